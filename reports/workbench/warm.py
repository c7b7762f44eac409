"""Everything that jobs need, imported and used once, in the process that workers are forked from.

What is built on first use (validators of tables, caches) is then there in every worker from its first job on.
"""

from __future__ import annotations

import gc
import json

from nonsmooth.proofs.clauses.workspace import unheard
from nonsmooth.reports.output.processes import GARBAGE_THRESHOLD
from nonsmooth.reports.workbench import worker
from nonsmooth.reports.workbench.documents import document_of
from nonsmooth.reports.workbench.jobs import view

__all__ = ["worker"]

STARTS = {"four-wheel": [0.1, 0.1, 0.0], "relay-oscillator": [0.1, 0.1]}


def _warm_up() -> None:
    gc.set_threshold(GARBAGE_THRESHOLD)
    for name, start in STARTS.items():
        request = {"document": document_of(name), "starts": [start]}
        for _ in view(json.dumps(request).encode(), unheard):
            pass


_warm_up()
