"""A CSV table of a hundred thousand wheels, with headings and speeds of their own: read, checked, verified."""

from __future__ import annotations

import random
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from tests.benchmarks.conftest import Stopwatch

WHEELS, SIDE = 100_000, 317
ALLOWED_RATIO = 3.5  # of the whole check to reading the table alone


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A grid with a pitch of a tenth whose wheels are displaced at random, in millimetres."""
    rng = random.Random(1)
    lines = ["x,y,heading,speed,mu_roll,mu_side"]
    for k in range(WHEELS):
        x, y = ((part * 100 + rng.randint(0, 50)) / 1000 for part in (k % SIDE, k // SIDE))
        a, b, speed = (rng.randint(1, 99) / 100 for _ in range(3))
        lines.append(f'{x:.3f},{y:.3f},"[{a}, {b}]",{speed},0.8,0.4')
    (tmp_path / "wheels.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    path = tmp_path / "large.toml"
    path.write_text('[wheels]\nfile = "wheels.csv"\n[check]\nequilibrium = [15.85, 15.85]\nradius = "1/10"\n')
    return path


def spent(*arguments: str) -> float:
    """Seconds of processor time of a process of its own, which may end with any verdict."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False, timeout=600)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode in (0, 1, 3), done.stderr
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_a_hundred_thousand_wheels(large: Path, stopwatch: Stopwatch) -> None:
    read = spent("-c", f"from nonsmooth.symbolic.files.scene_file import load_scene; load_scene({str(large)!r})")
    checked = spent("-m", "nonsmooth.reports.cli", "check", str(large), "--json")
    stopwatch.report(
        f"{WHEELS} wheels read in {read:.1f} s of processor time, read, checked and verified in {checked:.1f} s, "
        f"ratio {checked / read:.2f} (allowed {ALLOWED_RATIO})"
    )
    assert checked <= ALLOWED_RATIO * read
