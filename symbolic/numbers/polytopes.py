"""Small polytopes in rational numbers: the sides of a convex hull, and the corners of what sides bound.

Every choice of points, or of sides, is tried: for some tens of them in up to four dimensions that takes no time, and
nothing is rounded.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from typing import TypeAlias

from flint import fmpq, fmpq_mat

Affine: TypeAlias = list[fmpq]  # a and c of ``a . x + c``
Vector: TypeAlias = list[fmpq]


def value(row: Affine, place: Sequence[fmpq]) -> fmpq:
    """``a . x + c``."""
    return sum((a * x for a, x in zip(row, place, strict=False)), start=row[-1])


def solutions(rows: Sequence[Affine], count: int) -> tuple[Vector, list[Vector]] | None:
    """A point and directions that span all x in so many unknowns with ``a . x + c = 0``; None where there are none."""
    if not rows:
        return [fmpq(0)] * count, [[fmpq(j == k) for j in range(count)] for k in range(count)]
    reduced, rank = fmpq_mat([[*row[:-1], -row[-1]] for row in rows]).rref()
    pivots = [next(k for k in range(count + 1) if reduced[i, k]) for i in range(rank)]
    if count in pivots:
        return None
    point, directions = [fmpq(0)] * count, []
    for i, k in enumerate(pivots):
        point[k] = reduced[i, count]
    for free in sorted(set(range(count)) - set(pivots)):
        direction = [fmpq(k == free) for k in range(count)]
        for i, k in enumerate(pivots):
            direction[k] = -reduced[i, free]
        directions.append(direction)
    return point, directions


def along(row: Affine, point: Vector, directions: Sequence[Vector]) -> Affine:
    """An affine function of x as one of t, with ``x = point + sum t_i directions_i``."""
    linear = [*row[:-1], fmpq(0)]
    return [*(value(linear, direction) for direction in directions), value(row, point)]


def dimension_of(points: Sequence[Vector]) -> int:
    """That of the hull of some points."""
    apart = [[a - b for a, b in zip(point, points[0], strict=True)] for point in points[1:]]
    return int(fmpq_mat(apart).rank()) if apart else 0


def hull(points: Sequence[Vector]) -> tuple[list[Affine], list[Affine]]:
    """The convex hull of some points: affine functions that are zero on it, and such that are not negative on it."""
    first, count = points[0], len(points[0])
    apart = [[a - b for a, b in zip(point, first, strict=True)] for point in points[1:]]
    reduced, rank = fmpq_mat([[fmpq(0)] * count, *apart]).rref()
    spanned = reduced.tolist()[:rank]
    indices = [next(k for k in range(count) if row[k]) for row in spanned]  # coordinates that determine the others
    across = solutions([[*row, fmpq(0)] for row in spanned], count)
    zero = [[*normal, -value([*normal, fmpq(0)], first)] for normal in (across or ([], []))[1]]
    sides = []
    for side in _sides([[point[k] for k in indices] for point in points]):
        row = [fmpq(0)] * count + [side[-1]]
        for slope, k in zip(side, indices, strict=False):
            row[k] = slope
        sides.append(row)
    return zero, sides


def _sides(points: Sequence[Vector]) -> Iterator[Affine]:
    """The sides of a hull of full dimension, each once."""
    size, seen = len(points[0]), set[tuple[fmpq, ...]]()
    for chosen in combinations(points, size) if size else ():
        solution = solutions([[*point, fmpq(1), fmpq(0)] for point in chosen], size + 1)
        if solution is None or len(solution[1]) != 1:
            continue
        (row,) = solution[1]
        values = [value(row, point) for point in points]
        if any(v < 0 for v in values) and any(v > 0 for v in values):
            continue
        row = row if any(v > 0 for v in values) else [-entry for entry in row]
        scale = max(map(abs, row[:-1]))
        row = [entry / scale for entry in row]
        if tuple(row) not in seen:
            seen.add(tuple(row))
            yield row


def corners(sides: Sequence[Affine], count: int) -> list[Vector]:
    """The corners of ``a . x + c >= 0`` for all sides, in so many unknowns; each once, in ascending order."""
    vertices = set[tuple[fmpq, ...]]()
    for chosen in combinations(sides, count):
        solved = solutions(chosen, count)
        if solved is not None and not solved[1] and all(value(side, solved[0]) >= 0 for side in sides):
            vertices.add(tuple(solved[0]))
    return [list(corner) for corner in sorted(vertices)]


def around(points: Sequence[Vector]) -> list[Vector]:
    """The corners of a polygon one after the other, from the first on: each next one bounds it."""
    first, *waiting = points
    ordered = [first]
    while waiting:
        last = ordered[-1]
        for corner in waiting:
            _, sides = hull([[a - b for a, b in zip(other, last, strict=True)] for other in points])
            step = [a - b for a, b in zip(corner, last, strict=True)]
            if any(not row[-1] and not value(row, step) for row in sides):
                break
        else:
            raise ValueError("required the corners of a polygon")
        waiting.remove(corner)
        ordered.append(corner)
    return ordered


def holds(points: Sequence[Vector], place: Vector) -> bool:
    """Whether a place is in the convex hull of some points."""
    zero, sides = hull(points)
    return not any(value(row, place) for row in zero) and all(value(row, place) >= 0 for row in sides)


def are_independent(rows: Iterable[Affine]) -> bool:
    """Whether no combination of affine functions is a number."""
    normals = [row[:-1] for row in rows]
    return not normals or int(fmpq_mat(normals).rank()) == len(normals)
