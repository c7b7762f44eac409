"""A study: what is done with a scene, stated once for the command line and for Python.

A study has a dataclass of options.  Each field states its default, its help and its place in the help; the command's
options, the keywords of Python, their documentation and their refusals follow.  ``run`` takes a scene and the options
to a :class:`nonsmooth.reports.result.Result`, which the command shows and Python users hold.

To add an option of a study, write a field.  To add a command, write a study and make its command by
:func:`nonsmooth.reports.study_command.command`.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, fields
from enum import Enum, StrEnum
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from nonsmooth.reports.refusals import OptionError, RefusedError, in_keywords

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.result import Result
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem

Chosen = TypeVar("Chosen", bound="Options")
Method = TypeVar("Method", bound=Callable[..., Any])


class SceneKind(StrEnum):
    """What a study is of, in words."""

    ARRAY = "an array of wheels"
    SYSTEM = "a plain switched system"


@dataclass(frozen=True)
class OfferedOption:
    """How an option is offered.

    Attributes:
        help: what it does, in a sentence.
        typed: what the command line reads; an enumeration also reads the names of Python.
        flag: on the command line, by its name unless told.
        heading: in the help; what the option belongs to.
        metavar: how its value is called.
    """

    help: str
    typed: Any
    flag: str = ""
    heading: str = ""
    metavar: str | None = None


def option(  # the parts of an OfferedOption
    default: Any, help: str, typed: Any, *, flag: str = "", heading: str = "", metavar: str | None = None
) -> Any:
    """A field of the options of a study."""
    return field(default=default, metadata={"option": OfferedOption(help, typed, flag, heading, metavar)})


@dataclass(frozen=True, kw_only=True)
class Options:
    """The options of a study; each field is made by :func:`option`."""

    def __post_init__(self) -> None:
        """Names of Python become members of their enumerations.

        Raises:
            ValueError: for a name that is none.
        """
        for name, own in options_of(type(self)).items():
            if isinstance(own.typed, type) and issubclass(own.typed, Enum):
                object.__setattr__(self, name, own.typed(getattr(self, name)))


def options_of(options: type[Options]) -> dict[str, OfferedOption]:
    """How each option is offered, by the name of its field."""
    return {entry.name: entry.metadata["option"] for entry in fields(options)}


@dataclass(frozen=True)
class StudyRequest(Generic[Chosen]):
    """What somebody asks of a study.

    Attributes:
        options: with defaults for what was not given.
        given: names of the options that were, and of those of the scene (``rule``).
        kind: of the scene.
    """

    options: Chosen
    given: Collection[str]
    kind: SceneKind

    def refuse(self, names: Collection[str], required: str, received: str) -> None:
        """Refuse options that do nothing here.

        Raises:
            OptionError: for the first of these names that was given.
        """
        for name in self.given:
            if name in names:
                own = options_of(type(self.options)).get(name)
                flag = own.flag if own is not None and own.flag else f"--{name.replace('_', '-')}"
                raise OptionError(f"{flag}: required {required}, received {received}")


class SceneStudy(ABC, Generic[Chosen]):
    """Something that is done with a scene."""

    options: ClassVar[type[Any]]
    files: ClassVar[str]  # help of ``-o``

    @abstractmethod
    def endings(self, options: Chosen) -> Collection[str]:
        """What the file of a result may end in."""

    def refuse(self, asked: StudyRequest[Chosen], path: Path | None) -> None:
        """Refuse options, and a file, that do nothing here.

        Raises:
            RefusedError: naming the option and what it is for.
        """

    @abstractmethod
    def run(self, scene: Any, options: Chosen) -> Result:
        """Do it.

        Raises:
            RefusedError: where the scene or an option does not allow it.
        """

    def of(self, scene: Scene | SwitchedSystem, **given: Any) -> Any:
        """The result for a scene, by keywords of Python.

        Raises:
            ValueError: for keywords that cannot be used, named as such; or the error of the scene's own.
        """
        options = self.options(**given)
        try:
            self.refuse(StudyRequest(options, tuple(given), kind_of(scene)), None)
            return self.run(scene, options)
        except RefusedError as error:
            raise error.__cause__ or ValueError(in_keywords(str(error))) from None


def kind_of(scene: Scene | SwitchedSystem) -> SceneKind:
    """What a scene is."""
    from nonsmooth.symbolic.scene import Scene

    return SceneKind.ARRAY if isinstance(scene, Scene) else SceneKind.SYSTEM


# ---- Python --------------------------------------------------------------------------------------


def takes(options: type[Options], *headings: str) -> Callable[[Method], Method]:
    """A method of Python that takes the options of these headings, and those of none, as keywords.

    Its signature and its docstring list them; the method itself takes ``**options``.
    """

    def listed(method: Method) -> Method:
        own = inspect.signature(method)
        named = [parameter for parameter in own.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
        rest = [parameter for parameter in own.parameters.values() if parameter.kind is parameter.VAR_KEYWORD]
        taken = {parameter.name for parameter in named}
        lines = []
        for entry in fields(options):
            offered: OfferedOption = entry.metadata["option"]
            if entry.name in taken or offered.heading not in {"", *headings}:
                continue
            keyword = inspect.Parameter(entry.name, inspect.Parameter.KEYWORD_ONLY, default=entry.default)
            named.append(keyword)
            lines.append(f"            {entry.name}: {in_keywords(offered.help)}")
        method.__signature__ = own.replace(parameters=[*named, *rest])  # type: ignore[attr-defined]
        method.__doc__ = "\n".join([method.__doc__ or "", "        Keywords:", *lines])
        return method

    return listed
