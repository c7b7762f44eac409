"""Where bodies go: from all over the square, home, away, and with which heading."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

import nonsmooth as ns
from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.contact_rules import EllipseRule
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.trajectories.smooth_ends import smooth_ends
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.answers import answers_of, full_answers
from nonsmooth.proofs.answers.destinations import Destinations, Goal, best_point, destinations_of
from nonsmooth.proofs.answers.nearness import nearness
from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.findings import Equilibrium
from nonsmooth.proofs.robust.drift import (
    _directions,
    driven_out,
    is_driven_out_on_one_side,
    largest_spin,
)
from nonsmooth.proofs.robust.ends import decide_ends
from nonsmooth.proofs.robust.followed_body import is_carried_out, leaves_by_funnel
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import ContactSet
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.oracles.floats import Floats
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.oracles.wheels_in_floats import Contacts
from tests.thorough import few, keep, thorough

# ---- Where bodies go from all over the square: exact places beside sampled shares ----------------

# Eight wheels with headings and speeds drawn at random: the checked point is no equilibrium.
RANDOM = """
name = "random"
friction = { mu_roll = 0.8, mu_side = 0.4 }
check = { equilibrium = [0, 0], radius = 0.2 }
wheel = [
    { position = [0.11, -0.18], heading = [-0.06, 0.2], speed = 0.21 },
    { position = [-0.37, 0.01], heading = [0.35, -0.07], speed = 0.17 },
    { position = [0.25, 0.3], heading = [-0.35, -0.26], speed = 0.34 },
    { position = [-0.15, 0.24], heading = [0.22, -0.35], speed = 0.27 },
    { position = [0.3, -0.05], heading = [-0.3, 0.2], speed = 0.12 },
    { position = [-0.2, -0.3], heading = [0.15, 0.33], speed = 0.3 },
]
"""


def destinations(name: str, rule: str = "nearest") -> Destinations:
    found = destinations_of(check_theorem4(load_scene(name, rule=rule), prune=False))
    assert found is not None
    return found


@pytest.fixture(params=keep(1, ["few starts", "all starts"]))
def starts(request: pytest.FixtureRequest) -> None:
    """How many bodies are followed to count shares: a quarter or a tenth of them, or as many as the answers follow."""
    if request.param == "few starts":
        request.getfixturevalue("few_paths")


@pytest.fixture
def random_file(tmp_path: Path) -> str:
    file = tmp_path / "random.toml"
    file.write_text(RANDOM, encoding="utf-8")
    return str(file)


def test_orbits_that_touch_the_border_of_their_cell_circle_about_its_centre() -> None:
    """Rounding told a third of them from the others, which do the same."""
    goes = destinations_of(check_cells(load_scene("spiral-30", rule="box")))
    assert goes is not None
    assert [(one.goal, one.share) for one in goes.found] == [(Goal.PIVOT, 1.0)]


def test_an_array_beside_its_point_brings_bodies_to_its_middle() -> None:
    first = destinations("off-center").found[0]
    assert (first.goal, first.position) == (Goal.POINT, Position.COMES_HOME)
    assert [str(x) for x in first.points[0]] == ["1/2", "1/4"]
    assert first.share > 0.9


def test_rest_lines_are_told_by_their_ends() -> None:
    found = destinations("four-wheel-side").found
    assert {place.goal for place in found} == {Goal.LINE}
    assert sum(place.share for place in found) == pytest.approx(1)


def test_a_conveyor_lets_bodies_circle() -> None:
    goals = {place.goal: place.share for place in destinations("conveyor-3").found}
    assert goals[Goal.ORBIT] > 0.5


@pytest.mark.usefixtures("starts")
def test_shares_add_up_and_every_place_is_where_paths_end(random_file: str) -> None:
    scene = load_scene(random_file)
    check = check_cells(scene)
    found = destinations_of(check)
    assert found is not None
    assert sum(place.share for place in found.found) == pytest.approx(1)
    points = [place for place in found.found if place.goal is Goal.POINT and place.position is Position.COMES_HOME]
    field = array_field(check.partition, Kinematics.EXACT)
    for place in points:
        (end,) = [(float(x), float(y)) for x, y in place.points]
        start = (end[0] + 1e-5, end[1] - 2e-5, 0.0)
        path = simulate(field, start, 100.0)
        assert np.hypot(*(np.array([float(v) for v in path.end.state[:2]]) - end)) < 1e-6


def test_nothing_is_asked_where_all_come_home() -> None:
    assert full_answers(check_theorem4(load_scene("ring-6"))).destinations is None


def test_auto_takes_the_point_where_most_come_home() -> None:
    best = best_point(load_scene("off-center")).scene
    assert [str(x) for x in best.check.equilibrium] == ["1/2", "1/4"]
    assert answers_of(check_theorem4(best))[0].verdict is Position.COMES_HOME


@thorough  # the small one: test_auto_takes_the_point_where_most_come_home
def test_auto_takes_the_middle_of_a_rest_area() -> None:
    best = best_point(load_scene("off-center", rule="box")).scene
    assert answers_of(check_theorem4(best))[0].verdict is Position.STAYS_NEAR


@thorough  # the small one: test_auto_finds_a_point_where_the_body_stands, reports/test_bodies.py
def test_auto_on_the_command_line(random_file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["check", random_file, "--at", "auto", "--require", "position", "--json"]) in {0, 1, 3}
    assert '"answers"' in capsys.readouterr().out


@thorough  # the small one: test_auto_without_cells_proves_the_point_that_floats_propose
def test_without_cells_the_places_are_where_the_field_vanishes() -> None:
    found = destinations("off-center", rule="ellipse")
    (rest,) = [place for place in found.found if place.points]
    scene = load_scene("off-center", rule="ellipse")
    ((vx, vy, omega),) = minima_under(EllipseRule(), scene, np.array(rest.points)).twists
    ((x, y),) = rest.points
    assert np.hypot(vx - omega * y, vy + omega * x) < 1e-9
    path = smooth_path(EllipseRule(), scene, (0.1, -0.3, 0.0), 4.0)
    assert path.end.state[:2] == pytest.approx((x, y), abs=1e-4)
    assert rest.share > 0.9
    assert sum(place.share for place in found.found) == pytest.approx(1)


@thorough  # test_bodies_stand_still_where_the_field_is_stiff
@pytest.mark.parametrize(("count", "near", "steps"), keep(1, [(1, 0.3, 15), (3, 1.0, 40)]))
def test_bodies_that_jump_to_and_fro_about_a_point_are_seen_to_stand(count: int, near: float, steps: int) -> None:
    """Rollers turn all around it: the twist jumps there, and the field has no zero. Small steps end there too."""
    scene = load_scene("spiral-30", rule="roller")
    ends = smooth_ends(scene, np.array([[0.3, 0.1], [-0.2, 0.25], [0.1, -0.3]][:count]))
    assert ends.places.tolist() == [[0.0, 0.0]]
    assert ends.reached.tolist() == [0] * count
    place, step = near * np.array([0.3, 0.1]), 0.02
    for _ in range(steps):
        ((vx, vy, omega),) = minima_under(smooth_rule_of(scene), scene, place[None]).twists
        place = place + step * np.array([vx - omega * place[1], vy + omega * place[0]])
    assert np.hypot(*place) < step


@pytest.mark.usefixtures("without_law")
@pytest.mark.usefixtures("starts")
def test_without_cells_bodies_leave_a_saddle() -> None:
    assert destinations("saddle", rule="ellipse").found[0].goal is Goal.LEAVES


@pytest.mark.usefixtures("starts")
def test_without_cells_bodies_that_all_stand_still_are_an_area() -> None:
    scene = load_scene("four-wheel", rule="ellipse")
    still = replace(scene, wheels=tuple(replace(w, given_speed=scene.field.zero) for w in scene.wheels))
    found = destinations_of(check_theorem4(still))
    assert found is not None
    assert [place.goal for place in found.found] == [Goal.AREA]
    assert found.found[0].share == pytest.approx(1)
    (low, _), (high, _) = found.found[0].points  # where it is, however many places are in it
    assert -0.5 <= low < -0.4 < 0.4 < high <= 0.5


def test_auto_without_cells_proves_the_point_that_floats_propose(tmp_path: Path) -> None:
    file = tmp_path / "shifted.toml"
    lines = [f"{{ position = [{x}, {y}], heading = [{a}, {b}] }}," for x, y, a, b in SHIFTED]
    head = 'friction = { mu_roll = 0.8, mu_side = 0.8 }\ncontact = { rule = "ellipse" }\ncheck = { radius = 0.5 }\n'
    file.write_text(head + "wheel = [\n" + "\n".join(lines) + "\n]\n", encoding="utf-8")
    best = best_point(load_scene(str(file))).scene
    assert [str(x) for x in best.check.equilibrium] == ["3/10", "1/10"]
    assert answers_of(check_theorem4(best))[0].verdict is Position.COMES_HOME


# Four wheels at the corners of a square about (0.3, 0.1), rims to its middle.
SHIFTED = [(1.3, 1.1, -1, -1), (-0.7, 1.1, 1, -1), (-0.7, -0.9, 1, 1), (1.3, -0.9, -1, 1)]


@few(1)
@pytest.mark.parametrize("name", ["ring-6", "rectangle"])
def test_bodies_stand_still_where_the_field_is_stiff(name: str) -> None:
    """Explicit steps alone go on to and fro beside the point, faster than what counts as standing still."""
    scene = load_scene(name, rule="ellipse")
    side = np.linspace(-0.9, 0.9, 3) * float(scene.check.radius)
    ends = smooth_ends(scene, np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2))
    assert ends.places.tolist() == [[0.0, 0.0]]
    assert ends.reached.tolist() == [0] * 9


def test_bodies_over_rollers_that_all_stand_stay_where_they_start() -> None:
    """Steps to and fro were sought there, as long as the fastest body takes: a division by zero."""
    wheels = [ns.Wheel(place, heading="inward", speed=0) for place in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    scene = ns.Array(wheels, mu_roll=1, mu_side="1/2", rule="roller").scene
    starts = np.array([[0.1, 0.2], [-0.3, 0.1]])
    ends = smooth_ends(scene, starts)
    np.testing.assert_allclose(ends.places[ends.reached], starts, atol=1e-9)


# ---- What ``leaves`` means: bodies end, or are carried, farther than the accuracy; with outlines, and loads left
# open.

LARGE = '[body]\nshape = "rectangle"\nwidth = 900\nheight = 700\n'
ROUND = '[body]\nshape = "disc"\nradius = 400\n'


def scene_of(folder: Path, text: str) -> Scene:
    file = folder / "table.toml"
    file.write_text(text, encoding="utf-8")
    return load_scene(str(file))


def position_of(scene: Scene) -> Any:
    return answers_of(check_theorem4(scene, beside=False))[0]


@pytest.mark.parametrize(
    ("rule", "body"), keep(1, [("nearest", LARGE), ("ellipse", ROUND), ("nearest", ROUND), ("ellipse", LARGE)])
)
def test_under_an_outline_that_covers_all_wheels_bodies_are_followed_as_without(
    rule: str, body: str, tmp_path: Path
) -> None:
    table = MeasuredTable.random(3, rule, off=3.0)
    plain, outlined = (position_of(scene_of(tmp_path, table.toml + more)) for more in ("", body))
    assert (plain.verdict, outlined.verdict) == (Position.COMES_NEAR, Position.COMES_NEAR)
    assert outlined["ends_within"] == plain["ends_within"]
    assert 2 * outlined["accuracy"] <= outlined["within"] <= plain["within"]
    assert "while the same wheels carry it" in outlined.sentence


@pytest.mark.parametrize(
    ("radius", "angle", "is_said"),
    keep(2, [(26, None, True), (None, None, False), (26, 2, True), (26, Fraction(1, 1000), False)]),
)
def test_a_narrow_outline_makes_the_disc_smaller_until_nothing_is_said(
    radius: int | None, angle: int | Fraction | None, is_said: bool, tmp_path: Path
) -> None:
    """None for a radius is that of twice the accuracy, within which all starts would have to be."""
    scene = scene_of(tmp_path, MeasuredTable.random(3, "ellipse", off=3.0).toml).recentred()
    least = 2 * scene.accuracy
    contacts = ContactSet((), least if radius is None else Fraction(radius), None if angle is None else Fraction(angle))
    ends = decide_ends(scene, scene.accuracy, kept=contacts)
    assert (ends is not None) == is_said
    assert ends is None or least <= ends.within < 26


@pytest.mark.parametrize("rule", keep(2, ["nearest", "ellipse", "box", "roller"]))
def test_a_carton_that_rollers_carry_along_leaves(rule: str) -> None:
    answer = position_of(load_scene("roller-bed", rule=rule))
    assert answer.verdict is Position.LEAVES
    assert answer["after"] >= answer["accuracy"]  # the rollers run at one


@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
def test_a_carton_beside_the_middle_is_out_in_time(rule: str) -> None:
    array = ns.load("carton-on-6x6")
    assert isinstance(array, ns.Array)
    found = array.check(rule=rule, at=("1/10", 0)).position
    assert found.verdict == "leaves"
    path = array.simulate((0.1, 0, 0), float(found["after"]), rule=rule)
    away = [math.hypot(row["x"] - 0.1, row["y"]) for row in path.rows()]
    assert max(away) > found["accuracy"]


def test_where_other_wheels_come_under_a_body_within_the_accuracy_nothing_is_said() -> None:
    array = ns.load("carton-on-6x6")
    assert isinstance(array, ns.Array)
    found = array.check(at=("1/10", 0), accuracy="1/8").position
    assert found.verdict == "undecided"
    assert "within the accuracy other wheels come under it" in found.sentence


def loads_open(table: MeasuredTable) -> str:
    return table.toml.replace(f'rule = "{table.rule}"', f'rule = "{table.rule}", loads = "any"')


def three_wheels(off: float) -> MeasuredTable:
    """Three wheels leave no load open, so that the oracle for equal springs knows it."""
    rows = []
    for angle, turn in ((0, off), (120, 0.0), (240, -off / 2)):
        x, y = round(100 * math.cos(math.radians(angle))), round(100 * math.sin(math.radians(angle)))
        rows.append((x, y, round(angle + 180 + turn), 100.0))
    return MeasuredTable(tuple(rows), 0.8, 0.4, "ellipse")


@pytest.mark.usefixtures("without_law")
def test_where_loads_are_open_a_body_must_be_carried_farther_than_the_accuracy(tmp_path: Path) -> None:
    near, far = three_wheels(1.0), three_wheels(60.0)
    answers = [position_of(scene_of(tmp_path, loads_open(table))) for table in (near, far)]
    assert [answer.verdict for answer in answers] == [Position.UNDECIDED, Position.LEAVES]
    assert "driven away from the point itself; whether farther than the accuracy" in answers[0].sentence
    assert "under one of the loads" in answers[1].sentence
    accuracy, after = float(answers[1]["accuracy"]), float(answers[1]["after"])
    assert SmallSteps(near).end(np.zeros(2), 5.0, accuracy)[1] < accuracy
    assert SmallSteps(far).end(np.zeros(2), after, accuracy)[1] >= accuracy * (1 - 1e-6)


@pytest.mark.parametrize("rule", ["nearest", "ellipse", "roller"])
def test_no_sampled_motion_turns_faster_than_the_bound(rule: str, tmp_path: Path) -> None:
    table = MeasuredTable.random(5, rule, off=9.0)
    scene = scene_of(tmp_path, table.toml).recentred()
    bound, body, rng = largest_spin(scene, Fraction(20)), SmallSteps(table), np.random.default_rng(0)
    assert bound is not None
    spins = []
    for angle in rng.uniform(0, 2 * math.pi, 30):
        place = 20 * rng.uniform(0.3, 1) * np.array([math.cos(angle), math.sin(angle)])
        spins.append(abs(body.twists(place[None])[0, 2] / body.length))
    assert 0.2 * bound <= max(spins) <= bound


def test_friction_axes_of_their_own_are_followed_by_the_exact_cells() -> None:
    scene = load_scene("omni-3")
    assert driven_out(scene.recentred(), scene.accuracy) is None
    assert largest_spin(scene.recentred(), scene.accuracy) is not None


TO_ONE_SIDE = [
    *(("nearest", 102), ("box", 114), ("nearest", 104), ("box", 128), ("nearest", 112), ("nearest", 122), ("box", 116)),
    *(("nearest", seed) for seed in (100, 106, 110, 114, 116)),
]


@pytest.mark.parametrize(("rule", "seed"), keep(3, TO_ONE_SIDE))
def test_a_body_that_is_carried_out_from_as_near_as_one_likes_leaves(rule: str, seed: int, tmp_path: Path) -> None:
    """All motions lead out of the disc on one side of a line through the point."""
    table = MeasuredTable.symmetric(seed, rule)
    scene = scene_of(tmp_path, table.toml)
    answer, accuracy = position_of(scene), float(scene.accuracy)
    assert answer.verdict is Position.LEAVES
    assert "some starts as near as one likes" in answer.sentence
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    starts = 1e-3 * accuracy * np.column_stack([np.cos(angles), np.sin(angles)])
    _, farthest = SmallSteps(table).paths(starts, [5.0], accuracy)
    assert farthest.max() >= accuracy


@pytest.mark.usefixtures("without_law")
@pytest.mark.parametrize("number", keep(1, [9, 6, 10, 12, 13]))
def test_a_point_at_which_rollers_turn_is_none_of_rest_where_forces_drive_the_body(number: int, tmp_path: Path) -> None:
    """No exact twist is known there."""
    table = MeasuredTable.random(number, "roller", off=180.0)
    found = check_theorem4(scene_of(tmp_path, table.toml), beside=False).equilibrium
    assert (found.verdict, "bound its speed" in found.reason) == (Equilibrium.FAILS, True)
    assert np.hypot(*SmallSteps(table).velocity(np.zeros(2))) > 1.0


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_forces_do_not_drive_a_body_that_rests(rule: str, arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    assert not BalancedForces(replace(scene, contact=replace(scene.contact, rule=rule))).moves_from_the_origin


FOLLOWED = [
    *(("nearest", 10, 3.0), ("nearest", 2, 9.0), ("ellipse", 1, 9.0), ("box", 14, 25.0)),
    *(("roller", 1, 9.0), ("nearest", 1, 60.0), ("nearest", 10, 25.0), ("box", 23, 60.0)),
]


@pytest.mark.usefixtures("without_law")
@pytest.mark.parametrize(("rule", "number", "off"), keep(3, FOLLOWED))
def test_a_body_from_the_point_is_followed_to_where_it_is_too_far_away(
    rule: str, number: int, off: float, tmp_path: Path
) -> None:
    """It crosses cells and slides between them, or passes a funnel; no one direction is that of all."""
    table = MeasuredTable.random(number, rule, off=off)
    scene = scene_of(tmp_path, table.toml)
    centred, is_out = scene.recentred(), is_carried_out if rule in {"nearest", "box"} else leaves_by_funnel
    assert driven_out(centred, scene.accuracy) is None
    answer = position_of(scene)
    assert answer.verdict is Position.LEAVES
    assert any(words in answer.sentence for words in ("a body that starts at the point goes", "it ends within"))
    _, farthest = SmallSteps(table).end(np.zeros(2), 8.0, float(scene.accuracy))
    assert farthest > scene.accuracy
    assert is_out(centred, scene.accuracy)
    assert not is_out(centred, Fraction(farthest * 1.01))


@pytest.mark.parametrize(("rule", "seed"), keep(1, TO_ONE_SIDE))
def test_bodies_on_one_side_of_a_line_never_come_back_over_it(rule: str, seed: int, tmp_path: Path) -> None:
    table = MeasuredTable.symmetric(seed, rule)
    scene = scene_of(tmp_path, table.toml).recentred()
    assert is_driven_out_on_one_side(scene, scene.accuracy)
    assert not is_driven_out_on_one_side(scene, Fraction(10**6))
    cells = [(cell.polygon, cell.twists) for cell in build_partition(scene).cells]
    accuracy, body, rng = float(scene.accuracy), SmallSteps(table), np.random.default_rng(0)
    places = accuracy * rng.uniform(-0.7, 0.7, (300, 2))
    velocities = np.array([body.velocity(place) for place in places]).reshape(-1, 2)
    directions = [np.array([float(x) for x in direction]) for direction in _directions(cells)]
    least = [(velocities[places @ direction > 0] @ direction).min() for direction in directions]
    assert max(least) > 0


# ---- The disc from which bodies come home, and how far they swing out, against the words of the rule in small steps.

STARTS = 6  # around the point
INSIDE = 0.98  # of the radius of the disc
HOME = 0.1  # of that radius: nearer, steps of this length only chatter
STEP = 4e-3  # of that radius: how far a body moves in one step
MOST_STEPS = 20_000
SLIPS = 3  # steps by which a chattering path may err


def measured_table(seed: int) -> str:
    """4 to 12 wheels in whole millimetres and degrees, rims about inward, as the text of a scene file."""
    random = Random(f"table {seed}")  # no secret
    count = random.randint(4, 12)
    places = {(random.randint(-150, 150), random.randint(-75, 75)) for _ in range(count)}
    lines = ['units = { length = "mm" }', "friction = { mu_roll = 0.8, mu_side = 0.4 }", "check = { radius = 40 }"]
    for x, y in sorted(places):
        heading = round(math.degrees(math.atan2(-y, -x))) + random.randint(-20, 20)
        lines.append(
            f'[[wheel]]\nposition = [{x}, {y}]\nheading = "{heading % 360}*pi/180"\nspeed = {random.randint(50, 400)}'
        )
    return "\n".join(lines) + "\n"


def excursions(scene: Scene, radius: float) -> list[tuple[float, float]]:
    """For each start on the disc's border: the largest distance on the way and the least, in Euler steps."""
    contacts, extremes = Contacts.of(scene), []
    centre = np.array([float(x) for x in scene.check.equilibrium])
    twist_at = {"nearest": contacts.nearest, "box": contacts.box}[scene.contact.rule]
    wheels = list(range(len(scene.wheels)))
    for angle in np.linspace(0.1, 0.1 + math.tau, STARTS, endpoint=False):
        place: Floats = INSIDE * radius * np.array([math.cos(angle), math.sin(angle)])
        farthest = nearest = math.hypot(*place)
        for _ in range(MOST_STEPS):
            v_x, v_y, omega = twist_at(wheels, centre + place)
            # the velocity of the body's own centre of mass, measured in the world
            rate = np.array([v_x - omega * (centre[1] + place[1]), v_y + omega * (centre[0] + place[0])])
            place = place + STEP * radius * rate / max(math.hypot(*rate), 1e-12)
            distance = math.hypot(*place)
            farthest, nearest = max(farthest, distance), min(nearest, distance)
            if nearest < HOME * radius:
                break
        extremes.append((farthest, nearest))
    return extremes


def answered(scene: Scene) -> tuple[float, float] | None:
    """The disc and the swing of the position answer, where bodies come home from a disc."""
    answer = answers_of(check_theorem4(scene, beside=False))[0]
    if answer.verdict is not Position.COMES_HOME or answer["within"] is None:
        return None
    return float(answer["within"]), float(answer["swings_out_to"])


def compare(scene: Scene) -> bool:
    """Whether the scene has a disc; bodies from just inside it come home and swing no farther than is said."""
    said = answered(scene)
    if said is None:
        return False
    within, swing = said
    assert swing >= within
    for farthest, nearest in excursions(scene, within):
        assert farthest <= swing + SLIPS * STEP * within
        assert nearest < HOME * within
    return True


@pytest.mark.parametrize("seed", keep(3, [3, 4, 13, 16, 26, 50]))  # |c|^2 grows somewhere, another V shrinks
def test_bodies_come_home_and_swing_out_no_farther_than_is_said(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    said = answered(scene)
    assert said is not None
    assert said[0] < said[1]
    assert compare(scene)


def test_where_the_distance_never_grows_none_swings_out() -> None:
    assert answered(load_scene("four-wheel")) == (0.5, 0.5)
    assert answered(load_scene("off-center")) is None


TABLES = [2, 3, 5, 8, 13]


@pytest.mark.parametrize("seed", keep(2, TABLES))
def test_discs_of_measured_tables_at_their_best_points(seed: int, tmp_path: Path) -> None:
    file = tmp_path / "table.toml"
    file.write_text(measured_table(seed), encoding="utf-8")
    compare(best_point(load_scene(str(file))).scene)


# Two groups of four wheels in one scene, rims to the middle of their own group: under rule nearest each middle
# attracts, that of the wider group from farther away.
TWO_MIDDLES = [(-4, 0, 1), (4, 0, 3)]  # x and y of the middle, half the side of the group


def two_middles(path: Path) -> Scene:
    lines = ["friction = { mu_roll = 0.8, mu_side = 0.4 }", "check = { radius = 8 }"]
    for x, y, half in TWO_MIDDLES:
        for right, up in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
            place, heading = (x + half * right, y + half * up), (-right, -up)
            lines.append(f"[[wheel]]\nposition = {list(place)}\nheading = {list(heading)}\nspeed = 1")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load_scene(str(path))


def test_auto_takes_the_largest_disc_and_names_the_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each place of rest is checked alone at the same radius: none that comes home has a larger disc than the first."""
    scene = two_middles(tmp_path / "two.toml")
    chosen = best_point(scene)
    home = [point for point in chosen.found if point.position is Position.COMES_HOME]
    assert len(home) >= 2
    discs = [answered(scene.checked_at(point.points[0], scene.check.radius)) for point in home]
    sizes = [0.0 if disc is None else disc[0] for disc in discs]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > sizes[1]
    assert chosen.scene.check.equilibrium == home[0].points[0]
    assert [0.0 if point.within is None else float(point.within) for point in home] == sizes
    assert run(app, ["check", str(tmp_path / "two.toml"), "--at", "auto", "--json"]) in {0, 1, 3}
    said = json.loads(capsys.readouterr().out)["answers"]
    assert [point["within"] for point in said["rest_points"]][: len(sizes)] == [size or None for size in sizes]
    assert said["rest_points"][0]["within"] == said["position"]["within"]


# ---- The heading of bodies that end beside the checked point, against a simulator that shares nothing with the
# proofs.


def rate_at_rest(table: MeasuredTable, about: Floats) -> float:
    """The rotation rate where a body rests that starts at a place, by Newton's method on its velocity."""
    steps = SmallSteps(table)
    zero = root(steps.velocity, about, tol=1e-10)
    assert zero.success
    return float(steps.twists(zero.x[None])[0, 2] / steps.length)


@pytest.mark.usefixtures("without_law")
@pytest.mark.parametrize(("seed", "rule"), [(1, "ellipse"), (2, "ellipse"), (4, "ellipse"), (3, "roller")])
def test_a_body_that_ends_beside_the_point_turns_at_the_rate_that_is_said(seed: int, rule: str, tmp_path: Path) -> None:
    """The point itself is no place of rest; on one of these tables bodies end farther away than the accuracy."""
    table = MeasuredTable.random(seed, rule, off=3.0)
    position, heading, *_ = answers_of(check_theorem4(scene_of(tmp_path, table.toml)))
    assert position.verdict in {"comes near", "leaves"}
    assert heading.verdict == "drifts"
    rate = rate_at_rest(table, np.array(position["at"], dtype=float))
    assert abs(rate) <= float(heading["largest_rate"]) == pytest.approx(abs(rate), rel=1e-3)


# ---- bodies that turn about a place beside the point, of which rims that do not slip fix the twist ----------------


@few(4)
@pytest.mark.parametrize("seed", range(16))
def test_bodies_on_measured_tables_of_rollers_turn_about_a_place_beside_the_point(seed: int, tmp_path: Path) -> None:
    """By small steps of an independent minimizer, from starts on the border of the disc that is said."""
    draw = Random(seed)
    count, skew = draw.choice([3, 4, 5]), draw.choice([55, 65, 75])
    rows = []
    for k in range(count):
        angle = 360 * k / count + draw.uniform(-8, 8)
        x, y = round(150 * math.cos(math.radians(angle))), round(150 * math.sin(math.radians(angle)))
        rows.append((x, y, round(angle + skew), round(100 * (1 + draw.uniform(-0.005, 0.005)), 1)))
    table = MeasuredTable(tuple(rows), 0.8, 0.4, "roller")
    (tmp_path / "table.toml").write_text(table.toml)
    check = check_theorem4(load_scene(tmp_path / "table.toml"))
    turning = nearness(check.scene, check.results).turning
    said = {answer.name: answer.verdict for answer in answers_of(check)}
    if turning is None:
        assert said["position"] != "stays near"
        return
    assert (said["position"], said["heading"]) == ("stays near", "drifts")
    body, within, away = SmallSteps(table), float(turning.within), float(turning.away)
    angles = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    places = within * np.column_stack([np.cos(angles), np.sin(angles)])
    low, high = map(float, turning.rates)
    for _ in range(300):
        middle = places + body.velocity(places) * (0.005 / max(abs(low), abs(high)))
        places = places + body.velocity(middle) * (0.01 / max(abs(low), abs(high)))
    assert np.hypot(*places.T).max() <= within + 2 * away + 1e-3 * within
    assert np.hypot(*(places - places.mean(axis=0)).T).min() > 0.99 * within - 2 * away
