"""Maps of ends: the four-wheel formula, the scalar integrator as the slow definition, and every kind of end."""

from __future__ import annotations

import json
import math
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field, piecewise_constant
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.maps import SettleMap, grid_starts, settle_map
from nonsmooth.analysis.trajectories.piecewise_constant import follow_constant
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.thorough import few, thorough

FORMULA = 1e-12
SCALAR = 1e-9  # long chains of arcs: errors of 2^-53 per leg, amplified by grazing crossings


def built_in(name: str, kinematics: Kinematics) -> ConstantField:
    return array_field(build_nearest_partition(load_scene(name, rule="nearest").recentred()), kinematics)


@thorough  # the small one: test_maps_of_built_in_scenes_against_single_paths
def test_four_wheel_equals_the_formula_at_every_start() -> None:
    """theta_inf = theta_0 + g ||y0| - |x0||/2 and T = (|x0| + |y0|)/sqrt2, on axes and diagonals too (g = 0)."""
    field = built_in("four-wheel", Kinematics.LEADING)
    for count in (200, 41):
        ends = settle_map(field, grid_starts(field, count), theta=0.25)
        x, y = ends.starts.T
        g = np.sign(x * y * (y**2 - x**2))
        assert np.abs(ends.theta - 0.25 - g * np.abs(np.abs(y) - np.abs(x)) / 2).max() <= FORMULA
        assert np.abs(ends.arrival - (np.abs(x) + np.abs(y)) / math.sqrt(2)).max() <= FORMULA
        assert ends.ends == ((EndReason.REST, "corner (0, 0)"),)
        assert not ends.points.any()
        on_axis = (np.minimum(np.abs(x), np.abs(y)) == 0) & (np.maximum(np.abs(x), np.abs(y)) > 0)
        assert (ends.unique == ~on_axis).all()


def test_four_wheel_with_side_friction_stops_on_the_axes() -> None:
    """theta_inf = -g min(|x0|, |y0|)/2 beside the diagonals, from where the path may turn to either axis."""
    field = built_in("four-wheel-side", Kinematics.LEADING)
    ends = settle_map(field, grid_starts(field, 60))
    x, y = ends.starts.T
    beside = np.abs(np.abs(x) - np.abs(y)) > FORMULA
    g = np.sign(x * y * (y**2 - x**2))
    assert np.abs(ends.theta + g * np.minimum(np.abs(x), np.abs(y)) / 2)[beside].max() <= FORMULA
    assert np.abs(ends.points[beside]).min(axis=1).max() <= FORMULA
    assert (ends.unique == beside).all()


@pytest.mark.parametrize(
    "starts",
    [
        [(0, 0)],  # rest, slide up or down, or be carried away on either side
        [(0, 0.5)],
        [(0, 0), (0, 0), (0, -0.25), (0.5, 0)],
    ],
)
def test_starts_on_a_repelling_line_are_not_unique(starts: list[tuple[float, float]]) -> None:
    """x' = sign(x): where fields push apart, resting on the line is one solution of many."""
    right, left = HalfPlane((-1, 0), 0), HalfPlane((1, 0), 0)
    pieces = [((right,), (1, 0, 0)), ((left,), (-1, 0, 0))]
    field = piecewise_constant(square((Fraction(0), Fraction(0)), Fraction(1)), pieces)
    ends = settle_map(field, np.array(starts))
    assert ends.unique.tolist() == [x != 0 for x, _ in starts]
    assert ends.unique.tolist() == [simulate(field, (*start, 0), 9).unique for start in starts]


def assert_same_as_one_by_one(field: ConstantField, ends: SettleMap) -> None:
    for k, start in enumerate(ends.starts.tolist()):
        path = follow_constant(field, (*start, 0.0), None, None)
        reason = ends.ends[ends.basin[k]][0]
        assert reason is path.end.reason
        if reason in (EndReason.REST, EndReason.OUTSIDE):
            found = [ends.arrival[k], ends.theta[k]]
            assert found == pytest.approx([path.end.t, path.end.state[2]], abs=SCALAR)
        if reason in (EndReason.REST, EndReason.OUTSIDE, EndReason.APPROACH):
            assert ends.points[k] == pytest.approx(np.array(path.end.state[:2], dtype=float), abs=SCALAR)


@pytest.mark.parametrize("kinematics", list(Kinematics))
@pytest.mark.parametrize("seed", range(16))
def test_maps_of_random_arrays_against_single_paths(arrays: Arrays, seed: int, kinematics: Kinematics) -> None:
    rng = np.random.default_rng(seed)
    friction = (ROLL, SIDE)[seed % 2]
    scene = arrays.with_friction(arrays.random(seed, int(rng.integers(3, 7))), friction)
    field = array_field(build_nearest_partition(scene), kinematics)
    low, high = (np.array([float(v) for v in p]) for p in (field.cells.points[0], field.cells.points[0]))
    for point in field.cells.points:
        low, high = np.minimum(low, point), np.maximum(high, point)
    assert_same_as_one_by_one(field, settle_map(field, rng.uniform(low, high, (25, 2))))


@few(2)
@pytest.mark.parametrize("name", ["spiral-30", "conveyor-3", "elliptic", "saddle", "off-center"])
def test_maps_of_built_in_scenes_against_single_paths(name: str) -> None:
    field = built_in(name, Kinematics.EXACT)
    ends = settle_map(field, grid_starts(field, 7))
    assert_same_as_one_by_one(field, ends)


def test_the_rest_area_of_rule_box(arrays: Arrays) -> None:
    """Nothing moves where |x| + |y| <= mu_S/mu_R, and everything else stops on its border."""
    field = array_field(build_box_partition(arrays.four_wheel((1, Fraction(1, 5)))), Kinematics.EXACT)
    ends = settle_map(field, grid_starts(field, 30))
    reach = np.abs(ends.starts).sum(axis=1)
    assert (ends.arrival[reach < 0.2] == 0).all()
    assert np.abs(ends.points[reach > 0.2]).sum(axis=1) == pytest.approx(0.2, abs=FORMULA)
    assert {reason for reason, _ in ends.ends} == {EndReason.REST}


def test_turning_and_circling_have_no_final_heading() -> None:
    turning = settle_map(built_in("conveyor-3", Kinematics.LEADING), np.array([[0.1, 0.05]]))
    assert (turning.ends[0][0], turning.arrival[0], turning.theta[0]) == (EndReason.TURNING, 0, -math.inf)
    circling = settle_map(built_in("conveyor-3", Kinematics.EXACT), np.array([[0.1, 0.05]]))
    assert (circling.ends[0][0], circling.arrival[0], circling.theta[0]) == (EndReason.CIRCLES, math.inf, -math.inf)
    record = json.loads(json.dumps(circling.record(), allow_nan=False))
    assert (record["theta"], record["arrival"]) == ([None], [None])
    assert record["ends"][0]["reason"] == EndReason.CIRCLES.value


def test_a_map_seen_early_forgets_late_arrivals_only() -> None:
    """Closed orbits never arrive, whenever one looks; a kind of end that nobody has reached yet is not listed."""
    field = built_in("four-wheel", Kinematics.LEADING)
    ends = settle_map(field, np.array([[0.2, 0.1], [0.4, 0.3]]))
    early, late = ends.seen_until(0.3), ends.seen_until(1.0)
    assert late is ends
    assert early.ends == ((EndReason.REST, "corner (0, 0)"), (EndReason.TIME, ""))
    assert (early.arrived.tolist(), early.settled.tolist()) == ([True, False], [True, False])
    assert early.shares == (0.5, 0.5)
    assert ends.seen_until(0.01).ends == ((EndReason.TIME, ""),)
    circling = settle_map(built_in("conveyor-3", Kinematics.EXACT), np.array([[0.1, 0.05]]))
    assert circling.seen_until(0.01) is circling
    assert not circling.arrived.any()


def test_progress_counts_up_to_all_starts() -> None:
    said: list[tuple[int, int]] = []
    field = built_in("four-wheel", Kinematics.LEADING)
    settle_map(field, grid_starts(field, 4), report=lambda done, total: said.append((done, total)))
    assert said[-1] == (16, 16)
    assert said == sorted(said)


def test_exact_fields_are_rounded_and_input_is_checked(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING, exact=True)
    assert settle_map(field, np.array([[0.2, 0.4]])).theta == pytest.approx([0.1], abs=FORMULA)
    with pytest.raises(ValueError, match="inside the domain"):
        settle_map(field, np.array([[2.0, 0.0]]))
    with pytest.raises(ValueError, match="at least two"):
        grid_starts(field, 1)
