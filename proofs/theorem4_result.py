"""The verdict of Theorem 4 for one array, with the evidence of every clause.

``holds`` iff the equilibrium holds, translation is (asymptotically) stable, rotation is unstable and, where
mu_S < mu_R, feedback stabilizes.  At an equilibrium a clause that is refuted makes it ``fails``; a missing certificate
alone is not a refutation, so it makes it ``undecided``, and so does a point that is not shown to be an equilibrium.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TypeAlias

from nonsmooth.analysis.contact_rule import rule_of
from nonsmooth.analysis.fields.filippov import filippov_twists
from nonsmooth.analysis.partitions.loads import load_regions
from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.analysis.partitions.support import limiting_support
from nonsmooth.proofs.clauses.at_point.ellipse_clauses import EllipseEquilibrium, EllipseTranslation, spin_of
from nonsmooth.proofs.clauses.equilibrium.on_cells import EquilibriumResult
from nonsmooth.proofs.clauses.feedback.authority import Authority
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.obstruction import obstruction_text
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult, bounds_rotation, rotation_bound
from nonsmooth.proofs.clauses.translation.cones import build_fan
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium
from nonsmooth.proofs.own_paths import refuse_contradiction
from nonsmooth.proofs.verdicts import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.symbolic.contact_states import ContactCensus
from nonsmooth.symbolic.notebook import html_table
from nonsmooth.symbolic.scene import Scene

AnyFeedback: TypeAlias = FeedbackResult | DrivenFeedback
Clauses: TypeAlias = tuple[
    EquilibriumResult | EllipseEquilibrium,
    TranslationResult | EllipseTranslation,
    RotationResult,
    AnyFeedback,
]


@dataclass(frozen=True)
class Skipped:
    """Work left out because no verdict needs it."""

    what: str
    count: int
    why: str


@dataclass(frozen=True)
class Theorem4Result(ABC):
    """What every check reports, whatever the contact rule.

    Attributes:
        verdict: the theorem's verdict for the array.
        reason: the clause that decided it.
        scene: the array as it was given.
        census: counts of row triples.
        rotation: clause 3.
        authority: rank of the roll rows at the checked point.
        skipped: what was left out and why.
        seconds: where the time went.
    """

    verdict: Theorem4
    reason: str
    scene: Scene
    census: ContactCensus
    rotation: RotationResult
    authority: Authority
    skipped: tuple[Skipped, ...]
    seconds: dict[str, float]

    @property
    @abstractmethod
    def clauses(self) -> Clauses:
        """The four clauses, in order."""

    def _repr_html_(self) -> str:
        """The verdicts with their reasons, for a notebook."""
        names = ("equilibrium", "translation", "rotation", "feedback")
        rows = [(name, clause.verdict, clause.reason) for name, clause in zip(names, self.clauses, strict=True)]
        head = f"{self.scene.name}, rule {self.scene.contact.rule}"
        return html_table(head, ("clause", "verdict", "reason"), [*rows, ("Theorem 4", self.verdict, self.reason)])

    @property
    def minimizing_states(self) -> int | None:
        """How many contact states own a cell of the square; None where not all cells were built, or there are none."""
        return None

    @property
    def other_equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """Equilibria of the square beside the checked point; None where they were not searched for."""
        return None

    @property
    def theta_is_weakly_stable(self) -> bool | None:
        """Whether some solution keeps theta near its start; None where that is not decided.

        The verdicts themselves are strong: they speak of every solution.
        """
        return None


@dataclass(frozen=True)
class CellCheck(Theorem4Result):
    """Check under a rule with cells (``nearest``, ``box``).

    Attributes:
        partition: the cells, about the checked point.
        equilibrium: clause 1.
        translation: clause 2.
        feedback: clause 4.
        others: all equilibria of the square, about the checked point, with their own verdicts; None where they
            were not searched for.
    """

    partition: Partition
    equilibrium: EquilibriumResult
    translation: TranslationResult
    feedback: AnyFeedback
    others: tuple[JudgedEquilibrium, ...] | None

    @property
    def minimizing_states(self) -> int | None:
        """How many contact states own a cell of the square; None where not all cells were built."""
        return len(self.partition.states) if self.partition.complete else None

    @property
    def other_equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """Equilibria of the square beside the checked point; None where they were not searched for."""
        if self.others is None:
            return None
        return tuple(e for e in self.others if len(e.found.points) > 1 or any(e.found.points[0]))

    @property
    def theta_is_weakly_stable(self) -> bool:
        """Whether some solution keeps theta near its start.

        The body arrives after a bounded rotation and may rest without turning, since the drift holds zero.
        """
        drift = self.rotation.drift
        arrives = self.partition.complete and rotation_bound(self.partition, self.translation) is not None
        return drift is not None and arrives and drift.interval[0] <= 0 <= drift.interval[1]

    @property
    def clauses(self) -> Clauses:
        """The four clauses, in order."""
        return self.equilibrium, self.translation, self.rotation, self.feedback

    def check(self) -> bool:
        """Re-verify that the cells tile, the evidence of every clause on all of them, and the conclusion.

        Raises:
            nonsmooth.proofs.own_paths.ContradictionError: where a path contradicts the verdict about (x, y).
        """
        refuse_contradiction(self.partition, self.translation)
        clauses = self.clauses
        verified = all(clause.check() for clause in clauses) and self.authority.check(self.scene)
        about_it = self.partition.scene == self.scene.recentred() and self._speaks_of_every_cell()
        return verified and about_it and self.verdict is conclude(*clauses)[0]

    def _speaks_of_every_cell(self) -> bool:
        """Whether the clauses' evidence is about all cells of this partition, and no others."""
        partition, translation, zero = self.partition, self.translation, self.scene.field.zero
        here = filippov_twists(partition, (zero, zero))
        drift, bound = self.rotation.drift, self.rotation.rotation_per_distance
        every = [(cell, twist) for cell in partition.cells for twist in cell.twists]
        return (
            (partition.tiles if partition.complete else translation.lemma is not None)
            and translation.support == limiting_support(partition)
            and self.equilibrium.twists == here
            and (drift is None or drift.twists == here)
            and (bound is None or bounds_rotation(bound, partition, translation))
            and (self.rotation.fan is None or self.rotation.fan == translation.fan)
            and [(d.cell, d.twist) for d in translation.derivatives] == every
            and (translation.fan is None or translation.fan.cones == build_fan(partition))
            and self._feedback_is_ours()
        )

    def _feedback_is_ours(self) -> bool:
        if rule_of(self.scene).keeps_rows:
            return self.feedback == decide_feedback(self.partition)
        return self.feedback == decide_driven_feedback(self.partition.scene)


@dataclass(frozen=True)
class EllipseCheck(Theorem4Result):
    """Check under rule ``ellipse``, whose field is continuous and has no cells.

    Attributes:
        equilibrium: clause 1.
        translation: clause 2, by exact linearization.
        feedback: clause 4.
    """

    equilibrium: EllipseEquilibrium
    translation: EllipseTranslation
    feedback: DrivenFeedback

    @property
    def clauses(self) -> Clauses:
        """The four clauses, in order."""
        return self.equilibrium, self.translation, self.rotation, self.feedback

    def check(self) -> bool:
        """Re-verify the evidence of every clause and the conclusion."""
        clauses = self.clauses
        verified = all(clause.check() for clause in clauses) and self.authority.check(self.scene)
        point = self.equilibrium.point
        about_it = point.scene == self.scene.recentred() and point.region in load_regions(
            point.scene, point.scene.check.equilibrium
        )
        together = self.translation.point == point and self.rotation == spin_of(point)
        lemma = self.translation.lemma
        about_it = about_it and (lemma is None or lemma.scene == point.scene)
        ours = together and self.feedback == decide_driven_feedback(point.scene)
        return verified and about_it and ours and self.verdict is conclude(*clauses)[0]


Check: TypeAlias = CellCheck | EllipseCheck


def conclude(
    equilibrium: EquilibriumResult | EllipseEquilibrium,
    translation: TranslationResult | EllipseTranslation,
    rotation: RotationResult,
    feedback: AnyFeedback,
) -> tuple[Theorem4, str]:
    """The theorem's verdict from the clauses', and the clause that decided it."""
    if equilibrium.verdict is Equilibrium.FAILS:
        return Theorem4.HYPOTHESES_NOT_MET, f"the point is no equilibrium: {equilibrium.reason}"
    if equilibrium.verdict is Equilibrium.UNDECIDED:
        return Theorem4.UNDECIDED, f"equilibrium, undecided: {equilibrium.reason}"
    if translation.verdict is Translation.UNSTABLE:
        return Theorem4.FAILS, f"translation is unstable: {translation.reason}"
    if rotation.verdict is Rotation.NEUTRAL:
        return Theorem4.FAILS, f"theta is stable: {rotation.reason}"
    if feedback.obstruction is not None:
        return Theorem4.FAILS, obstruction_text(feedback.obstruction)
    for name, clause, open_verdicts in (
        ("translation", translation, (Translation.UNDECIDED,)),
        ("rotation", rotation, (Rotation.UNDECIDED,)),
        ("feedback", feedback, (Feedback.UNDECIDED, Feedback.NO_CERTIFICATE)),
    ):
        if clause.verdict in open_verdicts:
            return Theorem4.UNDECIDED, f"{name}, {clause.verdict}: {clause.reason}"
    return Theorem4.HOLDS, "every clause holds"
