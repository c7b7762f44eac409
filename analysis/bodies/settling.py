"""How a body with inertia comes to rest: simulated from stated starts until it settles, swings on, or is thrown off.

A path under full dynamics is followed in chunks, each as long as the slowest motion near the place of rest takes to
fade, or a part of that.  It *settles* where a chunk stays within a small part of the accuracy, smaller where less of
that motion fades in a chunk; it is on a *limit cycle* where a chunk swings as far as the one before, and it is *thrown
off* where it comes to the border of its support.  From the path follow the time after which it stays within the
accuracy of where it ends, and its swings: how often it comes back to more than the accuracy after it was nearer.

The massless path serves the same body at slow speeds.  With all wheels s times as fast the same path is followed s
times faster by a body of mass ``s^2 m`` (:mod:`nonsmooth.analysis.bodies.newton_euler`), so factors of the speeds are
tried as masses.  All of this is computed in floats and proves nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.trajectories.result import BROKEN_OFF, UNFINISHED, EndReason
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import Pose
from nonsmooth.symbolic.numbers.plane_arrays import Floats, norms

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.mass_path import MassPath
    from nonsmooth.analysis.bodies.newton_euler import DynamicPath, RigidBody

# Tolerances beside those of a path that is shown; still larger ones take more steps where bodies are light.
COARSER = 1e3
STILL = 0.05  # of the accuracy: a chunk that stays within it has settled
STEADY = 0.02  # relative change of the size of swings from one half of a chunk to the other on a limit cycle
MOST_CHUNKS = 12
MOST_WORK = 6_000  # evaluations of all forces for one start: about a second; no chunk begins after these
LONGEST = 20_000  # of one chunk, which may hold very many short steps where wheels are slow or stick
LOOKS = 400  # at a path, beside another one
FACTORS = tuple(2.0**k for k in range(-4, 4))  # of the speeds of all wheels
LIGHT = 2.0**-6  # of these speeds: a body without inertia, but for a 4,096th


class Settling(StrEnum):
    """What becomes of a body."""

    AT_REST = "comes to rest"
    LIMIT_CYCLE = "limit cycle"
    THROWN_OFF = "thrown off"
    OPEN = "still moving"  # as far as it was followed


@dataclass(frozen=True)
class SettlingResult:
    """One start, and what becomes of it.

    Attributes:
        start: ``(x, y, theta)``, from rest.
        kind: what becomes of it.
        end: the pose when it was last seen; its place is the middle of the swings on a limit cycle.
        until: how long it was followed.
        settles_after: the time after which it stays within the accuracy of where it ends; None where it does not.
        swings: how often it came back to more than the accuracy; None where it does not settle.
        amplitude: of a limit cycle, the largest distance from its middle; None without one.
        work: evaluations of all forces.
    """

    start: Pose
    kind: Settling
    end: Pose
    until: float
    settles_after: float | None
    swings: int | None
    amplitude: float | None
    work: int


def settle(
    scene: Scene, body: RigidBody, start: Pose, accuracy: float, chunk: float, is_long: bool, faded: float = 1.0
) -> SettlingResult:
    """Follow one body from rest until it settles.

    Args:
        scene: the array, with the body's outline if it has one.
        body: mass and inertia.
        start: its pose.
        accuracy: see the module (length).
        chunk: of the time.
        is_long: whether what is slow near the place of rest fades or grows in a chunk; else swings of one size may be
            swings that fade too slowly to be told, and are not called a limit cycle.
        faded: how much of the slowest motion fades in a chunk, at most 1: so small a part of the way that is left is
            the way of a chunk.

    Raises:
        ValueError: for a start at which the body does not stand.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        TrajectoryError: where the path cannot be followed.
    """
    times, places, work = [np.zeros(1)], [np.array([start[:2]])], 0
    state, begin, kind, before = np.array([*start, 0.0, 0.0, 0.0]), 0.0, Settling.OPEN, math.inf
    follower = _follower(scene, body)
    swing = _Swing(np.zeros(2), 0.0, 0.0)
    for _ in range(MOST_CHUNKS):
        path = follower.follow(state[:3].tolist(), chunk, state[3:].tolist())
        work += path.evaluations
        times.append(begin + path.times[1:])
        places.append(path.states[1:, :2])
        begin, state = begin + float(path.times[-1]), path.states[-1]
        swing = _Swing.of(path)
        reason = path.trajectory.end.reason
        if reason in UNFINISHED:
            break
        if reason is not EndReason.TIME:
            kind = Settling.THROWN_OFF
        elif swing.later <= STILL * faded * accuracy:
            kind = Settling.AT_REST
        elif is_long and _is_steady(swing.later, swing.earlier) and _is_steady(swing.later, before):
            kind = Settling.LIMIT_CYCLE
        if kind is not Settling.OPEN or work > MOST_WORK:
            break
        before = swing.later
    ends_at = swing.middle if kind is Settling.LIMIT_CYCLE else state[:2]
    end = float(ends_at[0]), float(ends_at[1]), float(state[2])
    after, swings = None, None
    if kind is Settling.AT_REST:
        distances = norms(np.concatenate(places) - ends_at)
        after, swings = arrival(np.concatenate(times), distances, accuracy), swings_of(distances, accuracy)
    amplitude = swing.later if kind is Settling.LIMIT_CYCLE else None
    return SettlingResult(start, kind, end, begin, after, swings, amplitude, work)


def _is_steady(size: float, before: float) -> bool:
    return abs(size - before) <= STEADY * size


def _follower(scene: Scene, body: RigidBody) -> MassPath:
    """Under the friction forces of the scene's own rule, which has to be one without cells."""
    from nonsmooth.analysis.bodies.mass_path import MassPath  # words about an end need none
    from nonsmooth.analysis.bodies.supports import carried_contacts

    contacts, outlined = carried_contacts(smooth_rule_of(scene), scene)
    return MassPath(contacts, body, outlined, COARSER, LONGEST)


@dataclass(frozen=True, eq=False)
class _Swing:
    """How far the places of a chunk are from their middle.

    Attributes:
        middle: of its second half, (2,).
        earlier: the largest distance in its first half.
        later: in its second half.
    """

    middle: Floats
    earlier: float
    later: float

    @classmethod
    def of(cls, path: DynamicPath) -> _Swing:
        """Of the integrator's own steps, which are short beside a swing."""
        late = path.times >= path.times[-1] / 2
        places = path.states[:, :2]
        middle = (places[late].max(axis=0) + places[late].min(axis=0)) / 2
        distances = norms(places - middle)
        return cls(middle, float(distances[~late].max(initial=0.0)), float(distances[late].max()))


def arrival(times: Floats, distances: Floats, accuracy: float) -> float:
    """The last time at which a path (m,) is farther from its end than the accuracy, between its samples; 0 if never."""
    outside = np.flatnonzero(distances > accuracy)
    if not outside.size:
        return 0.0
    last = int(outside[-1])
    if last + 1 == len(distances):
        return float(times[last])
    far, near = distances[last], distances[last + 1]
    return float(times[last] + (times[last + 1] - times[last]) * (far - accuracy) / (far - near))


def swings_of(distances: Floats, accuracy: float) -> int:
    """How often a path (m,) comes back to more than the accuracy from its end after it was nearer.

    That counts the local maxima of its distance that are above the accuracy and above the minimum before by as much.
    """
    count, lowest, highest, rises = 0, float(distances[0]), 0.0, False
    for distance in distances.tolist():
        if rises:
            highest = max(highest, distance)
            if distance < highest - accuracy / 2:
                count, rises, lowest = count + 1, False, distance
        else:
            lowest = min(lowest, distance)
            if distance > max(accuracy, lowest + accuracy / 2):
                rises, highest = True, distance
    return count


# ---- without mass ------------------------------------------------------------------------------


def massless_holds_to(
    scene: Scene, body: RigidBody, starts: Sequence[Pose], accuracy: float, until: float
) -> float | None:
    """The largest factor of all speeds up to which bodies keep within the accuracy of their massless paths.

    These are the paths of a body that is :data:`LIGHT` times as fast, so nearly the paths of the rule itself.

    Args:
        scene: the array.
        body: mass and inertia.
        starts: from rest.
        accuracy: length.
        until: up to which time they are compared, at the given speeds.

    Returns:
        One of :data:`FACTORS` such that it and each lower one that was tried does; 0 where the lowest does not.  None
        where that takes long.

    Raises:
        TrajectoryError: where a path cannot be followed.
    """
    times, work = np.linspace(0.0, until, LOOKS), 0

    def places(factor: float, start: Pose) -> Floats | None:
        nonlocal work
        path = _follower(scene, body.times(factor**2)).follow(start, until)
        work += path.evaluations
        tips = path.trajectory.end.reason in BROKEN_OFF
        return None if tips else path.trajectory.sample(times)[:, :2]

    massless = [places(LIGHT, start) for start in starts]
    low, high = -1, len(FACTORS)  # bisection: distances grow with the mass
    while high - low > 1:
        if work > MOST_WORK:
            return None
        tried = (low + high) // 2
        are_alike = all(
            _are_alike(places(FACTORS[tried], start), near, accuracy)
            for start, near in zip(starts, massless, strict=True)
        )
        if work > LONGEST:  # a path is not finished
            return None
        if are_alike:
            low = tried
        else:
            high = tried
    return FACTORS[low] if low >= 0 else 0.0


def _are_alike(places: Floats | None, others: Floats | None, accuracy: float) -> bool:
    if places is None or others is None:
        return False
    return bool(norms(places - others).max() <= accuracy)
