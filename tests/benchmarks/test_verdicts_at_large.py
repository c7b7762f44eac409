"""Five hundred random cocircular arrays: how many verdicts, and whether 32 long trajectories each agree."""

from __future__ import annotations

from collections import Counter

from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays
from tests.proofs.test_tied_arrays import compare_with_trajectories as compare

ARRAYS, STARTS, LARGEST_SHARE_UNDECIDED = 500, 32, 0.02


def test_verdicts_agree_with_trajectories(arrays: Arrays, stopwatch: Stopwatch) -> None:
    seen = Counter(compare(arrays, seed, STARTS) for seed in range(1000, 1000 + ARRAYS))
    stopwatch.report(f"{ARRAYS} arrays, {STARTS} starts each: {dict(seen)}")
    assert seen["undecided"] <= LARGEST_SHARE_UNDECIDED * ARRAYS
