"""The support polygon of an array, the convex hull of its wheels, and the square that a scene checks by default.

That square is a part of the array, whatever the unit of length: its half-width is ``s/n`` for the array's size s, the
larger extent along x or y, and the least whole n such that a square twice as wide about the point lies in the support
polygon.  So it is exact, and the same square in every unit; in a scene that states units it is shortened to two digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cmp_to_key
from itertools import pairwise

from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import lower_text
from nonsmooth.symbolic.numbers.plane import Vector, cross, minus

FEW = 64  # positions of which the hull is found exactly at once
DIRECTIONS = 32  # the farthest wheels in so many directions span a polygon; wheels well inside it are no corners
MARGIN = 2.0**-29  # relative to the coordinates: floats err by far less, so a wheel this deep inside is inside

SQUARES_THAT_FIT = 2  # a default square this many times as wide still lies in the support polygon
DIGITS = 2  # of a half-width that the program chooses in a scene with units
PARTS_WITHOUT_SUPPORT = 4  # n where the point is not inside the support polygon: that of the middle of a square array


def support_polygon(positions: Sequence[Vector]) -> list[Vector]:
    """Convex hull, counterclockwise, by Andrew's monotone chain with exact comparisons."""
    ordered = sorted(set(positions), key=cmp_to_key(_compare_points))

    def chain(points: Sequence[Vector]) -> list[Vector]:
        hull: list[Vector] = []
        for p in points:
            while len(hull) > 1 and cross(minus(hull[-1], hull[-2]), minus(p, hull[-1])).sign() <= 0:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return chain(ordered) + chain(ordered[::-1])


def outer_positions(positions: Sequence[Vector]) -> Sequence[Vector]:
    """The positions that may be corners: floats leave out those well inside a polygon of others."""
    if len(positions) <= FEW:
        return positions
    import numpy as np  # large arrays only: a small one is read in less time than NumPy takes to load

    places = np.array([[float(x), float(y)] for x, y in positions])
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    with np.errstate(over="ignore", invalid="ignore"):
        farthest = np.argmax(places @ np.array([np.cos(angles), np.sin(angles)]), axis=0)
        ring = places[list(dict.fromkeys(farthest.tolist()))]
        along = np.roll(ring, -1, axis=0) - ring
        offsets = places[:, None, :] - ring
        areas = along[:, 0] * offsets[..., 1] - along[:, 1] * offsets[..., 0]
        deep = (areas > MARGIN * np.square(np.abs(places).max())).all(axis=1)
    return [position for position, is_deep in zip(positions, deep.tolist(), strict=True) if not is_deep]


def default_radius(positions: Sequence[Vector], point: Vector) -> Number:
    """Half-width of the square about a point that is checked where a scene names none.

    Args:
        positions: of at least two wheels, at different places.
        point: the checked one.
    """
    corners = support_polygon(outer_positions(positions))
    size = max(extent(corners, 0), extent(corners, 1))
    return size / (_parts_of_size(corners, size, point) or PARTS_WITHOUT_SUPPORT)


def widest_square(positions: Sequence[Vector], point: Vector) -> Number | None:
    """Three digits of the half-width of the largest square about a point in the support polygon.

    None where the point is not strictly inside the polygon.
    """
    corners, widths = support_polygon(positions), list[Number]()
    for corner, following in pairwise([*corners, *corners[:1]]):
        e = minus(following, corner)
        widths.append(cross(e, minus(point, corner)) / (abs(e[0]) + abs(e[1])))
    if len(corners) < 3 or min(width.sign() for width in widths) <= 0:
        return None
    return widths[0].field.rational(min(Fraction(lower_text(width, DIGITS + 1)) for width in widths))


def chosen(radius: Number, units: Units) -> Number:
    """A half-width that the program chooses: in a scene with units its first two digits, so that it can be read."""
    return radius.field.rational(Fraction(lower_text(radius, DIGITS))) if units.length else radius


def _parts_of_size(corners: Sequence[Vector], size: Number, point: Vector) -> int | None:
    """The least n for the half-width ``size/n``; None where the point is not strictly inside the polygon.

    A square of half-width r about p lies on the inner side of a side ``e`` from a corner a where
    ``r (|e_x| + |e_y|) <= cross(e, p - a)``.  Nothing is divided: inverses are slow in large number fields.
    """
    parts = 1
    for corner, following in pairwise([*corners, corners[0]]):
        e = minus(following, corner)
        room = cross(e, minus(point, corner))
        if room.sign() <= 0:
            return None
        needed = SQUARES_THAT_FIT * size * (abs(e[0]) + abs(e[1]))
        if parts * room < needed:
            parts = _least_multiple(room, needed)
    return parts


def _least_multiple(step: Number, value: Number) -> int:
    """The least whole n with ``n step >= value``, for a positive step."""
    low, high = 0, 1
    while high * step < value:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if middle * step < value else (low, middle)
    return high


def extent(points: Sequence[Vector], axis: int) -> Number:
    """Largest difference of the coordinates along one axis."""
    coordinates = [point[axis] for point in points]
    return max(coordinates) - min(coordinates)


def _compare_points(p: Vector, q: Vector) -> int:
    return sign(p[0] - q[0]) or sign(p[1] - q[1])
