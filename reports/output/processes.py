"""Processes that compute for this one: a pool of workers, each killed alone, and what a worker does.

A worker does one job after the other.  A job goes in as bytes, its messages come back as bytes, and an empty message
ends it.  An empty message to the worker while a job runs asks it to stop; one that does not is killed, and another
takes its place.  Sweeps (``nonsmooth.reports.sweeps.workers``) and the page of the workbench share this pool.
"""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import threading
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterator
from contextlib import suppress
from multiprocessing import get_all_start_methods, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import TypeAlias, TypeVar

Target: TypeAlias = Callable[[Connection], None]  # what a worker runs, told the connection to its pool
Answers: TypeAlias = Callable[[bytes, Callable[[], None]], Iterator[bytes]]
Kind = TypeVar("Kind")

END = b""
GARBAGE_THRESHOLD = 200_000  # as the command line sets it: there are few cycles
GRACE = 0.15  # seconds that a job has to end before its worker is killed
STARTS = 3  # tries to start a worker, where what forks them is killed at that moment


class StoppedError(Exception):
    """A job that came to no end of its own: nobody wants it any more."""


class JobTimeoutError(StoppedError):
    """A job that took too long."""


class DiedError(StoppedError):
    """A job whose worker was killed, or ended."""


# ---- in this process -----------------------------------------------------------------------------


class Process:
    """A worker and the connection to it; to be made where an event loop runs.

    Attributes:
        jobs: how many it was given.
        is_gone: whether the process has ended.
        was_ready: whether it ever was ready to work.
    """

    def __init__(self, context: ForkServerContext | SpawnContext, target: Target) -> None:
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=target, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self.jobs, self.is_gone, self.was_ready = 0, False, False
        self._messages: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        """In a thread: hand every message to the event loop, and None once the process is gone."""
        message: bytes | None = b""
        while message is not None:
            try:
                message = self._connection.recv_bytes()
            except (EOFError, OSError):
                message, self.is_gone = None, True
            if not self.was_ready and message is not None:
                self.was_ready = True  # the first message says no more
                continue
            with suppress(RuntimeError):  # the loop is closed: nobody waits
                self._loop.call_soon_threadsafe(self._messages.put_nowait, message)

    def send(self, message: bytes) -> None:
        """Hand over a job, or with an empty message ask the one that runs to stop."""
        with suppress(OSError):  # that it died is noticed by who receives
            self._connection.send_bytes(message)

    async def receive(self) -> bytes | None:
        """The next message; None once the process is gone."""
        return await self._messages.get()

    def kill(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self._thread.join()
        self._connection.close()
        self._process.close()


class WorkerPool:
    """A few warm workers, for one event loop.

    Args:
        target: what a worker runs: :func:`serve` with the answers to jobs; a function that can be pickled.
        count: of workers at most; they are started as jobs need them.
        preload: the module that is imported once, in the process that forks the workers.
        most_jobs: after which a worker is replaced, whatever caches it has filled; any number unless given.

    Attributes:
        waiting: how many jobs wait for a worker.
        was_ready: whether any worker ever was ready to work.
    """

    def __init__(self, target: Target, count: int, *, preload: str, most_jobs: int | None = None) -> None:
        self._target, self._count, self._most_jobs = target, count, most_jobs
        self._context = _starting_with(preload)
        self._idle: asyncio.LifoQueue[Process] = asyncio.LifoQueue()  # the last one's caches are still warm
        self._workers: set[Process] = set()
        self._stopping: set[asyncio.Task[None]] = set()
        self.waiting, self.was_ready = 0, False

    def start(self) -> None:
        """Start all workers before there is a job."""
        while len(self._workers) < self._count:
            self._add()

    def close(self) -> None:
        """Kill all workers."""
        while self._workers:
            self._workers.pop().kill()

    async def run(
        self, job: bytes, *, seconds: float | None = None, cancelled: asyncio.Event | None = None
    ) -> AsyncGenerator[bytes, None]:
        """The messages of a job.

        Args:
            job: what is asked of a worker.
            seconds: after which it is given up.
            cancelled: is set by who wants it no more.

        Raises:
            StoppedError: where it is cancelled.
            JobTimeoutError: where it takes too long.
            DiedError: where its worker is killed.
        """
        unwanted = cancelled or asyncio.Event()
        worker, ended = await self._take(unwanted), False
        try:
            async for message in _messages(worker, job, seconds, unwanted):
                yield message
            ended = True
        finally:
            self.was_ready |= worker.was_ready
            self._give_back(worker, ended=ended)

    async def _take(self, cancelled: asyncio.Event) -> Process:
        """An idle worker; those that were killed meanwhile are replaced.

        Raises:
            StoppedError: where the job is cancelled before there is one.
        """
        self.waiting += 1
        try:
            for gone in [worker for worker in self._workers if worker.is_gone]:
                await self._replace(gone)
            if self._idle.empty() and len(self._workers) < self._count:
                self._add()
            worker = await _unless(cancelled, self._idle.get())
            while worker.is_gone:
                await self._replace(worker)
                worker = await _unless(cancelled, self._idle.get())
        finally:
            self.waiting -= 1
        worker.jobs += 1
        return worker

    def _give_back(self, worker: Process, *, ended: bool) -> None:
        """Keep a worker whose job has ended; stop the job of another one."""
        if worker not in self._workers:  # the pool is closed
            return
        is_spent = ended and worker.jobs == self._most_jobs
        if ended and not is_spent:
            self._idle.put_nowait(worker)
            return
        task = asyncio.ensure_future(self._replace(worker) if is_spent or worker.is_gone else self._stop(worker))
        self._stopping.add(task)
        task.add_done_callback(self._stopping.discard)

    async def _stop(self, worker: Process) -> None:
        """Let a job that nobody wants end, or kill its worker."""
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
        """Start a worker.

        Raises:
            EOFError: where what forks workers is killed again and again.
            ConnectionError: likewise.
        """
        for left in reversed(range(STARTS)):
            try:
                worker = Process(self._context, self._target)
            except (EOFError, ConnectionError):
                if not left:
                    raise
            else:
                self._workers.add(worker)
                self._idle.put_nowait(worker)
                return


def _starting_with(module: str) -> ForkServerContext | SpawnContext:
    """Fresh processes that copy neither our threads nor our locks.

    Where there is one, a server that has imported the module forks them: then another process costs little.
    """
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([module])
    return context


async def _messages(
    worker: Process, job: bytes, seconds: float | None, cancelled: asyncio.Event
) -> AsyncIterator[bytes]:
    """The messages of a job on a worker, until it says that it has ended.

    Raises:
        StoppedError: where it is cancelled, takes too long, or its process ends.
    """
    worker.send(job)
    deadline = None if seconds is None else asyncio.get_running_loop().time() + seconds
    while True:
        try:
            async with asyncio.timeout_at(deadline):
                message = await _unless(cancelled, worker.receive())
        except TimeoutError:
            raise JobTimeoutError from None
        if message is None:
            raise DiedError
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
        raise StoppedError
    finally:
        stop.cancel()
        found.cancel()


# ---- in a worker ---------------------------------------------------------------------------------


class CancelledError(BaseException):
    """Nobody wants this job any more; no step of it may take that for an error of its own."""


def serve(connection: Connection, answers: Answers) -> None:
    """Do jobs until the process that started this one is gone, or wants no more.

    Args:
        connection: to that process.
        answers: the messages of a job; it is told a function to call between steps, which raises
            :class:`CancelledError` where the job is wanted no more.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # interrupts are for the process that started this one
    gc.set_threshold(GARBAGE_THRESHOLD)
    gc.freeze()  # what is imported is never garbage
    threading.Thread(target=_end_with_parent, daemon=True).start()

    def look_up() -> None:
        if connection.poll():
            connection.recv_bytes()
            raise CancelledError

    try:
        connection.send_bytes(END)
        while True:
            job = connection.recv_bytes()
            if job == END:  # it came too late to stop the job before
                continue
            with suppress(CancelledError):
                for message in answers(job, look_up):
                    connection.send_bytes(message)
            connection.send_bytes(END)
    except (EOFError, OSError):
        os._exit(0)


def _end_with_parent() -> None:
    """End once the process that started this one is gone: it may have been killed, and then tells nobody."""
    parent = parent_process()
    if parent is not None:
        parent.join()
    os._exit(0)
