"""Where to cut a cone whose form touches zero inside an edge, or on a ray that leaves a corner: exactly there.

Halving approaches such a zero for ever; a cut makes it a corner.  The zeros looked for are roots of polynomials in one
variable: the form on an edge, and, near a corner of a triangle, its coefficients of the highest power of that corner
(the lowest terms of the polynomial there), as a form on the opposite edge.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.proofs.inequalities.binary_forms import edge_line
from nonsmooth.proofs.inequalities.dense_polynomials import Coefficients, trimmed, value
from nonsmooth.proofs.inequalities.effort import effort_left, take_effort
from nonsmooth.proofs.inequalities.forms import LONG_BITS, Problem
from nonsmooth.proofs.inequalities.real_roots import positive_roots, samples_between
from nonsmooth.proofs.inequalities.subdivision import SubCone, Violation
from nonsmooth.symbolic.numbers.coefficients import height
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Terms

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
    generators = [tuple(map(evaluated, g)) for g in part.generators]
    for edge in combinations(range(len(generators)), 2):
        line = edge_line(problem, part.pieces, edge)
        for t, is_zero in _suspects(line):
            point = tuple(a + b * t for a, b in zip(generators[edge[0]], generators[edge[1]], strict=True))
            if problem.is_violated_at(point):
                return Violation(point)
            if is_zero:
                return (*edge, t / (1 + t))
    if len(generators) == 3:
        for edge, line in _lowest_terms(problem, part.pieces.form):
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
