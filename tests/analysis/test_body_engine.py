"""Bodies with an outline against MuJoCo: a few poses and one path; many of them are in the benchmarks."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.trajectories.result import EndReason
from tests.body_engine import (
    lifted_loads,
    pose_beside_engine,
    predicted_changes,
    random_grid,
    run_beside_engine,
    with_random_body,
)
from tests.thorough import keep, thorough

TWISTS = 1e-3, 1e-2  # median and largest; over many poses 1e-4 is the median, and one of ten above 6e-4
LOADS = 2e-4  # of the weight
MARGIN = 0.05  # pitches: poses with a wheel nearer to the edge are left out
LATE, FAR = 0.04, 0.03  # of a path of length 0.4 at wheels of speed one; the largest seen 0.014 and 0.012


@thorough  # the small one: test_wheels_enter_and_leave_as_in_the_engine
def test_twists_loads_and_falls_of_random_bodies() -> None:
    poses = [pose_beside_engine(seed) for seed in range(1, 25)]
    assert all(pose.fell == pose.tips for pose in poses)
    assert any(pose.tips for pose in poses)
    inside = [pose for pose in poses if not pose.tips and pose.margin > MARGIN]
    assert len(inside) >= 6
    errors = [pose.twist_error for pose in inside]
    assert np.median(errors) < TWISTS[0]
    assert max(errors) < TWISTS[1]
    assert max(pose.load_error for pose in inside) < LOADS


@pytest.mark.parametrize(("until", "changes"), keep(1, [(0.22, 2), (0.4, 3)]))
def test_wheels_enter_and_leave_as_in_the_engine(until: float, changes: int) -> None:
    rng = np.random.default_rng(1)
    run = run_beside_engine(with_random_body(random_grid(rng), rng, 1.2), until)
    assert run.path.end.reason is EndReason.TIME
    assert len(predicted_changes(run.path)) == changes
    assert run.changes_alike(LATE)
    assert run.tips_alike
    assert run.error < FAR


@pytest.mark.parametrize(("seed", "speed", "time_constant"), [(1, 3e-3, 0.02), (1, 3e-3, 0.04), (3, 3e-3, 0.02)])
def test_slip_lifts_the_springs_of_the_engine(seed: int, speed: float, time_constant: float) -> None:
    """Why poses of engine and product part: by loads, which agree as wheels run more slowly."""
    engine, springs, lifted = lifted_loads(seed, speed, time_constant)
    apart = np.abs(engine - springs).max()
    assert apart > 5e-3
    assert np.abs(engine - lifted).max() < 0.01 * apart
