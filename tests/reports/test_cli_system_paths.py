"""Solutions of plain systems through the command line, against their closed forms."""

from __future__ import annotations

import csv
import io
import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from tests.thorough import few, keep

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


def test_two_surfaces_become_a_slide(follow: Follow) -> None:
    """x' = -2 if x > y else 2, y' = -3 if y > x else 1.5 from (1.5, 1)."""
    record = follow(TWO_SURFACES, "1.5,1", "--until", "1")
    (event,) = record["events"]
    assert (event["kind"], event["surface"]) == ("slide", "x - y = 0")
    assert event["t"] == pytest.approx(1 / 7, abs=EVENT)
    assert record["end"]["state"] == pytest.approx([31 / 34, 31 / 34], abs=EVENT)
    assert record["unique"] is True
    assert (record["schema"], record["kinematics"], record["feedback"]) == ("nonsmooth-trajectory/1", None, None)
    assert (record["states"], record["method"]) == (["x", "y"], "events")


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


def test_no_solution_leaves_a_point_that_is_proved_stable(follow: Follow) -> None:
    """Surfaces touch at the point, which floats alone leave in doubt."""
    record = follow((["x", "v"], ["v", "-sgn(2*x + v*Abs(v))"]), "1,0", "--until", "5")
    assert ([event["kind"] for event in record["events"]], record["unique"]) == (["slide", "rest"], True)
    record = follow((["x", "v"], ["v", "sgn(2*x - v*Abs(v))"]), "0,0", "--until", "1")
    assert record["unique"] is not True


def test_hysteresis_stays_within_its_width(follow: Follow) -> None:
    record = follow(TWO_SURFACES, "1.5,1", "--until", "1", "--method", "hysteresis", "--width", "1e-3")
    assert (record["method"], record["unique"]) == ("hysteresis", None)
    assert record["end"]["state"] == pytest.approx([31 / 34, 31 / 34], abs=1e-2)
    late = np.array([event["state"] for event in record["events"]]) @ [1, -1] / ROOT
    assert np.abs(late) == pytest.approx(1e-3, rel=1e-6)


def test_a_table_holds_the_samples(tmp_path: Path, follow: Follow) -> None:
    record, file = follow(EQ_4, "1,0.5,0"), tmp_path / "path.csv"
    assert run(app, ["simulate", str(tmp_path / "system.toml"), "--from", "1,0.5,0", "-o", str(file)]) == 0
    rows = list(csv.DictReader(io.StringIO(file.read_text())))
    assert [float(row["t"]) for row in rows] == record["t"]
    assert [[float(row[name]) for name in record["states"]] for row in rows] == record["state"]


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


def test_events_and_end_on_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["simulate", "relay-oscillator", "--from", "1,0.5", "--until", "2"]) == 0
    out = capsys.readouterr().out
    for said in ("plain switched system in x, y", "cross at x = 1.5, y = 0", "x = 0, y = -1.5", "unique"):
        assert said in out
