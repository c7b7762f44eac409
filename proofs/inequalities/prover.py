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
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np

from nonsmooth.analysis.cells.region import Region, Triple
from nonsmooth.proofs.inequalities.complete import decide_binary, decide_quadratic, zero_cut
from nonsmooth.proofs.inequalities.effort import effort_left
from nonsmooth.proofs.inequalities.forms import (
    PLANE,
    Problem,
    Question,
    Sense,
    build_parts,
    place_of,
    triangles,
)
from nonsmooth.proofs.inequalities.real_roots import RealRoot
from nonsmooth.proofs.inequalities.subdivision import Stuck, Violation
from nonsmooth.symbolic.formulas.surfaces import factorize
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.polynomial import Polynomial, float_values, float_values_and_sizes

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
    found: dict[tuple[Fraction, Fraction], Weights] = {}
    for scale in SCALES:
        for j in range(PARTS + 1):
            for k in range(PARTS + 1 - j):
                weights = ((PARTS - j - k) * scale, j, k)
                total = sum(weights)
                found.setdefault((Fraction(j, total), Fraction(k, total)), weights)
    return tuple(found.values())


def _suspects(question: Question, triangle: Sequence[Triple]) -> Iterator[Weights]:
    """The weights at which floats say that the claim fails, the clearest failures first."""
    weights = np.array(_grid(), dtype=float)
    x, y, w = (weights @ np.array([[float(v) for v in g] for g in triangle])).T
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
    x, y, w = (sum(c * v for c, v in zip(column, weights, strict=True)) for column in zip(*triangle, strict=True))
    return x / w, y / w


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
        found = decide(part)
        if isinstance(found, Violation):
            return _witness(question, place_of(found.point, part, question))
        if isinstance(found, RealRoot):
            return ZeroBetween(question, part, found)
        if isinstance(found, Stuck):
            stuck = stuck or Undecided(question, tuple(place_of(g, part, question) for g in found.corners))
    if stuck is not None and not region.guards and (refuting := counterexample(question)) is not None:
        return _witness(question, refuting)
    return stuck or Proof(question)


def decide(problem: Problem) -> Violation | RealRoot | Stuck | None:
    """Decide one simplicial part: what refutes it, or where the search ended; None where it is proved."""
    found = problem.subdivided(LITTLE_WORK)
    if not isinstance(found, Stuck):
        return found
    if len(problem.generators) == 2 and len(problem.form.field.radicands) <= MAX_EXACT_ROOTS:
        return decide_binary(problem)
    if not problem.guards and problem.form.degree == 2:
        quadratic = decide_quadratic(problem)
        return found if isinstance(quadratic, Stuck) else quadratic
    if not problem.guards and not problem.strict:
        rest = _without_square(problem)
        of_rest = found if rest is None else decide(rest)
        if of_rest is None or (isinstance(of_rest, Violation) and problem.is_violated_at(of_rest.point)):
            return of_rest
    work = min(MUCH_WORK, effort_left())
    return problem.subdivided(work, lambda part: zero_cut(problem, part)) if work else found


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
