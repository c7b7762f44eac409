"""Ten thousand wheels from a CSV table against sixteen: the check looks at those that can matter."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.proofs.theorem4 import CellCheck, check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch

ALLOWED_RATIO = 4
SIDE = 100

SCENE = """
name = "grid-100x100"
[friction]
mu_roll = 1
mu_side = "1/2"
[wheels]
file = "wheels.csv"
[field]
kind = "radial"
[contact]
rule = "nearest"
[check]
equilibrium = [0, 0]
radius = "1/2"
"""


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """grid-4x4 continued to 100 x 100 wheels: the same pitch, rims, friction and square."""
    places = [k - (SIDE - 1) / 2 for k in range(SIDE)]
    lines = ["x,y,heading,speed", *(f"{x},{y},," for y in places for x in places)]
    (tmp_path / "wheels.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    path = tmp_path / "grid.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def without_census(result: CellCheck) -> float:
    """Seconds in the partition and the clauses; the census of row triples is taken when it is asked for."""
    return sum(result.seconds.values())


def test_ten_thousand_wheels(large: Path, stopwatch: Stopwatch) -> None:
    """(read + check of 10,000 wheels) <= 4 (read + check of 16 wheels) + (read of 10,000 wheels)."""
    reading = stopwatch.best(lambda: load_scene(large))
    many = stopwatch.best(lambda: check_cells(load_scene(large)).census)
    few = stopwatch.best(lambda: check_cells(load_scene("grid-4x4")).census, runs=10)
    results = [[check_cells(load_scene(source)) for _ in range(5)] for source in (large, "grid-4x4")]
    core_many, core_few = (min(map(without_census, runs)) for runs in results)
    stopwatch.report(
        f"10,000 wheels: read {reading * 1e3:.0f} ms, read and check {many * 1e3:.0f} ms; "
        f"16 wheels: {few * 1e3:.0f} ms; (check - read)/(16 wheels) = {(many - reading) / few:.2f} "
        f"(allowed {ALLOWED_RATIO}); without the census of triples {core_many * 1e3:.1f} ms and {core_few * 1e3:.1f} ms"
    )
    assert results[0][0].verdict is results[1][0].verdict
    assert [len(runs[0].partition.cells) for runs in results] == [8, 8]
    assert many <= ALLOWED_RATIO * few + reading
