"""The law of three imposed twists where loads are unknown: one that holds the pose under every load of the set.

On level springs, which are among the loads, speeds impose twists as for loads that are known.  Under other loads they
impose others; where these stay in the pyramids of module ``twist_pyramid``, the law stabilizes under every load, at the
rate ``(1 - eta) kappa``.  Which three twists serve best is proposed by minimizers of D at sampled loads.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np

from nonsmooth.analysis.cells.load_sets import load_set
from nonsmooth.analysis.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.proofs.clauses.every_load.float_loads import FloatLoads, Floats, float_loads
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, least_products, rim_speeds
from nonsmooth.proofs.clauses.feedback.twist_candidates import ImposedTwist, rank_of
from nonsmooth.proofs.clauses.feedback.twist_pyramid import TwistPyramid, WheelForms, wheel_forms
from nonsmooth.symbolic.scene import Scene

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

    def check(self, cone: LawCone) -> bool:
        """Enclose the motions of every load of the set again."""
        if not 0 < self.slack < 1 or cone.rays is not None or rank_of(cone.twists) != 3:
            return False
        loads = float_loads(load_set(self.scene).bound)
        return self.holds(cone.twists, wheel_forms(self.scene), loads)

    def holds(self, three: Sequence[ImposedTwist], wheels: WheelForms, loads: FloatLoads) -> bool:
        """Whether three pyramids hold all motions."""
        twists = _floats(three)
        return all(
            TwistPyramid(
                twists, k, np.array(rim_speeds(self.scene, imposed)), self.slack, self.height
            ).holds_minimizers(wheels, loads)
            for k, imposed in enumerate(three)
        )


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
    loads, wheels = float_loads(load_set(scene).bound), wheel_forms(scene)
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


def _proposals(scene: Scene, unique: Sequence[ImposedTwist], wheels: WheelForms, loads: FloatLoads) -> list[_Proposal]:
    """The most promising choices of three twists, the best first."""
    twists, motions = _floats(unique), [_motions(scene, imposed, wheels, loads) for imposed in unique]
    found = []
    for chosen in combinations(range(len(unique)), 3):
        three = twists[list(chosen)]
        kappa = float(least_products(three[None])[0])
        if kappa < FLATTEST:
            continue
        slack = max(_slack(three, k, motions[index]) for k, index in enumerate(chosen))
        found.append(_Proposal(tuple(unique[k] for k in chosen), kappa, slack))
    promising = sorted(found, key=lambda proposal: -proposal.rate)
    return [proposal for proposal in promising[:TRIED] if proposal.slack < 1]


def _slack(three: Floats, chosen: int, motions: Floats) -> float:
    """The least eta for which the pyramid of one of three twists holds some motions."""
    parts = np.linalg.solve(three.T, (motions - three[chosen]).T)
    upward = parts[chosen]
    return float((np.abs(parts).sum(axis=0) - np.abs(upward) - upward).max(initial=0))


def _motions(scene: Scene, imposed: ImposedTwist, wheels: WheelForms, loads: FloatLoads) -> Floats:
    """Minimizers of D at the speeds of a twist under loads that push the body most, (m, 3); they prove nothing."""
    speeds = np.array(rim_speeds(scene, imposed))
    along, across = wheels.forces(*wheels.slips(_floats([imposed])[0], speeds))
    pulls = along[:, None] * wheels.along + across[:, None] * wheels.across
    samples = loads.samples(SIDES @ pulls.T)
    rule = rule_of(scene)
    is_smooth = isinstance(rule, SmoothRule)
    model = rule.contacts(scene) if isinstance(rule, SmoothRule) else contact_model(scene)
    targets = np.zeros(2 * model.wheels)
    targets[0::2] = speeds
    minimizer = EllipseInterior() if is_smooth else BoxHighs()
    return minimizer.minimize(replace(model, targets=targets), samples).twists


def _floats(imposed: Iterable[ImposedTwist]) -> Floats:
    return np.array([[float(x) for x in entry.twist] for entry in imposed])
