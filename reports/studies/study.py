"""A study: what is done with a scene, stated once for the command line and for Python.

A study has a dataclass of options.  Each field states its default, its help and its place in the help; the command's
options, the keywords of Python, their documentation and their refusals follow.  ``run`` takes a scene and the options
to a :class:`nonsmooth.reports.studies.result.Result`, which the command shows and Python users hold.

To add an option of a study, write a field.  To add a command, write a study and its entry in
:mod:`nonsmooth.reports.commands.registry`.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from nonsmooth.reports.output.refusals import OptionError, RefusedError, in_keywords
from nonsmooth.reports.output.study_options import Options, SceneOptions, SceneText, flag_of, options_of
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.studies.result import Result

Chosen = TypeVar("Chosen", bound="Options")
Method = TypeVar("Method", bound=Callable[..., Any])


@dataclass(frozen=True)
class StudyRequest(Generic[Chosen]):
    """What somebody asks of a study.

    Attributes:
        options: with defaults for what was not given.
        given: names of the options that were, and of those of the scene (``rule``).
        scene: what it is asked of.
    """

    options: Chosen
    given: Collection[str]
    scene: Any

    @property
    def kind(self) -> SceneKind:
        """That of the scene."""
        kind: SceneKind = self.scene.kind
        return kind

    def refuse(self, names: Collection[str], required: str, received: str) -> None:
        """Refuse options that do nothing here.

        Raises:
            OptionError: for the first of these names that was given.
        """
        for name in self.given:
            if name in names:
                option = options_of(type(self.options)).get(name)
                flag = f"--{name.replace('_', '-')}" if option is None else flag_of(name, option)
                raise OptionError(f"{flag}: required {required}, received {received}")


class SceneStudy(ABC, Generic[Chosen]):
    """Something that is done with a scene."""

    argument: ClassVar[Any] = SceneText  # how the command offers what the study is about
    options: ClassVar[type[Any]]
    files: ClassVar[str] = ""  # help of ``-o``; without it no file is written
    changes: ClassVar[Sequence[str]] = tuple(options_of(SceneOptions))  # what may be changed of the scene

    def endings(self, options: Chosen) -> Collection[str]:
        """What the file of a result may end in."""
        from nonsmooth.reports.studies.result import FORMATS

        return FORMATS

    def load(self, scene: Any, options: Chosen, **changes: Any) -> Any:
        """The scene that a user names.

        Raises:
            SceneError: for whatever cannot be used.
        """
        from nonsmooth.symbolic.files.scene_file import load_any

        return load_any(scene, **changes)

    def settled(self, options: Chosen, path: Path | None) -> Chosen:
        """The options, where the file that is asked for says more."""
        return options

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

    def of(self, scene: Any, **given: Any) -> Any:
        """The result for a scene, by keywords of Python.

        Raises:
            ValueError: for keywords that cannot be used, named as such; or the error of the scene's own.
        """
        try:
            options = self.options(**given)
            self.refuse(StudyRequest(options, tuple(given), scene), None)
            return self.run(scene, options)
        except RefusedError as error:
            raise error.__cause__ or ValueError(in_keywords(str(error))) from None


# ---- Python --------------------------------------------------------------------------------------


def takes(options: type[Options], *headings: str) -> Callable[[Method], Method]:
    """A method of Python that takes the options of these headings, and those of none, as keywords.

    Its signature and its docstring list them; the method itself takes ``**options``.
    """

    def listed(method: Method) -> Method:
        signature = inspect.signature(method)
        named = [
            parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD
        ]
        rest = [parameter for parameter in signature.parameters.values() if parameter.kind is parameter.VAR_KEYWORD]
        taken = {parameter.name for parameter in named}
        lines = []
        for entry in fields(options):
            offered = options_of(options).get(entry.name)
            if offered is None or entry.name in taken or offered.heading not in {"", *headings}:
                continue
            keyword = inspect.Parameter(entry.name, inspect.Parameter.KEYWORD_ONLY, default=entry.default)
            named.append(keyword)
            lines.append(f"            {entry.name}: {in_keywords(offered.help)}")
        method.__signature__ = signature.replace(parameters=[*named, *rest])  # type: ignore[attr-defined]
        method.__doc__ = "\n".join([method.__doc__ or "", "        Keywords:", *lines])
        return method

    return listed
