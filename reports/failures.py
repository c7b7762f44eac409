"""The answers with any one wheel failed, as a table of a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.answers.failures import Failure, worst_failure
from nonsmooth.reports.terminal import header_table, verdict_text


def failures_view(failures: Sequence[Failure]) -> RenderableType:
    """Wheel by wheel, and the worst by name."""
    table = header_table("wheel", "failure", "position", "heading", "pose", "why")
    for failure in failures:
        answers = map(verdict_text, (failure.position, failure.heading, failure.pose))
        table.add_row(Text(str(failure.wheel)), Text(failure.kind), *answers, Text(failure.why))
    worst = worst_failure(tuple(failures))
    head = Text("with any one wheel stopped (its friction stays) or lifted:")
    said = f"the worst: {worst.name}: position {worst.position}, heading {worst.heading}, pose {worst.pose}"
    return Group(head, table, Text(said, "bold"))
