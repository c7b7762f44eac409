"""Whether a plain system rests anywhere but at the origin: 0 in F at another point of some closed cells.

Three kinds of points are looked at, each exactly: a closed cell, where ``f = 0`` is refuted by ``f . f > 0``; an edge
between two cells, where 0 lies between f and k iff ``f x k = 0`` and ``f . k <= 0``, polynomials in one parameter; and
corners, where the hull of all fields around is looked at.  Beside a curved side a rest needs ``f x k = 0`` on the
curve, which is refuted by a sum of squares.  Points that only look like rests end undecided, never as ``none``.

Where several fields act in a cell (arbitrary switching), 0 may lie between two or three of them.  If no field vanishes
and no two are opposed on a connected set, then whether 0 is in the hull is the same all over it: at a border of the set
of places where it is, 0 would be on the border of the hull, hence a vertex of it or between two.  So pairs are refuted
all over a cell or a side, and the hull is looked at in one place of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from itertools import combinations

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region, Segment, Triple, common_edges, line_of
from nonsmooth.analysis.cells.switched_cells import FieldCell, PlaneField, distinct, velocities_at
from nonsmooth.proofs.inequalities.dense_polynomials import Coefficients, trimmed, value
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof, Sense, prove
from nonsmooth.proofs.inequalities.real_roots import positive_roots, samples_between
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
        cells: cover a domain.
    """
    fields = {velocity for cell in cells for velocity in cell.velocities}
    if any(cell.region.guards for cell in cells) and len(fields) > MOST_BESIDE_CURVES:
        return Rests.UNDECIDED  # where a curve meets an edge, three fields may hold 0 that no two of them do
    found = [*map(_in_cell, cells), *_on_edges(cells), *_at_corners(cells)]
    if Rests.SOME in found:
        return Rests.SOME
    return Rests.UNDECIDED if Rests.UNDECIDED in found else Rests.NONE


def _in_cell(cell: FieldCell) -> Rests:
    """Of a closed cell: none of its fields vanishes, no two are opposed, and 0 is not in their hull."""
    found = [_of_field(field, cell.region) for field in cell.velocities]
    if len(found) == 1:
        return found[0]
    place = cell.region.inner_point
    inside = not cell.region.guards
    if Rests.SOME in found or (inside and hull_holds_zero([(f(place), g(place)) for f, g in cell.velocities])):
        return Rests.SOME
    if Rests.UNDECIDED in found or not inside:
        return Rests.UNDECIDED
    apart = all(_never_opposed(first, second, cell.region) for first, second in combinations(cell.velocities, 2))
    return Rests.NONE if apart else Rests.UNDECIDED


def _never_opposed(first: PlaneField, second: PlaneField, region: Region) -> bool:
    """Whether two fields have a positive product wherever they are parallel in a region, but at the origin."""
    (f, g), (h, k) = first, second
    across, along = f * k - g * h, f * h + g * k
    if _is_nonzero(across, region) or _is_positive(along, region):
        return True
    return _vanishes_on_lines_only(across, along, region, positive=True)


def _of_field(field: PlaneField, region: Region) -> Rests:
    """Whether a field vanishes: one entry without a zero is enough, else the sum of squares."""
    f, g = field
    if any(_is_nonzero(part, region) for part in (f, g)):
        return Rests.NONE
    if any(_vanishes_on_lines_only(first, second, region) for first, second in ((f, g), (g, f))):
        return Rests.NONE
    outcome = prove(Sense.POSITIVE, f * f + g * g, region, except_origin=True)
    if isinstance(outcome, Proof):
        return Rests.NONE
    return Rests.SOME if isinstance(outcome, Counterexample) else Rests.UNDECIDED


def _is_nonzero(part: Polynomial, region: Region) -> bool:
    value_inside = part(region.inner_point).sign() if part else 0
    if not value_inside:
        return False
    sense = Sense.POSITIVE if value_inside > 0 else Sense.NEGATIVE
    return isinstance(prove(sense, part, region, except_origin=True), Proof)


def _is_positive(part: Polynomial, region: Region) -> bool:
    return bool(part) and isinstance(prove(Sense.POSITIVE, part, region, except_origin=True), Proof)


def _vanishes_on_lines_only(first: Polynomial, second: Polynomial, region: Region, *, positive: bool = False) -> bool:
    """Whether the zeros of one polynomial are lines on which the other has no zero in the region but the origin.

    Args:
        first: the one.
        second: the other.
        region: a cell.
        positive: whether the other must be positive there.
    """
    leading = first.terms[max(first.terms)] if first else None
    factored = factorize(first * leading.inverse()) if leading is not None else None
    if factored is None:
        return False
    for factor, _ in factored[1]:
        line = line_of(factor) if factor.degree == 1 else None
        met = line is None or _meet(line, second, region)
        if line is not None and not met and (not positive or _is_positive_along(line, second, region)):
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


def _is_positive_along(line: Triple, other: Polynomial, region: Region) -> bool:
    """Whether a polynomial without zeros on a line in a convex region is positive on that part of the line."""
    a, b, c = line
    size = a * a + b * b
    start, along = (-a * c / size, -b * c / size), (-b, a)
    low, high = None, None  # of t in start + t along
    for p, q, r in (tuple(map(evaluated, side)) for side in region.sides):
        slope, here = p * along[0] + q * along[1], p * start[0] + q * start[1] + r
        if not slope:
            if here.sign() < 0:
                return True  # beside the region
        elif slope.sign() > 0:
            low = -here / slope if low is None else max(low, -here / slope)
        else:
            high = -here / slope if high is None else min(high, -here / slope)
    if low is not None and high is not None:
        if high < low:
            return True
        t = (low + high) / 2
    else:
        t = low + 1 if low is not None else (high - 1 if high is not None else other.field.one)
    place = (start[0] + t * along[0], start[1] + t * along[1])
    return not any(place) or other(place).sign() > 0


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
        guarded = _is_guarded(first, second)
        for edge in common_edges(first.region, second.region):
            for field in first.velocities:
                for other in second.velocities:
                    yield _on_edge(field, other, edge, guarded=guarded)
            fields = (*first.velocities, *second.velocities)
            if len(fields) > 2 and hull_holds_zero(
                [(f(place), g(place)) for place in [_middle(edge)] for f, g in fields]
            ):
                yield Rests.UNDECIDED if guarded else Rests.SOME


def _middle(edge: Segment) -> Point:
    """A point between the ends of an edge, one of which may lie at infinity."""
    x, y, w = (a + b for a, b in zip(*edge, strict=True))
    return x / w, y / w


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
    return bool(roots) or any(value(along, t).sign() < 0 for t in samples_between(roots))


def _opposed_at_a_root(across: Coefficients, along: Coefficients) -> bool:
    return any(root.sign_of(along) <= 0 for root in positive_roots(trimmed(across)))


def _on_curve(first: FieldCell, second: FieldCell) -> Rests:
    """On the curves that part two cells: ``guard = 0`` and parallel fields are refuted together."""
    if len(first.velocities) > 1 or len(second.velocities) > 1:
        return Rests.UNDECIDED
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
