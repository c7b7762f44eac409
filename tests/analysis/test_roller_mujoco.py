"""Rule ``roller`` against MuJoCo with real rollers: three arrays; the benchmarks take a hundred."""

from __future__ import annotations

import numpy as np
import pytest

from tests.roller_engine import creep_rates, random_array, relative_errors

TWIST = 2e-3  # relative; the largest seen of these three 3e-4
CREEP = 2e-2  # relative; the largest seen 2e-3


@pytest.mark.parametrize("seed", [8, 13, 2])
def test_engines_settled_twist_is_that_of_rule_roller(seed: int) -> None:
    roller, ellipse, _ = relative_errors(*random_array(seed))
    assert roller < TWIST
    assert roller < ellipse / 10


@pytest.mark.parametrize("side", [0.02, 0.5])
def test_rollers_that_stand_creep_home_whatever_their_bearings(side: float) -> None:
    """``c' = -sqrt(2) u c``: under rule box the body rests, under rule ellipse it is ``(mu_R/mu_S)^2`` as fast."""
    assert creep_rates(side) == pytest.approx(np.sqrt(2), rel=CREEP)
