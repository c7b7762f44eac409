"""A worker of the page: the jobs it does, and what they answer.

A job arrives as its name and the bytes of the request; its answers go back as lines of JSON.  The worker looks whether
the page still wants it at every step, and every few milliseconds of exact arithmetic.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import TypeAlias

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.processes import serve

Announce: TypeAlias = Callable[[str], None]

CANCELLED = "cancelled"
MEMORY = 4 << 30  # bytes of address space; a job beyond it is refused


def serve_page(connection: Connection) -> None:
    """Do jobs of the page.

    Args:
        connection: to the server.
    """
    _limit_memory()
    serve(connection, _lines)


def _limit_memory() -> None:
    try:
        import resource
    except ImportError:  # not on Windows
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY if hard < 0 else min(MEMORY, hard), hard))


def _lines(job: bytes, look_up: Callable[[], None]) -> Iterator[bytes]:
    """The answers of a job as lines of JSON."""
    name, _, body = job.partition(b"\n")
    for message in answers(name.decode(), body, lambda step: look_up()):
        yield encoded(message)


def answers(name: str, body: bytes, look_up: Announce) -> Iterator[Record]:
    """The answers of a job; whatever is wrong with it is one of them.

    Args:
        name: of the job.
        body: of the request.
        look_up: is called between steps; it may end the job by an exception that is no :class:`Exception`.
    """
    # here and in who forks workers: the server computes nothing
    from nonsmooth.reports.workbench.jobs import JOBS, refusal

    try:
        yield from JOBS[name](body, look_up)
    except (EOFError, ConnectionError):  # the server is gone, and with it what it did not read
        raise
    except Exception as error:
        yield refusal(error)
    yield {"stage": "done"}


def encoded(message: Record) -> bytes:
    """A message as one line of JSON."""
    return json.dumps(message, allow_nan=False, separators=(",", ":")).encode() + b"\n"
