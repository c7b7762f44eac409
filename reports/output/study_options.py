"""Options of commands: those of a study, fields of a dataclass, for the command line and Python, and shared ones."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, fields
from enum import Enum, StrEnum
from operator import index
from pathlib import Path
from typing import Annotated, Any, NamedTuple, get_type_hints

import typer

from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES, MIXED
from nonsmooth.symbolic.messages.scene_error import shown

# what `fail` means for one array and for each of a sweep
FAIL = "Also with any one wheel failed: stopped (its friction stays) or lifted; the worst is named."


class OfferedOption(NamedTuple):
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
        """Names of Python become members of their enumerations, and its numbers whole numbers and floats.

        Raises:
            ValueError: for a name that is none, and for what is no number; it begins with the keyword.
        """
        hints = get_type_hints(type(self))
        for name, option in options_of(type(self)).items():
            value = getattr(self, name)
            if not (isinstance(value, str) and option.typed is str):  # which is read later, as on the command line
                object.__setattr__(self, name, read_keyword(name, hints[name], value))


def read_keyword(keyword: str, kind: Any, value: Any) -> Any:
    """The value of a keyword of Python as its kind holds it: a member of an enumeration, a whole number, a float.

    What is of another kind, and None where that is allowed, stays as it is.

    Raises:
        ValueError: for a name that is none, and for what is no number.
    """
    read: Any
    if isinstance(kind, type) and issubclass(kind, Enum):
        read, required = kind, f"one of {', '.join(member.value for member in kind)}"
    elif kind is int or (kind == int | None and value is not None):
        read, required = index, "a whole number"
    elif kind is float or (kind == float | None and value is not None):
        read, required = float, "a number within the range of floats"
    else:
        return value
    try:
        return read(value)
    except (ArithmeticError, TypeError, ValueError):
        raise ValueError(f"{keyword}: required {required}, received {shown(value)}") from None


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


def flag_of(name: str, option: OfferedOption) -> str:
    """How an option is called on the command line."""
    return option.flag.rpartition(" ")[2] or f"--{name.replace('_', '-')}"


def types_of(options: type[Options]) -> dict[str, Any]:
    """What the command line reads for each option."""
    hints = get_type_hints(options)
    return {name: option.typed or hints[name] for name, option in options_of(options).items()}


# ---- arguments that commands share, and what the shell completes ---------------------------------


def complete_scene(incomplete: str) -> list[str]:
    """Built-in names and scene files that begin as typed, for the shell."""
    from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems

    folder = Path(incomplete).parent if "/" in incomplete else Path()
    files = [str(folder / path.name) for path in sorted(folder.glob("*.toml"))]
    return [name for name in (*builtin_scenes(), *builtin_systems(), *files) if name.startswith(incomplete)]


def complete_vehicle(incomplete: str) -> list[str]:
    """Built-in vehicles and scene files that begin as typed, for the shell."""
    from nonsmooth.symbolic.files.documents import builtin_vehicles

    files = [name for name in complete_scene(incomplete) if name.endswith(".toml")]
    return [*(name for name in builtin_vehicles() if name.startswith(incomplete)), *files]


def complete_study(incomplete: str) -> list[str]:
    """Names of studies, for the shell."""
    from nonsmooth.proofs.measurements import STUDIES, SYSTEM_STUDIES

    return [study.name for study in (*STUDIES, *SYSTEM_STUDIES) if study.name.startswith(incomplete)]


SceneText = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="A scene file (TOML) or a built-in name.", autocompletion=complete_scene),
]
SceneTexts = Annotated[
    list[str],
    typer.Argument(metavar="SCENE...", help="Scene files (TOML) or built-in names.", autocompletion=complete_scene),
]
VehicleText = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A scene file with [vehicle] or a built-in name.", autocompletion=complete_vehicle
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]


# ---- what a command line offers by name; light, so that ``--help`` loads no mathematics ----------


class LawName(StrEnum):
    """A feedback law of rule ``nearest``; ``certified`` stands for the one that the feedback clause certifies."""

    CERTIFIED = "certified"
    CORRECTED = "corrected"
    PRINTED = "printed"
    GRADIENT = "gradient"
    CASCADE = "cascade"


class PathMethod(StrEnum):
    """How the solution is followed."""

    EVENTS = "events"
    HYSTERESIS = "hysteresis"
    SMOOTHED = "smoothed"
    DYNAMICS = "dynamics"


class Drawing(StrEnum):
    """What a picture of an array shows."""

    CELLS = "cells"
    ARRAY = "array"
    RATES = "rates"


class RegionSearch(StrEnum):
    """How much is done for the region, beyond a level set of the V that decides.

    ``auto`` is ``fast`` for a plain system in two states and more, and ``none`` for everything else.
    """

    AUTO = "auto"
    NONE = "none"
    FAST = "fast"
    BEST = "best"
