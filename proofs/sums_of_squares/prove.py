"""Proofs of ``p > 0`` on basic semialgebraic sets: floats propose sums of squares, rational arithmetic decides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from flint import fmpq

from nonsmooth.proofs.sums_of_squares.ansatz import Ansatz, Condition, build_ansatz, build_guards, without_idle
from nonsmooth.proofs.sums_of_squares.conic_program import solve, solve_inside
from nonsmooth.proofs.sums_of_squares.gram_certificate import GuardedClaim, SquareTerm, SumOfSquares
from nonsmooth.proofs.sums_of_squares.rounding import rounded
from nonsmooth.symbolic.numbers.polynomial import Exponents

LEVELS = (0, 1)  # degrees beyond that of p, in steps of two
MOST_UNKNOWNS = 6_000  # entries of Gram matrices: beyond that a program takes too long


@dataclass(frozen=True)
class Proved:
    """A claim with its evidence."""

    claim: GuardedClaim
    evidence: SumOfSquares


class Effort(Enum):
    """How far a proof is looked for."""

    HASTY = "p > 0, with the lowest degrees"
    STRICT = "p > 0"
    FULL = "p > 0, else p >= 0"


def prove_positive(condition: Condition, effort: Effort = Effort.STRICT) -> Proved | None:
    """A proof of a condition without parameters; None where none is found, which refutes nothing.

    Args:
        condition: with numbers for all parameters.
        effort: how far it is looked for.
    """
    scaled = normalized(condition)
    for level in LEVELS[:1] if effort is Effort.HASTY else LEVELS:
        ansatz = build_ansatz(scaled, level)
        if sum(len(block.monomials) ** 2 for block in ansatz.blocks) > 2 * MOST_UNKNOWNS:
            break
        found = _found(scaled, ansatz, strict=True)
        if found is not None:
            return found
    if effort is not Effort.FULL:
        return None
    return _found(scaled, without_idle(build_ansatz(scaled), scaled.support), strict=False)


def claim_of(condition: Condition, *, strict: bool) -> GuardedClaim:
    """What a condition without parameters claims."""
    guards = build_guards(condition)
    return GuardedClaim(condition.constant, guards, condition.variables, condition.at_origin, strict)


def _found(condition: Condition, ansatz: Ansatz, *, strict: bool) -> Proved | None:
    claim = claim_of(condition, strict=strict)
    if not strict and not condition.constant:
        return Proved(claim, SumOfSquares((SquareTerm((), (), ()),)))
    if not any(block.monomials for block in ansatz.blocks):  # no square has the terms of the condition
        return None
    evidence = _strictly(claim, condition, ansatz) if strict else _weakly(claim, condition, ansatz)
    return None if evidence is None else Proved(claim, evidence)


def _strictly(claim: GuardedClaim, condition: Condition, ansatz: Ansatz) -> SumOfSquares | None:
    found = solve_inside([(condition, ansatz)], 0, bounded=False)
    if found is None:
        return None
    ((_, kept),), solution = found
    return rounded(claim, kept, solution.grams[0])


def _weakly(claim: GuardedClaim, condition: Condition, ansatz: Ansatz) -> SumOfSquares | None:
    solution = solve([(condition, ansatz)], 0, inner=0.0, bounded=False, strict=False)
    return None if solution is None else rounded(claim, ansatz, solution.grams[0])


def normalized(condition: Condition) -> Condition:
    """The same condition with p and guards divided by powers of two near their largest coefficients."""
    guards = tuple(_divided(guard, _size(guard)) for guard in condition.guards)
    sizes = [_size(terms) for terms in (condition.constant, *condition.slopes.values()) if terms]
    size = max(sizes, default=fmpq(1))
    slopes = {k: _divided(slope, size) for k, slope in condition.slopes.items()}
    return replace(condition, constant=_divided(condition.constant, size), slopes=slopes, guards=guards)


def _size(terms: Mapping[Exponents, fmpq]) -> fmpq:
    """A power of two that is at most twice the largest coefficient, and at least half of it."""
    largest = max((abs(c) for c in terms.values()), default=fmpq(0))
    if not largest:
        return fmpq(1)
    shift = int(largest.p).bit_length() - int(largest.q).bit_length()
    return fmpq(2**shift) if shift >= 0 else fmpq(1, 2**-shift)


def _divided(terms: Mapping[Exponents, fmpq], size: fmpq) -> dict[Exponents, fmpq]:
    return {e: c / size for e, c in terms.items() if c}
