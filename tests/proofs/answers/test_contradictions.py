"""The net behind the proofs: faults planted in verdicts are noticed, and right verdicts are left alone."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.minimizers.sampling import SampledDerivative
from nonsmooth.proofs.answers import contradictions as net
from nonsmooth.proofs.answers.answer import Answer, Heading, Position
from nonsmooth.proofs.answers.answers import Answers, answers_of, exit_status, full_answers
from nonsmooth.proofs.answers.contradictions import RuleAtPoint, contradictions_of_certificate, contradictions_of_rules
from nonsmooth.proofs.answers.destinations import Destination, Destinations, Goal, SampledEnds
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.clauses.at_point.ellipse import Situation
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium, EquilibriumResult
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.findings import Certainty, Equilibrium, Fact, Quantity, Rotation, Theorem4, Translation
from nonsmooth.proofs.theorem4 import Check, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.array_certificates import say
from tests.evidence.contradictions import FAMILIES, compared, study
from tests.proofs.forged import with_results
from tests.thorough import few, keep, thorough

HALF = Fraction(1, 2)


@cache
def checked(name: str, rule: str = "nearest") -> Check:
    return check_theorem4(load_scene(name, rule=rule))


@cache
def answered_of(name: str) -> Answers:
    """The answers to its check, in which faults are planted."""
    return full_answers(checked(name), ask_others=False)


def noticed(check: Check, answered: Answers | None = None) -> set[str]:
    """What is compared where a contradiction is found; what follows from it is checked too."""
    answered = full_answers(check, ask_others=False) if answered is None else answered
    left, said = net.reconciled(check, answered)
    if left.contradictions:
        assert left.verdict is Theorem4.UNDECIDED
        assert exit_status(left, ["pose"]) == exit_status(left, ["theorem4"]) == 3
        for one in left.contradictions:
            assert all(one.sides)
            for name in set(one.clauses) & set(left.results):
                assert left.results[name].verdict == "undecided"
                assert one.sides[0] in left.results[name].reason
        answers = {answer.name: answer.verdict for answer in said.answers}
        if any("translation" in one.clauses for one in left.contradictions):
            assert answers["position"] is Position.UNDECIDED
        if any("rotation" in one.clauses for one in left.contradictions):
            assert answers["heading"] is Heading.UNDECIDED
    return {one.between for one in left.contradictions}


def with_situation(check: Check, **changes: Any) -> Check:
    """Another situation at the point, in both clauses that rest on it."""
    equilibrium, translation = check.equilibrium, check.translation
    assert isinstance(equilibrium, EllipseEquilibrium)
    assert isinstance(translation, EllipseTranslation)
    point = replace(equilibrium.point, **changes)
    return with_results(
        check, equilibrium=replace(equilibrium, point=point), translation=replace(translation, point=point)
    )


def with_translation(check: Check, verdict: Translation, **changes: Any) -> Check:
    assert isinstance(check.translation, TranslationResult)
    return with_results(check, translation=replace(check.translation, verdict=verdict, **changes))


# ---- planted faults, one for each pair -----------------------------------------------------------


@pytest.mark.usefixtures("few_paths")
@pytest.mark.parametrize("rule", keep(1, ["ellipse", "roller"]))
def test_a_point_from_which_nothing_is_driven_away(rule: str) -> None:
    moved = with_situation(checked("four-wheel", rule), situation=Situation.MOVED, twist=None, linearization=None)
    assert noticed(moved) >= {"position and destinations", "position and the field beside the point"}
    assert noticed(moved, Answers(answers_of(moved), None, ())) == {"position and the field beside the point"}


@pytest.mark.usefixtures("few_paths")
def test_a_rest_point_of_cells_that_is_said_to_be_none() -> None:
    check = checked("four-wheel")
    assert isinstance(check.equilibrium, EquilibriumResult)
    planted = with_results(check, equilibrium=replace(check.equilibrium, verdict=Equilibrium.FAILS, weights={}))
    assert "position and destinations" in noticed(planted)


@pytest.mark.usefixtures("few_paths")
def test_a_place_of_rest_that_was_rounded_to_a_float_contradicts_nothing() -> None:
    """Bodies rest 1e-12 beside the checked point: no sampled path tells the two apart, and both are right."""
    check = check_theorem4(load_scene("off-center", at="0.500000000001,1/4"))
    assert not noticed(check)
    assert answers_of(check)[0].verdict is Position.COMES_NEAR


@pytest.mark.usefixtures("few_paths")
@pytest.mark.parametrize(
    ("name", "rule"), keep(2, [("four-wheel", "nearest"), ("ring-6", "nearest"), ("spiral-30", "nearest")])
)
def test_an_attracting_point_that_is_said_to_be_unstable(name: str, rule: str) -> None:
    assert "position and destinations" in noticed(with_translation(checked(name, rule), Translation.UNSTABLE))


@pytest.mark.parametrize(("name", "rule"), [("outward", "nearest"), ("saddle", "nearest"), ("outward", "box")])
def test_a_disc_from_which_bodies_are_said_to_come_home(name: str, rule: str) -> None:
    check = checked(name, rule)
    radius = check.scene.check.radius
    planted = with_translation(
        check, Translation.ASYMPTOTICALLY_STABLE, region_radius=radius / 2, fan=None, quadratic=None
    )
    assert "position and destinations" in noticed(planted)


def test_a_disc_from_which_bodies_are_said_to_come_near() -> None:
    check, answered = checked("outward"), answered_of("outward")
    said = (Fact("within", Quantity(check.scene.check.radius)), Fact("ends_within", Quantity(Fraction(1, 100))))
    wrong = Answer("position", Position.COMES_NEAR, said)
    assert "position and destinations" in noticed(check, replace(answered, answers=(wrong, *answered.answers[1:])))


def test_a_disc_in_which_bodies_are_said_to_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """By this pair alone: another one sees the same fault."""
    monkeypatch.setattr(net, "PAIRS", (net.discs_and_ends,))
    check = checked("saddle")
    planted = with_translation(check, Translation.STABLE, region_radius=check.scene.check.radius, fan=None)
    assert noticed(planted) == {"position and destinations"}


@pytest.mark.parametrize(("name", "planted"), [("outward", "comes home"), ("four-wheel", "leaves")])
def test_a_linearization_with_the_wrong_sign(name: str, planted: str, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = {answer.name: answer for answer in answers_of(checked(name, "ellipse"))}
    wrong = replace(answers["position"], verdict=Position(planted))
    given = Answers((wrong, answers["heading"], answers["pose"]), None, ())
    check = checked(name, "ellipse")
    left, _ = net.reconciled(check, given)
    assert [one.between for one in left.contradictions] == ["position and the field beside the point"]
    assert left.contradictions[0].sides[0].startswith(f"position {planted}")
    assert not net.reconciled(check)[0].contradictions


def test_a_body_that_turns_for_ever_where_it_is_said_to_rest_without_turning() -> None:
    check = replace(checked("four-wheel"), verdict=Theorem4.FAILS)
    drift = check.rotation.drift
    planted = with_results(check, rotation=RotationResult(Rotation.NEUTRAL, "planted", drift))
    answered = full_answers(planted, ask_others=False)
    starts = np.array([[0.1, 0.0], [0.0, 0.2]])
    ends = SampledEnds(starts, np.zeros((2, 2)), np.zeros(2, bool), np.array([np.inf, 0.1]))
    answered = replace(answered, destinations=Destinations((), 2, ends))
    assert noticed(planted, answered) == {"heading and destinations"}
    bounded = replace(planted.rotation, rotation_per_distance=check.scene.field(HALF))
    ends = replace(ends, turning=np.array([0.04, 0.2]))
    assert noticed(
        with_results(planted, rotation=bounded), replace(answered, destinations=Destinations((), 2, ends))
    ) == {"heading and destinations"}
    ends = replace(ends, turning=np.array([0.04, -0.09]))
    assert not noticed(
        with_results(planted, rotation=bounded), replace(answered, destinations=Destinations((), 2, ends))
    )


def test_a_sampled_point_at_which_the_distance_grows_where_it_is_said_to_fall() -> None:
    check = checked("four-wheel", "ellipse")
    assert isinstance(check.translation, EllipseTranslation)
    for at, between in ((0.1, {"position and the samples of V*"}), (0.4, set())):
        sampled = SampledDerivative(100, 0.01, 0.02, (at, 0.0))
        planted = replace(check.translation, sampled=sampled, region_radius=check.scene.field(Fraction(1, 4)))
        planted_check = with_results(check, translation=planted)
        assert noticed(planted_check, Answers(answers_of(planted_check), None, ())) == between


def test_the_row_of_the_checked_point_says_the_opposite() -> None:
    check, answered = checked("outward"), answered_of("outward")
    assert answered.destinations is not None
    rows = answered.destinations.found
    for row in rows:
        if row.goal is Goal.POINT:
            said = replace(row, position=Position.STAYS_NEAR, heading=Heading.KEEPS)
            turned = tuple(said if one is row else one for one in rows)
    planted = replace(answered, destinations=replace(answered.destinations, found=turned))
    assert noticed(check, planted) == {"position and destinations", "heading and destinations"}
    _, left = net.reconciled(check, planted)
    assert left.destinations is not None
    assert all(row.position is None for row in left.destinations.found if row.goal is Goal.POINT)


def test_the_list_of_headings_says_the_opposite_at_the_checked_one() -> None:
    check, answered = checked("carton-on-6x6"), answered_of("carton-on-6x6")
    assert answered.headings is not None
    (entry,) = answered.headings.found
    assert not noticed(check, answered)
    for changes, between in (
        ({"position": Position.LEAVES}, {"position and headings of rest"}),
        ({"verdict": Heading.KEEPS}, {"heading and headings of rest"}),
        ({"position": Position.LEAVES, "proved": False}, set()),
    ):
        listed = replace(answered.headings, found=(replace(entry, **changes),))
        assert noticed(check, replace(answered, headings=listed)) == between


def test_a_theorem_that_holds_of_a_point_that_bodies_leave() -> None:
    assert noticed(replace(checked("outward"), verdict=Theorem4.HOLDS)) == {"position and Theorem 4"}


def robust(**numbers: float) -> Answer:
    return Answer(
        "tolerances", Certainty.CERTIFIED, tuple(Fact(key, Quantity(value)) for key, value in numbers.items())
    )


def test_tolerances_that_the_array_itself_does_not_keep() -> None:
    check, answered = checked("saddle"), answered_of("saddle")
    away = replace(answered, robust=robust(**{"radius": 0.01, "from": 0.4}))
    still = replace(answered, robust=robust(at_rest_within=0.4))
    assert noticed(check, away) == noticed(check, still) == {"tolerances and destinations"}
    assert not noticed(check, replace(answered, robust=robust(**{"radius": 0.01, "from": 0.001})))


REST, DRIVEN = RuleAtPoint("holds", "comes home", "keeps"), RuleAtPoint("fails", "leaves", "undecided")


def test_rules_of_which_one_excludes_what_the_other_says() -> None:
    scene = load_scene("four-wheel", rule="ellipse")

    def found(**asked: RuleAtPoint) -> list[str]:
        return [one.between for one in contradictions_of_rules(scene, asked)]

    assert found(ellipse=REST, box=DRIVEN) == ["the rules ellipse and box"]
    assert found(ellipse=REST, roller=DRIVEN) == ["the rules ellipse and roller"]
    assert not found(ellipse=DRIVEN, roller=REST)
    assert not found(ellipse=DRIVEN, box=REST)
    assert not found(nearest=REST, box=DRIVEN)
    assert not found(ellipse=REST, box=RuleAtPoint("undecided", "undecided", "undecided"))


def test_a_certificate_that_states_the_opposite() -> None:
    check = checked("four-wheel")
    certificate = build_certificate(check)
    assert not list(contradictions_of_certificate(certificate, check))
    opposite = {"equilibrium": False, "translation": "unstable", "rotation": "stable, not attractive"}
    for name, verdict in opposite.items():
        forged = copy.deepcopy(certificate)
        say(forged, **{name: verdict})
        assert [one.clauses for one in contradictions_of_certificate(forged, check)] == [(name,)]
    say(forged, rotation=None, theorem4="fails")
    assert list(contradictions_of_certificate(forged, check))
    say(forged, theorem4=None)
    assert not list(contradictions_of_certificate(forged, check))


# ---- true pairs ----------------------------------------------------------------------------------


def planted_ends(name: str, place: tuple[float, float]) -> Answers:
    """Destinations of bodies that all end at a place, measured from the point."""
    starts = np.array([[0.1, 0.0], [0.0, -0.1]])
    ends = SampledEnds(starts, np.array([place, place]), np.zeros(2, bool), np.full(2, np.nan))
    zero = checked(name).scene.field(0)
    row = Destination(Goal.POINT, ((zero, zero),), None, None, 1.0)
    return replace(answered_of(name), destinations=Destinations((row,), 2, ends))


def test_an_end_beside_the_point_is_another_place_as_long_as_it_can_be_told_from_it() -> None:
    check = checked("off-center")
    assert check.equilibrium.verdict is Equilibrium.FAILS
    assert not noticed(check, planted_ends("off-center", (1e-8, 0.0)))
    assert noticed(check, planted_ends("off-center", (1e-11, 0.0))) == {"position and destinations"}


def test_bodies_that_still_move_end_nowhere() -> None:
    check = checked("four-wheel")
    assert not noticed(check, planted_ends("four-wheel", (np.nan, np.nan)))


@few(3)
@pytest.mark.parametrize("name", keep(3, ["saddle", "four-wheel", "omni-3", "outward", "off-center", "ring-5"]))
@pytest.mark.parametrize("rule", keep(2, ["nearest", "box", "ellipse", "roller"]))
def test_built_in_scenes_contradict_nothing(name: str, rule: str) -> None:
    found = compared(load_scene(name, rule=rule))
    assert found is not None
    assert found[1] == ()


@thorough  # the tests below follow fewer arrays, and tests/proofs/test_tied_arrays.py plants the fault
def test_one_mixture_of_tied_motions_that_leaves_where_the_paths_drawn_come_home() -> None:
    """With equal frictions every mixture of two motions is possible; the simulator shows one of them."""
    ((_, _, said),) = study("cocircular", range(38, 39), ("nearest",))
    assert said == "leaves"


BEYOND_THE_SQUARE = """
friction = { mu_roll = "1/2", mu_side = "2/5" }
wheel = [
  { position = ["-1/5", "4/5"], heading = [7, -24], speed = "1/2" },
  { position = ["1/5", "-4/5"], heading = "pi/3", speed = "1/2" },
  { position = ["-33/40", "-9/40"], heading = [35, 36], speed = "3/4" },
  { position = ["33/40", "9/40"], heading = [-35, -36], speed = "3/4" },
]
check = { accuracy = "1/10" }
"""


def test_bodies_that_leave_the_square_come_back_to_it_from_a_larger_disc(tmp_path: Path) -> None:
    path = tmp_path / "wide.toml"
    path.write_text(BEYOND_THE_SQUARE, encoding="utf-8")
    check = check_theorem4(load_scene(path))
    answered = full_answers(check, ask_others=False)
    position, destinations = answered.answers[0], answered.destinations
    assert position.verdict is Position.COMES_NEAR
    assert float(position.numbers["within"]) > float(check.scene.check.radius)
    assert destinations is not None
    assert destinations.sampled.leaves.any()
    assert not noticed(check, answered)


@few(1)
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(4))
def test_right_verdicts_are_never_contradicted(family: str, seed: int) -> None:
    for _, rule, said in study(family, range(seed, seed + 1), ("nearest", "box")):
        assert "contradict" not in said, (rule, said)


@thorough  # the test above follows fewer arrays
@pytest.mark.parametrize("family", FAMILIES)
def test_right_verdicts_of_many_arrays_are_never_contradicted(family: str) -> None:
    for seed, rule, said in study(family, range(3, 25)):
        assert "contradict" not in said, (seed, rule, said)


def test_every_pair_has_a_planted_fault() -> None:
    """A pair that is added here needs a test that plants its fault."""
    planted: dict[str, Callable[..., Any]] = {
        "position_and_ends": test_a_rest_point_of_cells_that_is_said_to_be_none,
        "leaves_and_ends": test_an_attracting_point_that_is_said_to_be_unstable,
        "discs_and_ends": test_a_disc_in_which_bodies_are_said_to_stay,  # and two more, for those who come home or near
        "heading_and_ends": test_a_body_that_turns_for_ever_where_it_is_said_to_rest_without_turning,
        "answers_and_rows": test_the_row_of_the_checked_point_says_the_opposite,
        "answers_and_headings": test_the_list_of_headings_says_the_opposite_at_the_checked_one,
        "answers_and_theorem": test_a_theorem_that_holds_of_a_point_that_bodies_leave,
        "tolerances_and_ends": test_tolerances_that_the_array_itself_does_not_keep,
        "rules_and_rest": test_rules_of_which_one_excludes_what_the_other_says,
        "verdict_and_field": test_a_linearization_with_the_wrong_sign,
        "position_and_paths": test_built_in_scenes_contradict_nothing,  # its fault: tests/proofs/test_tied_arrays.py
        "disc_and_samples": test_a_sampled_point_at_which_the_distance_grows_where_it_is_said_to_fall,
    }
    assert {pair.__name__ for pair in net.PAIRS} == set(planted)
