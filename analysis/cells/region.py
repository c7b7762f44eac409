"""Convex regions of the plane, bounded or not, in homogeneous coordinates: cells on which a system is smooth.

A region is the part ``w = 1`` of the cone of its generators ``(x, y, w)``, ``w >= 0``, in counterclockwise order:
``w > 0`` is the point ``(x/w, y/w)``, ``w = 0`` a direction in which the region is unbounded.  So polygons and cones
are one thing, and clipping needs no division for the directions.  A region that a curved surface bounds
also has *guards*: it is the closure of the part where all of them are positive.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.symbolic.mechanics.contact_states import cross_product
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators

Triple: TypeAlias = tuple[Any, Any, Any]
Segment: TypeAlias = tuple[Triple, Triple]


@dataclass(frozen=True)
class Region:
    """A closed convex region of positive area that holds no whole line (a half-plane is two regions).

    Attributes:
        generators: ``(x, y, w)``, counterclockwise.
        guards: polynomials in (x, y) that are positive inside.
    """

    generators: tuple[Triple, ...]
    guards: tuple[Polynomial, ...] = ()

    @cached_property
    def sides(self) -> tuple[Triple, ...]:
        """Linear functionals ``(a, b, c)``, one per side from generator k to k + 1, with ``a x + b y + c w >= 0``."""
        return tuple(cross_product(g, h) for g, h in self._pairs())

    def _pairs(self) -> Iterator[Segment]:
        return pairwise([*self.generators, self.generators[0]])

    @property
    def edges(self) -> Iterator[Segment]:
        """Sides that lie in the plane, as pairs of generators."""
        return ((g, h) for g, h in self._pairs() if g[2] or h[2])

    def contains(self, point: Point) -> bool:
        """Whether the closed region holds the point; on a curved side, whether no guard is negative there."""
        inside = all(sign(a * point[0] + b * point[1] + c) >= 0 for a, b, c in self.sides)
        return inside and all(sign(guard(point)) >= 0 for guard in self.guards)

    @property
    def inner_point(self) -> Point:
        """A point of the interior (of the convex region; guards are not looked at)."""
        return affine(sum(column) for column in zip(*self.generators, strict=True))

    def reach(self, x: Any, y: Any) -> Any:
        """A factor s > 0 with ``s (x, y)`` in the region, for a direction in which it has points; 1 if possible."""
        low, high = x - x, None
        for a, b, c in self.sides:
            slope = a * x + b * y
            if sign(slope) > 0:
                low = max(low, -c / slope)
            elif sign(slope) < 0:
                high = -c / slope if high is None else min(high, -c / slope)
        if high is None or not high < 1:
            return max(low, x - x + 1)
        return (low + high) / 2

    def clipped(self, line: Triple) -> Region | None:
        """The part with ``a x + b y + c w >= 0``; None when no area is left."""
        values = [line[0] * x + line[1] * y + line[2] * w for x, y, w in self.generators]
        signs = [sign(value) for value in values]
        if min(signs) >= 0:
            return self
        if max(signs) <= 0:
            return None
        kept: list[Triple] = []
        for k, generator in enumerate(self.generators):
            after = (k + 1) % len(signs)
            if signs[k] >= 0:
                kept.append(generator)
            if signs[k] * signs[after] < 0:
                kept.append(_between(generator, self.generators[after], abs(values[after]), abs(values[k])))
        return replace(self, generators=tuple(kept))

    def split(self, surface: Polynomial) -> Iterator[Region]:
        """The two sides of ``surface = 0``: cut where it is a line, guarded where it is a curve."""
        for part in (surface, -surface):
            if surface.degree > 1:
                yield replace(self, guards=(*self.guards, part))
            else:
                piece = self.clipped(line_of(part))
                if piece is not None:
                    yield piece

    def sign_of(self, surface: Polynomial) -> int | None:
        """Sign of a polynomial inside, where the generators or a guard show it."""
        if surface.degree > 1:
            for guarded, side in ((surface, 1), (-surface, -1)):
                if any(guard.terms == guarded.terms for guard in self.guards):
                    return side
            return self._sign_by_coefficients(surface)
        a, b, c = line_of(surface)
        signs = {sign(a * x + b * y + c * w) for x, y, w in self.generators}
        return None if {1, -1} <= signs else max(signs, key=abs)

    def _sign_by_coefficients(self, surface: Polynomial) -> int | None:
        """The sign that all coefficients in the generators of the region's triangles share, if they do."""
        form, first = surface.homogenized().terms, self.generators[0]
        triangles = ([first, g, h] for g, h in pairwise(self.generators[1:]))
        signs = {sign(c) for triangle in triangles for c in in_generators(form, triangle).values()}
        return signs.pop() if len(signs) == 1 else None


def line_of(surface: Polynomial) -> Triple:
    """Coefficients ``(a, b, c)`` of ``a x + b y + c``."""
    zero = surface.field.zero
    a, b, c = (surface.terms.get(e, zero) for e in ((1, 0), (0, 1), (0, 0)))
    return a, b, c


def cone_region(start: Point, end: Point) -> Region:
    """The cone counterclockwise from one ray to another, of less than a half turn.

    Raises:
        ValueError: for any other angle.
    """
    if sign(cross(start, end)) <= 0:
        raise ValueError("required a cone of angle between zero and a half turn")
    zero = start[0] - start[0]
    return Region(((zero, zero, zero + 1), (*start, zero), (*end, zero)))


def polygon_region(polygon: Polygon) -> Region:
    """A convex polygon."""
    zero = polygon.vertices[0][0] - polygon.vertices[0][0]
    return Region(tuple((x, y, zero + 1) for x, y in polygon.vertices))


def quadrants(one: Any) -> tuple[Region, ...]:
    """The plane, as its four quadrants."""
    zero = one - one
    rays = [(one, zero), (zero, one), (-one, zero), (zero, -one)]
    return tuple(cone_region(a, b) for a, b in pairwise([*rays, rays[0]]))


def common_edges(first: Region, second: Region) -> Iterator[Segment]:
    """The parts of sides along which two regions with disjoint interiors meet."""
    for edge in first.edges:
        segment: Segment | None = edge
        for line in second.sides:
            segment = None if segment is None else _clipped_segment(segment, line)
        if segment is not None and (segment[0][2] or segment[1][2]):
            yield segment


def _clipped_segment(segment: Segment, line: Triple) -> Segment | None:
    """The part with ``line >= 0``; None where that is a point or nothing."""
    values = [line[0] * x + line[1] * y + line[2] * w for x, y, w in segment]
    signs = [sign(value) for value in values]
    if max(signs) <= 0 and min(signs) < 0:
        return None
    if min(signs) >= 0:
        return segment
    middle = _between(segment[0], segment[1], abs(values[1]), abs(values[0]))
    return (segment[0], middle) if signs[0] > 0 else (middle, segment[1])


def _between(g: Triple, h: Triple, alpha: Any, beta: Any) -> Triple:
    """``alpha g + beta h``, as a point where it is one."""
    x, y, w = (alpha * a + beta * b for a, b in zip(g, h, strict=True))
    return (x / w, y / w, w / w) if w else (x, y, w)


def affine(generator: Iterable[Any]) -> tuple[Any, Any]:
    """The point ``(x/w, y/w)``."""
    x, y, w = generator
    return x / w, y / w


def on_edge(edge: Segment, t: Any) -> tuple[Any, Any]:
    """The point of the edge ``g + t h``."""
    return affine(a + b * t for a, b in zip(*edge, strict=True))
