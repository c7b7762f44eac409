"""The disc in which bodies end, for every array of a box: ring after ring on which every body comes nearer.

On a ring ``inner <= |c| <= outer`` let ``c . v <= -kappa |c|`` for every array and every possible velocity.  It is
shown on quadrangles that cover the ring, each divided where that is not enough.  ``(c . c)' = 2 c . v``, so that bodies
within the largest ring come to the smallest one, in the sum of the times (outer - inner)/kappa, and do not leave.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Generic, TypeAlias, TypeVar

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.proofs.robust.level_sets import AnnulusPiece, ring
from nonsmooth.symbolic.mechanics.scene import Tolerance
from nonsmooth.symbolic.messages.under_way import tell, tell_count
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import around, between, dot, in_floats

PRECISION = 64  # bits of the balls
RINGS = 16  # of equal width, from the square inward
GROWTH = Fraction(6, 5)  # of the least radius: what a faster rate may cost
LEAST = Fraction(1, 2**20)  # of the radius of starts: smaller discs are not looked for

Bound = TypeVar("Bound")


@dataclass(frozen=True)
class TouchingRings:
    """Rings that touch, from the largest inward.

    Attributes:
        outer: level of the first one's outer border (length).
        inner: level of the inner border of each (length).
        rates: kappa on each (length/time).
        inside: radius of a disc that a level set holds, over its level.
        outside: radius of a disc that holds it.
    """

    outer: Fraction
    inner: tuple[Fraction, ...]
    rates: tuple[Fraction, ...]
    inside: Fraction = Fraction(1)
    outside: Fraction = Fraction(1)

    @property
    def start(self) -> Fraction:
        """Radius of the disc of starts."""
        return self.outer * self.inside

    @property
    def radius(self) -> Fraction:
        """Of the disc in which every body ends."""
        return self.inner[-1] * self.outside

    def swing_from(self, start: Fraction) -> Fraction:
        """A distance that no body from within ``start`` exceeds: of the level set that holds that disc."""
        return start * self.outside / self.inside

    def time_to(self, radius: Fraction, start: Fraction | None = None) -> Fraction:
        """After which every body from within ``start`` is within a radius that is not below :attr:`radius`."""
        outer, total = self.outer, Fraction(0)
        most = self.outer if start is None else start / self.inside
        for inner, rate in zip(self.inner, self.rates, strict=True):
            width = min(outer, most) - max(inner, radius / self.outside)
            total += max(width, Fraction(0)) / rate
            outer = inner
        return total


class RingProof(ABC, Generic[Bound]):
    """Discs in which bodies end under one contact rule; a subclass says how the rate on a quadrangle is shown.

    Attributes:
        widest: width of a ring as a share of its outer radius, at most.
        growth: of the width from one ring to the next.
        halvings: of the ring in which the disc ends.
        starts: shares of the square from which bodies may start, tried one after the other.
        sectors: quadrangles of a ring before any is divided.
        depth: how often a quadrangle is divided into four.
    """

    widest = Fraction(1)
    growth = 1
    halvings = 5
    starts = tuple(Fraction(k, 16) for k in (16, 15, 14, 12, 10, 8))
    sectors = 16
    depth = 3

    @abstractmethod
    def over(self, box: Tolerance) -> Bound | None:
        """What is known of all arrays of a box; None where nothing is, or the loads are not fixed."""

    @abstractmethod
    def rates(self, bound: Bound, pieces: Sequence[AnnulusPiece], *, at_any: bool) -> Iterable[arb | None]:
        """For each quadrangle a positive kappa with ``c . v <= -kappa |c|``; None where it must be divided.

        Args:
            bound: what is known of all arrays of a box.
            pieces: quadrangles.
            at_any: whether any kappa does, in place of a large one.
        """

    def comes_nearer(self, box: Tolerance, most: Fraction) -> bool:
        """Whether on some ring within ``most`` of the point bodies come nearer, at any rate."""
        with ctx.workprec(PRECISION):
            if (box, most) in self._found:
                return self._found[box, most] is not None
            bound = self.over(box)
            return bound is not None and self._first_ring(bound, most, at_any=True) is not None

    def disc(self, box: Tolerance, most: Fraction) -> TouchingRings | None:
        """The disc in which bodies end that start in one of a radius up to ``most``; None where none is found."""
        with ctx.workprec(PRECISION):
            first = self._outermost(box, most)
            if first is None:
                return None
            bound, start, rate = first
            return _fastest(list(self._inward(bound, start, rate)), start)

    def _outermost(self, box: Tolerance, most: Fraction) -> tuple[Bound, Fraction, arb] | None:
        """What is known of a box, with its first ring."""
        if (box, most) not in self._found:
            bound = self.over(box)
            first = None if bound is None else self._first_ring(bound, most, at_any=False)
            self._found[box, most] = None if bound is None or first is None else (bound, *first)
        return self._found[box, most]

    @cached_property
    def _found(self) -> dict[tuple[Tolerance, Fraction], tuple[Bound, Fraction, arb] | None]:
        return {}

    @cached_property
    def _failed(self) -> set[AnnulusPiece]:
        """Quadrangles on which some box failed: they are looked at first, since others fail there too."""
        return set()

    def _first_ring(self, bound: Bound, most: Fraction, *, at_any: bool) -> tuple[Fraction, arb] | None:
        """The outer radius of the first ring on which bodies come nearer, and their rate there."""
        for k, share in enumerate(self.starts):
            tell_count(k, len(self.starts), "widest rings")
            outer = most * share
            rate = self._rate(bound, outer * (1 - Fraction(1, RINGS)), outer, at_any=at_any)
            if rate is not None:
                return outer, rate
        return None

    def _inward(self, bound: Bound, start: Fraction, rate: arb) -> Iterator[tuple[Fraction, arb]]:
        """Inner radii of rings one after the other, and the rate on each; the last ones ever narrower."""
        inner, step, halvings = start * (1 - Fraction(1, RINGS)), start / RINGS, 0
        yield inner, rate
        while inner > LEAST * start and halvings <= self.halvings:
            tell(f"rings within {float_text(inner / start, 3)} of the widest")
            step = min(step, inner * self.widest)
            inner_rate = self._rate(bound, inner - step, inner)
            if inner_rate is None:
                step, halvings = step / 2, halvings + 1
                continue
            inner, step = inner - step, step * self.growth
            yield inner, inner_rate

    def _rate(self, bound: Bound, inner: Fraction, outer: Fraction, *, at_any: bool = False) -> arb | None:
        """A positive kappa with ``c . v <= -kappa |c|`` on a ring; None where none is shown."""
        return self._least(bound, list(ring(inner, outer, self.sectors)), self.depth, at_any=at_any)

    def _least(self, bound: Bound, pieces: Sequence[AnnulusPiece], depth: int, *, at_any: bool) -> arb | None:
        """The least rate on several quadrangles, divided where that is needed."""
        least = None
        hard = [piece for piece in pieces if piece in self._failed]
        for few in (hard, [piece for piece in pieces if piece not in hard]):
            for piece, kappa in zip(few, self.rates(bound, few, at_any=at_any), strict=True):
                rate = kappa
                if rate is None and depth:
                    rate = self._least(bound, list(piece.parts), depth - 1, at_any=at_any)
                if rate is None:
                    self._failed.add(piece)
                    return None
                least = rate if least is None else min(least, rate, key=rational_below)
        return least


def _fastest(rings: list[tuple[Fraction, arb]], start: Fraction) -> TouchingRings:
    """Nearly the smallest disc: slow rings at the end, which would bring bodies hardly nearer, are left out."""
    radius = max(rings[-1][0], LEAST * start)
    indices = [k for k, (inner, _) in enumerate(rings) if inner <= GROWTH * radius] or [len(rings) - 1]
    rates = [rational_below(rate) for _, rate in rings]
    last = max(indices, key=lambda k: (min(rates[: k + 1]), -rings[k][0]))
    return TouchingRings(start, tuple(inner for inner, _ in rings[: last + 1]), tuple(rates[: last + 1]))


# ---- the distance at which bodies end, from cells with bounds of their velocities ----------------
#
# On the cell let ``c . v <= c . w`` for every velocity, with w a rational vector.  Outside the set where ``c . w >=
# -kappa |c|`` the distance falls at the rate kappa.  That set meets the cell at distances up to a largest one: it is a
# cone, so the largest is on the border of the polygon, at a corner or where a side leaves the cone.  Along a side
# ``c . w + kappa |c|`` is convex: beyond a point where it is negative, up to an end where it is, it stays so.


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

    @cached_property
    def slow_from(self) -> list[fmpq]:
        """The square of the least kappa for which each corner is slow."""
        w = self.bound or (0, 0)
        return [min(dot(c, w), fmpq(0)) ** 2 / (dot(c, c) or fmpq(1)) for c in self.polygon.vertices]


def squared_radius(cells: Iterable[BoundedCell], kappa: fmpq) -> fmpq:
    """Square of a distance beyond which ``c . v <= -kappa |c|`` on all cells; kappa at least zero."""
    return max((_squared_reach(cell, kappa) for cell in cells), default=fmpq(0))


def _squared_reach(cell: BoundedCell, kappa: fmpq) -> fmpq:
    corners, square = cell.polygon.vertices, kappa * kappa
    slow = [c for c, least in zip(corners, cell.slow_from, strict=True) if least <= square]
    sides = (*around(corners), *around(corners[::-1]))
    last = [_last_slow(a, b, cell.bound, kappa) for a, b in sides if a in slow and b not in slow]
    return max((dot(c, c) for c in (*slow, *last)), default=fmpq(0))


def is_slow(c: Any, w: Any, kappa: Any) -> bool:
    """Whether ``c . w >= -kappa |c|``."""
    falls = dot(c, w)
    return falls >= 0 or falls * falls <= kappa * kappa * dot(c, c)


def _last_slow(slow: Point, fast: Point, w: Any, kappa: fmpq) -> Point:
    """The first of the parts of a side beyond which, up to its fast end, no point is slow.

    Bisection in floats proposes it; where rational numbers do not confirm that, they bisect.
    """
    a, b, bound, rate = in_floats(slow), in_floats(fast), in_floats(w), float(kappa)

    def seems_fast(part: int) -> bool:
        return not is_slow(between(a, b, part / PARTS), bound, rate)

    def is_fast(part: int) -> bool:
        return not is_slow(between(slow, fast, fmpq(part, PARTS)), w, kappa)

    near = bisect_left(range(PARTS), True, key=seems_fast)
    proposals = (near + k for k in (0, 1, -1))
    part = next((k for k in proposals if 0 < k <= PARTS and is_fast(k) and not is_fast(k - 1)), None)
    if part is None:
        part = bisect_left(range(PARTS), True, key=is_fast)
    return between(slow, fast, fmpq(part, PARTS))


def root_above(square: Fraction) -> Fraction:
    """A rational number whose square is at least a given one, and little more."""
    half = (square.numerator.bit_length() - square.denominator.bit_length()) // 2  # floats might not hold the square
    near = math.sqrt(float(square / Fraction(4) ** half))
    guess = Fraction(near) * Fraction(2) ** half * (1 + Fraction(1, 2**40))
    while guess * guess < square:
        guess *= 1 + Fraction(1, 2**30)
    return guess
