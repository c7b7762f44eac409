"""The command ``precision`` as a whole: how long it takes, what it covers, and whether repeated runs agree."""

from __future__ import annotations

import time
from itertools import combinations

import pytest

from nonsmooth.analysis.measurements.harness import Limits, Measured, Run, measure
from nonsmooth.analysis.measurements.studies import ELLIPSE_MINIMIZERS
from nonsmooth.proofs.measurements import PRUNING, STUDIES
from nonsmooth.reports.output.progress import silent
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch

ALLOWED = 300  # seconds of processor time for one array, all of it on one core
FEWEST_STUDIES, FEWEST_METHODS, FEWEST_SETTINGS = 4, 3, 5
DISTINCT = 3  # times that differ by this factor order two methods; below it lies the noise of a busy machine
WITHIN = 0.2  # of a predicted slope
SLOPES = {"hysteresis", "smoothed", "random samples", "grid of samples", "RK45", "DOP853"}


def measured(name: str, runs: int = 3) -> Run:
    return measure(load_scene(name), STUDIES, Limits(runs, 5.0), silent)


def methods_of(one: Measured) -> dict[str, int]:
    """Number of settings by method."""
    counts: dict[str, int] = {}
    for row in one.rows:
        counts[row.method] = counts.get(row.method, 0) + (row.setting is not None)
    return counts


@pytest.mark.parametrize("name", builtin_scenes())
def test_every_built_in_array(name: str, stopwatch: Stopwatch) -> None:
    start = time.process_time()
    found = measured(name)
    seconds = time.process_time() - start
    covered = [one for one in found.measured if one.plan is not None]
    left_out = ", ".join(one.of.name for one in found.measured if one.plan is None) or "nothing"
    stopwatch.report(f"{name}: {len(found.rows)} rows in {seconds:.0f} s (allowed {ALLOWED}), left out: {left_out}")
    assert seconds <= ALLOWED
    assert len(covered) >= FEWEST_STUDIES
    assert all(row.reference for row in found.rows)
    for one in covered:
        counts = methods_of(one)
        assert len(counts) >= (2 if one.of is ELLIPSE_MINIMIZERS else FEWEST_METHODS)
        assert all(count >= FEWEST_SETTINGS for count in counts.values() if count)
        if one.of is PRUNING:
            assert all(row.error == 0 for row in one.rows if row.error is not None)


def fastest(one: Measured) -> dict[str, float]:
    """The shortest time of each method that has a result."""
    times: dict[str, float] = {}
    for row in one.rows:
        if row.seconds is not None:
            times[row.method] = min(row.seconds, times.get(row.method, row.seconds))
    return times


def test_repeated_runs_order_the_methods_alike(stopwatch: Stopwatch) -> None:
    """Methods whose shortest times differ by a factor of 3 in one run are in the same order in the other."""
    first, second = measured("four-wheel"), measured("four-wheel")
    for one, two in zip(first.measured, second.measured, strict=True):
        times, again = fastest(one), fastest(two)
        pairs = [(a, b) for a, b in combinations(times, 2) if a in again and b in again]
        clear = [(a, b) for a, b in pairs if not 1 / DISTINCT < times[a] / times[b] < DISTINCT]
        stopwatch.report(f"{one.of.name}: {len(clear)} of {len(pairs)} pairs of methods are a factor 3 apart")
        assert [(a, b) for a, b in clear if (times[a] < times[b]) != (again[a] < again[b])] == []


def test_predicted_slopes_are_seen_on_four_wheels(stopwatch: Stopwatch) -> None:
    found = [slope for one in measured("four-wheel", runs=1).measured for slope in one.slopes]
    for slope in found:
        stopwatch.report(f"{slope.method}: slope {slope.value}, predicted {slope.order.expected}")
    checked = [slope for slope in found if slope.method in SLOPES]
    assert {slope.method for slope in checked} == SLOPES
    for slope in checked:
        assert slope.value is not None
        assert slope.value == pytest.approx(slope.order.expected, abs=WITHIN)
