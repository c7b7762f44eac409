"""Guards of a face of a smooth switched field: what is positive as long as a path keeps to it.

These are the bounds of the face, and of a sliding mode the normal speeds of its members (tangential exit), or the
least weight of a mode that holds several surfaces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.fields.convex_weights import WEIGHT_SLACK
from nonsmooth.analysis.fields.switched_field import FacedField, Surface, Vector, length, unit_normal
from nonsmooth.analysis.trajectories.face_motion import LOOK_AHEAD, SMALLEST_SPEED, TANGENT_SLACK, FaceMotion
from nonsmooth.analysis.trajectories.faces import FaceChoice
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.steppers import ScalarInterpolant
from nonsmooth.analysis.trajectories.two_fold import BECOMES_TANGENT, CLEAR_OF_TANGENCY, IS_TANGENT, tangency
from nonsmooth.analysis.trajectories.whirls import WhirlMotion

# Relative to the size of the states (lengths) or of the fields (speeds): the integrator's error per step.
GUARD_SLACK = 1e-12


@dataclass(frozen=True)
class Guard:
    """Positive on the face; ``slope`` is its derivative along the motion, exact where that is cheap.

    Attributes:
        normal: its gradient, where that is the same everywhere.
    """

    value: Callable[[float, Vector], float]
    slack: float
    slope: Callable[[float, Vector, Vector], float]
    surface: Surface | None = None
    normal: Vector | None = None


class FaceGuards(Guards):
    """The guards of a choice, where a path begins to follow it.

    Attributes:
        surfaces: the bound that each of them is; None for the others.
    """

    def __init__(self, field: FacedField, choice: FaceChoice, t: float, x: Vector) -> None:
        self._own = guards_of(field, choice, t, x)
        self.slacks = [guard.slack for guard in self._own]
        self.surfaces = [guard.surface for guard in self._own]

    def at(self, t: float, x: Vector) -> Sequence[float]:
        """All values.

        Raises:
            TrajectoryError: where one is not a number.
        """
        values = [guard.value(t, x) for guard in self._own]
        if any(map(math.isnan, values)):
            raise TrajectoryError(f"required numbers, received none at t = {t:.6g}, {x.tolist()}")
        return values

    def one(self, k: int, t: float, x: Vector) -> float:
        """One value."""
        return self._own[k].value(t, x)

    def slope(self, k: int, t: float, x: Vector, rate: Vector) -> float:
        """The derivative of one along the motion."""
        own = self._own[k]
        return own.slope(t, x, rate) if own.normal is None else float(own.normal.dot(rate))

    def along(self, k: int, step: DenseStep) -> Callable[[float], float]:
        """One as a function of time; of a flat surface its distance from that where the step begins."""
        own, between = self._own[k], step.between
        if own.normal is None or not isinstance(between, ScalarInterpolant):
            return super().along(k, step)
        return between.along(own.normal.tolist(), own.value(step.start, step.first))


def guards_of(field: FacedField, choice: FaceChoice, t: float, x: Vector) -> list[Guard]:
    """Bounds of the face, then normal speeds of its members or the least weight of its mode."""
    motion, face = choice.motion, choice.motion.face
    if isinstance(motion, WhirlMotion):
        return [Guard(motion.lasts, GUARD_SLACK, _difference(motion.lasts, field.size))]
    guards = [_bound(surface, side, GUARD_SLACK * field.size, x) for surface, side in face.bounds]
    if motion.is_pair:
        guards.append(_tangent(field, motion))
    if motion.is_pair and motion.weights_open:
        return guards
    if choice.orders is not None:
        guards += _exits(field, choice, float(np.abs(motion.fields(t, x)).max()))
    elif face.keep and len(face.members) > 1:
        guards.append(Guard(motion.least_weight, WEIGHT_SLACK, _difference(motion.least_weight, field.size)))
    return guards


def _bound(surface: Surface, side: int, slack: float, x: Vector) -> Guard:
    def value(t: float, x: Vector) -> float:
        return side * surface.value(x)

    def slope(t: float, x: Vector, velocity: Vector) -> float:
        return side * float(surface.gradient(x).dot(velocity))

    normal = side * surface.gradient(x) if surface.flat else None
    return Guard(value, slack * surface.steepness(x), slope, surface, normal)


def _exits(field: FacedField, choice: FaceChoice, scale: float) -> list[Guard]:
    """The members' normal speeds, with the signs they have inside the mode.

    One that nothing decides has the other's opposite, and turns clearly before that is told.
    """
    first, second = choice.orders or (0, 0)
    guards = []
    for member, (order, other) in enumerate(((first, second), (second, first))):
        if order or other:
            value = _exit(choice.motion, member, order or -other)
            slack = GUARD_SLACK if order else IS_TANGENT * TANGENT_SLACK
            guards.append(Guard(value, slack * scale, _difference(value, field.size)))
    return guards


def _exit(motion: FaceMotion, member: int, order: int) -> Callable[[float, Vector], float]:
    """A member's normal speed, with the sign it has inside the mode."""
    surface, velocity = motion.face.keep[0], motion.face.members[member].velocity
    return lambda t, x: order * float(unit_normal(surface, x) @ velocity(t, x))


def _tangent(field: FacedField, motion: FaceMotion) -> Guard:
    """Whether the weights of a slide follow from its speeds, or still do not: where that changes, so does its law.

    A dip within a step needs no search: there the exits are met, at a state that is tangent too.
    """

    def value(t: float, x: Vector) -> float:
        fields = motion.fields(t, x)
        here = tangency(motion, t, x, field.size, fields, motion.normal_speeds(x, fields))
        return CLEAR_OF_TANGENCY - here if motion.weights_open else here - BECOMES_TANGENT

    return Guard(value, GUARD_SLACK, lambda t, x, velocity: 0.0)


def _difference(value: Callable[[float, Vector], float], size: float) -> Callable[[float, Vector, Vector], float]:
    """The derivative of a guard along a motion, by a short step ahead."""

    def slope(t: float, x: Vector, velocity: Vector) -> float:
        ahead = LOOK_AHEAD * size / max(length(velocity), SMALLEST_SPEED)
        return (value(t + ahead, x + ahead * velocity) - value(t, x)) / ahead

    return slope
