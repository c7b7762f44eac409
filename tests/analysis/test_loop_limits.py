"""Limits of loops of crossings whose times are only as sure as slow crossings can be."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.trajectories.smooth_path import LoopLimit, LoopMemory

LIMIT = 2.0


def first_limit(ratio: float, noise: float, crossings: int = 60) -> LoopLimit | None:
    """Of a loop of two crossings a turn, ``LIMIT - t`` in a ratio, each time wrong by the noise over its speed."""
    memory, rng = LoopMemory(), np.random.default_rng(0)
    left = ratio ** (np.arange(crossings) / 2)
    for k, (rest, wrong) in enumerate(zip(left, rng.uniform(-noise, noise, crossings), strict=True)):
        time = LIMIT - rest + wrong / rest
        found = memory.limit_after(time, np.array([0.0, (-1.0) ** k * rest]), "+-"[k % 2], 10.0)
        if found is not None:
            return found
    return None


@pytest.mark.parametrize("ratio", [0.02, 0.16, 0.6])
@pytest.mark.parametrize("noise", [0.0, 1e-14, 1e-12])
def test_limits_are_as_sure_as_crossings_are(ratio: float, noise: float) -> None:
    found = first_limit(ratio, noise)
    assert found is not None
    assert found.time == pytest.approx(LIMIT, abs=1e-11 if noise == 0 else 1e-7)
    assert np.abs(found.x).max() < 1e-6


def test_loops_that_are_not_regular_have_no_limit() -> None:
    assert first_limit(0.16, 1e-6, crossings=12) is None
