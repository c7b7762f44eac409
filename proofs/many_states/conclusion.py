"""What follows from the evidence on a system in three states and more: verdict, reason, and what decided."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.many_states.escape import Velocity
from nonsmooth.proofs.many_states.examined_lyapunov import ExaminedLyapunov
from nonsmooth.proofs.many_states.instability import GrowthEvidence
from nonsmooth.proofs.many_states.linear_part import LinearPart, Spectrum
from nonsmooth.proofs.many_states.relay_degree import RelayDegree
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.invariance import Staying
from nonsmooth.proofs.systems.stability_result import UNDECIDED_BY
from nonsmooth.proofs.verdicts import Equilibrium, Translation


class ManyStateMethod(StrEnum):
    """What decided."""

    EQUILIBRIUM = "no equilibrium"
    LYAPUNOV = "Lyapunov function"
    INVARIANCE = "invariance principle"
    LINEARIZATION = "linearization"
    ESCAPE = "solution that leaves"
    RELAY = "relative degree of a relay"
    GROWTH = "function that shows instability"
    NONE = UNDECIDED_BY


@dataclass(frozen=True)
class StabilityEvidence:
    """All that is known of the point.

    Attributes:
        equilibrium: whether 0 is in F.
        linear: the linearization; None where there is none, or it was not reached.
        escape: a velocity with which a solution leaves the point; None where none is found.
        ray_rate: a lower bound of the rate at which solutions leave along a ray in a cone; None where none is found.
        relay: a switching surface that shows instability by its relative degree; None where none does.
        named: the V of the scene (without one the sum of squares of the states).
        searched: a V that was searched and falls; None where none was needed or found.
        growth: a V that shows instability; None where none was needed or found.
        attraction: LaSalle's principle with its evidence, as a certificate holds it, where the V that shows stability
            does not fall everywhere; None where that was not needed or not found.
        beyond: why the system is not looked at; empty where it is.
    """

    equilibrium: Equilibrium
    linear: LinearPart | None = None
    escape: Velocity | None = None
    ray_rate: Fraction | None = None
    relay: RelayDegree | None = None
    named: ExaminedLyapunov | None = None
    searched: ExaminedLyapunov | None = None
    growth: GrowthEvidence | None = None
    beyond: str = ""
    attraction: dict[str, Any] | None = None

    @property
    def proving(self) -> ExaminedLyapunov | None:
        """The V that shows stability."""
        if self.searched is not None:
            return self.searched
        shows = self.named is not None and self.named.examination.verdict in (Decrease.STRICT, Decrease.WEAK)
        return self.named if shows else None


def conclude(evidence: StabilityEvidence) -> tuple[Translation, str, ManyStateMethod]:
    """Verdict, reason and what decided."""
    return _by_leaving(evidence) or _by_functions(evidence)


def _by_leaving(evidence: StabilityEvidence) -> tuple[Translation, str, ManyStateMethod] | None:
    """What shows near the point that solutions leave it."""
    spectrum = None if evidence.linear is None else evidence.linear.spectrum
    if evidence.equilibrium is Equilibrium.FAILS:
        return Translation.UNSTABLE, "0 is not in F there, so every solution leaves it", ManyStateMethod.EQUILIBRIUM
    if evidence.escape is not None:
        place = ", ".join(map(str, evidence.escape))
        return (
            Translation.UNSTABLE,
            f"a solution leaves the point with velocity ({place}), into a cell",
            ManyStateMethod.ESCAPE,
        )
    if evidence.ray_rate is not None:
        return (
            Translation.UNSTABLE,
            "solutions leave along a ray inside a cone with a linear field",
            ManyStateMethod.ESCAPE,
        )
    if evidence.relay is not None:
        order = f"derivative {evidence.relay.degree} of the switching function is the first that depends on its sign"
        return Translation.UNSTABLE, f"{order}, and a function of the others never falls", ManyStateMethod.RELAY
    if spectrum in (Spectrum.UNSTABLE, Spectrum.GROWING):
        return Translation.UNSTABLE, str(spectrum), ManyStateMethod.LINEARIZATION
    return None


def _by_functions(evidence: StabilityEvidence) -> tuple[Translation, str, ManyStateMethod]:
    """What a V or a stable linearization shows."""
    spectrum = None if evidence.linear is None else evidence.linear.spectrum
    proving = evidence.proving
    if proving is not None and proving.examination.verdict is Decrease.STRICT:
        return Translation.ASYMPTOTICALLY_STABLE, proving.examination.reason, ManyStateMethod.LYAPUNOV
    if proving is not None and proving.examination.verdict is Decrease.WEAK and evidence.attraction is not None:
        return (
            Translation.ASYMPTOTICALLY_STABLE,
            f"{proving.examination.reason}, and {Staying.NONE}",
            ManyStateMethod.INVARIANCE,
        )
    if spectrum is Spectrum.HURWITZ:
        return Translation.ASYMPTOTICALLY_STABLE, str(spectrum), ManyStateMethod.LINEARIZATION
    if evidence.growth is not None:
        return (
            Translation.UNSTABLE,
            "V falls along every solution, from negative values at all distances",
            ManyStateMethod.GROWTH,
        )
    return _by_weak_evidence(evidence)


def _by_weak_evidence(evidence: StabilityEvidence) -> tuple[Translation, str, ManyStateMethod]:
    """What is said where nothing decides whether solutions attract."""
    if evidence.linear is not None and evidence.linear.spectrum is Spectrum.NEUTRAL:
        return Translation.STABLE, f"not asymptotically: {evidence.linear.spectrum}", ManyStateMethod.LINEARIZATION
    if evidence.proving is not None:
        why = "whether the equilibrium attracts is not decided by it"
        return Translation.STABLE, f"{evidence.proving.examination.reason}; {why}", ManyStateMethod.LYAPUNOV
    reason = evidence.beyond or "no Lyapunov function was found, and none that shows instability"
    return Translation.UNDECIDED, reason, ManyStateMethod.NONE
