"""Theorem 4, clause by clause, for one array: what is computed for which contact rule, and what is left out.

What the clauses conclude together: :mod:`nonsmooth.proofs.theorem4_result`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.analysis.partitions.equilibria import find_equilibria
from nonsmooth.analysis.partitions.partition import Partition, affordable
from nonsmooth.proofs.clauses.at_point.ellipse_clauses import decide_ellipse
from nonsmooth.proofs.clauses.equilibrium.on_cells import decide_equilibrium
from nonsmooth.proofs.clauses.feedback.authority import roll_authority
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback, with_samples
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.rotation.on_cells import decide_rotation
from nonsmooth.proofs.clauses.translation.cocircular import CocircularArray, cocircular_array
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium, judge_equilibria
from nonsmooth.proofs.theorem4_result import CellCheck, Clauses, EllipseCheck, Skipped, conclude
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.contact_states import ContactCensus, possible_triples, take_census
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit
from nonsmooth.symbolic.scene import Scene

CENSUS_LIMIT = 20_000  # row triples that are counted unasked: 25 wheels; a count decides no clause
FULL_CENSUS_LIMIT = 500_000  # row triples that are counted without pruning: 72 wheels, some ten seconds
CHECK_UNITS = 15_000_000  # of exact arithmetic in a whole check: a minute or so
SEARCH_UNITS = 4_000_000  # in the search for other equilibria, which no clause needs
LEMMA = "V* <= 0 by the lemma on inward rims on one circle"
ELLIPSE_SAMPLES = 2_000  # points at which V* is evaluated under rule ellipse where no lemma covers the square


def check_theorem4(scene: Scene, *, prune: bool = True) -> CellCheck | EllipseCheck:
    """Check Theorem 4 for an array under the contact rule of its scene.

    Args:
        scene: the array; the point ``scene.check.equilibrium`` is checked in the square around it.
        prune: leave out what no verdict needs; without, everything is computed, with the same verdicts.

    Raises:
        RefusalError: where the motion is not determined (loads that do not exist, frictionless wheels), and where the
            exact arithmetic would take too long.
    """
    with affordable(scene, CHECK_UNITS, "all clauses"):
        if isinstance(rule_of(scene), CellRule):
            return check_cells(scene, prune=prune)
        return check_ellipse(scene, prune=prune)


def check_cells(scene: Scene, *, prune: bool = True) -> CellCheck:
    """Check under a rule with cells; see :func:`check_theorem4`."""
    work = _Work(scene, prune)
    lemma = cocircular_array(work.centred)
    with work.timed("partition"):
        partition = _partition(work, lemma)
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
        feedback = decide_feedback(partition) if rule_of(scene).keeps_rows else _driven_feedback(work)
    return CellCheck(
        **work.summary(census, (equilibrium, translation, rotation, feedback)),
        partition=partition,
        equilibrium=equilibrium,
        translation=translation,
        feedback=feedback,
        others=others,
    )


def check_ellipse(scene: Scene, *, prune: bool = True) -> EllipseCheck:
    """Check under a rule without cells; see :func:`check_theorem4`."""
    work = _Work(scene, prune)
    with work.timed("contact states"):
        census = _census(work, 0)
    with work.timed("translation"):
        equilibrium, translation, rotation = decide_ellipse(work.centred, samples=ELLIPSE_SAMPLES, always=not prune)
    if translation.lemma is not None and prune:
        work.skip("samples of V*", ELLIPSE_SAMPLES, f"{LEMMA}: no solver is needed")
    with work.timed("feedback"):
        feedback = _driven_feedback(work)
    return EllipseCheck(
        **work.summary(census, (equilibrium, translation, rotation, feedback)),
        equilibrium=equilibrium,
        translation=translation,
        feedback=feedback,
    )


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
        """Say what is left out."""
        self.skipped.append(Skipped(what, count, why))

    def summary(self, census: ContactCensus, clauses: Clauses) -> dict[str, Any]:
        """The fields of :class:`~nonsmooth.proofs.theorem4_result.Theorem4Result`."""
        *_, rotation, feedback = clauses
        if feedback.verdict is Feedback.NOT_APPLICABLE:
            self.skip("feedback search", 1, feedback.reason)
        verdict, reason = conclude(*clauses)
        return {
            "verdict": verdict,
            "reason": reason,
            "scene": self.scene,
            "census": census,
            "rotation": rotation,
            "authority": roll_authority(self.scene),
            "skipped": tuple(self.skipped),
            "seconds": self.seconds,
        }

    @contextmanager
    def timed(self, step: str) -> Iterator[None]:
        """Note the time that a step takes."""
        start = time.perf_counter()
        yield
        self.seconds[step] = time.perf_counter() - start


def _partition(work: _Work, lemma: CocircularArray | None) -> Partition:
    """All cells, or where the lemma covers the square only those of rest at the point."""
    rule = rule_of(work.scene)
    if not isinstance(rule, CellRule):
        raise TypeError(f"required a rule with cells, received {rule.name}")
    rest = rule.build_rest_partition(work.centred) if lemma is not None and work.prune else None
    if rest is not None:
        work.skip("cells away from the point", 1, f"{LEMMA}: no other cells are needed")
        return rest
    partition = rule.build_partition(work.centred, prune=work.prune)
    idle = len(work.scene.wheels) - partition.wheels_considered
    if idle:
        in_pairs = all(state.is_of_a_pair for state in partition.states)
        where = "to be among the two nearest" if in_pairs else "for any of their rows to be taken"
        work.skip("wheels", idle, f"too far away {where} anywhere in the square")
    return partition


def _equilibria(work: _Work, partition: Partition) -> tuple[JudgedEquilibrium, ...] | None:
    if not partition.complete:
        work.skip("search for other equilibria", 1, "cells away from the point were not built")
        return None
    try:
        with work_limit(work.centred.field, SEARCH_UNITS):
            return judge_equilibria(work.centred, find_equilibria(partition))
    except WorkLimitError:
        why = f"it takes more than {SEARCH_UNITS // 1_000_000} million exact operations, and no clause needs it"
        work.skip("search for other equilibria", 1, why)
        return None


def _driven_feedback(work: _Work) -> DrivenFeedback:
    """The clause; two laws are sampled where it stays undecided, or when nothing is to be left out."""
    feedback = decide_driven_feedback(work.centred)
    if feedback.verdict is Feedback.NOT_APPLICABLE:
        return feedback
    if feedback.verdict is Feedback.UNDECIDED or not work.prune:
        return with_samples(feedback, work.centred)
    work.skip("samples of the closed loop", 2, "the feedback clause is decided exactly")
    return feedback


def _census(work: _Work, derived: int) -> ContactCensus:
    """Count the row triples where that is cheap or asked for."""
    possible = possible_triples(len(work.scene.wheels))
    limit = CENSUS_LIMIT if work.prune else FULL_CENSUS_LIMIT
    if possible <= limit:
        return take_census(work.scene)
    why = f"no cell in the square; singular and distinct triples are counted up to {limit} triples"
    work.skip("contact states", possible - derived, why)
    return ContactCensus(possible)
