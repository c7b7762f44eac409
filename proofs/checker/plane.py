"""Polygons in the plane with exact corners: chains that go around once, convex hulls, discs that they hold."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

from .tower import Number, Vector, cross, dot


def around(values: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Neighbours in a closed chain."""
    return list(pairwise([*values, values[0]]))


def turns_once(steps: Iterable[tuple[Vector, Vector]]) -> bool:
    """Whether counterclockwise steps, each of less than a half turn, that return to their start go around once.

    They do iff they pass from the lower half plane into the upper one exactly once.
    """
    entries = 0
    for step in steps:
        before, after = ((v[1].sign() or v[0].sign()) > 0 for v in step)
        entries += after > before
    return entries == 1


def convex_hull(places: Sequence[Vector]) -> list[Vector]:
    """The corners of the convex hull of plane points, counterclockwise (Andrew's monotone chain)."""
    ordered = sorted(places, key=cmp_to_key(_compare_places))
    if len(ordered) < 3:
        return ordered
    return [*_half_hull(ordered), *_half_hull(ordered[::-1])]


def _compare_places(a: Vector, b: Vector) -> int:
    return (a[0] - b[0]).sign() or (a[1] - b[1]).sign()


def _half_hull(ordered: Sequence[Vector]) -> list[Vector]:
    """The corners below the line from the first point to the last, without the last one."""
    chain: list[Vector] = []
    for place in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], place) <= 0:
            chain.pop()
        chain.append(place)
    return chain[:-1]


def _turn(a: Vector, b: Vector, c: Vector) -> int:
    """Sign of the turn from a over b to c, positive to the left."""
    return cross((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])).sign()


def holds_disc(hull: Sequence[Vector], squared_radius: Number) -> bool:
    """Whether a disc about the origin lies in a convex polygon: left of each side, no nearer than its radius."""
    for a, b in around(hull):
        step = (b[0] - a[0], b[1] - a[1])
        reach = cross(a, b)  # the distance of the side times its length
        if reach.sign() <= 0 or (reach * reach - squared_radius * dot(step, step)).sign() < 0:
            return False
    return len(hull) > 2
