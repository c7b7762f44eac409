"""What is refused: scenes and options that cannot be used, each in one line that is bad input and no fault."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter

from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.numbers.number import Number
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


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


# ---- numbers beyond floats -------------------------------------------------------------------------

LARGEST, LEAST = 1e150, 1e-150  # of numbers whose squares floats hold
RESOLUTION = 1e-9  # of the coordinates of the checked point: a smaller square is too far away for floats
DIGITS = 6


@contextmanager
def beyond_floats_named(loaded: Any) -> Iterator[bool]:
    """Arithmetic that fails on an array with a number far beyond floats is that number's doing, which is named.

    Such a number is no fault of itself: exact steps take it, and whole checks do where they need no others.  What NumPy
    warns of meanwhile, infinite floats and their differences, is said by this refusal or harms nothing.

    Args:
        loaded: a scene, one with its document or words, or a list of scenes; of other things nothing is named.

    Yields:
        Whether there is such a number.
    """
    refusals = list(filter(None, map(_beyond_floats, loaded if isinstance(loaded, list) else [loaded])))
    with catch_warnings():
        if refusals:
            simplefilter("ignore", RuntimeWarning)
        try:
            yield bool(refusals)
        except (SceneError, RefusedError):
            raise
        except (ArithmeticError, TypeError, ValueError) as error:
            if refusals:
                raise refusals[0] from error
            raise


def _beyond_floats(loaded: Any) -> SceneError | None:
    """What names the first number of an array that is beyond floats; None where there is none."""
    from nonsmooth.symbolic.messages.scene_kind import SceneKind
    from nonsmooth.symbolic.numbers.number_text import decimal_text

    scene = getattr(loaded, "scene", loaded)
    for key, value in _numbers_of(scene) if getattr(scene, "kind", None) is SceneKind.ARRAY else ():
        if value.sign() and not LEAST <= abs(float(value)) <= LARGEST:
            expected = f"0 or a size of {LEAST:g} to {LARGEST:g}: floats, which are needed here, fail beyond"
            return SceneError(scene.origin, key, expected, StatedFact(decimal_text(value, DIGITS)))
    return None


def _numbers_of(scene: Scene) -> Iterator[tuple[str, Number]]:
    """The keys of the numbers of an array, and these."""
    from nonsmooth.symbolic.mechanics.body import Disc
    from nonsmooth.symbolic.mechanics.scene import LoadTable

    for wheel in scene.wheels:
        key = f"wheel[{wheel.index:d}]"
        for name, value in (("mu_roll", wheel.friction.roll), ("mu_side", wheel.friction.side)):
            yield f"{key if name in wheel.named else 'friction'}.{name}", value
        yield from ((f"{key}.position", entry) for entry in wheel.position)
        yield f"{key}.speed", wheel.speed
        if wheel.speed_limit is not None:
            yield f"{key if 'speed_limit' in wheel.named else 'drive'}.speed_limit", wheel.speed_limit
    yield from (("check.equilibrium", entry) for entry in scene.check.equilibrium)
    yield "check.radius", scene.check.radius
    yield "check.length", scene.field(scene.check.length)
    if scene.check.accuracy is not None:
        yield "check.accuracy", scene.check.accuracy
    if isinstance(scene.contact.loads, LoadTable):
        yield from (("contact.loads", entry) for row in scene.contact.loads.rows for entry in row)
    if scene.body is not None:
        outline = scene.body.outline
        corners = ((outline.radius,),) if isinstance(outline, Disc) else outline.vertices
        yield from (("body", entry) for corner in corners for entry in corner)
    if scene.tolerances is not None:
        yield "tolerance.position", scene.tolerances.position
        yield "tolerance.centre_of_mass", scene.tolerances.centre_of_mass
    if scene.loop_errors is not None:
        yield "feedback.delay", scene.loop_errors.delay
        yield "feedback.position_error", scene.loop_errors.position


def require_resolved(scene: Scene) -> None:
    """Refuse squares so far away that floats, in the coordinates of the scene, do not tell places in them apart.

    Raises:
        SceneError: of such a square.
    """
    far, radius = max(map(abs, scene.check.place)), scene.check.radius
    if far * RESOLUTION > float(radius):
        from nonsmooth.symbolic.numbers.number_text import decimal_text

        expected = f"for paths, {RESOLUTION:g} of the coordinates of the point or more"
        raise SceneError(scene.origin, "check.radius", expected, StatedFact(decimal_text(radius, DIGITS)))
