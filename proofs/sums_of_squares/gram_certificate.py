"""Sums of squares with rational Gram matrices, checked by exact elimination.

A polynomial p is positive wherever ``g_j >= 0``, but perhaps at the origin, if ``p = sum_j G_j z_j^T Q_j z_j`` with
``G_0 = 1``, every other G_j a product of the g, z_j vectors of monomials, ``Q_0`` positive definite, every other Q_j
positive semidefinite, and z_0 zero nowhere but at the origin (Putinar 1993; Schmüdgen 1991 for products).  Here that
is verified: by comparing coefficients, and by ``L D L^T`` in rationals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq

from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms

RationalMatrix: TypeAlias = tuple[tuple[fmpq, ...], ...]


@dataclass(frozen=True)
class GuardedClaim:
    """``p > 0`` where all guards are ``>= 0``, at the origin only if ``at_origin``; or ``p >= 0`` there.

    Attributes:
        terms: of p, rational coefficients by exponents.
        guards: the same for each g.
        variables: how many.
        at_origin: whether p must be positive at the origin too.
        strict: whether ``p >= 0`` is not enough.
    """

    terms: Mapping[Exponents, fmpq]
    guards: tuple[Mapping[Exponents, fmpq], ...]
    variables: int
    at_origin: bool = False
    strict: bool = True


@dataclass(frozen=True)
class SquareTerm:
    """``prod_(j in factors) g_j * z^T Q z``.

    Attributes:
        factors: numbers of guards; none for a plain sum of squares.
        monomials: z, by exponents.
        gram: Q, symmetric.
    """

    factors: tuple[int, ...]
    monomials: tuple[Exponents, ...]
    gram: RationalMatrix

    def expanded(self, guards: Sequence[Mapping[Exponents, fmpq]]) -> Terms:
        """The polynomial that it is."""
        total: Terms = {}
        for a, row in zip(self.monomials, self.gram, strict=True):
            for b, value in zip(self.monomials, row, strict=True):
                exponents = tuple(map(int.__add__, a, b))
                total[exponents] = total.get(exponents, fmpq(0)) + value
        product = {exponents: value for exponents, value in total.items() if value}
        for factor in self.factors:
            product = multiply_terms(product, guards[factor])
        return product


@dataclass(frozen=True)
class SumOfSquares:
    """The evidence for one claim; the first term is the plain sum of squares, which makes it strict."""

    terms: tuple[SquareTerm, ...]

    def proves(self, claim: GuardedClaim) -> bool:
        """Whether the claim follows."""
        if not self.terms or self.terms[0].factors:
            return False
        total: Terms = {}
        for term in self.terms:
            total = add_terms(total, term.expanded(claim.guards))
        if total != {e: c for e, c in claim.terms.items() if c}:
            return False
        if not claim.strict:
            return all(is_semidefinite(term.gram) for term in self.terms)
        first, *others = self.terms
        apart = separates(first.monomials, at_origin=claim.at_origin)
        return apart and is_definite(first.gram) and all(is_semidefinite(term.gram) for term in others)


def separates(monomials: Sequence[Exponents], *, at_origin: bool) -> bool:
    """Whether monomials vanish together nowhere, or unless ``at_origin`` nowhere but at the origin.

    The constant is among them, or a power of every variable.
    """
    if any(not any(exponents) for exponents in monomials):
        return True
    if at_origin:
        return False
    alone = {next(k for k, e in enumerate(m) if e) for m in monomials if sum(1 for e in m if e) == 1}
    return bool(monomials) and len(alone) == len(monomials[0])


def is_definite(matrix: RationalMatrix) -> bool:
    """Whether a symmetric matrix is positive definite."""
    pivots = eliminated(matrix)
    return pivots is not None and all(pivot > 0 for pivot in pivots)


def is_semidefinite(matrix: RationalMatrix) -> bool:
    """Whether a symmetric matrix is positive semidefinite."""
    return eliminated(matrix) is not None


def eliminated(matrix: RationalMatrix) -> list[fmpq] | None:
    """The pivots of ``L D L^T``; None unless the matrix is symmetric and positive semidefinite.

    A pivot of zero is right only where the rest of its column is zero.
    """
    rest = [list(row) for row in matrix]
    if any(rest[i][j] != rest[j][i] for i in range(len(rest)) for j in range(i)):
        return None
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
