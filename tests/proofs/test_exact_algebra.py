"""Exact algebra: real roots, enclosures by balls, and the simplex method in fractions."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
import pytest
import sympy
from flint import arb, arb_mat
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import linprog

from nonsmooth.proofs.boxes.enclosures import (
    UNIT,
    Jet,
    approximate_inverse,
    holds_on,
    is_positive_definite,
    krawczyk,
    lies_inside,
    linear_stability,
    newton,
    parameters,
    turned_by,
    unit_vector,
)
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.linear_program import Mixture, best_mixture
from nonsmooth.proofs.inequalities.real_roots import RealRoot, Sturm, positive_roots, separated, value
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

# ---- Real roots isolated exactly: against NumPy, against known roots, and signs at roots that have no name.

RANDOM = examples(80)
FIELD = NumberField()
ROOT = FIELD.sqrt(2)


def is_isolated(root: RealRoot) -> bool:
    """Whether the polynomial has exactly one root between the bounds, and none at them."""
    ends = root.sturm.sign_at(root.low) and root.sturm.sign_at(root.high)
    return bool(ends) and root.low < root.high and root.sturm.count(root.low, root.high) == 1


def product(*factors: list[Number]) -> list[Number]:
    """Ascending coefficients of a product."""
    total = [FIELD.one]
    for factor in factors:
        longer = [FIELD.zero] * (len(total) + len(factor) - 1)
        for i, a in enumerate(total):
            for j, b in enumerate(factor):
                longer[i + j] = longer[i + j] + a * b
        total = longer
    return total


def minus(root: Number | Fraction | int) -> list[Number]:
    """``t - root``."""
    return [-FIELD(root), FIELD.one]


NUMBERS = st.builds(
    lambda q, k: FIELD(q) + k * ROOT, st.fractions(min_value=-3, max_value=3, max_denominator=4), st.integers(-1, 1)
)


@RANDOM
@given(st.lists(NUMBERS, min_size=1, max_size=4), st.lists(st.integers(1, 3), min_size=4, max_size=4))
def test_known_roots_are_isolated_whatever_their_multiplicities(roots: list[Number], powers: list[int]) -> None:
    coefficients = product(
        *[minus(r) for r, k in zip(roots, powers, strict=False) for _ in range(k)], [FIELD(1), FIELD(0), FIELD(1)]
    )
    positive = sorted({r for r in roots if r.sign() > 0})
    found = positive_roots(coefficients)
    assert len(found) == len(positive)
    for isolated, root in zip(found, positive, strict=True):
        assert is_isolated(isolated)
        assert isolated.low < root < isolated.high
        rational = all(c.as_rational() is not None for c in coefficients)
        assert isolated.exact() == root or (not rational and isolated.exact() is None)  # no factors over Q(sqrt2)
        assert isolated.sign_of(minus(root)) == 0
        assert isolated.sign_of(minus(root - 1)) == 1
        assert is_isolated(isolated.halved())


@RANDOM
@given(st.lists(st.integers(-20, 20), min_size=2, max_size=9))
def test_random_polynomials_against_numpy(integers: list[int]) -> None:
    assume(any(integers))
    coefficients = [FIELD(c) for c in integers]
    found = positive_roots(coefficients)
    roots = np.roots(integers[::-1])
    real = sorted(r.real for r in roots if abs(r.imag) < 1e-7 and r.real > 1e-7)
    distinct = [r for k, r in enumerate(real) if not k or r - real[k - 1] > 1e-4]
    clustered = len(distinct) < len(real) or any(abs(r.imag) < 1e-3 for r in roots if abs(r.imag) >= 1e-7)
    if not clustered:  # NumPy cannot tell double roots from near ones
        assert len(found) == len(distinct)
        for isolated, root in zip(found, distinct, strict=True):
            assert float(isolated.low) - 1e-6 <= root <= float(isolated.high) + 1e-6
    for isolated in found:
        assert is_isolated(isolated)


def test_roots_of_different_polynomials_are_told_apart() -> None:
    cubic = [FIELD(-2), FIELD(0), FIELD(0), FIELD(1)]  # 2^(1/3)
    near = minus(Fraction(125992, 100000))
    several = [*positive_roots(cubic), *positive_roots(product(cubic, minus(5))), *positive_roots(near)]
    roots = separated(several)
    assert len(roots) == 3
    assert all(a.high <= b.low for a, b in pairwise(roots))
    assert roots[0].exact() == Fraction(125992, 100000)
    assert roots[1].exact() is None
    assert roots[1].sign_of(near) == 1
    assert roots[1].sign_of(product(cubic, minus(7))) == 0
    assert roots[1].sign_of([]) == 0


def test_a_bound_with_none_or_two_roots_is_refused() -> None:
    quadratic = tuple(product(minus(1), minus(2)))
    assert is_isolated(RealRoot(quadratic, Fraction(1, 2), Fraction(3, 2)))
    assert not is_isolated(RealRoot(quadratic, Fraction(1, 2), Fraction(5, 2)))
    assert not is_isolated(RealRoot(quadratic, Fraction(3), Fraction(4)))
    assert not is_isolated(RealRoot(quadratic, Fraction(1), Fraction(3, 2)))  # a bound that is a root itself
    with pytest.raises(ValueError, match="nonzero"):
        positive_roots([FIELD.zero])


def test_sturm_counts_distinct_roots() -> None:
    coefficients = product(minus(1), minus(1), minus(ROOT), minus(3))
    sturm = Sturm(coefficients)
    assert sturm.count(Fraction(0), None) == 3
    assert sturm.count(Fraction(5, 4), Fraction(2)) == 1
    assert value(coefficients, Fraction(2)).sign() < 0


@RANDOM
@given(st.lists(st.integers(-9, 9), min_size=2, max_size=7), st.fractions(-5, 5, max_denominator=9))
def test_signs_of_rational_polynomials_are_those_of_their_values(numbers: list[int], point: Fraction) -> None:
    """Rational chains are evaluated by FLINT, up to positive factors."""
    assume(numbers[-1])
    expected = sum(Fraction(c) * point**k / 7 for k, c in enumerate(numbers))
    chain = Sturm([FIELD(Fraction(c, 7)) for c in numbers])
    assert chain.sign_at(point) == (expected > 0) - (expected < 0)


@RANDOM
@given(st.lists(st.integers(-3, 3), min_size=1, max_size=5))
def test_rational_chains_count_what_irrational_ones_count(roots: list[int]) -> None:
    """Times the square root of two the coefficients are irrational, and the chain is another."""
    rational = product(*(minus(root) for root in roots))
    irrational = [c * ROOT for c in rational]
    counts = {Sturm(chain).count(Fraction(-7, 2), Fraction(1, 2)) for chain in (rational, irrational)}
    assert counts == {len({root for root in roots if root <= 0})}


def test_close_roots_of_many_polynomials_are_told_apart_with_little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Roots ``10^-8 k``, of products of two factors each: what was found of a root is not found again for each pair."""
    field, halvings = NumberField(), 0
    halved = RealRoot.halved

    def counted(root: RealRoot) -> RealRoot:
        nonlocal halvings
        halvings += 1
        return halved(root)

    monkeypatch.setattr(RealRoot, "halved", counted)
    scale = 10**8
    curves = [[field(k * (k + 1)), field(-scale * (2 * k + 1)), field(scale**2)] for k in range(1, 40)]
    roots = separated(root for curve in curves for root in positive_roots(curve))
    assert [sum(root.low < Fraction(k, scale) < root.high for root in roots) for k in range(1, 41)] == [1] * 40
    assert len(roots) == 40
    assert halvings < 100 * 78


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_halves_hold_the_root_whatever_its_multiplicity(power: int) -> None:
    field = NumberField()
    coefficients = [field(c) for c in np.polynomial.polynomial.polypow([-1, 3], power).astype(int).tolist()]
    [root] = positive_roots(coefficients)
    for _ in range(30):
        root = root.halved()
        assert root.low < Fraction(1, 3) < root.high
    assert is_isolated(root)


# ---- Enclosures by balls, against eigenvalues, known zeros, and values at drawn members of boxes.

CIRCLE = 5.0  # x^2 + y^2 = 5 meets x y = 2 at (2, 1) and (1, 2)


def test_definite_matrices_are_those_with_positive_eigenvalues() -> None:
    rng = np.random.default_rng(1)
    answers = []
    for _ in range(200):
        entries = rng.integers(-4, 6, (3, 3))
        matrix = entries + entries.T + 4 * np.eye(3, dtype=int)
        answers.append(is_positive_definite(matrix.tolist()))
        assert answers[-1] == (np.linalg.eigvalsh(matrix).min() > 1e-9)
    assert 20 < sum(answers) < 180


def test_a_matrix_of_balls_is_definite_only_if_all_members_are() -> None:
    rows = [[arb(2), arb(0, 1), arb(0)], [arb(0, 1), arb(1), arb(0)], [arb(0), arb(0), arb(1)]]
    assert is_positive_definite(rows)
    rows[0][1] = rows[1][0] = arb(0, 1.5)
    assert not is_positive_definite(rows)


def test_stability_is_that_of_the_eigenvalues() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        matrix = rng.integers(-3, 4, (2, 2))
        real = np.linalg.eigvals(matrix).real
        expected = Translation.UNDECIDED
        if real.max() > 1e-9:
            expected = Translation.UNSTABLE
        elif real.max() < -1e-9:
            expected = Translation.ASYMPTOTICALLY_STABLE
        assert linear_stability(matrix.tolist()) is expected


def equations(z: arb_mat, product: int = 2) -> tuple[arb_mat, arb_mat]:
    x, y = z.entries()
    value = arb_mat([[x * x + y * y - CIRCLE], [x * y - product]])
    return value, arb_mat([[2 * x, 2 * y], [y, x]])


def test_krawczyks_operator_encloses_a_zero() -> None:
    centre = newton(equations, arb_mat([[arb(2.2)], [arb(0.9)]]), 8)
    assert centre is not None
    inverse = approximate_inverse(equations(centre)[1])
    assert inverse is not None
    box = arb_mat([[entry + 0.1 * UNIT] for entry in centre.entries()])
    image = krawczyk(centre, equations(centre)[0], inverse, equations(box)[1], box)
    assert lies_inside(image, box)
    assert all(entry.contains(zero) for entry, zero in zip(image.entries(), (2, 1), strict=True))
    wide = arb_mat([[entry + UNIT] for entry in centre.entries()])  # holds both zeros
    assert not lies_inside(krawczyk(centre, equations(centre)[0], inverse, equations(wide)[1], wide), wide)


def test_no_zero_is_proved_where_there_is_none() -> None:
    """The circle and the hyperbola x y = 3 do not meet."""

    def apart(z: arb_mat) -> tuple[arb_mat, arb_mat]:
        return equations(z, 3)

    centre = arb_mat([[arb(1.75)], [arb(1.5)]])
    inverse = approximate_inverse(apart(centre)[1])
    assert inverse is not None
    for radius in (0.01, 0.05, 0.2):
        box = arb_mat([[entry + radius * UNIT] for entry in centre.entries()])
        assert not lies_inside(krawczyk(centre, apart(centre)[0], inverse, apart(box)[1], box), box)


def test_parts_of_an_interval() -> None:
    assert holds_on(lambda x: bool(x * x - x + 0.26 > 0), arb(0), arb(1), 12)
    assert not holds_on(lambda x: bool(x * x - x + 0.25 > 0), arb(0), arb(1), 12)
    assert not holds_on(lambda x: bool(x * x - x + 0.26 > 0), arb(0), arb(1), 2)


def along(jets: list[Jet]) -> list[Jet]:
    """Something of every operation: a unit vector, turned, and a quotient."""
    x, y, angle = jets
    unit = unit_vector(x * y + arb(3), y - x)
    assert unit is not None
    a, b = turned_by(arb(1), arb(2), angle)
    return [a * unit[0] - b * unit[1], (a + b) / (x * x + arb(2)), -unit[1] * a]


@pytest.mark.parametrize("size", [0.01, 0.2])
def test_the_mean_value_theorem_encloses_every_member(size: float) -> None:
    middle, sizes = [0.3, -0.4, 0.7], [arb(size)] * 3
    whole = along(parameters([arb(value) + size * UNIT for value in middle]))
    boxes = [
        jet.over(sizes, at.value) for jet, at in zip(whole, along(parameters([arb(v) for v in middle])), strict=True)
    ]
    rng = np.random.default_rng(3)
    for shift in rng.uniform(-size, size, (50, 3)):
        x, y, angle = np.array(middle) + shift
        a, b = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ (1, 2)
        e, f = np.array([x * y + 3, y - x]) / math.hypot(x * y + 3, y - x)
        for box, exact in zip(boxes, (a * e - b * f, (a + b) / (x * x + 2), -f * a), strict=True):
            assert box.overlaps(arb(exact, 1e-12))
            assert float(box.rad()) < 8 * size


def test_slopes_are_those_of_differences() -> None:
    middle, step = [0.3, -0.4, 0.7], 1e-6
    for k in range(3):
        ends = []
        for side in (-step, step):
            values = [arb(value + side * (k == j)) for j, value in enumerate(middle)]
            ends.append([float(jet.value) for jet in along(parameters(values))])
        slopes = [float(jet.slopes[k]) for jet in along(parameters([arb(value) for value in middle]))]
        assert slopes == pytest.approx((np.array(ends[1]) - np.array(ends[0])) / (2 * step), abs=1e-8)


# ---- The exact simplex method: against HiGHS, against vertex enumeration, and through its own certificate.

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
    bounded = {highs(random_problem(seed))[0] for seed in range(40)}
    free = {highs(random_problem(seed + 5000, bounded=False))[0] for seed in range(40)}
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
    mixture = best_mixture(columns, target, prices)
    matrix = np.array([[float(x) for x in column] for column in columns]).T
    reference = linprog([-float(p) for p in prices], A_eq=matrix, b_eq=[0, 0, 1])
    assert (mixture is None) == (reference.status == 2)
    if mixture is not None:
        assert mixture.check(columns, target, prices)
        assert float(mixture.value) == pytest.approx(-reference.fun, abs=1e-9)
