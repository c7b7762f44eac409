"""Lyapunov's conditions for a nonsmooth V and a Filippov inclusion on a closed domain, each with exact evidence.

V is a polynomial on each cell (:mod:`nonsmooth.analysis.cells.switched_cells`); it is positive if it is on every
closed cell. Its derivative is decided part by part (:mod:`nonsmooth.proofs.inequalities.strata`): on each *closed*
cell ``grad V . f`` (the hull on a surface holds the fields of both sides, so for smooth V nothing else is needed:
Filippov 1988, sec. 15), and the sets of :mod:`nonsmooth.proofs.inequalities.ladder` on each edge and at each corner
where V bends.  Then along every solution

- largest value of Bacciotti and Ceragioli's set <= 0 everywhere: V does not increase, the equilibrium is stable;
- < 0 everywhere but at the equilibrium: no solution stays where 0 is in the set, so it is asymptotically stable
  (invariance principle: Bacciotti and Ceragioli 1999, thm. 3).

On closed cells < 0 is demanded also on sides where V bends: more than the theorem asks, and never too little.  A corner
at which V bends twice and the set is positive refutes nothing by itself (no solution need stay there): undecided.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.curved_kinks import is_seen_empty
from nonsmooth.proofs.inequalities.curved_regions import Adherence, adherence, is_empty
from nonsmooth.proofs.inequalities.effort import shared_effort
from nonsmooth.proofs.inequalities.kinks import Trend, worst
from nonsmooth.proofs.inequalities.ladder import Interval
from nonsmooth.proofs.inequalities.prover import Counterexample, Outcome, Proof, Sense, Undecided, ZeroBetween, prove
from nonsmooth.proofs.inequalities.strata import Refutation, Stratum, StratumPart, bend_strata, cell_stratum, stratum_of
from nonsmooth.symbolic.notebook import ShortRepr

EFFORT = 150_000  # coefficients looked at for all inequalities of one V: a few seconds
EMPTINESS_WORK = 2_000  # coefficients looked at to find that a cell beside a curve is empty; kept otherwise


class Decrease(StrEnum):
    """What V does along every solution in the domain."""

    STRICT = "V is positive and decreases everywhere but at the equilibrium"
    WEAK = "V is positive and does not increase"
    REFUTED = "V is no Lyapunov function"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Supremum:
    """The largest value of one derivative over the domain without the equilibrium.

    Attributes:
        trend: its sign.
        value: the exact value where every part that matters has a constant one; None otherwise.
        point: a point of the part on which it is largest.
    """

    trend: Trend
    value: Any | None
    point: Point | None


@dataclass(frozen=True, repr=False)
class LyapunovResult(ShortRepr):
    """Lyapunov's conditions on a domain, with the evidence of each.

    Attributes:
        cells: cover the domain; V and the fields are smooth on each.
        definite: ``V > 0`` on each closed cell, except at the equilibrium.
        strata: the derivatives, part by part.
        verdict: what follows.
        witness: where a condition fails.
        reason: one sentence for people.
    """

    cells: tuple[LyapunovCell, ...]
    definite: tuple[Outcome, ...]
    strata: tuple[Stratum, ...]
    verdict: Decrease
    witness: Refutation | None
    reason: str

    def supremum(self, name: str) -> Supremum:
        """Of ``naive``, ``shevitz_paden`` or ``bacciotti_ceragioli``."""
        trend = worst([getattr(s.trends, name) for s in self.strata])
        best: Interval | None = None
        point: Point | None = None
        exact = True
        for stratum in self.strata:
            interval = getattr(stratum.ladder, name)
            if getattr(stratum.trends, name) is Trend.EMPTY:
                continue
            exact = exact and stratum.constant
            if interval is not None and (best is None or best.high < interval.high):
                best, point = interval, stratum.sample
        return Supremum(trend, best.high if best is not None and exact else None, point)

    def check(self) -> bool:
        """Verify every inequality from its polynomials, and the conclusion; recompute the edges and corners."""
        if len(self.definite) != len(self.cells):
            return False
        for cell, outcome in zip(self.cells, self.definite, strict=True):
            asked = outcome.question
            about_this = asked.region == cell.region and not asked.polynomial - cell.potential
            if not about_this or not _still_true(outcome):
                return False
        evidence = [o for s in self.strata if isinstance(s.evidence, tuple) for o in s.evidence]
        rates = [(cell.region, rate) for cell in self.cells for rate in cell.rates]
        if len(evidence) != len(rates) or any(
            o.question.region != region or o.question.polynomial - rate or not _still_true(o)
            for o, (region, rate) in zip(evidence, rates, strict=True)
        ):
            return False
        concluded = conclude(self.cells, self.definite, self.strata)
        return concluded == (self.verdict, self.witness, self.reason) and self.recompute()

    def recompute(self) -> bool:
        """Whether the same parts follow from the evidence, and from the edges and corners where V bends."""
        claimed = [s.evidence for s in self.strata if s.part is StratumPart.CELL and isinstance(s.evidence, tuple)]
        return self.strata == (*map(stratum_of, self.cells, claimed), *bend_strata(self.cells))


def _still_true(outcome: Outcome) -> bool:
    return isinstance(outcome, Undecided) or outcome.check()


@shared_effort(EFFORT)
def examine(cells: Sequence[LyapunovCell]) -> LyapunovResult:
    """Decide Lyapunov's conditions on cells that cover the domain, the equilibrium at the origin."""
    real = inhabited(cells)
    definite = tuple(prove(Sense.POSITIVE, cell.potential, cell.region, except_origin=True) for cell in real)
    strata = (*(cell_stratum(cell) for cell in real), *bend_strata(real))
    verdict, witness, reason = conclude(real, definite, strata)
    return LyapunovResult(real, definite, strata, verdict, witness, reason)


def inhabited(cells: Sequence[LyapunovCell]) -> tuple[LyapunovCell, ...]:
    """Without the cells whose guards are proved to leave nothing of them."""
    return tuple(cell for cell in cells if not (cell.region.guards and _is_empty(cell)))


def _is_empty(cell: LyapunovCell) -> bool:
    """Whether the open cell holds no point: exactly over Q, unless that takes too much work.

    Otherwise, whether that is seen with little work (the origin alone would be no cell).
    """
    decided = is_empty(cell.region)
    if decided is not None:
        return decided
    return is_seen_empty(cell.region, cell.potential, EMPTINESS_WORK, except_origin=True)


def conclude(
    cells: Sequence[LyapunovCell], definite: Sequence[Outcome], strata: Sequence[Stratum]
) -> tuple[Decrease, Refutation | None, str]:
    """The verdict from the evidence."""
    refuted = next(refutations(cells, definite, strata), None)
    if refuted is not None:
        return Decrease.REFUTED, refuted, refuted.meaning
    trends = [_trusted(stratum) for stratum in strata]
    open_part = next((o for o in definite if not isinstance(o, Proof)), None)
    if open_part is not None or worst(trends) is Trend.UNDECIDED:
        stuck = [o for o in (open_part, *_outcomes(strata)) if isinstance(o, Undecided)]
        return Decrease.UNDECIDED, None, stuck[0].reason if stuck else "V bends where its derivative is not decided"
    if worst(trends) in (Trend.EMPTY, Trend.NEGATIVE):
        return Decrease.STRICT, None, Decrease.STRICT.value
    return Decrease.WEAK, None, Decrease.WEAK.value


def _outcomes(strata: Sequence[Stratum]) -> Iterator[Outcome]:
    for stratum in strata:
        if isinstance(stratum.evidence, tuple):
            yield from stratum.evidence


def _trusted(stratum: Stratum) -> Trend:
    """The trend that decides; a positive one without refutation decides nothing."""
    trend = stratum.trends.bacciotti_ceragioli
    return Trend.UNDECIDED if trend is Trend.POSITIVE and stratum.refutation is None else trend


def refutations(
    cells: Sequence[LyapunovCell], definite: Sequence[Outcome], strata: Sequence[Stratum]
) -> Iterator[Refutation]:
    """Where V is not zero at the equilibrium, not positive, not continuous, or increases."""
    for cell, outcome in zip(cells, definite, strict=True):
        zero = cell.potential.field.zero
        at_origin = cell.potential.terms.get((0, 0), zero)
        if at_origin and adherence(cell.region) is Adherence.YES:
            yield Refutation((zero, zero), at_origin, "V is not zero at the equilibrium")
        if isinstance(outcome, Counterexample):
            yield Refutation(outcome.point, outcome.value, "V is not positive")
        elif isinstance(outcome, ZeroBetween):
            yield Refutation(outcome.point, None, "V vanishes beside this point")
    for stratum in strata:
        if stratum.refutation is not None:
            yield stratum.refutation
