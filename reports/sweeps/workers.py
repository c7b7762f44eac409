"""Who checks the scenes of a sweep: this process, or a pool of processes that are warm and may die.

A worker that is killed costs time only: its pool is built anew, and what was under way is tried again, one by one, so
that it is known which scene it is whose workers die; after a few deaths that one is refused.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.synchronize import Event
from typing import NamedTuple, Protocol

from nonsmooth.reports.processes import begin_process, starting_with
from nonsmooth.reports.sweeps.base import Base
from nonsmooth.reports.sweeps.certified import cell_outcome
from nonsmooth.reports.sweeps.outcome import Outcome, outcome_of, refused
from nonsmooth.reports.sweeps.sweep_error import SweepError
from nonsmooth.reports.sweeps.values import Entry
from nonsmooth.symbolic.files.key_paths import Path

AHEAD = 2  # scenes under way for each worker, so that none waits for the next
TICK = 1.0  # seconds after which the sweep looks up, whether anything is finished or not
DEATHS = 4  # of workers before a scene is refused: among others, then alone
DIED = "its worker was killed again and again: it takes more memory or time than the machine allows"
FALSE_STARTS = 3  # pools that end before any worker is ready
NEVER_READY = (
    'required processes that start (a script needs if __name__ == "__main__":), received ones that end at once'
)


class Task(NamedTuple):
    """One scene to check."""

    key: str
    entries: tuple[Entry, ...]


class Work(NamedTuple):
    """What every scene of a sweep shares."""

    base: Base
    paths: tuple[Path, ...]
    failures: bool
    cells: bool = False  # cells of the grid instead of scenes

    def outcome(self, entries: Sequence[Entry]) -> Outcome:
        """Check one scene, or one cell."""
        if self.cells:
            return cell_outcome(self.base, self.paths, entries)
        return outcome_of(self.base, self.paths, entries, failures=self.failures)


class Finished(NamedTuple):
    """A scene that was checked; ``lasting`` where every run would find the same."""

    task: Task
    outcome: Outcome
    lasting: bool = True


class Workers(Protocol):
    """Whoever checks scenes."""

    @property
    def room(self) -> int:
        """How many more scenes to hand over now, so that no worker waits."""
        ...

    def submit(self, tasks: Iterable[Task]) -> None:
        """Hand over scenes."""
        ...

    def finished(self) -> Iterator[Finished]:
        """What is finished; comes back within about ``TICK`` seconds where nothing is."""
        ...

    def close(self) -> None:
        """Stop, and drop what is under way."""
        ...


class InProcess:
    """One scene after the other, here."""

    def __init__(self, work: Work) -> None:
        self._work = work
        self._waiting: deque[Task] = deque()

    @property
    def room(self) -> int:
        """One at a time, so that other sweeps find the next one free."""
        return 1 - len(self._waiting)

    def submit(self, tasks: Iterable[Task]) -> None:
        """See :class:`Workers`."""
        self._waiting.extend(tasks)

    def finished(self) -> Iterator[Finished]:
        """See :class:`Workers`."""
        while self._waiting:
            task = self._waiting.popleft()
            yield Finished(task, self._work.outcome(task.entries))

    def close(self) -> None:
        """See :class:`Workers`."""
        self._waiting.clear()


class ProcessPool:
    """Processes of this machine."""

    def __init__(self, work: Work, count: int) -> None:
        self._work, self._count = work, count
        self._context = starting_with(__name__)
        self._began = self._context.Event()  # set by every worker that is ready
        self._false_starts = 0
        self._executor = self._new()
        self._running: dict[Future[Outcome], Task] = {}
        self._again: deque[Task] = deque()  # to be tried once more, alone
        self._is_alone = False
        self._deaths: dict[str, int] = {}

    @property
    def room(self) -> int:
        """None while something is tried again."""
        return 0 if self._again or self._is_alone else self._count * AHEAD - len(self._running)

    def submit(self, tasks: Iterable[Task]) -> None:
        """See :class:`Workers`."""
        for task in tasks:
            self._start(task)

    def finished(self) -> Iterator[Finished]:
        """See :class:`Workers`."""
        self._try_again()
        done, _ = wait(self._running, timeout=TICK, return_when=FIRST_COMPLETED)
        died: list[Task] = []
        for future in done:
            task = self._running.pop(future)
            try:
                yield Finished(task, future.result())
            except BrokenProcessPool:
                died.append(task)
        if died:
            yield from self._recover(died)

    def close(self) -> None:
        """See :class:`Workers`."""
        self._running.clear()
        for process in list((self._executor._processes or {}).values()):  # no public way to stop what is under way
            process.kill()
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _new(self) -> ProcessPoolExecutor:
        """A pool of fresh processes: neither our threads nor our locks are copied into them."""
        shared = (self._work, self._began)
        return ProcessPoolExecutor(self._count, mp_context=self._context, initializer=_begin, initargs=shared)

    def _start(self, task: Task) -> None:
        try:
            self._running[self._executor.submit(_check, task.entries)] = task
        except (BrokenProcessPool, EOFError, ConnectionError):
            # It broke since we last looked, or what starts workers was killed: the task has done nothing that counts.
            self._again.append(task)

    def _try_again(self) -> None:
        """Begin one of those that must be tried again, where nothing else runs."""
        if self._running:
            return
        self._is_alone = bool(self._again)
        if self._again:
            self._start(self._again.popleft())
            if not self._running:  # it could not be started
                self._renew()

    def _recover(self, died: list[Task]) -> Iterator[Finished]:
        """Build the pool anew, and try again what was under way: any of it may have killed the worker."""
        for future in list(self._running):
            task = self._running.pop(future)
            if future.done() and future.exception() is None:
                yield Finished(task, future.result())
            else:
                died.append(task)
        self._renew()
        for task in died:
            deaths = self._deaths[task.key] = self._deaths.get(task.key, 0) + 1
            if deaths >= DEATHS:
                yield Finished(task, refused(DIED, is_system=self._work.base.is_system), lasting=False)
            else:
                self._again.append(task)

    def _renew(self) -> None:
        """Build the pool anew.

        Raises:
            SweepError: where no worker ever gets ready.
        """
        self._false_starts += not self._began.is_set()
        if self._false_starts >= FALSE_STARTS:
            raise SweepError(f"workers: {NEVER_READY}")
        self._executor.shutdown(wait=False, cancel_futures=True)
        self._executor = self._new()


def local_workers(work: Work, count: int) -> Workers:
    """This process for a count of 1, else a pool."""
    return InProcess(work) if count == 1 else ProcessPool(work, count)


def processors() -> int:
    """How many processes may run at once."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# ---- in a worker ---------------------------------------------------------------------------------

_works: list[Work] = []  # one entry in a worker, none elsewhere


def _begin(work: Work, began: Event) -> None:
    """Get ready."""
    begin_process()
    _works[:] = [work]
    began.set()


def _check(entries: tuple[Entry, ...]) -> Outcome:
    return _works[0].outcome(entries)
