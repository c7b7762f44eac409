"""A whole sweep: what was varied, what was found, and where the answers change."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from nonsmooth.reports.progress import ProgressCall, silent
from nonsmooth.reports.study_options import FAIL, Options, option
from nonsmooth.reports.sweeps.base import Base, entries_of, require_heard
from nonsmooth.reports.sweeps.borders import Border, find_borders
from nonsmooth.reports.sweeps.certified import Cells, CertifiedCell, certified_cell, exact_base, planned_cells
from nonsmooth.reports.sweeps.outcome import Outcome, outcome_of, questions_of
from nonsmooth.reports.sweeps.run import Runner
from nonsmooth.reports.sweeps.store import Store
from nonsmooth.reports.sweeps.sweep_error import SweepError
from nonsmooth.reports.sweeps.sweep_plan import LARGE, Point, SweepPlan
from nonsmooth.reports.sweeps.system_outcome import REFUSED
from nonsmooth.reports.sweeps.workers import Work, Workers, local_workers

SAMPLES = 4  # scenes by which the time of a large sweep is estimated; the first one is not counted
MAX_WORKERS = 1024


@dataclass(frozen=True)
class Sweep:
    """What a sweep found.

    Attributes:
        base: the scene before anything varies.
        plan: what varies.
        outcomes: of every scene, in the order of the plan.
        borders: where answers change along the edges of the grid; None where they were not looked for.
        cells: the cells of the grid, certified as a whole or not; None where nobody asked.
        checked: how many scenes were computed; the others were in the store, or equal to another one.
    """

    base: Base
    plan: SweepPlan
    outcomes: Sequence[Outcome]
    borders: tuple[Border, ...] | None
    checked: int
    cells: tuple[CertifiedCell, ...] | None = None

    @property
    def questions(self) -> tuple[str, ...]:
        """What every scene answers."""
        return questions_of(self.outcomes[0])


@dataclass(frozen=True, kw_only=True)
class Means(Options):
    """How a sweep is run: the options of the command that do not say what varies.

    In Python this process checks alone unless workers are given; the command gives them.
    """

    borders: bool = option(False, "Find where answers change along the grid, within 1e-9; a picture always does.")
    certify: bool = option(
        False, "Prove what holds in whole cells of the grid, for every array between and within the tolerances."
    )
    fail: int | None = option(None, FAIL, metavar="1")
    store: str | Path | None = option(
        None,
        "Keep results in this file, and take from it what is known; several sweeps may share it.",
        str | None,
        metavar="FILE",
    )
    workers: int | None = option(
        None, "Processes that check; as many as there are processors unless given.", metavar="N"
    )
    scheduler: str | None = option(
        None,
        "Check on the Dask cluster of this scheduler, such as tcp://host:8786 (needs nonsmooth[cluster]).",
        metavar="ADDRESS",
    )
    yes: bool = option(False, "Run more than a million scenes.")

    @property
    def processes(self) -> int:
        """How many processes check; 1 is this one alone."""
        return 1 if self.workers is None else self.workers


def run_sweep(base: Base, plan: SweepPlan, means: Means, report: ProgressCall = silent) -> Sweep:
    """Check all scenes of a plan.

    Raises:
        SceneError: for a number that no wheel takes.
        SweepError: for means that cannot be used, and where every scene is refused.
    """
    require_heard(base, plan)
    if means.fail not in (None, 1):
        raise SweepError(f"fail: required 1, the number of wheels that fail, received {means.fail}")
    if not 1 <= means.processes <= MAX_WORKERS:
        raise SweepError(f"workers: required 1 to {MAX_WORKERS}, received {means.workers}")
    if means.borders and plan.draws is not None:
        raise SweepError("borders: required a grid of scenes, received random draws")
    if base.is_system:
        _require_array(means)
    if plan.size > LARGE and not means.yes:
        raise SweepError(_estimate(base, plan, means))
    cells = planned_cells(base, plan) if means.certify else None
    scenes = exact_base(base) if means.certify else base
    work = Work(scenes, tuple(axis.path for axis in plan.axes), means.fail is not None)
    with _runner(work, means, report) as runner:
        outcomes = runner.outcomes((entries_of(plan, k) for k in range(plan.size)), plan.size)
        _require_one_answer(outcomes)
        borders = _borders(plan, outcomes, runner) if means.borders else None
        checked = runner.checked
    proved = None if cells is None else _certified(cells, means, report)
    return Sweep(base, plan, outcomes, borders, checked, proved)


def _require_array(means: Means) -> None:
    """Refuse for a plain system what is asked of arrays only.

    Raises:
        SweepError: for failures of wheels and for certified cells.
    """
    for name, asked in (("fail", means.fail is not None), ("certify", means.certify)):
        if asked:
            raise SweepError(f"{name}: required an array of wheels, received a plain switched system")


def _certified(cells: Cells, means: Means, report: ProgressCall) -> tuple[CertifiedCell, ...]:
    """What is proved of the cells of the grid."""
    work = Work(cells.base, cells.paths, failures=False, cells=True)
    with _runner(work, means, report) as runner:
        found = runner.outcomes(cells.entries, len(cells.entries), "cells")
    return tuple(certified_cell(sides, outcome) for sides, outcome in zip(cells.sides, found, strict=True))


@contextmanager
def _runner(work: Work, means: Means, report: ProgressCall) -> Iterator[Runner]:
    """Workers and store, closed in the end whatever happens."""
    store = None if means.store is None else Store(Path(means.store))
    try:
        workers = _workers(work, means)
        try:
            yield Runner(work, workers, store, report)
        finally:
            workers.close()
    finally:
        if store is not None:
            store.close()


def _workers(work: Work, means: Means) -> Workers:
    """A cluster where one is named, else this machine."""
    if means.scheduler is None:
        return local_workers(work, means.processes)
    from nonsmooth.reports.sweeps.cluster import Cluster

    return Cluster(work, means.scheduler)


def _borders(plan: SweepPlan, outcomes: Sequence[Outcome], runner: Runner) -> tuple[Border, ...]:
    def ask(points: Sequence[Point]) -> Sequence[Outcome]:
        scenes = (tuple(value.entry for value in point) for point in points)
        return runner.outcomes(scenes, len(points), "borders")

    return find_borders(plan, outcomes, ask)


def _require_one_answer(outcomes: Sequence[Outcome]) -> None:
    """A sweep without any answer is a mistake of its user.

    Raises:
        SweepError: with the first reason.
    """
    if all(outcome[questions_of(outcome)[0]] == REFUSED for outcome in outcomes):
        raise SweepError(f"vary: required a scene that can be checked, received {outcomes[0]['why']}")


def _estimate(base: Base, plan: SweepPlan, means: Means) -> str:
    """What to say before a large sweep, from a few measured scenes."""
    paths = tuple(axis.path for axis in plan.axes)
    seconds = []
    for k in range(SAMPLES):
        started = time.perf_counter()
        outcome_of(base, paths, entries_of(plan, plan.size * k // SAMPLES), failures=means.fail is not None)
        seconds.append(time.perf_counter() - started)
    whole = sum(seconds[1:]) / (SAMPLES - 1) * plan.size / means.processes
    return f"yes: required for more than {LARGE} scenes, received {plan.size}: about {_duration(whole)}"


def _duration(seconds: float) -> str:
    """``3 hours``, in the largest unit that is not longer."""
    units = (("years", 31_557_600), ("days", 86_400), ("hours", 3_600), ("minutes", 60))
    name, length = next(((name, length) for name, length in units if seconds >= 2 * length), ("seconds", 1))
    return f"{seconds / length:.3g} {name}"
