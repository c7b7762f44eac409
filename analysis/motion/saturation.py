"""Feedback laws whose wheels have largest speeds: all inputs of a cell are scaled by one common factor.

``sigma = min(1, min_w limit_w/|u_w|)`` over the wheels that act, and the law gives ``sigma u`` instead of u.
Under rule ``nearest`` the twist is linear in the inputs, ``xi = sum_w g_w u_w``, and nothing moves the body without
them; so the velocity of each cell is multiplied by ``sigma > 0`` and keeps its direction.  On an edge or at a corner
the scaled velocities span the same cone as the others, hence every Filippov solution of the limited loop runs along one
of the unlimited loop, more slowly, and the other way round: the same V falls along it, the same sets are not left, the
same edges are slid along.  (Scaling only the inputs that are too large would turn the velocity.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from nonsmooth.analysis.fields.constant_field import Pose, Speeds, StateLaw
from nonsmooth.analysis.trajectories.follow import find_root
from nonsmooth.analysis.trajectories.result import Event, EventKind, Piece, State, Trajectory
from nonsmooth.symbolic.mechanics.contact_states import ContactState


def demand(speeds: Mapping[int, float], limits: Mapping[int, float]) -> float:
    """``max_w |u_w|/limit_w``: above one where an input would exceed its limit; 0 where no wheel has one."""
    return max((abs(speed) / limits[wheel] for wheel, speed in speeds.items() if wheel in limits), default=0.0)


def limited_law(law: StateLaw, limits: Mapping[int, float]) -> StateLaw:
    """A law with all inputs of a cell scaled by one factor where one of them would exceed its limit.

    Args:
        law: any law.
        limits: the largest ``|u_w|`` by the number of the wheel (length/time); wheels without one are not limited.
    """
    if not limits:
        return law

    def prepare(state: ContactState) -> Speeds:
        wanted = law(state)

        def speeds(pose: Pose) -> Mapping[int, float]:
            given = wanted(pose)
            size = demand(given, limits)
            if size <= 1:
                return given
            return {wheel: _within(speed / size, limits.get(wheel)) for wheel, speed in given.items()}

        return speeds

    return prepare


def _within(speed: float, limit: float | None) -> float:
    """A scaled speed, without the rounding by which it may pass its limit."""
    return speed if limit is None or abs(speed) <= limit else math.copysign(limit, speed)


# ---- events of the limits ------------------------------------------------------------------------
#
# Where the law of a cell asks for more than a wheel can do, its inputs are scaled; the velocity of the cell has a kink
# there and no jump, so the integrator passes it by itself, with small steps.  Afterwards the times are found along the
# path: the demand ``max_w |u_w|/limit_w`` passes one.  It is looked at twice in every step of the integrator and at
# every switch, so what begins and ends within half a step is not seen.  While the body slides along an edge a wheel
# counts as limited where it is so in one of the cells beside.


SAME_SHARE = 1 - 1e-12  # of the largest demand: wheels this near to it reach their limits together, but for rounding

Demand = Callable[[float], float]


def with_saturation(path: Trajectory, wanted: Mapping[str, Speeds], limits: Mapping[int, float]) -> Trajectory:
    """The path with an event wherever a wheel reaches its limit, and where none is at its limit any more.

    Args:
        path: of the limited loop.
        wanted: what the law asks for, from the pose, by the name of the cell.
        limits: by the number of the wheel.
    """
    if not limits:
        return path
    found: list[Event] = []
    is_limited = False
    for piece in path.pieces:
        speeds = [wanted[name] for name in piece.cells if name in wanted]
        for event in _changes(piece, speeds, limits, is_limited=is_limited):
            found.append(event)
            is_limited = not is_limited
    events = sorted([*path.events, *found], key=lambda event: float(event.t))
    return replace(path, events=tuple(events))


def _changes(piece: Piece, speeds: list[Speeds], limits: Mapping[int, float], *, is_limited: bool) -> Iterator[Event]:
    """Events within a piece, and at its start, where a new cell may ask for more or less."""
    start = float(piece.start)

    def excess(since: float) -> float:
        pose = tuple(float(value) for value in piece.state(since))
        return max((demand(law(pose), limits) for law in speeds), default=0.0) - 1

    offsets = [float(time) - start for time in piece.times]
    times = sorted({0.0, *offsets, *((a + b) / 2 for a, b in pairwise(offsets))})
    before = 0.0, 0.0
    for since in times:
        now = excess(since)
        if (now > 0) is not is_limited:
            side = 1.0 if is_limited else -1.0
            at = since if not since else _passing(excess, side, before, (since, now))
            is_limited = not is_limited
            yield _event(start + at, piece.state(at), _at_limit(piece, at, speeds, limits) if is_limited else ())
        before = since, now


def _passing(excess: Demand, side: float, before: tuple[float, float], after: tuple[float, float]) -> float:
    """The time at which the demand passes one, coming from above (side 1) or from below (-1)."""
    return find_root(lambda since: side * excess(since), (before[0], side * before[1]), (after[0], side * after[1]))


def _at_limit(piece: Piece, at: float, speeds: list[Speeds], limits: Mapping[int, float]) -> tuple[int, ...]:
    """The wheels that ask for the most of what they can do."""
    pose = tuple(float(value) for value in piece.state(at))
    shares = [(abs(speed) / limits[w], w) for law in speeds for w, speed in law(pose).items() if w in limits]
    most = max(shares)[0]
    return tuple(sorted({wheel for share, wheel in shares if share >= most * SAME_SHARE}))


def _event(time: float, state: State, wheels: tuple[int, ...]) -> Event:
    if not wheels:
        return Event(time, state, EventKind.FREE, "no wheel is at its largest speed")
    named = ", ".join(map(str, wheels))
    return Event(time, state, EventKind.LIMIT, f"wheel{'s' * (len(wheels) > 1)} {named} at the largest speed")
