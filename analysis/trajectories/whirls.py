"""Paths that circle a corner ever faster and nearer without end: their mean motion, at the corner.

Around a corner with velocities that do not vanish there a full turn from distance s takes a time proportional to s, and
returns at ``gain s``.  With a gain below one the turns sum to a limit
(:mod:`nonsmooth.analysis.trajectories.smooth_path`).  With a gain of one, as symmetric arrays have, distance only
shrinks by what the velocities change within a turn, which is proportional to s too: so s falls exponentially, the
corner is never reached, and the number of turns grows without bound.  What can be followed is the limit of ever
smaller turns: the path at the corner, with each cell's share of time as its weight.  That is a Filippov motion at the
corner, one of many there, and the one that the path approaches.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.fields.switched_field import Face, Surface, Vector, unit_normal
from nonsmooth.analysis.trajectories.face_motion import FaceMotion, largest
from nonsmooth.symbolic.numbers.plane import around

# Relative to the size of the states: turns within this are drawn as their corner; a pixel of a figure.
WHIRL_EXTENT = 5e-4
# Durations of one turn and the next: nearer to one, more than a hundred turns leave a seventh of the distance.
WHIRL_RATIO = 0.98
WHIRL_LOOP = 16  # longest turn that is recognized, in crossings: cells around a corner
GAIN_DOUBT = 1e-9  # a gain nearer to one than this is one: it is a product of quotients of speeds
SPEED_DOUBT = 1e-9  # relative to the fields: slower crossings are none


@dataclass(frozen=True)
class SurfaceCrossing:
    """A crossing of a surface at a time: out of one member's cell."""

    time: float
    x: Vector
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
            speed = unit_normal(crossing.surface, crossing.x) @ member.velocity(crossing.time, crossing.x)
            into = names.index(following.place)
            self.gates.append(_Gate(crossing.surface, 1 if speed > 0 else -1, names.index(crossing.place), into))

    def mix(self, fields: Vector, speeds: Vector) -> Vector:
        """The shares of time, changed by as little as keeps the corner."""
        system = np.vstack([speeds.T / (largest(fields) or 1.0), np.ones(len(fields))])
        wanted = np.append(np.zeros(speeds.shape[1]), 1.0)
        return np.asarray(self.shares - np.linalg.pinv(system) @ (system @ self.shares - wanted))

    def speeds_through(self, t: float, x: Vector) -> Vector:
        """Speeds (gates, 2) through every surface of the turn: before it and behind it, relative to the fields."""
        fields = self.fields(t, x)
        scale = largest(fields) or 1.0
        rows = [
            gate.sense / scale * (fields[[gate.out_of, gate.into]] @ unit_normal(gate.surface, x))
            for gate in self.gates
        ]
        return np.array(rows)

    def lasts(self, t: float, x: Vector) -> float:
        """Positive while every surface is still crossed, and turns do not grow."""
        speeds = self.speeds_through(t, x)
        least = float(speeds.min()) - SPEED_DOUBT
        if least <= 0:
            return least
        return min(least, 1 + GAIN_DOUBT - float(np.prod(speeds[:, 1] / speeds[:, 0])))


def last_turn(crossings: Iterable[SurfaceCrossing], size: float) -> Sequence[SurfaceCrossing]:
    """The last turn with the crossing before it, if it is small and hardly smaller than the one before; else none."""
    known = list(crossings)
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


def whirl_around(faces: Sequence[Face], turn: Sequence[SurfaceCrossing], time: float, x: Vector) -> WhirlMotion | None:
    """The mean motion about a corner with these faces, if a turn crosses all its cells there."""
    places = {crossing.place for crossing in turn[1:]}
    for face in faces:
        if len(face.keep) > 1 and places == {member.name for member in face.members}:
            motion = WhirlMotion(face, turn[1:], turn[0])
            return motion if motion.lasts(time, x) > 0 else None
    return None
