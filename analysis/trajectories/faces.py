"""Motions on a face of a smooth switched field, and which faces a path can continue on.

On a face that holds surfaces with unit normals g the motion is ``sum l_k f_k`` with ``l >= 0, sum l = 1`` and
``g . sum l_k f_k = 0``.  One surface between two fields fixes l (Utkin's equivalent control); where l is not unique the
motion of least norm is drawn and the solution is called non-unique.  A face is a continuation iff its motion stays on
it for small times; where a speed vanishes its derivative along the motion decides (Filippov 1988, sec. 10, 14 and 19;
Piiroinen & Kuznetsov 2008).  Beyond the derivative nothing is decided: a face that both leave in doubt is taken only
where no other is left, and the path is not called unique then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from itertools import combinations_with_replacement
from operator import mul
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.convex_weights import central_weights, extreme_mixtures, least_mix, shortest_mixture
from nonsmooth.analysis.fields.float_code import Numbers
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, FacedField, ScalarVelocity, Velocity, length
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, spread

# ---- the motion on a face of a smooth switched field ---------------------------------------------
#
# ``sum l_k f_k``, tangent to the surfaces held.
#
# One surface between two fields fixes the weights l (Utkin's equivalent control); where they are not unique the motion
# of least norm is taken.


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
        held: weights to keep, where both speeds of a slide pass zero.
        open: whether both speeds of a slide are zero along it, so that they say nothing of the weights.
    """

    def __init__(self, face: Face, held: Floats | None = None, *, open: bool = False) -> None:
        self.face, self.held, self.open = face, held, open
        self._single = face.members[0].velocity if len(face.members) == 1 and not face.keep else None

    def __call__(self, t: float, x: Floats) -> Floats:
        """``sum l_k f_k``."""
        return self._single(t, x) if self._single is not None else self.mixed(x, self.fields(t, x))

    def mixed(self, x: Floats, fields: Floats) -> Floats:
        """The same from the fields of the members at a state."""
        if self._single is not None:
            return np.asarray(fields[0])
        return self.mix(fields, self.normal_speeds(x, fields)) @ fields

    def fields(self, t: float, x: Floats) -> Floats:
        """Fields of the members, one per row."""
        return np.array([member.velocity(t, x) for member in self.face.members], dtype=float)

    def normal_speeds(self, x: Floats, fields: Floats) -> Floats:
        """Speeds of the members along the unit normals held, (members, surfaces)."""
        normals = np.array([surface.normal(x) for surface in self.face.keep])
        return fields @ normals.T

    def mix(self, fields: Floats, speeds: Floats) -> Floats:
        """Weights of the members; outside the mode's region they are extrapolated: negative ones, still tangent."""
        if self.held is not None:
            return self.held
        if self.is_pair:
            first, second = speeds[0, 0], speeds[1, 0]
            known = not self.open and second != first
            share = second / (second - first) if known else least_mix(fields[0], fields[1])
            return np.array([share, 1 - share])
        weights = shortest_mixture(speeds, fields)
        if weights is None:
            weights = central_weights(speeds)
        return np.full(len(fields), 1.0 / len(fields)) if weights is None else weights

    def least_weight(self, t: float, x: Floats) -> float:
        """The least weight of the mode, as large as it can be: negative where the mode does not exist."""
        weights = central_weights(self.normal_speeds(x, self.fields(t, x)))
        return -1.0 if weights is None else float(weights.min())

    @property
    def velocity(self) -> Velocity:
        """The cheapest callable form: a single member's own field, and of a slide in single floats where both are."""
        rates = [m.velocity.rates for m in self.face.members if isinstance(m.velocity, ScalarVelocity)]
        if self.is_pair and not self.weights_open and len(rates) == 2:
            return ScalarVelocity(partial(self._slide, rates))
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

    def weights(self, t: float, x: Floats) -> tuple[tuple[str, float], ...]:
        """Convex weights by member; none where a single field rules."""
        if len(self.face.members) == 1:
            return ()
        fields = self.fields(t, x)
        mix = self.mix(fields, self.normal_speeds(x, fields))
        return tuple((m.name, float(w)) for m, w in zip(self.face.members, mix, strict=True) if w)

    def extremes(self, t: float, x: Floats, slack: float = TANGENT_SLACK) -> Floats:
        """Possible motions with the least and largest value of each coordinate; none where the mode is impossible.

        Speeds within the slack, relative to the fields, are zero.
        """
        fields = self.fields(t, x)
        if not self.face.keep:
            return fields
        speeds = self.normal_speeds(x, fields)
        cleaned = np.where(np.abs(speeds) > slack * largest(fields), speeds, 0.0)
        return extreme_mixtures(cleaned, fields)


def largest(fields: Floats) -> float:
    """Largest entry in absolute value."""
    entries = fields.ravel().tolist()  # of few entries NumPy takes longer
    return math.nan if any(map(math.isnan, entries)) else max(map(abs, entries), default=0.0)


# ---- where both normal speeds of a slide vanish at once ------------------------------------------
#
# A two-fold, so that they leave its weights open.
#
# A solution that keeps to the surface there has speeds ``N_k = D_k t``, and weights that make them cancel: ``l_1 D_1 +
# l_2 D_2 = 0`` with ``D_k = l_1 D_k1 + l_2 D_k2``, the derivative of N_k along its own velocity (D_kj: along the field
# of member j).  That is one quadratic equation.  A slide usually passes from attracting to repelling in such a point,
# in finite time and along with all its neighbours.  (Filippov 1988, sec. 19; Jeffrey & Colombo 2009, "The two-fold
# singularity of discontinuous vector fields".)
#
# The limit of the equivalent control is the same root, but no number to compute with: a quotient of rounding errors.


# Relative to the size of the states, off the surface: a thousand times what rounding leaves of a state. A speed within
# its effect is known to three digits at most, and so are the weights; an integrator takes tiny steps over such noise.
OFF_SURFACE = 1e-13
# Of the distance to the end of an edge: the part over which derivatives are taken there.
NEAR_END = 1e-3
# In units of the speeds that count as zero. A slide ends where both speeds fall to one, where two is tangent already,
# so that the end is found tangent whatever its rounding; one whose weights were open goes on as such to a hundred: far
# enough not to turn to and fro between both, and passed within some 1e-7 of the size.
BECOMES_TANGENT, IS_TANGENT, CLEAR_OF_TANGENCY = 1.0, 2.0, 100.0
FASTEST = 1e150
WEIGHT_DOUBT = 1e-6  # outside 0 ... 1: weights are roots of differences, which err by LOOK_AHEAD


def tangency(motion: FaceMotion, t: float, x: Floats, size: float, fields: Floats, speeds: Floats) -> float:
    """How far the normal speeds of a slide are from vanishing both, in units of what counts as zero.

    Args:
        motion: the slide.
        t: a time.
        x: a state on its surface.
        size: of the states.
        fields: of the two members there, one per row.
        speeds: their normal speeds, (2, 1).
    """
    nothing = max(TANGENT_SLACK * largest(fields), _doubt(motion, t, x, size, fields))
    return float(np.abs(speeds).sum()) / nothing if nothing else 0.0


def passing_weights(field: FacedField, motion: FaceMotion, t: float, x: Floats) -> Floats | None:
    """Weights (m, 2) of the motions that keep to the surface through a two-fold, the shortest velocity first.

    None where the speeds vanish to first order too, so that any weights will do.

    Raises:
        TrajectoryError: for speeds beyond 1e150.
    """
    fields = motion.fields(t, x)
    scale = largest(fields)
    if scale > FASTEST:
        raise TrajectoryError("required speeds of which floats hold the squares")
    changes = _changes(field, motion, t, x) if any(map(length, fields)) else np.zeros((2, 2))
    if largest(changes) * field.size <= BEND_SLACK * scale**2:
        return None
    (d11, d12), (d21, d22) = changes
    roots = np.roots([d11 - d12 - d21 + d22, d12 + d21 - 2 * d22, d22])
    real = roots[np.abs(roots.imag) <= WEIGHT_DOUBT].real
    shares = np.clip(real[(real >= -WEIGHT_DOUBT) & (real <= 1 + WEIGHT_DOUBT)], 0.0, 1.0)
    weights = np.column_stack([shares, 1 - shares])
    return weights[np.argsort([length(row @ fields) for row in weights])]


def _changes(field: FacedField, motion: FaceMotion, t: float, x: Floats) -> Floats:
    """``D_kj``: derivative of the normal speed of member k along the field of member j."""
    fields = motion.fields(t, x)
    here = motion.normal_speeds(x, fields)[:, 0]
    ahead = _reach(field, motion, x) / max(length(f) for f in fields)
    columns = []
    for velocity in fields:
        later = x + ahead * velocity
        speeds = motion.normal_speeds(later, motion.fields(t + ahead, later))[:, 0]
        columns.append((speeds - here) / ahead)
    return np.column_stack(columns)


def _reach(field: FacedField, motion: FaceMotion, x: Floats) -> float:
    """Length over which derivatives are taken: short of the bounds that the state does not lie on."""
    reach = LOOK_AHEAD * field.size
    for surface, _ in motion.face.bounds:
        away = abs(surface.value(x)) / length(surface.gradient(x))
        if away > SURFACE_SLACK * field.size:
            reach = min(reach, NEAR_END * away)
    return reach


def _doubt(motion: FaceMotion, t: float, x: Floats, size: float, fields: Floats) -> float:
    """What rounding of the state may change the normal speeds of a slide by; ``fields`` are those at the state.

    On a domain so small that no float tells how far to look it is infinite.
    """
    normal = motion.face.keep[0].normal(x)
    move = LOOK_AHEAD * size
    if not move:
        return math.inf
    change = motion.fields(t, x + move * normal) - fields
    return OFF_SURFACE * max(size, largest(x)) * largest(change) / move


# ---- which face follows --------------------------------------------------------------------------


# Fall of the least weight within the step ahead that counts: its own error is the rounding error of the fields.
WEIGHT_CHANGE = 1e-12


class FaceChoice(NamedTuple):
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

    def __init__(self, field: FacedField, motion: FaceMotion, t: float, x: Floats) -> None:
        self.size, self.motion, self.t, self.x = field.size, motion, t, x
        self.fields = motion.fields(t, x)
        self.scale = largest(self.fields)
        self.slack = TANGENT_SLACK  # relative to that, of speeds

    @cached_property
    def velocity(self) -> Floats:
        """The motion's velocity."""
        return self.motion.mixed(self.x, self.fields)

    @cached_property
    def speeds(self) -> Floats:
        """Normal speeds of the members, (members, surfaces)."""
        return self.motion.normal_speeds(self.x, self.fields)

    @cached_property
    def ahead(self) -> float:
        """Time in which the state moves by :data:`LOOK_AHEAD`."""
        return LOOK_AHEAD * self.size / max(length(self.velocity), self.scale, SMALLEST_SPEED)

    @cached_property
    def later(self) -> tuple[float, Floats]:
        """Time and state just ahead."""
        return self.t + self.ahead, self.x + self.ahead * self.velocity

    @cached_property
    def fields_later(self) -> Floats:
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

    def others_exist(self, extremes: Floats) -> bool:
        """Whether a motion with another velocity leaves one on the surfaces held just ahead, too.

        Looked at are those of some extreme velocities, and halfway to and between them.
        """
        ends = [self.velocity, *extremes]
        for first, second in combinations_with_replacement(ends, 2):
            velocity = (first + second) / 2
            if largest(velocity - self.velocity) > TANGENT_SLACK * self.scale:
                later = self.t + self.ahead, self.x + self.ahead * velocity
                if self.motion.least_weight(*later) >= -WEIGHT_DOUBT:
                    return True
        return False

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
                normal = surface.normal(self.later[1])
                order = self.bend(speed, side * float(normal @ self.motion(*self.later)))
            if order < 0:
                return -1
            verdict = min(verdict, order)
        return verdict


def face_choices(field: FacedField, faces: Sequence[Face], t: float, x: Floats) -> list[FaceChoice]:
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


def _crossing(faces: Sequence[Face], t: float, x: Floats) -> FaceChoice | None:
    """The only choice where a state lies on one surface alone, between two fields that clearly cross it.

    None elsewhere.  By far the most switches are such, and none of the trials below finds anything else there.
    """
    if len(faces) != 3 or len(faces[0].keep) != 1 or len(faces[0].members) != 2:
        return None
    (surface,) = faces[0].keep
    normal = surface.normal(x)
    fields = [member.velocity(t, x) for member in faces[0].members]
    speeds = [float(normal.dot(velocity)) for velocity in fields]
    nothing = TANGENT_SLACK * max(map(length, fields))
    if not (min(speeds) > nothing or max(speeds) < -nothing):
        return None
    beyond = (surface, 1 if speeds[0] > 0 else -1)
    return next((FaceChoice(FaceMotion(face)) for face in faces[1:] if beyond in face.bounds), None)


def _trials(field: FacedField, face: Face, t: float, x: Floats) -> list[_Trial]:
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
    free = bool(spread(extremes) > TANGENT_SLACK * trial.scale) and not trial.only_rounding
    if free and len(face.keep) > 1:
        free = trial.others_exist(extremes)
    rates = None
    if field.heading is not None and len(face.keep) > 1:
        drift = extremes[:, field.heading]
        rates = (float(drift.min()), float(drift.max()))
    return FaceChoice(motion, free, rates, orders, sure)
