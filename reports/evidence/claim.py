"""One row of the evidence: what is claimed or measured, by whom, what is predicted, and what follows.

Verdicts come from the numbers alone, by limits that were set before any data was looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from nonsmooth.reports.exact_record import Record
from nonsmooth.symbolic.number_text import float_text

CLOSE, NEAR = 0.05, 0.15  # relative errors up to which a prediction agrees with a measurement, or is near it


class ClaimVerdict(StrEnum):
    """What follows from a row."""

    AGREES = "agrees"
    NEAR = "near"
    MISSES = "misses"
    REFUTED = "refuted"


class ClaimKind(StrEnum):
    """Where a row belongs."""

    VEHICLES = "vehicles"
    PUSHES = "pushes"
    CLAIMS = "claims"


@dataclass(frozen=True)
class Claim:
    """One row.

    Attributes:
        kind: of the evidence.
        claim: what is said or measured, in words.
        source: who says so; where it is cited from memory, that is said.
        predicted: by this program.
        measured: by the source.
        unit: of both.
        error: relative, or in the unit where :attr:`is_absolute`; None where the numbers are counts that must be equal.
        verdict: what follows.
        witness: what shows it, in words.
        fitted: how many numbers were fitted to the data: 0 unless stated.
    """

    kind: ClaimKind
    claim: str
    source: str
    predicted: float
    measured: float
    unit: str
    error: float | None
    verdict: ClaimVerdict
    witness: str = ""
    fitted: int = 0

    def record(self) -> Record:
        """JSON with stable keys."""
        return {
            "kind": self.kind.value,
            "claim": self.claim,
            "source": self.source,
            "predicted": self.predicted,
            "measured": self.measured,
            "unit": self.unit or None,
            "error": self.error,
            "verdict": self.verdict.value,
            "witness": self.witness or None,
            "fitted": self.fitted,
        }

    def values(self) -> tuple[str, str, str]:
        """Predicted, measured and error as people read them."""
        predicted, measured = (
            f"{float_text(value, 4)} {self.unit}".strip() for value in (self.predicted, self.measured)
        )
        return predicted, measured, "-" if self.error is None else f"{round(100 * self.error, 1) + 0.0:+.1f} %"


def measured_verdict(error: float) -> ClaimVerdict:
    """Of a relative error."""
    if abs(error) <= CLOSE:
        return ClaimVerdict.AGREES
    return ClaimVerdict.NEAR if abs(error) <= NEAR else ClaimVerdict.MISSES


def published(claim: str, source: str, predicted: float, claimed: float, witness: str, unit: str = "") -> Claim:
    """A published number against the computed one: they agree, or the claim is refuted by the witness."""
    verdict = ClaimVerdict.AGREES if abs(predicted - claimed) <= CLOSE * abs(claimed) else ClaimVerdict.REFUTED
    error = predicted / claimed - 1 if claimed and predicted != claimed else None
    return Claim(ClaimKind.CLAIMS, claim, source, predicted, claimed, unit, error, verdict, witness)
