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
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, FacedField, Vector, length, unit_normal
from nonsmooth.analysis.trajectories.face_motion import (
    BEND_SLACK,
    LOOK_AHEAD,
    SMALLEST_SPEED,
    TANGENT_SLACK,
    FaceMotion,
    largest,
)
from nonsmooth.analysis.trajectories.two_fold import IS_TANGENT, passing_weights, tangency

# Fall of the least weight within the step ahead that counts: its own error is the rounding error of the fields.
WEIGHT_CHANGE = 1e-12


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

    def __init__(self, field: FacedField, motion: FaceMotion, t: float, x: Vector) -> None:
        self.size, self.motion, self.t, self.x = field.size, motion, t, x
        self.fields = motion.fields(t, x)
        self.scale = largest(self.fields)
        self.slack = TANGENT_SLACK  # relative to that, of speeds

    @cached_property
    def velocity(self) -> Vector:
        """The motion's velocity."""
        return self.motion.mixed(self.x, self.fields)

    @cached_property
    def speeds(self) -> Vector:
        """Normal speeds of the members, (members, surfaces)."""
        return self.motion.normal_speeds(self.x, self.fields)

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
        return 0 if abs(speed) <= self.slack * self.scale else (1 if speed > 0 else -1)

    def bend(self, speed: float, later: float) -> int:
        """Sign of the derivative of a speed, zero within the slack."""
        change = (later - speed) / self.ahead
        return 0 if abs(change) <= BEND_SLACK * self.scale**2 / self.size else (1 if change > 0 else -1)

    def pair_orders(self) -> tuple[int, int]:
        """Signs of the two members' normal speeds just ahead."""
        now = self.speeds[:, 0]
        signs = [self.clear(float(speed)) for speed in now]
        if 0 in signs:
            later = self.motion.normal_speeds(self.later[1], self.fields_later)[:, 0]
            signs = [s or self.bend(float(a), float(b)) for s, a, b in zip(signs, now, later, strict=True)]
        return signs[0], signs[1]

    @property
    def only_rounding(self) -> bool:
        """Whether it is rounding alone that leaves the weights of a slide open."""
        return self.motion.weights_open and any(self.clear(float(speed)) for speed in self.speeds[:, 0])

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
            if abs(surface.value(self.x)) > SURFACE_SLACK * self.size * surface.steepness(self.x):
                continue
            speed = side * float(gradient @ self.velocity) / surface.steepness(self.x)
            order = self.clear(speed)
            if not order:
                normal = unit_normal(surface, self.later[1])
                order = self.bend(speed, side * float(normal @ self.motion(*self.later)))
            if order < 0:
                return -1
            verdict = min(verdict, order)
        return verdict


def face_choices(field: FacedField, faces: Sequence[Face], t: float, x: Vector) -> list[FaceChoice]:
    """Continuations at a state among the faces there, those that hold most surfaces first; sure ones where any is."""
    crossing = _crossing(faces, t, x)
    if crossing is not None:
        return [crossing]
    found: list[FaceChoice] = []
    trials = [trial for face in faces for trial in _trials(field, face, t, x)]
    if any(trial.motion.weights_open for trial in trials):
        for trial in trials:  # a speed that is small enough to leave weights open is zero for all of them
            trial.slack = IS_TANGENT * TANGENT_SLACK
    for trial in trials:
        motion, orders = trial.motion, None
        if motion.is_pair:
            orders = trial.pair_orders()
            if orders[0] * orders[1] > 0:
                continue
        elif motion.face.keep and not trial.exists():
            continue
        verdict = trial.inward()
        if verdict >= 0:
            found.append(_choice(field, trial, orders, sure=verdict > 0))
    return [choice for choice in found if choice.sure] or found


def _crossing(faces: Sequence[Face], t: float, x: Vector) -> FaceChoice | None:
    """The only choice where a state lies on one surface alone, between two fields that clearly cross it.

    None elsewhere.  By far the most switches are such, and none of the trials below finds anything else there.
    """
    if len(faces) != 3 or len(faces[0].keep) != 1 or len(faces[0].members) != 2:
        return None
    (surface,) = faces[0].keep
    normal = unit_normal(surface, x)
    fields = [member.velocity(t, x) for member in faces[0].members]
    speeds = [float(normal.dot(velocity)) for velocity in fields]
    nothing = TANGENT_SLACK * max(map(largest, fields))
    if not (min(speeds) > nothing or max(speeds) < -nothing):
        return None
    beyond = (surface, 1 if speeds[0] > 0 else -1)
    return next((FaceChoice(FaceMotion(face)) for face in faces[1:] if beyond in face.bounds), None)


def _trials(field: FacedField, face: Face, t: float, x: Vector) -> list[_Trial]:
    """The motion on a face; where both speeds of a slide vanish, those that keep to the surface."""
    trial = _Trial(field, FaceMotion(face), t, x)
    motion = trial.motion
    if not motion.is_pair or tangency(motion, t, x, field.size, trial.fields, trial.speeds) > IS_TANGENT:
        return [trial]
    weights = passing_weights(field, motion, t, x)
    kept = [FaceMotion(face, open=True)] if weights is None else [FaceMotion(face, held) for held in weights[:1]]
    return [_Trial(field, motion, t, x) for motion in kept]


def _choice(field: FacedField, trial: _Trial, orders: tuple[int, int] | None, *, sure: bool) -> FaceChoice:
    """The choice with the range of its motions."""
    face, motion = trial.motion.face, trial.motion
    if len(face.members) == 1:
        return FaceChoice(motion, sure=sure)
    extremes = motion.extremes(trial.t, trial.x, trial.slack)
    if not len(extremes):
        return FaceChoice(motion, orders=orders, sure=sure)
    free = bool(np.ptp(extremes, axis=0).max() > TANGENT_SLACK * trial.scale) and not trial.only_rounding
    rates = None
    if field.heading is not None and len(face.keep) > 1:
        drift = extremes[:, field.heading]
        rates = (float(drift.min()), float(drift.max()))
    return FaceChoice(motion, free, rates, orders, sure)
