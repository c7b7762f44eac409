"""The semidefinite program behind sums of squares, in floats: a proposal, never a proof.

Unknown are shared parameters and one Gram matrix for each block of each condition; coefficients are compared monomial
by monomial, and the least eigenvalue of the Gram matrices is maximized.  The program is handed to Clarabel as it is:
for many small programs that takes a small part of the time of a modelling language.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.sums_of_squares.ansatz import Block, Blocks, Condition, separates
from nonsmooth.symbolic.numbers.polynomial import Exponents

Grams: TypeAlias = tuple[NDArray[np.float64], ...]
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

    parameters: NDArray[np.float64]
    grams: tuple[Grams, ...]
    margin: float


@dataclass
class _Rows:
    """A sparse matrix that grows."""

    rows: list[int]
    columns: list[int]
    values: list[float]
    count: int = 0

    def add(self, row: int, column: int, value: float) -> None:
        self.rows.append(row)
        self.columns.append(column)
        self.values.append(value)


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
    left: list[Block] = []
    for block, gram in zip(blocks, grams, strict=True):
        kept = tuple(m for m, size in zip(block.monomials, np.diag(gram), strict=True) if size > SMALL)
        if kept or not left:
            left.append(replace(block, monomials=kept))
    return condition, tuple(left)


def solve(
    problems: Sequence[Problem],
    parameters: int,
    *,
    inner: float,
    bounded: bool,
    strict: bool = True,
    price: NDArray[np.float64] | None = None,
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
    matrix, right = _Rows([], [], []), []
    for (condition, blocks), own in zip(problems, starts, strict=True):
        right += _comparison(condition, blocks, own, matrix)
    cones: list[Any] = [clarabel.ZeroConeT(matrix.count)]
    limits = _limits(parameters, margin, matrix, bounded=bounded)
    if price is not None:
        matrix.add(matrix.count, margin, -1.0)
        matrix.count += 1
        limits.append(-least)
    right += limits
    cones.append(clarabel.NonnegativeConeT(len(limits)))
    for (_, blocks), own in zip(problems, starts, strict=True):
        for k, (block, start) in enumerate(zip(blocks, own, strict=True)):
            size = len(block.monomials)
            for row, column, weight in _triangle(size):
                here = start + column * (column + 1) // 2 + row
                matrix.add(matrix.count, here, -weight)
                if row == column:
                    matrix.add(matrix.count, margin, inner if k else 1.0)
                matrix.count += 1
                right.append(0.0)
            if size:
                cones.append(clarabel.PSDTriangleConeT(size) if size > 1 else clarabel.NonnegativeConeT(1))
    if not np.isfinite([*matrix.values, *right]).all():  # coefficients beyond the range of floats
        return None
    shape = (matrix.count, total)
    rows = sparse.csc_matrix((matrix.values, (matrix.rows, matrix.columns)), shape=shape)
    objective = np.zeros(total)
    objective[margin] = -1.0
    if price is not None:
        objective[: margin + 1] = [*price, 0.0]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = ITERATIONS
    nothing = sparse.csc_matrix((total, total))
    found = clarabel.DefaultSolver(nothing, objective, rows, np.array(right), cones, settings).solve()
    values = np.asarray(found.x)
    if not len(values) or not np.all(np.isfinite(values)) or (strict and not values[margin] > LEAST_MARGIN):
        return None
    grams = tuple(
        tuple(_symmetric(values, start, len(block.monomials)) for block, start in zip(blocks, own, strict=True))
        for (_, blocks), own in zip(problems, starts, strict=True)
    )
    return Solution(values[:parameters], grams, float(values[margin]))


def _places(problems: Sequence[Problem], start: int) -> tuple[list[list[int]], int]:
    """Where the entries of each Gram matrix begin among the unknowns, and how many unknowns there are."""
    starts = []
    for _, blocks in problems:
        own = []
        for block in blocks:
            own.append(start)
            start += len(block.monomials) * (len(block.monomials) + 1) // 2
        starts.append(own)
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
            shift = tuple(map(int.__add__, a, b))
            twice = 1 if row == column else 2
            terms = {tuple(map(int.__add__, shift, e)): c * twice for e, c in block.product.items()}
            yield column * (column + 1) // 2 + row, terms


def _comparison(condition: Condition, blocks: Blocks, starts: Sequence[int], matrix: _Rows) -> list[float]:
    """One row for each monomial: the sum over the blocks less p is zero."""
    place: dict[Exponents, int] = {}

    def row_of(exponents: Exponents) -> int:
        if exponents not in place:
            place[exponents] = matrix.count
            matrix.count += 1
        return place[exponents]

    for block, start in zip(blocks, starts, strict=True):
        for k, terms in entries(block):
            for exponents, value in terms.items():
                matrix.add(row_of(exponents), start + k, float(value))
    for parameter, slope in condition.slopes.items():
        for exponents, value in slope.items():
            matrix.add(row_of(exponents), parameter, -float(value))
    for exponents in condition.constant:
        row_of(exponents)
    return [float(condition.constant.get(exponents, 0)) for exponents in place]


def _limits(parameters: int, margin: int, matrix: _Rows, *, bounded: bool) -> list[float]:
    """The margin is at most 1, and parameters lie between -1 and 1."""
    matrix.add(matrix.count, margin, 1.0)
    matrix.count += 1
    for parameter in range(parameters if bounded else 0):
        for side in (1.0, -1.0):
            matrix.add(matrix.count, parameter, side)
            matrix.count += 1
    return [1.0] * (1 + 2 * parameters * bounded)


def _symmetric(values: NDArray[np.float64], start: int, size: int) -> NDArray[np.float64]:
    gram = np.zeros((size, size))
    for row, column, _ in _triangle(size):
        gram[row, column] = gram[column, row] = values[start + column * (column + 1) // 2 + row]
    return gram
