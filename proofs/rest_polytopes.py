"""Polytopes in which every place of a plain system rests: dead zones, sets of equilibria, and dry friction.

On planes, any number of them, let the fields around differ by constants: they are ``A x + b_k``.  Then 0 is in F where
``-A x`` is in the hull of the b_k: in a polytope with exact corners, as the hull has sides that are affine in x, and
what bounds the cell and the cube is affine, too.  In a cell there is one field.  A segment is a polytope with two
corners, a place that rests alone one with one.  In the plane the borders of a phase portrait tell more of segments:
there two fields may be any that are parallel all along a line.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import combinations
from typing import TypeAlias

from flint import fmpq

from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.polytopes import (
    Affine,
    Vector,
    along,
    are_independent,
    around,
    corners,
    dimension_of,
    holds,
    hull,
    solutions,
    value,
)

Place: TypeAlias = tuple[Number, ...]


class RestKind(StrEnum):
    """Where a place of rest lies."""

    CELL = "inside a cell"
    SLIDING = "on a surface that both fields lead to"
    REPELLING = "on a surface that both fields lead away from"
    BOUNDARY = "on a surface, where one of its fields is zero or runs along it"
    CORNER = "where surfaces meet"


@dataclass(frozen=True)
class RestPolytope:
    """A polytope in which every place rests, in coordinates of the displacement from the checked point.

    Attributes:
        corners: those of a polygon one after the other, others in ascending order of their coordinates.
        kind: where it lies.
        dimension: 1 for a segment.
        along: of a segment, the direction of its line.
        is_exact: whether the corners are exact, or as nearly as they are known, a millionth of the cube.
    """

    corners: tuple[Place, ...]
    kind: RestKind
    dimension: int = 1
    along: Place = field(default=(), compare=False)
    is_exact: bool = True

    def holds(self, place: Sequence[Number]) -> bool:
        """Whether an exact place is in it; no place is known to be where numbers are irrational."""
        known = [_rational(corner) for corner in (*self.corners, place)]
        points = [corner for corner in known if corner is not None]
        return len(points) == len(known) and holds(points[:-1], points[-1])


def _rational(place: Sequence[Number]) -> Vector | None:
    numbers = [coordinate.as_rational() for coordinate in place]
    known = [number for number in numbers if number is not None]
    return known if len(known) == len(numbers) else None


# ---- segments on borders in the plane ------------------------------------------------------------

KINDS = {BorderKind.SLIDING: RestKind.SLIDING, BorderKind.REPELLING: RestKind.REPELLING}


def of_border(part: BorderPart) -> RestPolytope:
    """A part of a border in the plane that both fields lead to, or away from."""
    a, b = part.normal
    ends = _ascending((part.start, part.end))
    return RestPolytope(ends, KINDS[part.kind], along=(-b, a), is_exact=part.is_exact)


def _ascending(places: Iterable[Place]) -> tuple[Place, ...]:
    return tuple(sorted(places, key=lambda place: tuple(map(float, place))))


def joined(parts: Iterable[RestPolytope]) -> list[RestPolytope]:
    """Polytopes, segments of one kind that go on where others end as one, and none that is a part of another one."""
    every = list(dict.fromkeys(parts))
    waiting = [part for part in every if part.dimension == 1]
    ended = [part for part in every if part.dimension > 1]
    while waiting:
        part = waiting.pop()
        other = next((one for one in waiting if one.kind is part.kind and _meet(part, one)), None)
        if other is None:
            ended.append(part)
        else:
            waiting.remove(other)
            ends = _ascending(set(part.corners) ^ set(other.corners))
            waiting.append(replace(part, corners=ends, is_exact=part.is_exact and other.is_exact))
    kept: list[RestPolytope] = []
    for part in sorted(ended, key=lambda part: -part.dimension):
        if not any(all(map(other.holds, part.corners)) for other in kept):
            kept.append(part)
    return kept


def _meet(first: RestPolytope, second: RestPolytope) -> bool:
    """Whether one of two segments goes on where the other one ends, in the same direction."""
    pairs = combinations(zip(first.along, second.along, strict=True), 2)
    are_parallel = not any(a * d - b * c for (a, c), (b, d) in pairs)
    return are_parallel and len(set(first.corners) & set(second.corners)) == 1


# ---- affine fields -------------------------------------------------------------------------------


def resting_polytopes(
    fields: Sequence[StatedField], planes: Sequence[Polynomial], guards: Sequence[Polynomial], radius: Number
) -> list[RestPolytope] | None:
    """All that rests on planes, with fields on all sides of them; None where that is not told.

    Of planes whose normals depend on each other not all sides have points; nor need the cell have any whose guards
    vanish on all of a polytope, and depend on these.

    Args:
        fields: on all sides of the planes, the first where they are positive; the field of a cell without any.
        planes: polynomials that are zero.
        guards: polynomials that are positive, or zero at the border.
        radius: half the side of the cube.
    """
    count, half = len(fields[0].rates), radius.as_rational()
    on, beside, *beyond = (
        _affine(polynomials, count) for polynomials in (planes, guards, *(field.rates for field in fields))
    )
    known = [rows for rows in beyond if rows is not None]
    if never_meet(planes):
        return []
    if on is None or beside is None or half is None or len(known) < len(beyond) or not are_independent(on):
        return None
    rest = _OnPlanes(on, beside, known, half)
    return rest.polytopes(fields[0].rates[0].field) if rest.differ_by_constants else None


def never_meet(planes: Sequence[Polynomial]) -> bool:
    """Whether planes have no point in common; of curved surfaces that is not told."""
    known = _affine(planes, len(planes[0].variables)) if planes else None
    return known is not None and solutions(known, len(planes[0].variables)) is None


def _affine(polynomials: Sequence[Polynomial], count: int) -> list[Affine] | None:
    """Coefficients in the states; None for others than affine ones with rational coefficients, and for sines.

    Args:
        polynomials: in the states, and in names of sines.
        count: of states.
    """
    rows = []
    for polynomial in polynomials:
        row = [fmpq(0)] * (count + 1)
        for exponents, number in polynomial.terms.items():
            known = number.as_rational()
            if sum(exponents) > 1 or any(exponents[count:]) or known is None:
                return None
            row[exponents.index(1) if any(exponents) else -1] = known
        rows.append(row)
    return rows


class _OnPlanes:
    """Affine fields on the subspace of planes with independent normals, in coordinates y of it: ``M y + c_k``.

    Args:
        planes: affine functions of the states that are zero.
        guards: that are not negative.
        fields: on all sides of the planes.
        half: half the side of the cube.
    """

    def __init__(self, planes: list[Affine], guards: list[Affine], fields: list[list[Affine]], half: fmpq) -> None:
        self.planes, self.guards = planes, guards
        count = len(fields[0])
        self.space = solutions(planes, count) or ([fmpq(0)] * count, [])
        self.fields = [[along(row, *self.space) for row in rows] for rows in fields]
        units = [[fmpq(j == k) for j in range(count)] for k in range(count)]
        self.cube = [side for unit in units for side in ([*unit, half], [*(-a for a in unit), half])]

    @property
    def differ_by_constants(self) -> bool:
        """Whether M is the same for all fields."""
        slopes = [[row[:-1] for row in rows] for rows in self.fields]
        return all(slope == slopes[0] for slope in slopes)

    def polytopes(self, numbers: NumberField) -> list[RestPolytope] | None:
        """What rests; see :func:`resting_polytopes`."""
        zero, sides = hull([[row[-1] for row in rows] for rows in self.fields])
        stays = solutions(list(map(self._of_field, zero)), len(self.space[1]))
        if stays is None:
            return []
        shares = [along(self._of_field(row), *stays) for row in sides]
        guards, cube = ([along(along(row, *self.space), *stays) for row in rows] for rows in (self.guards, self.cube))
        inside = corners([*shares, *guards, *cube], len(stays[1]))
        if not inside:
            return []
        further = [guard for guard, row in zip(self.guards, guards, strict=True) if _vanishes(row, inside)]
        if not are_independent([*self.planes, *further]):
            return None
        kind = self._kind(len(further), any(_vanishes(row, inside) for row in shares))
        places = sorted(_point_of(self.space, _point_of(stays, point)) for point in inside)
        dimension = dimension_of(places)
        stated = [tuple(map(numbers.rational, place)) for place in (around(places) if dimension == 2 else places)]
        line = tuple(b - a for a, b in zip(stated[0], stated[-1], strict=True)) if dimension == 1 else ()
        return [RestPolytope(tuple(stated), kind, dimension, line)]

    def _of_field(self, row: Affine) -> Affine:
        """An affine function of ``-M y``, in y."""
        columns = range(len(self.space[1]))
        rates = self.fields[0]
        return [*(-value([*row[:-1], fmpq(0)], [rate[j] for rate in rates]) for j in columns), row[-1]]

    def _kind(self, further: int, is_at_end: bool) -> RestKind:
        """Where the polytope lies.

        Args:
            further: on how many more planes.
            is_at_end: whether one of the fields alone is zero there, or some of them.
        """
        held = len(self.planes)
        if held + further > 1:
            return RestKind.CORNER
        if further or is_at_end:
            return RestKind.BOUNDARY
        if not held:
            return RestKind.CELL
        (first, second), (*normal, _) = self.fields, self.planes[0]
        gap = [a[-1] - b[-1] for a, b in zip(first, second, strict=True)]
        across = value([*normal, fmpq(0)], gap)
        return RestKind.SLIDING if across < 0 else RestKind.REPELLING if across > 0 else RestKind.BOUNDARY


def _vanishes(row: Affine, places: Sequence[Vector]) -> bool:
    return not any(value(row, place) for place in places)


def _point_of(space: tuple[Vector, list[Vector]], t: Sequence[fmpq]) -> Vector:
    """The point of an affine space with these coordinates."""
    point, directions = space
    return [value([*(direction[k] for direction in directions), c], t) for k, c in enumerate(point)]
