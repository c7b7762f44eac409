"""Cells, comparisons and reports as a script holds them: what the command line writes, and short to print."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from tests.thorough import few, keep

MOST_LINES, WIDEST, LONGEST = 12, 100, 2_000
DEEPEST = 6  # attributes of attributes that are printed
FIRST = 3  # entries of a sequence that are printed


@pytest.fixture(autouse=True)
def _no_window() -> None:
    mpl.use("Agg")


def array(name: str = "four-wheel", rule: str = "nearest") -> ns.Array:
    loaded = ns.load(name)
    assert isinstance(loaded, ns.Array)
    return loaded.with_(rule=rule)


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert run(app, arguments) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_cells_are_the_record_of_the_command(rule: str, capsys: pytest.CaptureFixture[str]) -> None:
    cells = array(rule=rule).cells()
    record = json.loads(printed(capsys, "partition", "four-wheel", "--rule", rule, "--json"))
    assert json.loads(json.dumps(cells.to_dict())) == record
    assert len(cells) == len(record["cells"])
    assert {row["cell"] for row in cells.rows()} == {str(k) for k in range(1, len(cells) + 1)}


@few(1)
@pytest.mark.parametrize("show", ["cells", "array", "rates"])
def test_pictures_are_the_files_of_the_command(show: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    own = array().cells().save(tmp_path / "own.svg", show=show)
    other = tmp_path / "other.svg"
    printed(capsys, "partition", "four-wheel", "--show", show, "-o", str(other))
    assert own.read_bytes() == other.read_bytes()


def test_a_picture_of_something_else_is_refused() -> None:
    with pytest.raises(ValueError, match="show: required one of cells, array, rates, received 'tea'"):
        array().cells().picture(show="tea")


def test_a_comparison_is_the_record_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    compared = array().compare()
    record = json.loads(printed(capsys, "partition", "four-wheel", "--compare", "--json"))
    assert json.loads(json.dumps(compared.to_dict())) == record
    exact, *sampled = (row["what"] for row in compared.rows())
    assert exact == "same motion on a share of the area"
    assert set(sampled) == {"sampled"}


@few(2)
@pytest.mark.parametrize("suffix", [".md", ".json", ".tex"])
def test_a_report_is_the_file_of_the_command(
    suffix: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = array().derive(only=["verdict", "cells"], without="cells")
    assert report.sections == ("Verdict",)
    printed(capsys, "derive", "four-wheel", "--only", "verdict", "-o", f"other{suffix}")
    other = Path(f"other{suffix}").read_text(encoding="utf-8")
    own = report.save(f"own{suffix}").read_text(encoding="utf-8")
    assert own == other
    if suffix != ".tex":
        assert own == report.text(suffix)


def test_a_map_is_the_record_of_the_command(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ("--grid", "5", "--heading", "0.2", "--until", "1", "--kinematics", "leading")
    record = json.loads(printed(capsys, "simulate", "off-center", *options, "--json"))
    found = array("off-center").map(5, heading=0.2, until=1.0, kinematics="leading")
    assert json.loads(json.dumps(found.to_dict())) == record
    printed(capsys, "simulate", "off-center", *options, "-o", str(tmp_path / "other.csv"))
    assert found.save(tmp_path / "own.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert len(found.rows()) == 25
    assert len(str(found).splitlines()) <= MOST_LINES


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"grid": 1}, "grid: required 2 to 500 starts in a row, received 1"),
        ({"grid": 3, "heading": float("nan")}, "heading: required a finite number"),
        ({"grid": 3, "heading": float("inf")}, "heading: required a finite number"),
        ({"grid": 3, "until": 0}, "until: required a positive number, received 0"),
        ({"grid": 3, "kinematics": "none"}, "'none' is not a valid Kinematics"),
    ],
)
def test_a_map_of_something_else_is_refused(options: dict[str, Any], line: str) -> None:
    with pytest.raises(ValueError, match=line):
        array().map(**options)


@pytest.mark.parametrize("method", ["events", "hysteresis", "smoothed"])
def test_a_path_is_that_of_the_command(method: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--from", "0.1,0.2,0.3", "--until", "0.5", "--method", method, "--kinematics", "leading"]
    options += [] if method == "events" else ["--width", "0.01"]
    record = json.loads(printed(capsys, "simulate", "four-wheel", *options, "--json"))
    width = {} if method == "events" else {"width": 0.01}
    path = array().simulate((0.1, 0.2, 0.3), 0.5, method=method, kinematics="leading", **width)
    own = json.loads(json.dumps(path.to_dict()))
    assert {key: record[key] for key in own} == own


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"width": 0.01}, "width: required method hysteresis or smoothed, received method events"),
        ({"gain": 2.0}, "gain: required feedback, received none"),
        ({"mass": 0.1}, "mass: required method dynamics, received method events"),
        ({"orbit": True}, "orbit: required a plain switched system, received an array of wheels"),
        ({"until": -1}, "until: required a positive number, received -1"),
    ],
)
def test_what_does_nothing_for_a_path_is_refused(options: dict[str, Any], line: str) -> None:
    with pytest.raises(ValueError, match=f"^{line}$"):
        array().simulate((0.1, 0.2, 0.3), **options)
    with pytest.raises(ValueError, match=r"^start: required 3 numbers x,y,theta, received 2$"):
        array().simulate((0.1, 0.2))
    with pytest.raises(ValueError, match="kinematics: required an array of wheels, received a plain"):
        ns.System(["x"], ["-x"]).simulate((1,), kinematics="exact")


def test_a_wrong_section_or_format_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"without: required names among answers, .* received 'tea'"):
        array().report(tmp_path / "r.md", without="tea")
    with pytest.raises(ValueError, match=r"format: required one of .html, .tex, .md, .json, received 'md'"):
        array().derive(only="verdict").text("md")
    assert not list(tmp_path.iterdir())


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "n" * 200, "off-center", "ring-5"]))
def test_results_print_in_few_lines(name: str, rule: str) -> None:
    asked = array("off-center", rule).with_(name=name) if len(name) > LONGEST / 20 else array(name, rule)
    results: list[Any] = [asked.check(), asked.compare(), asked.derive(only="verdict")]
    results.append(asked.simulate((0.01, 0.02, 0.1), until=0.5))
    if rule != "ellipse":
        results += [asked.cells(), asked.filippov_set((0, 0))]
    for result in results:
        lines = str(result).splitlines()
        assert len(lines) <= MOST_LINES, result
        assert max(map(len, lines)) <= WIDEST, result


@few(1)
@pytest.mark.parametrize("name", ["ring-5", "off-center", "flower", "relay-oscillator-damped"])
def test_whatever_a_result_holds_is_short_to_print(name: str) -> None:
    subject = ns.load(name)
    held: list[Any] = [subject.check()]
    if isinstance(subject, ns.Array):
        held += [subject.scene, subject.cells(), subject.compare(), subject.derive(only="verdict")]
        held += [subject.check(rule="box"), subject.check(rule="ellipse"), subject.simulate((0.01, 0.02, 0.1))]
    for part in inside(held):
        assert len(repr(part)) <= LONGEST, type(part)


def inside(value: Any, depth: int = 0) -> Iterator[Any]:
    """A value of ours and all that it holds."""
    if depth > DEEPEST:
        return
    if isinstance(value, (tuple, list)):
        for entry in value[:FIRST]:
            yield from inside(entry, depth + 1)
    elif dataclasses.is_dataclass(value) and type(value).__module__.startswith("nonsmooth"):
        yield value
        for part in dataclasses.fields(value):
            yield from inside(getattr(value, part.name), depth + 1)


def test_a_body_with_mass_is_what_the_command_follows(capsys: pytest.CaptureFixture[str]) -> None:
    command = ("simulate", "four-wheel", "--from", "0.2,0.3,0", "--until", "0.01", "--method", "dynamics")
    path = array().dynamics((0.2, 0.3, 0), until=0.01, mass=0.02, inertia=0.01)
    assert json.loads(json.dumps(path.to_dict())) == json.loads(
        printed(capsys, *command, "--mass", "0.02", "--inertia", "0.01", "--json")
    )
    study = array().compare_masses((0.2, 0.3, 0), until=0.01, mass=0.01)
    assert json.loads(json.dumps(study.to_dict())) == json.loads(
        printed(capsys, *command, "--mass", "0.01", "--compare-masses", "--json")
    )
    assert len(repr(study).splitlines()) <= MOST_LINES
    with pytest.raises(ValueError, match="mass: required a positive number"):
        array().compare_masses((0.2, 0.3, 0), mass=0)


def test_a_check_of_two_states_is_drawn_as_its_phase_portrait() -> None:
    """With the certified region where one is known; other numbers of states have no picture, and say so."""
    drawn = ns.System(("x", "y"), ("-sign(x) + y", "-y")).check().plot()
    assert "asymptotically stable" in drawn.get_title()
    assert {"border: sliding", "certified region"} <= set(drawn.get_legend_handles_labels()[1])
    for states, rhs in (("x", ["-x"]), ("xyz", ["-x", "-y", "-z"]), ("xy", [["-x", "-y"], ["-2*x", "-y"]])):
        with pytest.raises(TypeError, match="that can be drawn"):
            ns.System(states, rhs).check().plot()
