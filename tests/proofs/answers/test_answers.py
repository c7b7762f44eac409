"""The answers to a builder's questions, beside paths that know nothing of the clauses they come from."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.contact_rules.ellipse import EllipseRule
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.answer import GOOD, Answer, Heading, Inertia, Pose, Position
from nonsmooth.proofs.answers.answers import (
    QUESTIONS,
    TAKES_LONG,
    Answers,
    answers_of,
    exit_status,
    full_answers,
    other_rules,
)
from nonsmooth.proofs.findings.verdicts import Fact
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from nonsmooth.proofs.theorem4_result import Theorem4Result
from nonsmooth.reports.checks.check import REQUIRABLE
from nonsmooth.reports.output.facts import fact_lines
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.thorough import few, keep


def value_of(check: Theorem4Result, question: str, key: str) -> Any:
    (answer,) = [answer for answer in answers_of(check) if answer.name == question]
    (fact,) = [fact for fact in answer.facts if fact.key == key]
    return getattr(fact.value, "value", fact.value)


def verdicts(name: str, rule: str = "nearest") -> tuple[object, ...]:
    return tuple(answer.verdict for answer in answers_of(check_theorem4(load_scene(name, rule=rule))))


def test_the_paper_s_array() -> None:
    assert verdicts("four-wheel") == (Position.COMES_HOME, Heading.DRIFTS, Pose.CAN_BE_HELD)
    assert verdicts("four-wheel", "box") == (Position.STAYS_NEAR, Heading.KEEPS, Pose.CAN_BE_HELD)
    assert verdicts("four-wheel", "ellipse") == (Position.COMES_HOME, Heading.KEEPS, Pose.CAN_BE_HELD)


def test_what_leaves_and_what_cannot_be_held() -> None:
    assert verdicts("outward")[0] is Position.LEAVES
    assert verdicts("off-center")[:2] == (Position.LEAVES, Heading.UNDECIDED)
    assert verdicts("differential-drive")[2] is Pose.CANNOT_BE_HELD
    assert verdicts("saddle", "ellipse")[0] is Position.UNDECIDED


@few(3)
@pytest.mark.parametrize("name", ["four-wheel", "rectangle", "ring-5", "spiral-30", "elliptic", "grid-4x4"])
def test_bodies_come_home_from_as_far_and_as_fast_as_said(name: str) -> None:
    check = check_cells(load_scene(name))
    within, seconds = (float(value_of(check, "position", key)) for key in ("within", "seconds_per_distance"))
    field = array_field(check.partition, Kinematics.EXACT)
    for k in range(12):
        angle, distance = 0.4 + 2 * math.pi * k / 12, 0.99 * within * (0.3 + 0.7 * (k % 3) / 2)
        start = (distance * math.cos(angle), distance * math.sin(angle), 0.0)
        path = simulate(field, start, 2 * seconds * distance)
        rest = next(event for event in path.events if event.kind.value == "rest")
        assert float(rest.t) <= seconds * distance * (1 + 1e-9)
        assert math.hypot(float(rest.state[0]), float(rest.state[1])) <= 1e-9


@few(2)
@pytest.mark.parametrize(("name", "rule"), [("four-wheel", "box"), ("ring-6", "box"), ("four-wheel-side", "nearest")])
def test_bodies_stay_as_near_as_said(name: str, rule: str) -> None:
    check = check_cells(load_scene(name, rule=rule), prune=False)
    within = float(value_of(check, "position", "stays_within"))
    field = array_field(check.partition, Kinematics.EXACT)
    for k in range(8):
        start = (0.9 * within * math.cos(k), 0.9 * within * math.sin(k), 0.0)
        path = simulate(field, start, 3.0)
        assert path.end.reason is not EndReason.OUTSIDE
        distances = np.hypot(path.array[:, 0], path.array[:, 1])
        assert distances.max() <= 0.9 * within * (1 + 1e-9)


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "spiral-30", "rectangle"])
def test_the_distance_halves_as_fast_as_said(name: str) -> None:
    scene = load_scene(name, rule="ellipse")
    rate = float(value_of(check_theorem4(scene), "position", "rate"))
    path = smooth_path(EllipseRule(), scene, (1e-4, 0.4e-4, 0.0), 6 / rate)
    distances = np.hypot(path.array[:, 0], path.array[:, 1])
    times = np.array(path.times)
    late = times > 3 / rate
    slope = np.polyfit(times[late], np.log(distances[late]), 1)[0]
    assert slope == pytest.approx(-rate, rel=0.1)


def test_the_drift_is_attained_at_rest() -> None:
    check = check_cells(load_scene("four-wheel"))
    assert float(value_of(check, "heading", "largest_rate")) == pytest.approx(math.sqrt(2) / 2, rel=1e-15)


def test_numbers_are_rounded_to_the_safe_side() -> None:
    said = [
        line for answer in answers_of(check_theorem4(load_scene("four-wheel"))) for line in fact_lines(answer.facts)
    ]
    assert "at rest it may turn, at up to 0.7072 rad/s" in said  # sqrt(2)/2 = 0.70710678
    assert "from anywhere within 0.5" in said


@few(3)
@pytest.mark.parametrize("rule", keep(2, ["nearest", "ellipse", "box"]))
@pytest.mark.parametrize("name", keep(10, builtin_scenes()))
def test_every_answer_has_a_sentence_and_the_same_keys(name: str, rule: str) -> None:
    answers = answers_of(check_theorem4(load_scene(name, rule=rule)))
    for answer in answers:
        assert fact_lines(answer.facts), answer.name
        assert not any("(0)" in line or "nothing" in line or "1 of the 1" in line for line in fact_lines(answer.facts))
    keys = [sorted(fact.key for fact in answer.facts if fact.key) for answer in answers]
    assert keys == [
        [
            *("accuracy", "after", "at", "ends_within", "rate", "seconds_per_distance", "stays_within"),
            *("swings_out_to", "within"),
        ],
        ["largest_rate", "turn_per_distance"],
        ["law", "must_know", "position_error", "rate", "speed", "wheel_speed"],
    ]


def test_exit_status_asks_what_is_required() -> None:
    check = check_theorem4(load_scene("four-wheel"))
    assert exit_status(check, ["position", "pose", "theorem4"]) == 0
    assert exit_status(check, ["heading"]) == 1  # it drifts
    undecided = check_theorem4(load_scene("saddle", rule="ellipse"))
    assert exit_status(undecided, ["position"]) == 3
    assert exit_status(undecided, ["pose"]) == 0


HEAVY = """
units = { length = "mm", speed = "m/s" }
contact = { rule = "ellipse" }
grid = { rows = 2, columns = 2, pitch = 200 }
field = { kind = "radial", speed = 0.1 }
friction = { mu_roll = 0.8, mu_side = 0.8 }
"""
SETTLES = (Fact("settles_after", 0.3), Fact("from", [{"what": "comes to rest"}]))
CYCLES = (Fact("settles_after", None), Fact("from", [{"what": "comes to rest"}, {"what": "limit cycle"}]))
THROWN = (Fact("settles_after", None), Fact("from", [{"what": "thrown off"}]))
MOVES = (Fact("settles_after", None), Fact("from", [{"what": "still moving"}]))


@pytest.mark.parametrize(
    ("verdict", "facts", "status"),
    [
        (Inertia.STABLE, SETTLES, 0),
        (Inertia.STABLE, CYCLES, 1),
        (Inertia.STABLE, THROWN, 1),
        (Inertia.STABLE, MOVES, 3),
        (Inertia.UNSTABLE, SETTLES, 1),
        (Inertia.UNDECIDED, SETTLES, 3),
    ],
)
def test_inertia_is_required_proved_and_simulated(
    verdict: Inertia, facts: tuple[Fact, ...], status: int, tmp_path: Path
) -> None:
    file = tmp_path / "table.toml"
    file.write_text(HEAVY, encoding="utf-8")
    check = check_theorem4(load_scene(str(file)))
    answered = Answers((), None, (), inertia=Answer("inertia", verdict, facts))
    assert exit_status(check, ["inertia"], answered) == status


def test_inertia_is_not_required_where_nobody_follows_it() -> None:
    with pytest.raises(SceneError, match=r"--require inertia: required .units."):
        exit_status(check_theorem4(load_scene("four-wheel", rule="ellipse")), ["inertia"])


def test_what_can_be_required_is_what_is_answered() -> None:
    assert (*QUESTIONS, "inertia", "tolerances", "theorem4") == REQUIRABLE
    assert {Position.STAYS_NEAR, Position.LEAVES, Heading.DRIFTS, Pose.CANNOT_BE_HELD}.isdisjoint(GOOD)


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "spiral-30"]))
def test_the_other_rules_say_what_their_own_checks_say(name: str) -> None:
    for other in full_answers(check_theorem4(load_scene(name))).others:
        assert tuple(answer.verdict for answer in other.answers) == verdicts(name, other.name)[:2]


def test_other_rules_are_not_asked_of_large_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("ring-6")
    assert not any(other.why_not == TAKES_LONG for other in other_rules(scene))
    monkeypatch.setattr("nonsmooth.proofs.answers.answers.FEW_WHEELS", 5)
    assert {other.why_not for other in other_rules(scene)} == {TAKES_LONG}


def test_a_rule_that_refuses_the_square_says_why() -> None:
    scene = load_scene("four-wheel", radius="3/2")
    refused = full_answers(check_theorem4(scene)).others
    assert all(not other.answers and "support polygon" in other.why_not for other in refused)


def test_rubber_wheels_can_hold_a_pose_although_the_theorem_does_not_ask() -> None:
    check = check_theorem4(load_scene("four-wheel-side", rule="ellipse"))
    assert check.results["feedback"].verdict == "not applicable"
    assert verdicts("four-wheel-side", "ellipse")[2] is Pose.CAN_BE_HELD
    assert value_of(check, "pose", "rate") > 0
    assert exit_status(check, ["pose"]) == 0


def test_a_body_that_tips_at_the_point_is_said_to_tip() -> None:
    """Rule nearest asks for no loads; what it says beyond the support polygon is said of a body that tips."""
    check = check_theorem4(load_scene("four-wheel", at="2,0", radius="1/4"))
    sentence = answers_of(check)[0].sentence
    assert "the body tips at c*" in sentence


def test_speeds_that_move_no_body_hold_no_pose() -> None:
    """Side friction above the rims' own: random speeds leave the body at rest, as the answer says of all speeds."""
    scene = load_scene("four-wheel-side", rule="box")
    assert verdicts("four-wheel-side", "box")[2] is Pose.CANNOT_BE_HELD
    model, random = contact_model(scene), np.random.default_rng(7)
    for _ in range(50):
        targets = np.zeros(2 * len(scene.wheels))
        targets[::2] = random.normal(size=len(scene.wheels))
        driven = replace(model, targets=targets)
        assert np.allclose(BoxHighs().minimize(driven, loads_at(driven, np.zeros((1, 2)))).twists, 0)
