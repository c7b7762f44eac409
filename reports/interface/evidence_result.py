"""The evidence pack as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nonsmooth.reports.evidence.claim import ClaimKind
from nonsmooth.reports.evidence.pack import Evidence, gather
from nonsmooth.reports.interface.shown_result import ShownResult


@dataclass(frozen=True, repr=False)
class EvidenceResult(ShownResult):
    """Predictions beside what others measured, shipped or published.

    Attributes:
        shown: the rows, and the models of friction ranked.
    """

    shown: Evidence

    def __repr__(self) -> str:
        return self.shown.summary()


def validate(only: Iterable[str] = tuple(ClaimKind)) -> EvidenceResult:
    """Validate predictions against vehicles, measured pushes and published claims; all three take about a minute.

    Args:
        only: of ``vehicles``, ``pushes`` and ``claims``.

    Raises:
        ValueError: for another name.
    """
    return EvidenceResult(gather([ClaimKind(name) for name in only]))
