"""Processes that compute for this one: how they are started, and how they end with it."""

from __future__ import annotations

import gc
import os
import signal
import threading
from multiprocessing import get_all_start_methods, get_context, parent_process
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import TypeAlias

Context: TypeAlias = ForkServerContext | SpawnContext

GARBAGE_THRESHOLD = 200_000  # as the command line sets it: there are few cycles


def starting_with(module: str) -> Context:
    """Fresh processes that copy neither our threads nor our locks.

    Where there is one, a server that has imported the module forks them: then another process costs little.
    """
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([module])
    return context


def begin_process() -> None:
    """In a new process: leave interrupts to the one that started it, and end with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.set_threshold(GARBAGE_THRESHOLD)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End once the process that started this one is gone: it may have been killed, and then tells nobody."""
    parent = parent_process()
    if parent is not None:
        parent.join()
    os._exit(0)
