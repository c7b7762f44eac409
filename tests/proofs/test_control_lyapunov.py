"""Control Lyapunov functions ``c^T P c + w theta^2``: every P that serves is found, and what is found serves."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import islice
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.control_fields import InputCell, RowInputs
from nonsmooth.proofs.clauses.feedback.control_lyapunov import (
    SQUARES,
    ControlLyapunov,
    Demand,
    find_shapes,
    shape_regions,
)
from nonsmooth.proofs.clauses.feedback.gradient_law import certified_rate
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.thorough import few, keep

Shape: TypeAlias = tuple[Fraction, Fraction]

ROLL = (1, Fraction(1, 2))
SEEDS = range(30)
MILD = (0, 9, 14, 18, 21)  # short control fields: the loops of others are too stiff for an explicit integrator
SAMPLES = 4_000
INTEGRATION = 1e-6  # relative, of the integrator
ROUNDING = 1e-9  # of V'/V, in terms of order one

ARRAYS = Arrays()


def opposite_alike(seed: int) -> Scene:
    """Wheels on the unit circle with any rims, opposite ones alike, so that the origin is an equilibrium."""
    rng = np.random.default_rng(seed)
    wheels: list[WheelData] = []
    for _ in range(int(rng.integers(2, 4))):
        x, y = ARRAYS.circle_point(Fraction(int(rng.integers(-8, 9)), int(rng.integers(1, 6))))
        a, b = rng.integers(-4, 5, 2).tolist()
        if (x, y) not in {w.position for w in wheels}:
            a, b = (a, b) if a or b else (1, 0)
            wheels += [WheelData((x, y), (a, b)), WheelData((-x, -y), (-a, -b))]
    return ARRAYS.scene(wheels, ROLL)


@cache
def decided(seed: int, *, any_rims: bool) -> tuple[Partition, FeedbackResult]:
    scene = opposite_alike(seed) if any_rims else ARRAYS.cocircular(seed, ROLL)
    partition = build_nearest_partition(scene)
    return partition, decide_feedback(partition)


def local_cells(result: FeedbackResult) -> list[InputCell]:
    return list(result.inputs.local)


def demands_of(result: FeedbackResult) -> list[Demand]:
    return [data.demand for data in local_cells(result)]


def shapes(seed: int, count: int) -> list[Shape]:
    """Random rational (e, f) in the unit disc."""
    rng = np.random.default_rng(seed)
    found: list[Shape] = []
    while len(found) < count:
        e, f = (Fraction(int(n), 1000) for n in rng.integers(-999, 1000, 2))
        if e * e + f * f < 1:
            found.append((e, f))
    return found


def serves(demands: list[Demand], shape: Shape) -> bool:
    """By the definition: ``c^T P D_i`` has one strict sign at the vertices of each cell, P written out."""
    (e, f), good = shape, True
    for demand in demands:
        d = demand.direction
        values = [x * ((1 + e) * d[0] + f * d[1]) + y * (f * d[0] + (1 - e) * d[1]) for x, y in demand.vertices]
        good = good and {value.sign() for value in values} in ({1}, {-1})
    return good


# ---- the search is complete ----------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("any_rims", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_regions_hold_exactly_the_p_that_serve(seed: int, any_rims: bool) -> None:
    _, result = decided(seed, any_rims=any_rims)
    demands = demands_of(result)
    regions = [polygon for _, polygon in shape_regions(demands)]
    field = demands[0].direction[0].field

    def strictly_inside(polygon: Polygon, shape: Shape) -> bool:
        point = (field(shape[0]), field(shape[1]))
        return all(side.slack(point).sign() > 0 for side in polygon.sides)

    for shape in shapes(seed, 60):
        assert serves(demands, shape) == any(strictly_inside(polygon, shape) for polygon in regions)


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_one_p_is_found_in_every_region(seed: int) -> None:
    _, result = decided(seed, any_rims=True)
    demands = demands_of(result)
    found = list(find_shapes(demands))
    assert len(found) == len(shape_regions(demands))
    assert all(serves(demands, shape) for shape in found)
    assert all(ControlLyapunov(shape).is_positive for shape in found)


@pytest.mark.parametrize(("seeds", "any_rims"), keep(1, [(range(3), False), (SEEDS, False), (SEEDS, True)]))
def test_where_squares_fail_a_p_is_found_or_excluded(seeds: range, any_rims: bool) -> None:
    """Two inputs in every cell: each array has a certified V or a proof that no such V exists; both occur."""
    outcomes = set()
    for seed in seeds:
        _, result = decided(seed, any_rims=any_rims)
        if all(data.lever is not None for data in local_cells(result)):
            found = result.has_lyapunov
            assert found != result.none_serves
            outcomes.add((found, result.lyapunov == SQUARES))
    assert outcomes == {(True, True), (True, False), (False, True)}


@pytest.mark.parametrize(
    ("half_width", "turn", "serves_square"),
    [
        (1, (20, 21), False),
        (1, (3, 4), False),
        (2, (4, 3), True),
        (2, (3, 4), True),
        (3, (1, 1), True),
        (3, (0, 1), False),
    ],
)
def test_turned_rims_on_a_rectangle(half_width: int, turn: tuple[int, int], serves_square: bool) -> None:
    """On a square no P helps where P = I does not, on a long rectangle one may: a circle has no long axis."""
    corners = [(half_width, 1), (-half_width, 1), (-half_width, -1), (half_width, -1)]
    result = decide_feedback(build_nearest_partition(ARRAYS.scene(ARRAYS.inward(corners, turn), ROLL)))
    assert result.has_lyapunov == serves_square == (result.lyapunov != SQUARES)
    assert result.none_serves != serves_square


# ---- what is found ---------------------------------------------------------------------------------


def shaped_results(count: int | None) -> list[tuple[Partition, FeedbackResult]]:
    """The first arrays whose certified V is no sum of squares, or all; no array after them is decided."""
    every = (decided(seed, any_rims=any_rims) for seed in SEEDS for any_rims in (False, True))
    return list(islice((pair for pair in every if pair[1].lyapunov != SQUARES), count))


def inverse_rows(data: InputCell) -> NDArray[np.float64]:
    """Twists for unit input at the nearest and the second wheel, by a float solve of the three rows."""
    rows = []
    for row in data.state.rows:
        d = np.array([float(x) for x in row.wheel.unit_direction])
        p = np.array([float(x) for x in row.wheel.position])
        along = d if row.name.startswith("R") else np.array([-d[1], d[0]])
        rows.append([*along, along @ [-p[1], p[0]]])
    return np.linalg.inv(np.array(rows))[:, [0, 2]]


def worst_rate(data: InputCell, lyapunov: ControlLyapunov, within: float, seed: int) -> float:
    """Largest ``V'/V`` under the law with gain one at random states of the cell, from the exact pose kinematics."""
    rng = np.random.default_rng(seed)
    corners = np.array([[float(x) for x in vertex] for vertex in data.demand.vertices])
    (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
    p = np.array([[1 + e, f], [f, 1 - e]])
    c = rng.exponential(size=(SAMPLES, len(corners))) ** 2 @ corners
    c *= (within * rng.random(SAMPLES) / np.hypot(*c.T))[:, None]
    theta = rng.normal(size=SAMPLES) * np.hypot(*c.T) * 10 ** rng.uniform(-2, 2, SAMPLES)
    g = inverse_rows(data)
    gradient = 2 * np.column_stack([c @ p, w * theta])
    turned = np.column_stack([-c[:, 1], c[:, 0]])
    rates = np.stack([(gradient[:, :2] * (g[:2, k] + g[2, k] * turned)).sum(axis=1) for k in (0, 1)])
    rates += gradient[:, 2] * g[2, :, None]
    inputs = -rates / 2  # u = -k (a, b) with k = 1: a and b are the halves of the rates
    v = ((c @ p) * c).sum(axis=1) + w * theta**2
    return float(((rates * inputs).sum(axis=0) / v).max())


def best_rate(data: InputCell, lyapunov: ControlLyapunov) -> float:
    """Least ``(a^2 + b^2)/V`` to first order: by direction c the smaller eigenvalue of a pencil in (|c|, tau)."""
    corners = np.array([[float(x) for x in vertex] for vertex in data.demand.vertices])
    x, y = corners.mean(axis=0)
    angles = np.arctan2(corners @ [-y, x], corners @ [x, y]) + np.arctan2(y, x)
    c = np.array([(np.cos(t), np.sin(t)) for t in np.linspace(angles.min(), angles.max(), SAMPLES)])
    (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
    slopes, g = c @ np.array([[1 + e, f], [f, 1 - e]]), inverse_rows(data)
    sizes = np.sqrt((slopes * c).sum(axis=1))
    response = np.stack([(slopes @ g[:2]) / sizes[:, None], np.broadcast_to(g[2] * np.sqrt(w), (SAMPLES, 2))], axis=2)
    return float(np.linalg.svd(response, compute_uv=False).min() ** 2)


@pytest.mark.parametrize("count", keep(1, [1, 2, None]))
def test_the_rate_holds_under_exact_kinematics_within_its_reach(count: int | None) -> None:
    """``V' <= -2 kappa V`` at sampled states, and kappa is the best to first order but for rounding and slack."""
    for k, (_, result) in enumerate(shaped_results(count)):
        assert result.rate is not None
        reach = result.rate.reach
        assert reach is not None
        worst = max(worst_rate(data, result.lyapunov, float(reach), k) for data in local_cells(result))
        assert worst <= -2 * float(result.rate.kappa) + ROUNDING
        best = min(best_rate(data, result.lyapunov) for data in local_cells(result))
        assert 0.98 * best <= float(result.rate.kappa) <= best


def test_the_closed_loop_decays_at_the_certified_rate() -> None:
    """``V(t) <= V(0) exp(-2 kappa t)`` along a Filippov solution through several cells, from a start within reach."""
    crossed = 0
    for seed in MILD:
        partition, result = decided(seed, any_rims=False)
        assert result.rate is not None
        assert result.rate.reach is not None
        (e, f), w = (float(x) for x in result.lyapunov.shape), float(result.lyapunov.weight)
        law = gradient_law(1, (e, f), w)
        size = float(result.rate.reach) / 4
        path = simulate(feedback_field(partition, law, Kinematics.EXACT), (0.9 * size, 0.4 * size, size), 4)
        x, y, theta = path.array.T
        v = (1 + e) * x**2 + 2 * f * x * y + (1 - e) * y**2 + w * theta**2
        bound = v[0] * np.exp(-2 * float(result.rate.kappa) * np.array(path.times))
        assert (v <= bound * (1 + INTEGRATION)).all()
        assert v[-1] < v[0]
        crossed += len(path.events)
    assert crossed > 8


@pytest.mark.parametrize("count", keep(1, [2, 6]))
def test_any_weight_serves_and_half_of_the_best_rate_is_reached(count: int) -> None:
    for partition, result in shaped_results(count):
        assert result.rate is not None
        shape = result.lyapunov.shape
        light, best = (
            certified_rate(RowInputs(partition), ControlLyapunov(shape, Fraction(2) ** k)) for k in (-20, 60)
        )
        assert light is not None
        assert best is not None
        assert 0 < light.kappa < result.rate.kappa <= best.kappa
        assert result.rate.kappa >= Fraction(49, 100) * best.kappa
        half = certified_rate(RowInputs(partition), replace(result.lyapunov, weight=result.lyapunov.weight / 2))
        assert half is not None
        assert half.kappa <= Fraction(51, 100) * best.kappa
