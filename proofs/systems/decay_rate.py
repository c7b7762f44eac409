"""How fast a proved V falls, and how much an additive disturbance can do.

*Rates*: ``V' <= -kappa`` (arrival within ``V/kappa``), ``V' <= -kappa V`` (exponentially), or ``V' <= -kappa V^2``
(``V <= V_0/(1 + kappa V_0 t)``, where terms of higher order alone lead to the point).  A rate holds where it is
proved: on the closed cells that it is asked of.  What it says of solutions (when they arrive, how V falls with time)
holds of those that stay there, as all do that start where V is below its values on the border.  On closed cells both
are inequalities between polynomials.  On edges where V bends, the values of the set-valued derivative are shifted by
``kappa`` or ``kappa V`` and decided along the whole edge as without (:mod:`nonsmooth.proofs.inequalities.kinks`);
corners are met at single instants only.  Floats propose kappa.  A region ``V < c`` may reach beyond the square on which
V is proved to fall: then V has no bends, and a rate of its own is asked for on the region (:class:`RegionRate`).

*Gains*: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d``, Euclidean norms; ``gamma`` is an upper bound of
``|grad V|`` on all closed cells.  Inside a cell that is ``g . (f + d)``.  On an edge on which V bends the derivative is
``g . (f + d)`` with *every* g of the Clarke gradient, and one of them has ``g . f <= -kappa V`` for all f of F.  Let n
point from side 1 to side 2 and ``g_2 - g_1 = c n``.  Where both fields cross the same way, or where V bends against the
way they oppose each other, g_1 or g_2 serves: ``g_1 . f_2 = g_2 . f_2 - c n . f_2``.  Else the edge slides, and the
affine combination ``g_s`` with ``g_s . f_1 = g_s . f_2``, the known sliding value, serves if it lies between g_1 and
g_2, and otherwise the nearer end.  A disturbance may also hold a solution at a corner p, where ``f + d = 0``: there
``kappa V(p) <= gamma |f|`` is required for all f of F, unless one gradient serves all fields.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from itertools import combinations, combinations_with_replacement
from math import isqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import common_edges
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, distinct
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.kinks import Kink, Trend
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.systems.derivatives import bends_along_a_curve
from nonsmooth.proofs.systems.lyapunov_rows import sample_points, values_at
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion, below, rise_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import cross, dot, hull_holds_zero, minus
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError

Floats: TypeAlias = NDArray[np.float64]

SHARES = (Fraction(15, 16), Fraction(3, 4), Fraction(1, 2), Fraction(1, 4))  # of what samples allow, tried in turn
DENOMINATOR = 64  # of kappa and gamma; of slow rates twice as large until it holds FEWEST of them
FEWEST = 8
NEAR, FARTHER = 4.0, (32.0, 256.0)  # of the least distance of samples: up to the first, and between the others
VANISHES = 2.0**-2  # of the least ratio farther away: a smaller one near the point tends to zero there
LEVEL_SHARES = (Fraction(1), Fraction(1, 2))  # of the level of a region, tried in turn


class DecayKind(StrEnum):
    """The kinds of rates, as inequalities, the fastest first."""

    FINITE = "V' <= -{0}"
    EXPONENTIAL = "V' <= -{0} V"
    ALGEBRAIC = "V' <= -{0} V**2"

    @property
    def power(self) -> int:
        """The exponent p in ``V' <= -kappa V^p``."""
        return list(DecayKind).index(self)

    def on_starts(self, kappa: Fraction, starts: str) -> str:
        """What the inequality says of starts whose solutions stay where it holds."""
        if self is DecayKind.FINITE:
            return f"{starts} arrives within V/({kappa})"
        if self is DecayKind.ALGEBRAIC:
            return f"from {starts} V falls at least like V0/(1 + {kappa} V0 t), V0 its value there"
        return f"from {starts} V falls at least like exp(-{kappa} t)"


@dataclass(frozen=True)
class DecayRate:
    """A proved rate.

    Attributes:
        decay: of which kind.
        kappa: the rate.
        function: V in one state, where nothing else names it; empty elsewhere.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    decay: DecayKind
    kappa: Fraction
    function: str = ""
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def record(self) -> dict[str, str]:
        """As a certificate states it."""
        return {"kind": self.decay.name.lower(), "kappa": str(self.kappa)}

    def __str__(self) -> str:
        return self.decay.value.format(self.kappa)


def decay_rate(cells: Sequence[LyapunovCell]) -> DecayRate | None:
    """A rate of a V that is proved to fall on cells of a square; None where none is proved, or curves cut the cells."""
    if any(cell.region.guards for cell in cells):
        return None
    for decay in DecayKind:
        for kappa in rates_below(_largest_rate(cells, decay)):
            if _rate_holds(cells, decay, kappa):
                return DecayRate(decay, kappa)
    return None


def rate_scales(cells: Sequence[LyapunovCell], rate: DecayRate) -> bool:
    """Whether a rate on a square is one on the plane: on cones V and V' are forms, of the degrees of the rate.

    ``V' <= -kappa V^p`` scales where V' has p times the degree of V.

    Args:
        cells: cones at the point, of the plane.
        rate: proved on a square about it.
    """
    for cell in cells:
        degree = rate.decay.power * cell.potential.degree
        if not all(form.is_homogeneous for form in (cell.potential, *cell.rates)):
            return False
        if any(own and own.degree != degree for own in cell.rates):
            return False
    return True


def slowest_ratio(ratios: Floats, distances: Floats) -> Fraction:
    """The largest rate that samples allow, and zero where it seems that none is positive.

    Args:
        ratios: of ``-V'`` to ``V^p``, shape (n,).
        distances: of the samples from the point, shape (n,).
    """
    least = float(ratios.min(initial=np.inf))
    if not 0 < least < np.inf:
        return Fraction(0)
    times = distances / distances.min()
    farther = ratios[(times >= FARTHER[0]) & (times <= FARTHER[1])]
    vanishes = len(farther) and ratios[times <= NEAR].min() < VANISHES * farther.min()
    return Fraction(0) if vanishes and least * DENOMINATOR < 1 else Fraction(least)


def rates_below(largest: Fraction) -> Iterator[Fraction]:
    """Short rates to be tried in turn, of the largest that samples allow."""
    if not largest:
        return
    denominator = DENOMINATOR
    while largest * denominator < FEWEST:
        denominator *= 2
    for share in SHARES:
        kappa = Fraction(int(largest * share * denominator), denominator)
        if kappa > 0:
            yield kappa


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


def region_rate(cells: Sequence[LyapunovCell], region: SublevelRegion) -> RegionRate | None:
    """A rate on a region, or where V is below half its level; None where none is proved.

    Args:
        cells: of the region's square, with one polynomial V.
        region: certified with this V; its level may be that at which V' first vanishes, where no rate is positive.
    """
    for part in LEVEL_SHARES:
        level = region.level * part
        inside = [replace(cell, region=below(cell, level)) for cell in cells]
        for kappa in rates_below(_largest_rate(inside, DecayKind.EXPONENTIAL)):
            if _falls_below(cells, kappa, level):
                return RegionRate(kappa, level)
    return None


def _falls_below(cells: Sequence[LyapunovCell], kappa: Fraction, level: Fraction) -> bool:
    """Whether ``V' < -kappa V`` is proved off the point where ``V < level``."""
    return all(rise_below(rate + cell.potential * kappa, cell, level) is None for cell in cells for rate in cell.rates)


def _largest_rate(cells: Sequence[LyapunovCell], decay: DecayKind) -> Fraction:
    """The largest rate that sampled points of the cells allow; zero where no point is in any of them."""
    ratios, distances = [np.zeros(0)], [np.zeros(0)]
    for cell in cells:
        points = sample_points(cell.region)
        if not len(points):
            continue
        falls = np.min([-values_at(rate, points) for rate in cell.rates], axis=0)
        sizes = values_at(cell.potential, points) ** decay.power
        usable = (sizes > 0) & np.isfinite(sizes) & np.isfinite(falls)
        if not usable.any():  # a square beyond the range of floats: nothing is proposed
            return Fraction(0)
        ratios.append(falls[usable] / sizes[usable])
        distances.append(np.hypot(*points[usable].T))
    return slowest_ratio(np.concatenate(ratios), np.concatenate(distances))


def _rate_holds(cells: Sequence[LyapunovCell], decay: DecayKind, kappa: Fraction) -> bool:
    """Whether the rate is proved on all closed cells and edges, within the effort that is left."""
    if bends_along_a_curve(cells):
        return False
    shifts = [_shift(cell, decay, kappa) for cell in cells]
    for cell, shift in zip(cells, shifts, strict=True):
        for rate in cell.rates:
            if not isinstance(prove(Sense.NONPOSITIVE, rate + shift, cell.region), Proof):
                return False
    for (first, shift), (second, _) in combinations(zip(cells, shifts, strict=True), 2):
        for edge in common_edges(first.region, second.region):
            if not _falls_along(Kink(first, second, edge, shift)):
                return False
    return True


def _falls_along(kink: Kink) -> bool:
    try:
        return not kink.bends or kink.trends()[0].bacciotti_ceragioli.rank <= Trend.NONPOSITIVE.rank
    except WorkLimitError:
        return False


def _shift(cell: LyapunovCell, decay: DecayKind, kappa: Fraction) -> Polynomial:
    return cell.potential**decay.power * kappa


GAIN_SHARES = (Fraction(65, 64), Fraction(5, 4), Fraction(2))  # of what samples need, tried in turn


@dataclass(frozen=True)
class DisturbanceGain:
    """A proved gain.

    It holds on the square, or the cube, on which V and its rate are proved, or everywhere.

    Attributes:
        gamma: of the disturbance.
        rate: of V without it.
        level: of the region that is certified on that square; None where there is none, and everywhere.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
        everywhere: whether it holds in the whole space.
    """

    gamma: Fraction
    rate: DecayRate
    level: Fraction | None
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)
    everywhere: bool = False

    @property
    def largest(self) -> Fraction | None:
        """Disturbances below it leave the certified region invariant, or let solutions arrive all the same.

        None without a region, and where solutions stay bounded under any.
        """
        whole = self.rate.kappa / self.gamma
        if self.rate.decay is DecayKind.FINITE and (self.everywhere or self.level is not None):
            return whole
        return None if self.level is None else whole * self.level

    @property
    def ultimate(self) -> Fraction | None:
        """``V <= ultimate delta`` in the end; None where solutions arrive at the point itself."""
        return None if self.rate.decay is DecayKind.FINITE else self.gamma / self.rate.kappa

    def __str__(self) -> str:
        return f"with x' in F + d: {self.rate} + {self._times_gamma('abs(d)')}"

    def _times_gamma(self, size: str) -> str:
        return size if self.gamma == 1 else f"{self.gamma} {size}"

    @property
    def on_starts(self) -> str:
        """What it says of starts below the level, or of all; empty where it says nothing."""
        if self.largest is None and not self.everywhere:
            return ""
        if self.rate.decay is DecayKind.FINITE:
            ends = f"arrives all the same, within V/({self.rate.kappa} - {self._times_gamma('delta')})"
        else:
            ends = f"ends in V <= {self.ultimate} delta"
        below = "" if self.largest is None else f" < {self.largest}"
        starts = "every start" if self.everywhere else f"every start with V < {self.level} there"
        return f"where abs(d) <= delta{below} {starts} {ends}"


def disturbance_gain(
    cells: Sequence[LyapunovCell], radius: Number, rate: DecayRate, region: SublevelRegion | None
) -> DisturbanceGain | None:
    """The gain of a V with a proved rate on cells of a square.

    Args:
        cells: of the square.
        radius: half the side of the square.
        rate: proved on these cells.
        region: certified with this V, which falls on all of this square; None without.

    Returns:
        None where no gain is proved, for an algebraic rate, and for a V that bends under arbitrary switching.
    """
    if rate.decay is DecayKind.ALGEBRAIC:
        return None
    if any(len(cell.velocities) > 1 for cell in cells) and len({cell.potential for cell in cells}) > 1:
        return None
    needed = max([_largest_gradient(cells), *_corner_needs(cells, rate, radius)])
    for share in GAIN_SHARES:
        gamma = gain_above(needed * share)
        if _gain_holds(cells, rate, gamma, radius):
            return DisturbanceGain(gamma, rate, None if region is None else region.level)
    return None


def gain_above(needed: Fraction | float) -> Fraction:
    """A short number above another one."""
    return Fraction(int(needed * DENOMINATOR) + 1, DENOMINATOR)


def _largest_gradient(cells: Sequence[LyapunovCell]) -> Fraction:
    """The largest gradient at sampled points."""
    sizes = [np.hypot(*(values_at(p, sample_points(cell.region)) for p in cell.gradient)).max() for cell in cells]
    return Fraction(float(max(sizes)))


def _gain_holds(cells: Sequence[LyapunovCell], rate: DecayRate, gamma: Fraction, radius: Number) -> bool:
    """Whether gamma bounds all gradients, and serves at all corners."""
    for cell in cells:
        a, b = cell.gradient
        bound = Polynomial.constant(a.field, a.variables, gamma * gamma)
        if not isinstance(prove(Sense.NONPOSITIVE, a * a + b * b - bound, cell.region), Proof):
            return False
    return all(sign(need * need - gamma * gamma * square) <= 0 for need, square in _held_corners(cells, rate, radius))


def _corner_needs(cells: Sequence[LyapunovCell], rate: DecayRate, radius: Number) -> Iterator[Fraction]:
    """What gamma has to be at corners, from above."""
    for need, square in _held_corners(cells, rate, radius):
        if sign(square) > 0:
            ratio = Fraction(float(need)) / Fraction(max(isqrt(int(float(square) * (1 << 60))), 1), 1 << 30)
            yield ratio


def _held_corners(cells: Sequence[LyapunovCell], rate: DecayRate, radius: Number) -> Iterator[tuple[Any, Any]]:
    """Of corners inside the square at which no gradient serves all fields: what V loses, and the least ``|f|^2``."""
    for corner in _corners(cells, radius):
        around = [cell for cell in cells if cell.region.contains(corner)]
        fields = distinct((f(corner), g(corner)) for cell in around for f, g in cell.velocities)
        slopes = distinct((a(corner), b(corner)) for cell in around for a, b in [cell.gradient])
        lost = around[0].potential(corner) * rate.kappa if rate.decay is DecayKind.EXPONENTIAL else rate.kappa
        serving = [s for s in slopes if all(sign(dot(s, f) + lost) <= 0 for f in fields)]
        if not serving:
            yield lost, _least_square(fields)


def _corners(cells: Sequence[LyapunovCell], radius: Number) -> tuple[Point, ...]:
    """Vertices of cells inside the square, but the point itself."""
    places = distinct((x / w, y / w) for cell in cells for x, y, w in cell.region.generators)
    return tuple(p for p in places if any(map(sign, p)) and all(sign(abs(x) - radius) < 0 for x in p))


def _least_square(fields: Sequence[Point]) -> Any:
    """The least square of the length in the hull of some vectors."""
    if hull_holds_zero(fields):
        return fields[0][0] * 0
    least = None
    for a, b in combinations_with_replacement(fields, 2):
        square = _square_on_segment(a, b)
        least = square if least is None or sign(square - least) < 0 else least
    return least


def _square_on_segment(a: Point, b: Point) -> Any:
    """The least square of the length on a segment."""
    along = minus(b, a)
    if sign(dot(a, along)) >= 0:
        return dot(a, a)
    if sign(dot(b, along)) <= 0:
        return dot(b, b)
    area = cross(a, b)
    return area * area / dot(along, along)
