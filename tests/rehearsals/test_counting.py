"""A new command is a study and a line; options, keywords, help and refusals are fields, a format of files one line."""

from __future__ import annotations

import csv
import inspect
import json
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.reports.commands import registry
from nonsmooth.reports.simulations.simulate_options import PATH, SimulateOptions
from nonsmooth.reports.studies import result
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study import takes
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from tests.rehearsals import counting
from tests.reports.conftest import Invoke


@pytest.fixture(autouse=True)
def _counting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.COMMANDS, "count", registry.Entry("Count something.", "count four-wheel"))
    monkeypatch.setitem(sys.modules, "nonsmooth.reports.commands.count", counting)


def test_a_new_command_prints_writes_and_refuses(invoke: Invoke) -> None:
    shown = " ".join(invoke("count", "four-wheel", "--twice").out.replace("│", " ").split())
    assert "four-wheel: counted" in shown
    assert "count 8" in shown
    assert invoke("count", "eq-4", "--times", "3", "--json").record == {
        "schema": "toy-count/1", "scene": "eq-4", "count": 6
    }  # fmt: skip
    assert invoke("count", "four-wheel", "-o", "c.csv").out == "c.csv: 4 counted\n"
    assert list(csv.reader(Path("c.csv").read_text(encoding="utf-8").splitlines())) == [
        ["scene", "count", "half"], ["four-wheel", "4", ""]
    ]  # fmt: skip
    for ending, begin in ((".svg", b"<?xml"), (".png", b"\x89PNG"), (".pdf", b"%PDF")):
        assert invoke("count", "four-wheel", "-o", f"c{ending}").status == 0
        assert Path(f"c{ending}").read_bytes().startswith(begin)
    refused = invoke("count", "eq-4", "--twice")
    assert refused == (2, "", "nonsmooth: --twice: required an array of wheels, received a plain switched system\n")
    help_text = invoke("count", "--help").out
    assert "Of arrays:" in help_text
    assert "--times N" in help_text


def test_python_has_the_same_result_and_refusals(invoke: Invoke, tmp_path: Path) -> None:
    study, scene = counting.Count(), load_scene("four-wheel")
    found = study.of(scene, twice=True)
    assert isinstance(found, counting.CountResult)
    assert found.to_dict() == invoke("count", "four-wheel", "--twice", "--json").record
    assert found.rows() == [{"scene": "four-wheel", "count": 8, "half": None}]
    invoke("count", "four-wheel", "--twice", "-o", "other.csv")
    assert found.save(tmp_path / "own.csv").read_bytes() == Path("other.csv").read_bytes()
    assert "<p>four-wheel: counted</p><table>" in found._repr_html_()
    with pytest.raises(ValueError, match=r"^twice: required an array of wheels, received a plain switched system$"):
        study.of(load_system("eq-4"), twice=True)
    with pytest.raises(ValueError, match=r"^times: required no twice, received twice$"):
        study.of(scene, twice=True, times=2)


def test_a_new_format_is_one_line(monkeypatch: pytest.MonkeyPatch, invoke: Invoke) -> None:
    def lines(shown: Result, ending: str) -> bytes:
        return "".join(f"{json.dumps(row)}\n" for row in shown.rows()).encode()

    monkeypatch.setitem(result.FORMATS, ".jsonl", lines)
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    found = array.map(3)
    own = found.save("map.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line) for line in own] == found.rows()
    assert invoke("simulate", "four-wheel", "--grid", "3", "-o", "other.jsonl").status == 0
    assert Path("other.jsonl").read_bytes() == Path("map.jsonl").read_bytes()
    assert invoke("count", "four-wheel", "-o", "count.jsonl").status == 0


def test_the_fields_of_the_options_are_the_options_and_the_keywords(invoke: Invoke) -> None:
    shown = " ".join(invoke("simulate", "--help").out.split())
    for entry in fields(SimulateOptions):
        own = entry.metadata["option"]
        assert (own.flag or f"--{entry.name.replace('_', '-')}") in shown
        assert own.help in shown.replace("[default: 1.0]", "")
    keywords = inspect.signature(ns.Array.simulate).parameters
    defaults = {entry.name: entry.default for entry in fields(SimulateOptions)}
    for name in ("kinematics", "method", "width", "feedback", "law", "gain"):
        assert keywords[name].default == defaults[name]
        assert f"{name}: " in (ns.Array.simulate.__doc__ or "")


def test_a_method_takes_the_options_of_its_headings() -> None:
    @takes(SimulateOptions, PATH)
    def follow(start: Any, **options: Any) -> None:
        """Follow."""

    assert list(inspect.signature(follow).parameters) == ["start", "until", "kinematics", "method", "width", "options"]
