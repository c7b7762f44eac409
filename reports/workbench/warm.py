"""Everything that jobs need, imported and used once, in the process that workers are forked from.

What is built on first use (validators of tables, caches) is then there in every worker from its first job on.
"""

from __future__ import annotations

from nonsmooth.reports.interface.load import load
from nonsmooth.reports.workbench import worker
from nonsmooth.reports.workbench.array_view import array_stages

__all__ = ["worker"]


def _warm_up() -> None:
    array = load("four-wheel")
    for _ in array_stages(array, {}, lambda step: None):  # type: ignore[arg-type]
        pass


_warm_up()
