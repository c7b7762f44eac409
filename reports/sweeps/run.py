"""Running the scenes of a sweep: from the store where they are known, from the workers where they are not."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import TypeAlias

from nonsmooth.reports.progress import ProgressCall, silent
from nonsmooth.reports.sweeps.outcome import Outcome
from nonsmooth.reports.sweeps.store import Store
from nonsmooth.reports.sweeps.values import Entry
from nonsmooth.reports.sweeps.workers import Task, Work, Workers

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
