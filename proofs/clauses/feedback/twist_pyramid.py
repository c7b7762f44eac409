"""Where the motions lie that given speeds impose under every load of a set.

Loads enter D linearly, and they turn the motion: speeds u_l that impose the twist ``xi_l`` on level springs impose
another one elsewhere.  For three independent twists let ``{j, k, l} = {1, 2, 3}`` and let the *pyramid* of xi_l be ::

    P = {xi_l + sum_m lambda_m xi_m :  |lambda_j| + |lambda_k| <= lambda_l + eta,  lambda_l <= h},    eta, h > 0.

*Decay.*  The law imposes ``-k q_l xi_l``, ``q_m = g . xi_m``, for the largest ``|q_l|``.  If what follows is ``-k q_l
xi`` with xi inside P, then ::

    V'/2 = -k q_l ((1 + lambda_l) q_l + lambda_j q_j + lambda_k q_k)
        <= -k q_l^2 (1 + lambda_l - |lambda_j| - |lambda_k|) < -k (1 - eta) q_l^2 <= -k (1 - eta) kappa |g|^2,

and no larger set of motions has this for all g.

*Enclosure.*  Let every point ``xi_l + d`` of the border have a share ``0 < t <= 1`` with ``D(xi_l + d) > D(xi_l + (1-t)
d)``, under every load.  Then every minimizer is inside P: D is convex, so on the segment from xi_l to a minimizer it
never rises, yet outside of P the segment crosses the border.  The inequality is strict on compact sets: so it holds
near c* too, where loads and slips are nearly the same, whatever the loads do with time.

*Triangles.*  On a triangle of the border with corners a let f_i be any force in the friction set of wheel i.  D per
load is at least ``f_i . slip_i``, and by convexity at most the linear interpolation of its values at the corners: so ::

    min_a min_N sum_i N_i (f_i . slip_i(xi_l + d_a) - D_i(xi_l + (1-t) d_a)) > 0

proves the inequality on all of the triangle.  With f_i at its middle, triangles are halved along all edges until this
holds.  Floats decide, with a bound of their errors that is far above rounding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.contact_rule import SmoothRule, rule_of
from nonsmooth.proofs.clauses.every_load.float_loads import FloatLoads, Floats
from nonsmooth.symbolic.constraints import roll_row, side_row
from nonsmooth.symbolic.friction_set import CutEllipse, float_sets
from nonsmooth.symbolic.scene import Scene

SHARES = (1.0, 0.5, 0.25, 0.125)  # t
FIRST_HALVINGS = 2
MOST_TRIANGLES = 20_000  # of one pyramid: some tenths of a second
BATCH = 2_000_000  # numbers in one array: triangles times corners of the set of loads


@dataclass(frozen=True, eq=False)
class WheelForms:
    """The wheels of an array in floats, per unit of load.

    Attributes:
        along: rows of the slip along each rim, (n, 3).
        across: rows of the slip across, (n, 3).
        limits: half-axes of the friction sets along and across, (n, 2).
        sets: the friction sets; none where they are boxes.
    """

    along: Floats
    across: Floats
    limits: Floats
    sets: CutEllipse[Floats] | None

    def forces(self, along: Floats, across: Floats) -> tuple[Floats, Floats]:
        """The forces that slips (..., n) meet, along and across; any in the set where a wheel does not slip."""
        if self.sets is None:
            return self.limits[:, 0] * np.sign(along), self.limits[:, 1] * np.sign(across)
        return self.sets.gradient(along, across)

    def slips(self, twists: Floats, speeds: Floats) -> tuple[Floats, Floats]:
        """Slips along and across, (..., n)."""
        return twists @ self.along.T - speeds, twists @ self.across.T

    def dissipation(self, twists: Floats, speeds: Floats) -> Floats:
        """``D_i`` per load, (..., n)."""
        along, across = self.slips(twists, speeds)
        first, second = self.forces(along, across)
        power: Floats = first * along + second * across
        return power

    def sizes(self, twists: Floats, speeds: Floats) -> Floats:
        """Sums of the absolute values of all terms of ``D_i``, (..., n)."""
        along = np.abs(twists) @ np.abs(self.along).T + np.abs(speeds)
        size: Floats = self.limits[:, 0] * along + self.limits[:, 1] * (np.abs(twists) @ np.abs(self.across).T)
        return size


def wheel_forms(scene: Scene) -> WheelForms:
    """The wheels of a centred scene of a rule that minimizes the dissipation, each number rounded once."""
    rule = rule_of(scene)
    along = np.array([[float(x) for x in roll_row(wheel).unit_normal] for wheel in scene.wheels])
    across = np.array([[float(x) for x in side_row(wheel).unit_normal] for wheel in scene.wheels])
    if not isinstance(rule, SmoothRule):
        limits = [[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels]
        return WheelForms(along, across, np.array(limits), None)
    sets = float_sets(rule.friction_set(wheel.friction) for wheel in scene.wheels)
    return WheelForms(along, across, np.column_stack([sets.along, sets.across]), sets)


@dataclass(frozen=True, eq=False)
class TwistPyramid:
    """The pyramid of one of three twists.

    Attributes:
        twists: the three, (3, 3).
        chosen: l.
        speeds: of all wheels, which are to impose it, (n,).
        slack: eta.
        height: h.
    """

    twists: Floats
    chosen: int
    speeds: Floats
    slack: Fraction
    height: Fraction

    def holds_minimizers(self, wheels: WheelForms, loads: FloatLoads) -> bool:
        """Whether every minimizer of D under every load is proved to lie inside."""
        waiting = self._border()
        for _ in range(FIRST_HALVINGS):
            waiting = _halved(waiting)
        seen = len(waiting)
        while len(waiting):
            parts = np.array_split(waiting, 1 + waiting.shape[0] * loads.centres.shape[0] * 3 // BATCH)
            judged = [self._judge(part, wheels, loads) for part in parts]
            if any(lost for _, lost in judged):
                return False
            waiting = _halved(np.concatenate([open_ones for open_ones, _ in judged]))
            seen += len(waiting)
            if seen > MOST_TRIANGLES:
                return False
        return True

    def _border(self) -> Floats:
        """Triangles of the border, as differences to the twist, (8, 3, 3)."""
        eta, height = float(self.slack), float(self.height)
        axes = np.roll(np.eye(3), -self.chosen, axis=0)
        up, first, second = axes
        top, reach = height * up, height + eta
        edge = [top + reach * side for side in (first, second, -first, -second)]
        sides = list(zip(edge, [*edge[1:], edge[0]], strict=True))
        triangles = [(end, a, b) for end in (-eta * up, top) for a, b in sides]
        return np.array(triangles) @ self.twists

    def _judge(self, triangles: Floats, wheels: WheelForms, loads: FloatLoads) -> tuple[Floats, bool]:
        """The triangles that are not proved, and whether one of them cannot be: D is not larger at its middle."""
        centre = self.twists[self.chosen]
        middles = triangles.mean(axis=1)
        forces = wheels.forces(*wheels.slips(centre + middles, self.speeds))
        along, across = wheels.slips(centre + triangles, self.speeds)
        least = forces[0][:, None] * along + forces[1][:, None] * across
        there = wheels.dissipation(centre + middles, self.speeds)
        doubt = loads.doubt(2 * wheels.sizes(np.abs(centre) + np.abs(triangles), self.speeds)).max(axis=1)
        proved, possible = np.zeros(len(triangles), dtype=bool), np.zeros(len(triangles), dtype=bool)
        for share in SHARES:
            inner = wheels.dissipation(centre + (1 - share) * triangles, self.speeds)
            proved |= loads.lowest(least - inner).min(axis=1) > doubt
            nearer = wheels.dissipation(centre + (1 - share) * middles, self.speeds)
            possible |= loads.lowest(there - nearer) > doubt
        return triangles[~proved], bool((~proved & ~possible).any())


def _halved(triangles: Floats) -> Floats:
    """Four triangles for each."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.concatenate([np.stack(corners, axis=1) for corners in _quarters(a, b, c, ab, bc, ca)])


def _quarters(a: Floats, b: Floats, c: Floats, ab: Floats, bc: Floats, ca: Floats) -> Iterator[Sequence[Floats]]:
    yield from ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
