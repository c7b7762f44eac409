"""The command line from the shell, interpreter start included, against merely importing SymPy."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.benchmarks.conftest import Stopwatch

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
