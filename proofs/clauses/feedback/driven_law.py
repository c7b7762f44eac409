"""The law of :mod:`nonsmooth.proofs.clauses.feedback.by_friction`: its three twists, their speeds, and its rate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.box_twists import BoxTwist
from nonsmooth.proofs.clauses.feedback.ellipse_twists import BalancedTwist
from nonsmooth.proofs.clauses.feedback.feedback_rate import rounded_down
from nonsmooth.symbolic.constraints import Triple, cross_product, gram, independent, inner, roll_row, side_row
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.scene import Scene, Wheel

ImposedTwist: TypeAlias = BoxTwist | BalancedTwist

CHOICES = 16  # unique minimizers among which the best three are sought
_SMALLER = Fraction(9, 10)  # next try where rounding made the proposed rate too large


@dataclass(frozen=True)
class LawCone:
    """Directions of c in which the law uses the same three twists.

    Attributes:
        rays: first and last direction, counterclockwise, less than a half turn apart; None all around.
        twists: three independent twists, each the only minimizer near c* inside the cone.
        elsewhere: the same twists with their slopes in the other load regions that meet at c* (all around).
    """

    rays: tuple[Point, Point] | None
    twists: tuple[ImposedTwist, ...]
    elsewhere: tuple[ImposedTwist, ...] = ()

    @property
    def vectors(self) -> tuple[Triple, ...]:
        """The twists alone."""
        return tuple(imposed.twist for imposed in self.twists)

    @property
    def bounds(self) -> Iterator[tuple[Number, Number]]:
        """Half-widths of squares about c* in which the loads keep their form and each slope of D stays positive.

        As numerators and denominators: over many square roots a quotient is long work, and one of all is asked for.
        """
        for imposed in (*self.twists, *self.elsewhere):
            if isinstance(imposed, BoxTwist):
                affine = [(side.offset, *side.normal) for side in imposed.region.polygon.sides]
                for constant, x, y in (*affine, *imposed.slopes):
                    size = abs(x) + abs(y)
                    if sign(constant) > 0 and sign(size):
                        yield constant, size

    def check(self) -> bool:
        """Re-verify that the twists are independent, each the only minimizer."""
        return rank_of(self.twists) == 3 and all(map(self._is_unique, (*self.twists, *self.elsewhere)))

    def _is_unique(self, imposed: ImposedTwist) -> bool:
        if self.rays is None:
            return imposed.is_unique
        return isinstance(imposed, BoxTwist) and imposed.is_unique_towards(between(*self.rays))


def in_scene(twist: Triple, length: Fraction) -> Triple:
    """``(v, omega/l)``: a twist of the array with l for its unit of length, in the scene's own; the same speeds."""
    return twist[0], twist[1], twist[2] / length


def rank_of(imposed: Iterable[ImposedTwist]) -> int:
    """How many of the twists are independent."""
    return len(independent([entry.twist for entry in imposed]))


def between(start: Point, end: Point) -> Point:
    """A direction inside a cone of less than a half turn."""
    return start[0] + end[0], start[1] + end[1]


def best_three(unique: Sequence[ImposedTwist]) -> tuple[ImposedTwist, ...]:
    """Three independent ones of twists that span, of the first few those of the largest rate in floats."""
    basis = independent([imposed.twist for imposed in unique])
    few = [*(unique[k] for k in basis), *(imposed for k, imposed in enumerate(unique) if k not in basis)][:CHOICES]
    floats = np.array([[float(x) for x in imposed.twist] for imposed in few])
    choices = np.array(list(combinations(range(len(few)), 3)))
    grams = np.einsum("clr,cls->crs", floats[choices], floats[choices])
    chosen = tuple(few[k] for k in choices[np.argmax(np.linalg.eigvalsh(grams)[:, 0])])
    return chosen if rank_of(chosen) == 3 else tuple(few[:3])


def certified_gain(twists: Sequence[Triple]) -> Fraction:
    """A rational kappa > 0 with ``max_l (g . xi_l)^2 > kappa |g|^2``, just below what the least eigenvalue gives."""
    rows = gram(twists)
    volume, trace = float(inner(cross_product(rows[0], rows[1]), rows[2])), float(rows[0][0] + rows[1][1] + rows[2][2])
    least = np.linalg.eigvalsh(np.array([[float(x) for x in row] for row in rows]))[0]
    kappa = rounded_down(max(least, 4 * volume / trace**2) / len(twists))  # the second bound sees no cancellation
    while not gains(twists, kappa):
        kappa *= _SMALLER
    return kappa


def gains(twists: Sequence[Triple], kappa: Fraction) -> bool:
    """Whether ``sum_l xi_l xi_l^T - m kappa`` is positive definite (Sylvester), m the number of twists.

    Then the largest of the m products ``(g . xi_l)^2`` is more than ``kappa |g|^2``.
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = gram(twists)
    shift = kappa * len(twists)
    rows = (xx - shift, xy, xz), (xy, yy - shift, yz), (xz, yz, zz - shift)
    normal = cross_product(rows[0], rows[1])
    return rows[0][0].sign() > 0 and normal[2].sign() > 0 and inner(normal, rows[2]).sign() > 0


def _rolling_speed(wheel: Wheel, twist: Triple) -> float:
    """The speed at which a wheel does not slip along its friction axis."""
    row = roll_row(wheel)
    if wheel.axis is None:
        return float(inner(row.unit_normal, twist))
    return float(inner(row.normal, twist) / row.gain)


def rim_speeds(scene: Scene, imposed: ImposedTwist) -> tuple[float, ...]:
    """The speeds of all wheels of a centred scene that impose a twist, rounded; both with l for the unit of length.

    Rule ``box``: ``u_i = d_i . v(p_i)``, no rim slips along; with a friction axis ``u_i = a_i . v(p_i)/(a_i . d_i)``.
    Rules without cells: where a wheel slips across, the
    speed turns its force to ``(rho, tau)``: ``u_i = a_i . xi - (beta/alpha) (b_i . xi) rho/tau``, or where its rollers
    turn the rim does not slip.
    """
    speeds = {wheel.index: _rolling_speed(wheel, imposed.twist) for wheel in scene.wheels}
    for index, ratio in imposed.slip_ratios.items():
        wheel = scene.wheels[scene.places[index]]
        across = float(inner(side_row(wheel).unit_normal, imposed.twist))
        speeds[index] -= across * ratio
    return tuple(speeds.values())
