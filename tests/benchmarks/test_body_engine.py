"""Whole paths of bodies with an outline against MuJoCo; settled twists: ``test_real_machine``."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from tests.benchmarks.conftest import Stopwatch
from tests.body_engine import inward_grid, random_grid, run_beside_engine, with_random_body

RUNS = 3  # of each kind; the third random one reacts strongly to loads: poses come out 0.11 apart
LATE = 0.08  # of changes, at wheels of speed one; the engine is late by some per cent


@pytest.mark.parametrize("kind", ["random", "inward"])
def test_paths(kind: str, stopwatch: Stopwatch) -> None:
    runs = []
    for seed in range(RUNS):
        rng = np.random.default_rng(seed + 1)
        grid = random_grid(rng) if kind == "random" else inward_grid(Fraction(1, 2))
        runs.append(run_beside_engine(with_random_body(grid, rng, 1.2), 0.7))
    alike, tips = sum(run.changes_alike(LATE) for run in runs), sum(run.tips_alike for run in runs)
    far = max(run.error for run in runs)
    stopwatch.report(
        f"{kind}: {alike} of {RUNS} paths with the same changes, {tips} with the same end, poses {far:.3f} apart"
    )
    assert all(run.path.end.reason.name == "TIPS" for run in runs if run.fell is not None)
    assert alike >= RUNS - 1
