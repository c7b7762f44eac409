"""The twists that are looked at for a law of imposed twists: all pairs of wheels, or the most promising of many.

Two hundred wheels have twenty thousand candidates (:func:`candidate_twists`), and three that are imposed
decide the clause.  A twist is imposed iff the forces that wheels can carry add up to zero.  They are convex sets
within sums of support functions ``sum_i h_i(m)``, which must not be negative in any direction m: floats take the
least over some directions m, in parts of all friction, and propose.  What they propose is decided exactly, and what
they miss is said to be not looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.arrangement import Arrangement, Beside, beyond_floats, order
from nonsmooth.analysis.cells.contact_rule import friction_sets, has_cells, smooth_rule_of
from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.slopes import Slopes, blocks
from nonsmooth.proofs.clauses.feedback.balanced_twists import BalancedTwist, balance_twist, exclude_twist
from nonsmooth.symbolic.mechanics.contact_states import (
    RowKind,
    Triple,
    cross_product,
    independent,
    inner,
    leading_one,
    roll_row,
    scaled,
    side_row,
)
from nonsmooth.symbolic.mechanics.friction_set import Box, FrictionSet, float_sets
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, float_points, row_norms

# ---- realizable twists: the motions that some speeds of the wheels impose under rule ``box`` -----
#
# A twist xi is *realizable* at c if it minimizes D for some speeds.  Then it also does for ``u_i = d_i . v(p_i)``, the
# speeds at which no rim slips along: the friction along a rim may be anything within its limit, and across it has the
# sign of the slip.  So with ``a_k`` the rows, ``beta_k(c)`` their weights and Z all roll rows with the side rows that
# do not slip
#
#     sum_{k not in Z} beta_k s_k a_k  in  sum_{k in Z} [-1, 1] beta_k a_k,
#
# and only the signs ``s_k`` of the side slips count.  Hence the realizable twists are a union of cones of the
# arrangement of the planes ``S_k . xi = 0``, closed and symmetric; with a cone its edges are realizable too, since
# there a sign may be anything in [-1, 1].  So *the realizable edges span all that is realizable*: at most one candidate
# for each pair of wheels.  (Where the side rows do not span, the coordinate planes are added; a finer arrangement has
# the same property.)
#
# The condition is the one of :mod:`nonsmooth.analysis.cells.arrangement`: no slope of D is negative.  Slopes are
# affine in c.  Where all are positive at the equilibrium, they are near it: the twist is the only minimizer there.
#
# *Boxes inside cut friction sets.* Let a cut friction set hold the box ``|f_R| <= rho N, |f_S| <= kappa beta N``, ``rho
# <= alpha sqrt(1 - kappa^2)``, that spans it across the rim.  Then D is at least that of the boxes for every twist, and
# equal where no rim slips along.  So a twist that is the only minimizer for boxes, at speeds at which no rim slips
# along, is the only minimizer under that rule too, at the same places c.  (Rule ``roller``: the rollers turn, ``rho <=
# sqrt(mu_R^2 - mu_S^2)``.)
#
# Of many wheels only the most promising candidates are looked at.


_DIGITS = 10  # binary: candidates have length one up to this
_BITS = 20  # of the rational below sqrt(1 - kappa^2)
_SMALLEST = 2.0**-10  # of sqrt(1 - kappa^2): below it a box holds next to nothing of the set


@dataclass(frozen=True)
class BoxTwist:
    """A twist with the slopes of D there that may vanish at the equilibrium, or first beside it.

    Attributes:
        twist: xi.
        slopes: affine forms of c; xi is not realizable where one is negative.  Where the rows that it satisfies are of
            rank three, it is realizable iff none is negative, and the only minimizer iff all are positive, in each
            square about the equilibrium in which those that are positive there stay so.  Where it is excluded at the
            equilibrium, one that is negative there stands alone.
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
        numbers = table.first_to_vanish() if falling is None else [falling]
        return BoxTwist(twist, tuple(table[k].exact for k in numbers), self.region, len(independent(tight)) == 3)


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


# ---- candidates of many wheels -------------------------------------------------------------------


ENOUGH = 60  # candidates beyond which three independent unique minimizers end the search: a better rate is not sought
LOOKED_AT = 20_000  # wheels times candidates that are looked at: a minute or so under rule ellipse
TIES = 16  # candidates that seem to balance exactly, of which a law by directions of c is made
FEW_OF = 6  # part of them beyond which the search may end
TRIED = 100  # candidates of which it is tried to prove that no speeds impose them
DIRECTIONS = 64  # m: those in which the array has least grip
PAIRS = 20_000  # of planes: all of two hundred wheels
SAME = 2.0**-40  # relative: a wheel slips less than this, or not at all
LEAST_MARGIN = 2.0**-20  # of all friction: below that the margin may be rounding
USED = -1.0  # in place of the margin of a candidate that was proposed
LEAST_ANGLE = 2.0**-13  # of a twist of length one with the span of others: below that it would give no rate

ImposedTwist: TypeAlias = BoxTwist | BalancedTwist


def imposer(scene: Scene, region: LoadRegion) -> Callable[[Triple], ImposedTwist]:
    """What imposes a twist under the rule of the scene."""
    if has_cells(scene):
        return Drives(scene, region).examine
    return partial(balance_twist, scene, region)


def rank_of(imposed: Sequence[ImposedTwist]) -> int:
    """How many of the twists are independent."""
    return len(independent([entry.twist for entry in imposed]))


def unique_ones(imposed: Sequence[ImposedTwist]) -> list[ImposedTwist]:
    """Those that are the only minimizer at the equilibrium."""
    return [entry for entry in imposed if entry.is_unique]


def candidates_of(scene: Scene, region: LoadRegion, enough: int = ENOUGH) -> tuple[list[ImposedTwist], bool]:
    """The candidates, and whether these are all; of many only the most promising.

    The more wheels, the longer each takes, and the fewer are looked at.  The search may end after ``enough``.
    """
    most = LOOKED_AT // len(scene.wheels)
    impose = imposer(scene, region)
    if math.comb(len(scene.wheels), 2) > most:
        return _promising_candidates(scene, region, impose, most), False
    candidates: list[ImposedTwist] = []
    for twist in candidate_twists(scene):
        if len(candidates) >= most:
            return candidates, False
        candidates.append(impose(twist))
        may_end = len(candidates) > min(enough, most // FEW_OF)
        if may_end and candidates[-1].is_unique and rank_of(unique_ones(candidates)) == 3:
            return candidates, False
    return candidates, True


def _promising_candidates(
    scene: Scene, region: LoadRegion, impose: Callable[[Triple], ImposedTwist], most: int
) -> list[ImposedTwist]:
    """Candidates off the span of the unique minimizers found so far, until there are three; then those that may tie."""
    proposals = PromisingTwists(scene, region)
    candidates: list[ImposedTwist] = []
    unique: list[Triple] = []
    while len(unique) < 3 and len(candidates) < most // 2:
        twist = proposals.next(unique)
        if twist is None:
            break
        candidates.append(impose(twist))
        unique += [twist] if candidates[-1].is_unique else []
    if len(unique) < 3:
        candidates += map(impose, proposals.ties(unique, TIES))
    return candidates


def with_exclusions(candidates: Sequence[ImposedTwist]) -> list[ImposedTwist]:
    """The candidates with the proof, where it is sought apart, that no speeds impose them; no more than matters."""
    judged: list[ImposedTwist] = []
    tried = 0
    for candidate in candidates:
        if isinstance(candidate, BalancedTwist) and not candidate.is_unique and tried < TRIED:
            matters = rank_of([entry for entry in judged if not entry.is_excluded]) < 3
            tried += matters
            judged.append(exclude_twist(candidate) if matters else candidate)
        else:
            judged.append(candidate)
    return judged


class PromisingTwists:
    """The candidates of a centred scene in floats, the most promising first.

    Args:
        scene: the array.
        region: of the loads.
    """

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        self._planes = side_planes(scene)
        planes = float_points(self._planes)
        self._pairs = _some_pairs(len(planes))
        edges = np.cross(planes[self._pairs[:, 0]], planes[self._pairs[:, 1]])
        lengths = np.linalg.norm(edges, axis=1, keepdims=True)
        self._edges = np.divide(edges, lengths, out=np.zeros_like(edges), where=lengths > 0)
        grip = _ForceSupports(scene, region)
        self._margin = np.concatenate([grip.margin(block) for block in blocks(self._edges)])

    def next(self, span: Sequence[Triple]) -> Triple | None:
        """The best candidate off the span of these twists; None where there seems to be none.  Each comes once."""
        off = self._off(span)
        return self._take(self._margin * off, (self._margin > LEAST_MARGIN) & (off > LEAST_ANGLE))

    def ties(self, span: Sequence[Triple], most: int) -> Iterator[Triple]:
        """Candidates off the span whose forces seem to balance exactly, those farthest off first."""
        off = self._off(span)
        for _ in range(most):
            twist = self._take(off, (np.abs(self._margin) <= LEAST_MARGIN) & (off > LEAST_ANGLE))
            if twist is None:
                return
            yield twist

    def _off(self, span: Sequence[Triple]) -> Floats:
        """Sine of the angle of each candidate with the span."""
        basis = np.linalg.qr(float_points(span).T)[0] if span else np.zeros((3, 0))
        return row_norms(self._edges - self._edges @ basis @ basis.T)

    def _take(self, merit: Floats, usable: Mask) -> Triple | None:
        """The usable candidate of the largest merit; its multiples are not used again."""
        if not usable.any():
            return None
        best = int(np.argmax(np.where(usable, merit, -1)))
        self._margin[np.abs(self._edges @ self._edges[best]) > 1 - LEAST_ANGLE**2] = USED
        a, b = (self._planes[k] for k in self._pairs[best])
        return edge_of(a, b)


class _ForceSupports:
    """Support functions of the forces that the wheels can carry, in a few directions."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        loads = np.array([float(form[0]) for form in region.forces])
        sets = float_sets(friction_sets(scene))
        rolls = float_points([roll_row(wheel).unit_normal for wheel in scene.wheels])
        self.sides = float_points([side_row(wheel).unit_normal for wheel in scene.wheels])
        along, across = (loads * sets.along)[:, None] * rolls, (loads * sets.across)[:, None] * self.sides
        m = _least_grip(along, across)
        a, b = np.abs(along @ m.T), across @ m.T
        self.all = (a + np.abs(b)).sum(axis=0)
        still = type(sets)(1.0, 1.0, sets.cut[:, None]).support(a, b)
        if isinstance(sets, Box):
            left, right = a - b, a + b
        else:
            left, right = np.where(b < 0, still, a), np.where(b > 0, still, a)
        self.even, self.odd, self.still = (left + right) / 2 - still, (right - left) / 2, still.sum(axis=0)

    def margin(self, twists: Floats) -> Floats:
        """The least support in both senses of each direction, in parts of all friction.

        A wheel that slips to the right adds ``still + even + odd``, one that slips to the left ``still + even - odd``.
        """
        slips = twists @ self.sides.T
        slips[np.abs(slips) <= SAME * (np.abs(twists) @ np.abs(self.sides).T)] = 0
        signs = np.sign(slips)
        least = self.still + np.abs(signs) @ self.even - np.abs(signs @ self.odd)
        return (least / self.all).min(axis=1)


def _least_grip(along: Floats, across: Floats) -> Floats:
    """Of the normals of pairs of rims, and the axes, those in which the rims hold least of what sides may push."""
    pairs = _some_pairs(len(along))
    normals = np.concatenate([np.cross(along[pairs[:, 0]], along[pairs[:, 1]]), np.eye(3)])
    lengths = row_norms(normals)
    m = normals[lengths > lengths.max() * SAME] / lengths[lengths > lengths.max() * SAME, None]
    held, pushed = (
        np.concatenate([np.abs(block @ rows.T).sum(axis=1) for block in blocks(m)]) for rows in (along, across)
    )
    grip = np.divide(held, pushed, out=np.full(len(m), np.inf), where=pushed > 0)
    few = min(DIRECTIONS, len(grip))
    least = np.flatnonzero(grip <= np.partition(grip, few - 1)[few - 1])
    return m[least[np.argsort(grip[least], kind="stable")[:few]]]


def _some_pairs(count: int) -> Indices:
    """All pairs, or of many wheels as many from all over the list."""
    pairs = np.stack(np.triu_indices(count, 1), axis=1)
    return pairs[:: -(-len(pairs) // PAIRS)]
