"""The edges and cells that meet at a point of an edge or at a corner, and the signs by which paths decide there.

What motions do around the point is that of :mod:`nonsmooth.analysis.cells.moves`; here is added what a path must know
besides: which edge a ray is, how far it reaches, and where the domain ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.cells.moves import EXACT, Signs
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.symbolic.numbers.plane import dot, minus

# Relative to the largest speed in the domain: directions and velocities err by a few 2^-53, so a smaller normal
# speed is a tangent one.
SPEED_SLACK = 2.0**-45
# Relative: a gain nearer to one than this is not told from one; the series would need more than 1e12 turns.
GAIN_DOUBT = 1e-12


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


def signs_of(field: ConstantField) -> Signs:
    """Exact for a field of exact numbers; for floats, zero within their rounding."""
    if field.exact:
        return EXACT
    speed, turn, rate = (SPEED_SLACK * scale for scale in (field.speed_scale, field.turn_scale, field.rate_scale))
    return Signs(speed, turn, rate, speed * field.speed_scale, turn * field.speed_scale, GAIN_DOUBT)


def junction_at(field: ConstantField, place: OnEdge | AtCorner, point: Point) -> Junction:
    """The fan at a point of an edge or at a corner."""
    cells = field.cells
    own: tuple[tuple[int, tuple[tuple[int, bool], ...]], ...]
    if isinstance(place, OnEdge):
        edge = cells.edges[place.edge]
        own = tuple((cell, ((cells.side_of(cell, place.edge), len(edge.cells) < 2),)) for cell in edge.cells)
        return Junction(point, own, tuple(_rays(field, place.edge, point)), len(edge.cells) < 2)
    corner = cells.corners[place.corner]
    own = tuple(
        (cell, tuple((k, _is_border(field, cell, k)) for k in cells.active_sides(cell, place.corner)))
        for cell in corner.cells
    )
    rays = chain.from_iterable(_rays(field, number, point, place.corner) for number in corner.edges)
    border = any(len(cells.edges[number].cells) < 2 for number in corner.edges)
    return Junction(point, own, tuple(rays), border)


def _is_border(field: ConstantField, cell: int, side: int) -> bool:
    return all(len(field.cells.edges[e].cells) < 2 for e in field.cells.borders[cell][side])


def _rays(field: ConstantField, number: int, point: Point, source: int | None = None) -> Iterator[Ray]:
    """The edge towards each of its corners other than the source; edges on the border of the domain have none."""
    edge = field.cells.edges[number]
    if edge.left is None or edge.right is None:
        return
    r = field.cells.direction(number)
    for corner in (edge.end, edge.start):
        if corner == source:
            continue
        forward = corner == edge.end
        direction = r if forward else (-r[0], -r[1])
        beside = (edge.left, edge.right) if forward else (edge.right, edge.left)
        reach = dot(direction, minus(field.cells.points[corner], point)) / dot(direction, direction)
        yield Ray(number, direction, *beside, reach, corner)
