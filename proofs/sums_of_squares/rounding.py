"""From a Gram matrix in floats to one in rationals that satisfies the equations exactly (Peyrl and Parrilo 2008).

Entries are rounded; then the least change of the entries beside guards repairs the monomials that the plain sum of
squares does not reach, and the rest of the error, divided among the entries of each monomial, goes into the plain sum
of squares.  If the floats lie inside the cone, so does the result for fine enough fractions: ``L D L^T`` tells.

Parameters of several conditions are rounded so that every condition can still be met exactly: monomials that no plain
sum of squares reaches (of too low or too high a degree) tie parameters to the numbers beside guards by linear
equations; the rounding keeps these.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray

from nonsmooth.proofs.sums_of_squares.ansatz import Blocks, Condition, reached, separates
from nonsmooth.proofs.sums_of_squares.conic_program import Grams, Problem, Solution, entries
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms

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
        triangles = _repaired(condition, blocks, [_triangle(gram, denominator) for gram in grams])
        if triangles is None:
            return None
        first, *others = found = tuple(map(_symmetric, triangles))
        holds = is_definite(first) if strict else is_semidefinite(first)
        if holds and all(map(is_semidefinite, others)) and not _error(condition, blocks, triangles):
            return found
    return None


def nearest(value: float, denominator: int) -> fmpq:
    """A fraction with a given denominator."""
    return fmpq(round(value * denominator), denominator)


def simplest(value: float, denominator: int) -> fmpq:
    """The fraction nearest to a number with at most a given denominator."""
    found = Fraction(value).limit_denominator(denominator)
    return fmpq(found.numerator, found.denominator)


def _triangle(gram: NDArray[np.float64], denominator: int) -> list[fmpq]:
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
                e = tuple(map(int.__add__, a, b))
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
    found = matrix.transpose() * solved
    return [found[k, 0] for k in range(len(columns))]


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


def _symmetric(triangle: Sequence[fmpq]) -> RationalMatrix:
    rows: list[list[fmpq]] = []
    for value in triangle:  # column by column: as the rows of the lower triangle
        if not rows or len(rows[-1]) == len(rows):
            rows.append([])
        rows[-1].append(value)
    return tuple(tuple(rows[max(i, j)][min(i, j)] for j in range(len(rows))) for i in range(len(rows)))


def is_definite(matrix: RationalMatrix) -> bool:
    """Whether a symmetric matrix is positive definite."""
    pivots = _pivots(matrix)
    return pivots is not None and all(pivot > 0 for pivot in pivots)


def is_semidefinite(matrix: RationalMatrix) -> bool:
    """Whether a symmetric matrix is positive semidefinite."""
    return _pivots(matrix) is not None


def _pivots(matrix: RationalMatrix) -> list[fmpq] | None:
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
        own, right, found = _outside(condition, blocks, count, len(values))
        rows += own
        rights += right
        for block, entry in found:
            gram = grams[block]
            column = next(c for c in range(len(gram)) if (c + 1) * (c + 2) // 2 > entry)
            values.append(nearest(float(gram[entry - column * (column + 1) // 2, column]), denominator))
    if not rows:
        return tuple(values)
    return _solved(rows, rights, values, count)


def _outside(
    condition: Condition, blocks: Blocks, parameters: int, start: int
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
