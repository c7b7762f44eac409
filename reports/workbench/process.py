"""One worker process as the server sees it: jobs go in, messages come out, and it can be killed."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress

from nonsmooth.reports.processes import Context
from nonsmooth.reports.workbench.worker import serve

WARM = "nonsmooth.reports.workbench.warm"  # what the server of forks imports


class Process:
    """A worker and the connection to it; to be made where an event loop runs.

    Attributes:
        jobs: how many it was given.
        is_gone: whether the process has ended.
    """

    def __init__(self, context: Context) -> None:
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self.jobs, self.is_gone = 0, False
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
            with suppress(RuntimeError):  # the loop is closed: nobody waits
                self._loop.call_soon_threadsafe(self._messages.put_nowait, message)

    def send(self, message: bytes) -> None:
        """Hand over a job, or with an empty message cancel the one that runs."""
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
