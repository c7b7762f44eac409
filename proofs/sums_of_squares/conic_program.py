"""The semidefinite program behind sums of squares, in floats: a proposal, and how it is rounded to a proof.

Unknown are shared parameters and one Gram matrix for each block of each condition; coefficients are compared monomial
by monomial, and the least eigenvalue of the Gram matrices is maximized.  The program is handed to Clarabel as it is:
for many small programs that takes a small part of the time of a modelling language.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import sqrt
from operator import add
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.sums_of_squares.ansatz import Block, Blocks, Condition, reached, separates
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms

Grams: TypeAlias = tuple[Floats, ...]
ITERATIONS = 60
INNER = 1 / 8  # part of the margin by which Gram matrices beside guards are definite
SMALL = 2.0**-12  # diagonal entries of solutions on the border of the cone that are taken for zero
LEAST_MARGIN = 2.0**-22  # a smaller one is the noise of the solver, and no rounding survives it


@dataclass(frozen=True)
class Solution:
    """What the solver proposes.

    Attributes:
        parameters: their values.
        grams: of each condition, one matrix for each block.
        margin: the least eigenvalue of the first Gram matrices; positive where the program has a strict solution.
    """

    parameters: Floats
    grams: tuple[Grams, ...]
    margin: float


class _Rows:
    """A sparse matrix that grows row by row, with the right-hand sides."""

    def __init__(self) -> None:
        self.entries: list[tuple[float, int, int]] = []
        self.right: list[float] = []

    def add(self, row: Mapping[int, float], right: float) -> None:
        """Add a row by its columns."""
        self.entries += [(value, len(self.right), column) for column, value in row.items()]
        self.right.append(right)


Problem: TypeAlias = tuple[Condition, Blocks]


def solve_inside(problems: list[Problem], parameters: int, *, bounded: bool) -> tuple[list[Problem], Solution] | None:
    """A solution well inside the cones, where there is one: that survives rounding best.

    Where none is strict, monomials whose squares have no part in any solution are left out, and the rest is tried.
    """
    outer = solve(problems, parameters, inner=0.0, bounded=bounded, strict=False)
    if outer is not None and abs(outer.margin) <= LEAST_MARGIN:
        problems = [_without_small(problem, grams) for problem, grams in zip(problems, outer.grams, strict=True)]
        whole = all(separates(blocks[0].monomials, at_origin=c.at_origin) for c, blocks in problems)
        outer = solve(problems, parameters, inner=0.0, bounded=bounded) if whole else None
    if outer is None or outer.margin <= LEAST_MARGIN:
        return None
    return problems, solve(problems, parameters, inner=INNER, bounded=bounded) or outer


def _without_small(problem: Problem, grams: Grams) -> Problem:
    """Without the monomials whose diagonal entries are nearly zero."""
    condition, blocks = problem
    remaining: list[Block] = []
    for block, gram in zip(blocks, grams, strict=True):
        monomials = tuple(m for m, size in zip(block.monomials, np.diag(gram), strict=True) if size > SMALL)
        if monomials or not remaining:
            remaining.append(replace(block, monomials=monomials))
    return condition, tuple(remaining)


def solve(
    problems: Sequence[Problem],
    parameters: int,
    *,
    inner: float,
    bounded: bool,
    strict: bool = True,
    price: Floats | None = None,
    least: float = 0.0,
) -> Solution | None:
    """Maximize the margin, or minimize a price of the parameters with some margin; None where none is found.

    Args:
        problems: conditions with their blocks.
        parameters: how many the conditions share.
        inner: by which part of the margin the Gram matrices beside guards must be definite.
        bounded: whether the parameters lie between -1 and 1.
        strict: whether the margin must be positive.
        price: of each parameter, whose sum is minimized.
        least: the least margin where there is a price.
    """
    import clarabel
    from scipy import sparse

    starts, total = _places(problems, parameters + 1)
    margin = parameters
    matrix = _Rows()
    for (condition, blocks), block_starts in zip(problems, starts, strict=True):
        for monomial, compared in _comparison(condition, blocks, block_starts).items():
            matrix.add(compared, float(condition.constant.get(monomial, 0)))
    cones: list[Any] = [clarabel.ZeroConeT(len(matrix.right))]
    limits = [({margin: 1.0}, 1.0)]
    limits += [({k: side}, 1.0) for k in range(parameters if bounded else 0) for side in (1.0, -1.0)]
    limits += [] if price is None else [({margin: -1.0}, -least)]
    for limit in limits:
        matrix.add(*limit)
    cones.append(clarabel.NonnegativeConeT(len(limits)))
    for (_, blocks), block_starts in zip(problems, starts, strict=True):
        for k, (block, start) in enumerate(zip(blocks, block_starts, strict=True)):
            size = len(block.monomials)
            for row, column, weight in _triangle(size):
                own_margin = {margin: inner if k else 1.0} if row == column else {}
                matrix.add({start + column * (column + 1) // 2 + row: -weight, **own_margin}, 0.0)
            if size:
                cones.append(clarabel.PSDTriangleConeT(size) if size > 1 else clarabel.NonnegativeConeT(1))
    weights, numbers, columns = zip(*matrix.entries, strict=True)
    if not are_finite([*weights, *matrix.right]):  # coefficients beyond the range of floats
        return None
    rows = sparse.csc_matrix((weights, (numbers, columns)), shape=(len(matrix.right), total))
    objective = np.zeros(total)
    objective[margin] = -1.0
    if price is not None:
        objective[: margin + 1] = [*price, 0.0]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = ITERATIONS
    nothing = sparse.csc_matrix((total, total))
    solution = clarabel.DefaultSolver(nothing, objective, rows, np.array(matrix.right), cones, settings).solve()
    values = np.asarray(solution.x)
    if not len(values) or not np.all(np.isfinite(values)) or (strict and not values[margin] > LEAST_MARGIN):
        return None
    grams = tuple(
        tuple(
            _symmetric(values, start, len(block.monomials)) for block, start in zip(blocks, block_starts, strict=True)
        )
        for (_, blocks), block_starts in zip(problems, starts, strict=True)
    )
    return Solution(values[:parameters], grams, float(values[margin]))


def _places(problems: Sequence[Problem], start: int) -> tuple[list[list[int]], int]:
    """Where the entries of each Gram matrix begin among the unknowns, and how many unknowns there are."""
    starts = []
    for _, blocks in problems:
        block_starts = []
        for block in blocks:
            block_starts.append(start)
            start += len(block.monomials) * (len(block.monomials) + 1) // 2
        starts.append(block_starts)
    return starts, start


def _triangle(size: int) -> Iterator[tuple[int, int, float]]:
    """The upper triangle, column by column, with the factors of an isometry."""
    for column in range(size):
        for row in range(column + 1):
            yield row, column, 1.0 if row == column else sqrt(2)


def entries(block: Block) -> Iterator[tuple[int, dict[Exponents, Any]]]:
    """For each entry of the upper triangle, column by column, the polynomial that it multiplies (exact)."""
    for column, b in enumerate(block.monomials):
        for row, a in enumerate(block.monomials[: column + 1]):
            shift = tuple(map(add, a, b))
            twice = 1 if row == column else 2
            terms = {tuple(map(add, shift, e)): c * twice for e, c in block.product.items()}
            yield column * (column + 1) // 2 + row, terms


def _comparison(condition: Condition, blocks: Blocks, starts: Sequence[int]) -> dict[Exponents, dict[int, float]]:
    """One row for each monomial: the sum over the blocks less p is zero."""
    rows: dict[Exponents, dict[int, float]] = {}
    for block, start in zip(blocks, starts, strict=True):
        for k, terms in entries(block):
            for exponents, value in terms.items():
                rows.setdefault(exponents, {})[start + k] = float(value)
    for parameter, slope in condition.slopes.items():
        for exponents, value in slope.items():
            rows.setdefault(exponents, {})[parameter] = -float(value)
    for exponents in condition.constant:
        rows.setdefault(exponents, {})
    return rows


def _symmetric(values: Floats, start: int, size: int) -> Floats:
    gram = np.zeros((size, size))
    for row, column, _ in _triangle(size):
        gram[row, column] = gram[column, row] = values[start + column * (column + 1) // 2 + row]
    return gram


# ---- from a Gram matrix in floats to one in rationals --------------------------------------------
#
# It then satisfies the equations exactly (Peyrl and Parrilo 2008).  Entries are rounded; then the least change of the
# entries beside guards repairs the monomials that the plain sum of squares does not reach, and the rest of the error,
# divided among the entries of each monomial, goes into the plain sum of squares.  If the floats lie inside the cone, so
# does the result for fine enough fractions: ``L D L^T`` tells.
#
# Parameters of several conditions are rounded so that every condition can still be met exactly: monomials that no plain
# sum of squares reaches (of too low or too high a degree) tie parameters to the numbers beside guards by linear
# equations; the rounding keeps these.


DENOMINATORS = (1 << 6, 1 << 14, 1 << 24, 1 << 36)  # tried in turn

RationalMatrix: TypeAlias = tuple[tuple[fmpq, ...], ...]
Triangles: TypeAlias = list[list[fmpq]]  # of each block, the upper triangle column by column


def rounded(condition: Condition, blocks: Blocks, grams: Grams, *, strict: bool) -> tuple[RationalMatrix, ...] | None:
    """Rational Gram matrices that prove a condition; None where the rounding breaks it.

    With them the sum over the blocks is p, term by term, and all of them are positive semidefinite.  A strict proof
    has a definite one for the plain sum of squares, whose monomials vanish together nowhere that counts.
    """
    if strict and not separates(blocks[0].monomials, at_origin=condition.at_origin):
        return None
    for denominator in DENOMINATORS:
        triangles = _repaired(condition, blocks, [_rational_triangle(gram, denominator) for gram in grams])
        if triangles is None:
            return None
        first, *others = matrices = tuple(map(_rational_symmetric, triangles))
        holds = is_definite(first) if strict else is_semidefinite(first)
        if holds and all(map(is_semidefinite, others)) and not _error(condition, blocks, triangles):
            return matrices
    return None


def nearest(value: float, denominator: int) -> fmpq:
    """A fraction with a given denominator."""
    return fmpq(round(value * denominator), denominator)


def simplest(value: float, denominator: int) -> fmpq:
    """The fraction nearest to a number with at most a given denominator."""
    return as_fmpq(Fraction(value).limit_denominator(denominator))


def _rational_triangle(gram: Floats, denominator: int) -> list[fmpq]:
    return [nearest(gram[row, column], denominator) for column in range(len(gram)) for row in range(column + 1)]


def _repaired(condition: Condition, blocks: Blocks, triangles: Triangles) -> Triangles | None:
    """The same with every coefficient of p met; None where that is impossible."""
    first, *others = blocks
    within = reached(first.monomials)
    columns = [
        (k, entry, terms)
        for k, block in enumerate(others, 1)
        for entry, terms in entries(block)
        if not within.issuperset(terms)
    ]
    error = _error(condition, blocks, triangles)
    outside = sorted({e for e in error if e not in within} | {e for *_, t in columns for e in t if e not in within})
    if outside:
        change = _least_change([{e: c for e, c in t.items() if e not in within} for *_, t in columns], outside, error)
        if change is None:
            return None
        for (k, entry, _), value in zip(columns, change, strict=True):
            triangles[k][entry] += value
        error = _error(condition, blocks, triangles)
    counts: dict[Exponents, int] = {}
    plain = list(entries(first))
    for _, terms in plain:
        for e, twice in terms.items():
            counts[e] = counts.get(e, 0) + int(twice.p)
    for entry, terms in plain:
        for e in terms:
            triangles[0][entry] += error.get(e, fmpq(0)) / counts[e]
    return triangles


def _error(condition: Condition, blocks: Blocks, triangles: Triangles) -> Terms:
    """What the sum over the blocks lacks of p."""
    total: Terms = {e: c for e, c in condition.constant.items() if c}
    for block, triangle in zip(blocks, triangles, strict=True):
        plain: Terms = {}
        for column, b in enumerate(block.monomials):
            for row, a in enumerate(block.monomials[: column + 1]):
                value = triangle[column * (column + 1) // 2 + row] * (-1 if row == column else -2)
                e = tuple(map(add, a, b))
                plain[e] = plain.get(e, fmpq(0)) + value
        total = add_terms(total, multiply_terms({e: c for e, c in plain.items() if c}, block.product))
    return total


def _least_change(
    columns: Sequence[Mapping[Exponents, fmpq]], rows: Sequence[Exponents], target: Mapping[Exponents, fmpq]
) -> list[fmpq] | None:
    """The shortest x with ``sum_k x_k columns_k = target`` on the given rows; None without one."""
    if not columns:
        return None
    zero = fmpq(0)
    matrix = fmpq_mat(len(rows), len(columns), [column.get(e, zero) for e in rows for column in columns])
    right = fmpq_mat(len(rows), 1, [target.get(e, zero) for e in rows])
    solved = particular_solution(matrix * matrix.transpose(), right)
    if solved is None:
        return None
    change = matrix.transpose() * solved
    return [change[k, 0] for k in range(len(columns))]


def particular_solution(matrix: fmpq_mat, right: fmpq_mat) -> fmpq_mat | None:
    """Some solution of ``matrix x = right``, zero in the unknowns that are free; None without one."""
    height, width = matrix.nrows(), matrix.ncols()
    listed = [[*(matrix[i, j] for j in range(width)), right[i, 0]] for i in range(height)]
    reduced, rank = fmpq_mat(listed).rref()
    solution = [fmpq(0)] * width
    for i in range(rank):
        pivot = next(j for j in range(width + 1) if reduced[i, j])
        if pivot == width:
            return None
        solution[pivot] = reduced[i, width]
    return fmpq_mat(width, 1, solution)


def _rational_symmetric(triangle: Sequence[fmpq]) -> RationalMatrix:
    rows: list[list[fmpq]] = []
    for value in triangle:  # column by column: as the rows of the lower triangle
        if not rows or len(rows[-1]) == len(rows):
            rows.append([])
        rows[-1].append(value)
    return tuple(tuple(rows[max(i, j)][min(i, j)] for j in range(len(rows))) for i in range(len(rows)))


def is_definite(matrix: Sequence[Sequence[fmpq]]) -> bool:
    """Whether a symmetric matrix is positive definite."""
    pivots = _pivots(matrix)
    return pivots is not None and all(pivot > 0 for pivot in pivots)


def is_semidefinite(matrix: RationalMatrix) -> bool:
    """Whether a symmetric matrix is positive semidefinite."""
    return _pivots(matrix) is not None


def _pivots(matrix: Sequence[Sequence[fmpq]]) -> list[fmpq] | None:
    """The pivots of ``L D L^T`` of a symmetric matrix; None unless it is positive semidefinite.

    A pivot of zero is right only where the rest of its column is zero.
    """
    rest = [list(row) for row in matrix]
    pivots: list[fmpq] = []
    while rest:
        pivot, column = rest[0][0], rest[0][1:]
        if pivot < 0 or (not pivot and any(column)):
            return None
        pivots.append(pivot)
        rest = [
            [value - a * b / pivot if a and b else value for b, value in zip(column, row[1:], strict=True)]
            for a, row in zip(column, rest[1:], strict=True)
        ]
    return pivots


def round_parameters(problems: Sequence[Problem], solution: Solution, denominator: int) -> tuple[fmpq, ...] | None:
    """Rational parameters near those of a solution; None where the equations have no solution.

    Args:
        problems: as they were solved.
        solution: in floats.
        denominator: of those parameters that are free, and of numbers beside guards in the equations.
    """
    count = len(solution.parameters)
    values = [nearest(float(value), denominator) for value in solution.parameters]
    rows: list[dict[int, fmpq]] = []
    rights: list[fmpq] = []
    for (condition, blocks), grams in zip(problems, solution.grams, strict=True):
        equations, right, places = _outside(condition, blocks, len(values))
        rows += equations
        rights += right
        for block, entry in places:
            gram = grams[block]
            column = next(c for c in range(len(gram)) if (c + 1) * (c + 2) // 2 > entry)
            values.append(nearest(float(gram[entry - column * (column + 1) // 2, column]), denominator))
    if not rows:
        return tuple(values)
    return _solved(rows, rights, values, count)


def _outside(
    condition: Condition, blocks: Blocks, start: int
) -> tuple[list[dict[int, fmpq]], list[fmpq], list[tuple[int, int]]]:
    """The equations of one condition that the plain sum of squares does not enter, and the entries in them."""
    first, *others = blocks
    within = reached(first.monomials)
    place: dict[Exponents, dict[int, fmpq]] = {}
    used: list[tuple[int, int]] = []
    for k, block in enumerate(others, 1):
        for entry, terms in entries(block):
            outer = {e: c for e, c in terms.items() if e not in within}
            if not outer:
                continue
            for e, c in outer.items():
                place.setdefault(e, {})[start + len(used)] = -c
            used.append((k, entry))
    for parameter, slope in condition.slopes.items():
        for e, c in slope.items():
            if e not in within and c:
                place.setdefault(e, {})[parameter] = c
    for e, c in condition.constant.items():
        if e not in within and c:
            place.setdefault(e, {})
    return list(place.values()), [-condition.constant.get(e, fmpq(0)) for e in place], used


def _solved(
    rows: Sequence[dict[int, fmpq]], rights: Sequence[fmpq], values: list[fmpq], count: int
) -> tuple[fmpq, ...] | None:
    """The values with those changed that the equations determine, parameters before others."""
    columns = sorted({k for row in rows for k in row})
    matrix = fmpq_mat(len(rows), len(columns), [row.get(k, fmpq(0)) for row in rows for k in columns])
    errors = [right - sum(c * values[k] for k, c in row.items()) for row, right in zip(rows, rights, strict=True)]
    change = particular_solution(matrix, fmpq_mat(len(rows), 1, errors))
    if change is None:
        return None
    for j, column in enumerate(columns):
        values[column] += change[j, 0]
    return tuple(values[:count])
