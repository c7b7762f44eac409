"""How long the HTML report of the paper's array takes from a cold start, and how large it is."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.benchmark

RUNS = 3  # the fastest counts
MOST_BYTES = 2_000_000


def seconds(target: Path, *options: str) -> float:
    """Processor time of the fastest of some runs in a process of its own: on an idle machine, what a user waits."""
    line = [sys.executable, "-m", "nonsmooth.reports.cli", "derive", "four-wheel", "-o", str(target), *options]
    times = []
    for _ in range(RUNS):
        before = os.times()
        subprocess.run(line, check=True, capture_output=True)
        after = os.times()
        times.append(after.children_user + after.children_system - before.children_user - before.children_system)
    return min(times)


@pytest.mark.parametrize(("options", "most"), [((), 15.0), (("--without", "trajectories,precision"), 3.0)])
def test_the_report_is_written_in_time(tmp_path: Path, options: tuple[str, ...], most: float) -> None:
    target = tmp_path / "r.html"
    taken = seconds(target, *options)
    print(f"\nderive four-wheel {' '.join(options)}: {taken:.2f} s, {target.stat().st_size / 1000:.0f} kB")
    assert taken <= most
    assert target.stat().st_size <= MOST_BYTES
