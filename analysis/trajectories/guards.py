"""Guards of a face of a smooth switched field, and paths that circle a corner without end.

Guards are positive as long as a path keeps to the face: these are the bounds of the face, and of a sliding mode the
normal speeds of its members (tangential exit), or the least weight of a mode that holds several surfaces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.convex_weights import WEIGHT_SLACK
from nonsmooth.analysis.fields.switched_field import Face, FacedField, Surface, length
from nonsmooth.analysis.trajectories.faces import (
    BECOMES_TANGENT,
    CLEAR_OF_TANGENCY,
    IS_TANGENT,
    LOOK_AHEAD,
    SMALLEST_SPEED,
    TANGENT_SLACK,
    FaceChoice,
    FaceMotion,
    largest,
    tangency,
)
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards, PolynomialInterpolant
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.numbers.plane import around
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm

# ---- paths that circle a corner ever faster and nearer without end -------------------------------
#
# Their mean motion, at the corner.
#
# Around a corner with velocities that do not vanish there a full turn from distance s takes a time proportional to s,
# and returns at ``gain s``.  With a gain below one the turns sum to a limit
# (:mod:`nonsmooth.analysis.trajectories.smooth_path`).  With a gain of one, as symmetric arrays have, distance only
# shrinks by what the velocities change within a turn, which is proportional to s too: so s falls exponentially, the
# corner is never reached, and the number of turns grows without bound.  What can be followed is the limit of ever
# smaller turns: the path at the corner, with each cell's share of time as its weight.  That is a Filippov motion at the
# corner, one of many there, and the one that the path approaches.


# Relative to the size of the states: turns within this are drawn as their corner; a pixel of a figure.
WHIRL_EXTENT = 5e-4
# Durations of one turn and the next: nearer to one, more than a hundred turns leave a seventh of the distance.
WHIRL_RATIO = 0.98
WHIRL_LOOP = 16  # longest turn that is recognized, in crossings: cells around a corner
GAIN_DOUBT = 1e-9  # a gain nearer to one than this is one: it is a product of quotients of speeds
SPEED_DOUBT = 1e-9  # relative to the fields: slower crossings are none


class SurfaceCrossing(NamedTuple):
    """A crossing of a surface at a time: out of one member's cell."""

    time: float
    x: Floats
    place: str
    surface: Surface


@dataclass(frozen=True)
class _Gate:
    """A surface of a turn, crossed in the sense of its normal times ``sense``, out of one member into another."""

    surface: Surface
    sense: int
    out_of: int
    into: int


class WhirlMotion(FaceMotion):
    """The mean motion of the turns around a corner.

    Args:
        face: the corner.
        turn: the crossings of one turn, in order.
        before: the one before them.
    """

    def __init__(self, face: Face, turn: Sequence[SurfaceCrossing], before: SurfaceCrossing) -> None:
        super().__init__(face)
        names = [member.name for member in face.members]
        times = [before.time, *(crossing.time for crossing in turn)]
        self.shares = np.zeros(len(names))
        for crossing, lasted in zip(turn, np.diff(times), strict=True):
            self.shares[names.index(crossing.place)] += lasted / (times[-1] - times[0])
        self.gates = []
        for crossing, following in around(turn):
            member = face.members[names.index(crossing.place)]
            speed = crossing.surface.normal(crossing.x) @ member.velocity(crossing.time, crossing.x)
            into = names.index(following.place)
            self.gates.append(_Gate(crossing.surface, 1 if speed > 0 else -1, names.index(crossing.place), into))

    def mix(self, fields: Floats, speeds: Floats) -> Floats:
        """The shares of time, changed by as little as keeps the corner."""
        system = np.vstack([speeds.T / (largest(fields) or 1.0), np.ones(len(fields))])
        wanted = np.append(np.zeros(speeds.shape[1]), 1.0)
        return self.shares - np.linalg.pinv(system) @ (system @ self.shares - wanted)

    def speeds_through(self, t: float, x: Floats) -> Floats:
        """Speeds (gates, 2) through every surface of the turn: before it and behind it, relative to the fields."""
        fields = self.fields(t, x)
        scale = largest(fields) or 1.0
        rows = [gate.sense / scale * (fields[[gate.out_of, gate.into]] @ gate.surface.normal(x)) for gate in self.gates]
        return np.array(rows)

    def lasts(self, t: float, x: Floats) -> float:
        """Positive while every surface is still crossed, and turns do not grow."""
        speeds = self.speeds_through(t, x)
        least = float(speeds.min()) - SPEED_DOUBT
        if least <= 0:
            return least
        return min(least, 1 + GAIN_DOUBT - float(np.prod(speeds[:, 1] / speeds[:, 0])))


def last_turn(crossings: Iterable[SurfaceCrossing], size: float) -> Sequence[SurfaceCrossing]:
    """The last turn with the crossing before it, if it is small and hardly smaller than the one before; else none."""
    known = list(crossings)
    if len(known) < 2 or largest(known[-1].x - known[-2].x) > WHIRL_EXTENT * size:
        return ()
    places = [crossing.place for crossing in known]
    for loop in range(2, WHIRL_LOOP + 1):
        if len(places) <= 2 * loop:
            break
        if places[-loop:] != places[-2 * loop : -loop]:
            continue
        first, second = (known[k].time - known[k - loop].time for k in (-1 - loop, -1))
        if not WHIRL_RATIO * first < second < first:
            return ()
        coordinates = zip(*(crossing.x.tolist() for crossing in known[-loop:]), strict=True)
        extent = max(max(values) - min(values) for values in coordinates)
        return known[-1 - loop :] if extent <= WHIRL_EXTENT * size else ()
    return ()


def turning_gain(corner: Face, faces: Sequence[Face], t: float, x: Floats) -> float:
    """By how much a turn around a corner of two surfaces grows; zero where solutions do not turn around it.

    In a cell with the distances a and b from the surfaces, ``a' < 0 < b'`` takes a distance s along one to
    ``-s b'/a'`` along the other; the gain is the product of these over the four cells.
    """
    cells = [face for face in faces if not face.keep]
    if len(corner.keep) != 2 or len(cells) != 4:
        return 0.0
    gain, senses = 1.0, set[int]()
    for cell in cells:
        velocity, sides = cell.members[0].velocity(t, x), dict(cell.bounds)
        first, second = (sides[surface] * float(surface.normal(x) @ velocity) for surface in corner.keep)
        if first * second >= 0:
            return 0.0
        gain *= -second / first if first < 0 else -first / second
        senses.add(sides[corner.keep[0]] * sides[corner.keep[1]] * (1 if first < 0 else -1))
    return gain if len(senses) == 1 else 0.0


def whirl_around(faces: Sequence[Face], turn: Sequence[SurfaceCrossing], time: float, x: Floats) -> WhirlMotion | None:
    """The mean motion about a corner with these faces, if a turn crosses all its cells there."""
    places = {crossing.place for crossing in turn[1:]}
    for face in faces:
        if len(face.keep) > 1 and places == {member.name for member in face.members}:
            motion = WhirlMotion(face, turn[1:], turn[0])
            return motion if motion.lasts(time, x) > 0 else None
    return None


# ---- guards --------------------------------------------------------------------------------------


# Relative to the size of the states (lengths) or of the fields (speeds): the integrator's error per step.
GUARD_SLACK = 1e-12


@dataclass(frozen=True)
class Guard:
    """Positive on the face; ``slope`` is its derivative along the motion, exact where that is cheap.

    Attributes:
        normal: its gradient, where that is the same everywhere.
    """

    value: Callable[[float, Floats], float]
    slack: float
    slope: Callable[[float, Floats, Floats], float]
    surface: Surface | None = None
    normal: Floats | None = None


class FaceGuards(Guards):
    """The guards of a choice, where a path begins to follow it, and further ones.

    Attributes:
        surfaces: the bound that each of them is; None for the others.
        first_further: the number of the first of the further ones.
    """

    def __init__(self, of_face: Sequence[Guard], further: Sequence[Guard] = ()) -> None:
        self._own = [*of_face, *further]
        self.first_further = len(of_face)
        self.slacks = [guard.slack for guard in self._own]
        self.surfaces = [guard.surface for guard in self._own]

    def at(self, t: float, x: Floats) -> Sequence[float]:
        """All values.

        Raises:
            TrajectoryError: where one is not a number.
        """
        values = [guard.value(t, x) for guard in self._own]
        if any(map(math.isnan, values)):
            raise TrajectoryError(f"required numbers, received none at t = {t:.6g}, {x.tolist()}")
        return values

    def one(self, k: int, t: float, x: Floats) -> float:
        """One value."""
        return self._own[k].value(t, x)

    def slope(self, k: int, t: float, x: Floats, rate: Floats) -> float:
        """The derivative of one along the motion."""
        guard = self._own[k]
        return guard.slope(t, x, rate) if guard.normal is None else float(guard.normal.dot(rate))

    def along(self, k: int, step: DenseStep) -> Callable[[float], float]:
        """One as a function of time; of a flat surface its distance from that where the step begins."""
        guard, between = self._own[k], step.between
        if guard.normal is None or not isinstance(between, PolynomialInterpolant):
            return super().along(k, step)
        return between.along(guard.normal.tolist(), guard.value(step.start, step.first))


def guards_of(field: FacedField, choice: FaceChoice, t: float, x: Floats) -> list[Guard]:
    """Bounds of the face, then normal speeds of its members or the least weight of its mode."""
    motion, face = choice.motion, choice.motion.face
    if isinstance(motion, WhirlMotion):
        return [Guard(motion.lasts, GUARD_SLACK, by_difference(motion.lasts, field.size))]
    guards = [_bound(surface, side, GUARD_SLACK * field.size, x) for surface, side in face.bounds]
    if motion.is_pair:
        guards.append(_tangent(field, motion))
    if motion.is_pair and motion.weights_open:
        return guards
    if choice.orders is not None:
        guards += _exits(field, choice, max_norm(motion.fields(t, x)))
    elif face.keep and len(face.members) > 1:
        guards.append(Guard(motion.least_weight, WEIGHT_SLACK, by_difference(motion.least_weight, field.size)))
    return guards


def _bound(surface: Surface, side: int, slack: float, x: Floats) -> Guard:
    def value(t: float, x: Floats) -> float:
        return side * surface.value(x)

    def slope(t: float, x: Floats, velocity: Floats) -> float:
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
            guards.append(Guard(value, slack * scale, by_difference(value, field.size)))
    return guards


def _exit(motion: FaceMotion, member: int, order: int) -> Callable[[float, Floats], float]:
    """A member's normal speed, with the sign it has inside the mode."""
    surface, velocity = motion.face.keep[0], motion.face.members[member].velocity
    return lambda t, x: order * float(surface.normal(x) @ velocity(t, x))


def _tangent(field: FacedField, motion: FaceMotion) -> Guard:
    """Whether the weights of a slide follow from its speeds, or still do not: where that changes, so does its law.

    A dip within a step needs no search: there the exits are met, at a state that is tangent too.
    """

    def value(t: float, x: Floats) -> float:
        fields = motion.fields(t, x)
        here = tangency(motion, t, x, field.size, fields, motion.normal_speeds(x, fields))
        return CLEAR_OF_TANGENCY - here if motion.weights_open else here - BECOMES_TANGENT

    return Guard(value, GUARD_SLACK, lambda t, x, velocity: 0.0)


def by_difference(value: Callable[[float, Floats], float], size: float) -> Callable[[float, Floats, Floats], float]:
    """The derivative of a guard along a motion, by a short step ahead."""

    def slope(t: float, x: Floats, velocity: Floats) -> float:
        ahead = LOOK_AHEAD * size / max(length(velocity), SMALLEST_SPEED)
        return (value(t + ahead, x + ahead * velocity) - value(t, x)) / ahead

    return slope
