"""Arrays of hundreds to a hundred thousand wheels: what they take, beside small ones."""

from __future__ import annotations

import random
import resource
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.theorem4 import CellCheck, Check, check_cells, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch

# ---- A CSV table of a hundred thousand wheels, with headings and speeds of their own: read, checked, verified.

WHEELS, ROW = 100_000, 317
TO_READING = 3.5  # of the whole check to reading the table alone


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """A grid with a pitch of a tenth whose wheels are displaced at random, in millimetres."""
    rng = random.Random(1)
    lines = ["x,y,heading,speed,mu_roll,mu_side"]
    for k in range(WHEELS):
        x, y = ((part * 100 + rng.randint(0, 50)) / 1000 for part in (k % ROW, k // ROW))
        a, b, speed = (rng.randint(1, 99) / 100 for _ in range(3))
        lines.append(f'{x:.3f},{y:.3f},"[{a}, {b}]",{speed},0.8,0.4')
    (tmp_path / "wheels.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    path = tmp_path / "table.toml"
    path.write_text('[wheels]\nfile = "wheels.csv"\n[check]\nequilibrium = [15.85, 15.85]\nradius = "1/10"\n')
    return path


def spent(*arguments: str) -> float:
    """Seconds of processor time of a process of its own, which may end with any verdict."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False, timeout=600)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1, 3), done.stderr
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_a_hundred_thousand_wheels(table: Path, stopwatch: Stopwatch) -> None:
    read = spent("-c", f"from nonsmooth.symbolic.files.scene_file import load_scene; load_scene({str(table)!r})")
    checked = spent("-m", "nonsmooth.reports.cli", "check", str(table), "--json")
    stopwatch.report(
        f"{WHEELS} wheels read in {read:.1f} s of processor time, read, checked and verified in {checked:.1f} s, "
        f"ratio {checked / read:.2f} (allowed {TO_READING})"
    )
    assert checked <= TO_READING * read


# ---- Ten thousand wheels from a CSV table against sixteen: the check looks at those that can matter.

TO_SIXTEEN = 4
SIDE = 100

OF_TABLE = """
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
    path.write_text(OF_TABLE, encoding="utf-8")
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
        f"(allowed {TO_SIXTEEN}); without the census of triples {core_many * 1e3:.1f} ms and {core_few * 1e3:.1f} ms"
    )
    assert results[0][0].verdict is results[1][0].verdict
    assert [len(runs[0].partition.cells) for runs in results] == [8, 8]
    assert many <= TO_SIXTEEN * few + reading


# ---- A grid of 14 x 14 wheels against one of 7 x 8 under the rules that minimize D: three and a half times the
# wheels.

TO_SMALL = 25  # twice the square of the ratio of wheels: tables of pairs are what grows
OF_GRID = """
name = "grid"
[friction]
mu_roll = 1
mu_side = "1/2"
[grid]
rows = {rows}
columns = {columns}
[check]
radius = "1/2"
"""


def grid(folder: Path, rows: int, columns: int) -> Path:
    path = folder / f"grid-{rows}.toml"
    path.write_text(OF_GRID.format(rows=rows, columns=columns), encoding="utf-8")
    return path


def check_afresh(source: Path, rule: str) -> Check:
    """Read and check, in a number field of its own."""
    return check_theorem4(load_scene(source, rule=rule))


@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_two_hundred_wheels(rule: str, tmp_path: Path, stopwatch: Stopwatch) -> None:
    """check of 14 x 14 wheels <= 25 check of 7 x 8 wheels, and every clause decided in both."""
    sources = [grid(tmp_path, 14, 14), grid(tmp_path, 7, 8)]
    results = [check_afresh(source, rule) for source in sources]
    work = [partial(check_afresh, source, rule) for source in sources]
    large, small = (stopwatch.best(check, runs=2) for check in work)
    stopwatch.report(
        f"rule {rule}: 196 wheels {large:.1f} s, 56 wheels {small:.1f} s, ratio {large / small:.1f} "
        f"(allowed {TO_SMALL})"
    )
    assert all(result.feedback.verdict is Feedback.STABILIZABLE for result in results)
    assert all(result.check() for result in results)
    assert large <= TO_SMALL * small
