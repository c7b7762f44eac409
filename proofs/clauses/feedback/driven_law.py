"""The law of imposed twists (module ``by_friction``): its three twists, their speeds, and its rate.

*Rate.*  For three independent twists ``max_l (g . xi_l)^2 > kappa |g|^2`` for all nonzero g iff ``kappa |g|^2 < 1``
at the corners ``g . xi_l = +-1`` of a parallelepiped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.rational_bounds import MUCH_BELOW, confirmed, rounded_down
from nonsmooth.proofs.clauses.feedback.twist_candidates import BoxTwist, ImposedTwist, rank_of
from nonsmooth.symbolic.mechanics.contact_states import (
    Triple,
    cross_product,
    independent,
    inner,
    roll_row,
    scaled,
    side_row,
)
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, row_norms

CHOICES = 64  # unique minimizers among which the best three are sought
DIGITS = 8  # binary, of the lengths of twists
CORNERS = ((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1))  # up to the sense


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


def in_scene(twist: Triple, length: Fraction) -> Triple:
    """``(v, omega/l)``: a twist of the array with l for its unit of length, in the scene's own; the same speeds."""
    return twist[0], twist[1], twist[2] / length


def best_three(scene: Scene, unique: Sequence[ImposedTwist]) -> tuple[ImposedTwist, ...]:
    """Three independent ones of twists that span, of the first few those of the least effort, in the lengths that suit.

    A law imposes ``-k (g . xi) xi``, so its fastest rim runs at up to ``k |xi| max_i |u_i|`` for an error ``|g| = 1``.
    Twists of which this *effort* is one are compared: the largest kappa at equal efforts is the least effort at equal
    kappa.  The longest of the chosen twists gets the length one, the others keep their efforts equal to its own.
    """
    basis = independent([imposed.twist for imposed in unique])
    few = [*(unique[k] for k in basis), *(imposed for k, imposed in enumerate(unique) if k not in basis)][:CHOICES]
    factors = np.array([effort(scene, imposed) ** -0.5 for imposed in few])
    vectors = factors[:, None] * float_points(imposed.twist for imposed in few)
    choices = np.array(list(combinations(range(len(few)), 3)))
    best = choices[np.argmax(least_products(vectors[choices]))]
    if rank_of([few[k] for k in best]) < 3:
        best = np.arange(3)  # the basis
    longest = row_norms(vectors[best]).max()
    return tuple(_lengthened(few[k], factors[k] / longest) for k in best)


def effort(scene: Scene, imposed: ImposedTwist) -> float:
    """``|xi| max_i |u_i|``: the speed of the fastest rim for an error ``|g| = 1`` along xi, at gain one."""
    size = float(np.linalg.norm([float(x) for x in imposed.twist]))
    return size * max(map(abs, rim_speeds(scene, imposed)))


def _lengthened(imposed: ImposedTwist, factor: float) -> ImposedTwist:
    """A positive multiple of the twist; speeds, slips and D are multiplied alike, so what imposes it stays evidence."""
    share = Fraction(max(1, round(factor * 2**DIGITS)), 2**DIGITS)
    return replace(imposed, twist=scaled(imposed.twist, imposed.twist[0].field(share)))


def least_products(twists: Floats) -> Floats:
    """The least ``max_l (g . xi_l)^2`` over ``|g| = 1`` for triples of twists (m, 3, 3), shape (m,); zero in a plane.

    ``max_l |g . xi_l| <= 1`` is a parallelepiped, so its corners, ``g . xi_l = +-1``, are farthest from zero.
    """
    normals = np.cross(np.roll(twists, -1, axis=1), np.roll(twists, -2, axis=1))
    volumes = np.einsum("mr,mr->m", twists[:, 0], normals[:, 0])
    corners = np.einsum("sl,mlr->msr", np.array(CORNERS), normals)
    return volumes**2 / np.maximum((corners**2).sum(axis=2).max(axis=1), np.finfo(float).tiny)


def certified_gain(twists: Sequence[Triple]) -> Fraction:
    """A rational kappa > 0 with ``max_l (g . xi_l)^2 > kappa |g|^2``, just below the largest.

    Raises:
        ValueError: where rounding spoils what floats propose.
    """
    volume, corners = _corners(twists)
    proposal = rounded_down(float(volume) ** 2 / max(float(inner(corner, corner)) for corner in corners))
    kappa = confirmed(proposal, lambda value: gains(twists, value), MUCH_BELOW, tries=1000)
    if kappa is None:
        raise ValueError("required twists whose determinant floats tell from zero")
    return kappa


def gains(twists: Sequence[Triple], kappa: Fraction) -> bool:
    """Whether three twists have ``max_l (g . xi_l)^2 > kappa |g|^2`` for all nonzero g, by the corners."""
    if len(twists) != 3:
        return False
    volume, corners = _corners(twists)
    return all(sign(volume * volume - inner(corner, corner) * kappa) > 0 for corner in corners)


def _corners(twists: Sequence[Triple]) -> tuple[Number, list[Triple]]:
    """The determinant, and by Cramer's rule that times the g with ``g . xi_l = s_l`` for the signs of ``CORNERS``."""
    first, second, third = twists
    normals = cross_product(second, third), cross_product(third, first), cross_product(first, second)
    return inner(first, normals[0]), [_signed_sum(normals, signs) for signs in CORNERS]


def _signed_sum(vectors: Sequence[Triple], signs: Sequence[int]) -> Triple:
    (a, b, c), (r, s, t) = vectors, signs
    return a[0] * r + b[0] * s + c[0] * t, a[1] * r + b[1] * s + c[1] * t, a[2] * r + b[2] * s + c[2] * t


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
    ratios = imposed.slip_ratios
    return tuple(_rim_speed(wheel, imposed.twist, ratios) for wheel in scene.wheels)


def _rim_speed(wheel: Wheel, twist: Triple, ratios: Mapping[int, float]) -> float:
    speed, ratio = _rolling_speed(wheel, twist), ratios.get(wheel.index)
    return speed if ratio is None else speed - float(inner(side_row(wheel).unit_normal, twist)) * ratio
