"""Segments on which every place of a plain system rests: dead zones, lines of equilibria, and dry friction.

Where rates are affine, ``f = 0`` in a cell is a linear system; so is ``l f + (1 - l) g = 0, s = 0`` in x and l between
two fields that differ by a constant on a plane.  If its solutions form a line, and what bounds the cell or the border
is affine too, they are a segment with exact ends.  In the plane the borders of a phase portrait tell more: there f and
g may be any two fields that are parallel all along a line.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import combinations
from typing import TypeAlias

from flint import fmpq, fmpq_mat

from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.kernel.written import null_basis
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial

Place: TypeAlias = tuple[Number, ...]
Affine: TypeAlias = list[fmpq]  # coefficients of all unknowns, and a constant


class RestKind(StrEnum):
    """Where a place of rest lies."""

    CELL = "inside a cell"
    SLIDING = "on a surface that both fields lead to"
    REPELLING = "on a surface that both fields lead away from"
    BOUNDARY = "on a surface, where one of its fields is zero or runs along it"
    CORNER = "where surfaces meet"


@dataclass(frozen=True)
class RestSegment:
    """A segment on which every place rests, in coordinates of the displacement from the checked point.

    Attributes:
        start: the end with the smaller coordinates.
        end: the other end.
        kind: where it lies.
        direction: of the line.
        is_exact: whether the ends are exact, or as nearly as they are known, a millionth of the cube.
    """

    start: Place
    end: Place
    kind: RestKind
    direction: Place = field(compare=False)
    is_exact: bool = True


KINDS = {BorderKind.SLIDING: RestKind.SLIDING, BorderKind.REPELLING: RestKind.REPELLING}


def of_border(part: BorderPart) -> RestSegment:
    """A part of a border in the plane that both fields lead to, or away from."""
    a, b = part.normal
    return _forward(RestSegment(part.start, part.end, KINDS[part.kind], (-b, a), part.is_exact))


def joined(segments: Iterable[RestSegment]) -> Iterator[RestSegment]:
    """Segments, those of one kind that go on where others end as one."""
    waiting = list(dict.fromkeys(segments))
    while waiting:
        own = waiting.pop()
        other = next((one for one in waiting if one.kind is own.kind and _meet(own, one)), None)
        if other is None:
            yield own
        else:
            waiting.remove(other)
            start, end = {own.start, own.end} ^ {other.start, other.end}
            waiting.append(_forward(replace(own, start=start, end=end, is_exact=own.is_exact and other.is_exact)))


def _meet(first: RestSegment, second: RestSegment) -> bool:
    """Whether one of two segments goes on where the other one ends, in the same direction."""
    pairs = combinations(zip(first.direction, second.direction, strict=True), 2)
    are_parallel = not any(a * d - b * c for (a, c), (b, d) in pairs)
    return are_parallel and len({first.start, first.end} & {second.start, second.end}) == 1


def _forward(segment: RestSegment) -> RestSegment:
    """The same from the end with the smaller coordinates."""
    start, end = sorted((segment.start, segment.end), key=lambda own: tuple(map(float, own)))
    return replace(segment, start=start, end=end)


# ---- affine rates --------------------------------------------------------------------------------


@dataclass(frozen=True)
class SolutionLine:
    """The solutions ``p + t d`` of a linear system, and the part of them that is asked for.

    Attributes:
        point: p.
        direction: d.
        first: the least t.
        last: the largest t.
    """

    point: list[fmpq]
    direction: list[fmpq]
    first: fmpq
    last: fmpq

    def at(self, t: fmpq) -> list[fmpq]:
        """A solution."""
        return [a + t * b for a, b in zip(self.point, self.direction, strict=True)]


def resting_in_cell(field: StatedField, guards: Sequence[Polynomial], radius: Number) -> list[RestSegment] | None:
    """The segment of a cell in which its field is zero; none where it is zero nowhere; None where nothing is said.

    Args:
        field: of the cell.
        guards: polynomials that are positive in the cell.
        radius: half the side of the cube.
    """
    return _segments(_affine(field.rates, len(field.rates)), guards, radius, field, RestKind.CELL)


def resting_on_plane(
    first: StatedField, second: StatedField, plane: Polynomial, guards: Sequence[Polynomial], radius: Number
) -> list[RestSegment] | None:
    """The same on a plane between two fields, the first of them where its polynomial is positive."""
    own, other, on = (_affine(parts, len(first.rates)) for parts in (first.rates, second.rates, [plane]))
    if own is None or other is None or on is None:
        return None
    own, other = (_restricted(rows, on[0]) for rows in (own, other))
    apart = [[p - q for p, q in zip(a, b, strict=True)] for a, b in zip(own, other, strict=True)]
    if any(any(row[:-1]) for row in apart):
        return None  # the product of l and a state
    *normal, constant = on[0]
    across = sum((a * row[-1] for a, row in zip(normal, apart, strict=True)), start=fmpq(0))
    mixed = [[*row[:-1], gap[-1], row[-1]] for row, gap in zip(other, apart, strict=True)]
    kind = RestKind.SLIDING if across < 0 else RestKind.REPELLING if across > 0 else RestKind.BOUNDARY
    return _segments([*mixed, [*normal, fmpq(0), constant]], guards, radius, first, kind)


def _restricted(rows: Sequence[Affine], plane: Affine) -> list[Affine]:
    """Affine functions on a plane, without a coordinate that it determines."""
    k = next(k for k, slope in enumerate(plane[:-1]) if slope)
    return [[a - row[k] / plane[k] * b for a, b in zip(row, plane, strict=True)] for row in rows]


def _segments(
    equations: list[Affine] | None, guards: Sequence[Polynomial], radius: Number, field: StatedField, kind: RestKind
) -> list[RestSegment] | None:
    """The segments of states that solve affine equations, in which further unknowns lie between zero and one."""
    count, half = len(field.rates), radius.as_rational()
    bounds = _affine(guards, count)
    if equations is None or bounds is None or half is None:
        return None
    found = _solutions(equations)
    if found is None:
        return []
    point, directions = found
    if len(directions) != 1 or not any(directions[0][:count]):
        return None
    further = len(point) - count
    around = [[*row[:-1], *[fmpq(0)] * further, row[-1]] for row in bounds]
    shares = _between(range(count, len(point)), len(point), fmpq(0), fmpq(1))
    line = _within(point, directions[0], [*around, *_between(range(count), len(point), -half, half), *shares])
    if line is None:
        return []
    if line.first == line.last:
        return None  # one place
    if any(_is_zero_along(line, row) for row in around):
        kind = RestKind.BOUNDARY if kind is RestKind.CELL else RestKind.CORNER
    elif any(_is_zero_along(line, row) for row in shares):
        kind = RestKind.BOUNDARY
    ends = (line.at(line.first), line.at(line.last), line.direction)
    start, end, along = (tuple(map(field.rates[0].field.rational, own[:count])) for own in ends)
    return [_forward(RestSegment(start, end, kind, along))]


def _between(places: Iterable[int], unknowns: int, low: fmpq, high: fmpq) -> list[Affine]:
    """What is not negative where some unknowns lie between two numbers."""
    units = [[fmpq(j == k) for j in range(unknowns)] for k in places]
    return [row for own in units for row in ([*own, -low], [*(-a for a in own), high])]


def _is_zero_along(line: SolutionLine, row: Affine) -> bool:
    """Whether an affine function is zero all along a line."""
    return not any(_value(row, line.at(t)) for t in (line.first, line.last))


def _value(row: Affine, place: Sequence[fmpq]) -> fmpq:
    return sum((a * x for a, x in zip(row, place, strict=False)), start=row[-1])


def _affine(polynomials: Sequence[Polynomial], count: int) -> list[Affine] | None:
    """Coefficients in the states; None for others than affine ones with rational coefficients, and for sines.

    Args:
        polynomials: in the states, and in names of sines.
        count: of states.
    """
    rows = []
    for own in polynomials:
        row = [fmpq(0)] * (count + 1)
        for exponents, number in own.terms.items():
            known = number.as_rational()
            if sum(exponents) > 1 or any(exponents[count:]) or known is None:
                return None
            row[exponents.index(1) if any(exponents) else -1] = known
        rows.append(row)
    return rows


def _solutions(rows: Sequence[Affine]) -> tuple[list[fmpq], list[list[fmpq]]] | None:
    """A point and directions that span all solutions of ``a . z + c = 0``; None where there are none."""
    reduced, rank = fmpq_mat([[*row[:-1], -row[-1]] for row in rows]).rref()
    count = len(rows[0]) - 1
    pivots = [next(k for k in range(count + 1) if reduced[i, k]) for i in range(rank)]
    if count in pivots:
        return None
    point = [fmpq(0)] * count
    for i, k in enumerate(pivots):
        point[k] = reduced[i, count]
    kernel = null_basis(fmpq_mat([row[:-1] for row in rows]))
    return point, [[kernel[k, j] for k in range(count)] for j in range(kernel.ncols())]


def _within(point: list[fmpq], direction: list[fmpq], sides: Sequence[Affine]) -> SolutionLine | None:
    """The part of a line in a bounded polyhedron on which no side is negative; None where there is none."""
    lows, highs = list[fmpq](), list[fmpq]()
    for row in sides:
        here, slope = _value(row, point), _value([*row[:-1], fmpq(0)], direction)
        if slope:
            (lows if slope > 0 else highs).append(-here / slope)
        elif here < 0:
            return None
    first, last = max(lows), min(highs)
    return SolutionLine(point, direction, first, last) if first <= last else None
