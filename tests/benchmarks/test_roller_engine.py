"""Rollers that stand, against MuJoCo with real rollers; a hundred random arrays: ``test_real_machine``."""

from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.conftest import Stopwatch
from tests.roller_engine import creep_rates

CREEP = 2e-2  # relative, of the speed at which the body comes home near the point


@pytest.mark.parametrize("side", [0.02, 0.05, 0.1, 0.2, 0.5])
def test_creep_at_rest(side: float, stopwatch: Stopwatch) -> None:
    rates = creep_rates(side)
    stopwatch.report(f"creep at rest, mu_S = {side}: {rates[0]:.4f}, {rates[1]:.4f} |c|; sqrt(2) = {np.sqrt(2):.4f}")
    assert rates == pytest.approx(np.sqrt(2), rel=CREEP)
