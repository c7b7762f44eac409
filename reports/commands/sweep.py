"""``nonsmooth sweep``: many scenes that differ in a few numbers."""

from __future__ import annotations

from nonsmooth.reports.studies.study_command import command
from nonsmooth.reports.sweeps.sweep_study import SWEEP

sweep = command(
    SWEEP,
    "sweep",
    """Check many scenes that differ in a few numbers: a table, strips or a map of answers, and where they change.

    Exit status: 0 done, 2 bad input.
    """,
)
