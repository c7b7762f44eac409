"""A check from the shell, interpreter start included, against merely importing SymPy."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.benchmarks.conftest import Stopwatch

pytestmark = pytest.mark.benchmark

ALLOWED_RATIO = 3


def run(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True)


def test_cold_check_of_the_four_wheel_array(stopwatch: Stopwatch) -> None:
    """Runs alternate, so that a busy moment of the machine meets both."""
    check, sympy = float("inf"), float("inf")
    for _ in range(7):
        sympy = min(sympy, stopwatch.best(lambda: run("-c", "import sympy"), runs=1))
        check = min(check, stopwatch.best(lambda: run("-m", "nonsmooth.reports.cli", "check", "four-wheel"), runs=1))
    stopwatch.report(
        f"cold check four-wheel: {check * 1e3:.0f} ms, import sympy {sympy * 1e3:.0f} ms, "
        f"ratio {check / sympy:.2f} (allowed {ALLOWED_RATIO})"
    )
    assert check <= ALLOWED_RATIO * sympy
