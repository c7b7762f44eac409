"""The evidence pack: all rows, in every form of ``nonsmooth validate``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.reports.evidence.claim import Claim, ClaimKind
from nonsmooth.reports.evidence.literature import literature_claims
from nonsmooth.reports.evidence.pushes import PushEvidence, push_claims, push_evidence
from nonsmooth.reports.evidence.vehicles import MULTIPLIER, vehicle_claims
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.number_text import float_text

SCHEMA = "nonsmooth-evidence/1"
COLUMNS = ("kind", "claim", "source", "predicted", "measured", "unit", "error", "verdict", "witness", "fitted")
REMARK = (
    "Nothing was tuned. A prediction agrees with a measurement within 5 %, and is near it within 15 %; a published "
    "claim agrees, or is refuted by a witness."
)


@dataclass(frozen=True)
class Evidence:
    """What was predicted and what was measured.

    Attributes:
        claims: the rows.
        pushes: models of friction ranked on the measured pushes; None where these were not asked for.
    """

    claims: tuple[Claim, ...]
    pushes: PushEvidence | None = None

    @property
    def multipliers(self) -> list[Claim]:
        """The rows about effective tracks of vehicles."""
        return [claim for claim in self.claims if claim.claim.startswith(MULTIPLIER)]

    @property
    def published(self) -> list[Claim]:
        """The rows about published claims."""
        return [claim for claim in self.claims if claim.kind is ClaimKind.CLAIMS]

    def record(self) -> Record:
        """JSON with stable keys."""
        return {
            "schema": SCHEMA,
            "rows": [claim.record() for claim in self.claims],
            "verdicts": dict(Counter(claim.verdict.value for claim in self.claims)),
            "ranking": None if self.pushes is None else self.pushes.record(),
        }

    def lines(self) -> Iterator[tuple[object, ...]]:
        """One line for each row."""
        yield COLUMNS
        for claim in self.claims:
            record = claim.record()
            yield tuple(record[name] for name in COLUMNS)

    def picture(self, suffix: str) -> bytes:
        """Errors of the vehicles, histograms of the pushes, medians of the models."""
        from nonsmooth.reports.figures.evidence import evidence_figure

        return evidence_figure(self, suffix)

    def summary(self) -> str:
        """One line."""
        counts = Counter(claim.verdict.value for claim in self.claims)
        return f"{len(self.claims)} rows: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items())

    def view(self) -> RenderableType:
        """Tables: the rows, and the ranking."""
        parts: list[RenderableType] = [Text(self.summary())]
        for kind in ClaimKind:
            own = [claim for claim in self.claims if claim.kind is kind]
            if own:
                parts.append(_claims_table(kind, own))
        if self.pushes is not None:
            parts.append(_ranking_table(self.pushes))
        return Group(*parts, Text(REMARK, "dim"))


def gather(kinds: Collection[ClaimKind] = tuple(ClaimKind)) -> Evidence:
    """Compute the rows of some kinds, all unless given: about half a minute."""
    claims: list[Claim] = []
    if ClaimKind.VEHICLES in kinds:
        claims += vehicle_claims()
    pushes = push_evidence() if ClaimKind.PUSHES in kinds else None
    if pushes is not None:
        claims += push_claims(pushes)
    if ClaimKind.CLAIMS in kinds:
        claims += literature_claims()
    return Evidence(tuple(claims), pushes)


def _claims_table(kind: ClaimKind, claims: list[Claim]) -> RenderableType:
    table = header_table(kind.value, "predicted", "measured", "error", "verdict")
    table.show_lines = True
    for claim in claims:
        text = claim.claim if not claim.witness else f"{claim.claim} ({claim.witness})"
        table.add_row(text, *claim.values(), claim.verdict.value)
    return table


def _ranking_table(pushes: PushEvidence) -> RenderableType:
    table = header_table("direction of 400 pushes", "model", "fitted", "median", "95 %")
    for row in pushes.record():
        low, high = (float_text(value, 3) for value in row["interval"])
        median = f"{float_text(row['median'], 3)} deg"
        table.add_row(row["direction"], row["model"], str(row["fitted"]), median, f"{low} to {high}")
    return table
