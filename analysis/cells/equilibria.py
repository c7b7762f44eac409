"""All equilibria of the checked square: points with zero velocity in F, exactly.

With exact kinematics ``c' = v + omega J c`` a point is an equilibrium of the translation

- inside a cell, where the cell rests (an area) or turns about the point (its instant centre ``c = J v/omega``);
- on a common side of two cells, where their velocities oppose each other: parallel (linear in the position along
  the side, because both turning terms point the same way) with a product that is not positive;
- at a vertex, where the convex hull of the velocities that meet there holds zero;
- where two motions tie in a cell (mu_R = mu_S), along the line on which these two oppose each other.

Areas and segments of equilibria are reported as such, points once.

The square cuts the plane only to end the search: at its border F is the hull of all cells of the plane whose closure
holds the point, those beyond the square too.  So each side is looked at in a partition of a narrow strip about it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import combinations, pairwise, product
from typing import Any

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import around, between, cross, dot, hull_holds_zero, minus, side_of


class EquilibriumPlace(StrEnum):
    """Where an equilibrium lies."""

    AREA = "rest area"
    CENTRE = "instant centre"
    SIDE = "side"
    SEGMENT = "segment"
    VERTEX = "vertex"


@dataclass(frozen=True, repr=False)
class RestPlace(ShortRepr):
    """A point, segment or polygon of equilibria: its points, and the cells that meet there."""

    place: EquilibriumPlace
    points: tuple[Point, ...]
    cells: tuple[int, ...]


def find_equilibria(partition: Partition, strips: Sequence[Partition] | None = None) -> tuple[RestPlace, ...]:
    """Every equilibrium of the square, areas first.

    Args:
        partition: of the closed square.
        strips: the same array's about each side, in their order; without them cells beyond the border do not count.
    """
    found = _find_inside(partition)
    return found if strips is None else (*found, *_on_border(partition, found, map(_find_inside, strips)))


def _on_border(
    partition: Partition, known: Sequence[RestPlace], beside: Iterable[Sequence[RestPlace]]
) -> Iterator[RestPlace]:
    """Equilibria on the border of the square that the cells inside do not show, in parts of those beside each side."""
    seen = list(known)
    for (start, end), places in zip(around(partition.domain.vertices), beside, strict=True):
        for place in places:
            met = _met(place.points, start, end)
            if met and not all(any(_holds(cell, point) for cell in seen) for point in (*met, _middle(met))):
                kind = EquilibriumPlace.SEGMENT if len(met) > 1 else place.place
                kind = EquilibriumPlace.VERTEX if len(met) < min(len(place.points), 2) else kind
                cells = tuple(cell.index for cell in partition.cells_at(_middle(met)))
                seen.append(RestPlace(kind, met, cells))
                yield seen[-1]


def _met(points: Sequence[Point], start: Point, end: Point) -> tuple[Point, ...]:
    """Where a segment meets a point, a segment or a convex polygon: nowhere, at a point, or between two."""
    along = minus(end, start)
    heights = [cross(along, minus(point, start)) for point in points]
    reached = _zeros_on_boundary(points, heights)
    if not reached:
        return ()
    length = dot(along, along)
    shares = [dot(along, minus(point, start)) / length for point in reached]
    low, high = max(min(shares), shares[0] * 0), min(max(shares), shares[0] * 0 + 1)
    if sign(high - low) < 0:
        return ()
    ends = (between(start, end, low), between(start, end, high))
    return ends if sign(high - low) else ends[:1]


def _middle(points: Sequence[Point]) -> Point:
    return points[0] if len(points) == 1 else between(points[0], points[1], Fraction(1, 2))


def _holds(place: RestPlace, point: Point) -> bool:
    """Whether a point, a segment, or a closed polygon with its corners counterclockwise holds a point."""
    if place.place is not EquilibriumPlace.AREA:
        return _covers(place, point)
    return side_of(place.points, point) >= 0


def _find_inside(partition: Partition) -> tuple[RestPlace, ...]:
    """Every equilibrium that the cells of a partition show, areas first."""
    areas = [RestPlace(EquilibriumPlace.AREA, c.polygon.vertices, (c.index,)) for c in partition.cells if c.rests]
    found = [*areas, *_centres(partition), *_ties(partition)]
    for side in shared_sides(partition):
        found += _on_side(side)
    resting = {cell for area in areas for cell in area.cells}
    for corner in partition.complex.corners:
        cells = [partition.cells[k] for k in corner.cells]
        if resting & {cell.index for cell in cells}:
            continue
        rates = [twist.pose_rate(corner.point) for cell in cells for twist in cell.twists]
        if hull_holds_zero(rates) and not any(_covers(known, corner.point) for known in found):
            found.append(RestPlace(EquilibriumPlace.VERTEX, (corner.point,), tuple(cell.index for cell in cells)))
    return tuple(found)


@dataclass(frozen=True)
class SharedSide:
    """A segment of positive length that two cells have in common."""

    start: Point
    end: Point
    first: Cell
    second: Cell


def shared_sides(partition: Partition) -> Iterator[SharedSide]:
    """Common segments of all pairs of cells; also where a side of one meets several of the other."""
    plane = partition.complex
    for edge in plane.edges:
        if edge.left is not None and edge.right is not None:
            first, second = sorted((edge.left, edge.right))
            yield SharedSide(
                plane.points[edge.start], plane.points[edge.end], partition.cells[first], partition.cells[second]
            )


def _centres(partition: Partition) -> Iterator[RestPlace]:
    """Cells that turn about a point of their own."""
    for cell in partition.cells:
        turning = [twist for twist in cell.twists if twist.omega]
        centres = dict.fromkeys((-twist.vy / twist.omega, twist.vx / twist.omega) for twist in turning)
        for centre in centres:
            if all(sign(side.slack(centre)) > 0 for side in cell.polygon.sides):
                yield RestPlace(EquilibriumPlace.CENTRE, (centre,), (cell.index,))


def _ties(partition: Partition) -> Iterator[RestPlace]:
    """Equilibria of cells with several motions: ``f_1 x f_2`` is affine in c, so they lie on a line or everywhere."""
    for cell in partition.cells:
        if cell.rests:
            continue
        for a, b in combinations(cell.twists, 2):
            values = [_opposition(a, b, vertex) for vertex in cell.polygon.vertices]
            if not any(values):
                middle = cell.polygon.centre
                if sign(dot(a.pose_rate(middle), b.pose_rate(middle))) < 0:
                    yield RestPlace(EquilibriumPlace.AREA, cell.polygon.vertices, (cell.index,))
                continue
            ends = _zeros_on_boundary(cell.polygon.vertices, values)
            if len(ends) == 2:
                yield from _segments(a, b, SharedSide(ends[0], ends[1], cell, cell), (cell.index, cell.index))


def _zeros_on_boundary(corners: Sequence[Point], values: Sequence[Any]) -> list[Point]:
    """Boundary points where an affine function, given at the vertices, vanishes (two, unless it only touches)."""
    points: list[Point] = []
    for (p, here), (q, after) in around(list(zip(corners, values, strict=True))):
        if not here:
            points.append(p)
        elif sign(here) * sign(after) < 0:
            points.append(between(p, q, here / (here - after)))
    return points


def _on_side(side: SharedSide) -> Iterator[RestPlace]:
    """Equilibria in the open common segment of two cells."""
    if side.first.rests or side.second.rests:
        return
    cells = (side.first.index, side.second.index)
    for a, b in product(side.first.twists, side.second.twists):
        at_start, at_end = _opposition(a, b, side.start), _opposition(a, b, side.end)
        if not at_start and not at_end:
            yield from _segments(a, b, side, cells)
        elif sign(at_start) * sign(at_end) < 0:
            t = at_start / (at_start - at_end)
            point = between(side.start, side.end, t)
            if sign(dot(a.pose_rate(point), b.pose_rate(point))) <= 0:
                yield RestPlace(EquilibriumPlace.SIDE, (point,), cells)


def _opposition(a: Twist, b: Twist, point: Point) -> Any:
    """Zero where the two velocities are parallel; linear along a side."""
    return cross(a.pose_rate(point), b.pose_rate(point))


def _segments(a: Twist, b: Twist, side: SharedSide, cells: tuple[int, int]) -> Iterator[RestPlace]:
    """Parts of a side with parallel velocities on which these oppose each other, and a point where both vanish at once.

    Velocities that differ lie along one line there, so each changes sign at most once along the side: the zeros of the
    two split the side into pieces of constant sign.  Where both change it together, as where one twist turns on both
    sides about a point between them, no piece beside the zero is of equilibria, and it is one.
    """
    breaks: list[Any] = []
    for twist in (a, b):
        before, after = twist.pose_rate(side.start), twist.pose_rate(side.end)
        change = minus(after, before)
        if any(change):
            t = -dot(before, change) / dot(change, change)
            if sign(t) > 0 and sign(t - 1) < 0:
                breaks.append(t)
    zero = side.start[0] - side.start[0]
    marks = sorted([zero, zero + 1, *breaks])
    opposed = False
    for lower, upper in pairwise(marks):
        middle = between(side.start, side.end, (lower + upper) / 2)
        if sign(upper - lower) > 0 and sign(dot(a.pose_rate(middle), b.pose_rate(middle))) <= 0:
            opposed = True
            ends = between(side.start, side.end, lower), between(side.start, side.end, upper)
            yield RestPlace(EquilibriumPlace.SEGMENT, ends, cells)
    if breaks and not opposed:
        point = between(side.start, side.end, breaks[0])
        if not any(a.pose_rate(point)):
            yield RestPlace(EquilibriumPlace.SIDE, (point,), cells)


def _covers(known: RestPlace, point: Point) -> bool:
    """Whether a known segment (or point) holds the point."""
    first, last = known.points[0], known.points[-1]
    if known.place is EquilibriumPlace.AREA:
        return False
    to_first = minus(point, first)
    to_last = minus(point, last)
    return not cross(to_first, to_last) and sign(dot(to_first, to_last)) <= 0
