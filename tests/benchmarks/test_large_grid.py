"""A grid of 14 x 14 wheels against one of 7 x 8 under the rules that minimize D: three and a half times the wheels."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.theorem4 import Check, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch

ALLOWED_RATIO = 25  # twice the square of the ratio of wheels: tables of pairs are what grows
SCENE = """
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
    path.write_text(SCENE.format(rows=rows, columns=columns), encoding="utf-8")
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
        f"(allowed {ALLOWED_RATIO})"
    )
    assert all(result.feedback.verdict is Feedback.STABILIZABLE for result in results)
    assert all(result.check() for result in results)
    assert large <= ALLOWED_RATIO * small
