"""The disc of the translation clause as a checker can follow it: a squared radius, and barriers where V* grows.

Inside the disc ``V* = 2 c . v`` must not be positive (not even zero, where the verdict rests on ``V* < 0``).  On a cell
where it is, at some vertex, a barrier shows that this happens beyond the disc only: numbers ``(a, b, t)`` with ::

    a x + b y >= 1  at all corners of the cell,   t >= 0,   |n|^2 <= 1/squared_radius  for  n = (a, b) + t v

so ``n . c >= 1`` where ``v . c >= 0`` in the cell, hence ``|c|^2 >= squared_radius`` there.  Floats find the barriers,
the checker verifies them exactly.  Where V* limits the disc, the squared radius is a short rational just below it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.support import limiting_support
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_below, short_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import around, between, dot, minus

Floats: TypeAlias = tuple[float, float]
State: TypeAlias = tuple[int, int]  # position of a cell, and of a state in it

# Relative margin that a disc leaves for the rounding of its barriers; they are verified exactly.
MARGIN = 2.0**-20
BARRIER_BITS = 48
SIMPLE = 1_000  # denominators of a rate that may be the exact one


@dataclass(frozen=True)
class CertifiedDisc:
    """A disc about the checked point.

    Attributes:
        squared_radius: of the disc; None where V* does not keep its sign near the point.
        barriers: by state, where V* grows outside of the disc.
        strictly: whether V* is negative off the point, or only not positive.
        rate: at which ``|c|`` falls in the whole square; None where there is none.
    """

    squared_radius: Number | None
    barriers: dict[State, list[Fraction]]
    strictly: bool = False
    rate: Fraction | None = None


def certified_disc(partition: Partition) -> CertifiedDisc:
    """The largest disc in the square on which V* is as on the closed cells at the checked point, or a little less.

    It lies in the support polygon too: beyond, the body tips.

    Raises:
        OverflowError: for lengths or speeds beyond the range of floats.
    """
    zero, radius = partition.scene.field.zero, partition.scene.check.radius
    local = partition.cells_at((zero, zero))
    highest = max(_largest_sign(cell, twist) for cell in local for twist in cell.twists)
    here = {cell.index for cell in local}
    growing = {
        (k, s): _Growth.of(cell, twist)
        for k, cell in enumerate(partition.cells)
        for s, twist in enumerate(cell.twists)
        if cell.index not in here and _largest_sign(cell, twist) > highest
    }
    nearest = min((growth.distance for growth in growing.values()), default=math.inf)
    squared = radius * radius
    support = limiting_support(partition)
    if support is not None:
        squared = min(squared, support.squared_distance)
    size = math.sqrt(float(squared))
    if nearest * (1 - MARGIN) < size:
        size = nearest * (1 - MARGIN)
        squared = partition.scene.field.rational(_rounded(size * size * (1 - MARGIN)))
    barriers = {state: own.barrier(size) for state, own in growing.items()}
    return CertifiedDisc(squared, barriers, highest < 0, None if growing else _falling_rate(partition))


def _falling_rate(partition: Partition) -> Fraction | None:
    """A short ``rate > 0`` with ``c . v <= -rate |c|`` at all corners of all cells, hence in the square; else None."""
    pairs = [
        (-dot(twist.velocity, vertex), dot(vertex, vertex))
        for cell in partition.cells
        for vertex in cell.polygon.vertices
        if any(vertex)
        for twist in cell.twists
    ]
    least = min(rational_below(enclosure(inward) / enclosure(square).sqrt()) for inward, square in pairs)
    if least <= 0:
        return None
    simple = least.limit_denominator(SIMPLE)
    is_near = abs(simple - least) < least * Fraction(MARGIN)
    is_exact = is_near and all(sign(inward * inward - square * (simple * simple)) >= 0 for inward, square in pairs)
    return simple if is_exact else short_below(least)


def _largest_sign(cell: Cell, twist: Twist) -> int:
    """Largest sign of V* at the vertices other than the checked point."""
    return max(sign(dot(twist.velocity, vertex)) for vertex in cell.polygon.vertices if any(vertex))


@dataclass(frozen=True)
class _Growth:
    """A cell in floats, with the point of its part ``v . c >= 0`` that is nearest to the checked point."""

    vertices: tuple[Floats, ...]
    velocity: Floats
    nearest: Floats

    @classmethod
    def of(cls, cell: Cell, twist: Twist) -> _Growth:
        """The part follows from exact signs: floats could miss a vertex or side on which V* vanishes."""
        vertices = tuple((float(x), float(y)) for x, y in cell.polygon.vertices)
        signs = [sign(dot(twist.velocity, vertex)) for vertex in cell.polygon.vertices]
        v = float(twist.vx), float(twist.vy)
        part: list[Floats] = []
        for (p, here), (q, after) in around(list(zip(vertices, signs, strict=True))):
            if here >= 0:
                part.append(p)
            if here * after < 0:
                part.append(_crossing(p, q, v))
        return cls(vertices, v, min((_nearest(p, q) for p, q in around(part)), key=lambda p: math.hypot(*p)))

    @property
    def distance(self) -> float:
        """Distance of the part from the checked point (length)."""
        return math.hypot(*self.nearest)

    def barrier(self, size: float) -> list[Fraction]:
        """A barrier for the disc of this size, midway between what the disc and what the part allow."""
        scale = math.sqrt(self.distance / size) / self.distance / self.distance
        n, v = (self.nearest[0] * scale, self.nearest[1] * scale), self.velocity
        lower, upper = 0.0, math.inf
        for p in self.vertices:
            rate, slack = dot(v, p), dot(n, p) - 1
            if rate > 0:
                upper = min(upper, slack / rate)
            elif rate < 0:
                lower = max(lower, slack / rate)
        t = (lower + upper) / 2 if upper < math.inf else 2 * lower
        return [_rounded(x) for x in (n[0] - t * v[0], n[1] - t * v[1], t)]


def _crossing(p: Floats, q: Floats, v: Floats) -> Floats:
    """The point of a segment where ``v . c`` changes sign."""
    a, b = abs(dot(v, p)), abs(dot(v, q))
    return between(p, q, a / (a + b) if a + b else 0.5)


def _nearest(p: Floats, q: Floats) -> Floats:
    """The point of a segment that is nearest to the origin."""
    along = minus(q, p)
    length = dot(along, along)
    return between(p, q, min(1.0, max(0.0, -dot(p, along) / length)) if length else 0.0)


def _rounded(value: float) -> Fraction:
    """A short rational within ``2^-BARRIER_BITS`` of the value, relatively."""
    if not math.isfinite(value):
        raise OverflowError("required lengths and speeds within the range of floats")
    mantissa, exponent = math.frexp(value)
    return Fraction(round(mantissa * 2**BARRIER_BITS)) * Fraction(2) ** (exponent - BARRIER_BITS)
