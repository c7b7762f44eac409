"""What is refused: scenes and options that cannot be used, each in one line that is bad input and no fault."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from nonsmooth.symbolic.scene_error import SceneError

if TYPE_CHECKING:
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem


class RefusedError(Exception):
    """A scene that can be read but not checked; ``str(error)`` is one line."""


class UnwrittenError(RefusedError):
    """A file for which what was found does not serve; ``found`` is shown all the same, since it took the work."""

    def __init__(self, message: str, found: Any) -> None:
        super().__init__(message)
        self.found = found


class OptionError(RefusedError, ValueError):
    """An option that cannot be used: ``--gain: required a positive number, received -1.0``.

    Python users read its keyword: :func:`in_keywords`.
    """


def in_keywords(message: str) -> str:
    """A message about options with the keywords of Python in their places: ``--from`` is ``start``."""
    named = re.sub(r"--from\b", "start", message)
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)", lambda found: found[1].replace("-", "_"), named)


@contextmanager
def bad_input(scene: Scene | SwitchedSystem, *errors: type[Exception]) -> Iterator[None]:
    """Errors of these kinds are the scene's own, which their message then names; their cause is the error itself."""
    try:
        yield
    except (SceneError, RefusedError):
        raise
    except errors as error:
        raise RefusedError(f"{scene.origin}: {error}") from error


@contextmanager
def option_named(*errors: type[Exception]) -> Iterator[None]:
    """Errors of these kinds begin with a keyword, which is an option on the command line; their cause is itself."""
    try:
        yield
    except errors as error:
        raise RefusedError(f"--{error}") from error


@contextmanager
def refusals_named(scene: Scene | SwitchedSystem) -> Iterator[None]:
    """Name the scene in the refusal of a check."""
    from nonsmooth.analysis.cells.partition import RefusalError

    with bad_input(scene, RefusalError):
        yield
