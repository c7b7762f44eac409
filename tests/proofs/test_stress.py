"""Stress tests of whole scenes, and that they fail where a method is careless."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
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
from nonsmooth.analysis.trajectories.cell_motion import Free
from nonsmooth.analysis.trajectories.smooth_path import IMPLICIT
from nonsmooth.proofs import measurements
from nonsmooth.proofs.measurements import ARRAY_VERDICTS, CASES
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_any, load_system
from nonsmooth.symbolic.mechanics.constraints import Row, Twist
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import scaled, with_wheels
from nonsmooth.symbolic.numbers import enclosures
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.proofs.conftest import Load
from tests.thorough import keep, thorough

LEAST_ROWS = 30


def failed(rows: Iterator[ResultRow]) -> list[ResultRow]:
    return [row for row in rows if not row.ok]


# ---- whole scenes --------------------------------------------------------------------------------


@thorough  # the small ones: test_a_plain_system_holds, test_other_arrays_hold
@pytest.mark.parametrize("name", ["line-of-equilibria", "ring-3", "relay-oscillator-damped"])
def test_a_built_in_scene_holds(name: str) -> None:
    assert_all_hold(load_any(name))


def test_a_plain_system_holds(load: Load) -> None:
    """Bodies cross its line once at most, so that no path is long."""
    assert_all_hold(load("-x", "-y - Abs(x)"))


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
