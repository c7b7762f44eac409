"""What pruning saves: a check of Theorem 4 that leaves out what no verdict needs, against one that leaves out nothing.

The yardstick is the whole check of the same array, and the error is the number of verdicts that differ: 0, always.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.plan import Finding, Plan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
from nonsmooth.symbolic.contact_states import possible_triples
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene

PRUNED, WHOLE = "pruned", "whole"


def build_pruning(scene: Scene) -> Plan:
    """The plan for every contact rule; a rule that refuses the array fails, and says why."""
    trials = tuple(trial for rule in Rule for trial in _trials(scene, rule))
    return Plan("the verdicts of the check that leaves out nothing", trials)


PRUNING = Study(
    "pruning", "pruning: verdicts that differ from those of a whole check", "verdicts that differ", build_pruning
)


def _trials(scene: Scene, rule: Rule) -> tuple[Trial, Trial]:
    ruled = replace(scene, contact=replace(scene.contact, rule=rule))
    whole = _WholeCheck(ruled)
    judge = partial(_judge, whole)
    return Trial(f"{rule}, {WHOLE}", whole.run, judge), Trial(f"{rule}, {PRUNED}", partial(_pruned, ruled), judge)


class _WholeCheck:
    """The check that leaves out nothing; its verdicts are kept, because it is also the yardstick."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._verdicts: tuple[str, ...] | None = None

    def run(self, clock: Clock) -> CellCheck | EllipseCheck:
        """Check, and remember the verdicts."""
        clock.check()
        result = check_theorem4(self.scene, prune=False)
        self._verdicts = verdicts(result)
        return result

    @property
    def verdicts(self) -> tuple[str, ...]:
        """The verdicts; the check is run where it has not been."""
        if self._verdicts is None:
            self._verdicts = verdicts(check_theorem4(self.scene, prune=False))
        return self._verdicts


def _pruned(scene: Scene, clock: Clock) -> CellCheck | EllipseCheck:
    clock.check()
    return check_theorem4(scene)


def verdicts(result: CellCheck | EllipseCheck) -> tuple[str, ...]:
    """The theorem's verdict and those of its clauses."""
    clauses = (result, result.equilibrium, result.translation, result.rotation, result.feedback)
    return tuple(clause.verdict.value for clause in clauses)


def _judge(whole: _WholeCheck, found: CellCheck | EllipseCheck) -> Finding:
    work = {"row triples": possible_triples(len(found.scene.wheels))}
    if isinstance(found, CellCheck):
        partition = found.partition
        work |= {"wheels": partition.wheels_considered, "contact states": len(partition.states)}
        work["cells"] = len(partition.cells)
    work["left out"] = len(found.skipped)
    differing = sum(mine != theirs for mine, theirs in zip(verdicts(found), whole.verdicts, strict=True))
    return Finding(float(differing), work=work, note="; ".join(step.what for step in found.skipped))
