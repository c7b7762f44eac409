"""Theorem 4 as a whole: verdicts of known arrays, what pruning saves, and results that do not belong together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import pytest

from nonsmooth.analysis.measurements import cases, path_studies, studies
from nonsmooth.analysis.measurements.harness import Case, Clock, Limits, Outcome, Study
from nonsmooth.proofs import measurements
from nonsmooth.proofs.clause_registry import conclude
from nonsmooth.proofs.clauses.equilibrium.clause import decide_equilibrium
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.proofs.measurements import CASES, PRUNING, STUDIES, SYSTEM_STUDIES
from nonsmooth.proofs.measurements import verdicts as verdicts_of
from nonsmooth.proofs.theorem4 import CENSUS_LIMIT, check_cells, check_theorem4
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.contact_states import possible_triples
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.built_in import drift, verdicts, whole_check
from tests.conftest import Arrays, Pair, WheelData
from tests.four_wheel import ROLL, SIDE
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.forged import with_results
from tests.thorough import few, keep, thorough

# ---- Theorem 4 as a whole: verdicts of known arrays, pruning, and results that do not belong together.

WheelTolerance: TypeAlias = "Callable[[Arrays], Scene]"

SEEDS = range(12)


def off_center(arrays: Arrays) -> Scene:
    scene = arrays.four_wheel(ROLL)
    there = (scene.field(Fraction(1, 5)), scene.field(Fraction(1, 10)))
    return replace(scene, check=replace(scene.check, equilibrium=there))


KNOWN: dict[str, tuple[WheelTolerance, Theorem4]] = {
    "four-wheel, roll": (lambda arrays: arrays.four_wheel(ROLL), Theorem4.HOLDS),
    "four-wheel, side": (lambda arrays: arrays.four_wheel(SIDE), Theorem4.HOLDS),
    "four-wheel, tie": (lambda arrays: arrays.four_wheel((1, 1)), Theorem4.HOLDS),
    "off center": (off_center, Theorem4.HYPOTHESES_NOT_MET),
    "outward": (lambda arrays: arrays.pushed(1, 1), Theorem4.FAILS),
    "saddle": (lambda arrays: arrays.pushed(1, -1), Theorem4.FAILS),
    "facing pair": (lambda arrays: arrays.scene(arrays.inward([(1, 0), (-1, 0)])), Theorem4.FAILS),
    "3 x 3 grid": (lambda arrays: arrays.grid(3, 3), Theorem4.HYPOTHESES_NOT_MET),
}


@pytest.mark.parametrize("name", KNOWN)
def test_verdicts_of_known_arrays(arrays: Arrays, name: str) -> None:
    build, expected = KNOWN[name]
    result = check_cells(build(arrays))
    assert result.verdict is expected
    assert result.check()


@few(2)
@pytest.mark.parametrize("n", range(3, 13))
def test_the_theorem_holds_for_inward_rings(arrays: Arrays, n: int) -> None:
    for friction in (ROLL, SIDE):
        result = check_cells(arrays.ring(n, friction))
        assert result.verdict is Theorem4.HOLDS
        assert result.check()
        expected = Feedback.STABILIZABLE if friction == ROLL else Feedback.NOT_APPLICABLE
        assert result.feedback.verdict is expected


@few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_every_random_result_verifies_itself(arrays: Arrays, seed: int) -> None:
    for scene in (arrays.random(seed, 2 + seed % 5), arrays.cocircular(seed)):
        assert check_cells(scene).check()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_verdict_is_the_stated_conjunction(arrays: Arrays, seed: int) -> None:
    """``holds`` iff equilibrium, (asymptotic) stability, spin, and feedback where it applies."""
    for scene in (arrays.random(seed, 4), arrays.cocircular(seed)):
        r = check_cells(scene)
        holds = (
            r.equilibrium.verdict is Equilibrium.HOLDS
            and r.translation.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)
            and r.rotation.verdict is Rotation.UNSTABLE
            and r.feedback.verdict in (Feedback.STABILIZABLE, Feedback.NOT_APPLICABLE)
        )
        assert (r.verdict is Theorem4.HOLDS) == holds
        assert (r.verdict is Theorem4.HYPOTHESES_NOT_MET) == (r.equilibrium.verdict is Equilibrium.FAILS)


def test_a_refuted_clause_fails_and_an_open_one_leaves_it_undecided(arrays: Arrays) -> None:
    r = check_cells(arrays.four_wheel(ROLL))
    assert conclude(r.results)[0] is Theorem4.HOLDS
    one = r.partition.scene.field.one
    fails = replace(r.equilibrium, verdict=Equilibrium.FAILS, separator=(one, one))
    assert conclude(with_results(r, equilibrium=fails).results)[0] is Theorem4.HYPOTHESES_NOT_MET
    for verdict, expected in (
        (Translation.UNSTABLE, Theorem4.FAILS),
        (Translation.UNDECIDED, Theorem4.UNDECIDED),
        (Translation.STABLE, Theorem4.HOLDS),
    ):
        other = with_results(r, translation=replace(r.translation, verdict=verdict))
        assert conclude(other.results)[0] is expected
    for spin, expected in ((Rotation.NEUTRAL, Theorem4.FAILS), (Rotation.UNDECIDED, Theorem4.UNDECIDED)):
        other = with_results(r, rotation=replace(r.rotation, verdict=spin))
        assert conclude(other.results)[0] is expected
    for law, expected in (
        (Feedback.NO_CERTIFICATE, Theorem4.UNDECIDED),
        (Feedback.UNDECIDED, Theorem4.UNDECIDED),
        (Feedback.NOT_APPLICABLE, Theorem4.HOLDS),
    ):
        other = with_results(r, feedback=replace(r.feedback, verdict=law))
        assert conclude(other.results)[0] is expected


def test_a_failure_outweighs_an_open_clause(arrays: Arrays) -> None:
    r = check_cells(arrays.four_wheel(ROLL))
    neutral = replace(r.rotation, verdict=Rotation.NEUTRAL)
    undecided = replace(r.translation, verdict=Translation.UNDECIDED)
    assert conclude(with_results(r, translation=undecided, rotation=neutral).results)[0] is Theorem4.FAILS


def test_a_far_wheel_does_not_lift_a_missing_certificate(arrays: Arrays) -> None:
    """Two wheels on one axle spin about its middle, and no input moves the body along it; a far wheel is no help."""
    far = WheelData((Fraction(3, 2), 0), (-1, 0), friction=SIDE)
    results = [check_cells(arrays.axle(*others, radius=1)) for others in ((), (far,))]
    assert any(3 in cell.wheels for cell in results[1].partition.cells)
    for result in results:
        assert result.translation.verdict is Translation.STABLE
        assert result.rotation.verdict is Rotation.UNSTABLE
        assert result.feedback.verdict is Feedback.NO_CERTIFICATE
        assert [str(x) for x in result.feedback.obstruction or ()] == ["0", "1", "0"]
        assert result.verdict is Theorem4.FAILS
        assert result.check()
        assert not with_results(result, feedback=replace(result.feedback, obstruction=None)).check()


# ---- leaving out what a scene does not need ------------------------------------------------------


def same_without_pruning(scene: Scene) -> None:
    """Every verdict, rate, region and drift is the same where all contact states are looked at."""
    pruned, whole = check_cells(scene), whole_check(scene)
    assert verdicts(pruned) == verdicts(whole)
    assert drift(pruned) == drift(whole)
    assert pruned.translation.worst_rate == whole.translation.worst_rate
    assert pruned.translation.region_radius == whole.translation.region_radius
    assert pruned.partition.wheels_considered <= whole.partition.wheels_considered == len(standing(scene).wheels)


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_pruning_changes_nothing_for_random_arrays(arrays: Arrays, seed: int) -> None:
    for scene in (arrays.random(seed, 6), arrays.cocircular(seed)):
        same_without_pruning(scene)


@few(2)
@pytest.mark.parametrize("name", builtin_scenes())
def test_pruning_changes_nothing_for_built_in_scenes(name: str) -> None:
    same_without_pruning(load_scene(name, rule="nearest"))


@thorough  # the small one: test_pruning_changes_nothing_for_built_in_scenes
@pytest.mark.parametrize(("side", "considered"), keep(1, [(5, 21), (6, 16)]))
def test_pruning_of_grids_leaves_wheels_out_and_changes_nothing(arrays: Arrays, side: int, considered: int) -> None:
    scene = arrays.grid(side, side)
    assert check_cells(scene).partition.wheels_considered <= considered < len(scene.wheels)
    same_without_pruning(scene)


def test_what_is_left_out_is_named(arrays: Arrays) -> None:
    result = check_cells(arrays.grid(12, 12))
    skipped = {entry.what: entry.count for entry in result.skipped}
    considered = result.partition.wheels_considered
    possible = possible_triples(144)
    assert considered < 40
    assert skipped["wheels"] == 144 - considered
    assert skipped["contact states"] == possible - len(result.partition.states)
    assert result.census.possible == possible > CENSUS_LIMIT
    assert result.census.singular is None
    assert result.census.regular is None


def test_without_pruning_everything_is_counted(arrays: Arrays) -> None:
    scene = arrays.four_wheel(SIDE)
    result = whole_check(scene)
    assert result.census == check_cells(scene).census
    assert (result.census.possible, result.census.singular, result.census.distinct_twists) == (56, 16, 13)
    assert [entry.what for entry in result.skipped] == ["feedback search"]
    assert set(result.seconds) == {
        "partition",
        "contact states",
        "other equilibria",
        "equilibrium",
        "translation",
        "rotation",
        "feedback",
    }


# ---- results that do not belong together ---------------------------------------------------------


def test_a_partition_with_a_hole_is_refused(arrays: Arrays) -> None:
    """All clauses are decided anew on the cells that are left: only the area tells."""
    r = check_cells(arrays.cocircular(58))
    zero = r.partition.scene.field.zero
    far = next(cell for cell in r.partition.cells if not cell.polygon.contains((zero, zero)))
    holed = replace(r.partition, cells=tuple(cell for cell in r.partition.cells if cell is not far))
    translation = decide_translation(holed)
    wrong = with_results(
        replace(r, cells=holed),
        equilibrium=decide_equilibrium(holed),
        translation=translation,
        rotation=decide_rotation(holed, translation),
        feedback=decide_feedback(holed),
    )
    assert all(map(evidence_holds, (wrong.equilibrium, translation, wrong.rotation)))
    assert r.check()
    assert not wrong.check()


def test_a_feedback_clause_that_was_waved_away_is_refused(arrays: Arrays) -> None:
    r = check_cells(arrays.four_wheel(ROLL))
    assert not with_results(r, feedback=replace(r.feedback, verdict=Feedback.NOT_APPLICABLE)).check()


@pytest.mark.parametrize("rule", ["nearest", "ellipse", "roller"])
def test_evidence_about_another_square_or_friction_is_refused(arrays: Arrays, rule: str) -> None:
    """It is sound; only that it speaks of this array is wrong."""
    scene = replace(arrays.four_wheel(ROLL), contact=replace(arrays.four_wheel(ROLL).contact, rule=rule))
    smaller = replace(scene, check=replace(scene.check, radius=scene.check.radius / 2))
    rougher = replace(
        scene,
        wheels=tuple(replace(w, friction=replace(w.friction, side=w.friction.side * 3)) for w in scene.wheels),
    )
    for other in (smaller, rougher):
        result = check_theorem4(other)
        assert result.check()
        assert not replace(result, scene=scene).check()


@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("friction", [ROLL, SIDE])
def test_the_feedback_clause_applies_exactly_where_the_friction_says_so(
    arrays: Arrays, rule: str, friction: Pair
) -> None:
    scene = arrays.four_wheel(friction)
    result = check_theorem4(replace(scene, contact=replace(scene.contact, rule=rule)))
    assert result.check()
    assert isinstance(result.feedback, DrivenFeedback)
    assert result.feedback.verdict is (Feedback.NOT_APPLICABLE if friction == SIDE else Feedback.STABILIZABLE)
    for verdict in set(Feedback) - {result.feedback.verdict, Feedback.UNDECIDED}:
        wrong = replace(result.feedback, verdict=verdict)
        forged = with_results(result, feedback=wrong)
        assert not replace(forged, verdict=conclude(forged.results)[0]).check()


@pytest.mark.parametrize(
    ("verdict", "status"),
    [(Theorem4.HOLDS, 0), (Theorem4.FAILS, 1), (Theorem4.HYPOTHESES_NOT_MET, 1), (Theorem4.UNDECIDED, 3)],
)
def test_exit_statuses(verdict: Theorem4, status: int) -> None:
    assert verdict.exit_status == status


@pytest.mark.parametrize(("friction", "weakly"), [(ROLL, True), (SIDE, False)])
def test_strong_and_weak_stability_of_theta_are_told_apart(
    arrays: Arrays, friction: tuple[Fraction, Fraction], weakly: bool
) -> None:
    """Some solution of eq. (4) rests at the origin without turning; for eq. (3) no decay bounds the way there."""
    result = check_cells(arrays.four_wheel(friction))
    assert result.rotation.verdict is Rotation.UNSTABLE
    assert result.theta_is_weakly_stable is weakly


def test_a_spinning_body_is_not_weakly_stable(arrays: Arrays) -> None:
    result = check_cells(arrays.scene(arrays.inward([(1, 0), (-1, 0), (0, 1), (0, -1)], turn=(0, 1))))
    assert result.rotation.verdict is Rotation.UNSTABLE
    assert not result.theta_is_weakly_stable


def test_the_reason_names_the_clause_that_does_not_apply(arrays: Arrays) -> None:
    """With mu_side above mu_roll the theorem has no law, so that not every clause holds."""
    found = check_cells(arrays.four_wheel(SIDE))
    assert found.feedback.verdict is Feedback.NOT_APPLICABLE
    assert (found.verdict, found.reason) == (
        Theorem4.HOLDS,
        "every clause that applies holds; not applicable: feedback",
    )
    assert check_cells(arrays.four_wheel(ROLL)).reason == "every clause holds"


# ---- What pruning saves: the verdicts of a pruned check are those of a whole one, and a difference would be counted.

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
    wrong = replace(with_results(right, rotation=open_rotation), verdict=Theorem4.UNDECIDED)
    assert trial.judge(right).error == 0
    assert trial.judge(wrong).error == 2
    assert verdicts_of(right) == ("holds", "holds", "asymptotically stable", "unstable", "stabilizable")


def test_a_rule_that_refuses_the_array_fails_and_says_why() -> None:
    plan = PRUNING.build(load_scene("four-wheel", radius="2"))
    trials = [trial for trial in plan.trials if trial.method.startswith("box")]
    rows = [PRUNING.measure(trial, plan, Limits(1, SECONDS)) for trial in trials]
    assert [row.outcome for row in rows] == [Outcome.FAILED] * 2
    assert "check.radius: required at most" in rows[0].note


# ---- The registry: every study and case that a chapter defines is listed, once and under its own name.


def defined() -> dict[int, Study | Case]:
    """The studies and cases of all chapters, by identity: the registry names those of the others too."""
    values = [value for module in (studies, path_studies, cases, measurements) for value in vars(module).values()]
    return {id(value): value for value in values if isinstance(value, Study | Case)}


def test_every_measurement_is_listed_once() -> None:
    listed = [*STUDIES, *SYSTEM_STUDIES, *CASES]
    assert sorted(defined()) == sorted(map(id, listed))
    for studies_of_a_kind in (STUDIES, SYSTEM_STUDIES):
        assert len({study.name for study in studies_of_a_kind}) == len(studies_of_a_kind)


def test_families_of_one_name_are_about_different_scenes() -> None:
    for about in ("array", "system"):
        names = [case.name for case in CASES if getattr(case, about) is not None]
        assert len(set(names)) == len(names)


def test_a_family_has_no_rows_of_scenes_that_it_is_not_about() -> None:
    scene = load_scene("ring-3")
    assert [list(case.rows(scene)) for case in CASES if case.array is None] == [[]]
