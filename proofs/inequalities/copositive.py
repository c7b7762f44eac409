"""Quadratic forms on simplicial cones: decided completely, zeros included.

In the generators the form is ``lambda^T M lambda``, ``lambda >= 0``.  If all principal submatrices of lower order are
copositive, M is not copositive iff ``det M < 0`` and ``adj M >= 0`` (Cottle, Habetler and Lemke 1970; Hadeler 1983);
then ``lambda = adj M (1, ..., 1)`` shows it.  A zero inside a face of a copositive form is a kernel vector of the
face's submatrix, which is positive semidefinite; so the zeros are sums of those that are alone on their face.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, TypeAlias

from nonsmooth.proofs.inequalities.forms import Problem, Role, Vector
from nonsmooth.proofs.inequalities.subdivision import NEARBY_STEPS, Violation
from nonsmooth.symbolic.constraints import cofactors
from nonsmooth.symbolic.numbers.number import sign

Matrix: TypeAlias = list[list[Any]]


@dataclass(frozen=True)
class QuadraticEvidence:
    """No principal submatrix refutes the claim; re-verified by trying all of them again."""

    def check(self, problem: Problem) -> bool:
        """Decide again from the definition."""
        return isinstance(decide_quadratic(problem), QuadraticEvidence)


def decide_quadratic(problem: Problem) -> QuadraticEvidence | Violation | None:
    """Decide the claim for a form of degree two without guards; None where a refutation has no point."""
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
                return _violation(problem, _spread([sum(row[1:], row[0]) for row in adjugate], face, count))
            kernel = next(([row[k] for row in adjugate] for k in range(size) if any(row[k] for row in adjugate)), None)
            if not determinant and kernel is not None and len({sign(x) for x in kernel} | {0}) == 2 and all(kernel):
                zeros.append(_spread([abs(x) for x in kernel], face, count))
    if problem.strict:
        for weights in _candidates(problem, zeros):
            point = _point(problem, weights)
            if problem.is_violated_at(point):
                return Violation(point)
    return QuadraticEvidence()


def gram_matrix(problem: Problem) -> Matrix:
    """M in the generators."""
    terms, count = problem.coefficients.form, len(problem.generators)
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
