"""The support polygon about the checked point: where the body stands, and where it tips.

Wheels only push, so forces balance the weight iff the centre of mass lies in the convex hull of the wheels.  Rule
``nearest`` asks for no loads and has cells beyond; what it says there is said of a body that tips.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from flint import arb

from nonsmooth.analysis.cells.contact_rule import contact_rule
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import square
from nonsmooth.symbolic.mechanics.body import outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot, minus
from nonsmooth.symbolic.numbers.rounded import remembered
from nonsmooth.symbolic.numbers.square_roots import NestingError

BITS = 40  # of a rational just below the distance


@dataclass(frozen=True)
class Support:
    """The support polygon of a centred scene.

    Attributes:
        corners: counterclockwise; fewer than three where all wheels stand on one line.
    """

    corners: tuple[Vector, ...]

    @property
    def sides(self) -> tuple[tuple[Vector, Vector], ...]:
        """From corner to corner, counterclockwise; none where it has no area."""
        return tuple(pairwise([*self.corners, self.corners[0]])) if len(self.corners) > 2 else ()

    @cached_property
    def stands(self) -> bool:
        """Whether the checked point lies strictly inside; elsewhere the body tips."""
        return bool(self.sides) and all(cross(p, q).sign() > 0 for p, q in self.sides)

    @cached_property
    def squared_distance(self) -> Number:
        """Squared distance of the checked point, strictly inside, from the border."""
        return min(_squared_distance(p, q) for p, q in self.sides)

    @cached_property
    def distance(self) -> Number | arb:
        """Distance from the border; a ball where the square root nests too deep."""
        try:
            return self.squared_distance.sqrt()
        except NestingError:
            return self.squared_distance.ball().sqrt()

    @cached_property
    def distance_below(self) -> Fraction:
        """A short rational just below the distance."""
        return rational_below_root(self.squared_distance)


def rational_below_root(square: Number) -> Fraction:
    """A short rational whose square is at most a positive number, and close to it."""
    mantissa, exponent = math.frexp(math.sqrt(float(square)))
    below = Fraction(math.floor(mantissa * 2**BITS)) * Fraction(2) ** (exponent - BITS)
    while (square - below * below).sign() < 0:
        below *= 1 - Fraction(1, 2**BITS)
    return below


def _squared_distance(start: Vector, end: Vector) -> Number:
    """Squared distance of the origin from the line through two points."""
    along = minus(end, start)
    area = cross(start, along)
    return area * area / dot(along, along)


@remembered(4)  # several clauses of one check ask for it
def _left_support(scene: Scene) -> Support | None:
    """The support polygon of all wheels of a centred scene; None where the square lies in it."""
    support = Support(tuple(support_polygon(outer_positions(scene.positions))))
    zero = scene.field.zero
    vertices = square((zero, zero), scene.check.radius).vertices
    inside = (cross(minus(q, p), minus((x, y), p)).sign() >= 0 for p, q in support.sides for x, y in vertices)
    return None if support.sides and all(inside) else support


def limiting_support(partition: Partition) -> Support | None:
    """The support polygon, where the square leaves it and regions must be cut at it.

    Rules that need loads refuse squares that leave it.  Where the point itself is not strictly inside, no region is
    left.
    """
    if contact_rule(partition.rule).needs_loads or (partition.like and limiting_support(partition.like) is None):
        return None
    return _left_support(partition.scene)
