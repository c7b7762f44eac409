"""LaSalle's principle in many states: whether a V that does not increase is kept by no solution but the point.

Bounded solutions of a Filippov inclusion tend to solutions along which V has one value (Ryan 1998; Bacciotti and
Ceragioli 1999).  Here all surfaces are hyperplanes through the point and V has one gradient.  No field lets V rise, so
at almost all times of such a solution all fields that its velocity mixes keep V.  The space is cut into strata, one for
each pattern of signs -, 0, + of the surfaces.  Let a solution be in a stratum for a set of times of positive measure.

1. There linear forms vanish: those of its surfaces with sign 0, and those that vanish wherever some field of a cell
   beside it keeps V (what follows from ``-grad V . f = 0``: kernels of semidefinite forms, powers of one coordinate).
2. The derivative of such a form h along the solution is zero at almost all these times.  It is a mixture of the
   ``h . f_i`` of all cells beside the stratum.  If these are one polynomial on the subspace where the forms of the
   stratum vanish, this is zero too: another form, if it is linear or an odd function of one coordinate.  If they are
   constants of one sign, no solution is there.
3. When a form of a surface with sign + or - vanishes on the subspace, the stratum holds nothing of it.

If every stratum ends with nothing or the point, a solution that keeps V is the point.  What is left out: V that bends,
surfaces that do not pass the point, strata on which the fields differ in what they do to all forms (sliding that may
stay), and sets that lie in no smaller subspace.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TypeAlias

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.kernel.squares import terms_of
from nonsmooth.proofs.many_states.affine_faces import unit
from nonsmooth.proofs.many_states.examination import CELL, POSITIVE, Examination
from nonsmooth.proofs.many_states.sign_cells import RationalTerms, SignCell, rational_terms
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.numbers.polynomial import Exponents, add_terms, multiply_terms

MOST_SURFACES = 4  # three to this power strata

Row: TypeAlias = list[fmpq]


def nothing_stays(examination: Examination) -> bool:
    """Whether a V that does not increase is shown to be kept by the checked point alone.

    Args:
        examination: of V, with all of its inequalities.
    """
    cells = examination.cells
    bends = sum(own.claim.name.split()[0] == POSITIVE for own in examination.asked) != 1
    if examination.verdict is not Decrease.WEAK or bends or not cells.are_cones:
        return False
    if len(cells.surfaces) > MOST_SURFACES:
        return False
    normals = [_row(rational_terms(surface), len(cells.states)) for surface in cells.surfaces]
    keeping = _keeping_forms(examination, normals)
    for signs in product((-1, 0, 1), repeat=len(normals)):
        beside = [c for c in cells.cells if all(s in {0, own} for s, own in zip(signs, c.signs, strict=True))]
        if beside and not _is_left(signs, normals, beside, keeping):
            return False
    return True


def _keeping_forms(examination: Examination, normals: Sequence[Row]) -> dict[tuple[int, ...], list[list[Row]]]:
    """For each cell and each of its fields, linear forms that vanish wherever that field keeps V."""
    found: dict[tuple[int, ...], list[list[Row]]] = {}
    for own in examination.asked:
        kind, marks, *_ = own.claim.name.split(" ")
        if kind == CELL:
            signs = tuple(1 if mark == "+" else -1 for mark in marks)
            fall = terms_of(own.claim.inequalities[0].value)
            found.setdefault(signs, []).append(_zero_forms(fall, signs, normals))
    return found


def _zero_forms(fall: Mapping[Exponents, fmpq], signs: Sequence[int], normals: Sequence[Row]) -> list[Row]:
    """Linear forms that vanish where a polynomial does on a closed cell, if all its parts are seen to be nonnegative.

    Its linear part must be a sum of guards with nonnegative weights, its quadratic part a semidefinite form, and every
    further monomial one whose sign on the cell is that of its coefficient, or all even.
    """
    count = len(next(iter(fall), ()))
    linear = _row({e: c for e, c in fall.items() if sum(e) == 1}, count)
    quadratic = [[_entry(fall, i, j) for j in range(count)] for i in range(count)]
    rows: list[Row] = []
    if any(linear):
        weights = _weights(linear, [[s * v for v in normal] for s, normal in zip(signs, normals, strict=True)])
        if weights is None:
            return []
        rows += [normal for weight, normal in zip(weights, normals, strict=True) if weight]
    if not _is_semidefinite(quadratic):
        return []
    rows += [row for row in quadratic if any(row)]
    for exponents, value in fall.items():
        if sum(exponents) == 0 or (sum(exponents) > 2 and not _is_nonnegative(exponents, value, signs, normals)):
            return []
        if sum(exponents) > 2 and sum(map(bool, exponents)) == 1:
            rows.append([fmpq(int(bool(e))) for e in exponents])
    return rows


def _entry(terms: Mapping[Exponents, fmpq], i: int, j: int) -> fmpq:
    """An entry of the symmetric matrix of the quadratic part."""
    count = len(next(iter(terms)))
    exponents = tuple(a + b for a, b in zip(unit(count, i), unit(count, j), strict=True))
    value = terms.get(exponents, fmpq(0))
    return value if i == j else value / 2


def _weights(form: Row, guards: Sequence[Row]) -> list[fmpq] | None:
    """Nonnegative weights with which independent guards add up to a form; None where there are none."""
    if not guards or _rank(guards) < len(guards) or _rank([*guards, form]) > len(guards):
        return None
    columns = fmpq_mat([[*(guard[k] for guard in guards), form[k]] for k in range(len(form))])
    reduced, _ = columns.rref()
    weights = [reduced[k, len(guards)] for k in range(len(guards))]
    return weights if all(weight >= 0 for weight in weights) else None


def _is_semidefinite(matrix: Sequence[Sequence[fmpq]]) -> bool:
    """Whether a symmetric matrix is positive semidefinite: pivots and what is left of it, one by one."""
    rows = [list(row) for row in matrix]
    while rows:
        k = next((k for k in range(len(rows)) if rows[k][k] > 0), None)
        if k is None:
            return not any(any(row) for row in rows)
        pivot, column = rows[k][k], rows[k]
        rest = [i for i in range(len(rows)) if i != k]
        rows = [[rows[i][j] - column[i] * column[j] / pivot for j in rest] for i in rest]
    return True


def _is_nonnegative(exponents: Exponents, value: fmpq, signs: Sequence[int], normals: Sequence[Row]) -> bool:
    """Whether a monomial is nonnegative on a closed cell: odd powers of coordinates whose sign a surface gives."""
    total = 1 if value > 0 else -1
    for k, exponent in enumerate(exponents):
        if exponent % 2:
            axis = [bool(i == k) for i in range(len(exponents))]
            j = next((j for j, normal in enumerate(normals) if list(map(bool, normal)) == axis), None)
            if j is None:
                return False
            total *= signs[j] * (1 if normals[j][k] > 0 else -1)
    return total > 0


# ---- one stratum ---------------------------------------------------------------------------------


def _is_left(
    signs: Sequence[int],
    normals: Sequence[Row],
    beside: Sequence[SignCell],
    keeping: Mapping[tuple[int, ...], list[list[Row]]],
) -> bool:
    """Whether a solution that keeps V is in a stratum at almost no time, unless it is the point."""
    count = len(beside[0].velocities[0])
    common = _common([rows for cell in beside for rows in keeping[cell.signs]], count)
    forms = [*(normal for s, normal in zip(signs, normals, strict=True) if not s), *common]
    fields = [field for cell in beside for field in cell.velocities]
    while True:
        forms = _independent(forms)
        vanish = (_rank([*forms, n]) == len(forms) for s, n in zip(signs, normals, strict=True) if s)
        if len(forms) == count or any(vanish):
            return True
        basis = _kernel(forms, count)
        slopes = [[_along(form, field, basis) for field in fields] for form in forms]
        if any(_are_constants_of_one_sign(row) for row in slopes):
            return True
        equations = _reduced(list(_same_for_all(slopes)))
        if any(list(map(sum, equation)) == [0] for equation in equations):
            return True  # a constant that would be zero
        found = [row for equation in equations if (row := _zero_row(equation, len(basis))) is not None]
        if not found:
            return False
        forms = [*forms, *(_lifted(row, basis) for row in found)]


def _common(spaces: Sequence[Sequence[Row]], count: int) -> list[Row]:
    """Forms that lie in the span of each of some lists of forms."""
    annihilators = [vector for rows in spaces for vector in _kernel(rows, count)]
    return _kernel(annihilators, count)


def _along(form: Row, field: Sequence[RationalTerms], basis: Sequence[Row]) -> RationalTerms:
    """``h . f`` on the subspace with a basis, as a polynomial in its coordinates."""
    size = len(basis)
    states = [{unit(size, i): b[k] for i, b in enumerate(basis) if b[k]} for k in range(len(form))]
    total: RationalTerms = {}
    for weight, rate in zip(form, field, strict=True):
        for exponents, value in rate.items() if weight else ():
            term: RationalTerms = {(0,) * size: weight * value}
            for state, exponent in zip(states, exponents, strict=True):
                for _ in range(exponent):
                    term = multiply_terms(term, state)
            total = add_terms(total, term)
    return {e: c for e, c in total.items() if c}


def _are_constants_of_one_sign(slopes: Sequence[RationalTerms]) -> bool:
    values = [next(iter(s.values())) for s in slopes if len(s) == 1 and not any(next(iter(s)))]
    return len(values) == len(slopes) and (all(v > 0 for v in values) or all(v < 0 for v in values))


def _same_for_all(slopes: Sequence[Sequence[RationalTerms]]) -> Iterator[RationalTerms]:
    """The derivatives of the mixtures of forms whose derivatives are one polynomial for all fields."""
    rows = []
    for own in zip(*slopes, strict=True):
        jumps = [add_terms(a, {e: -c for e, c in b[0].items()}) for a, b in zip(own, slopes, strict=True)]
        for exponents in {e for jump in jumps for e in jump}:
            rows.append([jump.get(exponents, fmpq(0)) for jump in jumps])
    for mixture in _kernel(rows, len(slopes)):
        total: RationalTerms = {}
        for weight, slope in zip(mixture, slopes, strict=True):
            total = add_terms(total, {e: weight * c for e, c in slope[0].items()})
        total = {e: c for e, c in total.items() if c}
        if total:
            yield total


def _reduced(equations: Sequence[RationalTerms]) -> list[RationalTerms]:
    """Equations with the same solutions, from which terms of high degree are eliminated as far as possible."""
    order = sorted({e for equation in equations for e in equation}, key=lambda e: (-sum(e), e))
    if not equations:
        return []
    reduced, rank = fmpq_mat([[equation.get(e, fmpq(0)) for e in order] for equation in equations]).rref()
    return [{e: reduced[i, j] for j, e in enumerate(order) if reduced[i, j]} for i in range(rank)]


def _zero_row(equation: RationalTerms, count: int) -> Row | None:
    """A linear form that vanishes where an equation holds: a linear one, or one that is monotonic in one entry."""
    degrees = {sum(e) for e in equation}
    if degrees == {1}:
        return _row(equation, count)
    entries = {k for e in equation for k, exponent in enumerate(e) if exponent}
    if len(entries) != 1 or 0 in degrees:
        return None
    values = list(equation.values())
    rises = all(d % 2 for d in degrees) and (all(v > 0 for v in values) or all(v < 0 for v in values))
    return [fmpq(int(k in entries)) for k in range(count)] if rises or len(values) == 1 else None


def _lifted(row: Row, basis: Sequence[Row]) -> Row:
    """A form of all states that is the given one on the subspace."""
    matrix = fmpq_mat([[*vector, value] for vector, value in zip(basis, row, strict=True)])
    reduced, rank = matrix.rref()
    count = len(basis[0])
    found = [fmpq(0)] * count
    for i in range(rank):
        pivot = next(j for j in range(count + 1) if reduced[i, j])
        found[pivot] = reduced[i, count]
    return found


# ---- linear algebra over the rationals -----------------------------------------------------------


def _row(terms: Mapping[Exponents, fmpq], count: int) -> Row:
    """The coefficients of a linear form."""
    return [terms.get(unit(count, k), fmpq(0)) for k in range(count)]


def _rank(rows: Sequence[Row]) -> int:
    return int(fmpq_mat([list(row) for row in rows]).rank()) if rows else 0


def _independent(rows: Sequence[Row]) -> list[Row]:
    """A basis of the span of some rows."""
    if not rows:
        return []
    reduced, rank = fmpq_mat([list(row) for row in rows]).rref()
    return [[reduced[i, j] for j in range(len(rows[0]))] for i in range(rank)]


def _kernel(rows: Sequence[Row], count: int) -> list[Row]:
    """A basis of the vectors on which all rows vanish."""
    independent = _independent(rows)
    pivots = [next(j for j in range(count) if row[j]) for row in independent]
    found = []
    for free in (j for j in range(count) if j not in pivots):
        vector = [fmpq(int(j == free)) for j in range(count)]
        for pivot, row in zip(pivots, independent, strict=True):
            vector[pivot] = -row[free]
        found.append(vector)
    return found
