"""What pruning saves: the verdicts of a pruned check are those of a whole one, and a difference would be counted."""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.analysis.measurements.harness import Clock, Limits, Outcome
from nonsmooth.proofs.findings.verdicts import Rotation, Theorem4
from nonsmooth.proofs.measurements import PRUNING, verdicts
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import thorough

SECONDS = 120


@thorough  # the small one: test_differing_verdicts_are_counted
def test_no_verdict_differs_and_no_work_is_added() -> None:
    plan = PRUNING.build(load_scene("four-wheel"))
    found = {trial.method: trial.judge(trial.work(Clock(SECONDS))) for trial in plan.trials}
    assert list(found) == [
        f"{rule}, {what}" for rule in ("nearest", "box", "ellipse", "roller") for what in ("whole", "pruned")
    ]
    assert all(finding.error == 0 for finding in found.values())
    for rule in ("nearest", "box"):
        pruned, whole = found[f"{rule}, pruned"].work, found[f"{rule}, whole"].work
        assert all(pruned[what] <= whole[what] for what in ("row triples", "wheels", "contact states", "cells"))
        assert whole["left out"] <= pruned["left out"]


def test_differing_verdicts_are_counted() -> None:
    scene = load_scene("four-wheel")
    trial = PRUNING.build(scene).trials[1]
    right = check_theorem4(scene)
    open_rotation = replace(right.rotation, verdict=Rotation.UNDECIDED)
    wrong = replace(right.with_results(rotation=open_rotation), verdict=Theorem4.UNDECIDED)
    assert trial.judge(right).error == 0
    assert trial.judge(wrong).error == 2
    assert verdicts(right) == ("holds", "holds", "asymptotically stable", "unstable", "stabilizable")


def test_a_rule_that_refuses_the_array_fails_and_says_why() -> None:
    plan = PRUNING.build(load_scene("four-wheel", radius="2"))
    trials = [trial for trial in plan.trials if trial.method.startswith("box")]
    rows = [PRUNING.measure(trial, plan, Limits(1, SECONDS)) for trial in trials]
    assert [row.outcome for row in rows] == [Outcome.FAILED] * 2
    assert "check.radius: required at most" in rows[0].note
