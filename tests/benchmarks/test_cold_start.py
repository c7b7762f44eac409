"""Processes of their own, interpreter start included: commands and a report, beside merely importing libraries."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.benchmarks.conftest import Stopwatch

# ---- The command line from the shell, interpreter start included, against merely importing SymPy.

RUNS = 10
COMMAND_LINE = ("-m", "nonsmooth.reports.cli")
# Of `import sympy`. The help cannot cost less than `import typer`, some 0.2 of it.
ALLOWED: dict[tuple[str, ...], float] = {
    **{("check", "four-wheel", "--rule", rule): 1.4 for rule in ("nearest", "box", "ellipse", "roller")},
    ("--help",): 0.3,
}


def with_bytecode(folder: Path) -> dict[str, str]:
    """The environment in which Python keeps bytecode in a folder, as pip leaves it beside what it installs."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return environment | {"PYTHONPYCACHEPREFIX": str(folder)}


def processor_time(environment: dict[str, str], *arguments: str) -> float:
    """Seconds of user and system time that Python takes for these arguments."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], check=False, capture_output=True, env=environment)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def test_cold_start(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Runs alternate, so that a busy moment of the machine meets all of them; the shortest of each counts."""
    environment = with_bytecode(tmp_path)
    sympy, shortest = float("inf"), dict.fromkeys(ALLOWED, float("inf"))
    for _ in range(RUNS):
        sympy = min(sympy, processor_time(environment, "-c", "import sympy"))
        for arguments in ALLOWED:
            shortest[arguments] = min(shortest[arguments], processor_time(environment, *COMMAND_LINE, *arguments))
    for arguments, seconds in shortest.items():
        stopwatch.report(
            f"cold {' '.join(arguments)}: {seconds * 1e3:.0f} ms, import sympy {sympy * 1e3:.0f} ms, "
            f"ratio {seconds / sympy:.2f} (allowed {ALLOWED[arguments]})"
        )
    assert all(seconds <= ALLOWED[arguments] * sympy for arguments, seconds in shortest.items())


# ---- How long the HTML report of the paper's array takes from a cold start, and how large it is. -

ROUNDS = 3  # the fastest of each counts
MOST_BYTES = 2_000_000
LIBRARIES = "import sympy, matplotlib.figure, scipy.optimize, scipy.spatial"
REPORT = ("-m", "nonsmooth.reports.cli", "derive", "four-wheel")


@pytest.mark.parametrize(("options", "most"), [((), 5), (("--without", "trajectories,precision"), 3)])
def test_the_report_takes_a_few_times_as_long_as_its_libraries(
    tmp_path: Path, options: tuple[str, ...], most: float
) -> None:
    target = tmp_path / "r.html"
    work, environment = ("-c", LIBRARIES), dict(os.environ)
    report = (*REPORT, "-o", str(target), *options)
    times = [(processor_time(environment, *work), processor_time(environment, *report)) for _ in range(ROUNDS)]
    libraries, own = (min(of) for of in zip(*times, strict=True))
    print(
        f"\nderive four-wheel {' '.join(options)}: {own:.2f} s, {own / libraries:.1f} times as long as its "
        f"libraries (allowed {most}), {target.stat().st_size / 1000:.0f} kB"
    )
    assert own <= most * libraries
    assert target.stat().st_size <= MOST_BYTES
