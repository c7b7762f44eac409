"""Signs of products: factors with signs of their own.

A square such as ``(x - 2 y)^2`` has no non-negative coefficients on any cone that holds its zeros inside; factored, it
needs none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from nonsmooth.proofs.inequalities.forms import Problem
from nonsmooth.proofs.inequalities.subdivision import Stuck, Violation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.surfaces import factorize

Decide: TypeAlias = Callable[[Problem], Any]
Confirm: TypeAlias = Callable[[Any, Problem], bool]


@dataclass(frozen=True)
class SignedFactor:
    """One factor with evidence of its sign; an even power needs none for a claim that is not strict."""

    polynomial: Polynomial
    exponent: int
    sign: int
    evidence: Any | None


@dataclass(frozen=True)
class ProductEvidence:
    """``form = constant * prod factor**exponent`` with factors of known signs."""

    constant: Number
    factors: tuple[SignedFactor, ...]

    def check(self, problem: Problem, confirms: Confirm) -> bool:
        """Multiply out, re-verify the evidence of each factor, and count signs."""
        product = Polynomial.constant(problem.form.field, problem.form.variables, self.constant)
        total = self.constant.sign()
        for factor in self.factors:
            product = product * factor.polynomial**factor.exponent
            total *= factor.sign**factor.exponent
            if factor.evidence is None:
                if problem.strict or factor.exponent % 2:
                    return False
            elif not confirms(factor.evidence, _signed(problem, factor.polynomial, factor.sign)):
                return False
        return not product - problem.form and total > 0


def decide_product(problem: Problem, decide: Decide) -> ProductEvidence | Violation | None:
    """Prove the claim factor by factor; None where the form has one factor only, or factors without a sign."""
    factored = factorize(problem.form)
    if factored is None or (len(factored[1]) == 1 and factored[1][0][1] == 1):
        return None
    constant, total, found = factored[0], factored[0].sign(), list[SignedFactor]()
    for polynomial, exponent in factored[1]:
        here = _sign_inside(problem, polynomial)
        evidence = None
        if exponent % 2 or problem.strict:
            evidence = decide(_signed(problem, polynomial, here))
            if isinstance(evidence, Violation) and problem.is_violated_at(evidence.point):
                return evidence
            if isinstance(evidence, Violation | Stuck):
                return None
        total *= here**exponent
        found.append(SignedFactor(polynomial, exponent, here, evidence))
    return ProductEvidence(constant, tuple(found)) if total > 0 else None


def _signed(problem: Problem, polynomial: Polynomial, sign: int) -> Problem:
    return replace(problem, form=polynomial * sign)


def _sign_inside(problem: Problem, polynomial: Polynomial) -> int:
    """Sign at a point inside the cone that is no zero."""
    weight = 1
    while True:
        columns = zip(*problem.generators, strict=True)
        powers = [weight**k for k in range(len(problem.generators))]
        value = polynomial([sum((p * x for p, x in zip(powers, c, strict=True)), 0 * c[0]) for c in columns])
        if value:
            return int(value.sign())
        weight += 1
