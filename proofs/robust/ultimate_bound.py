"""The distance at which bodies end, from cells with bounds of their velocities.

On the cell let ``c . v <= c . w`` for every velocity, with w a rational vector.  Outside the set where ``c . w >=
-kappa |c|`` the distance falls at the rate kappa.  That set meets the cell at distances up to a largest one: it is a
cone, so the largest is on the border of the polygon, at a corner or where a side leaves the cone.  Along a side
``c . w + kappa |c|`` is convex: beyond a point where it is negative, up to an end where it is, it stays so.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.symbolic.numbers.plane import around, between, dot

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
    corners, w = cell.polygon.vertices, cell.bound
    slow = [c for c in corners if w is None or is_slow(c, w, kappa)]
    sides = (*around(corners), *around(corners[::-1]))
    last = [_last_slow(a, b, w, kappa) for a, b in sides if a in slow and b not in slow]
    return max((dot(c, c) for c in (*slow, *last)), default=fmpq(0))


def is_slow(c: Any, w: Any, kappa: Any) -> bool:
    """Whether ``c . w >= -kappa |c|``."""
    falls = dot(c, w)
    return falls >= 0 or falls * falls <= kappa * kappa * dot(c, c)


def _last_slow(slow: Point, fast: Point, w: Any, kappa: fmpq) -> Point:
    """The first of the parts of a side beyond which, up to its fast end, no point is slow: by bisection.

    Floats propose it; where rational numbers do not confirm it, they bisect too.
    """
    number: Any
    for number in (float, fmpq):
        a, b, bound, rate = *(tuple(map(number, point)) for point in (slow, fast, w)), number(kappa)
        part = bisect_left(range(PARTS), True, key=lambda k: not is_slow(between(a, b, number(k) / PARTS), bound, rate))
        before, last = (between(slow, fast, fmpq(k, PARTS)) for k in (part - 1, part))
        if is_slow(before, w, kappa) and not is_slow(last, w, kappa):
            break
    return last


def root_above(square: Fraction) -> Fraction:
    """A rational number whose square is at least a given one, and little more."""
    guess = Fraction(math.sqrt(float(square))) * (1 + Fraction(1, 2**40))
    while guess * guess < square:
        guess *= 1 + Fraction(1, 2**30)
    return guess
