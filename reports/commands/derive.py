"""``nonsmooth derive``: the derivation report."""

from __future__ import annotations

from nonsmooth.reports.derivations.derivation import DERIVE
from nonsmooth.reports.studies.study_command import command

derive = command(
    DERIVE,
    "derive",
    """Write the derivation report; without -o, as Markdown to standard output.

    Of a plain system in two states: its cells, borders, Lyapunov function or leading terms, and phase portrait.

    Exit status: 0 written, whatever the verdict; 2 bad input.
    """,
)
