"""What long work says of itself while it is under way: one call, from any depth, that costs next to nothing.

The work calls :func:`tell` with a few words, such as ``t = 12.5 of 60``, wherever it comes round to it: once per step
of an integrator, per cell, per start.  Whoever watches (:mod:`nonsmooth.reports.output.progress` shows it on a
terminal) listens by :func:`listening`; where nobody does, nothing happens.  What is told never changes what is
computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeAlias

Listener: TypeAlias = Callable[[str], None]

# Each thread has its own: the workbench's workers are silent while a command of the same process is watched.
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


def tell(what: str) -> None:
    """Say what is being done now, in a few words without an end of line."""
    listener = _listener.get()
    if listener is not None:
        listener(what)


def is_watched() -> bool:
    """Whether anybody listens: words that are put together often wait for it."""
    return _listener.get() is not None


def tell_count(done: int, total: int, what: str) -> None:
    """Say how much is done: ``12 of 40 cells``."""
    tell(f"{done} of {total} {what}")


@contextmanager
def part_of(done: int, total: int, what: str) -> Iterator[None]:
    """Say how much is done, and say it before all that is told until the end of the block."""
    with parts() as say:
        say(f"{done} of {total} {what}")
        yield


@contextmanager
def parts() -> Iterator[Listener]:
    """A function to say which part is under way; it is said before all that is told until the next one."""
    listener, part = _listener.get(), ""
    if listener is None:
        yield lambda _: None
        return

    def say(what: str) -> None:
        nonlocal part
        part = what
        listener(part)

    with listening(lambda more: listener(f"{part}, {more}" if part else more)):
        yield say


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Hear what is told until the end of the block; only the innermost listener does."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)
