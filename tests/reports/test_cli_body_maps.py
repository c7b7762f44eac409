"""``simulate --grid`` for a body with an outline: the same numbers in every form, tips, and what is refused."""

from __future__ import annotations

import csv
import io
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import nonsmooth
from nonsmooth.reports.body_maps import BodyMapResult, destinations_figure
from nonsmooth.symbolic.scene_error import SceneError
from tests.thorough import thorough

if TYPE_CHECKING:
    from tests.reports.conftest import Invoke

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
    "schema",
    "scene",
    "rule",
    "status",
    "grid",
    "theta_0",
    "until",
    "destinations",
    "starts",
    "ends",
    "destination",
    "accuracy",
    "home",
    "parts",
]
GRID = ("simulate", "carton.toml", "--grid", "4", "--heading", "0.3")


@pytest.fixture
def carton(tmp_path: Path) -> Path:
    file = tmp_path / "carton.toml"
    file.write_text(SCENE)
    return file


def test_json_and_table_are_the_same_numbers(carton: Path, invoke: Invoke) -> None:
    record = invoke(*GRID, "--json").record
    assert list(record) == KEYS
    assert (record["schema"], record["status"], record["theta_0"]) == ("nonsmooth-body-map/1", "sampled", 0.3)
    assert record["starts"][0] == [-3.0, -3.0]  # the file's radius: the square of the whole array
    assert sum(one["share"] for one in record["destinations"]) == pytest.approx(1)
    assert invoke(*GRID, "-o", "map.csv").status == 0
    rows = list(csv.DictReader(io.StringIO((carton.parent / "map.csv").read_text())))
    assert len(rows) == 16
    for row, end, number in zip(rows, record["ends"], record["destination"], strict=True):
        assert [float(row[key]) for key in ("x_end", "y_end", "theta_end")] == [end[key] for key in ("x", "y", "theta")]
        assert (row["reason"], int(row["destination"])) == (end["reason"], number + 1)
        assert record["destinations"][number]["reason"] == end["reason"]
    assert record["ends"][0]["reason"] == "the body tips"
    assert any(end["reason"] == "the body rests" for end in record["ends"])


def test_a_terminal_says_sampled_and_how_many_tip(carton: Path, invoke: Invoke) -> None:
    out = invoke(*GRID).out
    assert "sampled" in out
    assert "the body tips" in out
    assert "tip where they start" in out
    assert "proved" not in out


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
    assert f"{moving} still moving at the last time" in line
    array = nonsmooth.load(carton)
    assert isinstance(array, nonsmooth.Array)
    shown = array.map(4, heading=0.3, until=0.5)
    assert isinstance(shown, BodyMapResult)
    figure = destinations_figure(shown)
    assert f"{moving} still moving at the last time" in figure.get_suptitle()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[-2:] == ["checked point", "wheel"]
    labels = labels[:-2]
    assert sum(float(label.split(" %")[0]) for label in labels) == pytest.approx(100, abs=0.5)
