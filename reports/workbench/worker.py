"""A worker: one process that does the jobs of the page one after the other, and can be told to stop.

A job arrives as its name and the bytes of the request; its answers go back as lines of JSON, and an empty message ends
it.  An empty message from the server while a job runs cancels it: the worker looks for one at every step, and every
few milliseconds of exact arithmetic.
"""

from __future__ import annotations

import gc
import json
import os
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any, TypeAlias

from nonsmooth.reports.processes import begin_process

Announce: TypeAlias = Callable[[str], None]

END = b""
CANCELLED = "cancelled"
MEMORY = 4 << 30  # bytes of address space; a job beyond it is refused


class CancelledError(BaseException):
    """The server wants this job no more; no step of it may take that for an error of its own."""


def serve(connection: Connection) -> None:
    """Do jobs until the server is gone, or wants no more.

    Args:
        connection: to the server.
    """
    begin_process()
    _limit_memory()
    gc.freeze()  # what is imported is never garbage
    try:
        while True:
            job = connection.recv_bytes()
            if job != END:
                _do(connection, job)
                connection.send_bytes(END)
    except (EOFError, OSError):
        os._exit(0)


def _limit_memory() -> None:
    try:
        import resource
    except ImportError:  # not on Windows
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY if hard < 0 else min(MEMORY, hard), hard))


def _do(connection: Connection, job: bytes) -> None:
    name, _, body = job.partition(b"\n")

    def look_up(step: str) -> None:
        """Between two steps: end the job if the server wants it no more."""
        del step
        if connection.poll():
            connection.recv_bytes()
            raise CancelledError

    try:
        for message in answers(name.decode(), body, look_up):
            connection.send_bytes(encoded(message))
    except CancelledError:
        connection.send_bytes(encoded({"stage": CANCELLED}))


def answers(name: str, body: bytes, look_up: Announce) -> Iterator[dict[str, Any]]:
    """The answers of a job; whatever is wrong with it is one of them.

    Args:
        name: of the job.
        body: of the request.
        look_up: is called between steps; it may end the job by an exception that is no :class:`Exception`.
    """
    from nonsmooth.reports.workbench.jobs import JOBS  # here and in who forks workers: the server computes nothing
    from nonsmooth.reports.workbench.refusals import refusal

    try:
        yield from JOBS[name](body, look_up)
    except (EOFError, ConnectionError):  # the server is gone, and with it what it did not read
        raise
    except Exception as error:
        yield refusal(error)
    yield {"stage": "done"}


def encoded(message: dict[str, Any]) -> bytes:
    """A message as one line of JSON."""
    return json.dumps(message, allow_nan=False, separators=(",", ":")).encode() + b"\n"
