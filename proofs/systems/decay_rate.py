"""How fast a proved V falls: ``V' <= -kappa`` (arrival within ``V/kappa``) or ``V' <= -kappa V`` (exponentially).

On closed cells both are inequalities between polynomials.  On edges where V bends, the values of the set-valued
derivative are shifted by ``kappa`` or ``kappa V`` and decided along the whole edge as without
(:mod:`nonsmooth.proofs.inequalities.kinks`); corners are met at single instants only.  Floats propose kappa.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
from nonsmooth.symbolic.numbers.polynomial import Polynomial

SHARES = (Fraction(15, 16), Fraction(3, 4), Fraction(1, 2), Fraction(1, 4))  # of what samples allow, tried in turn
DENOMINATOR = 64  # of kappa
LEAST = Fraction(1, DENOMINATOR)


class DecayKind(StrEnum):
    """The two kinds of rates."""

    FINITE = "V' <= -{0}: every solution arrives within V/({0})"
    EXPONENTIAL = "V' <= -{0} V: V falls at least like exp(-{0} t)"


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


def _sampled(cells: Sequence[LyapunovCell], decay: DecayKind) -> Fraction:
    """The largest rate that sampled points of the cells allow."""
    found = []
    for cell in cells:
        points = sample_points(cell.region)
        falls = np.min([-values_at(rate, points) for rate in cell.rates], axis=0)
        sizes = np.ones(len(points)) if decay is DecayKind.FINITE else values_at(cell.potential, points)
        found.append(float((falls / sizes).min()))
    return Fraction(max(min(found), 0.0))


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
