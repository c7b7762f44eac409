"""The contact rules side by side, as a script or a notebook holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.minimizers.agreement import Agreement, compare_rules
from nonsmooth.reports.agreement_views import (
    agreement_blocks,
    agreement_record,
    build_figure,
    difference_text,
    draw_pair,
)
from nonsmooth.reports.document import Block
from nonsmooth.reports.result import DataTable, Record, Result
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.number_text import short_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class ComparisonResult(Result):
    """Where the contact rules move a body alike on the checked square.

    Attributes:
        agreement: shares of the area (exact) for rules with cells, sampled differences beside rules without.
    """

    agreement: Agreement

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth partition --compare --json``."""
        return agreement_record(self.agreement)

    def table(self) -> DataTable:
        """One line for each pair of rules: what is compared, and what was found."""
        what, lines = "same motion on a share of the area", []
        for pair, shared in self.agreement.shared.items():
            lines.append((" and ".join(pair), what, short_text(shared.share)))
        for pair, difference in self.agreement.differences.items():
            lines.append((" and ".join(pair), "sampled", difference_text(difference)))
        return DataTable(("rules", "what", "found"), lines)

    def draw(self, ax: Axes) -> None:
        """Where the first two rules with cells prescribe the same motion."""
        draw_pair(ax, self.agreement, *next(iter(self.agreement.shared)))

    def figure(self) -> Figure:
        """The rules side by side."""
        return build_figure(self.agreement)

    def blocks(self) -> Sequence[Block]:
        """Shares and differences."""
        return agreement_blocks(self.agreement)

    def summary(self) -> str:
        """The shares of the area on which rules agree."""
        shared = self.agreement.shared.items()
        return "; ".join(f"rules {a} and {b} agree on a share of {found.share}" for (a, b), found in shared)

    def __repr__(self) -> str:
        said = [(row["rules"], f"{row['what']} {row['found']}") for row in self.rows()]
        return short_lines(f"contact rules on {next(iter(self.agreement.partitions.values())).scene.name}", said)


def compare_scene(scene: Scene) -> ComparisonResult:
    """Compare all contact rules on the square of an array.

    Raises:
        RefusalError: where the motion is not determined.
    """
    return ComparisonResult(compare_rules(scene))
