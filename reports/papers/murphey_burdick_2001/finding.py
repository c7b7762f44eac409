"""One finding of the audit: what the paper prints, what was computed, and what follows."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from nonsmooth.reports.document import Block, Paragraph, Section, Text


class ClaimOutcome(StrEnum):
    """How a printed claim fares."""

    CONFIRMED = "confirmed"
    CORRECTED = "true after a correction"
    STRENGTHENED = "conclusion right, argument completed"
    REFUTED = "refuted"


@dataclass(frozen=True)
class Finding:
    """A printed claim against the computation.

    Attributes:
        item: number of the finding.
        title: its subject.
        outcome: how the claim fares.
        claim: as printed.
        computed: what was computed, with formulas and tables.
        conclusion: what follows.
    """

    item: int
    title: str
    outcome: ClaimOutcome
    claim: Text
    computed: tuple[Block, ...]
    conclusion: Text

    def section(self) -> Section:
        """The finding as a part of a report."""
        claim, conclusion = Paragraph(("Printed: ", *self.claim)), Paragraph(("Finding: ", *self.conclusion))
        return Section(f"{self.title}: {self.outcome}", (claim, *self.computed, conclusion))
