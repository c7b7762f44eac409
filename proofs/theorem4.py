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

from nonsmooth.analysis.filippov import filippov_twists
from nonsmooth.analysis.nearest import build_nearest_partition
from nonsmooth.analysis.partition import Partition
from nonsmooth.proofs.equilibrium import EquilibriumResult, decide_equilibrium
from nonsmooth.proofs.feedback import FeedbackResult, decide_feedback
from nonsmooth.proofs.rotation import RotationResult, decide_rotation, rotation_bound
from nonsmooth.proofs.translation import TranslationResult, decide_translation
from nonsmooth.proofs.verdicts import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.symbolic.contact_states import ContactCensus, possible_triples, take_census
from nonsmooth.symbolic.scene import Rule, Scene
from nonsmooth.symbolic.scene_error import SceneError

CENSUS_LIMIT = 20_000  # row triples that are counted unasked: 25 wheels; a count decides no clause


@dataclass(frozen=True)
class Skipped:
    """Work left out because no verdict needs it."""

    what: str
    count: int
    why: str


@dataclass(frozen=True)
class Theorem4Result:
    """Verdict of the theorem for one array with the result of each clause."""

    verdict: Theorem4
    reason: str
    scene: Scene
    partition: Partition
    census: ContactCensus
    equilibrium: EquilibriumResult
    translation: TranslationResult
    rotation: RotationResult
    feedback: FeedbackResult
    skipped: tuple[Skipped, ...]
    seconds: dict[str, float]

    def check(self) -> bool:
        """Re-verify that the cells tile, the evidence of every clause on all of them, and the conclusion."""
        clauses = (self.equilibrium, self.translation, self.rotation, self.feedback)
        genuine = not self.partition.area_error and self._speaks_of_every_cell()
        return genuine and all(clause.check() for clause in clauses) and self.verdict is conclude(*clauses)[0]

    def _speaks_of_every_cell(self) -> bool:
        """Whether the clauses' evidence is about all cells of this partition, and no others."""
        zero = self.scene.field.zero
        here = filippov_twists(self.partition, (zero, zero))
        cells = self.partition.cells
        drift, bound = self.rotation.drift, self.rotation.rotation_per_distance
        return (
            self.equilibrium.twists == here
            and (drift is None or drift.twists == here)
            and (bound is None or bound == rotation_bound(self.partition, self.translation))
            and [(d.cell, d.twist) for d in self.translation.derivatives] == [(c, t) for c in cells for t in c.twists]
            and self.feedback == decide_feedback(self.partition)
        )


def check_theorem4(scene: Scene, *, prune: bool = True) -> Theorem4Result:
    """Check Theorem 4 for an array under the contact rule of its scene.

    Args:
        scene: the array; the point ``scene.check.equilibrium`` is checked in the square around it.
        prune: leave out what no verdict needs; without, everything is computed, with the same verdicts.

    Raises:
        SceneError: for a contact rule that is not available.
    """
    seconds: dict[str, float] = {}
    centred = scene.recentred()
    with _timed(seconds, "partition"):
        partition = build_partition(centred, prune=prune)
    skipped: list[Skipped] = []
    with _timed(seconds, "contact states"):
        census = _census(scene, partition, skipped, prune=prune)
    with _timed(seconds, "equilibrium"):
        equilibrium = decide_equilibrium(partition)
    with _timed(seconds, "translation"):
        translation = decide_translation(partition)
    with _timed(seconds, "rotation"):
        rotation = decide_rotation(partition, translation)
    with _timed(seconds, "feedback"):
        feedback = decide_feedback(partition)
    if feedback.verdict is Feedback.NOT_APPLICABLE:
        skipped.append(Skipped("feedback search", 1, feedback.reason))
    verdict, reason = conclude(equilibrium, translation, rotation, feedback)
    return Theorem4Result(
        verdict,
        reason,
        scene,
        partition,
        census,
        equilibrium,
        translation,
        rotation,
        feedback,
        tuple(skipped),
        seconds,
    )


def build_partition(scene: Scene, *, prune: bool = True) -> Partition:
    """Cells of the scene's contact rule in the checked square, in the scene's own coordinates.

    Raises:
        SceneError: for a contact rule that is not available.
    """
    if scene.contact.rule is Rule.NEAREST:
        return build_nearest_partition(scene, prune=prune)
    file = scene.source or scene.name
    raise SceneError(file, "contact.rule", '"nearest" (box and ellipse are not available yet)', str(scene.contact.rule))


def conclude(
    equilibrium: EquilibriumResult,
    translation: TranslationResult,
    rotation: RotationResult,
    feedback: FeedbackResult,
) -> tuple[Theorem4, str]:
    """The theorem's verdict from the clauses', and the clause that decided it."""
    if equilibrium.verdict is Equilibrium.FAILS:
        return Theorem4.HYPOTHESES_NOT_MET, f"the point is no equilibrium: {equilibrium.reason}"
    if translation.verdict is Translation.UNSTABLE:
        return Theorem4.FAILS, f"translation is unstable: {translation.reason}"
    if rotation.verdict is Rotation.NEUTRAL:
        return Theorem4.FAILS, f"theta is stable: {rotation.reason}"
    for name, clause, open_verdicts in (
        ("translation", translation, (Translation.UNDECIDED,)),
        ("rotation", rotation, (Rotation.UNDECIDED,)),
        ("feedback", feedback, (Feedback.UNDECIDED, Feedback.NO_CERTIFICATE)),
    ):
        if clause.verdict in open_verdicts:
            return Theorem4.UNDECIDED, f"{name} is undecided: {clause.reason}"
    return Theorem4.HOLDS, "every clause holds"


def _census(scene: Scene, partition: Partition, skipped: list[Skipped], *, prune: bool) -> ContactCensus:
    """Count the row triples where that is cheap or asked for."""
    idle = len(scene.wheels) - partition.wheels_considered
    if idle:
        skipped.append(Skipped("wheels", idle, "too far away to be among the two nearest anywhere in the square"))
    possible = possible_triples(len(scene.wheels))
    if possible <= CENSUS_LIMIT or not prune:
        return take_census(scene)
    derived = len(partition.states)
    why = f"no cell in the square; singular and distinct triples are counted up to {CENSUS_LIMIT} triples"
    skipped.append(Skipped("contact states", possible - derived, why))
    return ContactCensus(possible)


@contextmanager
def _timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[step] = time.perf_counter() - start
