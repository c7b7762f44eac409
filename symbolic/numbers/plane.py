"""Vectors of the plane: products, the quarter turn, and whether zero lies in a convex hull.

Over exact numbers, floats and other numbers that know their sign; for float arrays with the coordinates last see
:mod:`nonsmooth.symbolic.numbers.plane_arrays`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

from nonsmooth.symbolic.numbers.number import Number, sign

Vector: TypeAlias = tuple[Number, Number]
XY: TypeAlias = tuple[float, float]
Pose: TypeAlias = tuple[float, float, float]  # x, y, theta (radian)


E = TypeVar("E", bound=Any)  # a coordinate
T = TypeVar("T")


def in_floats(point: Any) -> XY:
    """A point, or a vector, of exact numbers or in an array, as one of floats."""
    return float(point[0]), float(point[1])


def pose_in_floats(state: Iterable[Any]) -> Pose:
    """``(x, y, theta)`` of exact numbers as floats."""
    x, y, theta = map(float, state)
    return x, y, theta


def turned(vector: tuple[E, E]) -> tuple[E, E]:
    """``J vector``: a quarter turn counterclockwise, ``J = [[0, -1], [1, 0]]``."""
    return -vector[1], vector[0]


def plus(a: Sequence[E], b: Sequence[E]) -> tuple[E, E]:
    """``a + b``."""
    return a[0] + b[0], a[1] + b[1]


def minus(a: Sequence[E], b: Sequence[E]) -> tuple[E, E]:
    """``a - b``."""
    return a[0] - b[0], a[1] - b[1]


def dot(a: Sequence[E], b: Sequence[E]) -> E:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Sequence[E], b: Sequence[E]) -> E:
    """``a_x b_y - a_y b_x``."""
    return a[0] * b[1] - a[1] * b[0]


def between(start: tuple[Any, Any], end: tuple[Any, Any], share: Any) -> tuple[Any, Any]:
    """The point after a share of the way from start to end."""
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def squared_distance(start: tuple[E, E], end: tuple[E, E]) -> E:
    """Squared distance of the origin from a segment."""
    along = minus(end, start)
    whole, ahead = dot(along, along), -dot(start, along)
    if sign(ahead) <= 0:
        return dot(start, start)
    if sign(ahead - whole) >= 0:
        return dot(end, end)
    area = cross(start, along)
    return area * area / whole


def around(items: Sequence[T]) -> list[tuple[T, T]]:
    """Each item with the next, the last with the first: the sides of a polygon from its vertices."""
    return list(zip(items, [*items[1:], *items[:1]], strict=True))


def side_of(corners: Sequence[tuple[Any, Any]], point: tuple[Any, Any]) -> int:
    """1 strictly inside a convex polygon, given counterclockwise, 0 on its border, -1 outside."""
    return min(sign(cross(minus(b, a), minus(point, a))) for a, b in around(corners))


def same_direction(a: Vector, b: Vector) -> bool:
    """Whether two nonzero vectors are positive multiples of each other."""
    return not cross(a, b) and sign(dot(a, b)) > 0


def hull_holds_zero(vectors: Sequence[tuple[Any, Any]]) -> bool:
    """Whether the convex hull of plane vectors holds zero: no open half-plane holds them all (none hold nothing)."""
    return bool(vectors) and separating_direction(vectors) is None


def separating_direction(vectors: Sequence[tuple[Any, Any]]) -> Vector | None:
    """A vector with a positive product against every vector; None where their convex hull holds zero.

    The cone of the vectors seen so far is kept by its first and last direction, as long as it is less than a half turn.
    With these, ``J first - J last`` serves.
    """
    if not all(any(v) for v in vectors):
        return None
    first = last = vectors[0]
    for v in vectors[1:]:
        from_first, from_last = sign(cross(first, v)), sign(cross(last, v))
        if from_first >= 0 >= from_last:
            if not from_first and not from_last and sign(dot(first, v)) < 0:
                return None  # opposite to a single direction
        elif from_first > 0:
            last = v
        elif from_last < 0:
            first = v
        else:
            return None  # opposite to the cone, or to one of its ends
    return minus(turned(first), turned(last)) if cross(first, last) else first
