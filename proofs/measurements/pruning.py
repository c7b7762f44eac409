"""What pruning saves: a check of Theorem 4 that leaves out what no verdict needs, against one that leaves out nothing.

The reference is the whole check of the same array, and the error is the number of verdicts that differ: 0, always.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.study_plan import Assessment, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.symbolic.contact_states import possible_triples
from nonsmooth.symbolic.rule import CONTACT_RULES
from nonsmooth.symbolic.scene import Scene

PRUNED, WHOLE = "pruned", "whole"


def build_pruning(scene: Scene) -> StudyPlan:
    """The plan for every contact rule; a rule that refuses the array fails, and says why."""
    trials = tuple(trial for rule in CONTACT_RULES for trial in _trials(scene, rule))
    return StudyPlan("the verdicts of the check that leaves out nothing", trials)


PRUNING = Study(
    "pruning", "pruning: verdicts that differ from those of a whole check", "verdicts that differ", build_pruning
)


def _trials(scene: Scene, rule: str) -> tuple[Trial, Trial]:
    ruled = replace(scene, contact=replace(scene.contact, rule=rule))
    judge = partial(_judge, cache(partial(_checked, ruled, False)))
    return (
        Trial(f"{rule}, {WHOLE}", partial(_checked, ruled, False), judge),
        Trial(f"{rule}, {PRUNED}", partial(_checked, ruled, True), judge),
    )


def _checked(scene: Scene, prune: bool, clock: Clock | None = None) -> Check:
    return check_theorem4(scene, prune=prune)


def verdicts(result: Check) -> tuple[str, ...]:
    """The theorem's verdict and those of its clauses."""
    return (result.verdict.value, *(found.verdict.value for _, found in result.clauses))


def _judge(whole: Callable[[], Check], found: Check) -> Assessment:
    work = {"row triples": possible_triples(len(found.scene.wheels))}
    if isinstance(found, CellCheck):
        partition = found.partition
        work |= {"wheels": partition.wheels_considered, "contact states": len(partition.states)}
        work["cells"] = len(partition.cells)
    work["left out"] = len(found.skipped)
    differing = sum(mine != theirs for mine, theirs in zip(verdicts(found), verdicts(whole()), strict=True))
    return Assessment(float(differing), work=work, note="; ".join(step.what for step in found.skipped))
