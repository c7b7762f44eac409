"""What must not change, and must follow, when an array is changed; and stress tests of whole scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from flint import arb

from nonsmooth.analysis.cells.filippov import upper_derivative_at
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.measurements import cases
from nonsmooth.analysis.measurements.cases import (
    DETERMINANTS,
    FEEDBACK,
    OFFSETS,
    POWERS,
    RATIOS,
    SCALES,
    STARTS,
    SWITCHES,
    TINY,
    array_scale_rows,
    collinear_rows,
    feedback_rows,
    load_scale_rows,
    support_rows,
    system_scale_rows,
)
from nonsmooth.analysis.measurements.harness import Case, Outcome, ResultRow, Rows, judged, measure
from nonsmooth.analysis.trajectories import follow as engine
from nonsmooth.analysis.trajectories.closed_forms import Free
from nonsmooth.analysis.trajectories.smooth_path import IMPLICIT
from nonsmooth.proofs import measurements
from nonsmooth.proofs.measurements import ARRAY_VERDICTS, CASES
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_any, load_scene, load_system
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Row, Twist
from nonsmooth.symbolic.mechanics.scene import Friction, LoadTable, Scene, Wheel
from nonsmooth.symbolic.mechanics.similar_scenes import scaled, with_wheels
from nonsmooth.symbolic.numbers import enclosures
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.built_in import drift, verdicts
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.oracles.measured_tables import MeasuredTable
from tests.proofs.conftest import Load
from tests.thorough import keep, thorough

# ---- What must not change when an array is rotated, reflected, scaled, sped up or renumbered, and what must follow

Rational: TypeAlias = int | Fraction
Matrix: TypeAlias = tuple[Rational, Rational, Rational, Rational]

SEEDS = range(6)
REMEMBERED = 2 * len(SEEDS)
TURN_3_4_5: Matrix = (Fraction(3, 5), Fraction(-4, 5), Fraction(4, 5), Fraction(3, 5))
TURN_5_12_13: Matrix = (Fraction(-5, 13), Fraction(-12, 13), Fraction(12, 13), Fraction(-5, 13))
MIRROR: Matrix = (Fraction(-7, 25), Fraction(24, 25), Fraction(24, 25), Fraction(7, 25))  # in an oblique line
SWAP: Matrix = (0, 1, 1, 0)
QUARTER: Matrix = (0, -1, 1, 0)


@lru_cache(maxsize=REMEMBERED)
def built(kind: str, seed: int) -> Scene:
    if kind == "random":
        return Arrays().random(seed, 3 + seed % 4).recentred()
    return Arrays().cocircular(seed)


@pytest.fixture(params=["random", "cocircular"])
def build(request: pytest.FixtureRequest) -> Callable[[int], Scene]:
    return partial(built, request.param)


check_unchanged = lru_cache(maxsize=REMEMBERED)(check_cells)  # the same array is compared with many


def image(matrix: Matrix, vector: Vector) -> Vector:
    a, b, c, d = matrix
    return vector[0] * a + vector[1] * b, vector[0] * c + vector[1] * d


def mapped(scene: Scene, change: Callable[[Wheel], Wheel]) -> Scene:
    return replace(scene, wheels=tuple(change(wheel) for wheel in scene.wheels))


def moved(scene: Scene, matrix: Matrix) -> Scene:
    """The array carried along by an orthogonal map; the checked square stays."""

    def carried(wheel: Wheel) -> Wheel:
        return replace(wheel, position=image(matrix, wheel.position), direction=image(matrix, wheel.direction))

    return mapped(scene, carried)


# ---- orthogonal maps -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("matrix", "sense"),
    [(TURN_3_4_5, 1), (TURN_5_12_13, 1), (MIRROR, -1), (SWAP, -1), (QUARTER, 1)],
    ids=["3-4-5", "5-12-13", "mirror", "swap", "quarter"],
)
@pytest.mark.parametrize("seed", SEEDS)
def test_orthogonal_maps(build: Callable[[int], Scene], seed: int, matrix: Matrix, sense: int) -> None:
    """Verdicts and the certified disc stay; rotation rates keep or change their sign; V* moves with its point."""
    scene = build(seed)
    before, after = check_unchanged(scene), check_cells(moved(scene, matrix))
    assert verdicts(after) == verdicts(before)
    expected = drift(before) if sense > 0 else tuple(-w for w in drift(before))[::-1]
    assert drift(after) == expected
    assert after.translation.region_radius == before.translation.region_radius
    for point in points_of_the_disc(scene, seed):
        there = image(matrix, point)
        assert upper_derivative_at(after.partition, there) == upper_derivative_at(before.partition, point)


def points_of_the_disc(scene: Scene, seed: int) -> list[Vector]:
    """Points that stay in the square under every rotation."""
    radius = scene.check.radius
    pairs = np.random.default_rng(seed).integers(-70, 71, (4, 2)).tolist()
    return [(radius * Fraction(x, 100), radius * Fraction(y, 100)) for x, y in [*pairs, (0, 70), (50, 50)]]


@pytest.mark.parametrize("matrix", [SWAP, QUARTER], ids=["swap", "quarter"])
@pytest.mark.parametrize("seed", SEEDS)
def test_maps_of_the_square_onto_itself_keep_the_worst_rate_and_the_cells(
    build: Callable[[int], Scene], seed: int, matrix: Matrix
) -> None:
    scene = build(seed)
    before, after = check_unchanged(scene), check_cells(moved(scene, matrix))
    assert after.translation.worst_rate == before.translation.worst_rate
    assert after.census == before.census
    cells = {(c.wheels, frozenset(image(matrix, v) for v in c.polygon.vertices)) for c in before.partition.cells}
    assert cells == {(c.wheels, frozenset(c.polygon.vertices)) for c in after.partition.cells}


# ---- units ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "factor", [Fraction(7, 3), Fraction(1, 10**400), Fraction(10**350)], ids=["7/3", "tiny", "huge"]
)
@pytest.mark.parametrize("seed", SEEDS)
def test_lengths(build: Callable[[int], Scene], seed: int, factor: Fraction) -> None:
    """Lengths times s: velocities stay, rotation rates are divided by s, the region grows with s."""
    scene = build(seed)
    wider = mapped(scene, lambda w: replace(w, position=(w.position[0] * factor, w.position[1] * factor)))
    wider = replace(wider, check=replace(wider.check, radius=wider.check.radius * factor))
    before, after = check_unchanged(scene), check_cells(wider)
    assert verdicts(after) == verdicts(before)
    assert after.census == before.census
    assert after.translation.worst_rate == before.translation.worst_rate
    assert drift(after) == tuple(w / factor for w in drift(before))
    radius = before.translation.region_radius
    assert after.translation.region_radius == (None if radius is None else radius * factor)


@pytest.mark.parametrize("seed", SEEDS)
def test_speeds(build: Callable[[int], Scene], seed: int) -> None:
    """Speeds times k: every twist is k times as fast; verdicts and region stay."""
    scene, factor = build(seed), Fraction(11, 4)
    faster = mapped(scene, lambda w: replace(w, given_speed=w.speed * factor))
    before, after = check_unchanged(scene), check_cells(faster)
    assert verdicts(after) == verdicts(before)
    assert after.census == before.census
    faster_rate, rate = after.translation.worst_rate, before.translation.worst_rate
    assert isinstance(faster_rate, Number)
    assert isinstance(rate, Number)
    assert faster_rate == rate * factor
    assert after.translation.region_radius == before.translation.region_radius
    assert drift(after) == tuple(w * factor for w in drift(before))


@pytest.mark.parametrize("seed", SEEDS)
def test_time_reversal_swaps_the_ends_of_the_drift(build: Callable[[int], Scene], seed: int) -> None:
    """Speeds times -1: every twist changes its sign, so does the drift; feedback does not see the given speeds."""
    scene = build(seed)
    before = check_unchanged(scene)
    after = check_cells(mapped(scene, lambda w: replace(w, given_speed=-w.speed)))
    assert drift(after) == tuple(-w for w in drift(before))[::-1]
    assert after.equilibrium.verdict is before.equilibrium.verdict
    assert after.feedback.verdict is before.feedback.verdict


@pytest.mark.parametrize("seed", SEEDS)
def test_frictions(build: Callable[[int], Scene], seed: int) -> None:
    """Only the order of mu_R and mu_S matters under rule nearest, not their size."""
    scene = build(seed)
    factor = Fraction(1, 50)
    weaker = mapped(scene, lambda w: replace(w, friction=Friction(w.friction.roll * factor, w.friction.side * factor)))
    before, after = check_unchanged(scene), check_cells(weaker)
    assert verdicts(after) == verdicts(before)
    assert [c.twists for c in after.partition.cells] == [c.twists for c in before.partition.cells]


@pytest.mark.parametrize("seed", SEEDS)
def test_reversed_rims_with_reversed_speeds_are_the_same_wheels(build: Callable[[int], Scene], seed: int) -> None:
    scene = build(seed)

    def reversed_rim(wheel: Wheel) -> Wheel:
        x, y = wheel.direction
        return replace(wheel, direction=(-x, -y), given_speed=-wheel.speed)

    before, after = check_unchanged(scene), check_cells(mapped(scene, reversed_rim))
    assert verdicts(after) == verdicts(before)
    assert drift(after) == drift(before)
    assert [c.twists for c in after.partition.cells] == [c.twists for c in before.partition.cells]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_length_of_a_rim_direction_does_not_matter(build: Callable[[int], Scene], seed: int) -> None:
    """With a given speed only the direction counts."""
    scene = mapped(build(seed), lambda w: replace(w, given_speed=w.speed))
    longer = mapped(scene, lambda w: replace(w, direction=(w.direction[0] * w.index, w.direction[1] * w.index)))
    before, after = check_unchanged(scene), check_cells(longer)
    assert verdicts(after) == verdicts(before)
    assert drift(after) == drift(before)
    assert [c.twists for c in after.partition.cells] == [c.twists for c in before.partition.cells]


# ---- numbering -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_numbering(build: Callable[[int], Scene], seed: int) -> None:
    scene = build(seed)
    order = np.random.default_rng(seed).permutation(len(scene.wheels)).tolist()
    shuffled = replace(scene, wheels=tuple(replace(scene.wheels[k], index=i) for i, k in enumerate(order, 1)))
    before, after = check_unchanged(scene), check_cells(shuffled)
    assert verdicts(after) == verdicts(before)
    assert after.census == before.census
    assert drift(after) == drift(before)
    assert after.translation.worst_rate == before.translation.worst_rate
    assert after.translation.region_radius == before.translation.region_radius
    assert after.partition.area_error == before.partition.area_error == 0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wheel_too_far_away_to_matter(build: Callable[[int], Scene], seed: int) -> None:
    """Under rule nearest a wheel that is nowhere among the two nearest changes nothing but the count of triples."""
    scene = build(seed)
    reach = max(abs(x) for w in scene.wheels for x in w.position) + scene.check.radius
    first = scene.wheels[0]
    far = replace(first, index=len(scene.wheels) + 1, position=(reach * 7, reach * -5))
    before, after = check_unchanged(scene), check_cells(replace(scene, wheels=(*scene.wheels, far)))
    assert verdicts(after) == verdicts(before)
    assert drift(after) == drift(before)
    assert after.translation.worst_rate == before.translation.worst_rate
    assert after.translation.region_radius == before.translation.region_radius
    assert [c.twists for c in after.partition.cells] == [c.twists for c in before.partition.cells]
    assert after.census.possible > before.census.possible


@pytest.mark.parametrize("seed", SEEDS)
def test_translation_of_the_array_with_its_equilibrium(build: Callable[[int], Scene], seed: int) -> None:
    scene = build(seed)
    x, y = scene.field(Fraction(41, 3)), scene.field(Fraction(-5, 7))
    shifted = mapped(scene, lambda w: replace(w, position=(w.position[0] + x, w.position[1] + y)))
    shifted = replace(shifted, check=replace(shifted.check, equilibrium=(x, y)))
    before, after = check_unchanged(scene), check_cells(shifted)
    assert verdicts(after) == verdicts(before)
    assert after.census == before.census
    assert drift(after) == drift(before)
    assert after.translation == before.translation


def test_a_table_of_loads_moves_with_the_array(arrays: Arrays) -> None:
    """``N_i`` at one place of the world is the same number before and after recentring."""
    scene = arrays.random(3, 4)
    x, y = scene.check.equilibrium
    rows = tuple((scene.field(k), scene.field(k + 1), scene.field(-k)) for k in range(1, 5))
    loaded = replace(scene, contact=replace(scene.contact, loads=LoadTable(rows)))
    moved_table = loaded.recentred().contact.loads
    assert any((x, y))
    assert isinstance(moved_table, LoadTable)
    point = (scene.field(Fraction(3, 7)), scene.field(-2))
    for (a, b, c), (d, e, f) in zip(rows, moved_table.rows, strict=True):
        assert a + b * point[0] + c * point[1] == d + e * (point[0] - x) + f * (point[1] - y)


# ---- Stress tests of whole scenes, and that they fail where a method is careless -----------------

LEAST_ROWS = 30


def failed(rows: Iterator[ResultRow]) -> list[ResultRow]:
    return [row for row in rows if not row.ok]


# ---- whole scenes --------------------------------------------------------------------------------


@thorough  # the small ones: test_a_plain_system_holds, test_other_arrays_hold
@pytest.mark.parametrize("name", ["line-of-equilibria", "ring-3", "relay-oscillator-damped"])
def test_a_built_in_scene_holds(name: str) -> None:
    assert_all_hold(load_any(name))


@pytest.mark.parametrize("every", keep(1, [3, 1]))
def test_a_plain_system_holds(load: Load, monkeypatch: pytest.MonkeyPatch, every: int) -> None:
    """Bodies do not cross its line, so that no path is long."""
    monkeypatch.setattr(measurements, "POWERS", POWERS[::every])
    assert_all_hold(load("-x - Abs(x)/2", "-y"))


def assert_all_hold(scene: Scene | SwitchedSystem) -> None:
    rows = measure(scene, CASES).rows
    assert len(rows) >= LEAST_ROWS
    assert [row for row in rows if not row.ok] == []
    for row in rows:
        assert row.note
        assert row.outcome
        assert row.error is None or math.isfinite(row.error)


@pytest.mark.parametrize("every", keep(1, [3, 1]))
def test_other_arrays_hold(arrays: Arrays, monkeypatch: pytest.MonkeyPatch, every: int) -> None:
    """An array at random, whose checked point is no equilibrium; and one refused by rule box."""
    monkeypatch.setattr(measurements, "RATIOS", dict(list(RATIOS.items())[::every]))
    monkeypatch.setattr(measurements, "POWERS", POWERS[::every])
    monkeypatch.setattr(measurements, "DETERMINANTS", DETERMINANTS[::every])
    rows = measure(arrays.random(4, 4), CASES).rows
    assert len(rows) >= LEAST_ROWS
    assert [row for row in rows if not row.ok] == []


@pytest.mark.parametrize("every", keep(1, [6, 1]))
def test_rates_whose_roots_are_out_of_reach_are_compared(monkeypatch: pytest.MonkeyPatch, every: int) -> None:
    monkeypatch.setattr(measurements, "RATIOS", {})
    monkeypatch.setattr(measurements, "POWERS", POWERS[::every])
    monkeypatch.setattr(measurements, "OFFSETS", OFFSETS[::every])
    monkeypatch.setattr(measurements, "DETERMINANTS", ())
    monkeypatch.setattr(enclosures, "MOST_BITS", 0)
    scene = load_scene("off-center", rule="box")
    assert isinstance(check_cells(scene).translation.worst_rate, arb)
    rows = list(ARRAY_VERDICTS.rows(scene))
    assert [(row.ok, row.error) for row in rows] == [(True, 0.0)] * len(rows)
    assert rows


def test_rates_that_differ_a_little_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    def a_little_faster(scene: Scene, factor: Fraction) -> Scene:
        return with_wheels(scaled(scene, factor), lambda wheel: replace(wheel, given_speed=wheel.speed * (1 + TINY)))

    monkeypatch.setattr(measurements, "scaled", a_little_faster)
    monkeypatch.setattr(measurements, "RATIOS", {})
    row = next(ARRAY_VERDICTS.rows(load_scene("off-center", rule="box")))
    assert not row.ok
    assert row.error == pytest.approx(float(TINY), rel=1e-3)


def test_rules_without_cells_are_refused_where_cells_are_needed() -> None:
    scene = load_scene("ring-3", rule="ellipse")
    for case, name in ((SCALES, "paths"), (FEEDBACK, "feedback gain")):
        (row,) = case.rows(scene)
        assert (row.name, row.outcome, row.ok) == (name, Outcome.REFUSED, True)
        assert "for cells, received" in row.note
    assert measure(scene, (STARTS, SWITCHES)).rows == []


@pytest.mark.parametrize("gains", keep(1, [[1.0, 1e6], list(cases.GAINS)]))
def test_loops_about_a_point_away_from_the_origin_hold(
    arrays: Arrays, monkeypatch: pytest.MonkeyPatch, gains: list[float]
) -> None:
    monkeypatch.setattr(cases, "GAINS", gains)
    scene = arrays.scene(arrays.inward(CORNERS), at=(Fraction(1, 4), Fraction(1, 8)))
    rows = list(FEEDBACK.rows(scene))
    assert failed(iter(rows)) == []
    assert "1e6" in {row.parameter for row in rows if IMPLICIT in row.outcome}


@thorough  # the small one: test_loops_about_a_point_away_from_the_origin_hold
def test_stiff_loops_say_that_they_are() -> None:
    rows = list(feedback_rows(build_nearest_partition(load_scene("grid-4x4"))))
    assert failed(iter(rows)) == []
    stiff = {row.parameter for row in rows if IMPLICIT in row.outcome}
    assert {"1e6", "1e8"} <= stiff
    assert not stiff & {"1e-6", "1e-3", "1e0"}


# ---- the check can fail --------------------------------------------------------------------------


def test_a_number_that_is_none_is_not_ok() -> None:
    assert not judged("case", "1", "verdict", math.nan, 1.0, why="").ok
    assert not judged("case", "1", "verdict", math.inf, math.inf, why="").ok


def test_a_case_that_raises_is_a_row_that_is_not_ok() -> None:
    def case(scene: object) -> Rows:
        yield judged("case", "1", "verdict", 0.0, 1.0, why="")
        raise ZeroDivisionError("of a careless method")

    first, last = Case("family", array=case).rows(load_scene("four-wheel"))
    assert first.ok
    assert (last.outcome, last.ok, last.note) == ("fault", False, "ZeroDivisionError: of a careless method")


def test_float_elimination_fails_for_wheels_in_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def careless(rows: Sequence[Row]) -> ContactState:
        matrix = np.array([[float(a) for a in row.normal] for row in rows])
        twist = np.linalg.solve(matrix, [float(row.rhs) for row in rows])
        field = rows[0].rhs.field
        return ContactState(tuple(rows), Twist(*(field(Fraction(float(x))) for x in twist)))

    scene = load_scene("ring-5")
    assert failed(collinear_rows(scene)) == []
    monkeypatch.setattr(cases, "solve_rows", careless)
    assert [row.parameter for row in failed(collinear_rows(scene))] == ["1e-3", "1e-6", "1e-9", "1e-12", "1e-14"]


def test_measured_angles_are_stressed_at_the_directions_that_stand_for_them(tmp_path: Path) -> None:
    """Elimination at 60 digits of those close by too would know their twists to no more than a few."""
    file = tmp_path / "table.toml"
    file.write_text(MeasuredTable.random(3, "nearest").toml, encoding="utf-8")
    scene = load_scene(file)
    assert len(list(collinear_rows(scene))) == 5
    assert failed(collinear_rows(scene)) == []


def test_loads_by_plain_normal_equations_fail_in_other_units(monkeypatch: pytest.MonkeyPatch) -> None:
    def careless(model: ContactModel, points: Any) -> Floats:
        moments = np.column_stack([np.ones(model.wheels), model.positions])
        goal = np.array([1.0, *np.atleast_2d(points)[0]])
        return np.maximum(moments @ np.linalg.lstsq(moments.T @ moments, goal, rcond=None)[0], 0.0)[None]

    scene = load_scene("four-wheel")
    assert failed(support_rows(scene)) == failed(load_scale_rows(scene)) == []
    monkeypatch.setattr(cases, "elastic_loads", careless)
    assert {"1e-9", "1e9"} <= {row.parameter for row in failed(load_scale_rows(scene))}
    assert "1e-3 outside" in {row.parameter for row in failed(support_rows(scene))}


def test_a_tolerance_in_signs_fails_at_small_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    def careless(number: Number) -> int:
        value = float(number)
        return 0 if abs(value) < 1e-9 else (value > 0) - (value < 0)

    monkeypatch.setattr(Number, "sign", careless)
    assert not all(row.ok for row in ARRAY_VERDICTS.rows(load_scene("four-wheel")))


def test_paths_in_single_precision_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, state = load_scene("four-wheel"), Free.state

    def careless(motion: Free, time: Any) -> tuple[Any, Any, Any]:
        x, y, theta = state(motion, time)
        return (x, y, theta) if not isinstance(x, float) else (float(np.float32(x)), float(np.float32(y)), theta)

    assert failed(array_scale_rows(scene)) == []
    monkeypatch.setattr(Free, "state", careless)
    bad = failed(SCALES.rows(scene))
    assert bad != []
    assert {row.name for row in bad} <= {"geometry scale, path", "far from the origin, path", "scales"}


def test_events_located_to_an_absolute_time_fail_in_fast_systems(monkeypatch: pytest.MonkeyPatch) -> None:
    located: Callable[..., float] = engine.find_root

    def careless(*arguments: Any) -> float:
        return round(located(*arguments), 12)

    scene = load_system("relay-oscillator")
    assert failed(system_scale_rows(scene)) == []
    monkeypatch.setattr(engine, "find_root", careless)
    assert [(row.name, row.parameter) for row in failed(system_scale_rows(scene))][-1] == ("time scale, path", "1e9")
