"""How a path ends: at rest since a time, creeping, or moving; read off the path itself, not off why it was cut.

The speed of a state is the size of its rate.  Of a body ``(x, y, theta)`` that is ``|c'| + r |theta'|``, with r its
size: no point of it within r is faster.  Speeds are means over :data:`PARTS` equal parts of the time, by the dense
output of the engine, so that chatter about a place of rest is rest as far as it stays there.  With the path's unit of
speed u (the fastest rim of an array, the fastest part of the path of a plain system) a path ends

- *at rest since t*, where the mean speed is at most :data:`REST` u, or rounding of the states, in the last part and
  from t on: t is the time at which that begins, by bisection of the part before on the dense output, so an arrival in
  finite time is met to rounding;
- *creeping at v*, where it is at most :data:`CREEP` u in the last part;
- *moving at v*, where it is more.

A point that is only approached is at rest in this sense once what is left of the speed is that small.  All of it is
about the time that was followed, in floats, and proves nothing of later times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.symbolic.numbers.plane_arrays import Floats

PARTS = 1_000  # of the time
ROUNDING = 2.0**-50  # of the states: a way in a part of the time that is rounding, of some ulps
REST = 1e-5  # of the unit of speed; sticking under full dynamics is a creep of 1e-6
CREEP = 1e-2
BISECTIONS = 40
FOR_EVER = (EndReason.TURNING, EndReason.CIRCLES)  # what never ends, of paths without a last time


class EndMotion(StrEnum):
    """How a path ends."""

    AT_REST = "at rest"
    CREEPS = "creeps"
    MOVING = "moving"


@dataclass(frozen=True)
class Ending:
    """The end of a path.

    Attributes:
        motion: see the module.
        since: time from which it is at rest; None where it is not.
        speed: mean speed in the last part, of ``(x, y)`` alone where the state is a pose (length/time).
        turning: mean rate of theta in the last part (radian/time); None where the state is no pose.
    """

    motion: EndMotion
    since: float | None
    speed: float
    turning: float | None = None

    def record(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"motion": self.motion.value, "since": self.since, "speed": self.speed, "turning": self.turning}


def parts_of(path: Trajectory) -> Floats:
    """The ends of the parts of its time (PARTS + 1,); of a path without a last time up to its last sample."""
    last = float(path.end.t) if math.isfinite(float(path.end.t)) else float(path.times[-1])
    return np.linspace(0.0, last, PARTS + 1)


def ending(path: Trajectory, size: float | None = None, fastest: float = 0.0) -> Ending:
    """How a path ends.

    Args:
        path: of poses, or of the states of a plain system.
        size: r of a body; None for plain systems.
        fastest: a lower bound for the unit of speed, which is else the largest mean speed of a part.
    """
    times = parts_of(path)
    states = path.sample(times)
    length = times[1] - times[0]
    if not length:  # it ends where it begins
        return Ending(EndMotion.AT_REST, 0.0, 0.0, None if size is None else 0.0)

    def moved(first: Floats, last: Floats) -> Floats:
        apart = np.abs(last - first)
        if size is None:
            return np.asarray(np.linalg.norm(apart, axis=-1))
        return np.asarray(np.hypot(apart[..., 0], apart[..., 1]) + size * apart[..., 2])

    speeds = moved(states[:-1], states[1:]) / length
    unit = max(fastest, float(speeds.max()))
    slow = max(REST * unit, ROUNDING * float(np.abs(states).max()) / length)
    final = states[-1] - states[-2]
    own = final if size is None else final[:2]
    speed, turning = float(np.linalg.norm(own) / length), None if size is None else float(final[2] / length)
    if path.end.reason in FOR_EVER:
        return Ending(EndMotion.MOVING, None, speed, turning)
    if path.end.reason is EndReason.REST or speeds[-1] <= slow:
        since = _rest_begins(times, speeds, slow, lambda t, late: _mean(path, moved, t, late))
        return Ending(EndMotion.AT_REST, since, speed, turning)
    return Ending(EndMotion.CREEPS if speeds[-1] <= CREEP * unit else EndMotion.MOVING, None, speed, turning)


def _mean(path: Trajectory, moved: Callable[[Floats, Floats], Floats], t: float, late: float) -> float:
    first, last = path.sample([t, late])
    return float(moved(first, last)) / (late - t)


def _rest_begins(times: Floats, speeds: Floats, slow: float, mean: Callable[[float, float], float]) -> float:
    """The time from which the mean speed is at most ``slow``: within the last part that is faster."""
    fast = np.flatnonzero(speeds > slow)
    if not fast.size:
        return 0.0
    part = int(fast[-1])
    if part + 1 == len(speeds):  # the engine ended it where it came to rest
        return float(times[-1])
    low, high = float(times[part]), float(times[part + 1])
    late = high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if middle >= late or mean(middle, late) <= slow:
            high = middle
        else:
            low = middle
    return high
