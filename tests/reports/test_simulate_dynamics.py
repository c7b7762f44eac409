"""``nonsmooth simulate --method dynamics``: its text, JSON, CSV and pictures, and what it refuses."""

from __future__ import annotations

import csv
import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.dynamics.newton_euler import RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import thorough

DYNAMICS = ("simulate", "four-wheel", "--from", "0.2,0.4,0", "--method", "dynamics")
PNG = b"\x89PNG"


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


def test_body_is_a_disc_of_a_tenth_unless_said_otherwise(capsys: pytest.CaptureFixture[str]) -> None:
    record = json.loads(invoke(capsys, *DYNAMICS, "--until", "0.1", "--json"))
    assert (record["mass"], record["inertia"]) == (0.1, pytest.approx(0.1))  # R^2 = 2
    text = invoke(capsys, *DYNAMICS, "--until", "0.1")
    assert "four-wheel: full dynamics, mass 0.1, inertia 0.1, from rest" in text
    assert "end: the time is over" in text
    assert "(1/g): 0.1 unless stated" in text


TABLE = """
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
        file.write_text(TABLE.format(unit=unit, radius=0.05 * size, x=0.2 * size, y=0.1 * size), encoding="utf-8")
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


@thorough
def test_masses_as_text_and_json_are_the_same_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = (*DYNAMICS, "--until", "0.02", "--mass", "0.01", "--compare-masses")
    record = json.loads(invoke(capsys, *arguments, "--json"))
    assert list(record) == ["schema", "scene", "start", "until", "rows", "limits", "skipped"]
    assert (record["schema"], record["start"], record["until"]) == ("nonsmooth-masses/1", [0.2, 0.4, 0], 0.02)
    assert [row["mass"] for row in record["rows"]] == pytest.approx([10.0**-k for k in range(2, 7)])
    assert [{own["rule"] for own in row["distances"]} for row in record["rows"]] == [
        {"nearest", "box", "ellipse", "roller"}
    ] * 5
    assert {limit["rule"] for limit in record["limits"]} == {"nearest", "box", "roller"}
    assert record["skipped"] == []
    text = invoke(capsys, *arguments)
    for row in record["rows"]:
        for own in row["distances"]:
            assert f"{own['position']:.3g}," in text  # a cell may be broken after the comma
            assert f"{own['rotation']:.3g} " in text


@thorough  # the small one: test_rules_without_a_path_are_named, analysis/test_mass_study.py
def test_masses_name_paths_that_end_early_or_do_not_exist(capsys: pytest.CaptureFixture[str]) -> None:
    outward = ("simulate", "outward", "--from", "0.2,0.4,0", "--method", "dynamics", "--compare-masses")
    assert "rule nearest: compared until t = 0.0791001" in invoke(capsys, *outward)
    outside = ("simulate", "four-wheel", "--from", "0.6,0.4,0", "--method", "dynamics", "--compare-masses")
    text = " ".join(invoke(capsys, *outside, "--until", "0.1").split())
    assert "rule box: no path: required a start inside the domain" in text


@thorough  # the small one: test_record_is_that_of_a_trajectory_with_body_and_velocity
def test_files_of_a_path(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    files = {suffix: str(tmp_path / f"path{suffix}") for suffix in (".csv", ".json", ".svg", ".png")}
    for file in files.values():
        assert "the time is over" in invoke(capsys, *DYNAMICS, "--until", "0.5", "-o", file)
    record = json.loads(Path(files[".json"]).read_text(encoding="utf-8"))
    header, *lines = csv.reader(Path(files[".csv"]).read_text(encoding="utf-8").splitlines())
    assert header == ["t", "x", "y", "theta", "w_x", "w_y", "omega"]
    expected = np.column_stack([record["t"], record["state"], record["velocity"]])
    assert np.array_equal(np.array(lines, float), expected)
    assert ET.parse(files[".svg"]).getroot().tag.endswith("svg")
    assert Path(files[".png"]).read_bytes().startswith(PNG)


@thorough  # the small one: test_a_body_with_mass_is_what_the_command_follows, reports/interface/test_results.py
def test_files_of_masses(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = (*DYNAMICS, "--until", "0.02", "--compare-masses", "-o")
    table, picture = tmp_path / "masses.csv", tmp_path / "masses.svg"
    assert "from rule ellipse at mass 1e-05" in invoke(capsys, *arguments, str(table))
    invoke(capsys, *arguments, str(picture))
    header, *lines = csv.reader(table.read_text(encoding="utf-8").splitlines())
    assert header == ["mass", "rule", "position", "rotation", "until"]
    assert len(lines) == 5 * 4 + 3
    assert [line[1] for line in lines if float(line[0]) == 0] == ["nearest", "box", "roller"]
    first = picture.read_bytes()
    invoke(capsys, *arguments, str(picture))
    assert picture.read_bytes() == first
