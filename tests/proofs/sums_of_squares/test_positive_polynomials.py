"""Sums of squares: known polynomials, sampled values, eigenvalues in floats, and evidence that was changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flint import fmpq

from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.gram_certificate import (
    GuardedClaim,
    SquareTerm,
    SumOfSquares,
    is_definite,
    is_semidefinite,
)
from nonsmooth.proofs.sums_of_squares.prove import Effort, Proved, claim_of, normalized, prove_positive
from nonsmooth.proofs.sums_of_squares.rounding import particular_solution

Terms = Mapping[Any, Any]


def exact(terms: Terms) -> dict[tuple[int, ...], fmpq]:
    return {e: fmpq(*c) if isinstance(c, tuple) else fmpq(c) for e, c in terms.items()}


def condition(terms: Terms, guards: Sequence[Terms] = (), *, box: bool = False, at_origin: bool = False) -> Condition:
    count = len(next(iter(terms)))
    bounds = [{tuple(int(i == k) for i in range(count)): fmpq(1)} for k in range(count)] if box else []
    return Condition(exact(terms), {}, tuple(map(exact, guards)), tuple(bounds), count, at_origin)


def follows(asked: Condition, found: Proved) -> bool:
    """Whether a claim is a condition without parameters, and follows from its evidence."""
    return found.claim == claim_of(normalized(asked), strict=found.claim.strict) and found.evidence.proves(found.claim)


X, Y = {(1, 0): 1}, {(0, 1): 1}
MOTZKIN = {(4, 2): 1, (2, 4): 1, (2, 2): -3, (0, 0): 1}

PROVED = [
    condition({(2, 0): 1, (1, 1): -1, (0, 2): 1}),
    condition({(2, 0): 1, (1, 1): 5, (0, 2): 1}, [X, Y]),  # copositive, not definite
    condition({(1, 0): 1, (2, 0): (-1, 2), (0, 2): 1}, [X], box=True),
    condition({(2, 0): 1, (3, 0): (1, 2), (0, 2): 1, (1, 3): -1}, box=True),
    condition({(4, 0): 1, (0, 2): 1, (2, 1): 1}),  # of order two in y and four in x
    condition({(0, 0): 1, (1, 0): (-9, 10)}, box=True, at_origin=True),
    condition({**MOTZKIN, (0, 0): (6, 5)}, box=True, at_origin=True),
    condition({(2, 0): -1, (0, 2): 4}, [{(1, 0): -1, (0, 1): 1}, {(1, 0): 1, (0, 1): 1}]),  # |x| <= y
]
NOT_POSITIVE = [
    condition({(2, 0): 1, (1, 1): -2, (0, 2): 1}),
    condition({(2, 0): 1, (1, 1): -3, (0, 2): 1}, [X, Y]),
    condition({(1, 0): 1, (2, 0): -1, (0, 2): 1}, [X], box=True),  # zero at (1, 0)
    condition({(0, 0): 1, (1, 0): -1}, box=True, at_origin=True),
    condition({(2, 0): 1, (0, 2): 1}, at_origin=True),
    condition({(2, 0): 1, (0, 4): -1}, box=True),
    condition({(4, 0): 1, (0, 2): 1, (2, 1): 2}),
    condition({(2, 0): -1, (0, 2): 1}, [{(1, 0): -1, (0, 1): 1}, {(1, 0): 1, (0, 1): 1}]),
]


@pytest.mark.parametrize("asked", PROVED)
def test_positive_polynomials_are_proved(asked: Condition) -> None:
    found = prove_positive(asked)
    assert found is not None
    assert follows(asked, found)


@pytest.mark.parametrize("asked", NOT_POSITIVE)
def test_polynomials_with_zeros_are_not(asked: Condition) -> None:
    assert prove_positive(asked) is None


def test_zeros_are_allowed_where_that_is_asked() -> None:
    weak = prove_positive(NOT_POSITIVE[0], Effort.FULL)
    assert weak is not None
    assert not weak.claim.strict
    assert follows(NOT_POSITIVE[0], weak)
    assert prove_positive(condition({(2, 0): 1, (1, 1): (-21, 10), (0, 2): 1}), Effort.FULL) is None
    assert prove_positive(condition({(1, 0): 1, (2, 0): 1, (0, 2): 0}, [X]), Effort.FULL) is not None


@pytest.mark.parametrize("seed", range(20))
def test_what_is_proved_is_positive_at_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    terms = {(2, 0): 3, (0, 2): 3, (0, 0): 0}
    for e in ((1, 1), (3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (2, 2), (0, 4)):
        terms[e] = int(rng.integers(-4, 5))
    guard = {(1, 0): int(rng.integers(-2, 3)), (0, 1): 1}
    asked = condition(terms, [guard], box=True)
    points = rng.uniform(-1, 1, (20_000, 2))
    points = points[points @ [float(asked.guards[0].get((1, 0), 0)), 1.0] >= 0]
    values = sum(float(c) * points[:, 0] ** e[0] * points[:, 1] ** e[1] for e, c in asked.constant.items())
    ratio = float(np.min(values / (points**2).sum(axis=1)))
    found = prove_positive(asked)
    if found is not None:
        assert follows(asked, found)
        assert ratio > 0
    if ratio > 0.2:
        assert found is not None


@pytest.mark.parametrize("seed", range(30))
def test_elimination_agrees_with_eigenvalues(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 7))
    root = rng.integers(-3, 4, (size, int(rng.integers(1, size + 2))))
    square = root @ root.T - int(rng.integers(0, 2)) * np.eye(size, dtype=int)
    gram = tuple(tuple(fmpq(int(value)) for value in row) for row in square)
    eigenvalues = np.linalg.eigvalsh(square.astype(float))
    assert is_semidefinite(gram) == bool(eigenvalues[0] > -1e-9)
    assert is_definite(gram) == bool(eigenvalues[0] > 1e-9)


def test_changed_evidence_is_refused() -> None:
    asked = PROVED[1]
    found = prove_positive(asked)
    assert found is not None
    first, *others = found.evidence.terms
    grams = [
        tuple(tuple(v + (i == j == 0) * fmpq(1, 10**9) for j, v in enumerate(row)) for i, row in enumerate(first.gram)),
        tuple(tuple(-v for v in row) for row in first.gram),
        first.gram[::-1],
    ]
    for gram in grams:
        forged = replace(found, evidence=SumOfSquares((replace(first, gram=gram), *others)))
        assert not follows(asked, forged)
    negative = tuple(
        replace(term, gram=tuple(tuple(-v for v in row) for row in term.gram)) if k == 0 else term
        for k, term in enumerate(others)
    )
    assert not follows(asked, replace(found, evidence=SumOfSquares((first, *negative))))
    assert not follows(asked, replace(found, evidence=SumOfSquares((*others, first))))
    assert not follows(PROVED[0], found)


def test_a_sum_of_squares_must_separate_the_origin() -> None:
    claim = GuardedClaim(exact({(2, 0): 1}), (), 2)
    square = SumOfSquares((SquareTerm((), ((1, 0),), ((fmpq(1),),)),))
    assert not square.proves(claim)
    assert square.proves(replace(claim, strict=False))


def test_equations_without_a_solution_have_none() -> None:
    from flint import fmpq_mat

    matrix = fmpq_mat([[1, 1], [2, 2]])
    assert particular_solution(matrix, fmpq_mat([[1], [3]])) is None
    found = particular_solution(matrix, fmpq_mat([[1], [2]]))
    assert found is not None
    assert matrix * found == fmpq_mat([[1], [2]])
