"""Polygons that hold the cell of an ordered pair of wheels for every array of a box, under rule ``nearest``.

Wheel i is nearer to c than wheel k for some array of the box only where ::

    2 c . (p_k - p_i) - 4 t |c|_1  <=  |p_k|^2 - |p_i|^2 + 2 t (|p_k|_1 + |p_i|_1) + 2 t^2,

with t the tolerance of every coordinate.  In a quadrant ``|c|_1`` is linear, so that this is a half-plane there.  Its
numbers are rounded outward to rationals, and the polygons are exact.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb, fmpq

from nonsmooth.analysis.cells.polygon import HalfPlane, Polygon
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Wheel

Quadrant: TypeAlias = tuple[int, int]

QUADRANTS: tuple[Quadrant, ...] = ((1, 1), (-1, 1), (-1, -1), (1, -1))


@dataclass(frozen=True)
class OuterCell:
    """A part in one quadrant of what may be the cell of a pair.

    Attributes:
        first: place of the nearest wheel in the list.
        second: place of the next one.
        signs: of the coordinates in the quadrant.
        polygon: over the rationals.
    """

    first: int
    second: int
    signs: Quadrant
    polygon: Polygon


def lower_end(ball: arb) -> fmpq:
    """Of a ball, exactly."""
    return as_fmpq(rational_below(ball))


def upper_end(ball: arb) -> fmpq:
    """Of a ball, exactly."""
    return -lower_end(-ball)


def outer_cells(wheels: Sequence[Wheel], radius: fmpq, step: arb) -> Iterator[OuterCell]:
    """All pairs that may carry somewhere in the square of half-width ``radius`` about the origin.

    Args:
        wheels: of a centred scene.
        radius: half-width of the square.
        step: tolerance of every coordinate of every wheel.
    """
    near = _among_the_nearest(wheels, radius, step)
    for signs in QUADRANTS:
        nearer = {(i, k): _nearer(wheels[i], wheels[k], step, signs) for i in near for k in near if i != k}
        for i in near:
            cell = _clipped(_quadrant(radius, signs), [nearer[i, k] for k in near if k != i])
            for j in near if cell is not None else ():
                if j != i:
                    pair = _clipped(cell, [nearer[j, k] for k in near if k not in (i, j)])
                    if pair is not None:
                        yield OuterCell(i, j, signs, pair)


def _clipped(polygon: Polygon | None, half_planes: Sequence[HalfPlane]) -> Polygon | None:
    for half_plane in half_planes:
        if polygon is None:
            return None
        polygon = polygon.clipped(half_plane)
    return polygon


def _quadrant(radius: fmpq, signs: Quadrant) -> Polygon:
    """The part of the square, counterclockwise."""
    sx, sy = signs
    zero = fmpq(0)
    corners = [(zero, zero), (sx * radius, zero), (sx * radius, sy * radius), (zero, sy * radius)]
    if sx * sy < 0:
        corners = [corners[0], *reversed(corners[1:])]
    sides = []
    for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
        normal = (by - ay, ax - bx)  # to the right of the side: outward
        sides.append(HalfPlane(normal, normal[0] * ax + normal[1] * ay))
    return Polygon(tuple(corners), tuple(sides))


def _nearer(near: Wheel, far: Wheel, step: arb, signs: Quadrant) -> HalfPlane:
    """Where one wheel may be nearer than another, in a quadrant."""
    near_place, far_place = ([entry.ball() for entry in wheel.position] for wheel in (near, far))
    normal = []
    for a, b, side in zip(near_place, far_place, signs, strict=True):
        entry = 2 * (b - a) - 4 * side * step
        normal.append(lower_end(entry) if side > 0 else upper_end(entry))
    (ax, ay), (bx, by) = near_place, far_place
    moved = 2 * step * (abs(ax) + abs(ay) + abs(bx) + abs(by)) + 2 * step * step
    return HalfPlane((normal[0], normal[1]), upper_end(bx * bx + by * by - ax * ax - ay * ay + moved))


def _among_the_nearest(wheels: Sequence[Wheel], radius: fmpq, step: arb) -> list[int]:
    """Places of the wheels that may be one of the two nearest somewhere in the square."""
    edge, reaches = arb(radius), []
    for wheel in wheels:
        sizes = [abs(entry.ball()) for entry in wheel.position]
        gaps = [max(size - edge - step, arb(0), key=float) for size in sizes]
        least = lower_end(gaps[0] * gaps[0] + gaps[1] * gaps[1])
        most = upper_end(sum(((size + edge + step) ** 2 for size in sizes), arb(0)))
        reaches.append((least, most))
    second = sorted(most for _, most in reaches)[1]
    return [k for k, (least, _) in enumerate(reaches) if least <= second]
