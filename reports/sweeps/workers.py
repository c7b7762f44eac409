"""Who checks the scenes of a sweep: this process, or a pool of processes that are warm and may die.

A worker that is killed costs time only: another takes its place, and its scene is tried again; after a few deaths that
one is refused.
"""

from __future__ import annotations

import asyncio
import logging
import os
import pickle
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from itertools import islice
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, Protocol

from nonsmooth.reports.output.processes import DiedError, WorkerPool, serve
from nonsmooth.reports.sweeps.base import Base, program_hash
from nonsmooth.reports.sweeps.certified_cells import cell_outcome
from nonsmooth.reports.sweeps.outcome import Outcome, outcomes_of, refused
from nonsmooth.reports.sweeps.sweep_plan import Entry, SweepError
from nonsmooth.symbolic.files.key_paths import Path

AHEAD = 2  # jobs under way for each worker, so that none waits for the next
JOB = 0.2  # seconds after which a worker answers: what it has not begun by then goes back to the others
MOST = 64  # scenes of a job
TICK = 1.0  # seconds after which the sweep looks up, whether anything is finished or not
DEATHS = 4  # of workers before a scene is refused: one among others, then alone
DIED = "its worker was killed again and again: it takes more memory or time than the machine allows"
NEVER_READY = (
    'required processes that start (a script needs if __name__ == "__main__":), received ones that end at once'
)


class Task(NamedTuple):
    """One scene to check."""

    key: str
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Work:
    """What every scene of a sweep shares, and what this process found so far."""

    base: Base
    paths: tuple[Path, ...]
    failures: bool
    cells: bool = False  # cells of the grid instead of scenes
    earlier: dict[Hashable, Outcome] = field(default_factory=dict, compare=False, repr=False)

    def outcome(self, entries: Sequence[Entry]) -> Outcome:
        """Check one scene, or one cell."""
        return self.outcomes([entries])[0]

    def outcomes(self, scenes: Sequence[Sequence[Entry]]) -> list[Outcome]:
        """Check the first of these scenes or cells, as many as are begun within :data:`JOB` seconds."""
        begun = _begun_in_time(scenes)
        if self.cells:
            return [cell_outcome(self.base, self.paths, entries) for entries in begun]
        return outcomes_of(self.base, self.paths, begun, failures=self.failures, earlier=self.earlier)


def _begun_in_time(scenes: Iterable[Sequence[Entry]]) -> Iterator[Sequence[Entry]]:
    """The first one, and the others until :data:`JOB` seconds have passed."""
    end = time.monotonic() + JOB
    for entries in scenes:
        yield entries
        if time.monotonic() >= end:
            return


class CheckedTask(NamedTuple):
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

    def finished(self) -> Iterator[CheckedTask]:
        """What is finished; comes back within about ``TICK`` seconds where nothing is."""
        ...

    def close(self) -> None:
        """Stop, and drop what is under way."""
        ...


class JobSize:
    """How many scenes make a job.

    Twice as many as were checked in the last one, or as many where it came back with some that were not.
    """

    def __init__(self) -> None:
        self.scenes = 1

    def learn(self, given: int, checked: int) -> None:
        """From a job: how many scenes were given, and how many of them were checked, one at least."""
        self.scenes = min(checked if checked < given else 2 * checked, MOST)


class InProcess:
    """One job after the other, here."""

    def __init__(self, work: Work) -> None:
        self._work, self._size = work, JobSize()
        self._waiting: deque[Task] = deque()

    @property
    def room(self) -> int:
        """One job at a time, so that other sweeps find the next scenes free."""
        return self._size.scenes - len(self._waiting)

    def submit(self, tasks: Iterable[Task]) -> None:
        """See :class:`Workers`."""
        self._waiting.extend(tasks)

    def finished(self) -> Iterator[CheckedTask]:
        """See :class:`Workers`."""
        while self._waiting:
            job = tuple(self._waiting)
            found = self._work.outcomes([task.entries for task in job])
            self._waiting = deque(job[len(found) :])
            self._size.learn(len(job), len(found))
            yield from map(CheckedTask, job, found)

    def close(self) -> None:
        """See :class:`Workers`."""
        self._waiting.clear()


class ProcessPool:
    """Processes of this machine, driven by an event loop in a thread of its own.

    A scene whose worker dies is tried again where nothing else runs: it may have lacked memory beside the others.
    """

    def __init__(self, work: Work, count: int) -> None:
        self._work, self._count, self._size = work, count, JobSize()
        self._running: dict[Future[list[Outcome]], tuple[Task, ...]] = {}
        self._died: dict[Task, int] = {}  # to be tried again, alone, and how many workers each has cost
        self._loop = asyncio.new_event_loop()
        self._pool = WorkerPool(partial(_serve, work), count, preload=__name__)
        self._thread = threading.Thread(target=self._drive, daemon=True)
        self._thread.start()

    @property
    def room(self) -> int:
        """None while something is tried again."""
        return 0 if self._died else (self._count * AHEAD - len(self._running)) * self._size.scenes

    def submit(self, tasks: Iterable[Task]) -> None:
        """See :class:`Workers`."""
        waiting = iter(tasks)
        while job := tuple(islice(waiting, self._size.scenes)):
            self._running[asyncio.run_coroutine_threadsafe(self._outcomes(job), self._loop)] = job

    def finished(self) -> Iterator[CheckedTask]:
        """See :class:`Workers`.

        Raises:
            SweepError: where no worker ever gets ready.
        """
        if self._died and not self._running:
            self.submit([next(iter(self._died))])
        done, _ = wait(self._running, timeout=TICK, return_when=FIRST_COMPLETED)
        for future in done:
            job = self._running.pop(future)
            try:
                found = future.result()
            except DiedError:
                for task in job:
                    yield from self._mourned(task)
            else:
                self._size.learn(len(job), len(found))
                self.submit(job[len(found) :])
                for task, outcome in zip(job, found, strict=False):
                    self._died.pop(task, None)
                    yield CheckedTask(task, outcome)

    def close(self) -> None:
        """See :class:`Workers`."""
        self._running.clear()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    def _drive(self) -> None:
        """In the thread: run the loop until it is stopped, then drop what is under way."""
        with asyncio.Runner(loop_factory=lambda: self._loop):
            self._loop.run_forever()
            self._pool.close()

    async def _outcomes(self, job: Sequence[Task]) -> list[Outcome]:
        """What a worker finds of the first scenes of a job.

        Raises:
            DiedError: where it is killed.
        """
        scenes = [task.entries for task in job]
        found = [pickle.loads(message) async for message in self._pool.run(pickle.dumps(scenes))]
        if isinstance(found[0], Exception):
            raise found[0]
        return found[0]

    def _mourned(self, task: Task) -> Iterator[CheckedTask]:
        """A scene whose worker died: tried again, or after a few deaths refused.

        Raises:
            SweepError: where no worker ever gets ready.
        """
        deaths = self._died[task] = self._died.get(task, 0) + 1
        if deaths < DEATHS:
            return
        if not self._pool.was_ready:
            raise SweepError(f"workers: {NEVER_READY}")
        del self._died[task]
        yield CheckedTask(task, refused(DIED, is_system=self._work.base.is_system), lasting=False)


def local_workers(work: Work, count: int) -> Workers:
    """This process for a count of 1, else a pool."""
    return InProcess(work) if count == 1 else ProcessPool(work, count)


def processors() -> int:
    """How many processes may run at once."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# ---- in a worker ---------------------------------------------------------------------------------


def _serve(work: Work, connection: Connection) -> None:
    serve(connection, partial(_answers, work))


def _answers(work: Work, job: bytes, look_up: Callable[[], None]) -> Iterator[bytes]:
    """The outcomes of scenes, or the fault that ended a check: who started this process raises it."""
    del look_up  # a scene of a sweep is never cancelled: its worker is killed
    try:
        found: list[Outcome] | Exception = work.outcomes(pickle.loads(job))
    except Exception as error:
        error.add_note(traceback.format_exc())
        found = error
    yield pickle.dumps(found)


# ---- a Dask cluster as the workers of a sweep ----------------------------------------------------
#
# The scheduler is there already, and only the sweep writes the store.
#
# Dask tries again what a dead worker left undone.  Every answer comes with the hash of the program that found it, so
# workers with another version of this program are refused.  Needs the package ``distributed`` (extra ``cluster``).


GOODBYE = 3  # seconds to leave the scheduler in order
ANSWER = 6  # seconds within which the scheduler must answer
FEWEST = 4  # scenes under way while there is no worker: clusters that adapt start workers for waiting work
RECOUNT = 5.0  # seconds between two counts of the workers


class Cluster:
    """Workers of a Dask scheduler."""

    def __init__(self, work: Work, address: str) -> None:
        """Connect.

        Raises:
            SweepError: for a scheduler that does not answer, and without the package.
        """
        try:
            self._dask: Any = import_module("distributed")
        except ImportError:
            required = "the package distributed (pip install nonsmooth[cluster])"
            raise SweepError(f"scheduler: required {required}, received a Python without it") from None
        self._address = address
        for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what is wrong is said in one line
        # A client that failed to connect would try to say goodbye for many seconds when it is deleted.
        client = type("SweepClient", (self._dask.Client,), {"__del__": _say_nothing})
        try:
            self._client = client(address, timeout=ANSWER, set_as_default=False, name="nonsmooth-sweep")
        except Exception:  # whatever answers there, be it another program, is no scheduler
            raise self._lost(f"a Dask scheduler that answers within {ANSWER} s", "none") from None
        self._is_system = work.base.is_system
        self._work = self._client.scatter(work, broadcast=False, hash=False)
        self._running: dict[Any, Task] = {}
        self._counted, self._threads = 0.0, 0

    @property
    def room(self) -> int:
        """Twice the threads of the cluster, less what is under way."""
        now = time.monotonic()
        if now - self._counted > RECOUNT:
            with self._connected():
                self._threads, self._counted = sum(self._client.nthreads().values()), now
        return max(FEWEST, self._threads * AHEAD) - len(self._running)

    def submit(self, tasks: Iterable[Task]) -> None:
        """See :class:`nonsmooth.reports.sweeps.workers.Workers`."""
        with self._connected():
            for task in tasks:
                self._running[self._client.submit(check_there, self._work, task.entries, pure=False)] = task

    def finished(self) -> Iterator[CheckedTask]:
        """See :class:`nonsmooth.reports.sweeps.workers.Workers`.

        Raises:
            SweepError: where the scheduler is lost, and for workers with another version of this program.
        """
        with self._connected():
            done = self._some_done()
        for future in done:
            task = self._running.pop(future)
            yield self._collected(future, task)

    def close(self) -> None:
        """See :class:`nonsmooth.reports.sweeps.workers.Workers`."""
        running = list(self._running)
        self._running.clear()
        with suppress(OSError, CancelledError):  # it may be lost
            if self._client.status == "running":
                self._client.cancel(running)
            self._client.close(timeout=GOODBYE)

    def _some_done(self) -> set[Any]:
        """What is finished after ``TICK`` seconds or less."""
        try:
            with self._client.as_current():
                done: set[Any] = self._dask.wait(list(self._running), timeout=TICK, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            if self._client.status != "running":
                raise
            return set()
        return done

    @contextmanager
    def _connected(self) -> Iterator[None]:
        """Work that needs the scheduler.

        Raises:
            SweepError: where it is lost.
        """
        try:
            yield
        except (OSError, CancelledError):
            raise self._lost("a scheduler that stays", "a lost connection") from None

    def _collected(self, future: Any, task: Task) -> CheckedTask:
        """The outcome of one scene."""
        if future.status in ("cancelled", "lost"):
            raise self._lost("a scheduler that stays", "a lost connection")
        try:
            program, outcome = future.result()
        except self._dask.KilledWorker:
            return CheckedTask(task, refused(DIED, is_system=self._is_system), lasting=False)
        if program != program_hash():
            raise self._lost("workers with this version of the program", "another version")
        return CheckedTask(task, outcome)

    def _lost(self, required: str, received: str) -> SweepError:
        return SweepError(f"scheduler: {self._address}: required {required}, received {received}")


def _say_nothing(client: object) -> None:
    """In place of a client's end: :meth:`Cluster.close` closes one that was connected."""


# ---- on a worker ---------------------------------------------------------------------------------

_one_at_a_time = threading.Lock()  # threads of one worker share the caches of exact numbers, and gain no speed


def check_there(work: Work, entries: tuple[Entry, ...]) -> tuple[str, Outcome]:
    """Check one scene on a worker; with the hash of the program that did."""
    with _one_at_a_time:
        return program_hash(), work.outcome(entries)
