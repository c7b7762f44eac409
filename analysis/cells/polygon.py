"""Convex polygons in the plane over any ordered field: exact with field numbers, fast with floats.

A polygon is kept in both forms, vertices (counterclockwise) and the half-plane behind each side, because
inequalities are proved on vertices and crossings are found on sides.  Clipping evaluates one sign per vertex
and intersects two lines per cut; with exact numbers every result is exact, and a polygon of zero area is None.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, Self, TypeAlias, TypeVar

from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.lazy import clear_sign, sure_float
from nonsmooth.symbolic.numbers.number import Tower, sign

Point: TypeAlias = tuple[Any, Any]


@dataclass(frozen=True)
class HalfPlane:
    """``normal . c <= offset``; ``label`` says where the line comes from (domain, bisector 1|2, ...)."""

    normal: Point
    offset: Any
    label: str = ""

    def slack(self, point: Point) -> Any:
        """``offset - normal . point``: positive inside, zero on the line."""
        return self.offset - (self.normal[0] * point[0] + self.normal[1] * point[1])

    def side(self, point: Point) -> int:
        """Sign of the slack: 1 inside, 0 on the line; floats decide where they are sure."""
        return self.sides([point])[0]

    def sides(self, points: Iterable[Point]) -> list[int]:
        """The same of several points."""
        offset, a, b = self._floats
        return [
            clear_sign(offset, -a * sure_float(x), -b * sure_float(y)) or sign(self.slack((x, y))) for x, y in points
        ]

    @cached_property
    def _floats(self) -> tuple[float, float, float]:
        return sure_float(self.offset), sure_float(self.normal[0]), sure_float(self.normal[1])


@dataclass(frozen=True, repr=False)
class Polygon(ShortRepr):
    """Convex polygon of positive area; side k runs from vertex k to vertex k + 1.

    Attributes:
        vertices: counterclockwise.
        sides: the half-plane of each side.
    """

    vertices: tuple[Point, ...]
    sides: tuple[HalfPlane, ...]

    @cached_property
    def area(self) -> Any:
        """Shoelace formula."""
        (x0, y0), total = self.vertices[0], 0
        for (x1, y1), (x2, y2) in zip(self.vertices[1:], self.vertices[2:], strict=False):
            total = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0) + total
        return total / 2

    @cached_property
    def centre(self) -> Point:
        """Mean of the vertices: an interior point."""
        n = len(self.vertices)
        return sum((x for x, _ in self.vertices)) / n, sum((y for _, y in self.vertices)) / n

    def over(self, field: Tower) -> Polygon:
        """The same polygon over another field; its numbers are rational."""

        def moved(point: Point) -> Point:
            x, y = point
            return field.rational(x.as_rational()), field.rational(y.as_rational())

        sides = (HalfPlane(moved(s.normal), field.rational(s.offset.as_rational()), s.label) for s in self.sides)
        return Polygon(tuple(map(moved, self.vertices)), tuple(sides))

    def contains(self, point: Point) -> bool:
        """Whether the closed polygon holds the point."""
        return all(side.side(point) >= 0 for side in self.sides)

    def clipped(self, half_plane: HalfPlane) -> Polygon | None:
        """Intersection with a closed half-plane; None when no area is left."""
        signs = half_plane.sides(self.vertices)
        if min(signs) >= 0:
            return self
        if max(signs) <= 0:
            return None
        return Polygon(
            *cut(signs, self.vertices, self.sides, half_plane, lambda crossed, _: intersection(crossed, half_plane))
        )


Corner = TypeVar("Corner")
Side = TypeVar("Side")


def cut(
    signs: Sequence[int],
    corners: Sequence[Corner],
    sides: Sequence[Side],
    line: Side,
    meeting: Callable[[Side, int], Corner],
) -> tuple[tuple[Corner, ...], tuple[Side, ...]]:
    """The corners and sides of the part of a convex polygon behind a line that crosses it.

    Args:
        signs: of the line's slack at the corners: 1 behind it, 0 on it.
        corners: counterclockwise.
        sides: each from its corner to the next.
        line: a side of what is left.
        meeting: the corner where a side crosses the line, from that and the sign where the side begins.
    """
    kept: list[Corner] = []
    bounding: list[Side] = []
    for k, here in enumerate(signs):
        after = signs[(k + 1) % len(signs)]
        if here >= 0:
            kept.append(corners[k])
            bounding.append(line if here == 0 and after < 0 else sides[k])
        if here * after < 0:
            kept.append(meeting(sides[k], here))
            bounding.append(line if here > 0 else sides[k])
    return tuple(kept), tuple(bounding)


def meeting(first: HalfPlane, second: HalfPlane) -> tuple[Any, Any, Any]:
    """``(w, x, y)``, where ``(x/w, y/w)`` is the common point of two boundary lines that are not parallel.

    ``w`` is positive where the second normal lies to the left of the first.
    """
    (a, b), (c, d) = first.normal, second.normal
    x = first.offset * d - b * second.offset
    y = a * second.offset - first.offset * c
    return a * d - b * c, x, y


def intersection(first: HalfPlane, second: HalfPlane) -> Point:
    """Common point of two boundary lines that are not parallel (Cramer's rule).

    Vertices are always computed from the lines themselves, never from other vertices, so exact numbers do not
    grow from clip to clip.
    """
    w, x, y = meeting(first, second)
    return x / w, y / w


def square(centre: Point, radius: Any) -> Polygon:
    """The square ``|x - x*|, |y - y*| <= radius``."""
    (x, y), r = centre, radius
    one = r / r
    zero = r - r
    sides = (
        HalfPlane((zero, -one), r - y, "domain"),
        HalfPlane((one, zero), x + r, "domain"),
        HalfPlane((zero, one), y + r, "domain"),
        HalfPlane((-one, zero), r - x, "domain"),
    )
    return Polygon(((x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)), sides)


def checked_square(scene: Scene) -> Polygon:
    """The square about its point that a scene asks about."""
    return square(scene.check.equilibrium, scene.check.radius)


def convex_polygon(corners: Sequence[Point]) -> Polygon:
    """The polygon of corners that turn left, counterclockwise; its sides are labelled as borders of a domain."""
    sides = []
    for k, (x, y) in enumerate(corners):
        after = corners[(k + 1) % len(corners)]
        outward = (after[1] - y, x - after[0])
        sides.append(HalfPlane(outward, outward[0] * x + outward[1] * y, "domain"))
    return Polygon(tuple(corners), tuple(sides))


def strips_about(square: Polygon, width: Any) -> list[Polygon]:
    """Rectangles about the sides of a square, in their order, that reach beyond them by a width, all around."""
    (x, y), _, (u, v), _ = square.vertices
    strips = [(x, y, u, y), (u, y, u, v), (x, v, u, v), (x, y, x, v)]
    return [
        convex_polygon([(a - width, b - width), (c + width, b - width), (c + width, d + width), (a - width, d + width)])
        for a, b, c, d in strips
    ]


class _Clipped(Protocol):
    def clipped(self, side: Any, /) -> Self | None: ...


Part = TypeVar("Part", bound=_Clipped)


def clipped_by(whole: Part, sides: Iterable[Any]) -> Part | None:
    """The part of a polygon, a region or an outline behind several sides; None where no area is left."""
    part = whole
    for side in sides:
        clipped = part.clipped(side)
        if clipped is None:
            return None
        part = clipped
    return part
