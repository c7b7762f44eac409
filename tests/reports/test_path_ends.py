"""Paths through the command line: where, when and how they end, of arrays and plain systems, with inertia or not."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.bodies import path as body_path_module
from nonsmooth.analysis.bodies.many_paths import ENDS, BodyEnd, BodyEnds
from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import body_of, body_path
from nonsmooth.analysis.bodies.newton_euler import RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.reports.simulations.heading_maps import HeadingsResult
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.units import Units
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

# ---- ``simulate`` says where, when and how a path ends, with inertia and without -----------------

TABLE = """
name = "table"
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 0.8, mu_side = 0.8 }
contact = { rule = "ellipse" }
grid = { rows = 2, columns = 2, pitch = 200 }
field = { kind = "radial", speed = 0.1 }
"""


def sentence(text: str) -> str:
    return " ".join(text.split())


def test_a_path_that_is_broken_off_is_not_said_to_end(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is followed so far; what is said of it, how long it takes to settle and whether it is unique, is too."""
    monkeypatch.setattr(body_path_module, "MOST_RATES", 30)
    command = ("simulate", "four-wheel", "--rule", "ellipse", "--from", "0.2,0.4,0", "--until", "5")
    said = " ".join(invoke(*command).out.split())
    assert re.search(r"followed until t = [-e0-9.]+, 0\.\d+ from the point, heading [-e0-9.]+ deg, moving at", said)
    assert "ends " not in said
    assert "of its end" not in said
    assert "unique so far: no other solution from this start until then" in said
    ending = invoke(*command, "--json").record["ending"]
    assert (ending["settles_after"], ending["swings"]) == (None, None)


def test_a_body_of_rule_nearest_rests_where_the_engine_says(invoke: Invoke) -> None:
    """The time is that of the event of rest, which the exact pieces give."""
    found = invoke("simulate", "four-wheel", "--from", "0.2,0.4,0.3", "--json").record
    (rest,) = [event["t"] for event in found["events"] if event["kind"] == "rest"]
    ending = found["ending"]
    assert ending["motion"] == "at rest"
    assert ending["since"] == pytest.approx(rest, abs=1e-6)
    assert (ending["distance"], ending["swings"]) == (pytest.approx(0.0, abs=1e-12), 0)
    shown = sentence(invoke("simulate", "four-wheel", "--from", "0.2,0.4,0.3").out)
    heading = math.degrees(found["end"]["state"][2])
    assert f"ends at the point, heading {heading:.3g} deg" in shown
    assert "inertia" not in shown


def test_a_bare_heading_is_in_the_unit_of_the_scene(invoke: Invoke, tmp_path: Path) -> None:
    """Degrees beside a unit of length; refused where the file's own angles were taken for degrees untold."""
    scene = tmp_path / "table.toml"
    scene.write_text(TABLE, encoding="utf-8")
    found = [
        invoke("simulate", str(scene), "--from", f"30,20,{angle}", "--until", "0.01", "--json").record["state"][0]
        for angle in ("5", "5deg", "pi/36")
    ]
    assert found[0] == found[1] == found[2] == pytest.approx([30, 20, math.pi / 36])
    mapped = invoke("simulate", str(scene), "--grid", "2", "--heading", "5", "--until", "0.01", "--json").record
    assert mapped["theta_0"] == pytest.approx(math.pi / 36)
    four = [(1, 1, 225), (-1, 1, 315), (-1, -1, 45), (1, -1, 135)]
    wheels = "".join(f"[[wheel]]\nposition = [{x}, {y}]\nheading = {angle}\n" for x, y, angle in four)
    scene.write_text(f"friction = {{ mu_roll = 1, mu_side = 0.5 }}\n{wheels}", encoding="utf-8")
    refused = invoke("simulate", str(scene), "--from", "0.2,0.4,0.3")
    assert refused.status == 2
    assert "required a unit, as 0.3deg or 0.3rad" in refused.err


def test_with_units_the_body_has_inertia(invoke: Invoke, tmp_path: Path) -> None:
    """The time to settle is that of the longer path that ``--method dynamics`` follows with finer steps."""
    scene = tmp_path / "table.toml"
    scene.write_text(TABLE, encoding="utf-8")
    found = invoke("simulate", str(scene), "--from", "30,20,0", "--until", "0.1", "--json").record
    assert found["ending"]["motion"] == "moving"
    heavy = found["inertia"]
    assert (heavy["status"], heavy["what"]) == ("simulated", "comes to rest")
    array = load_scene(str(scene))
    assert array.inertia is not None
    path = body_path(array, body_of(array, 1 / float(array.inertia.gravity)), (30, 20, 0), 4.0)
    away = np.hypot(*(path.states[:, :2] - path.states[-1, :2]).T)
    settles = float(path.times[np.flatnonzero(away > float(array.accuracy))[-1]])
    assert heavy["settles_after"] == pytest.approx(settles, rel=0.02)
    shown = sentence(invoke("simulate", str(scene), "--from", "30,20,0", "--until", "0.1").out)
    assert re.search(r"without inertia: ends [\d.]+ mm from the point, heading .* deg, moving at [\d.]+ mm/s", shown)
    followed = r"with inertia \(simulated, from rest until its place rests at t = [\d.]+ s\)"
    assert re.search(followed + r": ends .* mm of its end after [\d.]+ s, \d+ swing", shown)


def test_maps_count_the_starts_that_come_home(invoke: Invoke) -> None:
    found = invoke("simulate", "four-wheel", "--grid", "5", "--json").record
    at_x, at_y, accuracy = 0.0, 0.0, found["accuracy"]
    near = [math.hypot(x - at_x, y - at_y) <= accuracy for x, y in found["points"]]
    assert found["home"] == sum(near) == 25
    assert "25 of 25 end within" in invoke("simulate", "four-wheel", "--grid", "5").out


def test_maps_of_rules_without_cells_need_no_outline(invoke: Invoke, tmp_path: Path) -> None:
    """Each end is that of the path that the engine follows from the same start, however the body turns there."""
    (tmp_path / "table.toml").write_text(TABLE, encoding="utf-8")
    found = invoke("simulate", "table.toml", "--grid", "2", "--json").record
    ends = [(end["x"], end["y"]) for end in found["ends"]]
    assert found["home"] == len(ends) == 4
    for (x, y), end in list(zip(found["starts"], ends, strict=True))[::3]:
        path = invoke("simulate", "table.toml", "--from", f"{x},{y},0", "--until", "10", "--json").record
        assert path["end"]["state"][:2] == pytest.approx(end, abs=0.5)


def ends_at(headings: list[float], reasons: list[BodyEnd]) -> HeadingsResult:
    """Bodies started every 30 degrees that end at these headings (degrees)."""
    count = len(headings)
    starts = np.column_stack([np.zeros((count, 2)), 2 * math.pi * (np.arange(count) - count // 2) / count])
    poses = np.column_stack([np.zeros((count, 2)), np.radians(headings)])
    kinds = np.array([ENDS.index(reason) for reason in reasons])
    ends = BodyEnds(starts, poses, np.ones(count), kinds, np.zeros((count, 2), int), np.zeros(count), 1.0)
    return HeadingsResult(load_scene("carton-on-6x6"), (0.0, 0.0), ends)


def test_a_heading_returns_from_the_arc_that_ends_there() -> None:
    """Around a full turn: -180 and 150 are neighbours; ends may have turned once more."""
    headings = [178.0, -152.0, -100.0, 5.0, 5.1, 5.2, 364.8, 5.0, 60.0, 120.0, 178.2, 538.1]
    found = ends_at(headings, [BodyEnd.REST] * 12)
    arcs = [(round(math.degrees(arc.first)), round(math.degrees(arc.last))) for arc in found.returning]
    assert arcs == [(-90, 30), (120, 180)]
    assert [round(math.degrees(arc.heading or 0.0)) for arc in found.returning] == [5, 178]
    assert sum(arc.starts for arc in found.arcs) == 12
    assert found.summary() == "0.0873 rad returns from -1.57 to 0.524 rad; 3.11 rad returns from 2.09 to 3.14 rad"
    in_degrees = replace(found, scene=replace(found.scene, units=Units("mm", in_degrees=True)))
    assert in_degrees.summary() == "5 deg returns from -90 to 30 deg; 178 deg returns from 120 to 180 deg"


def test_a_heading_is_drawn_within_half_a_turn_of_its_start() -> None:
    """A body that keeps -180 degrees lies on the line of those that are kept, not a turn above it."""
    kept = [180.0, *range(-150, 180, 30)]
    upright, line = ends_at(kept, [BodyEnd.REST] * 12).figure().axes[0].lines
    drawn, expected = (np.array(one.get_ydata(), float) for one in (upright, line))
    assert np.abs(drawn - expected).max() < 1e-12


def test_headings_that_fall_or_lie_beside_their_arc_do_not_return() -> None:
    headings = [40.0] * 4 + [0.0] * 8
    found = ends_at(headings, [BodyEnd.REST] * 4 + [BodyEnd.TIPS] * 8)
    assert found.returning == ()
    assert found.summary() == "no heading returns"


def test_the_accuracy_of_paths_is_that_of_the_check(invoke: Invoke) -> None:
    """A carton leaves most wheels of a table out: those that carry it at the checked pose say what is near."""
    checked = invoke("check", "carton-on-6x6", "--json").record["answers"]["position"]["accuracy"]
    path = invoke("simulate", "carton-on-6x6", "--from", "0.05,0,0", "--until", "0.1", "--json").record["ending"]
    assert path["accuracy"] == pytest.approx(checked, rel=1e-3)


# ---- ``nonsmooth simulate --method dynamics``: its text, JSON, CSV and pictures, and what it refuses.

DYNAMICS = ("simulate", "four-wheel", "--from", "0.2,0.4,0", "--method", "dynamics")


def invoke(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Standard output of a run that ends well."""
    assert run(app, arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out


def test_record_is_that_of_a_trajectory_with_body_and_velocity(capsys: pytest.CaptureFixture[str]) -> None:
    record: dict[str, Any] = json.loads(invoke(capsys, *DYNAMICS, "--mass", "0.02", "--inertia", "0.01", "--json"))
    model = contact_model(load_scene("four-wheel"))
    path = simulate_dynamics(model, RigidBody(0.02, 0.01), (0.2, 0.4, 0.0), 2.0)
    assert (record["schema"], record["method"], record["kinematics"]) == ("nonsmooth-trajectory/1", "dynamics", "exact")
    assert (record["mass"], record["inertia"], record["creep_speed"]) == (0.02, 0.01, path.creep)
    assert record["t"] == path.times.tolist()
    assert np.array_equal(np.column_stack([record["state"], record["velocity"]]), path.states)
    assert record["velocity"][0] == [0, 0, 0]
    assert (record["end"]["t"], record["end"]["reason"], record["unique"]) == (2, "the time is over", True)


HEAVY_TABLE = """
units = {{ length = "{unit}", speed = "m/s" }}
friction = {{ mu_roll = 0.8, mu_side = 0.4 }}
check = {{ radius = {radius} }}
[[wheel]]
position = [{x}, {y}]
speed = 0.3
[[wheel]]
position = [-{x}, {y}]
speed = 0.3
[[wheel]]
position = [-{x}, -{y}]
speed = 0.3
[[wheel]]
position = [{x}, -{y}]
speed = 0.3
"""


def test_gravity_is_that_of_the_units_a_scene_states(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """One table in metres and in millimetres moves one body: the same times, all lengths a thousandfold."""
    found = {}
    for unit, size in (("m", 1), ("mm", 1000)):
        file = tmp_path / f"{unit}.toml"
        file.write_text(HEAVY_TABLE.format(unit=unit, radius=0.05 * size, x=0.2 * size, y=0.1 * size), encoding="utf-8")
        start = f"{0.02 * size:g},{0.01 * size:g},0"
        arguments = ("simulate", str(file), "--from", start, "--method", "dynamics", "--until", "0.4")
        found[unit] = json.loads(invoke(capsys, *arguments, "--json"))
        assert found[unit]["mass"] == pytest.approx(1 / (9.80665 * size))
        text = " ".join(invoke(capsys, *arguments).split())
        assert f"mass per weight (1/g): {1 / (9.80665 * size):.3g} in {unit} and seconds" in text
    end, larger = (np.array(found[unit]["state"][-1]) for unit in ("m", "mm"))
    assert np.allclose(end * [1000, 1000, 1], larger, rtol=1e-5, atol=1e-6)


def test_path_does_not_depend_on_the_scenes_rule(capsys: pytest.CaptureFixture[str]) -> None:
    one, other = (invoke(capsys, *DYNAMICS, "--until", "0.2", "--rule", rule) for rule in ("ellipse", "nearest"))
    assert one == other


# ---- Solutions of plain systems through the command line, against their closed forms -------------

ROUNDING = 1e-14
EVENT = 1e-12  # times of events found on DOP853's dense output
CURVED = 1e-9  # DOP853 over a few units of time
ROOT = math.sqrt(2)

Follow: TypeAlias = Callable[..., Any]

TWO_SURFACES = (["x", "y"], ["-2*sign(x - y)", "-3/4 - 9/4*sign(y - x)"])
EQ_4 = (
    ["x", "y", "theta"],
    [
        "sqrt(2)/2*sign(x)*(sign(y**2 - x**2) - 1)",
        "-sqrt(2)/2*sign(y)*(sign(y**2 - x**2) + 1)",
        "sqrt(2)/2*sign(x)*sign(y)*sign(y**2 - x**2)",
    ],
)


def write_system(folder: Path, states: list[str], rhs: list[str]) -> str:
    file = folder / "system.toml"
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n")
    return str(file)


@pytest.fixture
def follow(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Follow:
    """Simulate a system and return its record."""

    def call(system: tuple[list[str], list[str]] | str, start: str, *options: str) -> Any:
        name = system if isinstance(system, str) else write_system(tmp_path, *system)
        assert run(app, ["simulate", name, "--from", start, "--json", *options]) == 0
        captured = capsys.readouterr()
        assert not captured.err
        return json.loads(captured.out)

    return call


def test_equation_4_with_its_heading(follow: Follow) -> None:
    """Diagonal at t = 0.5/sqrt2 with theta -1/4, origin at 1.5/sqrt2."""
    record = follow(EQ_4, "1,0.5,0", "--until", "2")
    slide, rest = record["events"][:2]
    assert (slide["kind"], rest["kind"]) == ("slide", "rest")
    assert slide["t"] == pytest.approx(0.5 / ROOT, abs=EVENT)
    assert slide["state"] == pytest.approx([0.5, 0.5, -0.25], abs=EVENT)
    assert rest["t"] == pytest.approx(1.5 / ROOT, abs=EVENT)
    assert rest["state"] == pytest.approx([0, 0, -0.25], abs=EVENT)
    assert record["unique"] is False  # theta may drift at the origin


def test_a_slide_is_left_where_the_drive_grows(follow: Follow) -> None:
    """x' = 1 + t for x < 0 and t - 1 for x > 0: x leaves 0 at t = 1 and is 1/8 at t = 3/2."""
    record = follow((["x", "t"], ["t - sign(x)", "1"]), "0,0", "--until", "1.5")
    assert [event["kind"] for event in record["events"]] == ["slide", "leave"]
    assert record["events"][1]["t"] == pytest.approx(1, abs=CURVED)
    assert record["end"]["state"] == pytest.approx([1 / 8, 1.5], abs=CURVED)


def test_a_circle_is_crossed(follow: Follow) -> None:
    """Radius e^(t - 1); counterclockwise at rate 2 inside the unit circle, clockwise outside."""
    circle = "sign(x**2 + y**2 - 1)"
    system = (["x", "y"], [f"x + 2*y*{circle}", f"y - 2*x*{circle}"])
    record = follow(system, f"{math.exp(-1)!r},0", "--until", "1.5")
    (event,) = record["events"]
    assert (event["kind"], event["t"]) == ("cross", pytest.approx(1, abs=CURVED))
    end = math.exp(0.5) * np.array([math.cos(1), math.sin(1)])
    assert record["end"]["state"] == pytest.approx(end, abs=CURVED)


def test_built_in_relays(follow: Follow) -> None:
    record = follow("relay-oscillator", "1,0.5", "--until", "2")
    assert record["end"]["state"] == pytest.approx([0, -1.5], abs=EVENT)
    assert record["events"][0]["t"] == pytest.approx(0.5, abs=EVENT)
    damped = follow("relay-oscillator-damped", "1,0.5", "--until", "10")
    assert damped["events"][-1]["kind"] == "rest"
    assert damped["events"][-1]["t"] == pytest.approx(3, abs=EVENT)  # 5/3, then turns of 8/9 with ratio 1/3: 4/3
    assert damped["end"]["state"] == pytest.approx([0, 0], abs=EVENT)


def test_one_state(follow: Follow) -> None:
    record = follow((["x"], ["-sign(x)"]), "0.75", "--until", "2")
    assert [event["kind"] for event in record["events"]] == ["rest"]
    assert record["events"][0]["t"] == pytest.approx(0.75, abs=ROUNDING)
    assert ns.System(["x"], ["-sign(x)"]).simulate([0.75], until=2).summary().startswith("1 event, ")


def test_repelling_surfaces_are_not_unique(follow: Follow) -> None:
    record = follow((["x", "y"], ["sign(x)", "1"]), "0,0", "--until", "1")
    assert record["unique"] is False
    assert "nonunique" in [event["kind"] for event in record["events"]]


@pytest.mark.usefixtures("without_reach")
def test_no_solution_leaves_a_point_that_is_proved_stable(follow: Follow) -> None:
    """Surfaces touch at the point, which floats alone leave in doubt."""
    record = follow((["x", "v"], ["v", "-sgn(2*x + v*Abs(v))"]), "1,0", "--until", "5")
    assert ([event["kind"] for event in record["events"]], record["unique"]) == (["slide", "rest"], True)
    record = follow((["x", "v"], ["v", "sgn(2*x - v*Abs(v))"]), "0,0", "--until", "1")
    assert record["unique"] is not True


@few(1)
@pytest.mark.parametrize("suffix", keep(1, [".svg", ".png", ".pdf"]))
@pytest.mark.parametrize(
    ("states", "rhs", "start"),
    [(["x"], ["-sign(x)"], "1"), (*TWO_SURFACES, "1.5,1"), (*EQ_4, "1,0.5,0"), (["x", "y"], ["0", "0"], "1,1")],
)
def test_pictures(states: list[str], rhs: list[str], start: str, suffix: str, tmp_path: Path) -> None:
    """One, two and three states; and a point that never moves, without a surface."""
    name, files = write_system(tmp_path, states, rhs), [tmp_path / f"{name}{suffix}" for name in "ab"]
    for file in files:
        assert run(app, ["simulate", name, "--from", start, "-o", str(file)]) == 0
    first, second = (file.read_bytes() for file in files)
    assert first == second
    if suffix == ".svg":
        ET.fromstring(first)
