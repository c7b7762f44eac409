"""Clause 4 under the rules ``box`` and ``ellipse``: torque authority exactly, the closed loop by sampling.

No certificate is available where the motion depends on all inputs at once.  What is exact: without full torque
authority, twist tracking asks nothing of any wheel when the wanted motion is a missing twist; at the equilibrium
turned by theta that is rest, so ``V' = 0``.  What is sampled: the worst rate of V under the two laws of
:mod:`nonsmooth.analysis.fields.closed_loop`.  Two laws that fail, in floats, say nothing of a third: where the
clause applies it stays undecided, and the reason says what was seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.authority import Authority, roll_authority
from nonsmooth.proofs.clauses.feedback import side_friction_rules
from nonsmooth.proofs.clauses.witness import Witness
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
        verdict: not applicable or undecided.
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
        """The most promising law, where one lets V fall at every sample."""
        return str(self.laws[0].law) if self.laws and not self.laws[0].fails else None

    def check(self) -> bool:
        """Whether no more is claimed than sampling can say."""
        return self.verdict in (Feedback.UNDECIDED, Feedback.NOT_APPLICABLE)

    def speaks_of(self, scene: Scene) -> bool:
        """Whether the clause applies to the array exactly if this says so, and the exact witness is the array's own."""
        applies = side_friction_rules(scene.wheels) is None
        witness = _spin_witness(scene, roll_authority(scene)) if applies and all(s.fails for s in self.laws) else None
        return applies is (self.verdict is Feedback.UNDECIDED) and self.witness == witness


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
    if best.fails:
        x, y, theta = best.worst_state
        where = f"under {best.law} at (x, y, theta) = ({x:.4g}, {y:.4g}, {theta:.4g})"
        reason = f"sampled, not proved: V does not fall under either law, {where}"
        return SampledFeedback(Feedback.UNDECIDED, laws, authority, _spin_witness(scene, authority), reason)
    return SampledFeedback(Feedback.UNDECIDED, laws, authority, None, f"sampled, not proved: {shown}")


def _spin_witness(scene: Scene, authority: Authority) -> Witness | None:
    """The turned equilibrium, where the missing twist is the rotation about it."""
    zero, one = scene.field.zero, scene.field.one
    if (zero, zero, one) in authority.missing:
        return Witness((zero, zero), one, "twist tracking asks nothing of any wheel at c = c* and this theta: V' = 0")
    return None
