"""400 measured pushes: directions predicted with nothing fitted, and models of friction ranked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from nonsmooth.analysis.pushes.measured_pushes import SOURCE
from nonsmooth.analysis.pushes.ranking import Difference, Direction, Ranked, differences, rank
from nonsmooth.reports.evidence.claim import Claim, ClaimKind, ClaimVerdict
from nonsmooth.reports.exact_record import Record
from nonsmooth.symbolic.number_text import float_text


@dataclass(frozen=True)
class PushEvidence:
    """The models ranked both ways.

    Attributes:
        ranked: by direction of the prediction, the best median first.
        gaps: each model against the one before it.
    """

    ranked: Mapping[Direction, tuple[Ranked, ...]]
    gaps: Mapping[Direction, tuple[Difference, ...]]

    def of(self, direction: Direction, name: str) -> Ranked:
        """One model."""
        return next(one for one in self.ranked[direction] if one.model.name == name)

    def record(self) -> list[Record]:
        """A row for each model and direction."""
        rows = []
        for direction, ranked in self.ranked.items():
            above = {gap.worse.model.name: gap for gap in self.gaps[direction]}
            for place, one in enumerate(ranked, 1):
                gap = above.get(one.model.name)
                rows.append(
                    {
                        "direction": direction.value,
                        "place": place,
                        "model": one.model.name,
                        "fitted": one.model.parameters,
                        "median": one.median,
                        "interval": list(one.interval),
                        "mean": float(one.errors.mean()),
                        "pushes": len(one.errors),
                        "above_the_better": None if gap is None else list(gap.interval),
                    }
                )
        return rows


def push_evidence() -> PushEvidence:
    """Rank all models both ways: about half a minute."""
    ranked = {direction: rank(direction) for direction in Direction}
    return PushEvidence(ranked, {direction: differences(found) for direction, found in ranked.items()})


def push_claims(found: PushEvidence) -> Iterator[Claim]:
    """What the pushes say of the point contacts with nothing fitted, and of the source's own ranking."""
    for direction in Direction:
        yield _median(found.of(direction, "isotropic"), found.of(direction, "naive"))
    quartic, ellipsoid = (found.of(Direction.MOTION, name) for name in ("quartic", "ellipsoid"))
    yield _order(quartic, ellipsoid, "a convex quartic predicts motions better than an ellipsoid")
    isotropic = found.of(Direction.MOTION, "isotropic")
    yield _order(isotropic, quartic, "known supports with nothing fitted predict motions better than a fitted quartic")


def _median(own: Ranked, naive: Ranked) -> Claim:
    """The median angle beside that of a guess; it agrees where its interval lies below the guess's."""
    low, high = own.interval
    better = high < naive.interval[0]
    witness = f"median within {float_text(low, 3)} to {float_text(high, 3)}; the guess that they are parallel: "
    witness += f"{float_text(naive.median, 3)}"
    claim = f"{own.direction} of 400 pushes, point contacts: median angle between predicted and measured direction"
    verdict = ClaimVerdict.AGREES if better else ClaimVerdict.MISSES
    return Claim(ClaimKind.PUSHES, claim, SOURCE, own.median, 0.0, "deg", None, verdict, witness)


def _order(better: Ranked, worse: Ranked, claim: str) -> Claim:
    """Two medians in an order, with the interval of their difference."""
    (gap,) = differences((better, worse))
    low, high = (float_text(value, 3) for value in gap.interval)
    witness = f"difference of medians within {low} to {high} deg"
    verdict = ClaimVerdict.AGREES if gap.is_clear else ClaimVerdict.REFUTED
    return Claim(
        ClaimKind.PUSHES,
        claim,
        SOURCE,
        better.median,
        worse.median,
        "deg",
        None,
        verdict,
        witness,
        better.model.parameters,
    )
