"""The rigid body on the array: its outline, its centre of mass and its heading at the checked pose.

A wheel carries the body iff it lies strictly under the outline.  Without a body every wheel of an array carries, at
every pose: the paper's idealization.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from nonsmooth.symbolic.mechanics.continuum import Disc, Footprint, PolygonShape
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.plane import Vector


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


@dataclass(frozen=True)
class BodyInertia:
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
    corners = outline.vertices
    return all(_turn(corners[k - 2], corners[k - 1], corner).sign() >= 0 for k, corner in enumerate(corners))


def _turn(p: Vector, q: Vector, r: Vector) -> Number:
    return (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0])
