"""Clause 2 where loads are unknown: stability of (x, y) under every load, or a load that throws the body out."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.load_sets import Loads
from nonsmooth.proofs.boxes.linearization import Slip, inward_pull
from nonsmooth.proofs.clauses.every_load.cocircular import CocircularArray
from nonsmooth.proofs.clauses.every_load.decay import DecayUnderLoads
from nonsmooth.proofs.clauses.every_load.point import EveryLoad, EveryLoadPoint, is_admissible, load_text
from nonsmooth.proofs.clauses.every_load.wheel_pulls import wheel_slips
from nonsmooth.proofs.clauses.translation.at_point import WithoutCells
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import dot

INWARD = (
    "the friction of every wheel points to the middle at the motion about the point, so c . v < 0 under every load, "
    "also one that changes with time"
)
HURWITZ = "c' = A c to first order, and A is Hurwitz for every load of the set: for loads that depend on the pose alone"
LEMMA = "c . v <= 0 under every load, by the lemma on inward rims on one circle"


@dataclass(frozen=True)
class EveryLoadTranslation(WithoutCells):
    """Clause 2 with its evidence.

    Attributes:
        point: the situation at the point.
        verdict: strong stability of (x, y): under every load, and of every solution.
        reason: one sentence for people.
        lemma: certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses.
        load: a load that throws the body out (unstable).
        region_radius: of a disc in which ``|c|`` does not grow, whatever the load.
        comes_home: whether every body of that disc comes home.
        exponential_rate: a rate at which the distance decays close by, at least.
    """

    point: EveryLoadPoint
    verdict: Translation
    reason: str
    lemma: CocircularArray | None = None
    load: Loads | None = None
    region_radius: Number | None = None
    comes_home: bool = False
    exponential_rate: Number | None = None

    @property
    def worst_rate(self) -> Number | None:
        """Supremum of ``V*/|c|`` over the square: zero where V never grows."""
        return self.point.scene.field.zero if self.lemma is not None or self.comes_home else None

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts from which every body comes home."""
        return self.region_radius if self.comes_home else None

    @property
    def sampled(self) -> None:
        """Nothing is sampled."""


def decide_for_every_load(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    """Decide the clause from the situation at the point."""
    radius = None if lemma is None else point.scene.check.radius
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason, lemma)
    if point.situation in (EveryLoad.CARRIED, EveryLoad.UNIQUE):
        reason = f"{point.situation}: {point.reason}"
        return EveryLoadTranslation(point, Translation.STABLE, reason, lemma, region_radius=radius)
    if point.situation is EveryLoad.SMOOTH:
        return _smooth(point, lemma)
    if lemma is not None:
        return EveryLoadTranslation(point, Translation.STABLE, LEMMA, lemma, region_radius=radius)
    return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason)


def _smooth(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    """By forces to the middle, else by the linearization about rest."""
    slips = None if point.twist is None else wheel_slips(point.scene, point.twist.omega)
    if slips is None or point.slope is None:
        return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason, lemma)
    beta = inward_pull(point.slope)
    if beta is not None and all(wheel.bend for wheel in slips):
        radius = point.scene.check.radius if _are_outside(slips, point.scene.check.radius) else None
        rate = beta / (2 * max(wheel.bend * _squared_reach(wheel) for wheel in slips))
        return EveryLoadTranslation(
            point,
            Translation.ASYMPTOTICALLY_STABLE,
            INWARD,
            lemma,
            region_radius=radius,
            comes_home=True,
            exponential_rate=rate,
        )
    return _by_linearization(point, lemma)


def _are_outside(slips: tuple[Slip[Number], ...], radius: Number) -> bool:
    """Whether no wheel lies in the disc: under a wheel that carries alone the twist is not determined."""
    return all((dot(wheel.position, wheel.position) - radius * radius).sign() > 0 for wheel in slips)


def _squared_reach(slip: Slip[Number]) -> Number:
    """``|w|^2`` of its first two entries."""
    return slip.w[0] * slip.w[0] + slip.w[1] * slip.w[1]


def _decay(point: EveryLoadPoint) -> DecayUnderLoads | None:
    """The linearization about rest; None where the point spins or is not smooth."""
    if point.twist is None or point.slope is None or point.twist.omega:
        return None
    slips = wheel_slips(point.scene, point.twist.omega)
    return None if slips is None else DecayUnderLoads(slips, point.slope, point.loads)


def _by_linearization(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    decay = _decay(point)
    if decay is None:
        reason = "the body spins at the point, and its friction does not point to the middle there"
        return EveryLoadTranslation(point, Translation.UNDECIDED, reason, lemma)
    if decay.is_hurwitz_for_all():
        return EveryLoadTranslation(point, Translation.ASYMPTOTICALLY_STABLE, HURWITZ, lemma)
    load = decay.throwing_load()
    if load is not None and is_admissible(point.scene, load):
        reason = f"under the load {load_text(load)} the linearization has an eigenvalue with a positive real part"
        return EveryLoadTranslation(point, Translation.UNSTABLE, reason, lemma, load)
    return EveryLoadTranslation(point, Translation.UNDECIDED, _why_open(decay), lemma)


def _why_open(decay: DecayUnderLoads) -> str:
    if decay.soft_load is not None:
        return f"under the load {load_text(decay.soft_load)} the Hessian of D is singular at the point"
    return "bounds of trace and determinant over all loads do not show that the linearization is Hurwitz"


def decays_everywhere(found: EveryLoadTranslation) -> bool:
    """Whether the twist is of the order of the distance under every load, so that it adds up to little on the way."""
    decay = _decay(found.point)
    return found.verdict is Translation.ASYMPTOTICALLY_STABLE and decay is not None and decay.soft_load is None


def soft_load_of(found: EveryLoadTranslation) -> Loads | None:
    """A load under which the motion near the point is not determined to first order."""
    decay = _decay(found.point)
    return None if decay is None else decay.soft_load
