"""Progress of long work on standard error: on a terminal only, and only once it has lasted a second."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

PATIENCE = 1.0  # seconds that pass before anything is shown

Report: TypeAlias = Callable[[int, int], None]


@contextmanager
def progress(what: str) -> Iterator[Report]:
    """A function ``report(done, total)`` to call from the work; nothing is left on the terminal afterwards."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    started = time.monotonic()
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None, visible=False)

        def report(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, visible=time.monotonic() - started > PATIENCE)

        yield report
