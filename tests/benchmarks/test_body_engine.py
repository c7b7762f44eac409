"""Bodies with an outline against MuJoCo: settled twists of random bodies on random grids, and whole paths."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.body_engine import inward_grid, pose_beside_engine, random_grid, run_beside_engine, with_random_body

if TYPE_CHECKING:
    from tests.benchmarks.conftest import Stopwatch

pytestmark = pytest.mark.benchmark

POSES = 200
MARGIN = 0.05  # pitches from the edge
MEDIAN, MOST = 3e-4, 2e-3  # relative errors of twists: the median, and nine of ten
BEYOND = 2.7  # reach of the centre of mass of bodies that hang over the border of the grid
RUNS = 3  # of each kind; the third random one reacts strongly to loads: poses come out 0.11 apart
LATE = 0.08  # of changes, at wheels of speed one; the engine is late by some per cent


def test_settled_twists_and_falls(stopwatch: Stopwatch) -> None:
    poses = [pose_beside_engine(seed) for seed in range(POSES)]
    poses += [pose_beside_engine(seed, BEYOND) for seed in range(POSES // 4)]
    errors = [pose.twist_error for pose in poses if not pose.tips and not pose.fell and pose.margin > MARGIN]
    median, most = np.median(errors), np.quantile(errors, 0.9)
    stopwatch.report(f"{len(errors)} twists: median {median:.1e}, nine of ten below {most:.1e}")
    fell = [pose for pose in poses if pose.fell]
    tips = [pose for pose in poses if pose.tips]
    predicted = [pose for pose in fell if pose.tips]
    stopwatch.report(f"{len(fell)} plates fell, {len(predicted)} of them predicted; {len(tips)} predicted to tip")
    assert median < MEDIAN
    assert most < MOST
    assert len(predicted) == len(fell)


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
