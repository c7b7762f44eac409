"""Clause 4 of Theorem 4 as the check asks it, and what it says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.feedback.facts import AnyFeedback, feedback_facts
from nonsmooth.proofs.clauses.feedback.obstruction import obstruction_text
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings.facts import Fact, said
from nonsmooth.proofs.findings.verdicts import Feedback, Theorem4

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback


class FeedbackClause(Clause[AnyFeedback]):
    """Whether a discontinuous law makes a Lyapunov function of (c, theta) decrease."""

    name = "feedback"

    def decide(self, work: Workspace) -> AnyFeedback:
        """Through the control vector fields where the rule keeps rows, else through the twists that speeds impose.

        Two laws are sampled where the clause stays undecided, or when nothing is to be left out.
        """
        if work.rule.keeps_rows and work.partition is not None:
            found = decide_feedback(work.partition)
            if found.verdict is Feedback.NOT_APPLICABLE:
                work.skip("feedback search", 1, found.reason)
            return found
        return _driven(work)

    def undecided(self, result: AnyFeedback, reason: str) -> AnyFeedback:
        """Neither a law nor none, nor one beyond the theorem; where the clause does not apply, it still does not."""
        if result.verdict is Feedback.NOT_APPLICABLE:
            beyond = getattr(result, "beyond", None)
            return result if beyond is None else replace(result, beyond=beyond.undecided(reason))
        return result.undecided(reason)

    def settles(self, result: AnyFeedback) -> tuple[Theorem4, str] | None:
        """A plane of twists that no input leaves refutes every static feedback."""
        if result.obstruction is not None:
            return Theorem4.FAILS, obstruction_text(result.obstruction)
        return None

    def is_open(self, result: AnyFeedback) -> bool:
        """No certificate is no refutation."""
        return result.verdict in (Feedback.UNDECIDED, Feedback.NO_CERTIFICATE)

    def applies(self, result: AnyFeedback) -> bool:
        """The theorem's law needs wheels that grip along their rims."""
        return result.verdict is not Feedback.NOT_APPLICABLE

    def facts(self, result: AnyFeedback, check: CheckedArray) -> Iterator[Fact]:
        """Law, V, certified rate, region, margin, what was sampled, and the torque authority.

        Where the theorem asks nothing of feedback, they are about the law that holds the pose all the same.
        """
        if result.holding is not result:
            yield said(f"beyond the theorem: {result.holding.reason}")
        yield from feedback_facts(result.holding, check)


def _driven(work: Workspace) -> DrivenFeedback:
    """About the checked point, and about a place of rest that only rounding tells from it."""
    from nonsmooth.proofs.clauses.feedback.by_friction import BESIDE_OPEN, decide_driven_feedback, decided_around

    at_point = decide_driven_feedback(work.scene)
    distance = getattr(work.earlier["equilibrium"], "rounding_distance", None)
    found = at_point if distance is None else decided_around(at_point, distance)
    if found.holding.reason == BESIDE_OPEN:
        work.by_rounding.add(FeedbackClause.name)
    if found.verdict is Feedback.NOT_APPLICABLE or work.leaves_loads_open:
        return found
    if found.verdict is Feedback.UNDECIDED or not work.prune:
        from nonsmooth.proofs.clauses.feedback.sampled_laws import with_samples

        return with_samples(found, work.scene)
    work.skip("samples of the closed loop", 2, "the feedback clause is decided exactly")
    return found
