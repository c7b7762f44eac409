"""Realizable twists: the motions that some speeds of the wheels impose under rule ``box``.

A twist xi is *realizable* at c if it minimizes D for some speeds.  Then it also does for ``u_i = d_i . v(p_i)``, the
speeds at which no rim slips along: the friction along a rim may be anything within its limit, and across it has the
sign of the slip.  So with ``a_k`` the rows, ``beta_k(c)`` their weights and Z all roll rows with the side rows that
do not slip

    sum_{k not in Z} beta_k s_k a_k  in  sum_{k in Z} [-1, 1] beta_k a_k,

and only the signs ``s_k`` of the side slips count.  Hence the realizable twists are a union of cones of the
arrangement of the planes ``S_k . xi = 0``, closed and symmetric; with a cone its edges are realizable too, since
there a sign may be anything in [-1, 1].  So *the realizable edges span all that is realizable*: at most one candidate
for each pair of wheels.  (Where the side rows do not span, the coordinate planes are added; a finer arrangement has
the same property.)

The condition is the one of :mod:`nonsmooth.analysis.cells.arrangement`: no slope of D is negative.  Slopes are
affine in c.  Where all are positive at the equilibrium, they are near it: the twist is the only minimizer there.

*Boxes inside cut friction sets.*  Let a cut friction set hold the box ``|f_R| <= rho N, |f_S| <= kappa beta N``, ``rho
<= alpha sqrt(1 - kappa^2)``, that spans it across the rim.  Then D is at least that of the boxes for every twist, and
equal where no rim slips along.  So a twist that is the only minimizer for boxes, at speeds at which no rim slips along,
is the only minimizer under that rule too, at the same places c.  (Rule ``roller``: the rollers turn, ``rho <=
sqrt(mu_R^2 - mu_S^2)``.)

Of many wheels only the most promising candidates are looked at (module ``twist_candidates``).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np

from nonsmooth.analysis.cells.arrangement import Arrangement, Beside, beyond_floats, order
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.symbolic.mechanics.constraints import (
    RowKind,
    Triple,
    cross_product,
    independent,
    inner,
    leading_one,
    scaled,
    side_row,
)
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.numbers.number import Number, sign

_DIGITS = 10  # binary: candidates have length one up to this
_BITS = 20  # of the rational below sqrt(1 - kappa^2)
_SMALLEST = 2.0**-10  # of sqrt(1 - kappa^2): below it a box holds next to nothing of the set


@dataclass(frozen=True)
class BoxTwist:
    """A twist with the slopes of D there that are not certainly positive in a load region.

    Attributes:
        twist: xi.
        slopes: affine forms of c; xi is not realizable where one is negative.  Where the rows that it satisfies are of
            rank three, it is realizable iff none is negative, and the only minimizer iff all are positive.  Where it
            is excluded at the equilibrium, one that is negative there stands alone.
        region: where the forms hold.
        determined: whether the rows that it satisfies are of rank three; if not, it is nowhere the only minimizer.
    """

    twist: Triple
    slopes: tuple[Affine, ...]
    region: LoadRegion
    determined: bool

    @property
    def is_excluded(self) -> bool:
        """Whether it is not realizable at the equilibrium, hence nowhere near it."""
        return any(sign(form[0]) < 0 for form in self.slopes)

    @property
    def is_unique(self) -> bool:
        """Whether it is the only minimizer at the equilibrium, hence everywhere near it."""
        return self.determined and all(sign(form[0]) > 0 for form in self.slopes)

    def is_unique_towards(self, direction: Point) -> bool:
        """Whether it is the only minimizer at ``epsilon direction``, for all small epsilon > 0."""
        place = Beside((direction[0] * 0, direction[1] * 0), direction)
        return self.determined and all(order(form, place) > (0, 0) for form in self.slopes)

    @property
    def slip_ratios(self) -> dict[int, float]:
        """No rim slips along."""
        return {}

    @property
    def ties(self) -> list[Affine]:
        """The slopes that vanish at the equilibrium: what their sign is beside it depends on the direction."""
        return [form for form in self.slopes if not sign(form[0])]


class Drives:
    """What the wheels of one load region can impose."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        self.region = region
        self._arrangement = Arrangement(scene, region)

    @beyond_floats
    def examine(self, twist: Triple) -> BoxTwist:
        """The twist with its slopes, for speeds at which no rim slips along; of an excluded one a negative slope."""
        rows = self._arrangement.rows
        slips = (0 if row.kind is RowKind.ROLL else sign(inner(row.normal, twist)) for row in rows)
        signs = np.fromiter(slips, dtype=int, count=len(rows))
        tight = [row.normal for row, slip in zip(rows, signs, strict=True) if not slip]
        table = Slopes(self._arrangement, signs)
        falling, _ = table.at(np.array([1.0, 0.0, 0.0]))
        slopes = table if falling is None else (table[falling],)
        return BoxTwist(twist, tuple(slope.exact for slope in slopes), self.region, len(independent(tight)) == 3)


# ---- candidates --------------------------------------------------------------------------


def candidate_twists(scene: Scene) -> Iterator[Triple]:
    """The edges of the arrangement of side rows, each once (up to a factor), of length about one."""
    known: set[Triple] = set()
    for a, b in combinations(side_planes(scene), 2):
        edge = cross_product(a, b)
        if any(edge) and (canonical := leading_one(edge)) not in known:
            known.add(canonical)
            yield _of_length_one(canonical)


def side_planes(scene: Scene) -> list[Triple]:
    """The planes of twists at which a wheel does not slip; with the coordinate planes where these do not span."""
    planes = [side_row(wheel).normal for wheel in scene.wheels]
    if len(independent(planes)) < 3:
        zero, one = scene.field.zero, scene.field.one
        planes += [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
    return planes


def edge_of(first: Triple, second: Triple) -> Triple:
    """The candidate in two planes that differ."""
    return _of_length_one(leading_one(cross_product(first, second)))


def _of_length_one(twist: Triple) -> Triple:
    """A positive multiple of length one, up to the rounding of a rational factor."""
    unit = scaled(twist, max(abs(x) for x in twist).inverse())
    length = float(np.linalg.norm([float(x) for x in unit]))
    return scaled(unit, unit[0].field(Fraction(round(2**_DIGITS / length), 2**_DIGITS)))


# ---- boxes inside cut friction sets ------------------------------------------------------


def inscribed_boxes(scene: Scene) -> Scene | None:
    """The array under rule ``box`` with boxes inside the friction sets; None where a set is not cut, or hardly not."""
    rule, wheels = smooth_rule_of(scene), []
    for wheel in scene.wheels:
        limits = rule.friction_set(wheel.friction)
        width = box_width(limits)
        if width is None:
            return None
        wheels.append(replace(wheel, friction=Friction(limits.along * width, limits.across * limits.cut)))
    return replace(scene.under("box"), wheels=tuple(wheels))


def box_width(limits: FrictionSet) -> Fraction | None:
    """A rational of at most ``sqrt(1 - kappa^2)``: one for a segment along the rim, None for a whole ellipse."""
    if not limits.across:
        return Fraction(1)
    if not limits.is_cut:
        return None
    proposal = math.sqrt(1 - float(limits.cut) ** 2)
    width = Fraction(math.floor(proposal * 2**_BITS) - 1, 2**_BITS)
    return width if proposal > _SMALLEST and fits(limits.cut, width) else None


def fits(cut: Number, width: Fraction) -> bool:
    """Whether the corner (width, kappa) is in the unit disc, exactly."""
    return bool(cut * cut + width * width <= 1)
