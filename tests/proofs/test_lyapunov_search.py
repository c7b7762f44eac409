"""The search for V: candidates, its region and its rate, and the limit of its work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
from flint import fmpq

from nonsmooth.analysis.cells.switched_cells import square_regions, system_cells
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof, Undecided, prove
from nonsmooth.proofs.inequalities.subdivision import effort_left, effort_of_its_own, shared_effort
from nonsmooth.proofs.kernel.bases import bent, formula_text, monomials, piecewise_quadratics
from nonsmooth.proofs.kernel.cells import surfaces_of
from nonsmooth.proofs.kernel_strategies import find_weak_function, linear_matrix, rate_of, short_forms
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease
from nonsmooth.proofs.systems.domain import DecayKind, SublevelRegion
from nonsmooth.proofs.systems.energies import energies, falling_energies
from nonsmooth.proofs.systems.findings import Method, PlaneFunction
from nonsmooth.proofs.systems.lyapunov_search import find_lyapunov, in_time, propose
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.trees import float_value
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import contradiction
from tests.oracles.floats import value, velocity
from tests.plain import built
from tests.proofs.conftest import Load
from tests.proofs.forged import with_reach
from tests.thorough import few, keep, thorough

# ---- The search for V, its region and its rate: against paths, closed forms and forged evidence.

STEP, STEPS, STARTS = 1e-3, 1500, 12


def slack(radius: float) -> float:
    """By how much V may rise on a polygon that chatters with steps of this length."""
    return 20 * STEP * radius


@few(2)
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("y", "-2*sign(x) - sign(y)"),
        ("y", "-2*sign(x + y) + x/2"),
        ("y - 2*sign(x + y)", "-x + y/3 - sign(y)"),
        ("-sign(x) + y", "-y"),
        ("y", "-3*sign(x - y)*(-1) - 6*sign(2*x + y)"),
    ],
)
def test_a_found_v_falls_along_polygons(load: Load, first: str, second: str) -> None:
    system = load(first, second)
    lyapunov = find_lyapunov(system)
    assert lyapunov is not None
    assert lyapunov.formula is not None
    assert lyapunov.domain.radius is not None
    assert lyapunov.result.verdict is Decrease.STRICT
    rhs, formula = [f.text for f in system.rhs], lyapunov.formula.text
    radius = float(lyapunov.domain.radius)
    angles = np.linspace(0.1, 0.1 + 2 * np.pi, STARTS, endpoint=False)
    points = 0.5 * radius * np.array([np.cos(angles), np.sin(angles)])
    inside = np.ones(STARTS, dtype=bool)
    values = value(formula, x=points[0], y=points[1])
    lowest = values.copy()
    for _ in range(STEPS):
        points = points + STEP * velocity(rhs, points)
        inside &= np.abs(points).max(axis=0) <= radius
        values = value(formula, x=points[0], y=points[1])
        assert np.all(values[inside] <= lowest[inside] + slack(1.0))
        lowest = np.minimum(lowest, values)
    assert np.all(lowest[inside] < 0.5 * value(formula, x=radius / 2, y=0.0) + slack(1.0))


@thorough  # the small one: test_what_v_does_not_allow_is_not_claimed
def test_nothing_is_found_where_there_is_nothing(load: Load) -> None:
    for first, second in (("y", "-x"), ("x", "-y"), ("y", "-sign(x)"), ("-sign(x) + y", "y")):
        assert find_lyapunov(load(first, second)) is None


def test_rich_families_leave_work_for_smaller_squares(load: Load) -> None:
    """On the checked square two relays refute sum after sum; a quadratic form serves on a quarter of it."""
    first = "-sign(y) - sign(y - 2*x) - y/2 - x**2/2 - x/2"
    lyapunov = find_lyapunov(load(first, "-2*sign(y) - 2*sign(y - 2*x) - 3*x/4 - x*y/4"))
    assert lyapunov is not None
    assert lyapunov.text == "x**2 - x*y + y**2"


def test_in_reversed_time_it_grows(load: Load) -> None:
    result = decide_system(load("y + x**3", "-x + y**3"))
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.GROWTH)
    assert result.function is not None
    assert result.function.grows
    assert result.check()
    turned = in_time(system_cells(load("y", "-x"), square_regions(result.scene.check.radius)), grows=True)
    assert [str(p) for p in turned[0].velocities[0]] == ["-y", "x"]


def test_sums_of_basis_functions_are_written_as_formulas(load: Load) -> None:
    system = load("y - sign(x + 2*y)", "-sign(y)*sign(x - 1)")
    lines = [surface for surface in system.surfaces() if surface.is_homogeneous]
    assert {str(line) for line in lines} == {"x + 2*y", "y"}
    basis = (*map(bent, lines), *monomials(("a", "b"), 2))
    coefficients = [fmpq(1, 2), fmpq(0), fmpq(1), fmpq(-9, 11), fmpq(-1)]
    assert formula_text(basis, coefficients) == f"Abs({lines[0]})/2 + a**2 - 9*a*b/11 - b**2"


def test_programs_propose_what_all_rows_allow() -> None:
    rows = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, -0.5]])
    for coefficients in propose(rows):
        assert np.all(rows @ np.array([float(c) for c in coefficients]) > 0)
    assert list(propose(np.array([[1.0, 0.0], [-1.0, 0.0]]))) == []


# ---- regions and rates ---------------------------------------------------------------------------

U = "(100*x**4 - 384*x**2*y**2 + 400*y**4)"


def potential_flow(load: Load) -> SwitchedSystem:
    """``c' = (U - 1) grad U``: the region of attraction is U < 1, and V = abs(c)^2 serves up to 1/20 exactly."""
    return load(f"({U} - 1)*(400*x**3 - 768*x*y**2)", f"({U} - 1)*(1600*y**3 - 768*x**2*y)", radius='"1/4"')


@thorough  # of levels that are known exactly: test_regions_touch_the_border
def test_a_region_up_to_its_exact_limit(load: Load) -> None:
    """On the y axis U = 400 V^2, so V' = 8 U (U - 1) vanishes at V = 1/20 (Drake, issue 12876)."""
    system = potential_flow(load)
    result = decide_system(system)
    region = result.reach.region
    assert isinstance(region, SublevelRegion)
    assert region.refuted is not None
    assert Fraction(4094, 4096) <= region.level * 20 <= 1
    claims = certificate_of(result)["statement"]["claims"]
    assert str(region.level) in [claim["attracts"]["below"] for claim in claims if "attracts" in claim]
    assert Fraction(1, 20) < region.refuted < Fraction(1, 20) * Fraction(1001, 1000)
    assert region.point is not None
    x, y = map(float, region.point)
    level = 100 * x**4 - 384 * x**2 * y**2 + 400 * y**4
    assert 8 * level * (level - 1) > -1e-12
    assert x**2 + y**2 <= float(region.refuted)
    assert result.check()
    assert not with_reach(result, region=replace(region, level=Fraction(51, 1000))).check()
    assert not with_reach(result, region=replace(region, falls=True)).check()


def test_units_do_not_hide_a_region(load: Load) -> None:
    """The level of V = abs(x, y)^2 is the square of the half-width."""
    region = decide_system(load("-x + y**2", "-y", lyapunov='"x**2 + y**2"', radius='"1/10000000"')).reach.region
    assert isinstance(region, SublevelRegion)
    assert 1 - 2**-11 < float(region.level) * 10**14 < 1


@few(1)
@pytest.mark.parametrize(
    ("first", "second", "lyapunov", "level"),
    [
        ("-x + y**2", "-y", "x**2 + 2*y**2", Fraction(1, 4)),
        ("-sign(x)", "-2*sign(y) + x", "Abs(x) + Abs(y)", Fraction(1, 2)),
    ],
)
def test_regions_touch_the_border(load: Load, first: str, second: str, lyapunov: str, level: Fraction) -> None:
    result = decide_system(load(first, second, lyapunov=f'"{lyapunov}"'))
    region = result.reach.region
    assert isinstance(region, SublevelRegion)
    assert region.level == level
    assert region.point is not None
    assert max(abs(float(v)) for v in region.point) == 0.5
    assert result.check()
    higher = replace(region, level=level * 2)
    assert not with_reach(result, region=higher).check()
    assert not with_reach(result, near=higher, region=higher).check()


@pytest.mark.parametrize(
    ("first", "second", "lyapunov", "decay", "bound"),
    [
        (
            "-sign(x)",
            "-2*sign(y) + x",
            "Abs(x) + Abs(y)",
            DecayKind.FINITE,
            Fraction(1),
        ),  # V' = -1 at worst, sliding on x = 0
        ("-x", "-x**2*y - 2*y", "x**2 + y**2", DecayKind.EXPONENTIAL, Fraction(2)),
        ("y", "-x - y", "x**2 + x*y + y**2", DecayKind.EXPONENTIAL, Fraction(1)),
    ],
)
def test_rates_are_below_the_exact_ones(
    load: Load, first: str, second: str, lyapunov: str, decay: DecayKind, bound: Fraction
) -> None:
    rate = decide_system(load(first, second, lyapunov=f'"{lyapunov}"')).reach.rate
    assert rate is not None
    assert rate.decay is decay
    assert bound / 2 <= rate.kappa <= bound


@pytest.mark.parametrize(
    ("first", "second", "radius", "least"),
    keep(
        1,
        [
            ("y", "-sign(x) - y/4", "1/2", 0.004),  # 0.0026 on the square of the search
            ("-y", "x - y + x**2*y", "3", 4.5),  # van der Pol in reversed time; 1.7 on that square
        ],
    ),
)
def test_a_searched_v_is_proved_as_far_as_it_falls(
    load: Load, first: str, second: str, radius: str, least: float
) -> None:
    result = decide_system(load(first, second, radius=f'"{radius}"'))
    region = result.reach.region
    assert result.function is not None
    assert isinstance(region, SublevelRegion)
    size = float(region.radius)
    x, y = np.meshgrid(*2 * [np.linspace(-size, size, 201)])
    values = value(result.function.text, x=x, y=y)
    assert (values < float(region.level)).mean() * 4 * size**2 > least
    assert result.check()
    level = region.level
    assert not with_reach(result, region=replace(region, level=level * 5 / 4, refuted=level * 3)).check()


@pytest.mark.parametrize(
    ("first", "second", "slowest"),
    keep(
        3,  # irrational numbers in a V: test_irrational_numbers_stand_for_themselves_in_the_plane
        [
            ("y", "-x - y", 1.0),  # twice the real part of its eigenvalues: no V falls faster
            ("y", "-x - y/10 - Max(x, 0)", 0.1),
            ("y", "-x - y/2*(2 + 3*sign(x))", 1.0),  # twice the eigenvalue of a node, to which solutions come
            ("y", "-x - y/2*(1 + 3*sign(x - sqrt(2)*y))", np.inf),
        ],
    ),
)
def test_a_v_on_cones_falls_nearly_as_fast_as_solutions(load: Load, first: str, second: str, slowest: float) -> None:
    """It bends on lines between those on which the field switches, where it has to, and holds on the plane."""
    result = decide_system(load(first, second))
    rate = result.reach.rate
    assert result.function is not None
    assert result.function.domain.radius is None
    assert rate is not None
    assert rate.domain.radius is None
    assert 0.5 * min(slowest, 1.0) < float(rate.kappa) <= slowest
    assert result.check()


@pytest.mark.parametrize("count", [2, 3, 4, 5, 8])
def test_sums_are_all_functions_that_are_quadratic_between_lines(count: int) -> None:
    """In m lines there are as many: m values on rays and m mixed ones, of even functions and of odd ones each."""
    system = built(["-x", "-y"])
    x, y = system.coordinates()
    angles = np.pi * np.arange(count) / count
    lines = [x * round(99 * np.cos(angle)) + y * round(99 * np.sin(angle)) for angle in angles]
    basis = piecewise_quadratics(system.states, lines)
    points = np.random.default_rng(0).normal(size=(400, 2))
    sums = np.stack([value(function.text, x=points[:, 0], y=points[:, 1]) for function in basis], axis=1)
    assert np.linalg.matrix_rank(sums, tol=1e-9) == 4 * count


def test_surfaces_of_long_sums_are_found_term_by_term() -> None:
    """Twenty lines cut the plane into 40 cones, not into 2^20 patterns of signs."""
    lines = [f"Abs(x - {k}*y)" for k in range(20)]
    system = built(["-x", "-y"])
    surfaces = surfaces_of(system, parse_piecewise(" + ".join([*lines, "Max(x - 3*y, 0)*Abs(x + y)"]), system.states))
    assert list(map(str, surfaces[:3])) == ["x", "x - y", "x - 2*y"]
    assert len(surfaces) == 21


def test_a_v_of_linear_parts_is_proved_beside_other_terms(load: Load) -> None:
    """On the square V may bend where the field does not switch: no sum of other functions falls there."""
    system = load("y", "-x - y/2*(1 + 3*sign(x)) + x**2/4", radius='"1/4"')
    assert find_lyapunov(system) is None
    lyapunov = find_lyapunov(system, is_linear=True)
    assert lyapunov is not None
    assert lyapunov.domain.radius is not None
    assert lyapunov.result.verdict is Decrease.STRICT


def test_a_region_of_v_that_bends_reaches_beyond_its_square(load: Load) -> None:
    """``V' = -1 + 12 abs(x)^3 - abs(y)`` off the axes: V falls where ``V < 12^(-1/3)``, about 0.437."""
    result = decide_system(load("-sign(x) + 12*x**3", "-y", lyapunov='"Abs(x) + Abs(y)"'))
    near, region = result.reach.near, result.reach.region
    assert isinstance(near, SublevelRegion)
    assert isinstance(region, SublevelRegion)
    assert near.level == Fraction(1, 32)
    assert Fraction(42, 100) < region.level < Fraction(437, 1000)
    assert result.check()


def test_an_irrational_half_width_has_region_and_rate(load: Load) -> None:
    """On a square that is a little smaller, which is named: certificates hold no roots."""
    result = decide_system(load("-x - x**3", "-y", lyapunov='"x**2 + y**2"', radius='"sqrt(2)/3"'))
    region, rate = result.reach.region, result.reach.rate
    assert isinstance(region, SublevelRegion)
    assert rate is not None
    assert rate.domain.radius is not None
    assert Fraction(2, 9) * Fraction(2046, 2048) < region.level < Fraction(2, 9)
    assert region.radius == rate.domain.radius < result.scene.check.radius
    assert Fraction(15, 8) < rate.kappa <= 2
    claims = certificate_of(result)["statement"]["claims"]
    assert {"attracts", "rate", "gain"} <= {key for claim in claims for key in claim}


@pytest.mark.usefixtures("without_far_starts")
def test_what_v_does_not_allow_is_not_claimed(load: Load) -> None:
    """Twisting arrives in finite time, but V' vanishes at the point, and nearly so at a corner of the square."""
    result = decide_system(load("y", "-2*sign(x) - sign(y)"))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.region is not None
    assert isinstance(result.function, PlaneFunction)
    assert isinstance(result.function.result.cells[0].potential, Polynomial)
    assert result.reach.rate is not None
    assert result.reach.rate.decay is DecayKind.EXPONENTIAL
    formula, corner, field, step = result.function.formula, np.array([0.5, -0.5]), np.array([-0.5, -1.0]), 1e-6
    assert formula is not None
    first, later = (
        float_value(formula.tree, dict(zip("xy", at.tolist(), strict=True)), formula.text)
        for at in (corner, corner + step * field)
    )
    assert 0 < float(result.reach.rate.kappa) <= (first - later) / (step * first) + 1e-6 < 1e-3


def test_families_too_large_for_a_formula_are_left_out(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    """Six lines make a family of 68 functions, and a formula has at most sixty terms: on one square as on two."""
    monkeypatch.setattr("nonsmooth.proofs.many_states.weak_functions.SHARES", (Fraction(1),))
    system = load(
        "y*(2 + sign(x + y) - sign(x + 2*y) + sign(x - y))", "-x*(3 + sign(x - 2*y) - sign(2*x + y)) + y*Abs(x)"
    )
    assert len(system.surfaces()) == 6
    assert find_weak_function(PlanePoint(system)) is None


@pytest.mark.usefixtures("without_far_starts")
def test_a_rate_over_square_roots_is_certified(load: Load) -> None:
    """Roots of polynomials over sqrt(2) along the edges: once that ended the check, then it was too much work."""
    rhs = [
        "-3*x**3 - sqrt(2)*(Max(y - 1, 0) + Min(y + 1, 0))",
        "-3/2*sat(y, -1, 1) + x**2/10 - sqrt(2)*sign(x + y/2)",
    ]
    result = decide_system(load(*rhs))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.rate is not None
    assert result.check()


ONE_ZERO = [
    ["-2*x", "-10*x"],
    ["y", "-Max(x - 1/4, 0) - Min(x + 1/4, 0) - y"],  # a dead zone: linear on a smaller square
    ["0", "x - 3*y"],
    ["-x - 2*y", "x/3 + 2/3*y"],
]


@pytest.mark.parametrize("rhs", keep(2, ONE_ZERO))
def test_a_linear_field_with_one_eigenvalue_zero_is_stable(load: Load, rhs: list[str]) -> None:
    result = decide_system(load(*rhs))
    assert (result.verdict, result.deciding.theorem) == (Translation.STABLE, Method.LYAPUNOV)
    assert certificate_of(result)["statement"]["claims"][:2] == [{"stability": "stable"}, {"approaches": "near"}]
    assert decide_system(load(*(f"-({formula})" for formula in rhs))).verdict is Translation.UNSTABLE


@pytest.mark.usefixtures("without_reach")
@few(2)
@pytest.mark.parametrize("rhs", [["Abs(y)", "-y"], ["Abs(y)", "-y - y**3"], ["Abs(x + 2*y) - x", "-y"]])
def test_energies_whose_numbers_must_agree(load: Load, rhs: list[str]) -> None:
    """``(x + Abs(y))**2 + y**2``: shorter numbers leave ``y**2`` alone, and others that V rises on thin cones."""
    result = decide_system(load(*rhs))
    assert result.verdict is Translation.STABLE
    assert "not asymptotically" in result.reason
    assert result.check()


WEIGHED = {
    "a state of half the weight": (["-x**3 + y**4", "-x*y"], Translation.ASYMPTOTICALLY_STABLE),
    "numbers that must agree between degrees": (["y", "-x + z", "-z**3"], Translation.STABLE),
    "numbers that must agree on a ray of rest": (["-Max(x, 0) + Min(y, 0)", "-y - x"], Translation.STABLE),
}


@few(1)
@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("name", WEIGHED)
def test_energies_of_terms_of_several_degrees(name: str) -> None:
    """``2*x**2 + y**4``, and ``(x - z)**2 + y**2 + 2*y*z**3 + k*z**2``."""
    rhs, truth = WEIGHED[name]
    result = decide_system(built(rhs))
    assert result.verdict is truth
    assert result.check()
    assert not contradiction(certificate_of(result)["statement"])


# ---- Quadratic functions of linear systems: short, nearly as fast as solutions, and never faster.


def random_matrix(seed: int, count: int) -> np.ndarray:
    """A matrix whose eigenvalues have real parts of at most -1/4."""
    drawn = np.random.default_rng(seed).integers(-4, 5, size=(count, count)).astype(float)
    return drawn - np.eye(count) * (np.ceil(np.linalg.eigvals(drawn).real.max()) + 1 / 4)


@pytest.mark.parametrize("count", [2, 3, 4, 6])
@pytest.mark.parametrize("seed", keep(2, range(30)))
def test_forms_keep_a_good_part_of_the_rate(seed: int, count: int) -> None:
    """Against generalized eigenvalues, and the rate of solutions themselves."""
    matrix = random_matrix(seed, count)
    best = -2 * np.linalg.eigvals(matrix).real.max()
    forms = list(short_forms(matrix))
    assert forms
    for form in forms:
        assert (form == form.T).all()
        assert (np.diag(form) % 2 == 0).all()
        falls = -(matrix.T @ form + form @ matrix)
        rate = scipy.linalg.eigh(falls, form, eigvals_only=True).min()
        assert rate_of(form, matrix) == pytest.approx(rate, rel=1e-6)
        assert best / 4 <= rate <= best * (1 + 1e-9)


def test_the_smallest_form_comes_first() -> None:
    """Of an oscillator the one whose level sets are its own ellipses; of a stiff one the best form has long numbers."""
    (first, *_) = short_forms(np.array([[0.0, 1], [-1, -1]]))
    assert first.tolist() == [[2, 1], [1, 2]]
    (first, *_) = short_forms(np.diag([-1.0, -3]))
    assert first.tolist() == [[2, 0], [0, 2]]
    stiff = np.array([[0.0, 1], [-1e6, -1e3]])
    assert all(rate_of(form, stiff) > 0 for form in short_forms(stiff))
    assert not list(short_forms(np.array([[0.0, 1], [-1, 0]])))
    assert not list(short_forms(np.array([[1.0]])))


EXACT = [
    (("y", "-x - y"), "x**2 + x*y + y**2", Fraction(1)),
    (("-x", "-y"), "x**2 + y**2", Fraction(2)),
    (("-x", "-y", "-z"), "x**2 + y**2 + z**2", Fraction(2)),
]


@pytest.mark.parametrize(("rhs", "function", "kappa"), EXACT)
def test_rates_are_exact_where_they_are_short(rhs: tuple[str, ...], function: str, kappa: Fraction) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.everywhere
    assert result.function.text == function
    rate = result.reach.rate
    assert rate is not None
    assert (rate.decay, rate.kappa) == (DecayKind.EXPONENTIAL, kappa)
    claims = certificate_of(result)["statement"]["claims"]
    assert {"attracts": "everywhere"} in claims
    assert any(claim.get("rate", {}).get("within", "") is None for claim in claims)


def test_rates_of_several_states_are_near_those_of_solutions() -> None:
    """Chains of equal poles had 1/40 of the rate that this V shows."""
    rate = decide_system(built(["y", "z", "-x - 3*y - 3*z"])).reach.rate
    assert rate is not None
    assert Fraction(3, 4) < rate.kappa < 2


@pytest.mark.parametrize(
    ("rhs", "is_linear"),
    [
        (("-x + 2*y", "-y"), True),
        (("-x + 2*y", "-y - y**3"), False),
        (("-x + Abs(y)", "-y"), False),
        (("-x + 2*y + 1", "-y"), False),
        (("-x*sqrt(2)", "-y"), True),
    ],
)
def test_only_linear_systems_have_a_matrix(rhs: tuple[str, ...], is_linear: bool) -> None:
    assert (linear_matrix(built(rhs)) is not None) == is_linear


def test_a_stated_function_comes_before() -> None:
    """What the scene names is examined as it is."""
    result = decide_system(built(["y", "-x - y"], lyapunov="3*x**2/2 + x*y + y**2"))
    assert result.function.text == "3*x**2/2 + x*y + y**2"


# ---- Candidates for V of systems of second order: energies with a cross term ---------------------

# Right-hand sides, the place of the position, and its force; at rest that of friction is the mean of both directions.
SECOND_ORDER = [
    (("y", "-2*sign(x) - y"), 0, lambda x: 2 * np.sign(x)),
    (("y", "-x*Abs(x) - 3*y"), 0, lambda x: x * abs(x)),
    (("y", "-x - x**3 - Max(x, 0)/2 - sign(y)"), 0, lambda x: x + x**3 + max(x, 0) / 2),
    (("-3*y**3 - Abs(y)*y - x", "x"), 1, lambda x: 3 * x**3 + abs(x) * x),
]


def energy_of(formula: PiecewiseExpression, place: int, x: float, v: float) -> float:
    """A candidate without its cross term, which changes its sign with v."""
    both = [dict(zip(("x", "y") if place == 0 else ("y", "x"), (x, speed), strict=True)) for speed in (v, -v)]
    return sum(float_value(formula.tree, values, formula.text) for values in both) / 2


@pytest.mark.parametrize(("rhs", "place", "force"), SECOND_ORDER)
def test_the_energy_has_the_slope_of_the_force(
    rhs: tuple[str, str], place: int, force: Callable[[float], float]
) -> None:
    system, step = built(rhs), 1e-6
    crossed = list(falling_energies(system, system.check.radius))[1:]
    found = [*crossed, *energies(system)]
    assert len(crossed) in (2, 4)
    for formula in found:
        for x, v in np.random.default_rng(3).uniform(-0.4, 0.4, (20, 2)).tolist():
            high, low = (energy_of(formula, place, x + move, v) for move in (step, -step))
            assert (high - low) / (2 * step) == pytest.approx(force(x), abs=1e-6)
            assert energy_of(formula, place, x, v) - energy_of(formula, place, x, 0.0) == pytest.approx(v**2 / 2)


def test_what_is_of_no_second_order_has_none() -> None:
    for rhs in (("y - x", "-2*x - 3*y"), ("y", "-sqrt(2)*x - y"), ("y*Abs(y)", "-x - y")):
        system = built(rhs)
        assert not list(falling_energies(system, system.check.radius))[1:]


@pytest.mark.parametrize(
    ("rhs", "energy"),
    [
        (("y", "-x**3 - y + 2*z", "-y/3 - z**3"), "z**2/2 + y**2/12 + x**4/24"),  # a chain of three
        (("2*y", "-sign(x) - y"), "Abs(x) + y**2"),
        (("y", "-3*sat(x, -1, 2)"), "3*(x*sat(x, -1, 2) - sat(x, -1, 2)**2/2) + y**2/2"),
        (("-x + y**3", "-x/2 - y"), "x**2/2 + y**4/2"),
        (("y", "-x**3 - 3*y/(1 + x**4)"), "x**4/4 + y**2/2"),
    ],
)
def test_energies_of_chains(rhs: tuple[str, ...], energy: str) -> None:
    system, states = built(rhs), "xyz"[: len(rhs)]
    found, *_ = energies(system)
    expected = parse_piecewise(energy, tuple(states))
    ratios = []
    for place in np.random.default_rng(3).uniform(-4, 4, (20, len(rhs))).tolist():
        values = dict(zip(states, place, strict=True))
        ratios.append(float_value(found.tree, values, found.text) / float_value(expected.tree, values, energy))
    assert ratios == pytest.approx([ratios[0]] * len(ratios))


def test_a_relay_with_viscous_friction_has_a_short_function() -> None:
    result = decide_system(built(["y", "-2*sign(x) - y"]))
    assert result.function is not None
    assert result.function.text == "2*Abs(x) + y**2/2 + x*y/4"
    assert result.reach.region is not None
    assert result.reach.region.level >= 0.1  # 1681/262144 of the richest family, on a smaller square
    assert result.reach.rate is not None
    assert result.reach.rate.decay is DecayKind.EXPONENTIAL
    kinds = {kind for claim in certificate_of(result)["statement"]["claims"] for kind in claim}
    assert {"stability", "attracts", "rate", "gain"} <= kinds


def test_slight_damping_beside_a_sine_is_seen_by_the_energy() -> None:
    result = decide_system(built(["y - x**3/1000", "-sin(x) - x - y**3/1000"]))
    claims = certificate_of(result)["statement"]["claims"]
    assert {"stability": "asymptotically stable"} in claims
    assert {kind for claim in claims for kind in claim} == {"stability", "attracts", "rate"}


# ---- Inequalities that are hard together: one limit of work for all, and nothing but `undecided` comes of it.

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, ("x", "y"), name) for name in ("x", "y"))
# Positive, but zero along a curve that no cut hits up to a small rest: much work.
HARD = (X**2 * 7 - Y**3 + X * 3 - Y) ** 2 * 10**12 + 1


@thorough  # of smaller limits, which they share: the two tests below
@pytest.mark.parametrize("frequency", [1_000_000])
def test_an_audit_ends_after_the_work_of_all_its_inequalities(frequency: int) -> None:
    rhs = [f"-sign(x) - sin({frequency}*y)", f"-sign(y) - sin({frequency}*x)"]
    system = built(rhs, radius=1)
    with shared_effort(10**9):
        found = audit(system, "x**2 + y**2")
        spent = 10**9 - effort_left()
    assert spent < 2 * EFFORT
    assert found.verdict is AuditVerdict.UNDECIDED


def test_without_effort_easy_inequalities_are_decided_and_hard_ones_are_left_open() -> None:
    [region, *_] = square_regions(FIELD.one)
    with shared_effort(0):
        assert isinstance(prove(Sense.POSITIVE, X**2 + Y**2 + 1, region), Proof)
        assert isinstance(prove(Sense.POSITIVE, X - Y, region), Counterexample)
        assert isinstance(prove(Sense.POSITIVE, HARD, region), Undecided)


def test_efforts_count_for_those_around_them_but_for_one_of_its_own() -> None:
    [region, *_] = square_regions(FIELD.one)
    with shared_effort(10_000):
        with effort_of_its_own(3_000):
            prove(Sense.POSITIVE, HARD, region)
            assert effort_left() == 0
        assert effort_left() == 10_000
        with shared_effort(1_000):
            prove(Sense.POSITIVE, HARD, region)
            assert effort_left() == 0
        assert 7_000 < effort_left() <= 9_000
