"""``simulate --grid`` for a body with an outline: the same numbers in every form, tips, and what is refused."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from math import degrees, hypot
from pathlib import Path

import pytest

import nonsmooth
from nonsmooth.reports.checks.answers import destinations_head
from nonsmooth.reports.checks.check import check_scene
from nonsmooth.reports.simulations.body_maps import BodyMapResult, destinations_figure
from nonsmooth.reports.studies.result import Result
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.reports.conftest import Invoke
from tests.thorough import thorough

SCENE = """
[grid]
rows = 6
columns = 6
[field]
kind = "radial"
speed = "unit"
[body]
shape = "rectangle"
width = 3
height = 2
[friction]
mu_roll = 1
mu_side = 1
[contact]
rule = "ellipse"
[check]
radius = 3
"""
KEYS = [
    "schema", "scene", "rule", "status", "grid", "theta_0", "until",
    "destinations", "starts", "ends", "destination", "accuracy", "home", "parts",
]  # fmt: skip
GRID = ("simulate", "carton.toml", "--grid", "4", "--heading", "0.3")


@pytest.fixture
def carton(tmp_path: Path) -> Path:
    file = tmp_path / "carton.toml"
    file.write_text(SCENE)
    return file


def test_json_and_table_are_the_same_numbers(carton: Path, invoke: Invoke) -> None:
    record = invoke(*GRID, "--json", "-o", "map.csv").record
    assert list(record) == KEYS
    assert (record["schema"], record["status"], record["theta_0"]) == ("nonsmooth-body-map/1", "sampled", 0.3)
    assert record["starts"][0] == [-3.0, -3.0]  # the file's radius: the square of the whole array
    assert sum(one["share"] for one in record["destinations"]) == pytest.approx(1)
    rows = list(csv.DictReader(io.StringIO((carton.parent / "map.csv").read_text())))
    assert len(rows) == 16
    for row, end, number in zip(rows, record["ends"], record["destination"], strict=True):
        assert [float(row[key]) for key in ("x_end", "y_end", "theta_end")] == [end[key] for key in ("x", "y", "theta")]
        assert (row["reason"], int(row["destination"])) == (end["reason"], number + 1)
        assert record["destinations"][number]["reason"] == end["reason"]
    assert record["ends"][0]["reason"] == "the body tips"
    assert any(end["reason"] == "the body rests" for end in record["ends"])


def test_a_terminal_says_sampled_and_how_many_tip(carton: Path, invoke: Invoke) -> None:
    out = invoke("simulate", "carton.toml", "--grid", "3").out
    assert "sampled" in out
    assert "the body tips" in out
    assert "tip where they start" in out
    assert "proved" not in out


def test_bodies_that_still_move_are_told_apart_by_where_they_are(carton: Path, invoke: Invoke) -> None:
    """The time is enough for some of those that start near the point, and for no other."""
    record = invoke("simulate", "carton.toml", "--grid", "9", "--until", "0.3", "--json").record
    found = {one["where"]: one["share"] for one in record["destinations"] if one["reason"].startswith("still moving")}
    (near,) = (where for where in found if where.startswith("within "))
    assert found.keys() == {near, "elsewhere"}
    assert 81 * found[near] == pytest.approx(record["home"])


TABLE = """
units = { length = "mm", speed = "m/s" }
wheels = { file = "wheels.csv" }
body = { shape = "rectangle", width = 350, height = 250, mass = 3 }
check = { equilibrium = [200, 80], radius = 100 }
"""


@pytest.fixture
def table_file(tmp_path: Path) -> Path:
    """Ten omniwheels in two rows that push inward, under a body that covers six of them."""
    headings = [[0, 0, 90, 180, 180], [0, 0, -90, 180, 180]]
    rows = [(100 * k, 160 * j, headings[j][k]) for j in range(2) for k in range(5)]
    lines = [f"W{n},{x},{y},{heading},roller,0.4,0.02,0.3" for n, (x, y, heading) in enumerate(rows, 1)]
    head = "name,x,y,heading,contact,mu_roll,mu_side,speed"
    (tmp_path / "wheels.csv").write_text("\n".join([head, *lines]), encoding="utf-8")
    file = tmp_path / "table.toml"
    file.write_text(TABLE, encoding="utf-8")
    return file


def test_it_says_where_bodies_tip_and_over_which_wheels(table_file: Path, invoke: Invoke) -> None:
    """The starts that end at the time 0, and no nearer one; in the words of the table, with the names of wheels."""
    command = ("simulate", str(table_file), "--grid", "5", "--until", "0.02")
    out = " ".join(re.sub("[^\\x00-\\x7f]", " ", invoke(*command).out).split())  # without the lines of the table
    record = invoke(*command, "--json").record
    at_once = [end for end, start in zip(record["ends"], record["starts"], strict=True) if end["t"] == 0]
    away = [hypot(x - 200, y - 80) for x, y in record["starts"]]
    nearest = min(d for d, end in zip(away, record["ends"], strict=True) if end["t"] == 0)
    assert f"{len(at_once)} of 25 starts; all nearer than {nearest:g} mm to the point stand" in out
    assert "the centre of mass is beyond the line through wheels W" in out
    assert "check speaks of the part within 25 mm of the point, 6.25 % of this square" in out


def test_a_check_says_which_part_of_the_stated_square_its_shares_are_of(table_file: Path) -> None:
    scene = check_scene(load_scene(table_file), ask_others=False).scene
    head = destinations_head(scene, 121)
    assert "in the square within 25 mm, 6.25 % of the 100 mm square that is stated (--grid 9 maps that)" in head
    assert "on the wheels that carry it here" in head
    assert destinations_head(load_scene("four-wheel"), 7).endswith("start in the square (shares sampled from 7 starts)")


def test_a_picture_is_drawn(carton: Path, invoke: Invoke) -> None:
    done = invoke("simulate", "carton.toml", "--grid", "2", "-o", "map.svg")
    assert (done.status, done.err) == (0, "")
    assert (carton.parent / "map.svg").read_text().startswith("<?xml")


@thorough  # the small one: test_json_and_table_are_the_same_numbers
def test_python_gives_the_same_map(carton: Path, invoke: Invoke) -> None:
    array = nonsmooth.load(carton)
    assert isinstance(array, nonsmooth.Array)
    found = array.map(4, heading=0.3)
    assert found.to_dict() == invoke(*GRID, "--json").record
    assert "(sampled)" in repr(found)
    assert len(found.rows()) == 16
    assert "the rate of theta there is open" in invoke("simulate", carton.name, "--rule", "nearest", *GRID[2:]).out
    assert array.with_(rule="nearest").map(2).to_dict()["rule"] == "nearest"
    with pytest.raises(SceneError, match="leading"):
        array.map(3, kinematics="leading")


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_ends_say_by_when_and_how_fast_bodies_turn_on(invoke: Invoke, capsys: pytest.CaptureFixture[str]) -> None:
    """The rate is that of a check; a body that still moves has a heading and no end, one that stands still no rate."""

    def shown(result: Result) -> str:
        result.to_terminal()
        return " ".join(capsys.readouterr().out.replace("│", " ").split())

    spiral = nonsmooth.load("spiral-30").with_(rule="ellipse")
    turning = spiral.map(2)
    (end, *_) = turning.to_dict()["ends"]
    checked = invoke("check", "spiral-30", "--rule", "ellipse", "--json")
    assert abs(end["turning"]) == pytest.approx(float(checked.record["answers"]["heading"]["largest_rate"]), rel=1e-3)
    said = f"by t = {end['t']:.3g}, turning at {degrees(end['turning']):.3g} deg per unit of time"
    assert said in shown(turning)
    moving = shown(spiral.map(2, until=1))
    assert "still moving at the last time, at heading -" in moving
    assert "of 4 end, or are at the last time, within" in moving  # none of them ends
    assert "latest end none until t = 1 " in moving
    assert "turning" not in shown(nonsmooth.load("four-wheel").with_(rule="ellipse").map(2))


def test_the_parts_add_up_to_all_starts(carton: Path, invoke: Invoke) -> None:
    """A body that is still moving at the last time is named: in the record, the line, the title and the legend."""
    until = ("--until", "0.5")
    record = invoke(*GRID, *until, "--json").record
    counted = Counter(end["reason"] for end in record["ends"])
    moving = counted["still moving at the last time"]
    assert moving > 0
    for part in record["parts"]:
        (reason,) = [reason for reason in counted if part["end"].startswith(reason)]
        assert part["starts"] == counted[reason]
    assert sum(part["starts"] for part in record["parts"]) == 16
    line = invoke(*GRID, *until, "-o", "map.json").out
    assert "16 starts: " in line
    assert f"still moving at the last time ({moving})" in line
    array = nonsmooth.load(carton)
    assert isinstance(array, nonsmooth.Array)
    shown = array.map(4, heading=0.3, until=0.5)
    assert isinstance(shown, BodyMapResult)
    figure = destinations_figure(shown)
    assert f"still moving at the last time ({moving})" in figure.get_suptitle()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[-2:] == ["checked point", "wheel"]
    labels = labels[:-2]
    assert sum(float(label.split(" %")[0]) for label in labels) == pytest.approx(100, abs=0.5)


def test_wheels_are_named_where_there_is_room() -> None:
    array = nonsmooth.load("carton-on-6x6")
    assert isinstance(array, nonsmooth.Array)
    _, places = array.with_(rule="box").map(2).figure().axes
    assert {text.get_text() for text in places.texts} - {""} == {str(number) for number in range(1, 37)}
