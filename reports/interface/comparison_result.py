"""The contact rules side by side, as a script or a notebook holds them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.minimizers.agreement import Agreement, compare_rules
from nonsmooth.reports.agreement_views import agreement_map, agreement_record, difference_text
from nonsmooth.reports.files import PICTURES, output_path, write_whole
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.number_text import short_text

if TYPE_CHECKING:
    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class ComparisonResult(Tabular):
    """Where the contact rules move a body alike on the checked square.

    Attributes:
        agreement: shares of the area (exact) for rules with cells, sampled differences beside rules without.
    """

    agreement: Agreement

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth partition --compare --json``."""
        return agreement_record(self.agreement)

    def rows(self) -> list[dict[str, str]]:
        """One row for each pair of rules: what is compared, and what was found."""
        exact = [
            {
                "rules": " and ".join(pair),
                "what": "same motion on a share of the area",
                "found": short_text(shared.share),
            }
            for pair, shared in self.agreement.shared.items()
        ]
        sampled = [
            {"rules": " and ".join(pair), "what": "sampled", "found": difference_text(difference)}
            for pair, difference in self.agreement.differences.items()
        ]
        return [*exact, *sampled]

    def picture(self, suffix: str = ".svg") -> bytes:
        """The rules side by side, as the bytes of a picture file."""
        return agreement_map(self.agreement, suffix)

    def save(self, file: str | Path) -> Path:
        """Draw into a file whose name ends in .svg, .png or .pdf.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), PICTURES)
        write_whole(path, self.picture(path.suffix.lower()))
        return path

    def __repr__(self) -> str:
        said = [(row["rules"], f"{row['what']} {row['found']}") for row in self.rows()]
        return short_lines(f"contact rules on {next(iter(self.agreement.partitions.values())).scene.name}", said)


def compare_scene(scene: Scene) -> ComparisonResult:
    """Compare all contact rules on the square of an array.

    Raises:
        RefusalError: where the motion is not determined.
    """
    return ComparisonResult(compare_rules(scene))
