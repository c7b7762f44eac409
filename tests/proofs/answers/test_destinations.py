"""Where bodies go from all over the square: exact places beside sampled shares."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.contact_rules.ellipse import EllipseRule
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.trajectories.smooth_ends import smooth_ends
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers import destinations as destinations_module
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.answers import answers_of, full_answers
from nonsmooth.proofs.answers.best_point import best_point
from nonsmooth.proofs.answers.destinations import Destinations, Goal, destinations_of
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import few, keep, thorough

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
def starts(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """How many bodies are followed to count shares: a quarter of them, or as many as the answers follow."""
    if request.param == "few starts":
        monkeypatch.setattr(destinations_module, "STARTS", 15)
        monkeypatch.setattr(destinations_module, "FEW_STARTS", 5)


@pytest.fixture
def random_file(tmp_path: Path) -> str:
    file = tmp_path / "random.toml"
    file.write_text(RANDOM, encoding="utf-8")
    return str(file)


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


@few(2)
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["eq-3"], "required an array of wheels for --at auto, received a plain system"),
        (["off-center", "--radius", "1/100"], "required a rest point in the checked square, found none"),
        (
            ["off-center", "--rule", "ellipse", "--radius", "1/100"],
            "required a rest point that is simple or can be enclosed under rule ellipse",
        ),
    ],
)
def test_auto_refuses_in_one_line(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["check", *arguments, "--at", "auto"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err


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
    side = np.linspace(-0.9, 0.9, 5) * float(scene.check.radius)
    ends = smooth_ends(scene, np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2))
    assert ends.places.tolist() == [[0.0, 0.0]]
    assert ends.reached.tolist() == [0] * 25
