"""Progress of long work on standard error: on a terminal only, and only once it has lasted a second."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

PATIENCE = 1.0  # seconds that pass before anything is shown


class Report(Protocol):
    """What the work calls: steps done, steps in all (0: not known), and what is done now, where that changes."""

    def __call__(self, done: int, total: int, what: str | None = None) -> None:
        """Show it, or do nothing."""
        ...


def silent(done: int, total: int, what: str | None = None) -> None:
    """Where nobody watches."""


@contextmanager
def progress(what: str = "") -> Iterator[Report]:
    """A function to call from the work; nothing is left on the terminal afterwards."""
    if sys.stderr is None or not sys.stderr.isatty():
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
