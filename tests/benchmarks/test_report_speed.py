"""How long the HTML report of the paper's array takes from a cold start, and how large it is.

The measure is what a process takes that only loads the libraries which every report needs: no machine is as fast as
another, and the same one is not always as fast.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROUNDS = 3  # the fastest of each counts
MOST_BYTES = 2_000_000
LIBRARIES = "import sympy, matplotlib.figure, scipy.optimize, scipy.spatial"
REPORT = ("-m", "nonsmooth.reports.cli", "derive", "four-wheel")


def seconds(*arguments: str) -> float:
    """Processor time of a process of its own: on an idle machine, what a user waits."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


@pytest.mark.parametrize(("options", "most"), [((), 5), (("--without", "trajectories,precision"), 3)])
def test_the_report_takes_a_few_times_as_long_as_its_libraries(
    tmp_path: Path, options: tuple[str, ...], most: float
) -> None:
    target = tmp_path / "r.html"
    times = [(seconds("-c", LIBRARIES), seconds(*REPORT, "-o", str(target), *options)) for _ in range(ROUNDS)]
    libraries, report = (min(of) for of in zip(*times, strict=True))
    print(
        f"\nderive four-wheel {' '.join(options)}: {report:.2f} s, {report / libraries:.1f} times as long as its "
        f"libraries (allowed {most}), {target.stat().st_size / 1000:.0f} kB"
    )
    assert report <= most * libraries
    assert target.stat().st_size <= MOST_BYTES
