"""The closed forms of :mod:`nonsmooth.analysis.trajectories.motion` for many starts at once, in floats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.fields.constant_field import Flow
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.plane_arrays import turned
from nonsmooth.analysis.trajectories.slides import (
    ASYMPTOTE_DOUBT,
    PROPORTIONAL_DOUBT,
    SERIES_BELOW,
    SERIES_TERMS,
)


def velocities(flow: Flow, points: Floats) -> Floats:
    """``c'`` at points (m, 2)."""
    return np.array([flow.vx, flow.vy]) + flow.turn * turned(points)


def positions(flow: Flow, points: Floats, times: Floats) -> Floats:
    """Points after free motion for a time each."""
    v = velocities(flow, points)
    if not flow.turn:
        return points + v * times[:, None]
    along = np.sin(flow.turn * times) / flow.turn
    across = 2 * np.sin(flow.turn * times / 2) ** 2 / flow.turn
    return points + along[:, None] * v + across[:, None] * turned(v)


def crossing_times(
    flow: Flow, sides: Sequence[HalfPlane], points: Floats, active: frozenset[int], slack: float
) -> Floats:
    """Time until each side is crossed, (m, sides); infinite where it never is."""
    v, w = velocities(flow, points), flow.turn
    times = np.full((len(points), len(sides)), np.inf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for k, side in enumerate(sides):
            a, b = side.normal
            rate, bend = v[:, 0] * a + v[:, 1] * b, v[:, 0] * b - v[:, 1] * a
            if k in active:
                if w:
                    back = _time(w, -2 * rate / (w * bend))
                    times[:, k] = np.where(np.abs(rate) > slack, back, np.inf)
                continue
            gap = np.maximum(side.offset - points[:, 0] * a - points[:, 1] * b, 0.0)
            if not w:
                times[:, k] = np.where(rate > 0, gap / rate, np.inf)
                continue
            quadratic = w * (2 * bend - w * gap) / 4
            discriminant = rate**2 + 4 * quadratic * gap
            q = -(rate + np.copysign(np.sqrt(discriminant), rate)) / 2
            found = np.fmin(_time(w, -gap / q), _time(w, q / quadratic))
            times[:, k] = np.where(discriminant >= 0, found, np.inf)
    return times


def _time(w: float, z: Floats) -> Floats:
    """Time in ``(0, 2 pi/|w|)`` at which ``(2/w) tan(wt/2) = z``."""
    angle = np.arctan(abs(w) * np.abs(z) / 2)
    return 2 / abs(w) * np.where(z > 0, angle, np.pi - angle)


class EdgeSpeeds(NamedTuple):
    """Speeds of the two neighbours of an edge: towards its left, and along its direction."""

    left: Floats
    right: Floats
    left_along: Floats
    right_along: Floats


def edge_speeds(left: Flow, right: Flow, direction: Point, points: Floats) -> EdgeSpeeds:
    """Normal speeds (towards the left) and tangential speeds of the neighbours of an edge."""
    rx, ry = direction
    u, v = velocities(left, points), velocities(right, points)
    return EdgeSpeeds(
        rx * u[:, 1] - ry * u[:, 0],
        rx * v[:, 1] - ry * v[:, 0],
        rx * u[:, 0] + ry * u[:, 1],
        rx * v[:, 0] + ry * v[:, 1],
    )


class SlideEnds(NamedTuple):
    """How slides end: distance covered, time taken (infinite: an equilibrium is approached), rotation."""

    reach: Floats
    time: Floats
    rotation: Floats


def slide_ends(speeds: EdgeSpeeds, left: Flow, right: Flow, ends: Floats) -> SlideEnds:
    """Slides along a unit direction from points with the given speeds to the corner at distance ``ends``.

    The neighbours' normal speeds are of opposite strict signs at the start.
    """
    n1, n2, p1, p2 = speeds
    a, b = n2 * p1 - n1 * p2, right.turn * p1 - left.turn * p2
    c, d = n2 - n1, np.full_like(n1, right.turn - left.turn)
    k = n2 * left.omega - n1 * right.omega
    first, second = n1 * right.turn, n2 * left.turn
    fixed = np.abs(first - second) <= PROPORTIONAL_DOUBT * (np.abs(first) + np.abs(second))
    share = n2 / c
    a, c = np.where(fixed, share * p1 + (1 - share) * p2, a), np.where(fixed, 1.0, c)
    b, d = np.where(fixed, 0.0, b), np.where(fixed, 0.0, d)
    k = np.where(fixed, share * left.omega + (1 - share) * right.omega, k)
    reach = np.array(ends)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for normal, turn in ((n1, left.turn), (n2, right.turn)):
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
