"""Progress of long work on standard error: one line of a terminal, once the work has lasted a second.

``simulate: t = 12.5 of 60 (7 s)``: the step under way, what the work itself tells
(:func:`nonsmooth.symbolic.messages.under_way.tell`, from any depth), and the seconds since the start.  A thread that
does nothing but write keeps the seconds going.  Where standard error is a file, a pipe or a terminal that cannot clear
a line, commands write such a line below the other, one every ten seconds: a log shows that and where they go on.  Every
command has such a line (:func:`nonsmooth.reports.output.console.run` begins it); :func:`steps` names a step of it,
:func:`progress` counts what is done of a known total.  In Python, outside of a command, these two begin a line of their
own.  On a terminal the line ends, and leaves nothing behind, with the work or as soon as standard output is written.
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

from nonsmooth.symbolic.messages.under_way import listening, parts

PATIENCE = 1.0  # seconds that pass before anything is shown
TICK = 0.25  # seconds between two lines
LOGGED = 10.0  # seconds before the first line of a log, and between two
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
    """A function to call from the work with what is done of a total; nothing is left on the terminal afterwards."""
    with steps(what), parts() as say:

        def report(done: int, total: int, what: str | None = None) -> None:
            count = f"{done} of {total}" if total else f"{done}" if done else ""
            say(": ".join(part for part in (what, count) if part))

        yield report


@contextmanager
def steps(first: str, *, log: bool = False) -> Iterator[Callable[[str], None]]:
    """A function to call with the name of each step; nothing is left on the terminal afterwards.

    Args:
        first: the name of the first step.
        log: whether lines are written below each other where standard error is no terminal.
    """
    line = _StepLine.current
    if line is not None and line.is_shown:
        around = line.step
        line.name(first)
        try:
            yield line.name
        finally:
            line.name(around)
        return
    stream, is_log = _terminal(), log and sys.stderr is sys.__stderr__  # no buffer of somebody who calls a command
    if stream is not None:
        line = _StepLine(stream, first)
    elif is_log and sys.stderr is not None:
        line = _LogLines(sys.stderr, first)
    else:
        yield lambda _: None
        return
    _StepLine.current = line
    line.start()
    try:
        with listening(line.add):
            yield line.name
    finally:
        line.stop()
        _StepLine.current = None


def end_progress() -> None:
    """Clear the line for good, before anything else is written to the terminal."""
    if _StepLine.current is not None:
        _StepLine.current.stop()


def notice(file: str, text: str) -> None:
    """Say something about a file on standard error."""
    end_progress()
    print(f"{file}: {text}", file=sys.stderr)


def _terminal() -> TextIO | None:
    """Standard error, where somebody watches it on a terminal that can clear a line."""
    watched = sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
    return sys.stderr if watched else None


class _StepLine:
    """One line of a terminal: the step under way, what it tells of itself, and the seconds since the start."""

    current: _StepLine | None = None  # of this process: a terminal has one last line
    shows_each = True  # step, however short it is

    def __init__(self, stream: TextIO, first: str) -> None:
        self._stream, self.step, self._told = stream, first, ""
        self._started = time.monotonic()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._show, daemon=True)
        self._writing = threading.Lock()  # two threads write: the one that works, and the one that counts seconds
        self._written = False

    @property
    def is_shown(self) -> bool:
        """Whether it has not ended."""
        return not self._ended.is_set()

    def start(self) -> None:
        """Show the first step, and begin to wait."""
        self.name(self.step)
        self._thread.start()

    def name(self, step: str) -> None:
        """Another step is under way.  Once patience is over it is shown at once, however short it is."""
        self.step, self._told = step, ""
        if self.is_shown and self.shows_each and time.monotonic() - self._started >= PATIENCE:
            self._write_step()

    def add(self, told: str) -> None:
        """What the step tells of itself: shown with the next tick, as it may change a thousand times a second."""
        self._told = told

    def stop(self) -> None:
        """End, and clear the line."""
        if not self.is_shown:
            return
        self._ended.set()
        self._thread.join()
        if self._written:
            self._write("")

    def _show(self) -> None:
        """Write until the end, once patience is over."""
        waited, tick = self._pace()
        while not self._ended.wait(waited):
            self._write_step()
            waited = tick

    def _pace(self) -> tuple[float, float]:
        """Seconds before the first line, and between two."""
        return PATIENCE, TICK

    def _write_step(self) -> None:
        """Name the step and what it tells, and the whole seconds since the start, which are seen on any width."""
        said = ": ".join(part for part in (self.step, self._told) if part)
        seconds = f" ({time.monotonic() - self._started:.0f} s)"
        self._write(self._fitted(said, seconds))

    def _fitted(self, said: str, seconds: str) -> str:
        """Both within the width of the terminal."""
        return said[: max(shutil.get_terminal_size().columns - 1 - len(seconds), 0)] + seconds

    def _write(self, text: str) -> None:
        """Replace the line."""
        with self._writing:
            self._written = True
            self._stream.write(CLEAR_LINE + text)
            self._stream.flush()


class _LogLines(_StepLine):
    """The same in a log: whole lines, now and then, which stay."""

    shows_each = False

    def _pace(self) -> tuple[float, float]:
        return LOGGED, LOGGED

    def _fitted(self, said: str, seconds: str) -> str:
        return said + seconds  # a file is not as wide as a terminal

    def _write(self, text: str) -> None:
        if text:  # there is nothing to clear
            self._stream.write(f"{text}\n")
            self._stream.flush()
