"""Which sums of squares are tried for a polynomial inequality: products of guards and the monomials beside each.

Where p and the guards vanish at the origin, terms of too low an order could only be zero: they are left out, since a
Gram matrix that is forced to be singular survives no rounding.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import combinations, combinations_with_replacement
from operator import add
from typing import TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms


@dataclass(frozen=True)
class Condition:
    """``p > 0`` where guards are ``>= 0`` and forms b have ``-1 <= b <= 1``, p affine in parameters.

    Attributes:
        constant: p for parameters zero.
        slopes: what each parameter adds, by its number.
        guards: polynomials.
        bounds: affine forms b; none where the domain is a cone.
        variables: how many.
        at_origin: whether p must be positive at the origin too.
    """

    constant: Mapping[Exponents, fmpq]
    slopes: Mapping[int, Mapping[Exponents, fmpq]]
    guards: tuple[Mapping[Exponents, fmpq], ...]
    bounds: tuple[Mapping[Exponents, fmpq], ...]
    variables: int
    at_origin: bool = False

    @property
    def support(self) -> set[Exponents]:
        """The monomials of p."""
        return {e for terms in (self.constant, *self.slopes.values()) for e, c in terms.items() if c}

    @cached_property
    def multipliers(self) -> tuple[Terms, ...]:
        """What is ``>= 0`` there: the guards, ``1 - b^2`` for each bound, and ``1 - b``, ``1 + b``."""
        one = {(0,) * self.variables: fmpq(1)}
        opposite = [{e: -c for e, c in b.items()} for b in self.bounds]
        squares = [add_terms(one, multiply_terms(b, less)) for b, less in zip(self.bounds, opposite, strict=True)]
        sides = [add_terms(one, side) for b, less in zip(self.bounds, opposite, strict=True) for side in (less, b)]
        return (*map(dict, self.guards), *squares, *sides)


@dataclass(frozen=True)
class Block:
    """A product of guards, and the monomials whose squares and products it multiplies."""

    factors: tuple[int, ...]
    product: Mapping[Exponents, fmpq]
    monomials: tuple[Exponents, ...]


Blocks: TypeAlias = tuple[Block, ...]  # the first one is the plain sum of squares


def without_idle(blocks: Blocks, support: Collection[Exponents]) -> Blocks:
    """Without monomials whose squares nothing can cancel: their rows of the plain Gram matrix could only be zero.

    A square stands for itself where p, a product of two other monomials, or a block beside guards reaches it.
    """
    first, *others = blocks
    beside = {
        tuple(map(add, e, shift)) for block in others for shift in reached(block.monomials) for e in block.product
    }
    monomials = list(first.monomials)
    while True:
        mixed = {tuple(map(add, a, b)) for a, b in combinations(monomials, 2)}
        alive = {*support, *beside, *mixed}
        needed = [a for a in monomials if tuple(2 * e for e in a) in alive]
        if len(needed) == len(monomials):
            return (Block((), first.product, tuple(monomials)), *others)
        monomials = needed


def build_blocks(condition: Condition, level: int = 0) -> Blocks:
    """The blocks for a condition.

    Args:
        condition: p and where it must be positive.
        level: how far degrees go beyond that of p, in steps of two.
    """
    low, one = _least_order(condition), {(0,) * condition.variables: fmpq(1)}
    half = max((max(map(sum, condition.support), default=0) + 1) // 2, 1) + level
    blocks = [Block((), one, monomials_between(condition.variables, (low + 1) // 2, half))]
    for factors in _products(condition):
        product: Terms = dict(one)
        for k in factors:
            product = multiply_terms(product, condition.multipliers[k])
        least = max(0, low - min(map(sum, product)))
        room = (2 * half - max(map(sum, product))) // 2
        monomials = monomials_between(condition.variables, (least + 1) // 2, room)
        if monomials:
            blocks.append(Block(factors, product, monomials))
    return tuple(blocks)


def _least_order(condition: Condition) -> int:
    """The least degree of terms that squares need."""
    zero = (0,) * condition.variables
    beyond = any(guard.get(zero, 0) < 0 for guard in condition.guards)  # the origin is no point of the domain
    return 0 if beyond or condition.at_origin else min(map(sum, condition.support), default=0)


def programs(condition: Condition, level: int = 0) -> Iterator[Blocks]:
    """The blocks that are tried: those beside what is positive at the origin, where the Newton polyhedron tells more.

    The others are left to guards that vanish at the origin, whose terms may cancel what lies beneath the polyhedron.
    """
    blocks, zero = build_blocks(condition, level), (0,) * condition.variables
    if not _least_order(condition) or is_above_order(condition.support):
        yield blocks
        return
    inner = [block for block in blocks if block.product.get(zero, 0) > 0]
    yield tuple(block for block in above_polyhedron(condition.support, inner) if block.monomials or not block.factors)
    if len(inner) < len(blocks):
        yield blocks


# Near the origin squares have no terms beneath the Newton polyhedron of p, the hull of its exponents and all above:
# with weights of the variables for which no term of p has a lower weight than d, the terms of least weight of squares,
# and of squares beside what is positive at the origin, are not negative and cannot cancel, so none is lower than d.


def is_above_order(support: Collection[Exponents]) -> bool:
    """Whether the lowest terms hold a power of every variable: the polyhedron is that of all terms of their degree."""
    order = min(map(sum, support), default=0)
    return sum(sum(exponents) == max(exponents) == order for exponents in support) == len(next(iter(support), ()))


def above_polyhedron(support: Collection[Exponents], blocks: Collection[Block]) -> list[Block]:
    """Blocks with the monomials whose squares lie above the polyhedron beside all terms of the product."""
    corners = np.array(sorted(support), float)

    @cache  # blocks ask for the same places, and most lie above a corner
    def holds(*place: int) -> bool:
        return bool((corners <= place).all(axis=1).any()) or _has_weights(corners.T, place)

    def is_above(m: Exponents, block: Block) -> bool:
        squares = ([2 * power + more for power, more in zip(m, e, strict=True)] for e in block.product)
        return all(holds(*square) for square in squares)

    return [replace(block, monomials=tuple(m for m in block.monomials if is_above(m, block))) for block in blocks]


def plain_block(condition: Condition) -> Blocks:
    """The plain sum of squares alone, of the monomials in half the Newton polytope of p.

    A polynomial that is a sum of squares everywhere has no others (Reznick 1978): far fewer than all up to its degree.
    """
    support = sorted(condition.support)
    degrees = list(map(sum, support))
    corners = np.array(support, float).reshape(len(support), condition.variables).T
    candidates = monomials_between(condition.variables, (min(degrees) + 1) // 2, max(degrees) // 2) if support else ()
    inside = tuple(m for m in candidates if tuple(2 * e for e in m) in support or _is_mixture(corners, 2 * np.array(m)))
    return (Block((), {(0,) * condition.variables: fmpq(1)}, inside),)


def _is_mixture(corners: Floats, place: Floats) -> bool:
    """Whether a place lies in the convex hull of columns."""
    return bool((place <= corners.max(axis=1)).all()) and _has_weights(
        np.vstack([corners, -corners]), [*place, *-place]
    )


def _has_weights(rows: Floats, most: Sequence[float]) -> bool:
    """Whether a mixture of columns has entries of at most so much, in floats: what is proposed need not be certain."""
    ones = np.ones((1, len(rows[0])))
    return solve_program(0 * ones[0], A_ub=rows, b_ub=most, A_eq=ones, b_eq=[1.0]).status == 0


def _products(condition: Condition) -> Iterator[tuple[int, ...]]:
    """Each guard alone, and products of two affine ones (of sides of the box only beside a guard)."""
    guards, squares = len(condition.guards), len(condition.bounds)
    yield from ((k,) for k in range(guards + squares))
    affine = [k for k, guard in enumerate(condition.multipliers) if max(map(sum, guard)) == 1]
    yield from (pair for pair in combinations(affine, 2) if pair[0] < guards)


def gram_entries(blocks: Blocks) -> int:
    """How many entries the Gram matrices of a program have: what it costs."""
    return sum(len(block.monomials) ** 2 for block in blocks)


def monomials_between(count: int, low: int, high: int) -> tuple[Exponents, ...]:
    """All exponents of total degrees from low to high."""
    return tuple(e for degree in range(low, high + 1) for e in monomials_of(count, degree))


def monomials_of(count: int, degree: int) -> Iterator[Exponents]:
    """All exponents of a total degree."""
    for chosen in combinations_with_replacement(range(count), degree):
        yield tuple(chosen.count(k) for k in range(count))


def reached(monomials: Collection[Exponents]) -> set[Exponents]:
    """The products of two monomials."""
    return {tuple(map(add, a, b)) for a in monomials for b in monomials}


def separates(monomials: Collection[Exponents], *, at_origin: bool) -> bool:
    """Whether monomials vanish together nowhere, or unless ``at_origin`` nowhere but at the origin.

    The constant is among them, or a power of every variable.
    """
    if any(not any(exponents) for exponents in monomials):
        return True
    alone = {next(k for k, e in enumerate(m) if e) for m in monomials if sum(map(bool, m)) == 1}
    return not at_origin and len(alone) == max(map(len, monomials), default=-1)
