"""Forms on simplicial cones that are decided completely: of two generators by real roots, quadratic ones by minors.

*Two generators.*  On ``g_1 + t g_2``, ``0 < t < oo``, the form is a polynomial in t.  It can change sign or vanish only
at its roots, so one rational point between neighbouring roots shows the sign there.

*Quadratic forms.*  In the generators the form is ``lambda^T M lambda``, ``lambda >= 0``.  If all principal submatrices
of lower order are copositive, M is not copositive iff ``det M < 0`` and ``adj M >= 0`` (Cottle, Habetler and Lemke
1970; Hadeler 1983); then ``lambda = adj M (1, ..., 1)`` shows it.  A zero inside a face of a copositive form is a
kernel vector of the face's submatrix, which is positive semidefinite; so the zeros are sums of those that are alone on
their face.

*Elsewhere* a cone whose form touches zero inside an edge, or on a ray that leaves a corner, is cut exactly there:
halving approaches such a zero for ever; a cut makes it a corner.  The zeros looked for are roots of polynomials in one
variable: the form on an edge, and, near a corner of a triangle, its coefficients of the highest power of that corner
(the lowest terms of the polynomial there), as a form on the opposite edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.proofs.inequalities.effort import effort_left, take_effort
from nonsmooth.proofs.inequalities.forms import Problem
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
    Stuck,
    SubCone,
    Vector,
    Violation,
)
from nonsmooth.symbolic.mechanics.constraints import cofactors
from nonsmooth.symbolic.numbers.coefficients import height
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Terms


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
    found = {e[second]: c for e, c in form.items() if e[first] + e[second] == degree}
    return tuple(field(evaluated(found.get(k, 0))) for k in range(degree + 1))


Matrix: TypeAlias = list[list[Any]]


def decide_quadratic(problem: Problem) -> Violation | Stuck | None:
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
                return _violation(problem, weights) or Stuck(problem.generators)
            kernel = next(([row[k] for row in adjugate] for k in range(size) if any(row[k] for row in adjugate)), None)
            if not determinant and kernel is not None and len({sign(x) for x in kernel} | {0}) == 2 and all(kernel):
                zeros.append(_spread([abs(x) for x in kernel], face, count))
    if problem.strict:
        for weights in _candidates(problem, zeros):
            point = _point(problem, weights)
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
    origins = [z for z in zeros if problem.role(_point(problem, z)) is Role.ORIGIN]
    for origin in origins:
        for other in zeros:
            yield [a + b for a, b in zip(origin, other, strict=True)]


def _violation(problem: Problem, weights: list[Any]) -> Violation | None:
    """A point of the cell at or beside the weights, at which the form is negative."""
    count = len(weights)
    total = sum(weights[1:], weights[0])
    for k in range(NEARBY_STEPS):
        point = _point(problem, [w + total / (count * 4**k) for w in weights])
        for candidate in (_point(problem, weights), point):
            if problem.is_violated_at(candidate):
                return Violation(candidate)
    return None


def _point(problem: Problem, weights: Sequence[Any]) -> Vector:
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
        for t, is_zero in _suspects(line):
            point = tuple(a + b * t for a, b in zip(generators[edge[0]], generators[edge[1]], strict=True))
            if problem.is_violated_at(point):
                return Violation(point)
            if is_zero:
                return (*edge, t / (1 + t))
    if len(generators) == 3:
        for edge, line in _lowest_terms(problem, part.form):
            for t, is_zero in _suspects(line):
                if is_zero:
                    return (*edge, t / (1 + t))
    return None


def _suspects(line: Coefficients) -> Iterator[tuple[Any, bool]]:
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
        found = {e[edge[1]]: c for e, c in terms.items() if e[corner] == top}
        yield edge, tuple(field(evaluated(found.get(k, 0))) for k in range(degree + 1))
