"""The motion on a face of a smooth switched field: ``sum l_k f_k``, tangent to the surfaces held.

One surface between two fields fixes the weights l (Utkin's equivalent control); where they are not unique the motion
of least norm is taken.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from operator import mul

import numpy as np

from nonsmooth.analysis.fields.convex_weights import (
    basic_weights,
    central_weights,
    least_mix,
    least_norm_weights,
)
from nonsmooth.analysis.fields.float_code import Numbers
from nonsmooth.analysis.fields.switched_field import Face, ScalarVelocity, Vector, Velocity, unit_normal

# Relative to the fields around a point: normal speeds below are zero, since a state found on a surface is off by some
# 1e-12 of its size and gradients by difference err by 1e-11.
TANGENT_SLACK = 1e-9
# Relative to the size of the states: step along a motion for the derivative of a speed; its error is of this order.
LOOK_AHEAD = 1e-6
# Relative to the fields around a point per unit of size: derivatives below are zero (ten times the error above).
BEND_SLACK = 1e-5
SMALLEST_SPEED = 1e-300  # only to divide by: where nothing moves, any step will do


class FaceMotion:
    """The motion on a face: velocity and weights as functions of time and state.

    Args:
        face: the face.
        held: weights to keep, where both speeds of a slide pass zero
            (:mod:`nonsmooth.analysis.trajectories.two_fold`).
        open: whether both speeds of a slide are zero along it, so that they say nothing of the weights.
    """

    def __init__(self, face: Face, held: Vector | None = None, *, open: bool = False) -> None:
        self.face, self.held, self.open = face, held, open
        self._single = face.members[0].velocity if len(face.members) == 1 and not face.keep else None

    def __call__(self, t: float, x: Vector) -> Vector:
        """``sum l_k f_k``."""
        return self._single(t, x) if self._single is not None else self.mixed(x, self.fields(t, x))

    def mixed(self, x: Vector, fields: Vector) -> Vector:
        """The same from the fields of the members at a state."""
        if self._single is not None:
            return np.asarray(fields[0])
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
        if self.held is not None:
            return self.held
        if self.is_pair:
            first, second = speeds[0, 0], speeds[1, 0]
            known = not self.open and second != first
            share = second / (second - first) if known else least_mix(fields[0], fields[1])
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
        """The cheapest callable form: a single member's own field, and of a slide in single floats where both are."""
        own = [m.velocity.rates for m in self.face.members if isinstance(m.velocity, ScalarVelocity)]
        if self.is_pair and not self.weights_open and len(own) == 2:
            return ScalarVelocity(partial(self._slide, own))
        return self._single or self

    def _slide(self, members: Sequence[Callable[..., Numbers]], *x: float) -> Numbers:
        """The motion of a slide between two fields in single floats."""
        fields = [rates(*x) for rates in members]
        normal = self.face.keep[0].normal(np.array(x)).tolist()
        from_first, from_second = (sum(map(mul, normal, rates)) for rates in fields)
        if from_first == from_second:
            return tuple(self(0.0, np.array(x)).tolist())
        share = from_second / (from_second - from_first)
        return tuple(share * a + (1 - share) * b for a, b in zip(*fields, strict=True))

    @property
    def weights_open(self) -> bool:
        """Whether the weights of a slide do not follow from its speeds."""
        return self.open or self.held is not None

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

    def extremes(self, t: float, x: Vector, slack: float = TANGENT_SLACK) -> Vector:
        """Velocities whose hull are the possible motions; none where the mode is impossible.

        Speeds within the slack, relative to the fields, are zero.
        """
        fields = self.fields(t, x)
        if not self.face.keep:
            return fields
        speeds = self.normal_speeds(x, fields)
        cleaned = np.where(np.abs(speeds) > slack * largest(fields), speeds, 0.0)
        return np.asarray(basic_weights(cleaned) @ fields)


def largest(fields: Vector) -> float:
    """Largest entry in absolute value."""
    entries = fields.ravel().tolist()  # of few entries NumPy takes longer
    return math.nan if any(map(math.isnan, entries)) else max(map(abs, entries), default=0.0)
