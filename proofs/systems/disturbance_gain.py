"""How much an additive disturbance can do: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d``, Euclidean norms.

``gamma`` is an upper bound of ``|grad V|`` on all closed cells.  Inside a cell that is ``g . (f + d)``.  On an edge on
which V bends the derivative is ``g . (f + d)`` with *every* g of the Clarke gradient, and one of them has
``g . f <= -kappa V`` for all f of F.  Let n point from side 1 to side 2 and ``g_2 - g_1 = c n``.  Where both fields
cross the same way, or where V bends against the way they oppose each other, g_1 or g_2 serves:
``g_1 . f_2 = g_2 . f_2 - c n . f_2``.  Else the edge slides, and the affine combination ``g_s`` with
``g_s . f_1 = g_s . f_2``, the known sliding value, serves if it lies between g_1 and g_2, and otherwise the nearer end.
A disturbance may also hold a solution at a corner p, where ``f + d = 0``: there ``kappa V(p) <= gamma |f|`` is required
for all f of F, unless one gradient serves all fields.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement
from math import isqrt
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, distinct
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.proofs.systems.decay_rate import DecayKind, DecayRate
from nonsmooth.proofs.systems.lyapunov_rows import sample_points, values_at
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.plane import cross, dot, hull_holds_zero, minus

SHARES = (Fraction(65, 64), Fraction(5, 4), Fraction(2))  # of what samples need, tried in turn
DENOMINATOR = 64  # of gamma


@dataclass(frozen=True)
class DisturbanceGain:
    """A proved gain.

    It holds on the square on which V and its rate are proved.

    Attributes:
        gamma: of the disturbance.
        rate: of V without it.
        level: of the region that is certified on that square; None where there is none.
    """

    gamma: Fraction
    rate: DecayRate
    level: Fraction | None

    @property
    def largest(self) -> Fraction | None:
        """Disturbances below it leave the certified region invariant; None without one."""
        if self.level is None:
            return None
        whole = self.rate.kappa / self.gamma
        return whole if self.rate.decay is DecayKind.FINITE else whole * self.level

    @property
    def ultimate(self) -> Fraction | None:
        """``V <= ultimate delta`` in the end; None where solutions arrive at the point itself."""
        return None if self.rate.decay is DecayKind.FINITE else self.gamma / self.rate.kappa

    def __str__(self) -> str:
        return f"with x' in F + d: {self.rate} + {self.gamma} abs(d)"

    @property
    def on_starts(self) -> str:
        """What it says of starts below the level; empty without one."""
        kappa, gamma = self.rate.kappa, self.gamma
        if self.largest is None:
            return ""
        if self.rate.decay is DecayKind.FINITE:
            ends = f"arrives all the same, within V/({kappa} - {gamma} delta)"
        else:
            ends = f"ends in V <= {self.ultimate} delta"
        return f"where abs(d) <= delta < {self.largest} every start with V < {self.level} there {ends}"

    def check(self, cells: Sequence[LyapunovCell], radius: Number) -> bool:
        """Verify every inequality again."""
        return self.gamma > 0 and self.rate.check(cells) and _holds(cells, self.rate, self.gamma, radius)


def disturbance_gain(
    cells: Sequence[LyapunovCell], radius: Number, rate: DecayRate, region: SublevelRegion | None
) -> DisturbanceGain | None:
    """The gain of a V with a proved rate on cells of a square.

    Args:
        cells: of the square, with one field each.
        radius: half the side of the square.
        rate: proved on these cells.
        region: certified with this V, which falls on all of this square; None without.

    Returns:
        None where no gain is proved, and under arbitrary switching.
    """
    if any(len(cell.velocities) > 1 for cell in cells):
        return None
    needed = max([_sampled(cells), *_corner_needs(cells, rate, radius)])
    for share in SHARES:
        gamma = Fraction(int(needed * share * DENOMINATOR) + 1, DENOMINATOR)
        if _holds(cells, rate, gamma, radius):
            return DisturbanceGain(gamma, rate, None if region is None else region.level)
    return None


def _sampled(cells: Sequence[LyapunovCell]) -> Fraction:
    """The largest gradient at sampled points."""
    sizes = [np.hypot(*(values_at(p, sample_points(cell.region)) for p in cell.gradient)).max() for cell in cells]
    return Fraction(float(max(sizes)))


def _holds(cells: Sequence[LyapunovCell], rate: DecayRate, gamma: Fraction, radius: Number) -> bool:
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
