"""What pruning saves: a check of Theorem 4 that leaves out what no verdict needs, against one that leaves out nothing.

The yardstick is the whole check of the same array, and the error is the number of verdicts that differ: 0, always.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from nonsmooth.analysis.partitions.partition import RefusalError
from nonsmooth.analysis.studies.clock import Clock
from nonsmooth.analysis.studies.study import Finding, LeftOut, Plan, Study, Trial
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
from nonsmooth.symbolic.contact_states import possible_triples
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene

PRUNED, WHOLE = "pruned", "whole"


def build_pruning(scene: Scene) -> Plan:
    """The plan for every contact rule under which the array can be checked.

    Raises:
        LeftOut: where no rule determines the motion.
    """
    trials = tuple(trial for rule in Rule for trial in _trials(scene, rule))
    if not trials:
        raise LeftOut("no contact rule determines the motion in the square")
    return Plan("the verdicts of the check that leaves out nothing", trials)


PRUNING = Study(
    "pruning", "pruning: verdicts that differ from those of a whole check", "verdicts that differ", build_pruning
)


def _trials(scene: Scene, rule: Rule) -> Iterator[Trial]:
    ruled = replace(scene, contact=replace(scene.contact, rule=rule))
    try:
        whole = verdicts(check_theorem4(ruled, prune=False))
    except RefusalError:
        return
    for name in (PRUNED, WHOLE):
        yield Trial(f"{rule}, {name}", partial(_check, ruled, name == PRUNED), partial(_judge, whole))


def _check(scene: Scene, prune: bool, clock: Clock) -> CellCheck | EllipseCheck:
    clock.check()
    return check_theorem4(scene, prune=prune)


def verdicts(result: CellCheck | EllipseCheck) -> tuple[str, ...]:
    """The theorem's verdict and those of its clauses."""
    clauses = (result, result.equilibrium, result.translation, result.rotation, result.feedback)
    return tuple(clause.verdict.value for clause in clauses)


def _judge(whole: tuple[str, ...], found: CellCheck | EllipseCheck) -> Finding:
    work = {"row triples": possible_triples(len(found.scene.wheels))}
    if isinstance(found, CellCheck):
        partition = found.partition
        work |= {"wheels": partition.wheels_considered, "contact states": len(partition.states)}
        work["cells"] = len(partition.cells)
    work["left out"] = len(found.skipped)
    differing = sum(mine != theirs for mine, theirs in zip(verdicts(found), whole, strict=True))
    return Finding(float(differing), work=work, note="; ".join(step.what for step in found.skipped))
