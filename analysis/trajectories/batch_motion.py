"""The closed forms of :mod:`nonsmooth.analysis.trajectories.cell_motion` for many starts at once, in floats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.analysis.cells.moves import RaySpeeds, sliding
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.fields.constant_field import Flow
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.plane_arrays import turned
from nonsmooth.analysis.trajectories.cell_motion import line_times, times_back
from nonsmooth.analysis.trajectories.slides import (
    ASYMPTOTE_DOUBT,
    PROPORTIONAL_DOUBT,
    SERIES_BELOW,
    SERIES_TERMS,
)
from nonsmooth.symbolic.plane import cross, dot


def velocities(flow: Flow, points: Floats) -> Floats:
    """``c'`` at points (m, 2)."""
    return np.array([flow.vx, flow.vy]) + flow.turn * turned(points)


def crossing_times(
    flow: Flow, sides: Sequence[HalfPlane], points: Floats, active: frozenset[int], slack: float
) -> Floats:
    """Time until each side is crossed, (m, sides); infinite where it never is."""
    velocity: Any = velocities(flow, points).T
    w, at, never = float(flow.turn), (points[:, 0], points[:, 1]), np.full(len(points), np.inf)
    found = []
    for k, side in enumerate(sides):
        rate, bend, gap = dot(velocity, side.normal), cross(velocity, side.normal), side.slack(at)
        if k in active:
            found.append(np.where(np.abs(rate) > slack, times_back(w, rate, bend), np.inf) if w else never)
        elif w:
            found.append(line_times(w, gap, rate, bend))
        else:
            found.append(np.divide(np.maximum(gap, 0.0), rate, out=never.copy(), where=rate > 0))
    return np.stack(found, axis=1)


def edge_speeds(flow: Flow, direction: Point, points: Floats) -> RaySpeeds:
    """Speeds of a neighbour of an edge of unit direction: towards the left of the edge, and along it."""
    velocity: Any = velocities(flow, points).T
    return RaySpeeds(cross(direction, velocity), flow.turn, dot(direction, velocity))


class SlideEnds(NamedTuple):
    """How slides end: distance covered, time taken (infinite: an equilibrium is approached), rotation."""

    reach: Floats
    time: Floats
    rotation: Floats


def slide_ends(speeds: tuple[RaySpeeds, RaySpeeds], omegas: tuple[float, float], ends: Floats) -> SlideEnds:
    """Slides along a unit direction from points with the given speeds to the corner at distance ``ends``.

    Speeds and rotation rates of the left and the right cell; the normal speeds are of opposite strict signs at the
    start.
    """
    (n1, b1, p1), (n2, b2, p2) = speeds
    a, b, c, d = sliding(speeds[1], speeds[0])
    k = n2 * omegas[0] - n1 * omegas[1]
    first, second = n1 * b2, n2 * b1
    fixed = np.abs(first - second) <= PROPORTIONAL_DOUBT * (np.abs(first) + np.abs(second))
    share = n2 / c
    a, c = np.where(fixed, share * p1 + (1 - share) * p2, a), np.where(fixed, 1.0, c)
    b, d = np.where(fixed, 0.0, b), np.where(fixed, 0.0, d)
    k = np.where(fixed, share * omegas[0] + (1 - share) * omegas[1], k)
    reach = np.array(ends)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for normal, turn in ((n1, b1), (n2, b2)):
            if turn:
                reach = np.where(-normal / turn > 0, np.minimum(reach, -normal / turn), reach)
        stop = -a / b
        endless = (stop > 0) & (stop <= reach * (1 + ASYMPTOTE_DOUBT))
        x = np.where(endless, 0.0, b * reach / a)
        time = c * reach / a * _logarithm(x) + d * reach**2 / a * _second_logarithm(x)
        rotation = k * reach / a * _logarithm(x)
    turning = np.where(k != 0, np.copysign(np.inf, k * a), 0.0)
    return SlideEnds(
        np.where(endless, stop, reach), np.where(endless, np.inf, time), np.where(endless, turning, rotation)
    )


def _logarithm(x: Floats) -> Floats:
    """``log(1 + x)/x``, one at zero."""
    safe = np.where(x == 0, 1.0, x)
    return np.where(x == 0, 1.0, np.log1p(safe) / safe)


def _second_logarithm(x: Floats) -> Floats:
    """``(x - log(1 + x))/x^2``, one half at zero."""
    small = np.abs(x) < SERIES_BELOW
    near = np.where(small, x, 0.0)
    series = sum((-near) ** k / (k + 2) for k in range(SERIES_TERMS))
    far = np.where(small, 1.0, x)
    return np.where(small, series, (far - np.log1p(far)) / far**2)
