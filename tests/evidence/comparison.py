"""One row of the evidence: what is claimed or measured, by whom, what is predicted, and what follows.

Verdicts come from the numbers alone, by limits that were set before any data was looked at.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from nonsmooth.symbolic.numbers.number_text import float_text

CLOSE, NEAR = 0.05, 0.15  # relative errors up to which a prediction agrees with a measurement, or is near it


class Verdict(StrEnum):
    """What follows from a row."""

    AGREES = "agrees"
    NEAR = "near"
    MISSES = "misses"
    REFUTED = "refuted"


class Comparison(NamedTuple):
    """A prediction beside what a source measured or claims.

    Attributes:
        claim: what is said or measured, in words.
        source: who says so; where it is cited from memory, that is said.
        predicted: by this program.
        measured: by the source; None where nothing was measured but directions.
        verdict: what follows.
        error: relative; None where there is none to speak of.
        witness: what shows it, in words.
        unit: of both numbers.
        fitted: how many numbers were fitted to the data.
    """

    claim: str
    source: str
    predicted: float
    measured: float | None
    verdict: Verdict
    error: float | None = None
    witness: str = ""
    unit: str = ""
    fitted: int = 0

    def cells(self) -> tuple[str, ...]:
        """As people read it: claim, source, both numbers, error, verdict, numbers fitted, witness."""
        predicted, measured = (
            "-" if value is None else f"{float_text(value, 4)} {self.unit}".strip()
            for value in (self.predicted, self.measured)
        )
        error = "-" if self.error is None else f"{round(100 * self.error, 1) + 0.0:+.1f} %"
        fitted = str(self.fitted or "nothing")
        return self.claim, self.source, predicted, measured, error, self.verdict, fitted, self.witness


def measured(claim: str, source: str, predicted: float, number: float) -> Comparison:
    """A prediction beside a measured number."""
    error = predicted / number - 1
    return Comparison(claim, source, predicted, number, measured_verdict(error), error)


def measured_verdict(error: float) -> Verdict:
    """Of a relative error: the prediction agrees, is near or misses."""
    if abs(error) <= CLOSE:
        return Verdict.AGREES
    return Verdict.NEAR if abs(error) <= NEAR else Verdict.MISSES


def published(claim: str, source: str, predicted: float, claimed: float, witness: str) -> Comparison:
    """A published number against the computed one: they agree, or the claim is refuted by the witness."""
    verdict = Verdict.AGREES if abs(predicted - claimed) <= CLOSE * abs(claimed) else Verdict.REFUTED
    error = predicted / claimed - 1 if claimed and predicted != claimed else None
    return Comparison(claim, source, predicted, claimed, verdict, error, witness)
