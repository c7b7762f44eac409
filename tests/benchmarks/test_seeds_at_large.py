"""Random arrays of which the fast tests take a part: all of them."""

from __future__ import annotations

import pytest

from tests.analysis import test_equilibria as equilibria
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays
from tests.proofs import test_driven_feedback as driven

EQUILIBRIA = 200  # arrays


def test_equilibria(arrays: Arrays, stopwatch: Stopwatch) -> None:
    for seed in range(EQUILIBRIA):
        equilibria.test_every_equilibrium_of_a_random_array_is_one_and_none_is_missed(arrays, seed)
    stopwatch.report(f"{EQUILIBRIA} random arrays: every equilibrium found, and no other")


@pytest.mark.parametrize("seed", driven.FORCES_AND_SEPARATORS)
def test_forces_and_separators(arrays: Arrays, seed: int) -> None:
    driven.test_under_ellipse_forces_and_separators_exclude_each_other(arrays, seed, count=4)
