"""A Dask cluster as the workers of a sweep: the scheduler is there already, and only the sweep writes the store.

Dask tries again what a dead worker left undone.  Every answer comes with the hash of the program that found it, so
workers with another version of this program are refused.  Needs the package ``distributed`` (extra ``cluster``).
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from nonsmooth.reports.sweeps.base import program_hash
from nonsmooth.reports.sweeps.outcome import Outcome, refused
from nonsmooth.reports.sweeps.values import Entry, SweepError
from nonsmooth.reports.sweeps.workers import AHEAD, DIED, TICK, Finished, Task, Work

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

    def finished(self) -> Iterator[Finished]:
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

    def _collected(self, future: Any, task: Task) -> Finished:
        """The outcome of one scene."""
        if future.status in ("cancelled", "lost"):
            raise self._lost("a scheduler that stays", "a lost connection")
        try:
            program, outcome = future.result()
        except self._dask.KilledWorker:
            return Finished(task, refused(DIED, is_system=self._is_system), lasting=False)
        if program != program_hash():
            raise self._lost("workers with this version of the program", "another version")
        return Finished(task, outcome)

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
