"""The disc from which bodies come home, and how far they swing out, against the words of the rule in small steps."""

from __future__ import annotations

import json
import math
from pathlib import Path
from random import Random

import numpy as np
import pytest

from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.best_point import best_point
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.oracles.small_steps import Contacts
from tests.outlined import Floats
from tests.thorough import keep

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
    contacts, found = Contacts.of(scene), []
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
        found.append((farthest, nearest))
    return found


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
