"""``nonsmooth check``: Theorem 4 clause by clause, or the stability of a plain switched system."""

from __future__ import annotations

from nonsmooth.reports.checks.check import CHECK
from nonsmooth.reports.output.study_options import SceneTexts
from nonsmooth.reports.studies.study_command import command

check = command(
    CHECK,
    "check",
    """Check Theorem 4 clause by clause, or the stability of a plain switched system; of many scenes in one table.

    Exit status: 0 holds (or stable), 1 fails, hypotheses not met, or tips, 2 bad input, 3 undecided; of many the worst.
    """,
    SceneTexts,
)
