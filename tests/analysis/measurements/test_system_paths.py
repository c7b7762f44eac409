"""The study of paths of plain systems: orders that theory predicts, references against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from nonsmooth.analysis.measurements.harness import Limits, StudyPlan, fitted_slopes, measure
from nonsmooth.analysis.measurements.path_studies import SYSTEM_PATHS, Followed, build_system_paths
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.plain import built

QUICK = Limits(runs=1, seconds=2.0)


def measured(scene: SwitchedSystem, *methods: str) -> Any:
    """What the study measures, of some of its methods."""

    def plan(scene: SwitchedSystem) -> StudyPlan:
        whole = build_system_paths(scene)
        return replace(whole, trials=tuple(trial for trial in whole.trials if trial.method in methods))

    (found,) = measure(scene, (replace(SYSTEM_PATHS, build=plan),), QUICK).measured
    return found


def test_hysteresis_is_of_first_order_and_events_are_of_rounding() -> None:
    found = measured(load_system("relay-oscillator"), "hysteresis", "DOP853 with events")
    slopes = {slope.method: slope for slope in fitted_slopes(found.plan, found.rows)}
    assert slopes["hysteresis"].value == pytest.approx(1.0, abs=0.1)
    assert max(row.error for row in found.rows if row.method == "DOP853 with events") < 1e-12


def test_errors_fall_with_the_tolerance_of_a_field_that_is_not_constant() -> None:
    found = measured(built(["y", "-x - sgn(x) - y/4"]), "DOP853 with events")
    errors = [row.error for row in found.rows if row.method == "DOP853 with events"]
    assert errors[-1] < 1e-9
    assert errors[-1] < 1e-3 * errors[0]


def test_the_reference_is_a_closed_form() -> None:
    """``x' = -x`` and ``y' = -y`` shrink by one factor."""
    plan = build_system_paths(built(["-x", "-y"]))
    judge = plan.trials[0].judge
    time = 4 * 0.5 / 0.5
    exact = [(a / 32 * math.exp(-time), b / 32 * math.exp(-time)) for a, b in ((15, 10), (11, -3), (-5, 11), (-8, -13))]
    assert judge([Followed([time], [state], 1) for state in exact]).error < 1e-15
