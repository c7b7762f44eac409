"""Sums of squares: known polynomials, sampled values, eigenvalues in floats, and evidence that was changed.

What is found is shown by the checker, which shares nothing with the search.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from flint import fmpq

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality, cube_guards, identity, show
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.squares import Shown, find
from nonsmooth.proofs.sums_of_squares.ansatz import (
    Block,
    Condition,
    above_polyhedron,
    monomials_between,
    plain_block,
)
from nonsmooth.proofs.sums_of_squares.conic_program import is_definite, is_semidefinite, particular_solution, solve
from nonsmooth.proofs.sums_of_squares.prove import MOST_UNKNOWNS, Effort
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.polynomial import Exponents

Terms = Mapping[Any, Any]


def exact(terms: Terms) -> Polynomial:
    values = {e: Fraction(*c) if isinstance(c, tuple) else Fraction(c) for e, c in terms.items()}
    return Polynomial(len(next(iter(terms))), values)


def positive(terms: Terms, guards: Sequence[Terms] = (), *, box: bool = False, at_origin: bool = False) -> Claim:
    """A polynomial is positive where guards are not negative, in a box or everywhere, perhaps but at the origin."""
    value = exact(terms)
    named = {f"s{k}": exact(guard) for k, guard in enumerate(guards)}
    sides = cube_guards(identity(value.count), value.count) if box else {}
    return Claim("p", (Inequality(value, {**named, **sides}),), strict=True, at_origin=at_origin, bounded=box)


def follows(claim: Claim, proof: Shown) -> bool:
    """Whether the checker is shown a claim, strict or not, by evidence that says so."""
    try:
        show(replace(claim, strict=proof.strict), proof.evidence)
    except RejectedError:
        return False
    return True


X, Y = {(1, 0): 1}, {(0, 1): 1}
MOTZKIN = {(4, 2): 1, (2, 4): 1, (2, 2): -3, (0, 0): 1}

PROVED = [
    positive({(2, 0): 1, (1, 1): -1, (0, 2): 1}),
    positive({(2, 0): 1, (1, 1): 5, (0, 2): 1}, [X, Y]),  # copositive, not definite
    positive({(1, 0): 1, (2, 0): (-1, 2), (0, 2): 1}, [X], box=True),
    positive({(2, 0): 1, (3, 0): (1, 2), (0, 2): 1, (1, 3): -1}, box=True),
    positive({(4, 0): 1, (0, 2): 1, (2, 1): 1}),  # of order two in y and four in x
    positive({(0, 0): 1, (1, 0): (-9, 10)}, box=True, at_origin=True),
    positive({**MOTZKIN, (0, 0): (6, 5)}, box=True, at_origin=True),
    positive({(2, 0): -1, (0, 2): 4}, [{(1, 0): -1, (0, 1): 1}, {(1, 0): 1, (0, 1): 1}]),  # |x| <= y
]
NOT_POSITIVE = [
    positive({(2, 0): 1, (1, 1): -2, (0, 2): 1}),
    positive({(2, 0): 1, (1, 1): -3, (0, 2): 1}, [X, Y]),
    positive({(1, 0): 1, (2, 0): -1, (0, 2): 1}, [X], box=True),  # zero at (1, 0)
    positive({(0, 0): 1, (1, 0): -1}, box=True, at_origin=True),
    positive({(2, 0): 1, (0, 2): 1}, at_origin=True),
    positive({(2, 0): 1, (0, 4): -1}, box=True),
    positive({(4, 0): 1, (0, 2): 1, (2, 1): 2}),
    positive({(2, 0): -1, (0, 2): 1}, [{(1, 0): -1, (0, 1): 1}, {(1, 0): 1, (0, 1): 1}]),
]


@pytest.mark.parametrize("claim", PROVED)
def test_positive_polynomials_are_proved(claim: Claim) -> None:
    proof = find(claim, Effort.STRICT)
    assert proof is not None
    assert follows(claim, proof)


@pytest.mark.parametrize("claim", NOT_POSITIVE)
def test_polynomials_with_zeros_are_not(claim: Claim) -> None:
    assert find(claim, Effort.STRICT) is None


def test_zeros_are_allowed_where_that_is_asked() -> None:
    weak = find(NOT_POSITIVE[0], Effort.FULL)
    assert weak is not None
    assert not weak.strict
    assert follows(NOT_POSITIVE[0], weak)
    assert find(positive({(2, 0): 1, (1, 1): (-21, 10), (0, 2): 1}), Effort.FULL) is None
    assert find(positive({(1, 0): 1, (2, 0): 1, (0, 2): 0}, [X]), Effort.FULL) is not None


def test_no_program_asks_whether_a_polynomial_is_positive_that_is_zero_along_an_axis(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    idle = positive({(0, 2, 0): 1, (0, 0, 4): 1}, box=True)
    beside = positive({(0, 1, 0): 1, (0, 0, 2): 1}, [{(1, 0, 0): 1, (0, 1, 0): 1}, {(0, 1, 0): 1}])
    cut_off = positive({(0, 2): 1}, [{(1, 0): -1, (0, 1): 1}, {(1, 0): 1, (0, 1): 1}])  # where |x| <= y
    assert find(cut_off, Effort.STRICT) is not None
    monkeypatch.setattr("nonsmooth.proofs.sums_of_squares.prove.solve_inside", None)
    assert find(idle, Effort.STRICT) is None
    assert find(beside, Effort.STRICT) is None


def test_products_of_guards_and_squares_are_shown_where_they_vanish_along_faces() -> None:
    """``-V'`` of friction of second order, on the ground and between two bodies: zero wherever nothing moves."""
    y, w, apart = {(0, 1, 0): 1}, {(0, 0, 1): 1}, {(0, 1, 0): 1, (0, 0, 1): -1}
    cube_of_apart = {(0, 3, 0): 1, (0, 2, 1): -3, (0, 1, 2): 3, (0, 0, 3): -1}
    for claim in (
        positive({(0, 3, 0): 2, (0, 0, 3): (1, 3)}, [y, w]),
        positive({**cube_of_apart, (0, 1, 2): 4}, [y, apart]),
        positive({**cube_of_apart, (0, 0, 3): (-3, 4)}, [apart, w], box=True),
    ):
        proof = find(claim, Effort.FULL)
        assert proof is not None
        assert not proof.strict
        assert follows(claim, proof)
    assert find(positive({(0, 3, 0): 2, (0, 0, 3): (-1, 3)}, [y, w]), Effort.FULL) is None
    assert find(positive(cube_of_apart, [y, w]), Effort.FULL) is None


@pytest.mark.parametrize("seed", range(20))
def test_what_is_proved_is_positive_at_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    terms = {(2, 0): 3, (0, 2): 3, (0, 0): 0}
    for e in ((1, 1), (3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (2, 2), (0, 4)):
        terms[e] = int(rng.integers(-4, 5))
    guard = {(1, 0): int(rng.integers(-2, 3)), (0, 1): 1}
    claim = positive(terms, [guard], box=True)
    points = rng.uniform(-1, 1, (20_000, 2))
    points = points[points @ [float(guard[1, 0]), 1.0] >= 0]
    values = sum(float(c) * points[:, 0] ** e[0] * points[:, 1] ** e[1] for e, c in terms.items())
    ratio = float(np.min(values / (points**2).sum(axis=1)))
    proof = find(claim, Effort.STRICT)
    if proof is not None:
        assert follows(claim, proof)
        assert ratio > 0
    if ratio > 0.2:
        assert proof is not None


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
    claim = PROVED[1]
    proof = find(claim, Effort.STRICT)
    assert proof is not None
    assert len(proof.evidence["squares"][0]) > 1
    for change in (added_little, negated, with_other_monomials, without_the_first, without_the_last):
        forged = deepcopy(proof.evidence)
        change(forged["squares"][0])
        assert forged != proof.evidence
        assert not follows(claim, replace(proof, evidence=forged)), change
    assert not follows(PROVED[0], proof)


def added_little(squares: list[Any]) -> None:
    squares[0]["gram"][0][0] = str(Fraction(squares[0]["gram"][0][0]) + Fraction(1, 10**9))


def negated(squares: list[Any]) -> None:
    squares[-1]["gram"] = [[str(-Fraction(value)) for value in row] for row in squares[-1]["gram"]]


def with_other_monomials(squares: list[Any]) -> None:
    squares[0]["monomials"][0] = [2, 0]


def without_the_first(squares: list[Any]) -> None:
    squares.pop(0)


def without_the_last(squares: list[Any]) -> None:
    squares.pop()


def test_a_sum_of_squares_must_separate_the_origin() -> None:
    claim = positive({(2, 0): 1})
    square = {"squares": [[{"guards": [], "monomials": [[1, 0]], "gram": [["1"]]}]]}
    assert not follows(claim, Shown(square, strict=True))
    assert follows(claim, Shown(square, strict=False))


def test_equations_without_a_solution_have_none() -> None:
    from flint import fmpq_mat

    matrix = fmpq_mat([[1, 1], [2, 2]])
    assert particular_solution(matrix, fmpq_mat([[1], [3]])) is None
    solution = particular_solution(matrix, fmpq_mat([[1], [2]]))
    assert solution is not None
    assert matrix * solution == fmpq_mat([[1], [2]])


def test_squares_that_lie_beneath_the_newton_polyhedron_are_left_out() -> None:
    """Near the origin ``y^2 + x^6`` is larger than the rest; squares of x and x^2 could only be zero."""
    claim = positive({(0, 2): 2, (6, 0): 1, (4, 1): 2, (2, 2): 1, (6, 1): (-1, 8), (2, 3): (-1, 8)}, box=True)
    proof = find(claim, Effort.STRICT)
    assert proof is not None
    assert follows(claim, proof)
    used = {tuple(m) for entry in proof.evidence["squares"][0] for m in entry["monomials"]}
    assert (3, 0) in used
    assert not used & {(1, 0), (2, 0)}


@pytest.mark.parametrize("seed", range(3))
def test_monomials_are_those_of_the_newton_polyhedron_and_of_half_the_polytope(seed: int) -> None:
    """Of random exponents in two variables: by the exact half-planes of all lines through two of them."""
    rng = random.Random(seed)
    for _ in range(12):
        support = set(rng.sample(monomials_between(2, 2, 6), rng.randint(1, 5)))
        lines = [(b[1] - a[1], a[0] - b[0]) for a, b in permutations(support, 2)] + [(1, 0), (0, 1), (-1, 0), (0, -1)]
        upward = [normal for normal in lines if min(normal) >= 0]
        product = dict.fromkeys([(0, 0), *rng.sample(monomials_between(2, 1, 2), 2)], fmpq(1))
        blocks = [
            Block((), {(0, 0): fmpq(1)}, monomials_between(2, 0, 3)),
            Block((0,), product, monomials_between(2, 0, 3)),
        ]
        for before, after in zip(blocks, above_polyhedron(support, blocks), strict=True):
            monomials = [m for m in before.monomials if all(lies_in(support, upward, m, e) for e in before.product)]
            assert list(after.monomials) == monomials
        (plain,) = plain_block(Condition(dict.fromkeys(support, fmpq(1)), {}, (), (), 2))
        assert set(plain.monomials) == {m for m in monomials_between(2, 0, 3) if lies_in(support, lines, m, (0, 0))}


def lies_in(support: Collection[Exponents], normals: Sequence[Exponents], m: Exponents, e: Exponents) -> bool:
    """Whether ``2 m + e`` lies beyond the support along every one of some normals."""
    place = tuple(2 * a + b for a, b in zip(m, e, strict=True))
    return all(dot(normal, place) >= min(dot(normal, exponents) for exponents in support) for normal in normals)


def test_guards_that_vanish_at_the_origin_may_cancel_what_lies_beneath() -> None:
    """``y > 0`` where ``y >= x^2`` off the origin: ``y = (y - x^2) + x^2``, and y has no term in x."""
    claim = positive({(0, 1): 1, (0, 2): 1}, [{(0, 1): 1, (2, 0): -1}], box=True)
    proof = find(claim, Effort.STRICT)
    assert proof is not None
    assert follows(claim, proof)


def test_high_degrees_need_the_monomials_of_half_the_newton_polytope_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = []

    def noting(problems: Sequence[Any], *args: Any, **options: Any) -> Any:
        sizes.append(sum(len(block.monomials) ** 2 for _, blocks in problems for block in blocks))
        return solve(problems, *args, **options)

    monkeypatch.setattr("nonsmooth.proofs.sums_of_squares.prove.solve", noting)
    steep = positive({(10, 0, 0): 1, (0, 10, 0): 2, (0, 0, 12): 2}, box=True)
    proof = find(steep, Effort.STRICT)
    assert proof is not None
    assert proof.strict
    assert follows(steep, proof)
    flat = positive({(4, 0, 2): 1, (0, 4, 2): 2, (0, 0, 6): 2}, box=True)  # zero where z is
    weak = find(flat, Effort.FULL)
    assert weak is not None
    assert not weak.strict
    assert follows(flat, weak)
    assert max(sizes, default=0) <= 2 * MOST_UNKNOWNS  # none takes gigabytes
