"""``nonsmooth design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

from nonsmooth.reports.designs.design import DESIGN
from nonsmooth.reports.studies.study_command import command

design = command(
    DESIGN,
    "design",
    """Search for the headings, speeds and positions of the wheels that meet requirements and do best.

    Exit status: 0 found, 1 nothing found that meets the requirements, 2 bad input.
    """,
)
