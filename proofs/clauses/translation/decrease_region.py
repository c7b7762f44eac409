"""The disc about the equilibrium on which V* of ``V = |c|^2`` is negative, or not positive.

On a closed cell V* is linear, so where it is not as required is a polygon; the disc ends at the nearest of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nonsmooth.analysis.cells.filippov import CellDerivative
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.symbolic.numbers.enclosures import rational_below, square_root
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import around, cross, dot, minus
from nonsmooth.symbolic.numbers.rounded import either_way


def region_radius(
    derivatives: Sequence[CellDerivative], *, strict: bool, within: Number, limit: Number | None = None
) -> Number:
    """Radius of the largest disc, up to the given one, on which V* < 0 (or <= 0); ``limit`` bounds its square too.

    A rational just below it where its exact form is out of reach.
    """
    nearest = squared_reach(derivatives, strict=strict, within=within)
    nearest = nearest if limit is None else min(nearest, limit)
    if nearest == within * within:
        return within
    root = square_root(nearest)
    return root if isinstance(root, Number) else within.field.rational(rational_below(root))


def squared_reach(derivatives: Sequence[CellDerivative], *, strict: bool, within: Number) -> Number:
    """Squared distance of the nearest violation from the equilibrium; the square of ``within`` where it is farther."""
    segments = [segment for d in derivatives for segment in _violating_segments(d, strict=strict)]
    with either_way(within.field):  # of ends that are as near any will do
        return min([within * within, *(squared_distance(*segment) for segment in segments)])


def _violating_segments(derivative: CellDerivative, *, strict: bool) -> Iterator[tuple[Point, Point]]:
    """Boundary segments of the part of the closed cell where V* is not as required (without the equilibrium)."""
    worst, _ = derivative.largest
    polygon = derivative.cell.polygon
    zero = worst.field.zero
    if worst.sign() < 0 or (not strict and not worst) or polygon.contains((zero, zero)):
        return
    vx, vy = derivative.twist.velocity
    part = polygon.clipped(HalfPlane((-vx, -vy), zero)) if vx or vy else polygon
    if part is None:  # V* vanishes on a side or at a vertex only
        flat = [p for p, rate in zip(polygon.vertices, derivative.rates, strict=True) if not rate]
        yield flat[0], flat[-1]
        return
    yield from around(part.vertices)


def squared_distance(start: Point, end: Point) -> Number:
    """Squared distance of the origin from a segment."""
    along = minus(end, start)
    length, shift = dot(along, along), -dot(start, along)
    if shift.sign() <= 0:
        return dot(start, start)
    if shift >= length:
        return dot(end, end)
    area = cross(start, along)
    return area * area / length
