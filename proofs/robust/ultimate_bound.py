"""The distance at which bodies end, from cells with bounds of their velocities.

On the cell let ``c . v <= c . w`` for every velocity, with w a rational vector.  Outside the set where ``c . w >=
-kappa |c|`` the distance falls at the rate kappa.  That set meets the cell at distances up to a largest one: it is a
cone, so the largest is on the border of the polygon, at a corner or where a side leaves the cone.  Along a side
``c . w + kappa |c|`` is convex: beyond a point where it is negative, up to an end where it is, it stays so.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from flint import fmpq

from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.symbolic.numbers.plane import around, dot

Point: TypeAlias = tuple[fmpq, fmpq]

PARTS = 2**20  # of a side: to which the ends of intervals are rounded


@dataclass(frozen=True)
class BoundedCell:
    """A cell and what bounds the velocities on it.

    Attributes:
        polygon: over the rationals.
        bound: w; None where velocities are not bounded.
    """

    polygon: Polygon
    bound: Point | None


def squared_radius(cells: Iterable[BoundedCell], kappa: fmpq) -> fmpq:
    """Square of a distance beyond which ``c . v <= -kappa |c|`` on all cells; kappa at least zero."""
    return max((_squared_reach(cell, kappa) for cell in cells), default=fmpq(0))


def _squared_reach(cell: BoundedCell, kappa: fmpq) -> fmpq:
    corners: tuple[Point, ...] = cell.polygon.vertices
    if cell.bound is None:
        return max(dot(c, c) for c in corners)
    reach = fmpq(0)
    for a, b in around(corners):
        slow_a, slow_b = (is_slow(c, cell.bound, kappa) for c in (a, b))
        if slow_a:
            reach = max(reach, dot(a, a))
        if slow_a != slow_b:
            begin, end = (a, b) if slow_a else (b, a)
            last = _last_slow(begin, end, cell.bound, kappa)
            reach = max(reach, dot(last, last))
    return reach


def is_slow(c: Point, w: Point, kappa: fmpq) -> bool:
    """Whether ``c . w >= -kappa |c|``."""
    falls = dot(c, w)
    return falls >= 0 or falls * falls <= kappa * kappa * dot(c, c)


def _last_slow(slow: Point, fast: Point, w: Point, kappa: fmpq) -> Point:
    """The first of the parts of a side beyond which, up to its fast end, no point is slow: by bisection."""
    low, high = 0, PARTS
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_slow(_between(slow, fast, middle), w, kappa) else (low, middle)
    return _between(slow, fast, high)


def _between(a: Point, b: Point, part: int) -> Point:
    share = fmpq(part, PARTS)
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def root_above(square: Fraction) -> Fraction:
    """A rational number whose square is at least a given one, and little more."""
    guess = Fraction(math.sqrt(float(square))) * (1 + Fraction(1, 2**40))
    while guess * guess < square:
        guess *= 1 + Fraction(1, 2**30)
    return guess
