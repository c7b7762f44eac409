"""Measuring: outcomes, limits and slopes, on trials whose results are known."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest

from nonsmooth.analysis.measurements.harness import (
    FEWEST,
    REPEATED,
    Assessment,
    Clock,
    Limits,
    Order,
    Outcome,
    OutOfTime,
    ResultRow,
    Study,
    StudyPlan,
    Trial,
    fitted_slopes,
    log_slope,
    measure,
)
from nonsmooth.symbolic.files.scene_file import load_scene

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
    with pytest.raises(OutOfTime):
        late.check()


@pytest.mark.parametrize("slope", [-1, -0.5, 0.5, 1, 2])
def test_slopes_of_powers(slope: float) -> None:
    settings = [0.1, 0.02, 0.003, 4e-4]
    assert log_slope(settings, [3 * s**slope for s in settings]) == pytest.approx(slope, abs=1e-12)


def test_a_slope_needs_two_settings() -> None:
    with pytest.raises(ValueError, match="two different settings"):
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
