"""The search for sums of squares that show the inequalities of a claim, with common polynomials mu.

The semidefinite program proposes mu for all inequalities at once; rounded, each inequality is shown by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Exponents, Polynomial, constant
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_ansatz, build_guards, monomials_between
from nonsmooth.proofs.sums_of_squares.conic_program import solve_inside
from nonsmooth.proofs.sums_of_squares.gram_certificate import SquareTerm
from nonsmooth.proofs.sums_of_squares.prove import Effort, normalized, prove_positive
from nonsmooth.proofs.sums_of_squares.rounded_parameters import round_parameters
from nonsmooth.symbolic.numbers.polynomial import add_terms, multiply_terms

MU_DENOMINATORS = (1 << 6, 1 << 16)  # of the coefficients of mu, tried in turn

Terms = dict[Exponents, fmpq]
Shape = tuple[int, Exponents]  # a monomial of the function mu with a number


@dataclass(frozen=True)
class Asked:
    """An inequality as the search states it: parameters are the coefficients of mu, guards have their names."""

    condition: Condition
    names: tuple[str, ...]


def search(claim: Claim) -> dict[str, Any] | None:
    """Squares for each inequality of a claim; None where they were not found.

    Args:
        claim: without polynomials that are zero.
    """
    if any(inequality.zeros for inequality in claim.inequalities):
        return None
    shapes = _shapes(claim)
    asked = [_asked(claim, inequality, shapes) for inequality in claim.inequalities]
    for mu in _proposals(claim, asked, len(shapes)):
        squares = _all_squares(claim, asked, mu)
        if squares is not None:
            return {"squares": squares, "mu": _written_mu(claim, shapes, mu)} if shapes else {"squares": squares}
    return None


def _shapes(claim: Claim) -> list[Shape]:
    """The monomials of the functions mu: up to the degree with which ``mu q`` reaches that of p."""
    count = len(claim.inequalities[0].pushes)
    if not count:
        return []
    highest = max(own.value.degree for own in claim.inequalities)
    pushed = max(push.degree for own in claim.inequalities for push in own.pushes)
    own = monomials_between(claim.count, 0, max(highest - pushed, 0))
    return [(j, exponents) for j in range(count) for exponents in own]


def _asked(claim: Claim, inequality: Inequality, shapes: Sequence[Shape]) -> Asked:
    surfaces = {name: own for name, own in inequality.guards.items() if name[0] == "s"}
    sides = [name[1:] for name in inequality.guards if name[0] == "u"]
    bounds = tuple(_terms(constant(claim.count, 1) - inequality.guards[f"u{k}"]) for k in sides)
    pushes = [_terms(own) for own in inequality.pushes]
    slopes = {k: multiply_terms(pushes[j], {e: fmpq(1)}) for k, (j, e) in enumerate(shapes)}
    condition = Condition(
        _terms(inequality.value), slopes, tuple(map(_terms, surfaces.values())), bounds, claim.count, claim.at_origin
    )
    names = (*surfaces, *(f"b{k}" for k in sides), *(f"{letter}{k}" for k in sides for letter in "ud"))
    return Asked(condition, names)


def _terms(value: Polynomial) -> Terms:
    return {e: fmpq(c.numerator, c.denominator) for e, c in value.terms.items()}


def _proposals(claim: Claim, asked: Sequence[Asked], parameters: int) -> Iterator[tuple[fmpq, ...]]:
    """Coefficients of the functions mu."""
    if not parameters:
        yield ()
        return
    own = [normalized(one.condition) for one in asked]
    solved = solve_inside([(condition, build_ansatz(condition)) for condition in own], parameters, bounded=False)
    for denominator in MU_DENOMINATORS if solved is not None else ():
        values = None if solved is None else round_parameters(*solved, denominator)
        if values is not None:
            yield values
    if solved is None and not claim.strict:
        yield (fmpq(0),) * parameters


def _all_squares(claim: Claim, asked: Sequence[Asked], mu: Sequence[fmpq]) -> list[Any] | None:
    found = []
    for one in asked:
        condition = with_values(one.condition, dict(enumerate(mu)))
        proved = prove_positive(condition, Effort.STRICT if claim.strict else Effort.FULL)
        if proved is None:
            return None
        found.append(_written(condition, proved.evidence.terms, one.names))
    return found


def with_values(condition: Condition, values: Mapping[int, fmpq]) -> Condition:
    """A condition in which all parameters are numbers."""
    total = dict(condition.constant)
    for k, slope in condition.slopes.items():
        total = add_terms(total, {e: c * values[k] for e, c in slope.items()})
    return replace(condition, constant={e: c for e, c in total.items() if c}, slopes={})


def _written_mu(claim: Claim, shapes: Sequence[Shape], mu: Sequence[fmpq]) -> list[list[Any]]:
    count = len(claim.inequalities[0].pushes)
    found: list[list[Any]] = [[] for _ in range(count)]
    for (j, exponents), value in zip(shapes, mu, strict=True):
        if value:
            found[j].append([str(value), list(exponents)])
    return found


def _written(condition: Condition, terms: Sequence[SquareTerm], names: Sequence[str]) -> list[dict[str, Any]]:
    """The evidence about the stated polynomial, from that about its multiple by powers of two."""
    divided = normalized(condition)
    whole = _ratio(condition.constant, divided.constant)
    guards = list(zip(build_guards(condition), build_guards(divided), strict=True))
    found = []
    for term in terms:
        factor = whole
        for number in term.factors:
            factor /= _ratio(*guards[number])
        if any(any(row) for row in term.gram):
            rows = [[str(value * factor) for value in row[: i + 1]] for i, row in enumerate(term.gram)]
            own = [names[number] for number in term.factors]
            found.append({"guards": own, "monomials": [list(m) for m in term.monomials], "gram": rows})
    return found


def _ratio(stated: Mapping[Exponents, fmpq], divided: Mapping[Exponents, fmpq]) -> fmpq:
    """By how much a polynomial was divided."""
    return next((c / divided[e] for e, c in stated.items() if c), fmpq(1))
