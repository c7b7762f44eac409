"""Studies of errors: outcomes on trials whose results are known, plans, and the orders that theory predicts."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_study import MASS, MASSES, mass_study
from nonsmooth.analysis.bodies.newton_euler import disc
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.harness import (
    FEWEST,
    REPEATED,
    Assessment,
    Clock,
    LeftOut,
    Limits,
    Order,
    Outcome,
    ResultRow,
    Study,
    StudyPlan,
    Trial,
    TrialTimeout,
    fitted_slopes,
    log_slope,
    measure,
)
from nonsmooth.analysis.measurements.path_studies import (
    SYSTEM_PATHS,
    TRAJECTORIES,
    MethodPath,
    build_system_paths,
    follow_without_events,
)
from nonsmooth.analysis.measurements.reference_paths import ExactPath
from nonsmooth.analysis.measurements.studies import DERIVATION, UPPER_DERIVATIVE, codimension_of_largest
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.conftest import Arrays
from tests.plain import built
from tests.thorough import few, keep, thorough

# ---- Measuring: outcomes, limits and slopes, on trials whose results are known -------------------

LIMITS = Limits(runs=3, seconds=0.2)
PAUSE = 0.01  # seconds of work


def judged(result: Any) -> Assessment:
    return Assessment(float(result))


def trial(method: str, work: Callable[[Clock], Any], setting: float | None = None, repeats: int = 1) -> Trial:
    return Trial(method, work, judged, None if setting is None else "width", setting, repeats)


def measured(*trials: Trial, limits: Limits = LIMITS) -> list[ResultRow]:
    plan = StudyPlan("what is known", trials)
    study = Study("test", "a test", "error [1]", lambda scene: plan)
    return measure(load_scene("four-wheel"), [study], limits).rows


def endless(clock: Clock) -> float:
    while True:
        clock.check()


def spend(seconds: float) -> float:
    """Keep the processor busy."""
    start = time.process_time()
    while time.process_time() < start + seconds:
        pass
    return 0.0


def test_a_row_holds_error_time_and_reference() -> None:
    def work(clock: Clock) -> float:
        spend(PAUSE)
        return 0.25

    (row,) = measured(trial("busy", work, 1e-3, repeats=2))
    assert (row.name, row.method, row.parameter, row.setting) == ("test", "busy", "width", 1e-3)
    assert (row.error, row.reference, row.outcome) == (0.25, "what is known", Outcome.DONE)
    assert row.seconds is not None
    assert row.seconds >= PAUSE / 2


def test_the_shortest_run_counts() -> None:
    pauses = [5 * PAUSE, PAUSE, 3 * PAUSE]
    waiting = iter(pauses)

    def work(clock: Clock) -> float:
        spend(next(waiting))
        return 0.0

    (row,) = measured(trial("busy", work), limits=Limits(3, 60))
    assert next(waiting, None) is None
    assert row.seconds is not None
    assert PAUSE <= row.seconds < max(pauses)


def test_waiting_costs_no_processor_time() -> None:
    def work(clock: Clock) -> float:
        time.sleep(5 * PAUSE)
        return 0.0

    (row,) = measured(trial("idle", work), limits=Limits(1, 4 * PAUSE))
    assert row.outcome is Outcome.DONE


def test_long_runs_are_not_repeated() -> None:
    runs: list[None] = []

    def work(clock: Clock) -> float:
        runs.append(None)
        spend(REPEATED * LIMITS.seconds)
        return 0.0

    (row,) = measured(trial("busy", work))
    assert row.outcome is Outcome.DONE
    assert len(runs) == 1


def test_harder_settings_are_not_tried_after_a_time_out() -> None:
    runs: list[float] = []

    def work(setting: float) -> Callable[[Clock], float]:
        def counted(clock: Clock) -> float:
            runs.append(setting)
            return endless(clock) if setting < 1 else 0.0

        return counted

    rows = measured(*(trial("slow", work(s), s) for s in (1.0, 0.1, 0.01)), trial("other", lambda clock: 1.0))
    assert [row.outcome for row in rows] == [Outcome.DONE, Outcome.TIME_OUT, Outcome.TIME_OUT, Outcome.DONE]
    assert runs == [1.0] * 3 + [0.1]
    assert rows[1].error is rows[1].seconds is None
    assert rows[1].note == "not done within 0.2 s"
    assert rows[2].note == "not tried after a time-out"


def test_a_result_that_comes_too_late_does_not_count() -> None:
    (row,) = measured(trial("busy", lambda clock: spend(2 * PAUSE)), limits=Limits(1, PAUSE))
    assert row.outcome is Outcome.TIME_OUT


def test_methods_that_give_up_say_why_in_one_short_line() -> None:
    def gives_up(clock: Clock) -> float:
        raise RuntimeError("no convergence. A long story follows\nand another line")

    (row,) = measured(trial("solver", gives_up))
    assert (row.outcome, row.note, row.error) == (Outcome.FAILED, "no convergence", None)


def test_faults_of_the_program_are_not_outcomes() -> None:
    with pytest.raises(TypeError):
        measured(trial("wrong", len))  # type: ignore[arg-type]


def test_a_clock_raises_after_its_limit_only() -> None:
    Clock(60).check()
    late = Clock(0)
    spend(PAUSE)
    with pytest.raises(TrialTimeout):
        late.check()


@pytest.mark.parametrize("slope", [-1, -0.5, 0.5, 1, 2])
def test_slopes_of_powers(slope: float) -> None:
    settings = [0.1, 0.02, 0.003, 4e-4]
    assert log_slope(settings, [3 * s**slope for s in settings]) == pytest.approx(slope, abs=1e-12)


def test_a_slope_needs_two_settings() -> None:
    with pytest.raises(ValueError, match="constant"):
        log_slope([0.1, 0.1], [1, 2])


def test_errors_at_rounding_level_are_left_out_of_a_slope() -> None:
    order = Order(1.0, "a test")
    settings = [10.0**-k for k in range(1, 9)]
    errors = [max(s**2, 3e-15) for s in settings]
    rows = [
        ResultRow("test", "width", method="square", setting=s, error=e) for s, e in zip(settings, errors, strict=True)
    ]
    plan = StudyPlan("known", (), {"square": order})
    (slope,) = fitted_slopes(plan, rows)
    assert slope.value == pytest.approx(2, abs=1e-12)
    assert (slope.first, slope.last, slope.parameter) == (0.1, 1e-6, "width")
    (unknown,) = fitted_slopes(plan, rows[: FEWEST - 1])
    assert unknown.value is None


# ---- The slopes that theory predicts, seen in errors against exact answers; no time is measured here.
#
# Fits are least squares in log-log over the settings stated; the allowance covers that a switch falls anywhere within
# a step, and that random samples are random (their seeds are fixed).

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


# ---- The study of masses for ``precision``: its distances are those of the mass study, in every scene's own units.

SCALED = 1e-6  # relative: integrators take other steps in other units


def errors(plan: StudyPlan, method: str, own: slice = slice(None)) -> list[float]:
    """Those of the trials of a method, or of some of them."""
    trials = [trial for trial in plan.trials if trial.method == method]
    return [trial.judge(trial.work(Clock(60.0))).error for trial in trials[own]]


@thorough
def test_the_distance_falls_like_the_mass(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    plan = MASS.build(scene)
    found = errors(plan, "full dynamics")
    assert log_slope(MASSES[1:], found[1:]) == pytest.approx(1, abs=WITHIN)
    study = mass_study(scene, [disc(contact_model(scene), MASSES[2] / 2)], (0.2, 0.4, 0), 2.0)
    assert found[2] == pytest.approx(study.rows[0].distance("ellipse").position, rel=SCALED)
    assert study.limits is not None
    limits = {limit.rule: limit.position for limit in study.limits}
    for rule in ("nearest", "box"):
        assert errors(plan, f"rule {rule}") == pytest.approx([limits[rule]], rel=SCALED)


@thorough
def test_units_do_not_matter(arrays: Arrays) -> None:
    """Lengths times 8 and speeds times 4: the same paths, 8 times as large."""
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    wheels = tuple(
        replace(w, position=(w.position[0] * 8, w.position[1] * 8), given_speed=w.speed * 4) for w in scene.wheels
    )
    wider = replace(scene, wheels=wheels, check=replace(scene.check, radius=scene.check.radius * 8))
    small, large = (errors(MASS.build(s), "full dynamics", slice(1, 2)) for s in (scene, wider))
    assert large == pytest.approx([8 * error for error in small], rel=1e-4)  # default tolerances are absolute in part


def test_an_array_at_rest_is_left_out(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    still = replace(scene, wheels=tuple(replace(w, given_speed=scene.field.zero) for w in scene.wheels))
    with pytest.raises(LeftOut, match="no wheel is driven"):
        MASS.build(still)


# ---- The study of paths of plain systems: orders that theory predicts, references against closed forms.

QUICK = Limits(runs=1, seconds=2.0)


def measured_paths(scene: SwitchedSystem, *methods: str) -> Any:
    """What the study measures, of some of its methods."""

    def plan(scene: SwitchedSystem) -> StudyPlan:
        whole = build_system_paths(scene)
        return replace(whole, trials=tuple(trial for trial in whole.trials if trial.method in methods))

    (found,) = measure(scene, (replace(SYSTEM_PATHS, build=plan),), QUICK).measured
    return found


def test_hysteresis_is_of_first_order_and_events_are_of_rounding() -> None:
    found = measured_paths(load_system("relay-oscillator"), "hysteresis", "DOP853 with events")
    slopes = {slope.method: slope for slope in fitted_slopes(found.plan, found.rows)}
    assert slopes["hysteresis"].value == pytest.approx(1.0, abs=0.1)
    assert max(row.error for row in found.rows if row.method == "DOP853 with events") < 1e-12


def test_errors_fall_with_the_tolerance_of_a_field_that_is_not_constant() -> None:
    found = measured_paths(built(["y", "-x - sgn(x) - y/4"]), "DOP853 with events")
    errors = [row.error for row in found.rows if row.method == "DOP853 with events"]
    assert errors[-1] < 1e-9
    assert errors[-1] < 1e-3 * errors[0]


def test_the_reference_is_a_closed_form() -> None:
    """``x' = -x`` and ``y' = -y`` shrink by one factor."""
    plan = build_system_paths(built(["-x", "-y"]))
    judge = plan.trials[0].judge
    time = 4 * 0.5 / 0.5
    exact = [(a / 32 * math.exp(-time), b / 32 * math.exp(-time)) for a, b in ((15, 10), (11, -3), (-5, 11), (-8, -13))]
    assert judge([MethodPath([time], [state], 1) for state in exact]).error < 1e-15
