"""Derivatives of nonsmooth V: the golden ladder, linear programs, kinks along curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, gradients_at, lyapunov_cells, velocities_at
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.kinks import Interval, Kink, SupremumSign, SupremumSigns, ladder_at
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, derivatives_at, examine
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.proofs.systems.lyapunov_search import find_lyapunov
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.floats import velocity
from tests.proofs.conftest import Load
from tests.proofs.forged import with_reach
from tests.thorough import examples, few

# ---- Derivatives of nonsmooth V: the golden ladder, linear programs as a second opinion, and the parts of the
# domain.

RANDOM = examples(150)
SOLVER_ERROR = 1e-7  # HiGHS, on numbers of size 10
FIELD = NumberField()

Vector: TypeAlias = tuple[int, int]
Bounds: TypeAlias = tuple[float, float] | None


def cells_of(scene: SwitchedSystem, lyapunov: str) -> tuple[LyapunovCell, ...]:
    return lyapunov_cells(plane_cells(scene), parse_piecewise(lyapunov, scene.states), scene.states, "test")


def examined(scene: SwitchedSystem, lyapunov: str) -> LyapunovResult:
    result = examine(cells_of(scene, lyapunov))
    return result


# ---- golden values -----------------------------------------------------------------------------


def shown(interval: Interval | None) -> str | None:
    """``[0, 1]``, or ``{0}`` of one number; None for the empty set."""
    if interval is None:
        return None
    low, high = interval.low, interval.high
    return f"[{low}, {high}]" if high - low else f"{{{low}}}"


MAXIMUM = "(Abs(x) + Abs(y) + Abs(Abs(x) - Abs(y)))/2"  # max(|x|, |y|)


@pytest.mark.parametrize(
    ("name", "lyapunov", "point", "naive", "shevitz_paden", "bacciotti_ceragioli"),
    [
        ("relay-oscillator", "Abs(x) + Abs(y)", (1, 0), 2, "{0}", None),
        ("relay-oscillator", "Abs(x) + Abs(y)", (0, -3), 2, "{0}", None),
        ("relay-oscillator-damped", "Abs(x) + Abs(y)", (1, 0), "5/2", "{-1/2}", None),
        ("relay-oscillator-damped", "Abs(x) + Abs(y)", (0, 1), "3/2", "{-1/2}", None),
        ("eq-3", "Abs(x) + Abs(y)", (0, 1), "sqrt(2)", "{0}", "{0}"),
        ("eq-4", MAXIMUM, (1, 1), 0, "{-sqrt(2)/2}", "{-sqrt(2)/2}"),
        ("eq-4", MAXIMUM, (-2, 2), 0, "{-sqrt(2)/2}", "{-sqrt(2)/2}"),
    ],
)
def test_golden_ladder(
    name: str, lyapunov: str, point: Vector, naive: object, shevitz_paden: str, bacciotti_ceragioli: str | None
) -> None:
    """The three derivatives, each inside the one before."""
    scene = load_system(name)
    ladder = derivatives_at(cells_of(scene, lyapunov), (scene.field(point[0]), scene.field(point[1])))
    assert str(ladder.naive.high) == str(naive)
    assert (shown(ladder.shevitz_paden), shown(ladder.bacciotti_ceragioli)) == (shevitz_paden, bacciotti_ceragioli)


@pytest.mark.parametrize(
    ("name", "lyapunov", "naive", "shevitz_paden", "bacciotti_ceragioli", "verdict"),
    [
        ("relay-oscillator", "Abs(x) + Abs(y)", 2, 0, 0, Decrease.WEAK),
        ("relay-oscillator-damped", "Abs(x) + Abs(y)", "5/2", "-1/2", "-1/2", Decrease.STRICT),
        ("eq-3", "Abs(x) + Abs(y)", "sqrt(2)", 0, 0, Decrease.WEAK),
        ("eq-4", "Abs(x) + Abs(y)", "-sqrt(2)", "-sqrt(2)", "-sqrt(2)", Decrease.STRICT),
        ("eq-4", MAXIMUM, 0, "-sqrt(2)/2", "-sqrt(2)/2", Decrease.STRICT),
    ],
)  # fmt: skip
def test_suprema_over_the_plane(
    name: str, lyapunov: str, naive: object, shevitz_paden: object, bacciotti_ceragioli: object, verdict: Decrease
) -> None:
    result = examined(load_system(name), lyapunov)
    assert result.verdict is verdict
    suprema = [result.supremum(kind).value for kind in ("naive", "shevitz_paden", "bacciotti_ceragioli")]
    assert [str(value) for value in suprema] == [str(value) for value in (naive, shevitz_paden, bacciotti_ceragioli)]


def test_the_ladder_at_the_equilibrium_itself() -> None:
    result = decide_system(load_system("relay-oscillator"))
    zero = result.scene.field.zero
    assert isinstance(result.given, PlaneFunction)
    cells = result.given.result.cells
    ladder = ladder_at(velocities_at(cells, (zero, zero)), gradients_at(cells, (zero, zero)))
    assert (shown(ladder.naive), shown(ladder.bacciotti_ceragioli)) == ("[-2, 2]", "{0}")


def test_smooth_v_needs_no_surfaces() -> None:
    result = examined(load_system("eq-3"), "x**2 + y**2")
    assert all(isinstance(stratum.evidence, tuple) for stratum in result.strata)  # of cells
    assert result.verdict is Decrease.WEAK
    supremum = result.supremum("bacciotti_ceragioli")
    assert (supremum.supremum_sign, supremum.value) == (SupremumSign.NONPOSITIVE, None)  # it varies over the cells


# ---- one point: linear programs ------------------------------------------------------------------


def largest(costs: Sequence[float], rows: Sequence[Sequence[float]], rhs: Sequence[float]) -> float | None:
    """Maximum over convex weights with equations; None where there are none."""
    solution = linprog(-np.array(costs), A_eq=np.array([*rows, np.ones(len(costs))]), b_eq=[*rhs, 1], bounds=(0, None))
    return -solution.fun if solution.success else None


def common_values(velocities: list[Vector], gradients: list[Vector]) -> Bounds:
    """Bacciotti and Ceragioli's set by its definition."""
    products = np.array(gradients) @ np.array(velocities).T
    rows, rhs = list(products[1:] - products[0]), [0.0] * (len(gradients) - 1)
    high, low = largest(products[0], rows, rhs), largest(-products[0], rows, rhs)
    return None if high is None or low is None else (-low, high)


def intersected_values(velocities: list[Vector], gradients: list[Vector]) -> Bounds:
    """``[min_f max_g, max_f min_g]`` with the inner extremum as an extra variable."""
    products = np.array(gradients) @ np.array(velocities).T
    count = products.shape[1]

    def game(sign: int) -> float:
        solution = linprog(
            [0] * count + [-sign],
            A_ub=np.hstack([-sign * products, np.full((len(products), 1), sign)]),
            b_ub=np.zeros(len(products)),
            A_eq=[[1] * count + [0]],
            b_eq=[1],
            bounds=[(0, None)] * count + [(None, None)],
        )
        return float(solution.x[-1])

    low, high = game(-1), game(1)
    return (low, high) if low <= high + SOLVER_ERROR else None


VECTORS = st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1, max_size=4, unique=True)


@RANDOM
@given(VECTORS, VECTORS)
def test_ladder_against_linear_programs(velocities: list[Vector], gradients: list[Vector]) -> None:
    exact = [[(FIELD(a), FIELD(b)) for a, b in vectors] for vectors in (velocities, gradients)]
    ladder = ladder_at(*exact)
    products = [a * c + b * d for a, b in velocities for c, d in gradients]
    assert (ladder.naive.low, ladder.naive.high) == (min(products), max(products))
    for interval, expected in (
        (ladder.shevitz_paden, intersected_values(velocities, gradients)),
        (ladder.bacciotti_ceragioli, common_values(velocities, gradients)),
    ):
        agrees(interval, expected)
    inside(ladder.bacciotti_ceragioli, ladder.shevitz_paden)
    inside(ladder.shevitz_paden, ladder.naive)


def agrees(interval: Interval | None, expected: Bounds) -> None:
    assert (interval is None) == (expected is None)
    if interval is not None and expected is not None:
        assert [float(interval.low), float(interval.high)] == pytest.approx(expected, abs=SOLVER_ERROR)


def inside(inner: Interval | None, outer: Interval | None) -> None:
    if inner is not None:
        assert outer is not None
        assert outer.low <= inner.low
        assert inner.high <= outer.high


# ---- edges -------------------------------------------------------------------------------------

BENDING = ["Abs(x) + Abs(y)", "2*Abs(x) + Abs(y - x)", "x**2 + y**2 + x*Abs(y)", MAXIMUM, "Abs(x)**3 + Abs(y - 2*x)"]
FIELDS = [
    ("sign(y)", "-sign(x) - sign(y)/2"),
    ("-x + y*sign(x)", "-y - x*sign(y)"),
    ("x - 2*sign(x)", "x*y - sign(y) + 1/3"),
    ("y - sign(x)*(x**2 - 1/5)", "-x*y - sign(y - x)"),
    ("sign(x - 1)*y", "1 - x - y*sign(x)"),
]


@few(3)
@pytest.mark.parametrize("lyapunov", BENDING)
@pytest.mark.parametrize("field", FIELDS, ids=range(len(FIELDS)))
def test_signs_on_edges_bound_the_ladder_at_their_points(load: Load, lyapunov: str, field: tuple[str, str]) -> None:
    scene = load(*field)
    result = examined(scene, lyapunov)
    kinks = [stratum for stratum in result.strata if isinstance(stratum.evidence, Kink)]
    assert kinks
    for stratum in kinks:
        kink = stratum.evidence
        assert isinstance(kink, Kink)
        for t in kink.samples():
            assert kink.signs_at(t) == signs_of(result, kink.point(t))
        for t in [Fraction(k, 16) for k in (1, 3, 7, 12, 16, 21, 40, 160)]:
            here = signs_of(result, kink.point(t))
            assert kink.signs_at(t) == here
            for name in ("naive", "shevitz_paden", "bacciotti_ceragioli"):
                assert getattr(here, name).rank <= getattr(stratum.supremum_signs, name).rank


def signs_of(result: LyapunovResult, point: tuple[Any, Any]) -> SupremumSigns:
    """The signs of the largest values at a point, by the ladder there."""
    ladder = derivatives_at(result.cells, point)
    return SupremumSigns(*(SupremumSign.EMPTY if i is None else SupremumSign.of_sign(i.high.sign()) for i in ladder))


@few(4)
@pytest.mark.parametrize("lyapunov", BENDING)
@pytest.mark.parametrize("field", FIELDS, ids=range(len(FIELDS)))
def test_signs_on_cells_bound_the_rate_at_their_points(load: Load, lyapunov: str, field: tuple[str, str]) -> None:
    result = examined(load(*field), lyapunov)
    rng = np.random.default_rng(11)
    for cell, stratum in zip(result.cells, result.strata, strict=False):
        assert isinstance(stratum.evidence, tuple)
        for weights in rng.integers(0, 9, size=(12, len(cell.region.generators))):
            x, y, w = (combined(weights.tolist(), [g[axis] for g in cell.region.generators]) for axis in range(3))
            if not w or not (x or y):
                continue
            for rate in cell.rates:
                supremum_sign = SupremumSign.of_sign(rate((x / w, y / w)).sign())
                assert supremum_sign.rank <= stratum.supremum_signs.bacciotti_ceragioli.rank


def combined(weights: list[int], values: list[Any]) -> Number:
    total: Number = values[0] * weights[0]
    for weight, value in zip(weights[1:], values[1:], strict=True):
        total = total + value * weight
    return total


# ---- conditions on V ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lyapunov", "words"),
    [
        ("x**2 - y**2", "not positive"),
        ("x**2", "not positive"),
        ("(x - y)**2", "not positive"),
        ("(x - sqrt(2)*y)**2", "not positive"),
        ("(x**3 - 3*x*y**2 + y**3)**2", "vanishes beside"),
        ("x**2 + y**2 + 1", "not zero at the equilibrium"),
        ("(x**2 + y**2)*(2 + sign(x))", "not continuous"),
        ("x**2 + y**2 + Abs(x*y)*(1 + sign(y))/2 + (sign(y - x) + 1)*x**2", "not continuous"),
    ],
)
def test_v_that_is_no_candidate(load: Load, lyapunov: str, words: str) -> None:
    result = examined(load("-x", "-y"), lyapunov)
    assert result.verdict is Decrease.REFUTED
    assert result.witness is not None
    assert words in result.witness.meaning


def test_v_that_bends_along_a_curve_and_a_line_is_undecided_where_they_meet(load: Load) -> None:
    bent = "Abs(x**2 + y**2 - 1)*(x**2 + y**2)/100 + Abs(y)/10"
    result = examined(load("-x", "-y"), f"x**2 + y**2 + {bent}")
    assert result.verdict is Decrease.UNDECIDED
    assert "bends" in result.reason


def test_v_that_only_seems_to_bend(load: Load) -> None:
    """x |x| and sign(y) y^2 have continuous gradients: no edge is looked at."""
    result = examined(load("-x", "-y"), "x**2 + y**2 + (x*Abs(x) + y**2*sign(y))/2")
    assert all(isinstance(stratum.evidence, tuple) for stratum in result.strata)  # of cells
    assert result.verdict is Decrease.STRICT


def test_sliding_that_increases_v_refutes_it(load: Load) -> None:
    """In both half-planes V = |y| - x/2 + |x| falls; on y = 0 the body slides along x > 0 and V grows."""
    result = examined(load("1", "-4*sign(y)"), "Abs(x)/2 + Abs(y)")
    assert result.verdict is Decrease.REFUTED
    surfaces = [s for s in result.strata if isinstance(s.evidence, Kink)]
    assert max(s.supremum_signs.bacciotti_ceragioli.rank for s in surfaces) == SupremumSign.POSITIVE.rank
    cells = [s for s in result.strata if isinstance(s.evidence, tuple)]
    assert {s.supremum_signs.bacciotti_ceragioli for s in cells} == {SupremumSign.NEGATIVE}


# ---- V that bends along curves: against the definition at sampled points, paths, and a corner at which solutions
# rest.

STEP, STEPS = 1e-3, 4000


def follow(system: SwitchedSystem, points: np.ndarray) -> np.ndarray:
    """Where Euler polygons end."""
    for _ in range(STEPS):
        points = points + STEP * velocity([side.text for side in system.rhs], points)
    return points


@pytest.mark.usefixtures("without_far_starts")
@few(1)
@pytest.mark.parametrize(
    "relay",
    [
        "-3*sign(y + 2*x + x*y/4) - 3*x/4 - y/4",
        "-sign(x + y - 3*x**2/4)",
        "-2*sign(x + y*Abs(y)/4) + x/2 - y/4",
    ],
)
def test_relays_on_curves_are_decided_by_v_that_bends_there(load: Load, relay: str) -> None:
    system = load("y", relay)
    result = decide_system(system)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.function is not None
    assert "Abs(" in result.function.text
    assert result.check()
    assert result.reach.region is not None
    angles = np.linspace(0, 2 * np.pi, 9)
    ends = follow(system, 0.1 * np.array([np.cos(angles), np.sin(angles)]))
    assert np.abs(ends).max() < 0.1


@few(1)
@pytest.mark.parametrize("relay", ["-2*sign(y - x - x**2/4)", "-sign(x + y**2) + y/2", "2*sign(x + y + x**2)"])
def test_relays_on_curves_that_repel_have_no_such_v(load: Load, relay: str) -> None:
    system = load("y", relay)
    assert find_lyapunov(system) is None
    assert decide_system(system).verdict is not Translation.ASYMPTOTICALLY_STABLE


@few(2)
@pytest.mark.parametrize(
    ("first", "second", "lyapunov", "verdict"),
    [
        ("-x", "-y - sign(y + x**2)", "Abs(y + x**2) + x**2", AuditVerdict.VALID),
        ("-x", "-y", "x**2 + y**2 + Abs(x**2 + y**2 - 1/8)*(x**2 + y**2)/100", AuditVerdict.VALID),
        ("x/4", "-4*sign(y + x**2)", "4*Abs(y + x**2) + x**2", AuditVerdict.UNDECIDED),  # V grows while it slides
        ("y", "sign(x + y - 3*x**2/4)", "4*Abs(x + y - 3*x**2/4) + x**2", AuditVerdict.INVALID),
        ("-x", "-y", "x**2 + y**2 + (x**2 + y**2)*sign(y + x**2)/4", AuditVerdict.UNDECIDED),  # V jumps
    ],
)
def test_audits_of_v_that_bends_along_a_curve(
    load: Load, first: str, second: str, lyapunov: str, verdict: AuditVerdict
) -> None:
    result = audit(load(first, second), lyapunov)
    assert result.verdict is verdict


def test_where_a_further_cell_meets_the_curve_solutions_may_rest(load: Load) -> None:
    """V falls in all cells and along the curve, but at (1/4, -1/16) four fields hold 0 in their hull."""
    system = load("4*x*(-1 + 4*sign(y + x**2)*sign(x - 1/4))", "-12*sign(y + x**2)")
    lyapunov = "4*Abs(y + x**2) + x**2 + y**2"
    assert audit(system, lyapunov).verdict is AuditVerdict.UNDECIDED
    near = load("4*x*(-1 + 4*sign(y + x**2)*sign(x - 1/4))", "-12*sign(y + x**2)", radius='"1/8"')
    assert audit(near, lyapunov).verdict is AuditVerdict.VALID


@few(1)
@pytest.mark.parametrize("seed", range(8))
def test_proved_v_falls_along_random_curves(load: Load, seed: int) -> None:
    """The sliding value at points of the curve, from the definition in floats."""
    rng = np.random.default_rng(seed)
    a, b, c, d, k, m = (int(v) for v in rng.integers(1, 5, size=6))
    s, t = (int(v) for v in rng.integers(-4, 5, size=2))
    curve = f"(x + {a}*y/2 + {s}*x**2/4 + {t}*x*y/4)"
    system = load(f"{rng.choice(['y', 'y - x/2', '-x + y/2'])}", f"-{b}*sign{curve} + ({s}*x - {d}*y)/4")
    result = audit(system, f"{k}*Abs{curve} + {c}*x**2/2 + y**2/{m}")
    if result.verdict is not AuditVerdict.VALID:
        return
    x = np.linspace(-0.4, 0.4, 41)
    y = -(x + s * x**2 / 4) / (a / 2 + t * x / 4)
    x, y = x[np.abs(y) < 0.5], y[np.abs(y) < 0.5]
    normal = np.array([1 + s * x / 2 + t * y / 4, a / 2 + t * x / 4])
    fields = []
    for side in (1, -1):
        values = {"x": x, "y": y, "Abs": np.abs, "sign": lambda _, side=side: side}
        fields.append(np.array(np.broadcast_arrays(*[eval(f.text, values) for f in system.rhs])))  # noqa: S307
    p, q = ((normal * field).sum(axis=0) for field in fields)
    sliding = (q * fields[0] - p * fields[1]) / (q - p)
    falls = (np.array([c * x, 2 * y / m]) * sliding).sum(axis=0)
    opposed = (p * q < 0) & (np.abs(x) > 1e-9)
    assert np.all(falls[opposed] < 0)


def beside_a_curve(load: Load) -> tuple[Region, list[Polynomial]]:
    """The part of a square where ``q = 2 y + x^2 >= 0``, and the coordinates."""
    field = load("-x", "-y").field
    x, y = (Polynomial.variable(field, ("x", "y"), name) for name in ("x", "y"))
    one, zero = field.one, field.zero
    square = Region(((zero, zero, one), (zero, -one, one), (one, -one, one), (one, one, one), (zero, one, one)))
    return replace(square, guards=(y * 2 + x * x,)), [x, y]


def test_multiples_of_guards_show_what_they_leave(load: Load) -> None:
    """``q + 2 x^2 > 0`` where ``q = 2 y + x^2 >= 0``: along the curve it vanishes to second order."""
    beside, (x, y) = beside_a_curve(load)
    enough = y * 2 + x * x * 3
    assert isinstance(prove(Sense.POSITIVE, enough, beside, except_origin=True), Proof)
    for less in (y * 2 + x * x, -y * 2 - x * x * 3):
        assert not isinstance(prove(Sense.POSITIVE, less, beside, except_origin=True), Proof)
    wider = replace(beside, guards=(enough,))
    assert not isinstance(prove(Sense.POSITIVE, enough, wider, except_origin=True), Proof)
    assert isinstance(prove(Sense.NONNEGATIVE, y * 2 + x * x, beside), Proof)


def test_what_follows_from_a_guard_holds_at_points(load: Load) -> None:
    """``c q`` and a form of higher order beside random curves: proofs against values, at points ever nearer."""
    rng = np.random.default_rng(3)
    beside, (x, y) = beside_a_curve(load)
    scales, proved, refuted = 0.5 ** np.arange(12), 0, 0
    for _ in range(24):
        a, b, c = (int(v) for v in rng.integers(-3, 4, 3))
        curve = y * 2 + x * x * a + x * y * b
        polynomial = curve * int(rng.integers(1, 4)) + x * x * c + y * y * int(rng.integers(-1, 3))
        outcome = prove(Sense.POSITIVE, polynomial, replace(beside, guards=(curve,)), except_origin=True)
        xs = np.concatenate([share * scales for share in np.linspace(0.25, 0.5, 16)])
        ys = np.concatenate([-a * xs**2 / (2 + b * xs) + above * xs**2 for above in (1e-6, 0.01, 0.3, 2.0)])
        xs = np.tile(xs, 4)
        inside = (np.abs(ys) <= xs) & (float(a) * xs**2 + b * xs * ys + 2 * ys >= 0)
        values = sum(float(v) * xs**i * ys**j for (i, j), v in polynomial.terms.items())[inside]
        if isinstance(outcome, Proof):
            assert np.all(values > 0)
            proved += 1
        refuted += bool((values < 0).any())
    assert proved >= 5
    assert refuted >= 5


@pytest.mark.usefixtures("without_far_starts")
def test_a_v_that_bends_along_a_curve_has_a_rate(load: Load) -> None:
    """``x' = -x`` and V = x**2 on the curve, where x stays: V' <= -2 V at best."""
    result = decide_system(load("-x", "-y - sign(y + x**2)", lyapunov='"Abs(y + x**2) + x**2 + y**2"'))
    rate = result.reach.rate
    assert rate is not None
    assert 0 < rate.kappa <= 2
    assert result.check()
    assert not with_reach(result, rate=replace(rate, kappa=rate.kappa + 2)).check()
