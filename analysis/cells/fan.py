"""The fan of cones at a point: the cells whose closure holds it, each by two rays and its motions about the point.

Paths see a fan by the edges that meet at the point, because they must know which edge a ray is and how far it reaches
(:mod:`nonsmooth.analysis.trajectories.slides`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cmp_to_key
from typing import TYPE_CHECKING, TypeVar

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import around, cross, dot, same_direction, turned

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Cell, Partition

S = TypeVar("S", bound="Wedge")


@dataclass(frozen=True)
class Wedge:
    """The part of a cell near the point: counterclockwise from ray ``start`` to ray ``end``.

    Attributes:
        start: first ray.
        end: last ray.
    """

    start: Point
    end: Point

    @property
    def inner(self) -> Point:
        """A ray between both of a wedge of less than a half turn."""
        return self.start[0] + self.end[0], self.start[1] + self.end[1]

    @property
    def inward_normals(self) -> tuple[Point, ...]:
        """Of the sides along both rays; none where the cone is the plane."""
        x, y = turned(self.end)
        return () if is_plane(self) else (turned(self.start), (-x, -y))

    def holds(self, vector: Point) -> bool:
        """Whether a nonzero vector points into the closed cone (of angle at most a half turn)."""
        if not cross(self.start, self.end):  # half-plane
            return sign(cross(self.start, vector)) >= 0
        return sign(cross(self.start, vector)) >= 0 and sign(cross(vector, self.end)) >= 0


@dataclass(frozen=True)
class Cone(Wedge):
    """A wedge with the motions that act there.

    Attributes:
        twists: the motions.
    """

    twists: tuple[Twist, ...]

    def bends_out(self, twist: Twist) -> bool:
        """Whether a velocity points away from the point along a ray, and omega bends the path out of the cone there."""
        turn, velocity = sign(twist.omega), twist.velocity
        return any(turn == sense and same_direction(ray, velocity) for ray, sense in ((self.start, -1), (self.end, 1)))


@dataclass(frozen=True)
class CellCone(Cone):
    """The cone of a cell of an array."""

    cell: Cell


def build_fan(partition: Partition) -> tuple[CellCone, ...]:
    """The cones of the cells whose closure holds the origin, counterclockwise."""
    zero = partition.scene.field.zero
    cones = [_cone(cell) for cell in partition.cells_at((zero, zero))]
    cones.sort(key=lambda cone: by_angle(cone.start))
    if len(cones) == 1:
        return tuple(cones)
    # neighbours share one vector per ray, so that gains multiply to the gain of a full turn
    return tuple(replace(cone, end=following.start) for cone, following in around(cones))


def _cone(cell: Cell) -> CellCone:
    """The cone of a cell at the origin, from its vertices."""
    vertices = cell.polygon.vertices
    count = len(vertices)
    for k, vertex in enumerate(vertices):
        if not any(vertex):
            return CellCone(vertices[(k + 1) % count], vertices[k - 1], cell.twists, cell)
    for k, vertex in enumerate(vertices):
        after = vertices[(k + 1) % count]
        if not cross(vertex, after) and sign(dot(vertex, after)) < 0:
            return CellCone(after, vertex, cell.twists, cell)
    return CellCone(vertices[0], vertices[0], cell.twists, cell)  # the origin is inside: the cone is the plane


def _compare_angles(a: Point, b: Point) -> int:
    """Order by angle from the positive x axis, counterclockwise."""
    upper = [sign(p[1]) > 0 or (sign(p[1]) == 0 and sign(p[0]) > 0) for p in (a, b)]
    if upper[0] != upper[1]:
        return -1 if upper[0] else 1
    return -sign(cross(a, b))


by_angle = cmp_to_key(_compare_angles)  # key that sorts rays counterclockwise from the positive x axis


def is_plane(cone: Wedge) -> bool:
    """Whether the cone is the whole plane: the point lies inside its cell."""
    return cone.start is cone.end


def rays_of(fan: Sequence[S]) -> Iterator[tuple[Point, S, S]]:
    """Each ray with the cone before it and the cone after it (counterclockwise)."""
    if len(fan) == 1:
        return
    for k, cone in enumerate(fan):
        yield cone.start, fan[k - 1], cone
