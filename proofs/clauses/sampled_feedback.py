"""Clause 4 under the rules ``box`` and ``ellipse``: torque authority exactly, the closed loop by sampling.

No certificate is available where the motion depends on all inputs at once.  What is exact: without full torque
authority, twist tracking asks nothing of any wheel when the wanted motion is a missing twist; at the equilibrium
turned by theta that is rest, so ``V' = 0``.  What is sampled: the worst rate of V under the two laws of
:mod:`nonsmooth.analysis.fields.closed_loop`.  A witness refutes a law; without one the clause stays undecided.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.authority import Authority, roll_authority
from nonsmooth.proofs.clauses.translation import Witness
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene

if TYPE_CHECKING:
    from nonsmooth.analysis.fields.closed_loop import LoopSample

# Random states per law, each one minimization (a linear program of a millisecond under rule box); the search adds
# a few hundred.
STATES = {Rule.BOX: 100, Rule.ELLIPSE: 1_000}


@dataclass(frozen=True)
class SampledFeedback:
    """Verdict with the sampled laws.

    Attributes:
        verdict: not applicable, no certificate (every law is refuted) or undecided (one is not).
        laws: the sampled laws, best first.
        authority: rank of the roll rows at the equilibrium.
        witness: a point at which twist tracking is refuted exactly, where authority is missing.
        reason: one sentence for people.
    """

    verdict: Feedback
    laws: tuple[LoopSample, ...]
    authority: Authority
    witness: Witness | None
    reason: str

    @property
    def law(self) -> str | None:
        """The most promising law, where one is not refuted."""
        return str(self.laws[0].law) if self.verdict is Feedback.UNDECIDED else None

    def check(self) -> bool:
        """Whether the verdict follows from the samples; sampling itself proves nothing."""
        match self.verdict:
            case Feedback.NO_CERTIFICATE:
                return bool(self.laws) and all(sample.refuted for sample in self.laws)
            case Feedback.UNDECIDED:
                return bool(self.laws) and not self.laws[0].refuted
            case verdict:
                return verdict is Feedback.NOT_APPLICABLE


def sample_feedback(scene: Scene, blocked: str | None) -> SampledFeedback:
    """Sample both laws for a centred scene.

    Args:
        scene: the array, under rule ``box`` or ``ellipse``.
        blocked: why the clause does not apply, if so.
    """
    authority = roll_authority(scene)
    if blocked is not None:
        return SampledFeedback(Feedback.NOT_APPLICABLE, (), authority, None, blocked)
    from nonsmooth.analysis.fields.closed_loop import Law, sample_closed_loop
    from nonsmooth.analysis.fields.contact_model import contact_model
    from nonsmooth.analysis.minimizers.dissipation import Functional

    box = scene.contact.rule is Rule.BOX
    functional = Functional.BOX if box else Functional.ELLIPSE
    model, radius = contact_model(scene), float(scene.check.radius)
    samples = [sample_closed_loop(model, functional, law, radius, STATES[scene.contact.rule]) for law in Law]
    laws = tuple(sorted(samples, key=lambda sample: sample.worst_rate))
    best = laws[0]
    shown = f"{best.law}: largest V'/V found {best.worst_rate:.3g} k over {best.states} states"
    if best.refuted:
        x, y, theta = best.worst_state
        reason = f"sampled: both laws fail; {best.law} at (x, y, theta) = ({x:.4g}, {y:.4g}, {theta:.4g})"
        return SampledFeedback(Feedback.NO_CERTIFICATE, laws, authority, _spin_witness(scene, authority), reason)
    return SampledFeedback(Feedback.UNDECIDED, laws, authority, None, f"sampled, not proved: {shown}")


def _spin_witness(scene: Scene, authority: Authority) -> Witness | None:
    """The turned equilibrium, where the missing twist is the rotation about it."""
    zero, one = scene.field.zero, scene.field.one
    if (zero, zero, one) in authority.missing:
        return Witness((zero, zero), one, "twist tracking asks nothing of any wheel at c = c* and this theta: V' = 0")
    return None
