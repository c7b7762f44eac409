"""The twists that are looked at for a law of imposed twists: all pairs of wheels, or the most promising of many.

Two hundred wheels have twenty thousand candidates (:func:`.box_twists.candidate_twists`), and three that are imposed
decide the clause.  A twist is imposed iff the forces that wheels can carry add up to zero.  They are convex sets
within sums of support functions ``sum_i h_i(m)``, which must not be negative in any direction m: floats take the
least over some directions m, in parts of all friction, and propose.  What they propose is decided exactly, and what
they miss is said to be not looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import CellRule, friction_sets, rule_of
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.slopes import blocks
from nonsmooth.proofs.clauses.feedback.balanced_twists import BalancedTwist, balance_twist, exclude_twist
from nonsmooth.proofs.clauses.feedback.box_twists import BoxTwist, Drives, candidate_twists, edge_of, side_planes
from nonsmooth.symbolic.mechanics.constraints import Triple, independent, roll_row, side_row
from nonsmooth.symbolic.mechanics.friction_set import Box, float_sets
from nonsmooth.symbolic.mechanics.scene import Scene

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
Floats: TypeAlias = NDArray[np.float64]


def imposer(scene: Scene, region: LoadRegion) -> Callable[[Triple], ImposedTwist]:
    """What imposes a twist under the rule of the scene."""
    if isinstance(rule_of(scene), CellRule):
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
    found: list[ImposedTwist] = []
    for twist in candidate_twists(scene):
        if len(found) >= most:
            return found, False
        found.append(impose(twist))
        may_end = len(found) > min(enough, most // FEW_OF)
        if may_end and found[-1].is_unique and rank_of(unique_ones(found)) == 3:
            return found, False
    return found, True


def _promising_candidates(
    scene: Scene, region: LoadRegion, impose: Callable[[Triple], ImposedTwist], most: int
) -> list[ImposedTwist]:
    """Candidates off the span of the unique minimizers found so far, until there are three; then those that may tie."""
    proposals = PromisingTwists(scene, region)
    found: list[ImposedTwist] = []
    unique: list[Triple] = []
    while len(unique) < 3 and len(found) < most // 2:
        twist = proposals.next(unique)
        if twist is None:
            break
        found.append(impose(twist))
        unique += [twist] if found[-1].is_unique else []
    if len(unique) < 3:
        found += map(impose, proposals.ties(unique, TIES))
    return found


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
        planes = _floats(self._planes)
        self._pairs = _some_pairs(len(planes))
        edges = np.cross(planes[self._pairs[:, 0]], planes[self._pairs[:, 1]])
        lengths = np.linalg.norm(edges, axis=1, keepdims=True)
        self._edges = np.divide(edges, lengths, out=np.zeros_like(edges), where=lengths > 0)
        grip = _Grip(scene, region)
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
        basis = np.linalg.qr(_floats(span).T)[0] if span else np.zeros((3, 0))
        return np.asarray(np.linalg.norm(self._edges - self._edges @ basis @ basis.T, axis=1))

    def _take(self, merit: Floats, usable: NDArray[np.bool_]) -> Triple | None:
        """The usable candidate of the largest merit; its multiples are not used again."""
        if not usable.any():
            return None
        best = int(np.argmax(np.where(usable, merit, -1)))
        self._margin[np.abs(self._edges @ self._edges[best]) > 1 - LEAST_ANGLE**2] = USED
        a, b = (self._planes[k] for k in self._pairs[best])
        return edge_of(a, b)


class _Grip:
    """Support functions of the forces that the wheels can carry, in a few directions."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        loads = np.array([float(form[0]) for form in region.forces])
        sets = float_sets(friction_sets(scene))
        rolls = _floats([roll_row(wheel).unit_normal for wheel in scene.wheels])
        self.sides = _floats([side_row(wheel).unit_normal for wheel in scene.wheels])
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
        return np.asarray((least / self.all).min(axis=1))


def _least_grip(along: Floats, across: Floats) -> Floats:
    """Of the normals of pairs of rims, and the axes, those in which the rims hold least of what sides may push."""
    pairs = _some_pairs(len(along))
    normals = np.concatenate([np.cross(along[pairs[:, 0]], along[pairs[:, 1]]), np.eye(3)])
    lengths = np.linalg.norm(normals, axis=1)
    m = normals[lengths > lengths.max() * SAME] / lengths[lengths > lengths.max() * SAME, None]
    held, pushed = (
        np.concatenate([np.abs(block @ rows.T).sum(axis=1) for block in blocks(m)]) for rows in (along, across)
    )
    grip = np.divide(held, pushed, out=np.full(len(m), np.inf), where=pushed > 0)
    few = min(DIRECTIONS, len(grip))
    least = np.flatnonzero(grip <= np.partition(grip, few - 1)[few - 1])
    return np.asarray(m[least[np.argsort(grip[least], kind="stable")[:few]]])


def _some_pairs(count: int) -> NDArray[np.int_]:
    """All pairs, or of many wheels as many from all over the list."""
    pairs = np.stack(np.triu_indices(count, 1), axis=1)
    return pairs[:: -(-len(pairs) // PAIRS)]


def _floats(rows: Sequence[Triple]) -> Floats:
    return np.array([[float(x) for x in row] for row in rows])
