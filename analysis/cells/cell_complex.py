"""Corners, edges and cells of a polygonal partition: what a path can meet, each piece of it once.

Simulation needs more than polygons: which cells lie on the two sides of an edge, which edges leave a corner, and
where a side of one cell meets several of another.  These relations are found with exact numbers: floats only sort out
what is certainly apart.  :attr:`CellComplex.floats` keeps them and rounds the coordinates, so that the float form
inherits exact combinatorics.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon
from nonsmooth.symbolic.numbers import plane_arrays
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import XY, around, cross, dot, in_floats, minus
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, float_points, norm

# Relative to the size of the domain: corners farther apart as floats are different, nearer ones are compared exactly.
SAME_CORNER_DOUBT = 2.0**-29
# Length relative to the size of the domain: a float point comes from a handful of operations on coordinates of that
# size, so it lies within some 2^-49 of the line or corner that it was computed to reach; four bits are added.
PLACE_SLACK = 2.0**-45
SIDES_AT_ONCE = 64  # whose distances from all corners are held at once


class InCell(NamedTuple):
    """Inside a cell."""

    cell: int


class OnEdge(NamedTuple):
    """On an edge (also one on the border of the domain), away from its corners."""

    edge: int


class AtCorner(NamedTuple):
    """At a corner."""

    corner: int


Place: TypeAlias = InCell | OnEdge | AtCorner
Step: TypeAlias = tuple[int, int]  # from corner to corner


@dataclass(frozen=True)
class Edge:
    """A segment from corner ``start`` to corner ``end`` with a cell on each side (None beyond the domain)."""

    start: int
    end: int
    left: int | None
    right: int | None

    @property
    def cells(self) -> tuple[int, ...]:
        """The cells beside it."""
        return tuple(cell for cell in (self.left, self.right) if cell is not None)


@dataclass(frozen=True)
class Corner:
    """A point where edges end, with the cells whose closure holds it."""

    point: Point
    cells: tuple[int, ...]
    edges: tuple[int, ...]


@dataclass(frozen=True)
class CellComplex:
    """A polygonal partition with its incidences.

    Attributes:
        polygons: the cells, convex, with disjoint interiors.
        corners: every vertex of every cell, once.
        edges: the sides, cut at the corners.
        borders: ``borders[i][k]`` are the edges on side k of cell i, in the direction of the side.
        size: size of the domain (length), as it was given to :func:`build_complex`.
        slack: distance within which a point counts as on an edge or corner (length; zero for exact numbers).
    """

    polygons: tuple[Polygon, ...]
    corners: tuple[Corner, ...]
    edges: tuple[Edge, ...]
    borders: tuple[tuple[tuple[int, ...], ...], ...]
    size: float
    slack: float = 0.0

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """The corners' coordinates."""
        return tuple(corner.point for corner in self.corners)

    def direction(self, edge: int) -> Point:
        """From start to end; of unit length in floats, of any length in exact numbers (no square root)."""
        along = minus(self.points[self.edges[edge].end], self.points[self.edges[edge].start])
        if not self.slack:
            return along
        length = norm(along)
        return along[0] / length, along[1] / length

    def active_sides(self, cell: int, corner: int) -> tuple[int, ...]:
        """Sides of a cell that hold a corner."""
        return tuple(
            k
            for k, border in enumerate(self.borders[cell])
            if any(corner in (self.edges[e].start, self.edges[e].end) for e in border)
        )

    def side_of(self, cell: int, edge: int) -> int:
        """The side of a cell on which an edge lies."""
        return next(k for k, border in enumerate(self.borders[cell]) if edge in border)

    def locate(self, point: Point) -> Place | None:
        """Where a point lies; None outside the domain."""
        for k, corner in enumerate(self.points):
            if not self._apart(point, corner):
                return AtCorner(k)
        for k in range(len(self.edges)):
            if self.on_edge(k, point):
                return OnEdge(k)
        for k, polygon in enumerate(self.polygons):
            if all(sign(side.slack(point)) > 0 for side in polygon.sides):
                return InCell(k)
        return None

    def on_edge(self, edge: int, point: Point) -> bool:
        """Whether a point that is no corner lies on an edge."""
        r = self.direction(edge)
        start, end = (self.points[k] for k in (self.edges[edge].start, self.edges[edge].end))
        from_start, to_end = minus(point, start), minus(end, point)
        return not self.beyond(cross(r, from_start)) and sign(dot(r, from_start)) > 0 and sign(dot(r, to_end)) > 0

    def beyond(self, length: Any) -> int:
        """Sign of a length, zero within the slack."""
        if self.slack:
            return 0 if abs(length) <= self.slack else sign(length)
        return sign(length)

    def _apart(self, p: Point, q: Point) -> bool:
        return bool(self.beyond(p[0] - q[0]) or self.beyond(p[1] - q[1]))

    @cached_property
    def floats(self) -> CellComplex:
        """The same complex with float coordinates and sides of unit normals."""
        points = [(float(x), float(y)) for x, y in self.points]
        return replace(
            self,
            polygons=tuple(float_polygon(polygon) for polygon in self.polygons),
            corners=tuple(replace(c, point=p) for c, p in zip(self.corners, points, strict=True)),
            slack=PLACE_SLACK * self.size,
        )

    def in_unit(self, length: float) -> CellComplex:
        """The float form with another unit of length."""
        return replace(
            self,
            polygons=tuple(_polygon_in_unit(polygon, length) for polygon in self.polygons),
            corners=tuple(replace(corner, point=_point_in_unit(corner.point, length)) for corner in self.corners),
            size=self.size / length,
            slack=self.slack / length,
        )


def _point_in_unit(point: Point, length: float) -> Point:
    return point[0] / length, point[1] / length


def _polygon_in_unit(polygon: Polygon, length: float) -> Polygon:
    sides = tuple(replace(side, offset=side.offset / length) for side in polygon.sides)
    return Polygon(tuple(_point_in_unit(vertex, length) for vertex in polygon.vertices), sides)


def float_polygon(polygon: Polygon) -> Polygon:
    """The same with float coordinates and sides of unit normals."""
    sides = []
    for side in polygon.sides:
        a, b = in_floats(side.normal)
        length = float(np.hypot(a, b))
        sides.append(HalfPlane((a / length, b / length), float(side.offset) / length, side.label))
    return Polygon(tuple((float(x), float(y)) for x, y in polygon.vertices), tuple(sides))


def build_complex(polygons: Sequence[Polygon], size: float) -> CellComplex:
    """Find corners and edges of convex polygons with disjoint interiors, exactly.

    Args:
        polygons: cells over exact numbers (field elements, lazy numbers or fractions).
        size: size of the domain (length), for the float filter and the slack of the float form.
    """
    points, chains = _boundaries(polygons, size)
    beside: dict[Step, list[int | None]] = {}
    for cell, sides in enumerate(chains):
        for a, b in chain.from_iterable(sides):
            beside.setdefault((min(a, b), max(a, b)), [None, None])[0 if a < b else 1] = cell
    numbering = {key: k for k, key in enumerate(beside)}
    borders = tuple(tuple(tuple(numbering[min(s), max(s)] for s in side) for side in sides) for sides in chains)
    edges = tuple(Edge(a, b, *cells) for (a, b), cells in beside.items())
    leaving: list[list[int]] = [[] for _ in points]
    for k, edge in enumerate(edges):
        leaving[edge.start].append(k)
        leaving[edge.end].append(k)
    corners = tuple(
        Corner(point, tuple(sorted({cell for k in incident for cell in edges[k].cells})), tuple(incident))
        for point, incident in zip(points, leaving, strict=True)
    )
    return CellComplex(tuple(polygons), corners, edges, borders, size)


def tile(polygons: Sequence[Polygon], domain: Polygon, size: float) -> bool:
    """Whether counterclockwise polygons cover a domain once: their boundaries add up to its boundary.

    Sides of neighbours cancel piece by piece, and what is left is the domain's border.  Exact: no area, no quotient.
    """
    _, chains = _boundaries([*polygons, domain], size)
    total: Counter[Step] = Counter()
    for k, sides in enumerate(chains):
        weight = 1 if k < len(polygons) else -1
        for a, b in chain.from_iterable(sides):
            total[min(a, b), max(a, b)] += weight if a < b else -weight
    return not any(total.values())


def _boundaries(polygons: Sequence[Polygon], size: float) -> tuple[list[Point], list[list[list[Step]]]]:
    """Distinct corners, and for each side of each polygon its steps from corner to corner."""
    points, numbers = _corners(polygons, size)
    sides = [
        (first, last, side)
        for polygon, corners in zip(polygons, numbers, strict=True)
        for (first, last), side in zip(around(corners), polygon.sides, strict=True)
    ]
    stops = _stops(points, sides, size)
    return points, [[list(pairwise(next(stops))) for _ in corners] for corners in numbers]


def _corners(polygons: Sequence[Polygon], size: float) -> tuple[list[Point], list[list[int]]]:
    """Distinct vertices, and their numbers polygon by polygon."""
    points: list[Point] = []
    places = _Places(SAME_CORNER_DOUBT * size)
    numbers: list[list[int]] = []
    for polygon in polygons:
        numbered: list[int] = []
        for point in polygon.vertices:
            place = in_floats(point)
            close = places.close(place)
            known = next((k for k in close if points[k][0] == point[0] and points[k][1] == point[1]), None)
            if known is None:
                known = len(points)
                points.append(point)
                places.add(place)
            numbered.append(known)
        numbers.append(numbered)
    return points, numbers


class _Places:
    """Places in the plane in the order in which they come, sorted into squares so that those close by are soon found.

    Args:
        doubt: the largest difference of coordinates of places that are close.
    """

    def __init__(self, doubt: float) -> None:
        self._width = 2 * doubt
        self._squares: dict[Step | None, list[int]] = {None: []}  # None: beyond floats, close to all
        self._count = 0

    def add(self, place: XY) -> None:
        """One more, with the next number."""
        self._squares.setdefault(self._square(place), []).append(self._count)
        self._count += 1

    def close(self, place: XY) -> Iterator[int]:
        """The numbers of all that may be close to a place, and some others."""
        square = self._square(place)
        if square is None:
            return iter(range(self._count))
        around_it = ((square[0] + i, square[1] + j) for i in (0, -1, 1) for j in (0, -1, 1))
        return chain.from_iterable(self._squares.get(key, ()) for key in (*around_it, None))

    def _square(self, place: XY) -> Step | None:
        try:
            return math.floor(place[0] / self._width), math.floor(place[1] / self._width)
        except (ArithmeticError, ValueError):  # of infinite numbers, and where the width is zero
            return None


def _stops(points: Sequence[Point], sides: Sequence[tuple[int, int, HalfPlane]], size: float) -> Iterator[list[int]]:
    """For each side, from a corner to a corner: the corners on it, from its first one to its last."""
    places = float_points(points)
    for begin in range(0, len(sides), SIDES_AT_ONCE):
        some = sides[begin : begin + SIDES_AT_ONCE]
        close = _close(places, np.array([(first, last) for first, last, _ in some]), size)
        for (first, last, side), nearby in zip(some, close, strict=True):
            yield [first, *_between(points, first, last, side, nearby), last]


def _close(places: Floats, ends: Indices, size: float) -> list[list[int]]:
    """For each side from ``ends[k, 0]`` to ``ends[k, 1]`` the other corners that are not certainly elsewhere.

    Beyond the range of floats, where they are not numbers, nothing is.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        along = places[ends[:, 1]] - places[ends[:, 0]]
        offset = places - places[ends[:, 0], None]
        squared = plane_arrays.dot(along, along)[:, None]
        doubt = SAME_CORNER_DOUBT * size * (np.sqrt(squared) + size)
        beside, reach = plane_arrays.cross(along[:, None], offset), plane_arrays.dot(along[:, None], offset)
        elsewhere = (np.abs(beside) > doubt) | (reach < -doubt) | (reach > squared + doubt)
    np.put_along_axis(elsewhere, ends, True, axis=1)
    found: list[list[int]] = [[] for _ in ends]
    for side, corner in np.argwhere(~elsewhere).tolist():
        found[side].append(corner)
    return found


def _between(points: Sequence[Point], first: int, last: int, side: HalfPlane, close: Sequence[int]) -> list[int]:
    """Those of a few corners that lie between the ends of a side, in its direction."""
    if not close:
        return []
    start, end = points[first], points[last]
    r = minus(end, start)
    on = [
        k
        for k in close
        if not sign(side.slack(points[k]))
        and sign(dot(r, minus(points[k], start))) > 0
        and sign(dot(r, minus(end, points[k]))) > 0
    ]
    return sorted(on, key=lambda k: dot(r, points[k]))
