"""A hundred thousand arrays with exact coincidences, ten thousand without, and some under ``box``: against paths.

The number of arrays can be set for a shorter run: ``NONSMOOTH_TIED_ARRAYS=5000 make bench``.
"""

from __future__ import annotations

import os
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context

import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays
from tests.oracles.box_paths import box_contradiction, contradiction, observe_box
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.nearest_paths import observe
from tests.oracles.tied_arrays import scene_of, tied_array, tied_box, turning_pool, untied_array

ARRAYS = int(os.environ.get("NONSMOOTH_TIED_ARRAYS", "100000"))
BLOCK = 250
FIRST = 1_000_000  # seeds that the fast tests do not use
LARGEST_SHARE_UNDECIDED = 0.02  # of arrays without a coincidence


def judged(first: int, tied: bool) -> tuple[Counter[str], list[int]]:
    """Verdicts of a block of arrays, and the seeds of those that paths contradict."""
    seen, wrong = Counter[str](), []
    for seed in range(first, first + BLOCK):
        wheels = tied_array(seed)[0] if tied else untied_array(seed)
        result = decide_translation(build_nearest_partition(scene_of(Arrays(), wheels)))
        seen[str(result.verdict)] += 1
        if not evidence_holds(result) or contradiction(result, observe(wheels, seed=seed, starts=6)):
            wrong.append(seed)
    return seen, wrong


@pytest.mark.parametrize("tied", [True, False], ids=["tied", "untied"])
def test_no_verdict_is_contradicted_by_paths(stopwatch: Stopwatch, tied: bool) -> None:
    turning_pool()  # once, before the processes part
    count = ARRAYS if tied else ARRAYS // 10
    seen, wrong = Counter[str](), list[int]()
    with ProcessPoolExecutor(mp_context=get_context("fork")) as workers:
        starts = range(FIRST, FIRST + count, BLOCK)
        for verdicts, seeds in workers.map(judged, starts, repeat(tied)):
            seen += verdicts
            wrong += seeds
    total = sum(seen.values())
    share = seen["undecided"] / total
    kind = "with coincidences" if tied else "without"
    stopwatch.report(f"{total} arrays {kind}: {dict(seen)}, {share:.2%} undecided, {len(wrong)} contradicted")
    assert wrong == []
    assert tied or share <= LARGEST_SHARE_UNDECIDED


def test_no_verdict_at_corners_of_box_cells_is_contradicted_by_paths(stopwatch: Stopwatch) -> None:
    seen, wrong = Counter[str](), []
    for seed in range(FIRST, FIRST + ARRAYS // 100):
        wheels, at, partition = tied_box(Arrays(), seed)
        result = decide_translation(partition)
        seen[str(result.verdict)] += 1
        if box_contradiction(result, observe_box(wheels, at)):
            wrong.append(seed)
    stopwatch.report(f"{sum(seen.values())} corners of cells under box: {dict(seen)}, {len(wrong)} contradicted")
    assert wrong == []
