"""The answers to a builder's questions: whole arrays, one wheel failed, and with inertia."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sympy import Matrix

import nonsmooth as ns
from nonsmooth.analysis.bodies import settling
from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.contact_rules import EllipseRule
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
from nonsmooth.proofs.answers.failures import NO_DRIVE, NO_TABLE, Failure, FailureKind, failures_of, worst_failure
from nonsmooth.proofs.answers.inertia import inertia_answer, near_rest, settled_from
from nonsmooth.proofs.findings import Fact
from nonsmooth.proofs.theorem4 import Theorem4Result, check_cells, check_theorem4
from nonsmooth.reports.checks.check import REQUIRABLE
from nonsmooth.reports.output.facts import fact_lines
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing, with_only
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.under_way import listening
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.built_in import whole_check
from tests.springs import least_energy
from tests.thorough import few, keep

# ---- The answers to a builder's questions, beside paths that know nothing of the clauses they come from.


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


@pytest.mark.parametrize(("name", "is_at_rest"), [("outward", True), ("saddle", False)])
def test_whether_a_body_at_rest_turns_is_open_only_where_it_is(name: str, is_at_rest: bool) -> None:
    """Every turn takes more friction than rest at the point of the one, and some turns as much at that of the other."""
    scene = load_scene(name, rule="ellipse")
    heading = answers_of(check_theorem4(scene))[1]
    assert heading.verdict is Heading.UNDECIDED
    assert ("a body at rest does not turn" if is_at_rest else "whether a body at rest turns") in heading.sentence

    def losses(rate: float) -> float:
        total = 0.0
        for wheel in scene.wheels:
            (x, y), (u, v), speed = wheel.position, wheel.unit_direction, float(wheel.speed)
            slip = -rate * float(y) - speed * float(u), rate * float(x) - speed * float(v)
            along = slip[0] * float(u) + slip[1] * float(v)
            across = slip[1] * float(u) - slip[0] * float(v)
            total += math.hypot(float(wheel.friction.roll) * along, float(wheel.friction.side) * across)
        return total

    assert all((losses(rate) > losses(0.0) + 1e-12) is is_at_rest for rate in (-0.1, -1e-3, 1e-3, 0.1))


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


@pytest.mark.usefixtures("without_law")
@few(2)
@pytest.mark.parametrize(("name", "rule"), [("four-wheel", "box"), ("ring-6", "box"), ("four-wheel-side", "nearest")])
def test_bodies_stay_as_near_as_said(name: str, rule: str) -> None:
    check = whole_check(load_scene(name, rule=rule))
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


# ---- The answers with one wheel failed, against arrays that are written down without it ----------

CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
PLACES = [*CORNERS, (2, 0), (0, 2)]


def array(places: list[tuple[int, int]], rule: str, stopped: int | None = None, **more: Any) -> ns.Array:
    wheels = [ns.Wheel(place, heading="inward", speed=0 if k == stopped else 1) for k, place in enumerate(places, 1)]
    return ns.Array(wheels, mu_roll=1, mu_side="1/2", rule=rule, **more)


def found(failures: tuple[Failure, ...], wheel: int, kind: FailureKind) -> Failure:
    (one,) = [failure for failure in failures if (failure.wheel, failure.kind) == (wheel, kind)]
    return one


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_failures_answer_as_arrays_written_without_the_wheel(rule: str) -> None:
    failures = failures_of(array(PLACES, rule, radius="1/4").scene)
    assert [(failure.wheel, str(failure.kind)) for failure in failures] == [
        (wheel, kind) for wheel in range(1, 7) for kind in ("stopped", "lifted")
    ]
    for wheel in (1, 6):
        still = array(PLACES, rule, stopped=wheel, radius="1/4").check()
        stopped = found(failures, wheel, FailureKind.STOPPED)
        assert (stopped.position, stopped.heading) == (still.position.verdict, still.heading.verdict)
        without = array([place for k, place in enumerate(PLACES, 1) if k != wheel], rule, radius="1/4").check()
        lifted = found(failures, wheel, FailureKind.LIFTED)
        answers = (without.position.verdict, without.heading.verdict, without.pose.verdict, without.theorem4)
        assert (lifted.position, lifted.heading, lifted.pose, lifted.theorem4) == answers


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-6"]))
def test_no_law_is_promised_that_may_need_the_stopped_drive(name: str) -> None:
    told: list[str] = []
    with listening(told.append):
        failures = failures_of(load_scene(name))
    assert f"3 of {len(failures)} failures, wheel 2 lifted" in told
    for failure in failures:
        if failure.kind is FailureKind.STOPPED:
            assert failure.pose != "can be held"
            assert failure.theorem4 != "holds"
            assert failure.why == NO_DRIVE


def test_a_body_tips_over_the_diagonal_of_three_corners() -> None:
    failures = failures_of(load_scene("four-wheel"))
    lifted = [failure for failure in failures if failure.kind is FailureKind.LIFTED]
    assert {str(failure.position) for failure in lifted} == {"tips"}
    assert worst_failure(failures) is lifted[0]
    assert "tips over it" in lifted[0].why


def test_only_wheels_that_carry_are_asked_about() -> None:
    wheels = {failure.wheel for failure in failures_of(load_scene("carton-on-6x6"))}
    assert wheels == {15, 16, 21, 22}


def test_a_lifted_wheel_leaves_a_square_that_the_others_support() -> None:
    """The square of the scene leaves the support polygon of five wheels; a smaller one is checked."""
    scene = load_scene("ring-6", rule="ellipse", radius="7/10")
    lifted = found(failures_of(scene), 1, FailureKind.LIFTED)
    assert (lifted.position, lifted.why) == ("comes home", "")


def test_loads_by_a_table_say_nothing_about_fewer_wheels() -> None:
    scene = array(PLACES, "box", loads=[[1, 0, 0]] * 6).scene
    lifted = found(failures_of(scene), 5, FailureKind.LIFTED)
    assert (lifted.position, lifted.pose, lifted.why) == ("undecided", "undecided", NO_TABLE)


def test_loads_by_a_table_do_not_matter_where_a_rule_needs_none() -> None:
    scene = array(PLACES, "nearest", radius="1/4").scene
    table = array(PLACES, "nearest", radius="1/4", loads=[[1, 0, 0]] * 6).scene
    assert failures_of(table) == failures_of(scene)


MEASURED = [8, 9, 11, 10, 7, 6]  # of springs of unequal height under PLACES


@pytest.mark.parametrize("failed", range(6))
def test_springs_of_measured_loads_press_without_a_wheel_as_the_least_energy_says(failed: int) -> None:
    scene = array(PLACES, "ellipse", loads={"kind": "measured", "values": MEASURED}).scene
    rest = with_only(scene, [wheel for wheel in scene.wheels if wheel.index != failed + 1])
    places = [place for k, place in enumerate(PLACES) if k != failed]
    heights = np.array([value for k, value in enumerate(MEASURED) if k != failed]) / sum(MEASURED)
    centres = np.random.default_rng(failed).dirichlet(np.full(5, 0.5), 20) @ np.array(places, float)
    found = loads_at(contact_model(rest), centres)
    assert (found == 0).any()  # some wheels lift off
    for centre, loads in zip(centres, found, strict=True):
        np.testing.assert_allclose(
            loads, least_energy(np.array(places), np.ones(len(places)), heights, centre), atol=1e-6
        )


@pytest.mark.parametrize(("rule", "wheels"), keep(1, [("box", (5, 6)), ("ellipse", (6,)), ("ellipse", (5, 6))]))
def test_measured_loads_say_what_the_others_carry_without_a_wheel(
    rule: str, wheels: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against arrays written without it, with a table of the loads of springs on the others."""
    scene = array(PLACES, rule, radius="1/4", loads={"kind": "measured", "values": MEASURED}).scene
    looked_at = replace(scene, wheels=tuple(wheel for wheel in scene.wheels if wheel.index in wheels))
    # No other wheel fails, which would take long.
    monkeypatch.setattr(
        f"{failures_of.__module__}.standing", lambda other: looked_at if other is scene else standing(other)
    )
    failures = failures_of(scene)
    for wheel in wheels:
        places = [place for k, place in enumerate(PLACES, 1) if k != wheel]
        shares = [Fraction(value, sum(MEASURED)) for k, value in enumerate(MEASURED, 1) if k != wheel]
        without = array(places, rule, radius="1/4", loads=table_without(places, shares)).check()
        lifted = found(failures, wheel, FailureKind.LIFTED)
        assert lifted.why != NO_TABLE
        answers = (without.position.verdict, without.heading.verdict, without.pose.verdict, without.theorem4)
        assert (lifted.position, lifted.heading, lifted.pose, lifted.theorem4) == answers


def table_without(places: list[tuple[int, int]], shares: list[Fraction]) -> list[list[Fraction]]:
    """Rows of ``N = e + M G^-1 ((1, c) - M^T e)``, by Cramer's rule."""
    moments = [(Fraction(1), Fraction(x), Fraction(y)) for x, y in places]
    gram = Matrix([[sum(m[i] * m[j] for m in moments) for j in range(3)] for i in range(3)])
    weight = [sum(share * m[k] for share, m in zip(shares, moments, strict=True)) for k in range(3)]
    rows = []
    for moment, share in zip(moments, shares, strict=True):
        form = [Fraction(int(x.p), int(x.q)) for x in gram.solve(Matrix(moment))]
        constant = share - sum(f * w for f, w in zip(form, weight, strict=True))
        rows.append([form[0] + constant, form[1], form[2]])
    return rows


def test_the_height_of_a_wheel_that_was_not_pressed_is_not_known() -> None:
    scene = array(PLACES, "box", radius="1/4", loads={"kind": "measured", "values": [8, 9, 11, 10, 0, 6]}).scene
    assert found(failures_of(scene), 6, FailureKind.LIFTED).why == NO_TABLE


def test_the_worst_is_the_one_with_the_worst_position_first() -> None:
    one = failures_of(load_scene("four-wheel"))[0]
    leaves = replace(one, wheel=2, position=ns.Position.LEAVES, heading=ns.Heading.KEEPS)
    drifts = replace(one, wheel=3, position=ns.Position.COMES_HOME, heading=ns.Heading.DRIFTS)
    tips = replace(one, wheel=4, position=ns.Position.TIPS)
    assert worst_failure((leaves, drifts)) is leaves
    assert worst_failure((leaves, tips, drifts)) is tips
    assert worst_failure((drifts, replace(drifts, wheel=5))) is drifts


# ---- With inertia, of a body with an outline that turns where it rests: which wheels carry it there, and how long.

ROWS = [(99, 1, 60), (201, 0, 118), (100, 99, 2), (200, 101, 179), (101, 200, -62), (199, 199, -117)]
OTHERS = [(0, 0, 33), (300, 0, 146), (0, 200, -33), (300, 200, -147)]
WIDTH, HEIGHT = 230, 340
SCENE = f"""
units = {{ length = "mm", speed = "m/s" }}
friction = {{ mu_roll = 0.7, mu_side = 0.6 }}
contact = {{ rule = "ellipse" }}
body = {{ shape = "rectangle", width = {WIDTH}, height = {HEIGHT} }}
check = {{ equilibrium = [150, 100], radius = 50 }}
wheels = {{ file = "wheels.csv" }}
"""


@pytest.fixture
def table(tmp_path: Path) -> Scene:
    lines = "".join(f"{x},{y},{heading},0.25\n" for x, y, heading in ROWS + OTHERS)
    (tmp_path / "wheels.csv").write_text(f"x,y,heading,speed\n{lines}", encoding="utf-8")
    (tmp_path / "table.toml").write_text(SCENE, encoding="utf-8")
    return load_scene(tmp_path / "table.toml")


def test_the_same_wheels_carry_it_for_the_time_that_is_said(table: Scene) -> None:
    """The wheels under the outline at all poses of that time, by their places; without the outline it is stable."""
    near = near_rest(standing(table))
    said = re.search(r"up to ([\d.]+) deg/s, and after ([\d.]+) deg, ([\d.]+) s at least", near.why_not)
    assert said is not None
    assert "on the wheels that carry it here its centre of mass comes to rest, close to its place" in near.why_not
    assert "but its heading does not: there it turns all the time" in near.why_not
    rate, turn, time = map(float, said.groups())
    assert rate == pytest.approx(math.degrees(abs(near.spin)), rel=1e-3)
    assert rate * time == pytest.approx(turn, rel=1e-2)
    assert near.place is not None
    centre = complex(150 + near.place[0], 100 + near.place[1])
    wheels = np.array([complex(x, y) for x, y, _ in ROWS + OTHERS])
    for t in np.linspace(0, time, 40):
        seen = (wheels - centre) * np.exp(-1j * near.spin * t)
        inside = (abs(seen.real) < WIDTH / 2) & (abs(seen.imag) < HEIGHT / 2)
        assert inside.tolist() == [True] * len(ROWS) + [False] * len(OTHERS)
    alone = near_rest(replace(standing(table), body=None, idle=()))
    assert str(alone.verdict) == "stable"
    assert near.eigenvalues


SPINNING = """
friction = {{ mu_roll = 1, mu_side = "1/2" }}
grid = {{ rows = 6, columns = 6 }}
field = {{ kind = "spiral", angle = "30 deg" }}
body = {{ shape = "rectangle", width = "{}", height = "8/5" }}
check = {{ radius = "1/10" }}
"""


@pytest.mark.parametrize("rule", ["ellipse", "box", "nearest"])
@pytest.mark.parametrize("width", ["13/5", "29/10"])
def test_a_place_that_is_come_to_while_the_body_turns_says_until_when(width: str, rule: str, tmp_path: Path) -> None:
    """Of a body that the same wheels carry at all headings it is for good; under nearest the body may also not turn."""
    (tmp_path / "spin.toml").write_text(SPINNING.format(width), encoding="utf-8")
    scene = standing(load_scene(tmp_path / "spin.toml", rule=rule))
    position, heading = answers_of(check_theorem4(scene))[:2]
    assert (position.verdict in {*GOOD, Position.STAYS_NEAR}, heading.verdict) == (True, Heading.DRIFTS)
    said = "but there it turns all the time, until other wheels may carry it" in position.sentence
    assert ("all the time" in heading.sentence) == (rule != "nearest")
    around = np.arange(0, 360, 0.5) * math.pi / 180
    places = np.array([complex(x, y) / 2 for x in (-5, -3, -1, 1, 3, 5) for y in (-5, -3, -1, 1, 3, 5)])
    seen = places[:, None] * np.exp(-1j * around)
    under = (abs(seen.real) < float(Fraction(width)) / 2) & (abs(seen.imag) < 0.8)
    assert said == (rule != "nearest" and bool((under.any(axis=1) & ~under.all(axis=1)).any()))


def test_times_from_half_of_the_stated_radius_stand_beside_those_from_the_checked_one(table: Scene) -> None:
    """From where no other wheel carries it, and from farther out, each as a path from there tells it."""
    scene = standing(table)
    assert scene.check.wider is not None
    assert float(scene.check.wider) == 50
    found = inertia_answer(scene)
    assert found is not None
    near = float(scene.check.radius) / 2
    assert f"from 4 starts {near:.4g} mm away: within" in found.sentence
    assert "from 4 starts 25 mm away, half of the 50 mm that are stated, so also over other wheels: " in found.sentence
    stated = found.numbers["from_stated"]
    assert len(stated["from"]) + stated["tip"] == 4
    for row in stated["from"]:
        x, y, _ = row["start"]
        assert math.hypot(x - 150, y - 100) == pytest.approx(25)
    alone = settled_from(scene, tuple(stated["from"][0]["start"]))
    assert alone is not None
    assert alone.settles_after == pytest.approx(stated["from"][0]["settles_after"], rel=0.02)


def test_a_body_that_is_followed_alone_is_that_of_the_checked_wheels(table: Scene) -> None:
    """The accuracy of the wheels that carry it, not that of the whole table, and their slowest motion."""
    start, scene = (155.0, 96.0, 0.1), standing(table)
    assert scene.accuracy < table.accuracy
    assert settled_from(table, start) == settled_from(scene, start)


CREEPING = [((-18, 223), (80, -997), 30), ((-191, -94), (897, 442), 30), ((181, -145), (-780, 625), 32)]


def newton(t: float, state: Floats) -> Floats:
    """Newton's law on these three wheels, in mm: c, theta, and their rates, with loads by the balance of moments."""
    places, headings, speeds = (np.array(column, float) for column in zip(*CREEPING, strict=True))
    along = headings / np.linalg.norm(headings, axis=1)[:, None]
    across, arms = along @ [[0, 1], [-1, 0]], places - state[:2]
    contact = state[3:5] + state[5] * arms @ [[0, 1], [-1, 0]]
    slips = np.array([(contact * along).sum(axis=1) - speeds, (contact * across).sum(axis=1)])
    weighted = np.array([[0.25], [0.95]]) * slips
    shares = -np.array([[0.25], [0.95]]) * weighted / np.sqrt((weighted**2).sum(axis=0) + 1e-8)
    loads = np.linalg.solve(np.vstack([np.ones(3), places.T]), [1, *state[:2]])
    forces = loads[:, None] * (shares[0][:, None] * along + shares[1][:, None] * across)
    moment = arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0]
    inertia = ((places - places.mean(axis=0)) ** 2).sum(axis=1).mean() / 2
    return np.array([*state[3:], *9806.65 * forces.sum(axis=0), 9806.65 * moment / inertia])


def test_a_body_that_creeps_to_its_place_of_rest_has_not_settled_on_the_way(tmp_path: Path) -> None:
    """Its distance fades in a minute; it was said to rest 4.5 mm away from its place, settled after 0.83 s."""
    wheels = "".join(f"[[wheel]]\nposition = {[*p]}\nheading = {[*h]}\nspeed = {u}\n" for p, h, u in CREEPING)
    friction = '[friction]\nmu_roll = 0.25\nmu_side = 0.95\n[contact]\nrule = "ellipse"\n'
    (tmp_path / "creeping.toml").write_text(f'[units]\nlength = "mm"\n{friction}{wheels}', encoding="utf-8")
    scene, start = load_scene(tmp_path / "creeping.toml"), (14.3, 6.0, 0.0)
    place = near_rest(scene).place
    assert place is not None
    found = settled_from(scene, start)
    assert found is not None
    assert math.dist(found.end[:2], place) < 0.05 * float(scene.accuracy)
    path = solve_ivp(newton, (0, 60), [*start, 0, 0, 0], method="LSODA", rtol=1e-8, atol=1e-7, max_step=0.2)
    outside = np.linalg.norm(path.y[:2].T - place, axis=1) > float(scene.accuracy)
    assert found.settles_after == pytest.approx(path.t[outside].max(), rel=0.02)


def test_a_body_that_takes_very_many_steps_is_left_on_its_way(table: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wheels of 0.01 m/s whose rollers turn freely took two minutes; such a body is not thrown off."""
    monkeypatch.setattr(settling, "LONGEST", 20)
    left = settled_from(table, (155.0, 96.0, 0.1))
    assert left is not None
    assert left.kind is settling.Settling.OPEN
    assert left.work < 60


def test_a_body_with_inertia_on_wheels_that_all_stand_still_rests_where_it_starts(table: Scene) -> None:
    scene = standing(table)
    stopped = replace(scene, wheels=tuple(replace(w, given_speed=scene.field.zero) for w in scene.wheels))
    found = inertia_answer(stopped)
    assert found is not None
    assert len(found.numbers["from"]) == 4
    assert all(row["end"] == row["start"] for row in found.numbers["from"])
    assert found.numbers["settles_after"] == 0
