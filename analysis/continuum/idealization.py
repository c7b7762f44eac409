"""Which field and which objects a scene stands for, and when it stands for none."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.continuum.prediction import Prediction, predict
from nonsmooth.analysis.continuum.settling import directions
from nonsmooth.symbolic.continuum import ContinuousField, Disc, Footprint
from nonsmooth.symbolic.files.body_table import rectangle
from nonsmooth.symbolic.files.velocity_fields import LINEAR_KINDS
from nonsmooth.symbolic.scene import Scene

DIGITS = 3  # of the radius of the disc that covers the wheels, rounded up
STEEPEST = 1e6  # ratio of the largest to the smallest pull of a field of constant size: below, closed forms keep digits
LARGEST = 1e60  # lengths whose fourth powers floats hold


class NoIdealizationError(ValueError):
    """A scene that no continuous field stands for; ``str(error)`` says what was required."""


def idealization(scene: Scene) -> ContinuousField:
    """The field that a scene's wheels sample.

    Raises:
        NoIdealizationError: for a field of another kind, and for wheels that do not follow it.
    """
    field = scene.continuum
    if field is None or field.matrix is None:
        kinds = f"{', '.join(LINEAR_KINDS[:-1])} or {LINEAR_KINDS[-1]}"
        found = "none" if field is None else field.kind
        raise NoIdealizationError(f"field.kind: required {kinds} for a continuous field, received {found}")
    (a, b), (c, d) = field.matrix
    if not a * d - b * c or not (field.speed is None or field.speed):
        raise NoIdealizationError("field: required a field that vanishes at its centre only, received another")
    if field.speed is not None and np.linalg.cond(directions(field)) > STEEPEST:
        raise NoIdealizationError(f"field: required pulls in a ratio of at most {STEEPEST:g}, received a larger one")
    strange = next((wheel.index for wheel in scene.wheels if not field.is_followed_by(wheel)), None)
    if strange is not None:
        raise NoIdealizationError(
            f"wheel[{strange}]: required wheels that all follow one {field.kind} field for a continuous field, "
            "received another heading or speed"
        )
    return field


def footprints(scene: Scene) -> tuple[Footprint, ...]:
    """The scene's body, or else a rectangle and a disc that just cover the wheels, at rest at the checked point.

    Raises:
        NoIdealizationError: for lengths beyond the range of floats.
    """
    if scene.body is not None and not scene.body.is_balanced:
        raise NoIdealizationError("body.centre_of_mass: required the centroid for a continuous field, received another")
    if scene.continuum is not None and scene.continuum.footprint is not None:
        return (scene.continuum.footprint,)
    x, y = scene.check.equilibrium
    away = [(abs(wheel.position[0] - x), abs(wheel.position[1] - y)) for wheel in scene.wheels]
    width, height = (max(pair[k] for pair in away) for k in (0, 1))
    reach = max(math.hypot(float(a), float(b)) for a, b in away)
    _require_float(reach)
    disc = Disc(scene.field.rational(_rounded_up(reach)))
    return (rectangle(width, height), disc) if width and height else (disc,)


def predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization of a scene, for each of its objects.

    Raises:
        NoIdealizationError: as above.
    """
    field, found = idealization(scene), footprints(scene)
    for footprint in found:
        lengths = [footprint.radius] if isinstance(footprint, Disc) else [x for v in footprint.vertices for x in v]
        _require_float(max(abs(float(length)) for length in lengths))
    return tuple(predict(field, footprint) for footprint in found)


def _require_float(length: float) -> None:
    if not 1 / LARGEST <= length <= LARGEST:
        raise NoIdealizationError(f"body: required a length from {1 / LARGEST:g} to {LARGEST:g}, received {length:g}")


def _rounded_up(value: float) -> Fraction:
    unit = Fraction(10) ** (math.floor(math.log10(value)) + 1 - DIGITS)
    return math.ceil(Fraction(value) / unit) * unit
