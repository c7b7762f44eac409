"""Bodies with an outline through the commands: who carries, maps of ends, tipping, and what is refused."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from math import degrees, hypot
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth
from nonsmooth.analysis.bodies.many_paths import BodyEnd
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.reports.checks.answers import destinations_head
from nonsmooth.reports.checks.check import check_array
from nonsmooth.reports.figures.path import MARKERS
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.simulations.body_maps import BodyMapResult
from nonsmooth.reports.simulations.closed_paths import follow_closed
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import Result
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import LoopErrors
from tests.oracles.wheels_in_floats import places_of
from tests.outlined import polygon_depths
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

# ---- Bodies with an outline through the commands: who carries, how far that holds, tipping, and what is refused.

CARTON = """name = "carton"
[friction]
mu_roll = 1
mu_side = "1/2"
[grid]
rows = 6
columns = 6
[body]
shape = "rectangle"
width = 2.6
height = 1.6
"""
COVER = '[body]\nshape = "disc"\nradius = 9\n'
ALIKE = ("seconds", "contact_set")


@pytest.fixture
def carton(tmp_path: Path) -> str:
    file = tmp_path / "carton.toml"
    file.write_text(CARTON)
    return str(file)


def record(invoke: Invoke, *arguments: str) -> tuple[int, dict[str, Any]]:
    done = invoke(*arguments, "--json")
    return done.status, done.record


@few(2)
@pytest.mark.parametrize("rule", CONTACT_RULES)
@pytest.mark.parametrize("name", keep(1, ["four-wheel", "off-center", "ring-5"]))
def test_a_body_over_all_wheels_changes_no_verdict(name: str, rule: str, invoke: Invoke, tmp_path: Path) -> None:
    source = Path(load_scene.__code__.co_filename).parents[1] / "scenes" / f"{name}.toml"
    file = tmp_path / "covered.toml"
    file.write_text(f"{source.read_text()}\n{COVER}")
    bare, covered = (record(invoke, "check", scene, "--rule", rule) for scene in (name, str(file)))
    places = [found[1]["answers"]["position"] for found in (bare, covered)]
    if places[0]["verdict"] == "leaves":  # where and when is not asked of bodies with an outline
        for found in (bare, covered):
            found[1]["answers"]["position"] = "leaves"
        assert places[1]["verdict"] == "leaves"
    without, within = ({k: v for k, v in found[1].items() if k not in ALIKE} for found in (bare, covered))
    assert (bare[0], without) == (covered[0], within)
    assert covered[1]["contact_set"]["wheels"] == bare[1]["contact_set"]["wheels"]
    assert bare[1]["contact_set"]["margin"] is None
    assert covered[1]["contact_set"]["angle"] is None


@pytest.mark.parametrize("rule", keep(2, CONTACT_RULES))
def test_the_wheels_that_carry_are_an_array_of_their_own(
    carton: str, rule: str, invoke: Invoke, tmp_path: Path
) -> None:
    """The same verdicts as of a grid of those four wheels alone, in the same square."""
    file = tmp_path / "four.toml"
    file.write_text(CARTON.split("[grid]", maxsplit=1)[0] + "[grid]\nrows = 2\ncolumns = 2\n[check]\nradius = 0.2\n")
    own, four = (record(invoke, "check", scene, "--rule", rule)[1] for scene in (carton, str(file)))
    for clause in ("equilibrium", "translation", "rotation", "theorem4"):
        assert own[clause]["verdict"] == four[clause]["verdict"]
    assert own["answers"]["position"]["verdict"] == four["answers"]["position"]["verdict"]
    assert own["translation"]["worst_rate"] == four["translation"]["worst_rate"]


@pytest.mark.parametrize(
    ("side", "mass", "until"),
    keep(1, [(4, "1e-2", "0.01"), (6, "1e-4", "0.05"), (6, "1e-2", "0.01"), (6, "1e-4", "0.02")]),
)
def test_masses_are_compared_where_wheels_leave(
    invoke: Invoke, tmp_path: Path, side: int, mass: str, until: str
) -> None:
    file = tmp_path / "carton.toml"
    file.write_text(CARTON.replace("= 6", f"= {side}"))
    masses = ("--method", "dynamics", "--compare-masses", "--mass", mass, "--until", until)
    status, found = record(invoke, "simulate", str(file), "--from", f"{side / 2 - 1.7},0.15,0", *masses)
    assert status == 0
    assert {own["rule"] for own in found["limits"]} == {"nearest", "box", "roller"}
    beyond = side / 2 - 0.1
    tips = invoke("simulate", str(file), "--from", f"{beyond},{beyond},0", *masses)
    assert (tips.status, tips.out) == (2, "")
    assert tips.err.count("\n") == 1


@few(1)
@pytest.mark.parametrize("options", [("--rule", "nearest"), ("--rule", "box"), ("--method", "dynamics")])
def test_a_path_of_every_kind_through_the_command(
    options: tuple[str, ...], carton: str, invoke: Invoke, tmp_path: Path
) -> None:
    run = ("simulate", carton, *options, "--from", "1.3,0.15,0", "--until", "0.25")
    status, found = record(invoke, *run)
    assert status == 0
    kinds = [event["kind"] for event in found["events"]]
    assert kinds.count("leave") == 2
    for name in ("path.svg", "path.html", "path.csv"):
        assert invoke(*run, "-o", str(tmp_path / name)).status == 0
    tips = invoke("simulate", carton, *options, "--from", "2.9,2.9,0")
    assert (tips.status, tips.out) == (2, "")
    assert tips.err.endswith("where the body stands on its wheels, received one where it tips over wheel 36\n")


@pytest.mark.parametrize("rule", keep(1, ["nearest", "ellipse"]))
def test_auto_finds_a_point_where_the_body_stands(carton: str, rule: str, invoke: Invoke) -> None:
    status, found = record(invoke, "check", carton, "--at", "auto", "--rule", rule)
    assert status in {0, 1}
    assert found["equilibrium"]["verdict"] == "holds"


# ---- ``simulate --grid`` for a body with an outline: the same numbers in every form, tips, and what is refused.

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
GRID = ("simulate", "carton.toml", "--grid", "3", "--heading", "0.3")


@pytest.fixture
def large_carton(tmp_path: Path) -> Path:
    file = tmp_path / "carton.toml"
    file.write_text(SCENE)
    return file


def test_json_and_table_are_the_same_numbers(large_carton: Path, invoke: Invoke) -> None:
    record = invoke(*GRID, "--json", "-o", "map.csv").record
    assert list(record) == KEYS
    assert (record["schema"], record["status"], record["theta_0"]) == ("nonsmooth-body-map/1", "sampled", 0.3)
    assert record["starts"][0] == [-3.0, -3.0]  # the file's radius: the square of the whole array
    assert sum(one["share"] for one in record["destinations"]) == pytest.approx(1)
    rows = list(csv.DictReader(io.StringIO((large_carton.parent / "map.csv").read_text())))
    assert len(rows) == 9
    for row, end, number in zip(rows, record["ends"], record["destination"], strict=True):
        assert [float(row[key]) for key in ("x_end", "y_end", "theta_end")] == [end[key] for key in ("x", "y", "theta")]
        assert (row["reason"], int(row["destination"])) == (end["reason"], number + 1)
        assert record["destinations"][number]["reason"] == end["reason"]
    assert record["ends"][0]["reason"] == "the body tips"
    assert any(end["reason"] == "the body rests" for end in record["ends"])


def test_bodies_that_still_move_are_told_apart_by_where_they_are(large_carton: Path, invoke: Invoke) -> None:
    """The time is enough for some of those that start near the point; one rests at it from the start."""
    record = invoke("simulate", "carton.toml", "--grid", "9", "--until", "3", "--json").record
    found = {one["where"]: one["share"] for one in record["destinations"] if one["reason"].startswith("still moving")}
    (near,) = (where for where in found if where.startswith("within "))
    assert found.keys() == {near, "elsewhere"}
    (rests,) = (one for one in record["destinations"] if one["reason"] == BodyEnd.REST)
    assert 81 * (found[near] + rests["share"]) == pytest.approx(record["home"])


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
    """The starts that do not stand, and no nearer one; in the words of the table, with the names of wheels."""
    command = ("simulate", str(table_file), "--grid", "5", "--until", "0.02")
    out = " ".join(re.sub("[^\\x00-\\x7f]", " ", invoke(*command).out).split())  # without the lines of the table
    record = invoke(*command, "--json").record
    fallen = [end["t"] == 0 and end["reason"] != BodyEnd.REST for end in record["ends"]]
    away = [hypot(x - 200, y - 80) for x, y in record["starts"]]
    nearest = min(d for d, falls in zip(away, fallen, strict=True) if falls)
    assert f"{sum(fallen)} of 25 starts; all nearer than {nearest:g} mm to the point stand" in out
    assert "the centre of mass is beyond the line through wheels W" in out
    assert "check speaks of the part within 25 mm of the point, 6.25 % of this square" in out


def test_a_check_says_which_part_of_the_stated_square_its_shares_are_of(table_file: Path) -> None:
    scene = check_array(load_scene(table_file), ask_others=False).scene
    head = destinations_head(scene, 121)
    assert "in the square within 25 mm, 6.25 % of the 100 mm square that is stated (--grid 9 maps that)" in head
    assert "on the wheels that carry it here" in head
    assert destinations_head(load_scene("four-wheel"), 7).endswith("start in the square (shares sampled from 7 starts)")


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


def test_the_parts_add_up_to_all_starts(large_carton: Path, invoke: Invoke) -> None:
    """A body that is still moving at the last time is named: in the record, the line, the title and the legend."""
    command = ("simulate", "carton.toml", "--grid", "5", "--heading", "0.3", "--until", "0.5")
    record = invoke(*command, "--json").record
    counted = Counter(end["reason"] for end in record["ends"])
    moving = counted["still moving at the last time"]
    assert moving > 0
    for part in record["parts"]:
        (reason,) = [reason for reason in counted if part["end"].startswith(reason)]
        assert part["starts"] == counted[reason]
    assert sum(part["starts"] for part in record["parts"]) == 25
    line = invoke(*command, "-o", "map.json").out
    assert "25 starts: " in line
    assert f"still moving at the last time ({moving})" in line
    array = nonsmooth.load(large_carton)
    assert isinstance(array, nonsmooth.Array)
    shown = array.map(5, heading=0.3, until=0.5)
    assert isinstance(shown, BodyMapResult)
    figure = shown.figure()
    assert f"still moving at the last time ({moving})" in figure.get_suptitle()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"checked point", "wheel"} < set(labels)
    shares = [float(label.split(" %: ")[0]) for label in labels if " %: " in label]
    assert sum(shares) == pytest.approx(100, abs=0.5)


def test_wheels_are_named_where_there_is_room() -> None:
    array = nonsmooth.load("carton-on-6x6")
    assert isinstance(array, nonsmooth.Array)
    _, places = array.with_(rule="box").map(2).figure().axes
    assert {text.get_text() for text in places.texts} - {""} == {str(number) for number in range(1, 37)}


# ---- The closed loop of a body with an outline ends where other wheels carry it than those of its certified law.

LEAVES = (-0.189, 0.088, -0.242)  # from here wheel 14 comes under the carton
STAYS = (0.05, 0.03, 0.05)
LOOKS = 3000


def closed_loop(start: tuple[float, float, float], rule: str = "nearest") -> Trajectory:
    scene = load_scene("carton-on-6x6", rule=rule)
    return follow_closed(scene, SimulateOptions(start=start, feedback=True), LawName.CERTIFIED).trajectory


def first_change(path: Trajectory) -> float:
    """When other wheels than at first are under the carton, by looking closely; infinite where none ever are."""
    scene = load_scene("carton-on-6x6")
    assert scene.body is not None
    corners = np.array([[float(x) for x in corner] for corner in scene.body.vertices])
    places = places_of(scene)
    first = polygon_depths(corners, places, np.array(path.at(0.0))) > 0
    for time in np.linspace(0.0, 2.0, LOOKS):
        if ((polygon_depths(corners, places, np.array(path.at(time))) > 0) != first).any():
            return float(time)
    return np.inf


def as_if_without_outline(start: tuple[float, float, float], rule: str = "nearest") -> Trajectory:
    """The closed loop on the same wheels, which carry for ever."""
    scene = replace(standing(load_scene("carton-on-6x6", rule=rule)), body=None, idle=())
    return follow_closed(scene, SimulateOptions(start=start, feedback=True), LawName.CERTIFIED).trajectory


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_a_loop_ends_where_a_wheel_enters(rule: str) -> None:
    path, whole = closed_loop(LEAVES, rule), as_if_without_outline(LEAVES, rule)
    assert path.end.reason is EndReason.WHEELS
    assert path.events[-1].kind is EventKind.ENTER
    assert path.events[-1].surface == "wheel 14 under the body"
    change = first_change(whole)
    assert change - 2.0 / (LOOKS - 1) <= path.end.t <= change
    for time in np.linspace(0.0, path.end.t, 7):
        assert path.at(time) == pytest.approx(whole.at(time), abs=1e-12)
    assert path.pieces[-1].end == path.times[-1] == path.end.t


def test_a_loop_whose_pose_is_late_ends_there_too() -> None:
    """Its path is of samples, joined by straight lines."""
    scene = load_scene("carton-on-6x6", rule="box")
    late = LoopErrors(scene.field.rational(Fraction(1, 1000)), scene.field.zero, Fraction(0))
    scene = replace(scene, loop_errors=late)
    path, exact = (
        follow_closed(each, SimulateOptions(start=LEAVES, feedback=True), LawName.CERTIFIED).trajectory
        for each in (scene, replace(scene, loop_errors=None))
    )
    assert path.method == "sampled"
    assert (path.end.reason, path.events[-1].surface) == (EndReason.WHEELS, "wheel 14 under the body")
    assert path.end.t == pytest.approx(exact.end.t, rel=0.05)
    assert path.times[-1] == path.end.t > path.times[-2]
    assert path.states[-1] == path.end.state
    stays = follow_closed(scene, SimulateOptions(start=STAYS, feedback=True), LawName.CERTIFIED).trajectory
    assert stays.end.reason is EndReason.TIME
    assert not stays.events


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_a_loop_that_keeps_its_wheels_goes_on(rule: str) -> None:
    path, whole = closed_loop(STAYS, rule), as_if_without_outline(STAYS, rule)
    assert first_change(whole) == np.inf
    assert path.end == whole.end


def test_every_event_has_a_mark() -> None:
    assert set(MARKERS) == set(EventKind)
