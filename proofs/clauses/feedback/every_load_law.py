"""The law of three imposed twists where loads are unknown: one that holds the pose under every load of the set.

On level springs, which are among the loads, speeds impose twists as for loads that are known. Loads enter D linearly,
and they turn the motion: speeds u_l that impose the twist ``xi_l`` on level springs impose another one elsewhere. For
three independent twists let ``{j, k, l} = {1, 2, 3}`` and let the *pyramid* of xi_l be ::

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

Which three twists serve best is proposed by minimizers of D at sampled loads.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np

from nonsmooth.analysis.cells.contact_rule import friction_sets, has_cells
from nonsmooth.analysis.cells.load_sets import load_set
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model, with_friction_sets
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.proofs.clauses.at_point.every_load import FloatLoads, float_loads
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, least_products, rim_speeds
from nonsmooth.proofs.clauses.feedback.twist_candidates import ImposedTwist
from nonsmooth.symbolic.mechanics.contact_states import roll_row, side_row
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points

# Directions of force and moment in which loads are sampled that push the body most: of a cube's faces, edges, corners.
SIDES = np.array([side for side in product((-1.0, 0.0, 1.0), repeat=3) if any(side)])
CHOICES = 16  # unique minimizers among which three are sought
FLATTEST = 2.0**-20  # kappa of three twists that are looked at
TRIED = 6  # choices of three twists
LEAST = 2.0**-10  # eta
WIDER, WIDENING = 1.1, 1.6  # than the sampled motions ask for, at first and from one try to the next
WIDEST = Fraction(63, 64)  # eta; where that does not hold all motions, less is not tried
HEIGHT, LOWEST = 2, Fraction(1, 8)  # of pyramids: so many eta, but no less than this
DIGITS = 2**12
SHARES = (1.0, 0.5, 0.25, 0.125)  # t
FIRST_HALVINGS = 2
MOST_TRIANGLES = 20_000  # of one pyramid: some tenths of a second
BATCH = 2_000_000  # numbers in one array: triangles times corners of the set of loads

# ---- the law -----------------------------------------------------------------------------


@dataclass(frozen=True)
class EveryLoadLaw:
    """The evidence that a law holds the pose under every load of a set.

    Attributes:
        scene: the array with l for its unit of length, centred, its loads unknown.
        slack: eta: under every load the law works at a rate of ``(1 - eta) kappa`` or more.
    """

    scene: Scene
    slack: Fraction

    @property
    def height(self) -> Fraction:
        """Of the pyramids."""
        return max(HEIGHT * self.slack, LOWEST)

    @property
    def largest(self) -> Fraction:
        """No motion is longer than so many times the longest twist: ``1 + h + (h + eta)``."""
        return 1 + 2 * self.height + self.slack

    def holds(self, three: Sequence[ImposedTwist], wheels: ContactModel, loads: FloatLoads) -> bool:
        """Whether three pyramids hold all motions."""
        driven = (driven_by(self.scene, imposed, wheels) for imposed in three)
        pyramids = (TwistPyramid(_floats(three), k, self.slack, self.height) for k in range(3))
        return all(pyramid.holds_minimizers(rows, loads) for pyramid, rows in zip(pyramids, driven, strict=True))


def wheels_of(scene: Scene) -> ContactModel:
    """The wheels of a centred scene of a rule that minimizes the dissipation, with their friction sets.

    Every exact number of their rows is rounded once: products of floats would cancel in the moments, and doubts about
    the dissipation count rows by their sizes.
    """
    rows = float_points(row(wheel).unit_normal for wheel in scene.wheels for row in (roll_row, side_row))
    return with_friction_sets(replace(contact_model(scene), rows=rows), friction_sets(scene))


def driven_by(scene: Scene, imposed: ImposedTwist, wheels: ContactModel) -> ContactModel:
    """The wheels at the speeds that impose a twist on level springs."""
    targets = np.zeros(2 * wheels.wheels)
    targets[0::2] = rim_speeds(scene, imposed)
    return replace(wheels, targets=targets)


def on_level_springs(scene: Scene) -> Scene:
    """The array with one load that is among the unknown ones: springs of equal height and stiffness."""
    return replace(scene, contact=replace(scene.contact, loads=None))


def search_law(scene: Scene, unique: Sequence[ImposedTwist]) -> tuple[LawCone, EveryLoadLaw] | None:
    """The best law found of twists that speeds impose on level springs; None where none is proved.

    Args:
        scene: the centred array with l for its unit of length, its loads unknown.
        unique: the only minimizers on level springs, for some speeds.

    Raises:
        LoadError: where the loads do not exist, or are too many.
    """
    loads, wheels = float_loads(load_set(scene).bound), wheels_of(scene)
    best: tuple[float, tuple[ImposedTwist, ...], EveryLoadLaw] | None = None
    for proposal in _proposals(scene, unique[:CHOICES], wheels, loads):
        widest = EveryLoadLaw(scene, WIDEST)
        if (best is not None and proposal.rate <= best[0]) or not widest.holds(proposal.three, wheels, loads):
            continue
        for law in (*proposal.laws(scene), widest):
            rate = float(1 - law.slack) * proposal.kappa
            if best is not None and rate <= best[0]:
                break
            if law.holds(proposal.three, wheels, loads):
                best = rate, proposal.three, law
                break
    return None if best is None else (LawCone(None, best[1]), best[2])


@dataclass(frozen=True, eq=False)
class _Proposal:
    """Three twists with the rate on level springs, and the slack that sampled loads ask for."""

    three: tuple[ImposedTwist, ...]
    kappa: float
    slack: float

    @property
    def rate(self) -> float:
        return (1 - self.slack) * self.kappa

    def laws(self, scene: Scene) -> Iterator[EveryLoadLaw]:
        slack = max(self.slack * WIDER, LEAST)
        while slack < WIDEST:
            yield EveryLoadLaw(scene, Fraction(int(slack * DIGITS), DIGITS))
            slack *= WIDENING


def _proposals(
    scene: Scene, unique: Sequence[ImposedTwist], wheels: ContactModel, loads: FloatLoads
) -> list[_Proposal]:
    """The most promising choices of three twists, the best first."""
    twists, motions = _floats(unique), [_motions(scene, imposed, wheels, loads) for imposed in unique]
    proposals = []
    for chosen in combinations(range(len(unique)), 3):
        three = twists[list(chosen)]
        kappa = float(least_products(three[None])[0])
        if kappa < FLATTEST:
            continue
        slack = max(_slack(three, k, motions[index]) for k, index in enumerate(chosen))
        proposals.append(_Proposal(tuple(unique[k] for k in chosen), kappa, slack))
    promising = sorted(proposals, key=lambda proposal: -proposal.rate)
    return [proposal for proposal in promising[:TRIED] if proposal.slack < 1]


def _slack(three: Floats, chosen: int, motions: Floats) -> float:
    """The least eta for which the pyramid of one of three twists holds some motions."""
    parts = np.linalg.solve(three.T, (motions - three[chosen]).T)
    upward = parts[chosen]
    return float((np.abs(parts).sum(axis=0) - np.abs(upward) - upward).max(initial=0))


def _motions(scene: Scene, imposed: ImposedTwist, wheels: ContactModel, loads: FloatLoads) -> Floats:
    """Minimizers of D at the speeds of a twist under loads that push the body most, (m, 3); they prove nothing."""
    driven = driven_by(scene, imposed, wheels)
    forces = _forces(driven, _floats([imposed]))[0]
    samples = loads.samples(SIDES @ np.einsum("nk,nkj->jn", forces, driven.rows.reshape(-1, 2, 3)))
    minimizer = BoxHighs() if has_cells(scene) else EllipseMinimizer()
    return minimizer.minimize(driven, samples).twists


# ---- pyramids that hold all motions ------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TwistPyramid:
    """The pyramid of one of three twists.

    Attributes:
        twists: the three, (3, 3).
        chosen: l.
        slack: eta.
        height: h.
    """

    twists: Floats
    chosen: int
    slack: Fraction
    height: Fraction

    def holds_minimizers(self, driven: ContactRows, loads: FloatLoads) -> bool:
        """Whether every minimizer of D at the speeds of the wheels is proved to lie inside, under every load."""
        waiting = self._border()
        for _ in range(FIRST_HALVINGS):
            waiting = _halved(waiting)
        seen = len(waiting)
        while len(waiting):
            parts = np.array_split(waiting, 1 + waiting.shape[0] * loads.centres.shape[0] * 3 // BATCH)
            judged = [self._judge(part, driven, loads) for part in parts]
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

    def _judge(self, triangles: Floats, driven: ContactRows, loads: FloatLoads) -> tuple[Floats, bool]:
        """The triangles that are not proved, and whether one of them cannot be: D is not larger at its middle."""
        centre = self.twists[self.chosen]
        middles = triangles.mean(axis=1)
        forces = _forces(driven, centre + middles)
        least = (forces[:, None] * driven.slips(centre + triangles)).sum(axis=-1)
        there = _dissipation(driven, centre + middles)
        doubt = loads.doubt(2 * _sizes(driven, np.abs(centre) + np.abs(triangles))).max(axis=1)
        proved, possible = np.zeros(len(triangles), dtype=bool), np.zeros(len(triangles), dtype=bool)
        for share in SHARES:
            inner = _dissipation(driven, centre + (1 - share) * triangles)
            proved |= loads.lowest(least - inner).min(axis=1) > doubt
            nearer = _dissipation(driven, centre + (1 - share) * middles)
            possible |= loads.lowest(there - nearer) > doubt
        return triangles[~proved], bool((~proved & ~possible).any())


def _forces(driven: ContactRows, twists: Floats) -> Floats:
    """Along and across, some force of each set that its slip allows, per load, (..., n, 2)."""
    return np.stack(driven.sets.gradient(*np.moveaxis(driven.slips(twists), -1, 0)), axis=-1)


def _dissipation(driven: ContactRows, twists: Floats) -> Floats:
    """``D_i`` per load, (..., n)."""
    return np.asarray(driven.sets.support(*np.moveaxis(driven.slips(twists), -1, 0)))


def _sizes(driven: ContactRows, twists: Floats) -> Floats:
    """Sums of the absolute values of all terms of ``D_i``, (..., n)."""
    terms = (np.abs(twists) @ np.abs(driven.rows).T + np.abs(driven.targets)) * driven.friction
    return np.asarray(terms.reshape(*terms.shape[:-1], -1, 2).sum(axis=-1))


def _halved(triangles: Floats) -> Floats:
    """Four triangles for each."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(corners, axis=1) for corners in parts])


def _floats(imposed: Iterable[ImposedTwist]) -> Floats:
    return float_points(entry.twist for entry in imposed)
