"""Motions on a face of a smooth switched field, and which faces a path can continue on.

On a face that holds surfaces with unit normals g the motion is ``sum l_k f_k`` with ``l >= 0, sum l = 1`` and
``g . sum l_k f_k = 0``.  One surface between two fields fixes l (Utkin's equivalent control); where l is not unique the
motion of least norm is drawn and the solution is called non-unique.  A face is a continuation iff its motion stays on
it for small times; where a speed vanishes its derivative along the motion decides (Filippov 1988, sec. 10, 14 and 19;
Piiroinen & Kuznetsov 2008).  Beyond the derivative nothing is decided: a face that both leave in doubt is taken only
where no other is left, and the path is not called unique then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from nonsmooth.analysis.fields.convex_weights import (
    basic_weights,
    central_weights,
    least_mix,
    least_norm_weights,
)
from nonsmooth.analysis.fields.switched_field import (
    SURFACE_SLACK,
    Face,
    SwitchedField,
    Vector,
    Velocity,
    length,
    unit_normal,
)

# Relative to the fields around a point: normal speeds below are zero, since a state found on a surface is off by some
# 1e-12 of its size and gradients by difference err by 1e-11.
TANGENT_SLACK = 1e-9
# Relative to the size of the states: step along a motion for the derivative of a speed; its error is of this order.
LOOK_AHEAD = 1e-6
# Relative to the fields around a point per unit of size: derivatives below are zero (ten times the error above).
BEND_SLACK = 1e-5
# Fall of the least weight within the step above that counts: its own error is the rounding error of the fields.
WEIGHT_CHANGE = 1e-12
SMALLEST_SPEED = 1e-300  # only to divide by: where nothing moves, any step will do


class FaceMotion:
    """The motion on a face: velocity and weights as functions of time and state."""

    def __init__(self, face: Face) -> None:
        self.face = face
        self._single = face.members[0].velocity if len(face.members) == 1 and not face.keep else None

    def __call__(self, t: float, x: Vector) -> Vector:
        """``sum l_k f_k``."""
        if self._single is not None:
            return self._single(t, x)
        fields = self.fields(t, x)
        return np.asarray(self.mix(fields, self.normal_speeds(x, fields)) @ fields)

    def fields(self, t: float, x: Vector) -> Vector:
        """Fields of the members, one per row."""
        return np.array([member.velocity(t, x) for member in self.face.members], dtype=float)

    def normal_speeds(self, x: Vector, fields: Vector) -> Vector:
        """Speeds of the members along the unit normals held, (members, surfaces)."""
        normals = np.array([unit_normal(surface, x) for surface in self.face.keep])
        return np.asarray(fields @ normals.T)

    def mix(self, fields: Vector, speeds: Vector) -> Vector:
        """Weights of the members; outside the mode's region they are extrapolated: negative ones, still tangent."""
        if self.is_pair:
            first, second = speeds[0, 0], speeds[1, 0]
            if abs(first) + abs(second) > TANGENT_SLACK * largest(fields):
                share = second / (second - first) if second != first else 0.5
            else:
                share = least_mix(fields[0], fields[1])
            return np.array([share, 1 - share])
        possible = basic_weights(speeds)
        if len(possible):
            return np.asarray(least_norm_weights(possible @ fields) @ possible)
        weights = central_weights(speeds)
        return np.full(len(fields), 1.0 / len(fields)) if weights is None else weights

    def least_weight(self, t: float, x: Vector) -> float:
        """The least weight of the mode, as large as it can be: negative where the mode does not exist."""
        weights = central_weights(self.normal_speeds(x, self.fields(t, x)))
        return -1.0 if weights is None else float(weights.min())

    @property
    def velocity(self) -> Velocity:
        """The cheapest callable form: a single member's own field."""
        return self._single or self

    @property
    def is_pair(self) -> bool:
        """Whether it slides on one surface between two fields."""
        return len(self.face.members) == 2 and len(self.face.keep) == 1

    def weights(self, t: float, x: Vector) -> tuple[tuple[str, float], ...]:
        """Convex weights by member; none where a single field rules."""
        if len(self.face.members) == 1:
            return ()
        fields = self.fields(t, x)
        mix = self.mix(fields, self.normal_speeds(x, fields))
        return tuple((m.name, float(w)) for m, w in zip(self.face.members, mix, strict=True) if w)

    def extremes(self, t: float, x: Vector) -> Vector:
        """Velocities whose hull are the possible motions; none where the mode is impossible."""
        fields = self.fields(t, x)
        if not self.face.keep:
            return fields
        speeds = self.normal_speeds(x, fields)
        cleaned = np.where(np.abs(speeds) > TANGENT_SLACK * largest(fields), speeds, 0.0)
        return np.asarray(basic_weights(cleaned) @ fields)


@dataclass(frozen=True)
class FaceChoice:
    """A face to continue on.

    Attributes:
        motion: its motion.
        free: whether the motion is not the only one on the face.
        rates: interval of rates of the drifting state, where the field names one and only it moves.
        orders: signs of the two members' speeds just ahead, on one surface between two members.
        sure: whether the motion is known to stay on the face; where its second derivative vanishes too it may not.
    """

    motion: FaceMotion
    free: bool = False
    rates: tuple[float, float] | None = None
    orders: tuple[int, int] | None = None
    sure: bool = True


class _Trial:
    """A motion at a state, with what lies just ahead (evaluated only where a speed vanishes)."""

    def __init__(self, field: SwitchedField, motion: FaceMotion, t: float, x: Vector) -> None:
        self.size, self.motion, self.t, self.x = field.size, motion, t, x
        self.fields = motion.fields(t, x)
        self.scale = largest(self.fields)

    @cached_property
    def velocity(self) -> Vector:
        """The motion's velocity."""
        return self.motion(self.t, self.x)

    @cached_property
    def ahead(self) -> float:
        """Time in which the state moves by :data:`LOOK_AHEAD`."""
        return LOOK_AHEAD * self.size / max(length(self.velocity), self.scale, SMALLEST_SPEED)

    @cached_property
    def later(self) -> tuple[float, Vector]:
        """Time and state just ahead."""
        return self.t + self.ahead, self.x + self.ahead * self.velocity

    @cached_property
    def fields_later(self) -> Vector:
        """Fields of the members just ahead."""
        return self.motion.fields(*self.later)

    def clear(self, speed: float) -> int:
        """Sign of a speed, zero within the slack."""
        return 0 if abs(speed) <= TANGENT_SLACK * self.scale else (1 if speed > 0 else -1)

    def bend(self, speed: float, later: float) -> int:
        """Sign of the derivative of a speed, zero within the slack."""
        change = (later - speed) / self.ahead
        return 0 if abs(change) <= BEND_SLACK * self.scale**2 / self.size else (1 if change > 0 else -1)

    def pair_orders(self) -> tuple[int, int]:
        """Signs of the two members' normal speeds just ahead."""
        now = self.motion.normal_speeds(self.x, self.fields)[:, 0]
        signs = [self.clear(float(speed)) for speed in now]
        if 0 in signs:
            later = self.motion.normal_speeds(self.later[1], self.fields_later)[:, 0]
            signs = [s or self.bend(float(a), float(b)) for s, a, b in zip(signs, now, later, strict=True)]
        return signs[0], signs[1]

    def exists(self) -> bool:
        """Whether the surfaces held leave a motion here and just ahead: by its least weight, or where that is zero by
        whether it falls.
        """
        here = self.motion.least_weight(self.t, self.x)
        if abs(here) > TANGENT_SLACK:
            return here > 0
        return self.motion.least_weight(*self.later) - here >= -WEIGHT_CHANGE

    def inward(self) -> int:
        """Whether the motion keeps to the bounds that the state lies on: 1 yes, -1 no, 0 not decided."""
        verdict = 1
        for surface, side in self.motion.face.bounds:
            gradient = surface.gradient(self.x)
            if abs(surface.value(self.x)) > SURFACE_SLACK * self.size * length(gradient):
                continue
            speed = side * float(gradient @ self.velocity) / length(gradient)
            order = self.clear(speed)
            if not order:
                normal = unit_normal(surface, self.later[1])
                order = self.bend(speed, side * float(normal @ self.motion(*self.later)))
            if order < 0:
                return -1
            verdict = min(verdict, order)
        return verdict


def face_choices(field: SwitchedField, faces: Sequence[Face], t: float, x: Vector) -> list[FaceChoice]:
    """Continuations at a state among the faces there, those that hold most surfaces first; sure ones where any is."""
    found: list[FaceChoice] = []
    for face in faces:
        motion = FaceMotion(face)
        trial, orders = _Trial(field, motion, t, x), None
        if motion.is_pair:
            orders = trial.pair_orders()
            if orders[0] * orders[1] > 0:
                continue
        elif face.keep and not trial.exists():
            continue
        verdict = trial.inward()
        if verdict >= 0:
            found.append(replace(_choice(field, trial, orders), sure=verdict > 0))
    return [choice for choice in found if choice.sure] or found


def _choice(field: SwitchedField, trial: _Trial, orders: tuple[int, int] | None) -> FaceChoice:
    """The choice with the range of its motions."""
    face, motion = trial.motion.face, trial.motion
    if len(face.members) == 1:
        return FaceChoice(motion)
    extremes = motion.extremes(trial.t, trial.x)
    if not len(extremes):
        return FaceChoice(motion, orders=orders)
    free = bool(np.ptp(extremes, axis=0).max() > TANGENT_SLACK * trial.scale)
    rates = None
    if field.heading is not None and len(face.keep) > 1:
        drift = extremes[:, field.heading]
        rates = (float(drift.min()), float(drift.max()))
    return FaceChoice(motion, free, rates, orders)


def largest(fields: Vector) -> float:
    """Largest entry in absolute value."""
    return float(np.abs(fields).max(initial=0.0))
