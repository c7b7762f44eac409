"""Theorem 4, clause by clause, for one array: the verdict with the evidence of every clause.

``holds`` iff the equilibrium holds, translation is (asymptotically) stable, rotation is unstable and, where
mu_S < mu_R, feedback stabilizes.  A clause that is refuted makes it ``fails``; a missing certificate is not a
refutation, so it makes it ``undecided``.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from nonsmooth.analysis.box import build_box_partition, build_rest_partition
from nonsmooth.analysis.equilibria import find_equilibria
from nonsmooth.analysis.filippov import filippov_twists
from nonsmooth.analysis.nearest import build_nearest_partition
from nonsmooth.analysis.partition import Partition, RefusalError
from nonsmooth.proofs.authority import Authority, roll_authority
from nonsmooth.proofs.cocircular import CocircularArray, cocircular_array
from nonsmooth.proofs.ellipse_clauses import EllipseEquilibrium, EllipseTranslation, decide_ellipse
from nonsmooth.proofs.equilibrium import EquilibriumResult, decide_equilibrium
from nonsmooth.proofs.fan import build_fan
from nonsmooth.proofs.feedback import FeedbackResult, decide_feedback, side_friction_rules
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium, judge_equilibria
from nonsmooth.proofs.rotation import RotationResult, decide_rotation, rotation_bound
from nonsmooth.proofs.sampled_feedback import SampledFeedback, sample_feedback
from nonsmooth.proofs.translation import TranslationResult, decide_translation
from nonsmooth.proofs.verdicts import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.symbolic.contact_states import ContactCensus, possible_triples, take_census
from nonsmooth.symbolic.scene import Rule, Scene

CENSUS_LIMIT = 20_000  # row triples that are counted unasked: 25 wheels; a count decides no clause
FULL_CENSUS_LIMIT = 500_000  # row triples that are counted without pruning: 72 wheels, some ten seconds
LEMMA = "V* <= 0 by the lemma on inward rims on one circle"
ELLIPSE_SAMPLES = 2_000  # points at which V* is evaluated under rule ellipse where no lemma covers the square


@dataclass(frozen=True)
class Skipped:
    """Work left out because no verdict needs it."""

    what: str
    count: int
    why: str


@dataclass(frozen=True)
class Theorem4Result:
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


@dataclass(frozen=True)
class CellCheck(Theorem4Result):
    """Check under a rule with cells (``nearest``, ``box``).

    Attributes:
        partition: the cells, about the checked point.
        equilibrium: clause 1.
        translation: clause 2.
        feedback: clause 4; sampled under rule ``box``.
        others: all equilibria of the square, about the checked point, with their own verdicts; None where they
            were not searched for.
    """

    partition: Partition
    equilibrium: EquilibriumResult
    translation: TranslationResult
    feedback: FeedbackResult | SampledFeedback
    others: tuple[JudgedEquilibrium, ...] | None

    @property
    def theta_is_weakly_stable(self) -> bool:
        """Whether some solution keeps theta near its start: the verdicts themselves are strong, of every solution.

        The body arrives after a bounded rotation and may rest without turning, since the drift holds zero.
        """
        drift = self.rotation.drift
        arrives = self.partition.complete and rotation_bound(self.partition, self.translation) is not None
        return drift is not None and arrives and drift.interval[0] <= 0 <= drift.interval[1]

    def check(self) -> bool:
        """Re-verify that the cells tile, the evidence of every clause on all of them, and the conclusion."""
        clauses = (self.equilibrium, self.translation, self.rotation, self.feedback)
        verified = all(clause.check() for clause in clauses) and self.authority.check(self.scene)
        return verified and self._speaks_of_every_cell() and self.verdict is conclude(*clauses)[0]

    def _speaks_of_every_cell(self) -> bool:
        """Whether the clauses' evidence is about all cells of this partition, and no others."""
        partition, translation, zero = self.partition, self.translation, self.scene.field.zero
        here = filippov_twists(partition, (zero, zero))
        drift, bound = self.rotation.drift, self.rotation.rotation_per_distance
        every = [(cell, twist) for cell in partition.cells for twist in cell.twists]
        return (
            (partition.tiles if partition.complete else translation.lemma is not None)
            and self.equilibrium.twists == here
            and (drift is None or drift.twists == here)
            and (bound is None or bound == rotation_bound(partition, translation))
            and [(d.cell, d.twist) for d in translation.derivatives] == every
            and (translation.fan is None or translation.fan.cones == build_fan(partition))
            and (isinstance(self.feedback, SampledFeedback) or self.feedback == decide_feedback(partition))
        )


@dataclass(frozen=True)
class EllipseCheck(Theorem4Result):
    """Check under rule ``ellipse``, whose field is continuous and has no cells.

    Attributes:
        equilibrium: clause 1.
        translation: clause 2, by exact linearization.
        feedback: clause 4, sampled.
    """

    equilibrium: EllipseEquilibrium
    translation: EllipseTranslation
    feedback: SampledFeedback

    def check(self) -> bool:
        """Re-verify the evidence of every clause and the conclusion."""
        clauses = (self.equilibrium, self.translation, self.rotation, self.feedback)
        verified = all(clause.check() for clause in clauses) and self.authority.check(self.scene)
        return verified and self.verdict is conclude(*clauses)[0]


def check_theorem4(scene: Scene, *, prune: bool = True) -> CellCheck | EllipseCheck:
    """Check Theorem 4 for an array under the contact rule of its scene.

    Args:
        scene: the array; the point ``scene.check.equilibrium`` is checked in the square around it.
        prune: leave out what no verdict needs; without, everything is computed, with the same verdicts.

    Raises:
        RefusalError: where the motion is not determined (loads that do not exist, frictionless wheels).
    """
    if scene.contact.rule is Rule.ELLIPSE:
        return check_ellipse(scene, prune=prune)
    return check_cells(scene, prune=prune)


def check_cells(scene: Scene, *, prune: bool = True) -> CellCheck:
    """Check under rule ``nearest`` or ``box``; see :func:`check_theorem4`."""
    work = _Work(scene, prune)
    nearest = scene.contact.rule is Rule.NEAREST
    lemma = None if nearest else cocircular_array(work.centred)
    with work.timed("partition"):
        partition = _nearest_cells(work) if nearest else _box_cells(work, lemma)
    with work.timed("contact states"):
        census = _census(work, len(partition.states))
    with work.timed("equilibrium"):
        equilibrium = decide_equilibrium(partition)
        others = _equilibria(work, partition)
    with work.timed("translation"):
        translation = decide_translation(partition, lemma)
    with work.timed("rotation"):
        rotation = decide_rotation(partition, translation)
    with work.timed("feedback"):
        feedback = decide_feedback(partition) if nearest else _sampled_feedback(work)
    verdict, reason = conclude(equilibrium, translation, rotation, feedback)
    return CellCheck(
        verdict=verdict,
        reason=reason,
        scene=scene,
        census=census,
        rotation=rotation,
        authority=roll_authority(scene),
        skipped=work.left_out(feedback),
        seconds=work.seconds,
        partition=partition,
        equilibrium=equilibrium,
        translation=translation,
        feedback=feedback,
        others=others,
    )


def check_ellipse(scene: Scene, *, prune: bool = True) -> EllipseCheck:
    """Check under rule ``ellipse``; see :func:`check_theorem4`."""
    work = _Work(scene, prune)
    with work.timed("contact states"):
        census = _census(work, 0)
    with work.timed("translation"):
        equilibrium, translation, rotation = decide_ellipse(work.centred, samples=ELLIPSE_SAMPLES, always=not prune)
    if translation.lemma is not None and prune:
        work.skip("samples of V*", ELLIPSE_SAMPLES, f"{LEMMA}: no solver is needed")
    with work.timed("feedback"):
        feedback = _sampled_feedback(work)
    verdict, reason = conclude(equilibrium, translation, rotation, feedback)
    return EllipseCheck(
        verdict=verdict,
        reason=reason,
        scene=scene,
        census=census,
        rotation=rotation,
        authority=roll_authority(scene),
        skipped=work.left_out(feedback),
        seconds=work.seconds,
        equilibrium=equilibrium,
        translation=translation,
        feedback=feedback,
    )


def build_partition(scene: Scene, *, prune: bool = True) -> Partition:
    """Cells of the scene's contact rule in the checked square, in the scene's own coordinates.

    Raises:
        RefusalError: for rule ``ellipse``, which has no cells, and where the motion is not determined.
    """
    match scene.contact.rule:
        case Rule.NEAREST:
            return build_nearest_partition(scene, prune=prune)
        case Rule.BOX:
            return build_box_partition(scene)
        case _:
            raise RefusalError(
                'contact.rule: required "nearest" or "box" for cells, received "ellipse": its field is continuous'
            )


def conclude(
    equilibrium: EquilibriumResult | EllipseEquilibrium,
    translation: TranslationResult | EllipseTranslation,
    rotation: RotationResult,
    feedback: FeedbackResult | SampledFeedback,
) -> tuple[Theorem4, str]:
    """The theorem's verdict from the clauses', and the clause that decided it."""
    if equilibrium.verdict is Equilibrium.FAILS:
        return Theorem4.HYPOTHESES_NOT_MET, f"the point is no equilibrium: {equilibrium.reason}"
    if translation.verdict is Translation.UNSTABLE:
        return Theorem4.FAILS, f"translation is unstable: {translation.reason}"
    if rotation.verdict is Rotation.NEUTRAL:
        return Theorem4.FAILS, f"theta is stable: {rotation.reason}"
    for name, clause, open_verdicts in (
        ("equilibrium", equilibrium, (Equilibrium.UNDECIDED,)),
        ("translation", translation, (Translation.UNDECIDED,)),
        ("rotation", rotation, (Rotation.UNDECIDED,)),
        ("feedback", feedback, (Feedback.UNDECIDED, Feedback.NO_CERTIFICATE)),
    ):
        if clause.verdict in open_verdicts:
            return Theorem4.UNDECIDED, f"{name}, {clause.verdict}: {clause.reason}"
    return Theorem4.HOLDS, "every clause holds"


# ---- steps of a check --------------------------------------------------------------------


class _Work:
    """One check under way: the centred scene, what was left out, and where the time went."""

    def __init__(self, scene: Scene, prune: bool) -> None:
        self.scene = scene
        self.centred = scene.recentred()
        self.prune = prune
        self.skipped: list[Skipped] = []
        self.seconds: dict[str, float] = {}

    def skip(self, what: str, count: int, why: str) -> None:
        self.skipped.append(Skipped(what, count, why))

    def left_out(self, feedback: FeedbackResult | SampledFeedback) -> tuple[Skipped, ...]:
        if feedback.verdict is Feedback.NOT_APPLICABLE:
            self.skip("feedback search", 1, feedback.reason)
        return tuple(self.skipped)

    @contextmanager
    def timed(self, step: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[step] = time.perf_counter() - start


def _nearest_cells(work: _Work) -> Partition:
    partition = build_nearest_partition(work.centred, prune=work.prune)
    idle = len(work.scene.wheels) - partition.wheels_considered
    if idle:
        work.skip("wheels", idle, "too far away to be among the two nearest anywhere in the square")
    return partition


def _box_cells(work: _Work, lemma: CocircularArray | None) -> Partition:
    """All cells, or where the lemma covers the square only those of rest at the point."""
    rest = build_rest_partition(work.centred) if lemma is not None and work.prune else None
    if rest is None:
        return build_box_partition(work.centred)
    work.skip("cells away from the point", 1, f"{LEMMA}: no other cells are needed")
    return rest


def _equilibria(work: _Work, partition: Partition) -> tuple[JudgedEquilibrium, ...] | None:
    if partition.complete:
        return judge_equilibria(work.centred, find_equilibria(partition))
    work.skip("search for other equilibria", 1, "cells away from the point were not built")
    return None


def _sampled_feedback(work: _Work) -> SampledFeedback:
    return sample_feedback(work.centred, blocked=side_friction_rules(work.centred.wheels))


def _census(work: _Work, derived: int) -> ContactCensus:
    """Count the row triples where that is cheap or asked for."""
    possible = possible_triples(len(work.scene.wheels))
    limit = CENSUS_LIMIT if work.prune else FULL_CENSUS_LIMIT
    if possible <= limit:
        return take_census(work.scene)
    why = f"no cell in the square; singular and distinct triples are counted up to {limit} triples"
    work.skip("contact states", possible - derived, why)
    return ContactCensus(possible)
