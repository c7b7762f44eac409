"""Every built-in scene and system under stress: all rows ok, each within five minutes; random arrays as well."""

from __future__ import annotations

import time

import pytest

from nonsmooth.analysis.measurements.harness import measure
from nonsmooth.proofs.measurements import CASES
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_any, load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.benchmarks.conftest import Stopwatch
from tests.built_in import planar_systems
from tests.conftest import Arrays

LEAST_ROWS, MINUTES = 30, 5


def hold(name: str, scene: Scene | SwitchedSystem, stopwatch: Stopwatch) -> None:
    start = time.perf_counter()
    rows = measure(scene, CASES).rows
    seconds = time.perf_counter() - start
    stopwatch.report(f"{name}: {len(rows)} rows in {seconds:.1f} s")
    assert [row for row in rows if not row.ok] == []
    assert len(rows) >= LEAST_ROWS
    assert seconds <= 60 * MINUTES


@pytest.mark.parametrize("name", [*builtin_scenes(), *planar_systems()])
def test_built_in(name: str, stopwatch: Stopwatch) -> None:
    hold(name, load_any(name), stopwatch)


@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("name", ["four-wheel", "off-center"])
def test_other_rules(name: str, rule: str, stopwatch: Stopwatch) -> None:
    hold(f"{name}, rule {rule}", load_scene(name, rule=rule), stopwatch)


@pytest.mark.parametrize("seed", range(6))
def test_arrays_at_random(seed: int, arrays: Arrays, stopwatch: Stopwatch) -> None:
    hold(f"random array {seed}", arrays.random(seed, 3 + seed % 4), stopwatch)
    hold(f"cocircular array {seed}", arrays.cocircular(seed), stopwatch)
