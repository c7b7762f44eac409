"""Closed forms of the motions between events on cells with constant twist.

- *free* in a cell: with ``c' = v + w J c`` and initial velocity v0,
  ``c(t) = c0 + (sin wt)/w v0 + (1 - cos wt)/w J v0``, a straight line for w = 0.  The time to a line ``m . c = b``
  solves a quadratic in ``z = (2/w) tan(wt/2)``, which turns into the linear equation of a straight path as w -> 0: no
  case of nearly straight arcs loses digits.
- *rest*: c stays, theta drifts at a constant rate.

With w = 0 every formula is rational, so exact numbers stay exact.  None stands for a time that never comes.  Sliding
has a file of its own, :mod:`nonsmooth.analysis.trajectories.slides`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.fields.constant_field import Flow
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import dot, turned
from nonsmooth.symbolic.numbers.plane_arrays import Floats

State: TypeAlias = tuple[Any, Any, Any]


class SideCrossing(NamedTuple):
    """A side that a free motion reaches, and when."""

    time: Any
    side: int


@dataclass(frozen=True)
class Free:
    """Motion inside a cell from ``point`` with heading ``theta``, of one start or of arrays of them (m,)."""

    point: Point
    theta: Any
    flow: Flow

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``."""
        (vx, vy), w = self.flow.velocity(self.point), self.flow.turn
        theta = self.theta + self.flow.omega * time
        if not w:
            return self.point[0] + vx * time, self.point[1] + vy * time, theta
        sine = np.sin if isinstance(time, np.ndarray) else math.sin
        along, across = sine(w * time) / w, 2 * sine(w * time / 2) ** 2 / w
        return self.point[0] + along * vx - across * vy, self.point[1] + along * vy + across * vx, theta

    def first_crossing(self, sides: Iterable[HalfPlane], active: frozenset[int], slack: float) -> SideCrossing | None:
        """The side through which the path leaves a convex cell.

        It departs from the active sides; from those along which it moves, within a slack of the speed, it bends away.
        """
        best: SideCrossing | None = None
        for k, side in enumerate(sides):
            time = self._time_to(side) if k not in active else self._time_back(side, slack)
            if time is not None and (best is None or time < best.time):
                best = SideCrossing(time, k)
        return best

    def _time_to(self, side: HalfPlane) -> Any | None:
        """Time until a line ahead is crossed."""
        velocity, w = self.flow.velocity(self.point), self.flow.turn
        rate = dot(side.normal, velocity)
        if not w:
            return None if sign(rate) <= 0 else side.slack(self.point) / rate
        return _known(line_times(w, side.slack(self.point), rate, dot(side.normal, turned(velocity))))

    def _time_back(self, side: HalfPlane, slack: float) -> Any | None:
        """Time until an arc is back on a line that it departs from."""
        velocity, w = self.flow.velocity(self.point), self.flow.turn
        rate = dot(side.normal, velocity)
        if not w or abs(rate) <= slack:
            return None
        return _known(times_back(w, rate, dot(side.normal, turned(velocity))))


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def line_times(w: float, gap: Any, rate: Any, bend: Any) -> Floats:
    """Times until arcs cross a line ahead, infinite where they never do; of one start, or of many.

    Args:
        w: the rate at which their velocities v turn.
        gap: distances from the line, whose unit normal is n.
        rate: ``n . v``.
        bend: ``n . J v``.
    """
    gap, rate = np.maximum(gap, 0.0), np.asarray(rate, float)
    quadratic = w * (2 * bend - w * gap) / 4
    discriminant = rate**2 + 4 * quadratic * gap
    q = -(rate + np.copysign(np.sqrt(discriminant), rate)) / 2
    found = np.fmin(_arc_time(w, -gap / q), _arc_time(w, q / quadratic))
    return np.where(discriminant >= 0, found, np.inf)


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def times_back(w: float, rate: Any, bend: Any) -> Floats:
    """Times until arcs are back on a line that they depart from: the root z = 0 is the departure itself."""
    return _arc_time(w, np.asarray(-2 * rate, float) / (w * bend))


def _arc_time(w: float, z: Any) -> Floats:
    """Time in ``(0, 2 pi/|w|)`` at which ``(2/w) tan(wt/2) = z``."""
    angle = np.arctan(abs(w) * np.abs(z) / 2)
    return np.asarray(2 / abs(w) * np.where(z > 0, angle, np.pi - angle))


def _known(time: Floats) -> float | None:
    return float(time) if time < np.inf else None


@dataclass(frozen=True)
class Rest:
    """c stays; theta drifts at ``rate``."""

    point: Point
    theta: Any
    rate: Any

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` after ``time``."""
        return self.point[0], self.point[1], self.theta + self.rate * time
