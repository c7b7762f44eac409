"""The options of a study, stated once: a dataclass whose fields say how the command line and Python offer them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any, get_type_hints

from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES, MIXED

# what `fail` means for one array and for each of a sweep
FAIL = "Also with any one wheel failed: stopped (its friction stays) or lifted; the worst is named."


@dataclass(frozen=True)
class OfferedOption:
    """How an option is offered.

    Attributes:
        help: what it does, in a sentence.
        typed: what the command line reads, where that is another type than that of the field; an enumeration also
            reads the names of Python.
        flag: on the command line, by its name unless told, a short one before it; ``--no-...`` turns off what is on.
        heading: in the help; what the option belongs to.
        metavar: how its value is called.
        names: those that are accepted; None for any text.
        complete: what the shell offers for a text that was begun.
    """

    help: str
    typed: Any = None
    flag: str = ""
    heading: str = ""
    metavar: str | None = None
    names: Callable[[], Collection[str]] | None = None
    complete: Callable[[str], list[str]] | None = None


def option(default: Any, help: str, typed: Any = None, **offered: Any) -> Any:
    """A field of the options of a study, with the parts of an :class:`OfferedOption`."""
    return field(default=default, metadata={"option": OfferedOption(help, typed, **offered)})


@dataclass(frozen=True, kw_only=True)
class Options:
    """The options of a study: the fields that :func:`option` makes are offered."""

    def __post_init__(self) -> None:
        """Names of Python become members of their enumerations.

        Raises:
            ValueError: for a name that is none.
        """
        for name, typed in types_of(type(self)).items():
            if isinstance(typed, type) and issubclass(typed, Enum):
                object.__setattr__(self, name, typed(getattr(self, name)))


@dataclass(frozen=True, kw_only=True)
class SceneOptions(Options):
    """What the command line may change of a scene; Python has :meth:`nonsmooth.Array.with_`."""

    rule: str | None = option(None, "Contact rule; replaces the scene's.", names=lambda: (*CONTACT_RULES, MIXED))
    radius: str | None = option(
        None, "Half-width of the checked square, such as 1/2; replaces the scene's.", metavar="R"
    )
    at: str | None = option(None, "The point to check, such as 0,1/4; replaces the scene's.", metavar="X,Y")
    allow_outside: bool = option(False, "Read a table of wheels from outside the scene's folder too (wheels.file).")
    exact: bool = option(False, "Exact forms of numbers of a scene with units, not decimals (JSON has both).")


def options_of(options: type[Options]) -> dict[str, OfferedOption]:
    """How each option is offered, by the name of its field."""
    return {entry.name: entry.metadata["option"] for entry in fields(options) if "option" in entry.metadata}


def flag_of(name: str, own: OfferedOption) -> str:
    """How an option is called on the command line."""
    return own.flag.rpartition(" ")[2] or f"--{name.replace('_', '-')}"


def types_of(options: type[Options]) -> dict[str, Any]:
    """What the command line reads for each option."""
    hints = get_type_hints(options)
    return {name: own.typed or hints[name] for name, own in options_of(options).items()}
