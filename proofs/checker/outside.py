"""What comes to the point from no start: all to the right of a line over which all velocities lead to the right.

*Theorem.*  Let P be a simple closed polygon with the point to its left: counterclockwise with the point inside, or
clockwise with the point outside; or a simple chain of sides between two half-lines, which parts the plane, with the
point to its left.  Let ``n . f > 0`` on each side and half-line, with its normal n to the right, for every field f of a
cell whose closure meets its inside; and at each corner for the normals of both sides and every cell whose closure holds
it.  Then no solution from a start on P or to its right is ever to its left: none comes to the point.

*Proof.*  Let a solution be on P or right of it first, and left of it at a later time s.  Let t be the last time before
s at which it is not left of P; then x(t) is on P, and from t to s the solution is left of it.  At x(t), inside of a
side or at a corner, all velocities of F have positive products with the normals of the sides that meet there; F is
upper semicontinuous, so for some d > 0 they are at least d near x(t), and ``n . (x(r) - x(t)) >= d (r - t)`` for r just
after t and each of these n.  Near the inside of a side the left of P is where ``n . (x - x(t)) < 0``.  Near a corner it
is where that holds for both of its sides, or, where P turns right there, for at least one.  So x(r) is not left of P.

Half-lines lead along the axes.  A square that holds all corners and the point cuts them off; with its border, taken
counterclockwise from where the last one leaves it to where the first one enters, they close the chain to a polygon.
That is simple only where the half-lines meet nothing, beyond the square too, and what is to its left is to the left
of P.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeAlias

from .basin import Place, Plane
from .cells import Pattern, System
from .positivity import Proofs
from .theorems import Statement
from .work import BUDGET, items, require, take

MAX_CORNERS = 20_000
CORNER = re.compile(r"-?[0-9]{1,40} -?[0-9]{1,40}")

Line: TypeAlias = tuple[tuple[Place, ...], Place | None, tuple[int, int]]  # ends, direction of a half-line, normal


def show_outside(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """No start to the right of a polygon or chain, or on it, comes to the point.

    Hypotheses: ``surfaces`` on which fields switch, ``unit``, and ``corners``, each its place in units from the point;
    of a chain ``ends``, the directions in which the half-lines leave the first corner and the last.
    """
    surfaces, unit, corners, ends = take(hypotheses, "surfaces unit corners", "ends")
    require(system.count == 2, "a system in the plane")
    require(not system.numbers, "rational numbers, for a polygon")
    ring = [place_of(corner) for corner in items(corners, most=MAX_CORNERS)]
    directions = [] if ends is None else [place_of(end) for end in items(ends, 2)]
    along_axes = all(abs(x) + abs(y) == 1 for x, y in directions)
    require(bool(ring) and along_axes, "corners, and half-lines along the axes")
    whole = closed(ring, directions[0], directions[1]) if directions else ring
    require_simple(whole)
    require(winding(whole) == (1 if is_counterclockwise(whole) else 0), "the point to the left of the polygon")
    show_rightward(ring, directions, Plane(system, unit, surfaces, proofs))
    return [{"outside": {"unit": unit, "corners": corners, **({} if ends is None else {"ends": ends})}}]


def closed(chain: Sequence[Place], first: Place, last: Place, least: int = 1) -> list[Place]:
    """The polygon of a chain with its half-lines in a square, and the border of the square to the left of it."""
    half = max(least, 1 + max(abs(coordinate) for place in chain for coordinate in place))
    corners = [(half, half), (-half, half), (-half, -half), (half, -half)]  # each ends a side, counterclockwise
    enters, leaves = (border_place(*half_line, half) for half_line in ((chain[0], first), (chain[-1], last)))
    begin, end = side_of(leaves, half), side_of(enters, half)
    after = turn((0, 0), leaves, enters) > 0  # on the same side
    count = (end - begin) % 4 if begin != end or after else 4
    return [enters, *chain, leaves, *(corners[(begin + k) % 4] for k in range(count))]


def border_place(corner: Place, direction: Place, half: int) -> Place:
    """Where a half-line along an axis leaves the square ``|x|, |y| <= half``."""
    x, y = (half * step if step else coordinate for coordinate, step in zip(corner, direction, strict=True))
    return x, y


def side_of(place: Place, half: int) -> int:
    """The side of the square on which a place is: right, upper, left or lower."""
    x, y = place
    return [x == half, y == half, x == -half, y == -half].index(True)


def show_rightward(chain: Sequence[Place], ends: Sequence[Place], plane: Plane) -> None:
    """All velocities lead to the right on each side, and at each corner for both of its sides.

    Args:
        chain: corners, of a closed polygon where there are no ends.
        ends: the directions of both half-lines, or none.
        plane: the cells.
    """
    sides: list[Line] = [((a, b), None, rightward(a, b)) for a, b in pairwise(chain)]
    if ends:
        require(not any(plane.waves), "half-lines without sines and cosines")
        (first, last), still = ends, (0, 0)
        begin: Line = ((chain[0],), first, rightward(first, still))
        sides = [begin, *sides, ((chain[-1],), last, rightward(still, last))]
        before = sides
    else:
        sides.append(((chain[-1], chain[0]), None, rightward(chain[-1], chain[0])))
        before = [sides[-1], *sides]
    cells_by_line = {line: plane.touching(*line[:2]) for line in sides}
    for line, cells in cells_by_line.items():
        require_rightward(plane, cells, line)
    for corner, lines in zip(chain, pairwise(before), strict=True):
        touching = plane.touching((corner,))
        for line in lines:  # of the cells that meet a side this is known at its ends, too
            require_rightward(plane, touching - cells_by_line[line], ((corner,), None, line[2]))


def require_rightward(plane: Plane, cells: Iterable[Pattern], line: Line) -> None:
    """The fields of some cells have positive products with the normal on a closed side, a half-line or at a corner."""
    places, direction, (across, up) = line
    for field in (field for cell in cells for field in plane.fields(cell, places)):
        values = field.along((-across, -up)).highest(places, direction)
        known = max(values) < 0
        if direction is not None:  # powers of t: one that is negative, that of 1, is enough
            known = values[0] < 0 and max(values) <= 0
        require(known, f"velocities that lead to the right at {places}")


def place_of(data: Any) -> Place:
    """Two whole numbers from a text such as ``-3 0``."""
    require(type(data) is str and CORNER.fullmatch(data), "two whole numbers in a text")
    x, y = map(int, data.split(" "))
    return x, y


def rightward(first: Place, last: Place) -> tuple[int, int]:
    """The normal of a side to its right: outward where a polygon is counterclockwise."""
    return last[1] - first[1], first[0] - last[0]


def turn(a: Place, b: Place, c: Place) -> int:
    """Positive where a, b and c turn to the left, zero where they are on one line."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def require_simple(ring: Sequence[Place]) -> None:
    """No two sides have a point in common, but neighbours the corner between them.

    Sides are taken from left to right, and each is compared with those that reach as far as its left end.
    """
    count = len(ring)
    sides = list(pairwise((*ring, ring[0])))
    order = sorted(range(count), key=lambda k: min(corner[0] for corner in sides[k]))
    active: list[int] = []
    for k in order:
        left = min(corner[0] for corner in sides[k])
        active = [j for j in active if max(corner[0] for corner in sides[j]) >= left]
        BUDGET.spend(1 + len(active))
        for j in active:
            require(not meet(sides[j], sides[k], (k - j) % count, (j - k) % count), "sides that do not meet")
        active.append(k)


def meet(first: tuple[Place, Place], second: tuple[Place, Place], after: int, before: int) -> bool:
    """Whether two sides have a point in common that they need not have.

    Args:
        first: its ends.
        second: likewise.
        after: how many sides the second one comes after the first.
        before: how many it comes before.
    """
    (a, b), (c, d) = first, second
    if after == 1:  # b = c: only where the second one turns back along the first
        return turn(a, b, d) == 0 and along(b, a, d) > 0
    if before == 1:  # d = a
        return turn(c, a, b) == 0 and along(a, c, b) > 0
    if any(
        max(p[k] for p in first) < min(p[k] for p in second) or max(p[k] for p in second) < min(p[k] for p in first)
        for k in (0, 1)
    ):
        return False
    return turn(a, b, c) * turn(a, b, d) <= 0 and turn(c, d, a) * turn(c, d, b) <= 0


def along(a: Place, b: Place, c: Place) -> int:
    """The product of the ways from a to b and from a to c."""
    return (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1])


def is_counterclockwise(ring: Sequence[Place]) -> bool:
    """Whether a simple polygon is, by its area."""
    return sum(ax * by - ay * bx for (ax, ay), (bx, by) in pairwise((*ring, ring[0]))) > 0


def winding(ring: Sequence[Place]) -> int | None:
    """How often a polygon goes around the origin counterclockwise: on x > 0 it crosses upward so much more often.

    A corner on the axis counts as above it.  None where a side meets the origin itself.
    """
    total = 0
    for (ax, ay), (bx, by) in pairwise((*ring, ring[0])):
        if (ay < 0) == (by < 0):
            if ay == by == 0 and min(ax, bx) <= 0 <= max(ax, bx):
                return None
            continue
        crossing = ax + Fraction(-ay * (bx - ax), by - ay)
        if not crossing:
            return None
        if crossing > 0:
            total += 1 if ay < 0 else -1
    return total
