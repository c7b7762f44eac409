"""The search for sums of squares that show an inequality, in the form the checker multiplies out."""

from __future__ import annotations

from typing import Any

from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Polynomial, constant
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_guards
from nonsmooth.proofs.sums_of_squares.prove import Effort, normalized, prove_positive


def _terms(value: Polynomial) -> dict[tuple[int, ...], fmpq]:
    return {e: fmpq(c.numerator, c.denominator) for e, c in value.terms.items()}


def search(claim: Claim) -> dict[str, Any] | None:
    """Squares for each inequality of a claim without multipliers mu; None where they were not found."""
    found = []
    for inequality in claim.inequalities:
        squares = None if inequality.pushes or inequality.zeros else _squares(claim, inequality)
        if squares is None:
            return None
        found.append(squares)
    return {"squares": found}


def _squares(claim: Claim, inequality: Inequality) -> list[dict[str, Any]] | None:
    count = inequality.value.count
    surfaces = {name: own for name, own in inequality.guards.items() if name[0] == "s"}
    sides = [name[1:] for name in inequality.guards if name[0] == "u"]
    bounds = tuple(_terms(constant(count, 1) - inequality.guards[f"u{k}"]) for k in sides)
    condition = Condition(
        _terms(inequality.value), {}, tuple(map(_terms, surfaces.values())), bounds, count, claim.at_origin
    )
    proved = prove_positive(condition, Effort.FULL if not claim.strict else Effort.STRICT)
    if proved is None:
        return None
    names = [*surfaces, *(f"b{k}" for k in sides), *(f"{letter}{k}" for k in sides for letter in "ud")]
    return written(condition, proved.evidence.terms, names)


def written(condition: Condition, terms: Any, names: list[str]) -> list[dict[str, Any]]:
    """The evidence about the stated polynomial, from that about its multiple by powers of two."""
    divided = normalized(condition)
    ratio = lambda stated, small: next((c / small[e] for e, c in stated.items() if c), fmpq(1))
    whole = ratio(condition.constant, divided.constant)
    guards = list(zip(build_guards(condition), build_guards(divided), strict=True))
    found = []
    for term in terms:
        factor, own = whole, []
        for number in term.factors:
            stated, small = guards[number]
            factor /= ratio(stated, small)
            own.append(names[number])
        rows = [[str(value * factor) for value in row[: i + 1]] for i, row in enumerate(term.gram)]
        if any(any(row) for row in term.gram):
            found.append({"guards": own, "monomials": [list(m) for m in term.monomials], "gram": rows})
    return found
