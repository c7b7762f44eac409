"""The rules ``roller``, ``ellipse`` and ``box`` against MuJoCo with real rollers, over a hundred random arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.roller_engine import creep_rates, random_array, relative_errors

if TYPE_CHECKING:
    from tests.benchmarks.conftest import Stopwatch

pytestmark = pytest.mark.benchmark

ARRAYS = 100
MEDIAN = 2e-3  # relative error of a twist under rule roller
CREEP = 2e-2  # relative, of the speed at which the body comes home near the point


def test_median_error_of_the_twist(stopwatch: Stopwatch) -> None:
    """Where the twist jumps, the engine's loads decide on which side a body is: those few arrays are far off."""
    arrays = [random_array(seed) for seed in range(ARRAYS)]
    errors = np.array([relative_errors(*array) for array in arrays])
    stiff = np.array([wheels.mu_side[0] > 0.1 for wheels, _ in arrays])
    for name, chosen in (("mu_S up to 0.1", ~stiff), ("mu_S 0.1 to 0.5", stiff)):
        for rule, column in zip(("roller", "ellipse", "box"), errors[chosen].T, strict=True):
            median, most = np.median(column), np.quantile(column, 0.9)
            stopwatch.report(f"{name}, rule {rule}: median {median:.1e}, nine of ten below {most:.1e}")
    medians = np.median(errors, axis=0)
    assert medians[0] < MEDIAN
    assert medians[0] < medians[1] / 10
    assert np.quantile(errors[stiff, 0], 0.9) < np.quantile(errors[stiff, 2], 0.9) / 10


@pytest.mark.parametrize("side", [0.02, 0.05, 0.1, 0.2, 0.5])
def test_creep_at_rest(side: float, stopwatch: Stopwatch) -> None:
    rates = creep_rates(side)
    stopwatch.report(f"creep at rest, mu_S = {side}: {rates[0]:.4f}, {rates[1]:.4f} |c|; sqrt(2) = {np.sqrt(2):.4f}")
    assert rates == pytest.approx(np.sqrt(2), rel=CREEP)
