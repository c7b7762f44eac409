"""What lies on the array: the body, its outline and heading, the polygon that supports it, and fields of force.

A wheel carries the body iff it lies strictly under the outline.  Without a body every wheel of an array carries, at
every pose: the paper's idealization.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, cmp_to_key
from typing import Any, NamedTuple, TypeAlias, TypeVar

from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import lower_text, short_text
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, minus

# ---- the continuous idealization of an array -----------------------------------------------------
#
# A force field under the whole object instead of a wheel here and there.
#
# Each point p of the object's footprint is pushed by a force per area along ``A (p - p_0)``, of constant size (speed
# given) or as large as that vector (speed None).  The kinds ``radial``, ``elliptic``, ``saddle`` and ``spiral`` of a
# scene's ``[field]`` are of this form; for others ``matrix`` is None.


@dataclass(frozen=True)
class Disc:
    """A disc about the centroid (length)."""

    radius: Number


@dataclass(frozen=True)
class PolygonShape:
    """A simple polygon: vertices counterclockwise, measured from the centroid; at heading zero, as given."""

    vertices: tuple[Vector, ...]
    name: str = "polygon"

    @property
    def is_centrally_symmetric(self) -> bool:
        """Whether half a turn maps it onto itself."""
        half, odd = divmod(len(self.vertices), 2)
        pairs = zip(self.vertices[:half], self.vertices[half:], strict=False)
        return not odd and all(a == -c and b == -d for (a, b), (c, d) in pairs)


Footprint: TypeAlias = Disc | PolygonShape


@dataclass(frozen=True)
class ContinuousField:
    """What an array is an approximation of.

    Attributes:
        kind: of the velocity field, as the scene names it.
        matrix: rows of A; None where the field is not linear in the position.
        speed: constant size of the field; None for ``|A (p - p_0)|``.
        centre: ``p_0`` (length).
    """

    kind: str
    matrix: tuple[Vector, Vector] | None
    speed: Number | None
    centre: Vector


# ---- bodies --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Body:
    """A convex outline with a centre of mass.

    Attributes:
        outline: about its centroid, in the body's own frame (length).
        centre: the centroid measured from the centre of mass, in the body's own frame (length).
        heading: cosine and sine of the angle of the body's frame at the checked pose, where theta = 0.
    """

    outline: Footprint
    centre: Vector
    heading: Vector

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        """Corners at the checked pose, counterclockwise, measured from the centre of mass; none of a disc."""
        if isinstance(self.outline, Disc):
            return ()
        x, y = self.centre
        return tuple(self._turned((a + x, b + y)) for a, b in self.outline.vertices)

    @cached_property
    def centroid(self) -> Vector:
        """The centroid at the checked pose, measured from the centre of mass."""
        return self._turned(self.centre)

    @property
    def is_balanced(self) -> bool:
        """Whether the centre of mass is the centroid."""
        return not any(self.centre)

    @property
    def is_round(self) -> bool:
        """Whether every heading is the same: a disc whose centre of mass is its centre."""
        return isinstance(self.outline, Disc) and self.is_balanced

    @property
    def words(self) -> str:
        """What it is, for people."""
        return outline_text(self.outline)

    def _turned(self, point: Vector) -> Vector:
        """A point of the body's frame in the directions of the world."""
        (x, y), (c, s) = point, self.heading
        return c * x - s * y, s * x + c * y


class BodyInertia(NamedTuple):
    """How heavy a body is, as far as that matters: loads are its weight, so its mass cancels.

    Attributes:
        gravity: g (length/time^2); per unit of weight the mass is ``1/g``.
        squared_radius: ``rho^2 = I/m``, the squared radius of gyration (length^2); None where it is not stated, and is
            that of a uniform plate of the outline, or of a disc as large as the array.
        centre_height: of the centre of mass above the wheels (length); None where it is not stated, and is 0.
        is_stated: whether the scene states a mass or an inertia, so that somebody asks for dynamics.
        mass: as stated (kg), for files of physics engines; None where it is not.
    """

    gravity: Number
    squared_radius: Number | None = None
    centre_height: Number | None = None
    is_stated: bool = False
    mass: Number | None = None


def outline_text(outline: Footprint) -> str:
    """An outline in words, with its sizes."""
    if isinstance(outline, Disc):
        return f"disc of radius {short_text(outline.radius)}"
    if outline.name == "rectangle":
        a, b = outline.vertices[2]
        return f"rectangle {short_text(2 * a)} x {short_text(2 * b)}"
    return f"polygon of {len(outline.vertices)} sides"


def is_convex(outline: PolygonShape) -> bool:
    """Whether a polygon given counterclockwise never turns right; corners of half a turn are allowed."""
    sides = [minus(end, start) for start, end in around(outline.vertices)]
    return all(cross(side, following).sign() >= 0 for side, following in around(sides))


# ---- the support polygon of an array -------------------------------------------------------------
#
# The convex hull of its wheels, and the square that a scene checks by default.
#
# That square is a part of the array, whatever the unit of length: its half-width is ``s/n`` for the array's size s, the
# larger extent along x or y, and the least whole n such that a square twice as wide about the point lies in the support
# polygon.  So it is exact, and the same square in every unit; in a scene that states units it is shortened to two
# digits.


FEW = 64  # positions of which the hull is found exactly at once
DIRECTIONS = 32  # the farthest wheels in so many directions span a polygon; wheels well inside it are no corners
MARGIN = 2.0**-29  # relative to the coordinates: floats err by far less, so a wheel this deep inside is inside

SQUARES_THAT_FIT = 2  # a default square this many times as wide still lies in the support polygon
DIGITS = 2  # of a half-width that the program chooses in a scene with units
PARTS_WITHOUT_SUPPORT = 4  # n where the point is not inside the support polygon: that of the middle of a square array


P = TypeVar("P", bound=tuple[Any, Any])


def support_polygon(positions: Sequence[P]) -> list[P]:
    """Convex hull, counterclockwise, by Andrew's monotone chain; comparisons are exact for exact numbers."""
    ordered = sorted(set(positions), key=cmp_to_key(_compare_points))

    def chain(points: Sequence[P]) -> list[P]:
        hull: list[P] = []
        for p in points:
            while len(hull) > 1 and sign(cross(minus(hull[-1], hull[-2]), minus(p, hull[-2]))) <= 0:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return chain(ordered) + chain(ordered[::-1])


def outer_positions(positions: Sequence[P]) -> Sequence[P]:
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
    corners = support_polygon(positions)
    widths = square_rooms(corners, point)
    if len(corners) < 3 or min(width.sign() for width in widths) <= 0:
        return None
    return widths[0].field.rational(min(Fraction(lower_text(width, DIGITS + 1)) for width in widths))


def square_rooms(corners: Sequence[Vector], point: Vector) -> list[Number]:
    """Half-widths to which a square about a point reaches each side of a convex polygon; negative outside a side."""
    rooms = []
    for corner, following in around(corners):
        x, y = minus(following, corner)
        rooms.append(cross((x, y), minus(point, corner)) / (abs(x) + abs(y)))
    return rooms


def chosen(radius: Number, units: Units) -> Number:
    """A half-width that the program chooses: in a scene with units its first two digits, so that it can be read."""
    return radius.field.rational(Fraction(lower_text(radius, DIGITS))) if units.length else radius


def _parts_of_size(corners: Sequence[Vector], size: Number, point: Vector) -> int | None:
    """The least n for the half-width ``size/n``; None where the point is not strictly inside the polygon.

    A square of half-width r about p lies on the inner side of a side ``e`` from a corner a where
    ``r (|e_x| + |e_y|) <= cross(e, p - a)``.  Nothing is divided: inverses are slow in large number fields.
    """
    parts = 1
    for corner, following in around(corners):
        e = minus(following, corner)
        room = cross(e, minus(point, corner))
        if room.sign() <= 0:
            return None
        needed = SQUARES_THAT_FIT * size * (abs(e[0]) + abs(e[1]))
        if parts * room < needed:
            parts = _least_multiple(room, needed)
    return parts


def _least_multiple(step: Number, value: Number) -> int:
    """The least whole n with ``n step >= value``, for a positive step; it may be longer than ``bisect`` takes."""
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


def _compare_points(p: tuple[Any, Any], q: tuple[Any, Any]) -> int:
    return sign(p[0] - q[0]) or sign(p[1] - q[1])
