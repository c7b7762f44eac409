"""How fast a proved V falls: ``V' <= -kappa`` (arrival within ``V/kappa``) or ``V' <= -kappa V`` (exponentially).

A rate holds where it is proved: on the closed cells that it is asked of.  What it says of solutions (when they arrive,
how V falls with time) holds of those that stay there, as all do that start where V is below its values on the border.

On closed cells both are inequalities between polynomials.  On edges where V bends, the values of the set-valued
derivative are shifted by ``kappa`` or ``kappa V`` and decided along the whole edge as without
(:mod:`nonsmooth.proofs.inequalities.kinks`); corners are met at single instants only.  Floats propose kappa.

A region ``V < c`` may reach beyond the square on which V is proved to fall: then V has no bends, and a rate of its own
is asked for on the region (:class:`RegionRate`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from itertools import combinations

import numpy as np

from nonsmooth.analysis.cells.region import common_edges
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.kinks import Kink, Trend
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.proofs.inequalities.strata import bends_along_a_curve
from nonsmooth.proofs.systems.lyapunov_rows import sample_points, values_at
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion, below, rise_below
from nonsmooth.symbolic.numbers.polynomial import Polynomial

SHARES = (Fraction(15, 16), Fraction(3, 4), Fraction(1, 2), Fraction(1, 4))  # of what samples allow, tried in turn
DENOMINATOR = 64  # of kappa
LEAST = Fraction(1, DENOMINATOR)
LEVEL_SHARES = (Fraction(1), Fraction(1, 2))  # of the level of a region, tried in turn


class DecayKind(StrEnum):
    """The two kinds of rates, as inequalities."""

    FINITE = "V' <= -{0}"
    EXPONENTIAL = "V' <= -{0} V"

    def on_starts(self, kappa: Fraction, starts: str) -> str:
        """What the inequality says of starts whose solutions stay where it holds."""
        if self is DecayKind.FINITE:
            return f"{starts} arrives within V/({kappa})"
        return f"from {starts} V falls at least like exp(-{kappa} t)"


@dataclass(frozen=True)
class DecayRate:
    """A proved rate.

    Attributes:
        decay: which of the two.
        kappa: the rate.
    """

    decay: DecayKind
    kappa: Fraction

    def __str__(self) -> str:
        return self.decay.value.format(self.kappa)

    def check(self, cells: Sequence[LyapunovCell]) -> bool:
        """Verify every inequality again."""
        return self.kappa > 0 and _holds(cells, self.decay, self.kappa)


def decay_rate(cells: Sequence[LyapunovCell]) -> DecayRate | None:
    """A rate of a V that is proved to fall on cells of a square; None where none is proved, or curves cut the cells."""
    if any(cell.region.guards for cell in cells):
        return None
    for decay in DecayKind:
        largest = _sampled(cells, decay)
        for share in SHARES:
            kappa = Fraction(int(largest * share * DENOMINATOR), DENOMINATOR)
            if kappa >= LEAST and _holds(cells, decay, kappa):
                return DecayRate(decay, kappa)
    return None


@dataclass(frozen=True)
class RegionRate:
    """``V' <= -kappa V`` where ``V < level`` in a square, of a V without bends; every solution from there stays there.

    Attributes:
        kappa: the rate.
        level: at most that of a certified region in the same square.
    """

    kappa: Fraction
    level: Fraction

    def __str__(self) -> str:
        return DecayKind.EXPONENTIAL.value.format(self.kappa)

    def check(self, cells: Sequence[LyapunovCell], region: SublevelRegion) -> bool:
        """Verify the inequality again on cells of the region's square."""
        inside = 0 < self.level <= region.level
        return inside and self.kappa > 0 and _falls_below(cells, self.kappa, self.level)


def region_rate(cells: Sequence[LyapunovCell], region: SublevelRegion) -> RegionRate | None:
    """A rate on a region, or where V is below half its level; None where none is proved.

    Args:
        cells: of the region's square, with one polynomial V.
        region: certified with this V; its level may be that at which V' first vanishes, where no rate is positive.
    """
    for part in LEVEL_SHARES:
        level = region.level * part
        inside = [replace(cell, region=below(cell, level)) for cell in cells]
        largest = _sampled(inside, DecayKind.EXPONENTIAL)
        for share in SHARES:
            kappa = Fraction(int(largest * share * DENOMINATOR), DENOMINATOR)
            if kappa >= LEAST and _falls_below(cells, kappa, level):
                return RegionRate(kappa, level)
    return None


def _falls_below(cells: Sequence[LyapunovCell], kappa: Fraction, level: Fraction) -> bool:
    """Whether ``V' < -kappa V`` is proved off the point where ``V < level``."""
    return all(rise_below(rate + cell.potential * kappa, cell, level) is None for cell in cells for rate in cell.rates)


def _sampled(cells: Sequence[LyapunovCell], decay: DecayKind) -> Fraction:
    """The largest rate that sampled points of the cells allow; zero where no point is in any of them."""
    found = []
    for cell in cells:
        points = sample_points(cell.region)
        if not len(points):
            continue
        falls = np.min([-values_at(rate, points) for rate in cell.rates], axis=0)
        sizes = np.ones(len(points)) if decay is DecayKind.FINITE else values_at(cell.potential, points)
        usable = (sizes > 0) & np.isfinite(sizes) & np.isfinite(falls)
        if not usable.any():  # a square beyond the range of floats: nothing is proposed
            return Fraction(0)
        found.append(float((falls[usable] / sizes[usable]).min()))
    return Fraction(max(min(found, default=0.0), 0.0))


def _holds(cells: Sequence[LyapunovCell], decay: DecayKind, kappa: Fraction) -> bool:
    """Whether the rate is proved on all closed cells and edges."""
    if bends_along_a_curve(cells):
        return False
    shifts = [_shift(cell, decay, kappa) for cell in cells]
    for cell, shift in zip(cells, shifts, strict=True):
        for rate in cell.rates:
            if not isinstance(prove(Sense.NONPOSITIVE, rate + shift, cell.region), Proof):
                return False
    for (first, shift), (second, _) in combinations(zip(cells, shifts, strict=True), 2):
        for edge in common_edges(first.region, second.region):
            kink = Kink(first, second, edge, shift)
            if kink.bends and kink.trends()[0].bacciotti_ceragioli.rank > Trend.NONPOSITIVE.rank:
                return False
    return True


def _shift(cell: LyapunovCell, decay: DecayKind, kappa: Fraction) -> Polynomial:
    if decay is DecayKind.EXPONENTIAL:
        return cell.potential * kappa
    return Polynomial.constant(cell.potential.field, cell.potential.variables, kappa)
