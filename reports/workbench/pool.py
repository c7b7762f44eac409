"""Worker processes for the page: a newer view of the same tab cancels the older one; who does not stop is killed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable
from contextlib import aclosing
from typing import Any, NamedTuple, TypeVar

from nonsmooth.reports.processes import starting_with
from nonsmooth.reports.workbench.process import WARM, Process
from nonsmooth.reports.workbench.worker import CANCELLED, END

GRACE = 0.15  # seconds that a cancelled job has to end before its worker is killed
MOST_WAITING = 32  # jobs that wait for a worker; more are refused
TRIES = 2  # of a job whose process dies before it has said anything
MOST_JOBS = 500  # after which a worker is replaced, whatever caches it has filled

Kind = TypeVar("Kind")


class Job(NamedTuple):
    """What is asked of a worker.

    Attributes:
        name: of the job.
        body: of the job.
        seconds: after which it is given up.
        sequence: number of the request in its tab, which every message repeats; None outside of tabs.
    """

    name: str
    body: bytes
    seconds: float
    sequence: int | None = None


class StoppedError(Exception):
    """A job that came to no end of its own.

    Attributes:
        stages: what there is to say of it, one message each.
    """

    def __init__(self, *stages: dict[str, Any]) -> None:
        super().__init__()
        self.stages = stages


class DiedError(StoppedError):
    """A job whose process ended."""


class WorkerPool:
    """A few warm workers.

    Args:
        count: how many.
    """

    def __init__(self, count: int) -> None:
        self._context, self._count = starting_with(WARM), count
        self._idle: asyncio.LifoQueue[Process] = asyncio.LifoQueue()  # the last one's caches are still warm
        self._workers: set[Process] = set()
        self._waiting = 0
        self._tabs: dict[str, asyncio.Event] = {}
        self._stopping: set[asyncio.Task[None]] = set()

    @property
    def is_full(self) -> bool:
        """Whether more jobs wait than are kept."""
        return self._waiting >= MOST_WAITING

    def start(self) -> None:
        """Start the workers."""
        for _ in range(self._count):
            self._add()

    def close(self) -> None:
        """Kill all workers."""
        while self._workers:
            self._workers.pop().kill()

    async def run(self, job: Job, tab: str | None = None) -> AsyncGenerator[bytes, None]:
        """The messages of a job, each one line of JSON; the last one is of stage ``done`` or ``cancelled``.

        Args:
            job: what is asked.
            tab: whose older job this one cancels.
        """
        cancelled = self._begin(tab)
        try:
            async with aclosing(self._tried(job, cancelled)) as messages:
                async for message in messages:
                    yield _numbered(message, job.sequence)
        except StoppedError as stopped:
            for stage in stopped.stages:
                yield _numbered(json.dumps(stage).encode() + b"\n", job.sequence)
        finally:
            if tab is not None and self._tabs.get(tab) is cancelled:
                del self._tabs[tab]

    async def _tried(self, job: Job, cancelled: asyncio.Event) -> AsyncGenerator[bytes, None]:
        """The messages of a job; where its process is killed before the first one, once more by another process.

        Raises:
            StoppedError: where it comes to no end of its own.
        """
        has_begun, tries = False, 0
        while True:
            worker, ended = await self._take(cancelled), False
            tries += 1
            try:
                async for message in _messages(worker, job, cancelled):
                    has_begun = True
                    yield message
                ended = True
            except DiedError:
                if has_begun or tries == TRIES:
                    raise
            finally:
                self._give_back(worker, ended=ended)
            if ended:
                return

    def _begin(self, tab: str | None) -> asyncio.Event:
        """The event that cancels a new job of a tab; that of its older job is set."""
        cancelled = asyncio.Event()
        if tab is not None:
            older = self._tabs.pop(tab, None)
            if older is not None:
                older.set()
            self._tabs[tab] = cancelled
        return cancelled

    async def _take(self, cancelled: asyncio.Event) -> Process:
        """An idle worker; those that were killed meanwhile are replaced.

        Raises:
            StoppedError: where the job is cancelled before there is one.
        """
        self._waiting += 1
        try:
            for gone in [worker for worker in self._workers if worker.is_gone]:
                await self._replace(gone)
            worker = await _unless(cancelled, self._idle.get())
            while worker.is_gone:
                await self._replace(worker)
                worker = await _unless(cancelled, self._idle.get())
        finally:
            self._waiting -= 1
        worker.jobs += 1
        return worker

    def _give_back(self, worker: Process, *, ended: bool) -> None:
        """Keep a worker whose job has ended; stop the job of another one."""
        if worker not in self._workers:  # the pool is closed
            return
        if ended and worker.jobs < MOST_JOBS:
            self._idle.put_nowait(worker)
            return
        is_useless = ended or worker.is_gone
        task = asyncio.ensure_future(self._replace(worker) if is_useless else self._stop(worker))
        self._stopping.add(task)
        task.add_done_callback(self._stopping.discard)

    async def _stop(self, worker: Process) -> None:
        """Let a cancelled job end, or kill its worker."""
        worker.send(END)
        try:
            async with asyncio.timeout(GRACE):
                message: bytes | None = b"unknown"
                while message:
                    message = await worker.receive()
        except TimeoutError:
            message = None
        if message == END:
            self._give_back(worker, ended=True)
        else:
            await self._replace(worker)

    async def _replace(self, worker: Process) -> None:
        """Kill a worker, and start another one."""
        if worker in self._workers:
            self._workers.discard(worker)
            self._add()
            await asyncio.to_thread(worker.kill)

    def _add(self) -> None:
        worker = Process(self._context)
        self._workers.add(worker)
        self._idle.put_nowait(worker)


async def _messages(worker: Process, job: Job, cancelled: asyncio.Event) -> AsyncIterator[bytes]:
    """The messages of a job on a worker, until it says that it has ended.

    Raises:
        StoppedError: where it is cancelled, takes too long, or its process ends.
    """
    worker.send(job.name.encode() + b"\n" + job.body)
    deadline = asyncio.get_running_loop().time() + job.seconds
    while True:
        try:
            async with asyncio.timeout_at(deadline):
                message = await _unless(cancelled, worker.receive())
        except TimeoutError:
            expected = f"required a scene whose view takes at most {job.seconds:g} s, received one that takes longer"
            raise StoppedError(*_error(expected)) from None
        if message is None:
            raise DiedError(*_error("the process of this computation ended (killed, or out of memory); try again"))
        if message == END:
            return
        yield message


async def _unless(cancelled: asyncio.Event, awaited: Awaitable[Kind]) -> Kind:
    """What is awaited.

    Raises:
        StoppedError: where the event is set before it has come.
    """
    stop, found = asyncio.ensure_future(cancelled.wait()), asyncio.ensure_future(awaited)
    try:
        await asyncio.wait({stop, found}, return_when=asyncio.FIRST_COMPLETED)
        if found.done():
            return found.result()
        raise StoppedError({"stage": CANCELLED})
    finally:
        stop.cancel()
        found.cancel()


def _error(text: str) -> tuple[dict[str, Any], dict[str, Any]]:
    return {"stage": "error", "message": text, "key": None}, {"stage": "done"}


def _numbered(message: bytes, sequence: int | None) -> bytes:
    """A message with the number of its job."""
    return message if sequence is None else b'{"sequence":%d,' % sequence + message.removeprefix(b"{")
