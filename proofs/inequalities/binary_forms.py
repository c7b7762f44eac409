"""Forms on a cone of two generators: decided completely by isolating real roots.

On ``g_1 + t g_2``, ``0 < t < oo``, the form is a polynomial in t.  It can change sign or vanish only at its roots, so
one rational point between neighbouring roots shows the sign there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.inequalities.dense_polynomials import Coefficients, trimmed, value, without_zeros
from nonsmooth.proofs.inequalities.forms import Pieces, Problem
from nonsmooth.proofs.inequalities.real_roots import RealRoot, Sturm, positive_roots, samples_between
from nonsmooth.proofs.inequalities.subdivision import Violation
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import sign


@dataclass(frozen=True)
class RootEvidence:
    """All roots at which the form could change: between them one point each shows the sign."""

    roots: tuple[RealRoot, ...]

    def check(self, problem: Problem) -> bool:
        """Re-verify that these are all roots, and the signs between, at and beside them."""
        line = line_of(problem)
        curve = tuple(without_zeros(trimmed(line)))
        if not curve:
            return not problem.strict
        genuine = all(root.coefficients == curve and root.low > 0 and root.check() for root in self.roots)
        apart = all(a.high <= b.low for a, b in zip(self.roots, self.roots[1:], strict=False))
        complete = Sturm(curve).count(Fraction(0), None) == len(self.roots)
        return genuine and apart and complete and _failure(line, self.roots, problem.strict) is None


@dataclass(frozen=True)
class Zero:
    """A strict claim fails at ``g_1 + t g_2`` for the one t at a root that has no name in the field."""

    root: RealRoot


def decide_binary(problem: Problem) -> RootEvidence | Violation | Zero:
    """Decide the claim: its evidence, or where it fails."""
    line = line_of(problem)
    roots = tuple(positive_roots(line)) if any(line) else ()
    failure = _failure(line, roots, problem.strict)
    if failure is None:
        return RootEvidence(roots)
    if isinstance(failure, RealRoot):
        exact = failure.exact()
        if exact is None:
            return Zero(failure)
        failure = (1, exact)
    s, t = failure
    first, second = problem.generators
    return Violation(tuple(s * a + t * b for a, b in zip(first, second, strict=True)))


def _failure(line: Coefficients, roots: Sequence[RealRoot], strict: bool) -> tuple[Any, Any] | RealRoot | None:
    """Weights ``(s, t)`` of the generators, or a root, where the claim fails; None where it holds."""
    if not any(line):
        return (1, 1) if strict else None
    least = int(strict)
    for t in samples_between(roots):
        if sign(value(line, t)) < least:
            return 1, t
    if sign(line[0]) < least:
        return 1, 0
    if sign(line[-1]) < least:
        return 0, 1
    return roots[0] if strict and roots else None


def line_of(problem: Problem) -> Coefficients:
    """The form on its two generators by powers of ``t = lambda_second/lambda_first``, ascending."""
    exact = tuple(tuple(evaluated(x) for x in g) for g in problem.generators)
    return edge_line(problem, problem.pieces(exact), (0, 1))


def edge_line(problem: Problem, pieces: Pieces, edge: tuple[int, int]) -> Coefficients:
    """The form of a part along an edge by powers of ``t = lambda_second/lambda_first``, ascending."""
    field, degree = problem.form.field, problem.form.degree
    first, second = edge
    found = {e[second]: c for e, c in pieces.form.items() if e[first] + e[second] == degree}
    return tuple(field(evaluated(found.get(k, 0))) for k in range(degree + 1))
