"""Progress of long work on standard error: on a terminal only, and only once it has lasted a second.

:func:`progress` counts what is done of a known total.  :func:`steps` names the step under way, where each is one long
computation; a thread that does nothing but write keeps the seconds going.
"""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO

PATIENCE = 1.0  # seconds that pass before anything is shown
TICK = 0.25  # seconds between two lines of steps
CLEAR_LINE = "\r\x1b[K"


class ProgressCall(Protocol):
    """What the work calls: steps done, steps in all (0: not known), and what is done now, where that changes."""

    def __call__(self, done: int, total: int, what: str | None = None) -> None:
        """Show it, or do nothing."""
        ...


def silent(done: int, total: int, what: str | None = None) -> None:
    """Where nobody watches."""


@contextmanager
def progress(what: str = "") -> Iterator[ProgressCall]:
    """A function to call from the work; nothing is left on the terminal afterwards."""
    if _terminal() is None:
        yield silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True, markup=False, highlight=False, emoji=False)
    columns = (BarColumn(bar_width=20), MofNCompleteColumn(), TimeElapsedColumn())
    started = time.monotonic()
    with Progress(*columns, TextColumn("{task.description}", markup=False), console=console, transient=True) as bar:
        task = bar.add_task(what, total=None, visible=False)

        def report(done: int, total: int, what: str | None = None) -> None:
            visible = time.monotonic() - started > PATIENCE
            bar.update(task, description=what, completed=done, total=total or None, visible=visible)

        yield report


@contextmanager
def steps(first: str) -> Iterator[Callable[[str], None]]:
    """A function to call with the name of each step; nothing is left on the terminal afterwards."""
    stream = _terminal()
    if stream is None or os.environ.get("TERM") == "dumb":
        yield lambda _: None
        return
    line = _StepLine(stream, first)
    line.start()
    try:
        yield line.name
    finally:
        line.stop()


def _terminal() -> TextIO | None:
    """Standard error, where somebody watches it."""
    return sys.stderr if sys.stderr is not None and sys.stderr.isatty() else None


class _StepLine:
    """One line of a terminal: the step under way, and the seconds since the start."""

    def __init__(self, stream: TextIO, first: str) -> None:
        self._stream, self._step = stream, first
        self._started = time.monotonic()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._show, daemon=True)
        self._writing = threading.Lock()  # two threads write: the one that works, and the one that counts seconds
        self._written = False

    def start(self) -> None:
        """Begin to wait."""
        self._thread.start()

    def name(self, step: str) -> None:
        """Another step is under way.  Once patience is over it is shown at once, however short it is."""
        self._step = step
        if time.monotonic() - self._started >= PATIENCE:
            self._write_step()

    def stop(self) -> None:
        """End, and clear the line."""
        self._ended.set()
        self._thread.join()
        if self._written:
            self._write("")

    def _show(self) -> None:
        """Write until the end, once patience is over."""
        waited = PATIENCE
        while not self._ended.wait(waited):
            self._write_step()
            waited = TICK

    def _write_step(self) -> None:
        """Name the step, and the whole seconds since the start."""
        text = f"{self._step} ({time.monotonic() - self._started:.0f} s)"
        self._write(text[: shutil.get_terminal_size().columns - 1])

    def _write(self, text: str) -> None:
        """Replace the line."""
        with self._writing:
            self._written = True
            self._stream.write(CLEAR_LINE + text)
            self._stream.flush()
