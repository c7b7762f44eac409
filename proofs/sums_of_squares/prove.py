"""Proofs of ``p > 0`` on basic semialgebraic sets: floats propose sums of squares, rational arithmetic decides.

A polynomial p is positive wherever ``g_j >= 0``, but perhaps at the origin, if ``p = sum_j G_j z_j^T Q_j z_j`` with
``G_0 = 1``, every other G_j a product of the g, z_j vectors of monomials, ``Q_0`` positive definite, every other Q_j
positive semidefinite, and z_0 zero nowhere but at the origin (Putinar 1993; Schmüdgen 1991 for products).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from itertools import product, takewhile

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.sums_of_squares.ansatz import (
    Block,
    Blocks,
    Condition,
    build_blocks,
    gram_entries,
    plain_block,
    programs,
    without_idle,
)
from nonsmooth.proofs.sums_of_squares.conic_program import (
    RationalMatrix,
    particular_solution,
    rounded,
    solve,
    solve_inside,
)
from nonsmooth.symbolic.numbers.polynomial import Exponents, multiply_terms

MOST_UNKNOWNS = 6_000  # entries of Gram matrices: beyond that a program takes too long, and many gigabytes


@dataclass(frozen=True)
class SumOfSquares:
    """A polynomial as the sum over blocks of a product of guards and ``z^T Q z``; of nothing where it is zero.

    Attributes:
        condition: what it proves, without parameters.
        blocks: guards and monomials z.
        grams: Q of each block.
        strict: whether it proves ``> 0``, not only ``>= 0``.
    """

    condition: Condition
    blocks: Blocks
    grams: tuple[RationalMatrix, ...]
    strict: bool


class Effort(Enum):
    """How far a proof is looked for."""

    HASTY = "p > 0, with the lowest degrees"
    STRICT = "p > 0"
    FULL = "p > 0, else p >= 0"
    ALONE = "p > 0, else p >= 0, by squares without guards"


# Beside guards: by how much degrees go beyond that of p, in steps of two.
LEVELS = {Effort.HASTY: (0,), Effort.STRICT: (0, 1), Effort.FULL: (0, 1), Effort.ALONE: ()}
WEAK = (Effort.FULL, Effort.ALONE)  # that also ask whether p >= 0


def prove_positive(condition: Condition, effort: Effort = Effort.STRICT) -> SumOfSquares | None:
    """A proof of a condition without parameters, :func:`normalized`; None where none is found, which refutes nothing.

    Args:
        condition: with numbers for all parameters.
        effort: how far it is looked for.
    """
    scaled = normalized(condition)
    for blocks in () if _vanishes_along_an_axis(scaled) else _programs(scaled, effort):
        proof = _strictly(scaled, blocks)
        if proof is not None:
            return proof
    return _weakly(scaled, effort) if effort in WEAK else None


def _vanishes_along_an_axis(condition: Condition) -> bool:
    """Whether p is zero on half an axis beside the origin, at points of the set: then no proof is strict."""
    zero = (0,) * condition.variables
    if any(abs(bound.get(zero, fmpq(0))) >= 1 for bound in condition.bounds):
        return False
    for k in range(condition.variables):
        guards = [_along_axis(guard, k) for guard in condition.guards]
        for side in (1, -1):
            first = (
                coefficients[min(coefficients)] * side ** min(coefficients) for coefficients in guards if coefficients
            )
            if not _along_axis(condition.constant, k) and all(value > 0 for value in first):
                return True
    return False


def _along_axis(terms: Mapping[Exponents, fmpq], k: int) -> dict[int, fmpq]:
    """The coefficients of a polynomial on an axis, by powers."""
    return {e[k]: c for e, c in terms.items() if e[k] == sum(e) and c}


def _programs(condition: Condition, effort: Effort) -> Iterator[Blocks]:
    """The sums that are tried: of squares alone, which are few, and where those do not serve, beside guards."""
    if effort is not Effort.HASTY:
        yield from filter(_is_solvable, [plain_block(condition)])
    every = (blocks for level in LEVELS[effort] for blocks in programs(condition, level))
    yield from takewhile(_is_solvable, every)


def _is_solvable(blocks: Blocks) -> bool:
    """Whether a program is small enough."""
    return gram_entries(blocks) <= 2 * MOST_UNKNOWNS


def _strictly(condition: Condition, blocks: Blocks) -> SumOfSquares | None:
    result = solve_inside([(condition, blocks)], 0, bounded=False) if gram_entries(blocks) else None
    if result is None:
        return None
    ((_, remaining),), solution = result
    grams = rounded(condition, remaining, solution.grams[0], strict=True)
    return None if grams is None else SumOfSquares(condition, remaining, grams, strict=True)


def _weakly(condition: Condition, effort: Effort) -> SumOfSquares | None:
    if not condition.constant:
        return SumOfSquares(condition, (), (), strict=False)
    for built in (plain_block(condition), *(build_blocks(condition, level) for level in LEVELS[effort][:1])):
        blocks = without_idle(built, condition.support)
        if gram_entries(blocks) and _is_solvable(blocks):
            grams = known_squares(condition, blocks)
            if grams is None:
                solution = solve([(condition, blocks)], 0, inner=0.0, bounded=False, strict=False)
                grams = None if solution is None else rounded(condition, blocks, solution.grams[0], strict=False)
            if grams is not None:
                return SumOfSquares(condition, blocks, grams, strict=False)
    return None


def known_squares(condition: Condition, blocks: Blocks) -> tuple[RationalMatrix, ...] | None:
    """Gram matrices of ``p = sum_k c_k G_k v_k^2``, ``c_k >= 0``, with v_k a monomial or a guard; None without any.

    The friction ``y |y|`` makes ``-V' = y^3`` where ``y >= 0``: the guard y beside the square of y.  Such a p is zero
    along faces, so its matrices are singular, and no rounding of a semidefinite program keeps them semidefinite; this
    is a linear program.  Floats say which products are used, and exact numbers what their weights are.
    """
    products = [(k, square) for k, block in enumerate(blocks) for square in _squares(condition, block)]
    terms = [multiply_terms(blocks[k].product, multiply_terms(square, square)) for k, square in products]
    rows = sorted({e for polynomial in (condition.constant, *terms) for e in polynomial})
    table = [[polynomial.get(e, fmpq(0)) for polynomial in terms] for e in rows]
    target = [condition.constant.get(e, fmpq(0)) for e in rows]
    matrix = np.array([[float(entry) for entry in row] for row in table]).reshape(len(rows), len(terms))
    proposed = solve_program(np.ones(len(terms)), A_eq=matrix, b_eq=[float(value) for value in target])
    if proposed.status != 0:
        return None
    used = [k for k, weight in enumerate(proposed.x) if weight > 0]
    equations = fmpq_mat(len(rows), len(used), [row[k] for row in table for k in used])
    solution = particular_solution(equations, fmpq_mat(len(rows), 1, target))
    weights = [] if solution is None else solution.entries()
    if len(weights) < len(used) or min(weights) < 0:
        return None
    grams = [[[fmpq(0)] * len(block.monomials) for _ in block.monomials] for block in blocks]
    for weight, (k, square) in zip(weights, (products[number] for number in used), strict=True):
        places = [(blocks[k].monomials.index(e), c) for e, c in square.items()]
        for (i, first), (j, second) in product(places, places):
            grams[k][i][j] += weight * first * second
    return tuple(tuple(map(tuple, gram)) for gram in grams)


def _squares(condition: Condition, block: Block) -> Iterator[Mapping[Exponents, fmpq]]:
    """The monomials of a block, and the guards that are sums of several of them."""
    yield from ({e: fmpq(1)} for e in block.monomials)
    yield from (guard for guard in condition.guards if len(guard) > 1 and set(guard) <= set(block.monomials))


def normalized(condition: Condition) -> Condition:
    """The same condition with p and guards divided by powers of two near their largest coefficients."""
    guards = tuple(_divided(guard, _size(guard)) for guard in condition.guards)
    size = max((_size(terms) for terms in (condition.constant, *condition.slopes.values()) if terms), default=fmpq(1))
    slopes = {k: _divided(slope, size) for k, slope in condition.slopes.items()}
    return replace(condition, constant=_divided(condition.constant, size), slopes=slopes, guards=guards)


def _size(terms: Mapping[Exponents, fmpq]) -> fmpq:
    """A power of two that is at most twice the largest coefficient, and at least half of it."""
    largest = max((abs(c) for c in terms.values()), default=fmpq(0))
    if not largest:
        return fmpq(1)
    return fmpq(2) ** (int(largest.p).bit_length() - int(largest.q).bit_length())


def _divided(terms: Mapping[Exponents, fmpq], size: fmpq) -> dict[Exponents, fmpq]:
    return {e: c / size for e, c in terms.items() if c}
