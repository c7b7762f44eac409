"""A whole sweep: what was varied, what was found, and where the answers change."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TypeAlias

from nonsmooth.reports.output.progress import ProgressCall, silent
from nonsmooth.reports.output.study_options import FAIL, Options, option
from nonsmooth.reports.sweeps.base import Base, entries_of, require_heard
from nonsmooth.reports.sweeps.borders import Border, find_borders
from nonsmooth.reports.sweeps.certified_cells import Cells, CertifiedCell, certified_cell, exact_base, planned_cells
from nonsmooth.reports.sweeps.outcome import REFUSED, Outcome, questions_of
from nonsmooth.reports.sweeps.store import Store
from nonsmooth.reports.sweeps.sweep_plan import LARGE, Entry, Point, SweepError, SweepPlan
from nonsmooth.reports.sweeps.workers import MOST, Cluster, Task, Work, Workers, local_workers

SAMPLES = 4  # jobs by which the time of a large sweep is estimated; the first one is not counted
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
    scenes = exact_base(base) if means.certify else base
    work = Work(scenes, tuple(axis.path for axis in plan.axes), means.fail is not None)
    if plan.size > LARGE and not means.yes:
        raise SweepError(_estimate(work, plan, means))
    cells = planned_cells(base, plan) if means.certify else None
    with _runner(work, means, report) as runner:
        outcomes = runner.outcomes((entries_of(plan, k) for k in range(plan.size)), plan.size)
        if all(outcome[questions_of(outcome)[0]] == REFUSED for outcome in outcomes):
            raise SweepError(f"vary: required a scene that can be checked, received {outcomes[0]['why']}")
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
    return Cluster(work, means.scheduler)


def _borders(plan: SweepPlan, outcomes: Sequence[Outcome], runner: Runner) -> tuple[Border, ...]:
    def ask(points: Sequence[Point]) -> Sequence[Outcome]:
        scenes = (tuple(value.entry for value in point) for point in points)
        return runner.outcomes(scenes, len(points), "borders")

    return find_borders(plan, outcomes, ask)


def _estimate(work: Work, plan: SweepPlan, means: Means) -> str:
    """What to say before a large sweep, from a few measured jobs."""
    seconds = []
    for k in range(SAMPLES):
        first = plan.size * k // SAMPLES
        job = [entries_of(plan, scene) for scene in range(first, first + MOST)]
        started = time.perf_counter()
        checked = len(work.outcomes(job))
        seconds.append((time.perf_counter() - started) / checked)
    whole = sum(seconds[1:]) / (SAMPLES - 1) * plan.size / means.processes
    return f"yes: required for more than {LARGE} scenes, received {plan.size}: about {_duration(whole)}"


def _duration(seconds: float) -> str:
    """``3 hours``, in the largest unit that is not longer."""
    units = (("years", 31_557_600), ("days", 86_400), ("hours", 3_600), ("minutes", 60))
    name, length = next(((name, length) for name, length in units if seconds >= 2 * length), ("seconds", 1))
    return f"{seconds / length:.3g} {name}"


# ---- running the scenes --------------------------------------------------------------------------


ASK = "answers"  # what is asked of a scene, as part of its key
ASK_CELLS = "a cell of the grid, certified as a whole"
ASK_FAILURES = "answers, failures of one wheel"
LOOK_AHEAD = 200  # scenes that are looked up in the store at once
POLL = 0.2  # seconds between two looks for what another sweep is working on

Found: TypeAlias = Iterator[tuple[int, Outcome]]


class Runner:
    """Checks many scenes; equal ones once.

    Attributes:
        work: what they share.
        checked: how many were computed, and not read from the store.
    """

    def __init__(self, work: Work, workers: Workers, store: Store | None = None, report: ProgressCall = silent) -> None:
        self.work = work
        self.checked = 0
        self._workers, self._store, self._report = workers, store, report
        self._asked = ASK_CELLS if work.cells else ASK_FAILURES if work.failures else ASK

    def outcomes(self, scenes: Iterable[Sequence[Entry]], count: int, what: str = "checked") -> list[Outcome]:
        """The outcomes of scenes by the values of what varies, in their order.

        Args:
            scenes: they may be made one by one.
            count: how many there are.
            what: names the work for whoever watches.

        Raises:
            SweepError: where the store fails; what it holds stays.
        """
        found: dict[int, Outcome] = {}
        for k, outcome in self._found(enumerate(self._tasks(scenes))):
            found[k] = outcome
            self._report(len(found), count, what)
        return [found[k] for k in range(count)]

    def _tasks(self, scenes: Iterable[Sequence[Entry]]) -> Iterator[Task]:
        for entries in scenes:
            yield Task(self.work.base.key(self.work.paths, entries, self._asked), tuple(entries))

    def _found(self, tasks: Iterator[tuple[int, Task]]) -> Found:
        """The outcomes as they come, with the numbers of their scenes."""
        wanted: dict[str, list[int]] = {}  # scenes under way, and who waits for each
        waiting: deque[Task] = deque()  # looked up, not known, not yet begun
        elsewhere: deque[Task] = deque()  # under way in another sweep
        more = True
        while more or wanted:
            if more and len(waiting) < LOOK_AHEAD:
                some = list(islice(tasks, LOOK_AHEAD))
                more = bool(some)
                yield from self._look_up(some, wanted, waiting)
            yield from self._begin(wanted, waiting, elsewhere)
            for finished in self._workers.finished():
                self.checked += 1
                if self._store is not None and finished.lasting:
                    self._store.put(finished.task.key, finished.outcome)
                yield from ((k, finished.outcome) for k in wanted.pop(finished.task.key))
            if elsewhere and not waiting:  # ask again for what other sweeps are working on
                if len(wanted) == len(elsewhere):
                    time.sleep(POLL)
                waiting, elsewhere = elsewhere, deque()

    def _look_up(self, some: Sequence[tuple[int, Task]], wanted: dict[str, list[int]], waiting: deque[Task]) -> Found:
        """Hand out what the store knows, and queue the rest, equal scenes once."""
        known = {} if self._store is None else self._store.known([task.key for _, task in some])
        for k, task in some:
            if task.key in known:
                yield k, known[task.key]
            elif task.key in wanted:
                wanted[task.key].append(k)
            else:
                wanted[task.key] = [k]
                waiting.append(task)

    def _begin(self, wanted: dict[str, list[int]], waiting: deque[Task], elsewhere: deque[Task]) -> Found:
        """Hand over as many scenes as the workers have room for; what another sweep has finished or claimed is not."""
        while waiting and self._workers.room > 0:
            some = [waiting.popleft() for _ in range(min(self._workers.room, len(waiting)))]
            if self._store is None:
                self._workers.submit(some)
                continue
            ours = self._store.claim([task.key for task in some])
            others = [task for task in some if task.key not in ours]
            known = self._store.known([task.key for task in others])
            elsewhere.extend(task for task in others if task.key not in known)
            self._workers.submit([task for task in some if task.key in ours])
            for key, outcome in known.items():
                yield from ((k, outcome) for k in wanted.pop(key))
