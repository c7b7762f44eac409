"""The exact simplex method: against HiGHS, against vertex enumeration, and through its own certificate."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
import sympy
from scipy.optimize import linprog

from nonsmooth.proofs.inequalities.linear_program import Mixture, best_mixture
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField

# HiGHS solves to 1e-7 primal and dual feasibility; optima here are below 100 (weights of at most 10 vectors).
SOLVER_TOLERANCE = 1e-6
INFEASIBLE, UNBOUNDED = 2, 3

Problem = tuple[list[list[Number]], list[Number], list[Number]]  # columns, target, prices


def random_problem(seed: int, *, bounded: bool = True) -> Problem:
    """Small integers, so ties, parallel columns and degenerate vertices are frequent.

    A bounded problem has a last row of ones with target 1: convex weights, as in the clauses.
    """
    rng = np.random.default_rng(seed)
    field = NumberField()
    rows, count = int(rng.integers(1, 4)), int(rng.integers(1, 9))
    columns = [[field(x) for x in rng.integers(-2, 3, rows).tolist()] for _ in range(count)]
    target = [field(x) for x in rng.integers(-1, 2, rows).tolist()]
    if bounded:
        columns = [[*column, field.one] for column in columns]
        target = [*(t * Fraction(1, 2) for t in target), field.one]
    prices = [field(x) for x in rng.integers(-3, 4, count).tolist()]
    return columns, target, prices


def highs(problem: Problem) -> tuple[int, float]:
    """Status and optimum by SciPy."""
    columns, target, prices = ([[float(x) for x in c] for c in problem[0]], *problem[1:])
    result = linprog(
        [-float(p) for p in prices],
        A_eq=np.array(columns).T,
        b_eq=[float(t) for t in target],
        bounds=(0, None),
        method="highs",
    )
    return result.status, -result.fun if result.status == 0 else 0.0


def enumerated(problem: Problem) -> sympy.Rational | None:
    """Optimum by trying every basic solution with SymPy's rationals (bounded problems)."""
    columns, target, prices = ([[x.to_sympy() for x in c] for c in problem[0]], *problem[1:])
    matrix = sympy.Matrix(columns).T
    goal, price = (sympy.Matrix([x.to_sympy() for x in numbers]) for numbers in (target, prices))
    values = []
    for size in range(1, min(matrix.shape) + 1):
        for chosen in map(list, combinations(range(matrix.cols), size)):
            basis = matrix[:, chosen]
            if basis.rank() == size == basis.row_join(goal).rank():
                weights = (basis.T * basis).LUsolve(basis.T * goal)
                if min(weights) >= 0:
                    values.append(price[chosen, :].dot(weights))
    return max(values, default=None)


@pytest.mark.parametrize("seed", range(120))
def test_convex_weights_agree_with_highs(seed: int) -> None:
    problem = random_problem(seed)
    mixture = best_mixture(*problem)
    status, optimum = highs(problem)
    assert (mixture is None) == (status == INFEASIBLE)
    if mixture is not None:
        assert float(mixture.value) == pytest.approx(optimum, abs=SOLVER_TOLERANCE)
        assert mixture.check(*problem)


@pytest.mark.parametrize("seed", range(120))
def test_unbounded_and_infeasible_programs_are_told_apart(seed: int) -> None:
    problem = random_problem(seed + 5000, bounded=False)
    status, optimum = highs(problem)
    if status == UNBOUNDED:
        with pytest.raises(ValueError, match="required a bounded linear program"):
            best_mixture(*problem)
        return
    mixture = best_mixture(*problem)
    assert (mixture is None) == (status == INFEASIBLE)
    if mixture is not None:
        assert float(mixture.value) == pytest.approx(optimum, abs=SOLVER_TOLERANCE)
        assert mixture.check(*problem)


@pytest.mark.parametrize("seed", range(30))
def test_the_optimum_is_the_best_basic_solution_exactly(seed: int) -> None:
    problem = random_problem(seed)
    mixture = best_mixture(*problem)
    assert (None if mixture is None else mixture.value.to_sympy()) == enumerated(problem)


def test_all_outcomes_occur_among_the_random_programs() -> None:
    bounded = {highs(random_problem(seed))[0] for seed in range(120)}
    free = {highs(random_problem(seed + 5000, bounded=False))[0] for seed in range(120)}
    assert bounded == {0, INFEASIBLE}
    assert free == {0, INFEASIBLE, UNBOUNDED}


def test_a_cycling_example_ends() -> None:
    """Beale's program, on which the largest-coefficient rule cycles; optimum 1/20."""
    field = NumberField()
    q = Fraction
    rows: list[list[Fraction | int]] = [
        [q(1, 4), -60, q(-1, 25), 9, 1, 0, 0],
        [q(1, 2), -90, q(-1, 50), 3, 0, 1, 0],
        [0, 0, 1, 0, 0, 0, 1],
    ]
    columns = [[field(row[k]) for row in rows] for k in range(7)]
    prices = [field(x) for x in (q(3, 4), -150, q(1, 50), -6, 0, 0, 0)]
    target = [field(x) for x in (0, 0, 1)]
    mixture = best_mixture(columns, target, prices)
    assert mixture is not None
    assert mixture.value == q(1, 20)
    assert mixture.check(columns, target, prices)


def test_redundant_rows_do_no_harm() -> None:
    """Twice the same equation leaves an artificial column in the basis, at level zero."""
    field = NumberField()
    columns = [[field(x), field(2 * x), field.one] for x in (-1, 2, 3)]
    target, prices = [field(1), field(2), field.one], [field(0), field(1), field(5)]
    mixture = best_mixture(columns, target, prices)
    assert mixture is not None
    assert mixture.value == Fraction(5, 2)
    assert mixture.check(columns, target, prices)


def test_no_weights_at_all_may_be_the_best() -> None:
    field = NumberField()
    problem: Problem = ([[field.one]], [field.zero], [-field.one])
    mixture = best_mixture(*problem)
    assert mixture is not None
    assert mixture.weights == {}
    assert mixture.value == 0
    assert mixture.check(*problem)


def test_irrational_programs_are_solved_exactly() -> None:
    """0 = w1 sqrt2 - w2 sqrt3 + w3, and a near tie that floats would miss: prices differ by 10^-30."""
    field = NumberField()
    two, three = field.sqrt(2), field.sqrt(3)
    columns = [[two, field.one], [-three, field.one], [two, field.one]]
    target = [field.zero, field.one]
    prices = [field.one, field.zero, 1 + field(Fraction(1, 10**30))]
    mixture = best_mixture(columns, target, prices)
    assert mixture is not None
    assert mixture.weights == {1: two / (two + three), 2: three / (two + three)}
    assert mixture.check(columns, target, prices)


INFEASIBLE_SEEDS = (1, 2, 3, 7, 8, 9, 10, 17, 18, 20, 22, 25, 26, 29, 32, 34, 36)
FEASIBLE_SEEDS = [seed for seed in range(40) if seed not in INFEASIBLE_SEEDS]


def test_infeasible_programs_are_those_without_a_mixture() -> None:
    for seed in range(40):
        problem = random_problem(seed)
        assert (highs(problem)[0] == INFEASIBLE) == (seed in INFEASIBLE_SEEDS) == (best_mixture(*problem) is None)


@pytest.mark.parametrize("seed", FEASIBLE_SEEDS)
def test_a_tampered_certificate_is_refused(seed: int) -> None:
    problem = random_problem(seed)
    mixture = best_mixture(*problem)
    assert mixture is not None
    one = mixture.value.field.one
    k = next(iter(mixture.weights))
    tampered = [
        replace(mixture, value=mixture.value + one),
        replace(mixture, weights={**mixture.weights, k: mixture.weights[k] + one}),
        replace(mixture, weights={**mixture.weights, k: -mixture.weights[k]}),
        replace(mixture, weights={}),
        replace(mixture, multipliers=(*mixture.multipliers[:-1], mixture.multipliers[-1] + one)),
    ]
    assert not any(wrong.check(*problem) for wrong in tampered)


def test_a_feasible_but_suboptimal_mixture_is_refused() -> None:
    """The cheapest mixture has the right form; no multipliers can prove it best."""
    different = 0
    for seed in FEASIBLE_SEEDS:
        columns, target, prices = random_problem(seed)
        best, worst = best_mixture(columns, target, prices), best_mixture(columns, target, [-p for p in prices])
        assert best is not None
        assert worst is not None
        if best.value != -worst.value:
            different += 1
            cheapest = Mixture(worst.weights, -worst.value, best.multipliers)
            assert not cheapest.check(columns, target, prices)
            turned = replace(cheapest, multipliers=tuple(-y for y in worst.multipliers))
            assert not turned.check(columns, target, prices)
    assert (different, len(FEASIBLE_SEEDS)) == (19, 23)


@pytest.mark.parametrize("seed", range(30))
def test_proposals_over_many_roots_are_verified_and_equal_the_exact_optimum(seed: int) -> None:
    """Columns over six square roots: the value agrees with HiGHS, and the certificate verifies exactly."""
    rng = np.random.default_rng(seed)
    field = NumberField()
    roots = [field.sqrt(n) for n in (2, 3, 5, 7, 11, 13)]
    count = int(rng.integers(3, 12))

    def entry() -> Number:
        return roots[rng.integers(6)] * int(rng.integers(-3, 4))

    columns = [(entry(), entry(), field.one) for _ in range(count)]
    prices = [entry() for _ in range(count)]
    target = (field.zero, field.zero, field.one)
    found = best_mixture(columns, target, prices)
    matrix = np.array([[float(x) for x in column] for column in columns]).T
    reference = linprog([-float(p) for p in prices], A_eq=matrix, b_eq=[0, 0, 1])
    assert (found is None) == (reference.status == 2)
    if found is not None:
        assert found.check(columns, target, prices)
        assert float(found.value) == pytest.approx(-reference.fun, abs=1e-9)
