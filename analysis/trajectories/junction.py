"""The fan at a point of an edge or at a corner: the cells that meet there and the rays between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import dot

# Relative to the largest speed in the domain: directions and velocities err by a few 2^-53, so a smaller normal
# speed is a tangent one.
SPEED_SLACK = 2.0**-45


class Ray(NamedTuple):
    """An edge seen from a point on it: direction away from the point, cells beside it, distance to its end."""

    edge: int
    direction: Point
    left: int
    right: int
    reach: Any
    corner: int


@dataclass(frozen=True)
class Junction:
    """A point on an edge or at a corner with its fan.

    Attributes:
        cells: each closed cell at the point, with the sides it is active on and whether they border the domain.
    """

    point: Point
    cells: tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]
    rays: tuple[Ray, ...]
    border: bool


class Signs:
    """Signs of speeds: exact for exact numbers, zero within rounding for floats."""

    def __init__(self, field: ConstantField) -> None:
        exact = field.exact
        self.speed_slack = 0.0 if exact else SPEED_SLACK * field.speed_scale
        self.turn_slack = 0.0 if exact else SPEED_SLACK * field.turn_scale
        self.rate_slack = 0.0 if exact else SPEED_SLACK * field.rate_scale
        self.product_slack = self.speed_slack * field.speed_scale
        self.bend_slack = self.turn_slack * field.speed_scale

    def __call__(self, value: Any, slack: float) -> int:
        """Sign of a value, zero within a slack that is zero for exact numbers."""
        return 0 if slack and abs(value) <= slack else sign(value)

    def first(self, speed: Any, change: Any, change_slack: float) -> int:
        """Sign of a speed just ahead: its own, or that of its change."""
        return self(speed, self.speed_slack) or self(change, change_slack)


def junction_at(field: ConstantField, place: OnEdge | AtCorner, point: Point) -> Junction:
    """The fan at a point of an edge or at a corner."""
    cells = field.cells
    own: tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]
    if isinstance(place, OnEdge):
        edge = cells.edges[place.edge]
        own = tuple((cell, ((cells.side_of(cell, place.edge), len(edge.cells) < 2),)) for cell in edge.cells)
        rays = tuple(_rays(field, place.edge, point, (edge.end, edge.start)))
        return Junction(point, own, rays, len(edge.cells) < 2)
    corner = cells.corners[place.corner]
    own = tuple(
        (cell, tuple((k, _is_border(field, cell, k)) for k in cells.active_sides(cell, place.corner)))
        for cell in corner.cells
    )
    fan = [
        ray
        for number in corner.edges
        for ray in _rays(field, number, point, (cells.edges[number].start, cells.edges[number].end), place.corner)
    ]
    border = any(len(cells.edges[number].cells) < 2 for number in corner.edges)
    return Junction(point, own, tuple(fan), border)


def _is_border(field: ConstantField, cell: int, side: int) -> bool:
    return all(len(field.cells.edges[e].cells) < 2 for e in field.cells.borders[cell][side])


def _rays(
    field: ConstantField, number: int, point: Point, ends: tuple[int, int], source: int | None = None
) -> Iterator[Ray]:
    """The edge towards each of its corners other than the source; edges on the border of the domain have none."""
    edge, (x, y) = field.cells.edges[number], point
    if edge.left is None or edge.right is None:
        return
    r = field.cells.direction(number)
    for corner in ends:
        if corner == source:
            continue
        forward = corner == edge.end
        direction = r if forward else (-r[0], -r[1])
        beside = (edge.left, edge.right) if forward else (edge.right, edge.left)
        px, py = field.cells.points[corner]
        reach = dot(direction, (px - x, py - y)) / dot(direction, direction)
        yield Ray(number, direction, *beside, reach, corner)
