"""Maps of ends through the command line: the four-wheel formula, what is seen at a time, and every format."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
import xml.etree.ElementTree as ET
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.reports.cli import app
from nonsmooth.reports.output import progress as progress_module
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.simulations.maps import SettleMapResult, ends_figure
from tests.thorough import few, keep

FORMULA = 1e-12
KEYS = [
    "schema", "scene", "rule", "kinematics", "grid", "theta_0", "until", "summary", "starts", "theta", "arrival",
    "points", "basin", "ends", "unique", "accuracy", "home", "parts",
]  # fmt: skip


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert run(app, ["simulate", *arguments, "--json"]) == 0
    captured = capsys.readouterr()
    assert not captured.err
    return json.loads(captured.out)


def test_the_formula_of_the_four_wheel_array(capsys: pytest.CaptureFixture[str]) -> None:
    """theta_inf = theta_0 + g ||y0| - |x0||/2 and T = (|x0| + |y0|)/sqrt2."""
    record = printed(
        capsys, "four-wheel", "--grid", "12", "--heading", "0.25", "--kinematics", "leading", "--radius", "1/4"
    )
    assert list(record) == KEYS
    assert (record["schema"], record["grid"], record["theta_0"], record["until"]) == ("nonsmooth-map/1", 12, 0.25, None)
    x, y = np.array(record["starts"]).T
    assert (np.abs(x).max(), np.abs(y).max(), len(x)) == (0.25, 0.25, 144)
    g = np.sign(x * y * (y**2 - x**2))
    assert np.abs(np.array(record["theta"]) - 0.25 - g * np.abs(np.abs(y) - np.abs(x)) / 2).max() <= FORMULA
    assert np.abs(np.array(record["arrival"]) - (np.abs(x) + np.abs(y)) / math.sqrt(2)).max() <= FORMULA
    assert record["ends"] == [{"reason": "the body rests", "place": "corner (0, 0)"}]
    summary = record["summary"]
    assert (summary["shares"], summary["arrived"], summary["unique"]) == ([1.0], 1.0, 1.0)
    assert summary["latest_arrival"] == pytest.approx(0.5 / math.sqrt(2), abs=FORMULA)
    assert summary["theta"] == [min(record["theta"]), max(record["theta"])]


def test_starts_that_are_late_are_on_their_way(capsys: pytest.CaptureFixture[str]) -> None:
    record = printed(capsys, "four-wheel", "--grid", "10", "--kinematics", "leading", "--until", "0.4")
    x, y = np.array(record["starts"]).T
    late = (np.abs(x) + np.abs(y)) / math.sqrt(2) > 0.4
    assert 0 < late.sum() < 100
    reasons = [record["ends"][k]["reason"] for k in record["basin"]]
    assert [reason == "the time is over" for reason in reasons] == late.tolist()
    for key in ("theta", "arrival"):
        assert [value is None for value in record[key]] == late.tolist()
    assert [point == [None, None] for point in record["points"]] == late.tolist()
    assert record["summary"]["arrived"] == pytest.approx(1 - late.mean())


def test_the_parts_of_a_map_add_up_to_all_starts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Those that are late are named beside those that rest: in the record, the line, the title and the legend."""
    arguments = ["four-wheel", "--grid", "10", "--kinematics", "leading", "--until", "0.4"]
    record = printed(capsys, *arguments)
    late = sum(value is None for value in record["arrival"])
    parts = {part["end"]: part["starts"] for part in record["parts"]}
    assert parts == {"the body rests": 100 - late, "the time is over": late}
    assert run(app, ["simulate", *arguments, "-o", str(tmp_path / "map.json")]) == 0
    line = capsys.readouterr().out
    assert "100 starts: " in line
    assert f"the time is over ({late})" in line
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    shown = array.map(10, until=0.4, kinematics="leading")
    assert isinstance(shown, SettleMapResult)
    figure = ends_figure(shown)
    assert f"the time is over ({late})" in figure.get_suptitle()
    shares = [text.get_text() for text in figure.legends[0].get_texts() if " %: " in text.get_text()]
    assert sum(float(label.split(" %")[0]) for label in shares) == pytest.approx(100, abs=0.1)


def test_a_table_holds_what_json_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, record_file = tmp_path / "map.csv", tmp_path / "map.json"
    arguments = ["simulate", "conveyor-3", "--grid", "6"]
    assert run(app, [*arguments, "-o", str(table)]) == 0
    assert run(app, [*arguments, "-o", str(record_file)]) == 0
    capsys.readouterr()
    record = printed(capsys, "conveyor-3", "--grid", "6")
    assert json.loads(record_file.read_text()) == record
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert [[float(row["x"]), float(row["y"])] for row in rows] == record["starts"]
    assert [float(row["theta"]) if row["theta"] else None for row in rows] == record["theta"]
    assert [record["ends"][k] for k in record["basin"]] == [{k: row[k] for k in ("reason", "place")} for row in rows]
    assert [row["unique"] == "yes" for row in rows] == record["unique"]


@few(1)
@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
@pytest.mark.parametrize(
    ("scene", "grid"), keep(1, [("four-wheel-side", "3"), *((name, "7") for name in ("conveyor-3", "saddle"))])
)
def test_pictures_are_whole_and_equal_for_equal_input(scene: str, grid: str, suffix: str, tmp_path: Path) -> None:
    """With starts that never arrive, starts that are not unique, and more ends than there are colors."""
    files = [tmp_path / f"{name}{suffix}" for name in "ab"]
    for file in files:
        assert run(app, ["simulate", scene, "--grid", grid, "--until", "0.3", "-o", str(file)]) == 0
    first, second = (file.read_bytes() for file in files)
    assert first == second
    assert len(first) > 5_000
    if suffix == ".svg":
        ET.fromstring(first)


def test_the_summary_on_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["simulate", "four-wheel-side", "--grid", "6", "--kinematics", "leading"]) == 0
    out = capsys.readouterr().out
    for said in (
        "6 x 6 starts",
        "theta_inf",
        "-0.15 to 0.15",
        "by t = 0.141 to 0.707",
        "latest arrival",
        "t = 0.7071067812",
        "never arrive",
    ):
        assert said in out
    assert "33.33 %" in out.splitlines()[-2]  # 12 of the 36 starts lie on a diagonal, where both axes can be reached


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_progress_is_shown_on_a_terminal_and_only_when_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    shown = {}
    for patience in (0.0, 60.0):
        stream = Terminal()
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(progress_module, "PATIENCE", patience)
        with progress("counting starts") as report:
            report(1, 2)
            report(2, 2)
        shown[patience] = "counting starts" in stream.getvalue()
    assert shown == {0.0: True, 60.0: False}


@pytest.mark.parametrize("seed", range(6))
def test_cells_too_thin_for_floats_are_refused_or_mapped(seed: int) -> None:
    """Rings that are regular but for rounding: two borders that ought to be one are 1e-15 apart."""
    rng = np.random.default_rng(seed)
    count, off = (4, 8)[seed % 2], math.radians((0, 3, 7)[seed % 3])
    turns = 2 * math.pi * np.arange(count) / count
    places = np.stack([np.cos(turns), np.sin(turns)], axis=1) + rng.uniform(-1, 1, (count, 2)) * 10.0 ** -(
        14 + seed % 2
    )
    wheels = [ns.Wheel((x, y), t + math.pi + off, 1, 1, 0.5) for (x, y), t in zip(places.tolist(), turns, strict=True)]
    with suppress(RefusalError):
        found = ns.Array(wheels).map(5)
        assert isinstance(found, SettleMapResult)
        assert sum(found.found.shares) == pytest.approx(1)


def test_a_path_that_floats_lose_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def lost(*arguments: Any) -> Any:
        raise TrajectoryError("no edge of cell 1 at (0, 0): please report this")

    monkeypatch.setattr("nonsmooth.reports.simulations.maps.settled", lost)
    assert run(app, ["simulate", "four-wheel", "--grid", "2"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "required cells that floats tell apart, to follow paths, received thinner ones (no edge of cell 1" in said
