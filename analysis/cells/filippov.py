"""The Filippov set-valued map of a partition and the upper derivative of V = |c - c*|^2.

``F(c) = co { c' of every cell whose closure holds c }``; values of the field on surfaces are ignored.  The
upper derivative ``V*(c) = max over F(c) of grad V . f`` (Filippov 1988, sec. 15; Murphey & Burdick, eq. 5) is
the maximum of a linear function over a hull, so it is attained at a cell's own velocity.  On one cell with
constant twist it is linear in c, because ``c . J c = 0`` removes the rotation: hence it is decided at the
vertices of the closed cell, exactly.

The partition must be centred: ``c* = 0`` (:meth:`nonsmooth.symbolic.mechanics.scene.Scene.recentred`).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from flint import arb, ctx

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.enclosures import PRECISION, enclosure, square_root
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import around, cross, dot

_PRECISION = 128  # bits of the balls by which slopes are compared first


def filippov_twists(partition: Partition, point: Point | None = None) -> tuple[Twist, ...]:
    """Twists whose pose rates span ``F(point)``: those of every closed cell that holds the point, else the origin."""
    cells = partition.meeting if point is None else partition.cells_at(point)
    return tuple(dict.fromkeys(t for cell in cells for t in cell.twists))


def lyapunov_rate(twist: Twist, point: Point) -> Number:
    """``d/dt |c|^2 = 2 c . v`` (the same for exact and leading-order kinematics)."""
    return 2 * dot(twist.velocity, point)


def upper_derivative_at(partition: Partition, point: Point) -> Number:
    """``V*(point)`` for ``V = |c|^2``, exactly.

    Raises:
        ValueError: if the point is outside the checked square.
    """
    twists = filippov_twists(partition, point)
    if not twists:
        raise ValueError(f"required a point of the checked square, received ({point[0]}, {point[1]})")
    return max(lyapunov_rate(twist, point) for twist in twists)


@dataclass(frozen=True)
class RelativeRate:
    """The number ``2 v . c/|c|`` for a direction c; compared without taking roots, and mostly by balls."""

    velocity: Point
    direction: Point

    @cached_property
    def _product(self) -> Number:
        return dot(self.velocity, self.direction)

    @cached_property
    def _length_squared(self) -> Number:
        return dot(self.direction, self.direction)

    @cached_property
    def _ball(self) -> arb:
        """Half the number."""
        with ctx.workprec(_PRECISION):
            return enclosure(self._product) / enclosure(self._length_squared).sqrt()

    def __lt__(self, other: RelativeRate) -> bool:
        if self._ball < other._ball:
            return True
        if self._ball > other._ball:
            return False
        s, t = self._product.sign(), other._product.sign()
        if s != t:
            return s < t
        square = self._product * self._product * other._length_squared
        others = other._product * other._product * self._length_squared
        return bool(square < others if s > 0 else others < square)

    def sign(self) -> int:
        """Certified sign: -1, 0 or 1."""
        return self._product.sign()

    def scaled(self, factor: Fraction) -> RelativeRate:
        """A multiple of the number."""
        x, y = self.velocity
        return RelativeRate((x * factor, y * factor), self.direction)

    def is_at_most(self, bound: Number) -> bool:
        """Whether the number is not above a bound, without taking its root."""
        if self.sign() != bound.sign():
            return self.sign() < bound.sign()
        excess = 4 * self._product * self._product - bound * bound * self._length_squared
        return excess.sign() * self.sign() <= 0

    @property
    def value(self) -> Number | arb:
        """The exact value, which takes one square root; a ball where that root is out of reach."""
        if not self.sign():
            return self.velocity[0].field.zero
        with ctx.workprec(PRECISION):
            return 2 * self.sign() * square_root(self._product * self._product / self._length_squared)


@dataclass(frozen=True)
class CellDerivative:
    """V* on one closed cell for one of its twists.

    Attributes:
        cell: the cell.
        twist: the twist.
        rates: ``2 c . v`` at each vertex of the cell.
    """

    cell: Cell
    twist: Twist
    rates: tuple[Number, ...]

    @property
    def largest(self) -> tuple[Number, Point]:
        """Largest value of V* on the closed cell and the vertex that attains it."""
        best = max(range(len(self.rates)), key=lambda k: self.rates[k])
        return self.rates[best], self.cell.polygon.vertices[best]

    def relative(self) -> RelativeRate:
        """Supremum of ``V*/|c|`` over the nonzero points of the closed cell."""
        return largest_slope(self.twist, self.cell.polygon)


def cell_derivatives(partition: Partition) -> tuple[CellDerivative, ...]:
    """V* at the vertices of every closed cell."""
    return tuple(
        CellDerivative(cell, twist, tuple(lyapunov_rate(twist, p) for p in cell.polygon.vertices))
        for cell in partition.cells
        for twist in cell.twists
    )


def largest_slope(twist: Twist, polygon: Polygon) -> RelativeRate:
    """Supremum of ``2 v . c/|c|`` over the polygon's nonzero points.

    It is ``2 |v|`` where the polygon holds a point along v, and is attained at a vertex otherwise: the cosine
    of the angle to v falls away from v.
    """
    velocity = twist.velocity
    directions = [p for p in polygon.vertices if any(p)]
    if any(velocity) and points_into(polygon, velocity):
        directions = [velocity]
    best = RelativeRate(velocity, directions[0])
    for p in directions[1:]:
        best = max(best, RelativeRate(velocity, p))
    return best


def points_into(polygon: Polygon, direction: Point) -> bool:
    """Whether the ray from the origin along ``direction`` meets the polygon beyond the origin.

    The line ``cross(direction, c) = 0`` cuts the polygon in a segment; its ends lie on the ray iff their
    inner product with the direction is positive.
    """
    for (p, here), (q, after) in around([(p, sign(cross(direction, p))) for p in polygon.vertices]):
        if here == 0 and sign(dot(direction, p)) > 0:
            return True
        if here * after < 0:
            a, b = abs(cross(direction, p)), abs(cross(direction, q))
            if sign(dot(direction, p) * b + dot(direction, q) * a) > 0:
                return True
    return False
