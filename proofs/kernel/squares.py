"""The search for sums of squares that show the inequalities of a claim, with common polynomials mu.

The semidefinite program proposes mu for all inequalities at once; rounded, each inequality is shown by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Exponents, constant
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_blocks, monomials_between
from nonsmooth.proofs.sums_of_squares.conic_program import round_parameters, solve_inside
from nonsmooth.proofs.sums_of_squares.prove import WEAK, Effort, SumOfSquares, normalized, prove_positive
from nonsmooth.symbolic.numbers.polynomial import add_terms, multiply_terms

MU_DENOMINATORS = (1 << 6, 1 << 16)  # of the coefficients of mu, tried in turn

Terms = dict[Exponents, fmpq]
Shape = tuple[int, Exponents]  # a monomial of the function mu with a number


@dataclass(frozen=True)
class Shown:
    """Evidence that was found.

    Attributes:
        evidence: as a certificate holds it, of any kind.
        strict: whether it shows ``> 0`` off the origin (or everywhere, as the claim asks).
        mu: of squares, the coefficients of the functions mu; None of another kind.
    """

    evidence: Record
    strict: bool
    mu: tuple[fmpq, ...] | None = None


def search(claim: Claim) -> Record | None:
    """Squares for each inequality of a claim; None where they were not found."""
    proof = find(claim, Effort.STRICT if claim.strict else Effort.FULL)
    return None if proof is None else proof.evidence


def find(claim: Claim, effort: Effort, mu: tuple[fmpq, ...] | None = None) -> Shown | None:
    """The same, and whether they show that the inequalities are strict.

    Args:
        claim: without polynomials that are zero.
        effort: how far proofs are looked for, and whether it is also asked if all are ``>= 0``.
        mu: the coefficients of the functions mu where they are known.
    """
    if any(inequality.zeros for inequality in claim.inequalities):
        return None
    shapes = mu_shapes([claim])
    conditions = [condition_of(claim, inequality, shapes) for inequality in claim.inequalities]
    for values in [mu] if mu is not None else _proposals(conditions, len(shapes), weakly=effort in WEAK):
        proof = _with_mu(claim, conditions, values, effort)
        if proof is not None:
            evidence: Record = {"squares": proof[0]}
            if shapes:
                evidence["mu"] = _written_mu(claim, shapes, values)
            return Shown(evidence, proof[1], values)
    return None


def mu_shapes(claims: Sequence[Claim]) -> list[Shape]:
    """The monomials of the functions mu: up to the degree with which ``mu q`` reaches that of p.

    Args:
        claims: about functions of one basis, on the same face.
    """
    first = claims[0].inequalities
    if not first[0].pushes:
        return []
    highest = max(inequality.value.degree for claim in claims for inequality in claim.inequalities)
    pushed = max(push.degree for inequality in first for push in inequality.pushes)
    monomials = monomials_between(claims[0].count, 0, max(highest - pushed, 0))
    return [(j, exponents) for j in range(len(first[0].pushes)) for exponents in monomials]


def condition_of(claim: Claim, inequality: Inequality, shapes: Sequence[Shape]) -> Condition:
    """An inequality as the search states it: parameters are the coefficients of mu."""
    surfaces = [guard for name, guard in inequality.guards.items() if name[0] == "s"]
    bounds = tuple(terms_of(constant(claim.count, 1) - inequality.guards[f"u{k}"]) for k in _sides(inequality))
    pushes = [terms_of(push) for push in inequality.pushes]
    slopes = {k: multiply_terms(pushes[j], {e: fmpq(1)}) for k, (j, e) in enumerate(shapes)}
    terms = terms_of(inequality.value)
    return Condition(terms, slopes, tuple(map(terms_of, surfaces)), bounds, claim.count, claim.at_origin)


def _sides(inequality: Inequality) -> list[str]:
    """The variables that the cube bounds."""
    return [name[1:] for name in inequality.guards if name[0] == "u"]


def _guard_names(inequality: Inequality) -> list[str]:
    """The names of the guards in the order of :attr:`Condition.multipliers`."""
    sides = _sides(inequality)
    surfaces = [name for name in inequality.guards if name[0] == "s"]
    return [*surfaces, *(f"b{k}" for k in sides), *(f"{letter}{k}" for k in sides for letter in "ud")]


def _proposals(conditions: Sequence[Condition], parameters: int, *, weakly: bool) -> Iterator[tuple[fmpq, ...]]:
    """Coefficients of the functions mu."""
    if not parameters:
        yield ()
        return
    scaled = [normalized(condition) for condition in conditions]
    solved = solve_inside([(condition, build_blocks(condition)) for condition in scaled], parameters, bounded=False)
    for denominator in MU_DENOMINATORS if solved is not None else ():
        values = None if solved is None else round_parameters(*solved, denominator)
        if values is not None:
            yield values
    if solved is None and weakly:
        yield (fmpq(0),) * parameters


def _with_mu(
    claim: Claim, conditions: Sequence[Condition], mu: Sequence[fmpq], effort: Effort
) -> tuple[list[Any], bool] | None:
    """Squares for known functions mu, and whether all inequalities are strict."""
    squares, strict = [], True
    for inequality, condition in zip(claim.inequalities, conditions, strict=True):
        stated = with_values(condition, dict(enumerate(mu)))
        proved = prove_positive(stated, effort)
        if proved is None:
            return None
        strict = strict and proved.strict
        squares.append(_written(stated, proved, _guard_names(inequality)))
    return squares, strict


def with_values(condition: Condition, values: Mapping[int, fmpq]) -> Condition:
    """A condition in which all parameters are numbers."""
    total = dict(condition.constant)
    for k, slope in condition.slopes.items():
        total = add_terms(total, {e: c * values[k] for e, c in slope.items()})
    return replace(condition, constant={e: c for e, c in total.items() if c}, slopes={})


def _written_mu(claim: Claim, shapes: Sequence[Shape], mu: Sequence[fmpq]) -> list[list[Any]]:
    polynomials: list[list[Any]] = [[] for _ in claim.inequalities[0].pushes]
    for (j, exponents), value in zip(shapes, mu, strict=True):
        if value:
            polynomials[j].append([str(value), list(exponents)])
    return polynomials


def _written(stated: Condition, proved: SumOfSquares, names: Sequence[str]) -> list[Record]:
    """The evidence about the stated polynomial, from that about its multiple by powers of two."""
    divided = proved.condition
    whole = _ratio(stated.constant, divided.constant)
    ratios = list(map(_ratio, stated.multipliers, divided.multipliers))
    squares = []
    for block, gram in zip(proved.blocks, proved.grams, strict=True):
        factor = whole
        for number in block.factors:
            factor /= ratios[number]
        if any(map(any, gram)):
            rows = [[str(value * factor) for value in row[: i + 1]] for i, row in enumerate(gram)]
            guards = [names[number] for number in block.factors]
            squares.append({"guards": guards, "monomials": [list(m) for m in block.monomials], "gram": rows})
    return squares


def _ratio(stated: Mapping[Exponents, fmpq], divided: Mapping[Exponents, fmpq]) -> fmpq:
    """By how much a polynomial was divided."""
    return next((c / divided[e] for e, c in stated.items() if c), fmpq(1))
