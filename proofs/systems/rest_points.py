"""Whether a plain system rests anywhere but at the origin: 0 in F at another point of some closed cells.

Three kinds of points are looked at, each exactly: a closed cell, where ``f = 0`` is refuted by ``f . f > 0``; an edge
between two cells, where 0 lies between f and k iff ``f x k = 0`` and ``f . k <= 0``, polynomials in one parameter; and
corners, where the hull of all fields around is looked at.  Beside a curved side a rest needs ``f x k = 0`` on the
curve, which is refuted by a sum of squares.  Points that only look like rests end undecided, never as ``none``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from itertools import combinations

from nonsmooth.analysis.cells.region import Region, Segment, Triple, common_edges, line_of
from nonsmooth.analysis.cells.switched_cells import FieldCell, PlaneField, distinct, velocities_at
from nonsmooth.proofs.inequalities.binary_forms import Line
from nonsmooth.proofs.inequalities.dense_polynomials import Coefficients, trimmed, value
from nonsmooth.proofs.inequalities.prover import Proof, Sense, Witness, prove
from nonsmooth.proofs.inequalities.real_roots import positive_roots
from nonsmooth.proofs.systems.border_motion import along_edge, are_parted
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.plane import hull_holds_zero
from nonsmooth.symbolic.surfaces import factorize

MOST_BESIDE_CURVES = 2  # fields


class Rests(StrEnum):
    """What is known of rests away from the origin."""

    NONE = "there is none"
    SOME = "there are some"
    UNDECIDED = "undecided"


def find_rests(cells: Sequence[FieldCell]) -> Rests:
    """Whether 0 is in F at some point of the closed cells but the origin.

    Args:
        cells: cover a domain; one field each.
    """
    fields = {cell.velocities for cell in cells}
    if any(cell.region.guards for cell in cells) and len(fields) > MOST_BESIDE_CURVES:
        return Rests.UNDECIDED  # where a curve meets an edge, three fields may hold 0 that no two of them do
    found = [*map(_in_cell, cells), *_on_edges(cells), *_at_corners(cells)]
    if Rests.SOME in found:
        return Rests.SOME
    return Rests.UNDECIDED if Rests.UNDECIDED in found else Rests.NONE


def _in_cell(cell: FieldCell) -> Rests:
    """Of a closed cell with one field: one entry without a zero is enough, else the sum of squares."""
    if len(cell.velocities) > 1:
        return Rests.UNDECIDED
    (f, g) = cell.velocities[0]
    if any(_is_nonzero(part, cell.region) for part in (f, g)):
        return Rests.NONE
    if any(_vanishes_on_lines_only(first, second, cell.region) for first, second in ((f, g), (g, f))):
        return Rests.NONE
    outcome = prove(Sense.POSITIVE, f * f + g * g, cell.region, except_origin=True)
    if isinstance(outcome, Proof):
        return Rests.NONE
    return Rests.SOME if isinstance(outcome, Witness) else Rests.UNDECIDED


def _is_nonzero(part: Polynomial, region: Region) -> bool:
    value_inside = part(region.inner_point).sign() if part else 0
    if not value_inside:
        return False
    sense = Sense.POSITIVE if value_inside > 0 else Sense.NEGATIVE
    return isinstance(prove(sense, part, region, except_origin=True), Proof)


def _vanishes_on_lines_only(first: Polynomial, second: Polynomial, region: Region) -> bool:
    """Whether the zeros of one entry are lines on which the other has no zero in the region but the origin."""
    leading = first.terms[max(first.terms)] if first else None
    factored = factorize(first * leading.inverse()) if leading is not None else None
    if factored is None:
        return False
    for factor, _ in factored[1]:
        if factor.degree == 1 and not _meet(line_of(factor), second, region):
            continue
        if not _is_nonzero(factor, region):
            return False
    return True


def _meet(line: Triple, other: Polynomial, region: Region) -> bool:
    """Whether a polynomial vanishes on a line at a point of the region that is not the origin."""
    a, b, c = line
    size = a * a + b * b
    start, along = (-a * c / size, -b * c / size), (-b, a)
    sides = [tuple(map(evaluated, side)) for side in region.sides]
    for turn in (1, -1):
        t = Polynomial.variable(other.field, ("t",), "t")
        x, y = (t * (step * turn) + begin for begin, step in zip(start, along, strict=True))
        curve = _dense(other.composed([x, y]))
        inside = [_dense(x * p + y * q + r) for p, q, r in sides]
        if not curve or (c and not curve[0]):
            return True  # all along, or at the foot of the origin: left to others
        if any(all(root.sign_of(side) >= 0 for side in inside) for root in positive_roots(curve)):
            return True
    return False


def _dense(polynomial: Polynomial) -> Coefficients:
    """Coefficients of a polynomial in one variable, ascending."""
    zero = polynomial.field.zero
    return [polynomial.terms.get((k,), zero) for k in range(polynomial.degree + 1)] if polynomial else []


def _on_edges(cells: Sequence[FieldCell]) -> Iterator[Rests]:
    for first, second in combinations(cells, 2):
        if first.velocities == second.velocities:
            continue
        if are_parted(first, second):
            yield _on_curve(first, second)
        for edge in common_edges(first.region, second.region):
            yield _on_edge(first.velocities[0], second.velocities[0], edge, guarded=_is_guarded(first, second))


def _is_guarded(first: FieldCell, second: FieldCell) -> bool:
    return bool(first.region.guards or second.region.guards)


def _on_edge(first: PlaneField, second: PlaneField, edge: Segment, *, guarded: bool) -> Rests:
    """Between the ends; where curves cut the cells, a rest may lie on a part that belongs to one of them only."""
    (f, g), (h, k) = first, second
    across, along = along_edge(f * k - g * h, edge), along_edge(f * h + g * k, edge)
    holds = _opposed_everywhere(along) if not across else _opposed_at_a_root(across, along)
    if not holds:
        return Rests.NONE
    return Rests.UNDECIDED if guarded else Rests.SOME


def _opposed_everywhere(along: Coefficients) -> bool:
    """Whether parallel fields are opposed at some point of an edge, or one of them vanishes there."""
    if not along:
        return True
    roots = positive_roots(along)
    return bool(roots) or any(value(along, t).sign() < 0 for t in Line.samples(roots))


def _opposed_at_a_root(across: Coefficients, along: Coefficients) -> bool:
    return any(root.sign_of(along) <= 0 for root in positive_roots(trimmed(across)))


def _on_curve(first: FieldCell, second: FieldCell) -> Rests:
    """On the curves that part two cells: ``guard = 0`` and parallel fields are refuted together."""
    (f, g), (h, k) = first.velocities[0], second.velocities[0]
    across, region = f * k - g * h, Region(first.region.generators)
    for guard in first.region.guards:
        if any(not guard + other for other in second.region.guards):
            outcome = prove(Sense.POSITIVE, guard * guard + across * across, region, except_origin=True)
            if not isinstance(outcome, Proof) and not _is_nonzero(across, region):
                return Rests.UNDECIDED
    return Rests.NONE


def _at_corners(cells: Sequence[FieldCell]) -> Iterator[Rests]:
    corners = distinct((x / w, y / w) for cell in cells for x, y, w in cell.region.generators if w and (x or y))
    for corner in corners:
        if hull_holds_zero(velocities_at(cells, corner)):
            guarded = any(cell.region.guards for cell in cells if cell.region.contains(corner))
            yield Rests.UNDECIDED if guarded else Rests.SOME
