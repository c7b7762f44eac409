"""How paths end, and maps of where they end."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.polygon import HalfPlane, clipped_by, square
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field, piecewise_constant
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.minimizers.agreement import (
    OUTSIDE,
    PointLocator,
    compare_rules,
    comparison_grid,
    shared_area,
)
from nonsmooth.analysis.trajectories.maps import SettleMap, grid_starts, settle_map, settle_maps
from nonsmooth.analysis.trajectories.piecewise_constant import follow_constant
from nonsmooth.analysis.trajectories.result import (
    CREEP,
    REST,
    End,
    EndMotion,
    EndReason,
    Piece,
    State,
    Trajectory,
    ending,
)
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.thorough import few, keep, thorough

# ---- Maps of ends: the four-wheel formula, the scalar integrator as the slow definition, and every kind of end.

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


def test_slides_on_one_edge_end_at_two_points() -> None:
    """Between turns about (-1, 1) and (1, -1), y' = y on the line x = 0, which ends at (0, 1) and at (0, -1)."""
    left, right = HalfPlane((1, 0), 0), HalfPlane((-1, 0), 0)
    domain = square((Fraction(0), Fraction(0)), Fraction(3))
    field = piecewise_constant(domain, [((left,), (1, 1, 1)), ((right,), (-1, -1, 1))], Kinematics.EXACT)
    ends = settle_map(field, np.array([(x, y) for x in (-0.2, 0.2) for y in (0.5, -0.5)]))
    assert {ends.ends[k] for k in ends.basin} == {(EndReason.CIRCLES, "cell 1"), (EndReason.CIRCLES, "cell 2")}
    assert (ends.theta == math.inf).all()


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


# ---- How paths end: against paths whose end is known without following them ----------------------

Pose = tuple[float, float, float]


def path_of(state_at: object, until: float, reason: EndReason = EndReason.TIME) -> Trajectory:
    """A path in one piece, given as a function of time."""

    def state(time: float) -> State:
        return tuple(state_at(time))  # type: ignore[operator]

    times = tuple(np.linspace(0.0, until, 11).tolist())
    piece = Piece(0.0, until, "", (), state, lambda: times)
    end = End(until, state(until), reason)
    return Trajectory("exact", "events", (), end, True, (piece,))


def test_an_arrival_in_finite_time_is_met_to_rounding() -> None:
    arrives = 0.73105857863
    found = ending(path_of(lambda t: (max(arrives - t, 0.0), 0.0, 0.1), 2.0), 1.0, 1.0)
    assert found.motion is EndMotion.AT_REST
    assert found.since == pytest.approx(arrives, abs=1e-7)
    assert (found.speed, found.turning) == (0.0, 0.0)


@pytest.mark.parametrize("rate", [1.0, 3.0])
def test_a_point_that_is_approached_rests_when_its_speed_is_small(rate: float) -> None:
    """``x = exp(-rate t)`` with the unit of speed ``rate``, that at the start: ``exp(-rate t) = REST``."""
    until = 30.0
    found = ending(path_of(lambda t: (math.exp(-rate * t), 0.0, 0.0), until), 1.0, 1.0)
    expected = math.log(1 / REST) / rate
    assert found.motion is EndMotion.AT_REST
    assert found.since == pytest.approx(expected, abs=until / 500)


def test_slow_and_fast_ends_are_told_apart() -> None:
    for speed, motion in ((REST / 2, EndMotion.AT_REST), (2 * REST, EndMotion.CREEPS), (2 * CREEP, EndMotion.MOVING)):
        found = ending(path_of(lambda t, v=speed: (v * t, 0.0, 0.0), 5.0), 1.0, 1.0)
        assert found.motion is motion
        assert found.speed == pytest.approx(speed)


def test_rounding_of_a_body_that_stands_is_rest() -> None:
    found = ending(path_of(lambda t: (0.1 + 1e-15 * math.sin(9 * t), 0.0), 2.0))
    assert (found.motion, found.since) == (EndMotion.AT_REST, 0.0)


def test_a_motion_far_away_that_floats_hold_is_no_rest() -> None:
    found = ending(path_of(lambda t: (1e13 - 2 * t, -2.0), 10.0))
    assert found.motion is EndMotion.MOVING
    assert found.speed == pytest.approx(2, rel=0.1)


def test_turning_in_place_is_no_rest() -> None:
    found = ending(path_of(lambda t: (0.0, 0.0, -0.5 * t), 5.0), 0.1, 1.0)
    assert found.motion is EndMotion.MOVING
    assert found.speed == 0.0
    assert found.turning == pytest.approx(-0.5)


def test_a_body_that_passes_its_end_is_not_at_rest_then() -> None:
    """It comes through the last state at full speed before; rest begins where it stays."""

    def swings(t: float) -> Pose:
        return (math.sin(2 * math.pi * min(t, 1.0)), 0.0, 0.0)

    found = ending(path_of(swings, 3.0), 1.0, 1.0)
    assert found.since == pytest.approx(1.0, abs=1e-4)


def test_states_of_plain_systems_count_alike() -> None:
    found = ending(path_of(lambda t: (3 * t, 4 * t), 1.0))
    assert (found.motion, found.turning) == (EndMotion.MOVING, None)
    assert found.speed == pytest.approx(5.0)
    still = ending(path_of(lambda t: (1.0, 2.0), 1.0))
    assert (still.motion, still.since) == (EndMotion.AT_REST, 0.0)


def test_samples_without_pieces_are_read_between() -> None:
    path = path_of(lambda t: (max(1 - t, 0.0), 0.0, 0.0), 2.0)
    sampled = Trajectory("exact", "hysteresis", (), path.end, None, sampled=(path.times, path.states))
    assert ending(sampled, 1.0, 1.0).since == pytest.approx(1.0, abs=1e-3)


# ---- Paths are called unique only where nothing else was left open -------------------------------


def follow(tmp_path: Path, rhs: list[str], start: list[float]) -> Trajectory:
    file = tmp_path / "my.toml"
    states = ["x", "y", "z"][: len(rhs)]
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n", encoding="utf-8")
    return simulate(system_field(load_system(file), start), start, 1.0)


def squeezed(first: str, second: str) -> list[str]:
    """(1, 3 x) between two curves, of which y = 3 x^2/2 is a solution; (0, -1) outside."""
    inside = f"(1 - sign({first})*sign({second}))/2"
    return [inside, f"3*x*{inside} - (1 - {inside})"]


def test_a_cell_squeezed_between_tangent_curves_may_be_entered(tmp_path: Path) -> None:
    """From the origin both (0, -t) and (t, 3 t^2/2) are solutions; no tangent cone shows the second cell."""
    path = follow(tmp_path, squeezed("y - x**2", "y - 2*x**2"), [0.0, 0.0])
    assert path.unique is None
    assert any("touch here" in event.note for event in path.events)


@pytest.mark.parametrize(
    ("rhs", "start"),
    [
        (["-sign(y - x**2)", "-1"], [0.25, 1.0]),  # one curve is crossed
        (["-sign(x + y) - sign(x - y)", "-sign(x + y) + sign(x - y)"], [0.0, 0.0]),  # lines through one point
        (["-sign(x)", "-sign(y - x**2)"], [0.0, 0.0]),  # transversal, one of them curved
        (["-sign(x)", "-sign(y)", "-sign(z)"], [0.1, 0.2, 0.1]),
        (squeezed("y - x**2", "y - 2*x**2"), [0.5, 0.375]),  # inside the narrow cell, away from the contact
    ],
)
def test_transversal_surfaces_leave_no_doubt(tmp_path: Path, rhs: list[str], start: list[float]) -> None:
    assert follow(tmp_path, rhs, start).unique


@pytest.mark.parametrize("side", [Fraction(1, 2), Fraction(1, 5), Fraction(1, 100)])
def test_share_of_equal_twists_on_four_wheel(arrays: Arrays, side: Fraction) -> None:
    scene = arrays.four_wheel((1, side))
    shared = shared_area(build_nearest_partition(scene), build_box_partition(scene))
    assert shared.share == max(0, 1 - 2 * side)
    assert len(shared.shared_twists) == (8 if side < Fraction(1, 2) else 0)


def test_a_partition_agrees_with_itself_everywhere(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.ring(5))
    assert shared_area(partition, partition).share == 1


def test_share_against_counting_points(arrays: Arrays) -> None:
    scene = arrays.ring(6, (1, Fraction(1, 20)), Fraction(1, 4))
    first, second = build_nearest_partition(scene), build_box_partition(scene)
    points = np.random.default_rng(0).uniform(-0.25, 0.25, (40_000, 2))
    same = np.abs(PointLocator(first).twists(points) - PointLocator(second).twists(points)).max(axis=1) < 1e-12
    # 40,000 points: the share's standard error is below 0.0025
    assert abs(same.mean() - float(shared_area(first, second).share)) < 0.01


def test_points_are_located_in_the_cell_that_holds_them(arrays: Arrays) -> None:
    rng = np.random.default_rng(3)
    scene = arrays.grid(4, 4, (1, Fraction(1, 5)))
    partition = build_box_partition(scene)
    inside = [arrays.interior_point(cell.polygon, rng) for cell in partition.cells]
    points = np.array([[float(x), float(y)] for x, y in inside])
    assert PointLocator(partition).locate(points).tolist() == list(range(len(inside)))
    assert PointLocator(partition).locate(np.array([[9.0, 9.0]])).tolist() == [OUTSIDE]
    assert np.isnan(PointLocator(partition).twists(np.array([[9.0, 9.0]]))).all()


@pytest.mark.parametrize("name", ["four-wheel", "grid-4x4"])
def test_points_in_buckets_are_located_as_points_one_by_one(name: str) -> None:
    locator = PointLocator(build_box_partition(load_scene(name, rule="box")))
    reach = float(locator.partition.scene.check.radius)
    many = np.random.default_rng(0).uniform(-1.2 * reach, 1.2 * reach, (20_000, 2))
    many[:4] = [(reach, reach), (-reach, -reach), (np.nan, 0), (1e9, -1e9)]
    few = np.concatenate([locator.locate(points) for points in np.array_split(many, 20)])
    found = locator.locate(many)
    assert found.tolist() == few.tolist()
    inside = np.abs(many).max(axis=1) <= reach
    assert (found[inside] != OUTSIDE).all()
    assert (found[~inside] == OUTSIDE).all()


def test_disjoint_polygons_have_no_intersection(arrays: Arrays) -> None:
    cells = build_nearest_partition(arrays.four_wheel()).cells
    assert clipped_by(cells[0].polygon, cells[1].polygon.sides) is None
    assert clipped_by(cells[0].polygon, cells[0].polygon.sides) == cells[0].polygon


def test_the_three_rules_side_by_side(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 100)))
    agreement = compare_rules(scene)
    assert agreement.shared["nearest", "box"].share == Fraction(49, 50)
    # on the grid, whose points lie in the cells in the same shares, box and nearest differ on about 2 %
    points = comparison_grid(scene)
    near, box = (PointLocator(p).twists(points) for p in agreement.partitions.values())
    assert (np.abs(near - box).max(axis=1) > 1e-12).mean() == pytest.approx(1 / 50, abs=0.02)
    assert agreement.differences["ellipse", "box"].mean is not None
    assert agreement.differences["ellipse", "box"].largest is not None
    assert 0 < agreement.differences["ellipse", "box"].mean <= agreement.differences["ellipse", "box"].largest <= 2


def test_rules_agree_where_all_wheels_carry_the_body(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tangential rims of one speed: every rule gives the same rotation everywhere."""
    monkeypatch.setattr("nonsmooth.analysis.minimizers.agreement.GRID", 12)
    agreement = compare_rules(load_scene("conveyor-3"))
    assert agreement.shared["nearest", "box"].share == 1
    for difference in agreement.differences.values():
        assert difference.largest is not None
        assert difference.largest < 1e-6


@pytest.mark.parametrize("seed", keep(2, range(12)))
def test_maps_that_are_followed_together_are_those_of_each(arrays: Arrays, seed: int) -> None:
    """Fields with other numbers of cells, sides, edges and corners, other sizes, and other numbers of starts."""
    rng = np.random.default_rng(seed)
    scenes = [arrays.random(10 * seed + k, int(rng.integers(3, 7))) for k in range(4)]
    fields = [
        array_field(build_nearest_partition(arrays.with_friction(scene, SIDE)), Kinematics.EXACT) for scene in scenes
    ]
    fields[2:2] = [built_in(name, Kinematics.EXACT) for name in ("spiral-30", "conveyor-3")]
    maps = [(field, grid_starts(field, 3 + k)) for k, field in enumerate(fields)]
    for (field, starts), together in zip(maps, settle_maps(maps, theta=0.5), strict=True):
        alone = settle_map(field, starts, theta=0.5)
        assert together.ends == alone.ends
        for name in ("starts", "theta", "arrival", "points", "basin", "unique"):
            assert np.array_equal(getattr(together, name), getattr(alone, name), equal_nan=True)
