"""Inequalities between polynomials on closed cells: a proof, a witness, or where the search got stuck.

``prove(sense, polynomial, region)`` decides ``polynomial < 0``, ``<= 0``, ``> 0`` or ``>= 0`` on a closed region of the
plane, bounded or not, with coefficients in the scene's field.  Where a curve cuts the cell, rational points are tried
first, elsewhere last.  Each simplicial part goes through the same ways:

1. non-negative coefficients in the generators, with a few bisections (extreme rays for a linear form);
2. what is complete: real roots for two generators, principal minors for a quadratic form;
3. squares: where ``>= 0`` is claimed, an irreducible factorization over Q takes off the square that divides the form;
4. more bisections, cutting edges first where the form touches zero.

Nothing undecided is left for homogeneous polynomials in the plane and for quadratic forms.  Elsewhere the search ends
undecided where the polynomial touches zero inside the cell at a point that none of the cuts hits.

Floats propose these points in each triangle of the region, at distances from the origin that fall by powers of eight;
the first few at which a claim seems to fail are evaluated exactly, and only an exact failure counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import combinations
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np
from flint import fmpq

from nonsmooth.analysis.cells.region import Region, Triple, affine
from nonsmooth.proofs.inequalities.forms import PLANE, Problem, Question, Sense, build_parts, place_of, triangles
from nonsmooth.proofs.inequalities.real_roots import (
    Coefficients,
    RealRoot,
    positive_roots,
    samples_between,
    trimmed,
    value,
)
from nonsmooth.proofs.inequalities.subdivision import (
    LONG_BITS,
    NEARBY_STEPS,
    Role,
    SubCone,
    UndecidedCorners,
    Vector,
    Violation,
    effort_left,
    take_effort,
)
from nonsmooth.symbolic.formulas.surfaces import factorize
from nonsmooth.symbolic.mechanics.contact_states import cofactors
from nonsmooth.symbolic.numbers.coefficients import height
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane_arrays import float_points
from nonsmooth.symbolic.numbers.polynomial import Polynomial, Terms, float_values, float_values_and_sizes

# ---- forms on simplicial cones that are decided completely ---------------------------------------
#
# Of two generators by real roots, quadratic ones by minors.
#
# *Two generators.* On ``g_1 + t g_2``, ``0 < t < oo``, the form is a polynomial in t.  It can change sign or vanish
# only at its roots, so one rational point between neighbouring roots shows the sign there.
#
# *Quadratic forms.* In the generators the form is ``lambda^T M lambda``, ``lambda >= 0``.  If all principal submatrices
# of lower order are copositive, M is not copositive iff ``det M < 0`` and ``adj M >= 0`` (Cottle, Habetler and Lemke
# 1970; Hadeler 1983); then ``lambda = adj M (1, ..., 1)`` shows it.  A zero inside a face of a copositive form is a
# kernel vector of the face's submatrix, which is positive semidefinite; so the zeros are sums of those that are alone
# on their face.
#
# *Elsewhere* a cone whose form touches zero inside an edge, or on a ray that leaves a corner, is cut exactly there:
# halving approaches such a zero for ever; a cut makes it a corner.  The zeros looked for are roots of polynomials in
# one variable: the form on an edge, and, near a corner of a triangle, its coefficients of the highest power of that
# corner (the lowest terms of the polynomial there), as a form on the opposite edge.


def decide_binary(problem: Problem) -> Violation | RealRoot | None:
    """Decide the claim: where it fails; None where it holds.

    A strict claim may fail at ``g_1 + t g_2`` alone, for a root t that has no name in the field: that is returned.
    """
    line = line_of(problem)
    roots = tuple(positive_roots(line)) if any(line) else ()
    failure = _failure(line, roots, problem.strict)
    if failure is None:
        return None
    if isinstance(failure, RealRoot):
        exact = failure.exact()
        if exact is None:
            return failure
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
    return edge_line(problem, problem.part(exact).form, (0, 1))


def edge_line(problem: Problem, form: Terms, edge: tuple[int, int]) -> Coefficients:
    """The form of a part along an edge by powers of ``t = lambda_second/lambda_first``, ascending."""
    field, degree = problem.form.field, problem.form.degree
    first, second = edge
    coefficients = {e[second]: c for e, c in form.items() if e[first] + e[second] == degree}
    return tuple(field(evaluated(coefficients.get(k, 0))) for k in range(degree + 1))


Matrix: TypeAlias = list[list[Any]]


def decide_quadratic(problem: Problem) -> Violation | UndecidedCorners | None:
    """Decide the claim for a form of degree two without guards: where it fails; None where it holds.

    Stuck where it is false and no point of the cell was found that shows it.
    """
    matrix = gram_matrix(problem)
    count = len(matrix)
    zeros: list[list[Any]] = []
    for size in range(1, count + 1):
        for face in combinations(range(count), size):
            minor = [[matrix[i][j] for j in face] for i in face]
            adjugate = _adjugate(minor)
            determinant = sum((minor[0][k] * adjugate[k][0] for k in range(size)), 0 * matrix[0][0])
            entries = [entry for row in adjugate for entry in row]
            if sign(determinant) < 0 and all(sign(entry) >= 0 for entry in entries):
                weights = _spread([sum(row[1:], row[0]) for row in adjugate], face, count)
                return _violation(problem, weights) or UndecidedCorners(problem.generators)
            kernel = next(([row[k] for row in adjugate] for k in range(size) if any(row[k] for row in adjugate)), None)
            if not determinant and kernel is not None and len({sign(x) for x in kernel} | {0}) == 2 and all(kernel):
                zeros.append(_spread([abs(x) for x in kernel], face, count))
    if problem.strict:
        for weights in _candidates(problem, zeros):
            point = _combination(problem, weights)
            if problem.is_violated_at(point):
                return Violation(point)
    return None


def gram_matrix(problem: Problem) -> Matrix:
    """M in the generators."""
    terms, count = problem.whole.form, len(problem.generators)
    zero = problem.form.field.zero

    def entry(i: int, j: int) -> Any:
        value = terms.get(tuple(int(k == i) + int(k == j) for k in range(count)), zero)
        return value if i == j else value / 2

    return [[entry(i, j) for j in range(count)] for i in range(count)]


def _candidates(problem: Problem, zeros: Sequence[list[Any]]) -> Iterator[list[Any]]:
    """Zeros, and sums of the origin with zeros at infinity: one of them is a point of the cell if any zero is."""
    yield from zeros
    origins = [z for z in zeros if problem.role(_combination(problem, z)) is Role.ORIGIN]
    for origin in origins:
        for other in zeros:
            yield [a + b for a, b in zip(origin, other, strict=True)]


def _violation(problem: Problem, weights: list[Any]) -> Violation | None:
    """A point of the cell at or beside the weights, at which the form is negative."""
    count = len(weights)
    total = sum(weights[1:], weights[0])
    for k in range(NEARBY_STEPS):
        point = _combination(problem, [w + total / (count * 4**k) for w in weights])
        for candidate in (_combination(problem, weights), point):
            if problem.is_violated_at(candidate):
                return Violation(candidate)
    return None


def _combination(problem: Problem, weights: Sequence[Any]) -> Vector:
    columns = zip(*problem.generators, strict=True)
    return tuple(sum((w * x for w, x in zip(weights, c, strict=True)), 0 * weights[0] * c[0]) for c in columns)


def _spread(values: Sequence[Any], face: Sequence[int], count: int) -> list[Any]:
    placed = dict(zip(face, values, strict=True))
    zero = values[0] - values[0]
    return [placed.get(k, zero) for k in range(count)]


def _adjugate(matrix: Matrix) -> Matrix:
    """Of a symmetric matrix of at most three rows."""
    if len(matrix) == 1:
        return [[1 + 0 * matrix[0][0]]]
    if len(matrix) == 2:
        (a, b), (_, c) = matrix
        return [[c, -b], [-b, a]]
    first, second, third = ((row[0], row[1], row[2]) for row in matrix)
    return [list(row) for row in cofactors(first, second, third)]


CUT_DEPTH = 3  # zeros are looked for in the first parts only
# Largest degree times 2^(square roots in the coefficients), times the length of rational ones: Sturm chains below a
# tenth of a second.
ROOT_WORK = 64
OF_A_ROOT = 150  # coefficients of a cone that cost as much as one unit of this work

Edge: TypeAlias = tuple[int, int]


def zero_cut(problem: Problem, part: SubCone) -> tuple[int, int, Any] | Violation | None:
    """Where to cut a part, ``(first, second, weight)``; or a point on an edge that refutes the claim."""
    if part.depth > CUT_DEPTH:
        return None
    generators = [tuple(map(evaluated, g)) for g in part.corners]
    for edge in combinations(range(len(generators)), 2):
        line = edge_line(problem, part.form, edge)
        for t, is_zero in _suspect_parameters(line):
            point = tuple(a + b * t for a, b in zip(generators[edge[0]], generators[edge[1]], strict=True))
            if problem.is_violated_at(point):
                return Violation(point)
            if is_zero:
                return (*edge, t / (1 + t))
    if len(generators) == 3:
        for edge, line in _lowest_terms(problem, part.form):
            for t, is_zero in _suspect_parameters(line):
                if is_zero:
                    return (*edge, t / (1 + t))
    return None


def _suspect_parameters(line: Coefficients) -> Iterator[tuple[Any, bool]]:
    """Parameters at which a form on an edge is negative, or zero without a name of higher degree."""
    curve = trimmed(line)
    work = _root_work(curve) if curve else 0
    if not curve or work > min(ROOT_WORK, effort_left() // OF_A_ROOT):
        return
    take_effort(work * OF_A_ROOT)
    roots = positive_roots(curve)
    for t in samples_between(roots):
        if sign(value(curve, t)) < 0:
            yield fmpq(t.numerator, t.denominator), False
    for root in roots:
        exact = root.exact()
        if exact is not None:
            yield exact, True


def _root_work(curve: Coefficients) -> int:
    masks = longest = 0
    for c in curve:
        for mask, coefficient in c.terms.items():
            masks |= mask
            longest = max(longest, height(coefficient))
    return (len(curve) - 1) * (1 + longest // LONG_BITS) << masks.bit_count()


def _lowest_terms(problem: Problem, terms: Terms) -> Iterator[tuple[Edge, Coefficients]]:
    """For each corner, the coefficients of its highest power as a form on the opposite edge."""
    field = problem.form.field
    for corner, edge in ((0, (1, 2)), (1, (0, 2)), (2, (0, 1))):
        top = max((e[corner] for e in terms), default=0)
        degree = problem.form.degree - top
        coefficients = {e[edge[1]]: c for e, c in terms.items() if e[corner] == top}
        yield edge, tuple(field(evaluated(coefficients.get(k, 0))) for k in range(degree + 1))


# ---- the prover ----------------------------------------------------------------------------------


PARTS = 12  # of each side of a triangle
SCALES = (1, 8, 64, 512)  # factors of the first corner, the origin where the region holds it
CONFIRMED = 4  # points of each triangle that are evaluated exactly

Weights: TypeAlias = tuple[int, int, int]


def counterexample(question: Question) -> tuple[Any, Any] | None:
    """A point of the region inside all guards at which a claim fails; None where none was found."""
    for triangle in triangles(question.region, holds_origin=question.holds_origin):
        for weights in _suspects(question, triangle):
            point = _point(triangle, weights)
            if question.fails_at(point):
                return point
    return None


@cache
def _grid() -> tuple[Weights, ...]:
    """Weights of the corners of a triangle, no point twice."""
    by_place: dict[tuple[Fraction, Fraction], Weights] = {}
    for scale in SCALES:
        for j in range(PARTS + 1):
            for k in range(PARTS + 1 - j):
                weights = ((PARTS - j - k) * scale, j, k)
                total = sum(weights)
                by_place.setdefault((Fraction(j, total), Fraction(k, total)), weights)
    return tuple(by_place.values())


def _suspects(question: Question, triangle: Sequence[Triple]) -> Iterator[Weights]:
    """The weights at which floats say that the claim fails, the clearest failures first."""
    weights = np.array(_grid(), dtype=float)
    x, y, w = (weights @ float_points(triangle)).T
    inside = w > 0
    with np.errstate(all="ignore"):
        points = np.column_stack([x / w, y / w])
        for guard in question.region.guards:
            inside &= float_values(guard.terms, points) > 0
        values, sizes = float_values_and_sizes(question.claimed.terms, points)
        share = values / sizes
    fails = (share <= 0 if question.sense.strict else share < 0) & inside & np.isfinite(share)
    order = np.argsort(np.where(fails, share, np.inf), kind="stable")
    for k in order[: min(CONFIRMED, int(fails.sum()))]:
        yield _grid()[int(k)]


def _point(triangle: Sequence[Triple], weights: Weights) -> tuple[Any, Any]:
    return affine(sum(c * v for c, v in zip(column, weights, strict=True)) for column in zip(*triangle, strict=True))


LITTLE_WORK = 500  # coefficients of parts looked at before the complete ways are tried
MUCH_WORK = 50_000  # about a second
MAX_EXACT_ROOTS = 6  # square roots in the field up to which quotients of two generators are carried out


QuestionT = TypeVar("QuestionT")  # a question about the plane, or a claim of a certificate


@dataclass(frozen=True)
class Proof(Generic[QuestionT]):
    """The claim holds.

    Attributes:
        question: the claim.
        evidence: as a certificate holds it; None of a question about the plane.
    """

    question: QuestionT
    evidence: Any = None


@dataclass(frozen=True)
class Counterexample(Generic[QuestionT]):
    """A point of the closed cell at which the claim is false.

    Attributes:
        question: the claim.
        point: in the claim's variables.
        value: the polynomial there.
    """

    question: QuestionT
    point: tuple[Any, ...]
    value: Any


@dataclass(frozen=True)
class ZeroBetween:
    """A strict claim fails on one direction ``first + t second`` whose t, of high degree, has no name in the field.

    Attributes:
        question: the claim.
        part: the cone of two rays and the form on it.
        zero: the isolated root t.
    """

    question: Question
    part: Problem
    zero: RealRoot

    @property
    def point(self) -> tuple[Any, ...]:
        """A point close to the zero (the bounds of t enclose it)."""
        first, second = self.part.generators
        near = tuple(a + b * self.zero.low for a, b in zip(first, second, strict=True))
        return place_of(near, self.part, self.question)


@dataclass(frozen=True)
class Undecided(Generic[QuestionT]):
    """Neither proved nor refuted.

    Attributes:
        question: the claim.
        part: corners ``(x, y)`` of the part on which the search ended; directions where unbounded.
    """

    question: QuestionT
    part: tuple[tuple[Any, ...], ...] = ()

    @property
    def reason(self) -> str:
        """One sentence for people."""
        corners = ", ".join(place_text(map(_number, corner), 5) for corner in self.part)
        return f"the sign was not found on the part of the cell with corners {corners}"


Outcome: TypeAlias = Proof[Question] | Counterexample[Question] | ZeroBetween | Undecided[Question]


def prove(sense: Sense | str, polynomial: Polynomial, region: Region, *, except_origin: bool = False) -> Outcome:
    """Decide the sign of a polynomial on a closed region.

    Args:
        sense: "<0", "<=0", ">0" or ">=0".
        polynomial: in ("x", "y").
        region: the closed region of the plane.
        except_origin: leave the origin out of a strict claim.

    Raises:
        ValueError: for a polynomial in other variables.
    """
    if polynomial.variables != PLANE:
        raise ValueError(f"required a polynomial in {PLANE}, received {polynomial.variables}")
    question = Question(Sense(sense), polynomial, region, except_origin)
    origin = (polynomial.field.zero,) * 2
    if question.fails_at(origin):
        return _witness(question, origin)
    refuting = counterexample(question) if region.guards else None
    if refuting is not None:
        return _witness(question, refuting)
    stuck: Undecided[Question] | None = None
    for part in build_parts(question):
        outcome = decide(part)
        if isinstance(outcome, Violation):
            return _witness(question, place_of(outcome.point, part, question))
        if isinstance(outcome, RealRoot):
            return ZeroBetween(question, part, outcome)
        if isinstance(outcome, UndecidedCorners):
            stuck = stuck or Undecided(question, tuple(place_of(g, part, question) for g in outcome.corners))
    if stuck is not None and not region.guards and (refuting := counterexample(question)) is not None:
        return _witness(question, refuting)
    return stuck or Proof(question)


def decide(problem: Problem) -> Violation | RealRoot | UndecidedCorners | None:
    """Decide one simplicial part: what refutes it, or where the search ended; None where it is proved."""
    outcome = problem.subdivided(LITTLE_WORK)
    if not isinstance(outcome, UndecidedCorners):
        return outcome
    if len(problem.generators) == 2 and len(problem.form.field.radicands) <= MAX_EXACT_ROOTS:
        return decide_binary(problem)
    if not problem.guards and problem.form.degree == 2:
        quadratic = decide_quadratic(problem)
        return outcome if isinstance(quadratic, UndecidedCorners) else quadratic
    if not problem.guards and not problem.strict:
        rest = _without_square(problem)
        of_rest = outcome if rest is None else decide(rest)
        if of_rest is None or (isinstance(of_rest, Violation) and problem.is_violated_at(of_rest.point)):
            return of_rest
    work = min(MUCH_WORK, effort_left())
    return problem.subdivided(work, lambda part: zero_cut(problem, part)) if work else outcome


def _without_square(problem: Problem) -> Problem | None:
    """``>= 0`` of what is left of a form without the largest square that divides it; None where that is all."""
    factored = factorize(problem.form)
    if factored is None or all(exponent == 1 for _, exponent in factored[1]):
        return None
    rest = Polynomial.constant(problem.form.field, problem.form.variables, factored[0])
    for factor, exponent in factored[1]:
        rest *= factor ** (exponent % 2)
    return replace(problem, form=rest)


def _witness(question: Question, point: tuple[Any, ...]) -> Counterexample[Question]:
    return Counterexample(question, point, question.polynomial(point))


def _number(value: Any) -> Any:
    return value if hasattr(value, "sign") else float(value)
