"""Forms on a cone of two generators: decided completely by isolating real roots.

On ``g_1 + t g_2``, ``0 < t < oo``, the form ``A + r B`` is a function of one variable: with ``q = |g_1 + t g_2|^2`` it
is ``A(t) + sqrt(q(t)) B(t)``.  It can change sign or vanish only at roots of ``A^2 - q B^2`` (of A where that is
identically zero, or where there is no r), so one rational point between neighbouring roots shows the sign there, and
at a root the signs of A and B do.  No square root is taken and no half-angle is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from nonsmooth.proofs.inequalities.dense_polynomials import difference, product, trimmed, value, without_zeros
from nonsmooth.proofs.inequalities.forms import Pieces, Problem, Vector, surd_sign
from nonsmooth.proofs.inequalities.real_roots import RealRoot, Sturm, positive_roots
from nonsmooth.proofs.inequalities.subdivision import Violation
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Terms


@dataclass(frozen=True)
class RadicalFunction:
    """``A(t) + sqrt(q(t)) B(t)`` on ``0 < t < oo``; ascending coefficients.

    Attributes:
        plain: A.
        radial: B; empty where there is no r.
        square: q.
    """

    plain: tuple[Number, ...]
    radial: tuple[Number, ...]
    square: tuple[Number, ...]

    @cached_property
    def critical(self) -> list[Number]:
        """A polynomial with all zeros among its roots; empty where the function vanishes or is not decided by it."""
        if not trimmed(self.radial):
            return trimmed(self.plain)
        return trimmed(self.norm) or trimmed(self.plain)

    @cached_property
    def norm(self) -> list[Number]:
        """``A^2 - q B^2``."""
        return difference(product(self.plain, self.plain), product(self.square, product(self.radial, self.radial)))

    @staticmethod
    def samples(roots: Sequence[RealRoot]) -> list[Fraction]:
        """One point between any two neighbours of zero, the given roots and infinity."""
        return [root.low for root in roots[:1]] + [root.high for root in roots] or [Fraction(1)]

    def sign_at(self, t: Fraction) -> int:
        """Sign at a rational point."""
        return surd_sign(value(self.plain, t), value(self.radial, t), value(self.square, t))

    def sign_at_root(self, root: RealRoot) -> int:
        """Sign at a root of :attr:`critical`."""
        first, second = root.sign_of(self.plain), root.sign_of(self.radial) * root.sign_of(self.square)
        if first * second >= 0:
            return first or second
        return first * root.sign_of(self.norm)

    def end_sign(self, *, last: bool) -> int:
        """Sign at ``t = 0`` or, scaled, at infinity."""
        k = -1 if last else 0
        radial = self.radial[k] if self.radial else 0
        return surd_sign(self.plain[k], radial, self.square[k])


@dataclass(frozen=True)
class RootEvidence:
    """All roots at which the function could change: between them one point each shows the sign."""

    roots: tuple[RealRoot, ...]

    def check(self, problem: Problem) -> bool:
        """Re-verify that these are all roots, and the signs between, at and beside them."""
        line = line_of(problem)
        if not line.critical:
            return not problem.strict
        critical = tuple(without_zeros(line.critical))
        genuine = all(root.coefficients == critical and root.low > 0 and root.check() for root in self.roots)
        apart = all(a.high <= b.low for a, b in zip(self.roots, self.roots[1:], strict=False))
        complete = Sturm(critical).count(Fraction(0), None) == len(self.roots)
        return genuine and apart and complete and _failure(line, self.roots, problem.strict) is None


@dataclass(frozen=True)
class Zero:
    """A strict claim fails at ``g_1 + t g_2`` for the one t at a root that has no name in the field."""

    root: RealRoot


def decide_binary(problem: Problem) -> RootEvidence | Violation | Zero:
    """Decide the claim: its evidence, or where it fails."""
    line = line_of(problem)
    roots = tuple(positive_roots(line.critical)) if line.critical else ()
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


def _failure(line: RadicalFunction, roots: Sequence[RealRoot], strict: bool) -> tuple[Any, Any] | RealRoot | None:
    """Weights ``(s, t)`` of the generators, or a root, where the claim fails; None where it holds."""
    if not line.critical:
        return (1, 1) if strict else None
    least = int(strict)
    for t in line.samples(roots):
        if line.sign_at(t) < least:
            return 1, t
    for last in (False, True):
        if line.end_sign(last=last) < least:
            return int(not last), int(last)
    return next((root for root in roots if line.sign_at_root(root) < least), None) if strict else None


def line_of(problem: Problem) -> RadicalFunction:
    """The problem on its two generators, as a function of one variable."""
    exact = tuple(tuple(evaluated(x) for x in g) for g in problem.generators)
    return edge_line(problem, exact, problem.pieces(exact), (0, 1))


def edge_line(problem: Problem, generators: Sequence[Vector], pieces: Pieces, edge: tuple[int, int]) -> RadicalFunction:
    """The form along an edge, as a function of ``t = lambda_second/lambda_first``."""
    field, degree = problem.form.plain.field, problem.form.degree
    square = problem.square_of_distance([generators[k] for k in edge])
    radial = () if pieces.radial is None else _dense(pieces.radial, edge, degree - 1, field)
    return RadicalFunction(_dense(pieces.plain, edge, degree, field), radial, _dense(square, (0, 1), 2, field))


def _dense(terms: Terms, edge: tuple[int, int], degree: int, field: NumberField) -> tuple[Number, ...]:
    """Coefficients along an edge by the power of its second generator."""
    first, second = edge
    found = {e[second]: c for e, c in terms.items() if e[first] + e[second] == degree}
    return tuple(field(evaluated(found.get(k, 0))) for k in range(degree + 1))
