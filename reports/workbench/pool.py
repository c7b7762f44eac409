"""Worker processes for the page: a newer request of the same tab cancels the older one; who does not stop is killed."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing import get_all_start_methods, get_context
from multiprocessing.context import BaseContext
from typing import Any

from nonsmooth.reports.workbench.worker import END, encoded, serve

GRACE = 0.1  # seconds that a cancelled job has to end before its worker is killed
MOST_WAITING = 32  # jobs that wait for a worker; more are refused
CANCELLED = encoded({"stage": "cancelled"})


class BusyError(Exception):
    """More jobs wait than are kept."""


class Worker:
    """One process and the connection to it."""

    def __init__(self, context: BaseContext) -> None:
        ours, theirs = context.Pipe()
        self._connection = ours
        self._process = context.Process(target=serve, args=(theirs,), daemon=True)  # type: ignore[attr-defined]
        self._process.start()
        theirs.close()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="worker")
        self.jobs = 0

    def send(self, message: bytes) -> None:
        """Hand over a job, or with an empty message cancel the one that runs."""
        with suppress(OSError):  # a worker that died is noticed by who receives
            self._connection.send_bytes(message)

    async def receive(self) -> bytes:
        """The next message.

        Raises:
            EOFError: where the process is gone.
        """
        try:
            return await asyncio.get_running_loop().run_in_executor(self._thread, self._connection.recv_bytes)
        except OSError:
            raise EOFError from None

    def kill(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self._thread.shutdown(wait=True)
        self._connection.close()


class Job:
    """One request under way."""

    def __init__(self) -> None:
        self.cancelled = asyncio.Event()


class Pool:
    """A few warm workers.

    Args:
        count: how many.
    """

    def __init__(self, count: int) -> None:
        self._context, self._count = _start_method(), count
        self._idle: asyncio.Queue[Worker] = asyncio.Queue()
        self._workers: set[Worker] = set()
        self._waiting = 0
        self._tabs: dict[str, Job] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self) -> None:
        """Start the workers."""
        for _ in range(self._count):
            self._add()

    def _add(self) -> None:
        worker = Worker(self._context)
        self._workers.add(worker)
        self._idle.put_nowait(worker)

    def close(self) -> None:
        """Kill all workers."""
        for worker in self._workers:
            worker.kill()
        self._workers.clear()

    async def run(self, name: str, body: bytes, seconds: float, tab: str | None = None) -> AsyncIterator[bytes]:
        """The messages of a job, each one line of JSON.

        Args:
            name: of the job.
            body: of the request.
            seconds: after which it is given up.
            tab: whose older job this one cancels.

        Raises:
            BusyError: where too many jobs wait.
        """
        job = Job()
        if tab is not None:
            older = self._tabs.pop(tab, None)
            if older is not None:
                older.cancelled.set()
            self._tabs[tab] = job
        try:
            async for message in self._run(job, name, body, seconds):
                yield message
        finally:
            if tab is not None and self._tabs.get(tab) is job:
                del self._tabs[tab]

    async def _run(self, job: Job, name: str, body: bytes, seconds: float) -> AsyncIterator[bytes]:
        worker = await self._take(job)
        if worker is None:
            yield CANCELLED
            return
        pending: asyncio.Task[bytes] | None = None
        ended = False
        stop = asyncio.ensure_future(job.cancelled.wait())
        try:
            worker.send(name.encode() + b"\n" + body)
            deadline = asyncio.get_running_loop().time() + seconds
            while True:
                pending = asyncio.ensure_future(worker.receive())
                left = deadline - asyncio.get_running_loop().time()
                await asyncio.wait({pending, stop}, timeout=max(left, 0), return_when=asyncio.FIRST_COMPLETED)
                if job.cancelled.is_set():
                    yield CANCELLED
                    return
                if not pending.done():
                    yield encoded({"stage": "error", "message": _too_long(seconds), "key": None})
                    return
                try:
                    message = pending.result()
                except EOFError:
                    yield encoded({"stage": "error", "message": "the worker of this job ended; try again", "key": None})
                    return
                if message == END:
                    ended = True
                    return
                yield message
        finally:
            stop.cancel()
            self._give_back(worker, pending, ended=ended)

    async def _take(self, job: Job) -> Worker | None:
        """An idle worker; None where the job is cancelled before there is one.

        Raises:
            BusyError: where too many jobs wait.
        """
        if self._idle.empty() and self._waiting >= MOST_WAITING:
            raise BusyError
        self._waiting += 1
        try:
            getting, stop = asyncio.ensure_future(self._idle.get()), asyncio.ensure_future(job.cancelled.wait())
            try:
                await asyncio.wait({getting, stop}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                stop.cancel()
                if not getting.done():
                    getting.cancel()
            if job.cancelled.is_set():
                if getting.done() and not getting.cancelled():
                    self._idle.put_nowait(getting.result())
                return None
            return getting.result()
        finally:
            self._waiting -= 1

    def _give_back(self, worker: Worker, pending: asyncio.Task[bytes] | None, *, ended: bool) -> None:
        if ended:
            self._idle.put_nowait(worker)
            return
        task = asyncio.ensure_future(self._stop(worker, pending))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _stop(self, worker: Worker, pending: asyncio.Task[bytes] | None) -> None:
        """Let a cancelled job end, or kill its worker."""
        worker.send(END)
        try:
            async with asyncio.timeout(GRACE):
                while True:
                    message = await asyncio.shield(pending or asyncio.ensure_future(worker.receive()))
                    pending = None
                    if message == END:
                        self._idle.put_nowait(worker)
                        return
        except (TimeoutError, EOFError):
            self._workers.discard(worker)
            await asyncio.to_thread(worker.kill)
            self._add()


def _too_long(seconds: float) -> str:
    return f"required a scene whose check takes at most {seconds:g} s, received one that takes longer"


def _start_method() -> Any:
    """A server that has imported what jobs need and forks workers, where there is one: a new worker costs little."""
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload(["nonsmooth.reports.workbench.warm"])
    return context
