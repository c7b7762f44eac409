"""The slopes that theory predicts, seen in errors against exact answers; no time is measured here.

Fits are least squares in log-log over the settings stated; the allowance covers that a switch falls anywhere within a
step, and that random samples are random (their seeds are fixed).
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import islice

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.harness import Clock, Study, StudyPlan, log_slope
from nonsmooth.analysis.measurements.path_studies import TRAJECTORIES, follow_without_events
from nonsmooth.analysis.measurements.reference_paths import ExactPath
from nonsmooth.analysis.measurements.studies import DERIVATION, UPPER_DERIVATIVE, codimension_of_largest
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.thorough import few, keep

WITHIN = 0.2  # of the predicted slope
SECONDS = 120  # of one setting: none comes near
FEW_SAMPLES = 100_000
ROUNDING = 1e-13
SLACK = 1.01  # of the ends of a range


def errors_of(plan: StudyPlan, method: str, easiest: float, hardest: float) -> dict[float, float]:
    """Error by setting over a closed range of settings."""
    low, high = sorted((easiest, hardest))
    found = {}
    for trial in plan.trials:
        if trial.method == method and trial.setting is not None and low / SLACK < trial.setting < high * SLACK:
            found[trial.setting] = trial.judge(trial.work(Clock(SECONDS))).error
    assert len(found) >= 4
    return found


def slope_of(study: Study, scene: Scene, method: str, easiest: float, hardest: float) -> tuple[float, float | None]:
    """The slope that is seen and the one that the study expects."""
    plan = study.build(scene)
    found = errors_of(plan, method, easiest, hardest)
    return log_slope(list(found), list(found.values())), plan.orders[method].expected


@few(1)
@pytest.mark.parametrize("name", keep(1, ["saddle", "spiral-30", "ring-5"]))
@pytest.mark.parametrize("method", ["hysteresis", "smoothed"])
def test_layers_err_by_their_width(name: str, method: str) -> None:
    seen, expected = slope_of(TRAJECTORIES, load_scene(name), method, 1, 1e-4)
    assert expected == 1
    assert seen == pytest.approx(1, abs=WITHIN)


def crossing_path(field: ConstantField, start: tuple[float, float, float]) -> ExactPath | None:
    """The exact path up to the middle of its first cell after a crossing; None where it slides or leaves first."""
    path = simulate(field, start, None)
    if len(path.pieces) < 2 or path.events[0].kind is not EventKind.CROSS:
        return None
    second = path.pieces[1]
    ends = second.start if second.end is None else second.end
    return ExactPath(start, (float(second.start) + float(ends)) / 2, path)


@few(1)
@pytest.mark.parametrize(("method", "count"), keep(1, [("RK45", 10), ("RK45", 30), ("DOP853", 30)]))
def test_a_step_across_a_switch_errs_by_the_tolerance(method: str, count: int) -> None:
    """Tolerances 1e-3 to 1e-8; mean of log(error) over some starts, since the switch falls anywhere within a step."""
    field = array_field(build_partition(load_scene("spiral-30")), Kinematics.LEADING, exact=True)
    starts = np.random.default_rng(0).uniform(-0.45, 0.45, (120, 2)).tolist()
    crossing = (path for x, y in starts if (path := crossing_path(field, (x, y, 0.0))) is not None)
    paths = list(islice(crossing, count))
    assert len(paths) == count
    tolerances = [10.0**-k for k in range(3, 9)]
    means = []
    for tolerance in tolerances:
        both, clock = (tolerance, tolerance), Clock(SECONDS)
        followed = [follow_without_events(field, method, both, p.start, p.until, clock) for p in paths]
        errors = [p.error_at(f.times[-1], f.states[-1]) for p, f in zip(paths, followed, strict=True)]
        means.append(math.exp(float(np.mean(np.log(errors)))))
    assert log_slope(tolerances, means) == pytest.approx(1, abs=WITHIN)
    assert TRAJECTORIES.build(load_scene("spiral-30")).orders[method].expected == 1


def test_events_make_the_tolerance_irrelevant() -> None:
    plan = TRAJECTORIES.build(load_scene("spiral-30"))
    assert max(errors_of(plan, "DOP853 with events", 1e-3, 1e-11).values()) < ROUNDING
    assert plan.orders["DOP853 with events"].expected is None


@pytest.mark.parametrize(("name", "codimension"), keep(2, [("four-wheel", 2), ("four-wheel-side", 1), ("ring-5", 2)]))
def test_random_samples_come_near_a_face_by_its_codimension(name: str, codimension: int) -> None:
    scene = load_scene(name)
    assert codimension_of_largest(build_partition(scene.recentred())) == codimension
    seen, expected = slope_of(UPPER_DERIVATIVE, scene, "random samples", 100, FEW_SAMPLES)
    assert expected == -1 / codimension
    assert seen == pytest.approx(expected, abs=WITHIN)


def test_a_grid_keeps_half_a_spacing_from_a_vertex() -> None:
    seen, expected = slope_of(UPPER_DERIVATIVE, load_scene("ring-5"), "grid of samples", 100, FEW_SAMPLES)
    assert expected == -1 / 2
    assert seen == pytest.approx(expected, abs=0.01)


def test_a_largest_value_on_a_whole_cell_is_found_by_all_samples() -> None:
    scene = load_scene("conveyor-3", rule="box")
    plan = UPPER_DERIVATIVE.build(scene)
    assert codimension_of_largest(build_partition(scene.recentred())) == 0
    assert plan.orders["random samples"].expected is None
    first = next(trial for trial in plan.trials if trial.method == "random samples")
    assert first.judge(first.work(Clock(SECONDS))).error < ROUNDING


def test_a_tie_hides_motions_from_samples(arrays: Arrays) -> None:
    tied = arrays.with_friction(load_scene("four-wheel"), (1, 1))
    assert UPPER_DERIVATIVE.build(tied).orders["random samples"].expected is None


def test_balls_gain_a_bit_for_every_bit() -> None:
    seen, expected = slope_of(DERIVATION, load_scene("ring-5"), "balls", 2.0**-53, 2.0**-161)
    assert expected == 1
    assert seen == pytest.approx(1, abs=WITHIN)


def test_exact_methods_have_no_error(arrays: Arrays) -> None:
    scene = replace(arrays.four_wheel((1, Fraction(1, 5))), name="four wheels")
    exact = {
        TRAJECTORIES: "events, exact numbers",
        UPPER_DERIVATIVE: "exact cells",
        DERIVATION: "number field, cofactors",
    }
    for study, method in exact.items():
        trial = next(t for t in study.build(scene).trials if t.method == method)
        assert trial.judge(trial.work(Clock(SECONDS))).error == 0
