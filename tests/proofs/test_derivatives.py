"""Derivatives of nonsmooth V: the golden ladder, linear programs as a second opinion, and the parts of the domain."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from nonsmooth.analysis.cells.switched_cells import LyapunovCell, gradients_at, lyapunov_cells, velocities_at
from nonsmooth.proofs.inequalities.kinks import Interval, Kink, Trend, Trends, ladder_at
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, derivatives_at, examine
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.proofs.conftest import Load
from tests.thorough import examples, few

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
    assert str(ladder.shevitz_paden) == shevitz_paden
    assert (None if ladder.bacciotti_ceragioli is None else str(ladder.bacciotti_ceragioli)) == bacciotti_ceragioli


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
    found = [result.supremum(kind).value for kind in ("naive", "shevitz_paden", "bacciotti_ceragioli")]
    assert [str(value) for value in found] == [str(value) for value in (naive, shevitz_paden, bacciotti_ceragioli)]


def test_the_ladder_at_the_equilibrium_itself() -> None:
    result = decide_system(load_system("relay-oscillator"))
    zero = result.scene.field.zero
    assert isinstance(result.given, PlaneFunction)
    cells = result.given.result.cells
    ladder = ladder_at(velocities_at(cells, (zero, zero)), gradients_at(cells, (zero, zero)))
    assert str(ladder.naive) == "[-2, 2]"
    assert str(ladder.bacciotti_ceragioli) == "{0}"


def test_smooth_v_needs_no_surfaces() -> None:
    result = examined(load_system("eq-3"), "x**2 + y**2")
    assert all(isinstance(stratum.evidence, tuple) for stratum in result.strata)  # of cells
    assert result.verdict is Decrease.WEAK
    supremum = result.supremum("bacciotti_ceragioli")
    assert (supremum.trend, supremum.value) == (Trend.NONPOSITIVE, None)  # it varies over the cells


# ---- one point: linear programs ------------------------------------------------------------------


def largest(costs: Sequence[float], rows: Sequence[Sequence[float]], rhs: Sequence[float]) -> float | None:
    """Maximum over convex weights with equations; None where there are none."""
    found = linprog(-np.array(costs), A_eq=np.array([*rows, np.ones(len(costs))]), b_eq=[*rhs, 1], bounds=(0, None))
    return -found.fun if found.success else None


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
        found = linprog(
            [0] * count + [-sign],
            A_ub=np.hstack([-sign * products, np.full((len(products), 1), sign)]),
            b_ub=np.zeros(len(products)),
            A_eq=[[1] * count + [0]],
            b_eq=[1],
            bounds=[(0, None)] * count + [(None, None)],
        )
        return float(found.x[-1])

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
    for found, expected in (
        (ladder.shevitz_paden, intersected_values(velocities, gradients)),
        (ladder.bacciotti_ceragioli, common_values(velocities, gradients)),
    ):
        agrees(found, expected)
    inside(ladder.bacciotti_ceragioli, ladder.shevitz_paden)
    inside(ladder.shevitz_paden, ladder.naive)


def agrees(found: Interval | None, expected: Bounds) -> None:
    assert (found is None) == (expected is None)
    if found is not None and expected is not None:
        assert [float(found.low), float(found.high)] == pytest.approx(expected, abs=SOLVER_ERROR)


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
def test_trends_on_edges_bound_the_ladder_at_their_points(load: Load, lyapunov: str, field: tuple[str, str]) -> None:
    scene = load(*field)
    result = examined(scene, lyapunov)
    kinks = [stratum for stratum in result.strata if isinstance(stratum.evidence, Kink)]
    assert kinks
    for stratum in kinks:
        kink = stratum.evidence
        assert isinstance(kink, Kink)
        for t in kink.samples():
            assert kink.trends_at(t) == trends_of(result, kink.point(t))
        for t in [Fraction(k, 16) for k in (1, 3, 7, 12, 16, 21, 40, 160)]:
            here = trends_of(result, kink.point(t))
            assert kink.trends_at(t) == here
            for name in ("naive", "shevitz_paden", "bacciotti_ceragioli"):
                assert getattr(here, name).rank <= getattr(stratum.trends, name).rank


def trends_of(result: LyapunovResult, point: tuple[Any, Any]) -> Trends:
    """The signs of the largest values at a point, by the ladder there."""
    ladder = derivatives_at(result.cells, point)
    return Trends(*(Trend.EMPTY if i is None else Trend.of_sign(i.high.sign()) for i in ladder))


@few(4)
@pytest.mark.parametrize("lyapunov", BENDING)
@pytest.mark.parametrize("field", FIELDS, ids=range(len(FIELDS)))
def test_trends_on_cells_bound_the_rate_at_their_points(load: Load, lyapunov: str, field: tuple[str, str]) -> None:
    result = examined(load(*field), lyapunov)
    rng = np.random.default_rng(11)
    for cell, stratum in zip(result.cells, result.strata, strict=False):
        assert isinstance(stratum.evidence, tuple)
        for weights in rng.integers(0, 9, size=(12, len(cell.region.generators))):
            x, y, w = (combined(weights.tolist(), [g[axis] for g in cell.region.generators]) for axis in range(3))
            if not w or not (x or y):
                continue
            for rate in cell.rates:
                trend = Trend.of_sign(rate((x / w, y / w)).sign())
                assert trend.rank <= stratum.trends.bacciotti_ceragioli.rank


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
    assert max(s.trends.bacciotti_ceragioli.rank for s in surfaces) == Trend.POSITIVE.rank
    cells = [s for s in result.strata if isinstance(s.evidence, tuple)]
    assert {s.trends.bacciotti_ceragioli for s in cells} == {Trend.NEGATIVE}
