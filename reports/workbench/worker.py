"""A worker: one process that does the jobs of the page one after the other, and can be told to stop.

A job arrives as its name and the bytes of the request; its answers go back as lines of JSON, and an empty message ends
it.  An empty message from the server while a job runs cancels it: the worker looks for one at every step.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import sys
import traceback
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.reports.workbench.jobs import JOBS
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.scene_error import SceneError

END = b""
GARBAGE_THRESHOLD = 200_000  # as the command line sets it: there are few cycles
MEMORY = 3 << 30  # bytes of address space; a job beyond it is refused


class CancelledError(BaseException):
    """The server wants this job no more; no step of it may take that for an error of its own."""


def serve(connection: Connection) -> None:
    """Do jobs until the server is gone.

    Args:
        connection: to the server.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.set_threshold(GARBAGE_THRESHOLD)
    _limit_memory()
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

    def look_up(step: str = "") -> None:
        """Between two steps: end the job if the server wants it no more."""
        del step
        if connection.poll():
            connection.recv_bytes()
            raise CancelledError

    try:
        for message in _messages(name.decode(), body, look_up):
            connection.send_bytes(encoded(message))
    except CancelledError:
        connection.send_bytes(encoded({"stage": "cancelled"}))


def _messages(name: str, body: bytes, look_up: Any) -> Iterator[dict[str, Any]]:
    """The answers of a job; whatever is wrong ends in one message of stage ``error``."""
    try:
        yield from JOBS[name](body, look_up)
    except SceneError as error:
        yield {"stage": "error", "message": str(error), "key": error.key.replace("[", ".").replace("]", "") or None}
    except RequestError as error:
        yield {"stage": "error", "message": str(error), "key": error.key}
    except (RefusalError, ValueError, ArithmeticError) as error:
        yield {"stage": "error", "message": str(error), "key": None}
    except MemoryError:
        yield {
            "stage": "error",
            "message": "required a scene that fits into memory, received a larger one",
            "key": None,
        }
    except (EOFError, BrokenPipeError):
        raise
    except Exception:
        traceback.print_exc(file=sys.stderr)
        yield {"stage": "error", "message": "a fault of the program; its log has the traceback", "key": None}


def encoded(message: dict[str, Any]) -> bytes:
    """A message as one line of JSON."""
    return json.dumps(message, allow_nan=False, separators=(",", ":")).encode() + b"\n"
