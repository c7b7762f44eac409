"""Sweeps: a warm worker against the same check in this process, and ten thousand scenes on two processors."""

from __future__ import annotations

import time

import pytest

from nonsmooth.reports.sweeps.base import base_of
from nonsmooth.reports.sweeps.sweep import Means, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import read_plan
from nonsmooth.reports.sweeps.workers import ProcessPool, Task, Work
from nonsmooth.symbolic.files.documents import read_document
from tests.benchmarks.conftest import Stopwatch

SCENES = 40  # of each of the two that are compared
RATIO = 1.5  # of a check in a warm worker to one in this process
MEASURED, WHOLE = 500, 10_000  # scenes that are run, and that are asked about
FEW = 100  # of them in this process


def work() -> Work:
    return Work(base_of(*read_document("four-wheel")), (("check", "radius"),), False)


def tasks(first: int) -> list[Task]:
    """Scenes that no cache knows, each checked by itself."""
    return [Task(f"{k}", (f"{k}/1009",)) for k in range(first, first + SCENES)]


def run_all(pool: ProcessPool, waiting: list[Task]) -> None:
    done = 0
    while done < SCENES:
        room = max(pool.room, 0)
        pool.submit(waiting[:room])
        waiting = waiting[room:]
        done += sum(1 for _ in pool.finished())


def test_a_warm_worker_takes_little_longer_than_this_process(stopwatch: Stopwatch) -> None:
    shared, pool = work(), ProcessPool(work(), 1)
    try:
        run_all(pool, tasks(1))  # warm
        starts = iter(range(100, 1000, SCENES))

        def here() -> None:
            for task in tasks(next(starts)):
                shared.outcome(task.entries)

        here()
        alone = stopwatch.best(here)
        there = stopwatch.best(lambda: run_all(pool, tasks(next(starts))))
    finally:
        pool.close()
    stopwatch.report(
        f"a check of four wheels: here {1e3 * alone / SCENES:.1f} ms, in a warm worker {1e3 * there / SCENES:.1f} ms, "
        f"ratio {there / alone:.2f} (asked <= {RATIO})"
    )
    assert there <= RATIO * alone


@pytest.mark.parametrize(("key", "values", "most"), [("mu_side", "0.05:2", 20), ("radius", "1/10:1", 80)])
def test_ten_thousand_scenes_on_two_processors(key: str, values: str, most: int, stopwatch: Stopwatch) -> None:
    """From a part of them: seconds that passed, and processor time, which other programs disturb less.

    Of friction rule `nearest` sees only which coefficient of a wheel is larger, so many scenes share one check.
    """
    base = base_of(*read_document("four-wheel"))
    plan = read_plan({key: f"{values}:{MEASURED}"}, base.document, base.file)
    start = time.perf_counter()
    found = run_sweep(base, plan, Means(workers=2))
    passed = (time.perf_counter() - start) * WHOLE / MEASURED
    few, start = read_plan({key: f"{values}:{FEW}"}, base.document, base.file), time.process_time()
    run_sweep(base, few, Means())
    busy = (time.process_time() - start) * WHOLE / FEW / 2
    stopwatch.report(
        f"{WHOLE} scenes of four wheels that differ in {key} on two workers: {passed:.0f} s by {MEASURED} of them with "
        f"the start of the workers, {busy:.0f} s of each processor by {FEW} (asked <= {most})"
    )
    assert found.checked == MEASURED
    assert busy <= most
