"""A new kind of scene is read, checked, reported and held by Python with ten files, four of them a branch each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from tests.rehearsals.spring import BRANCHES, OWN, SpringResult, ToyKind, branches
from tests.reports.conftest import Invoke

KIND, OFFERED = 1, 1  # the member of SceneKind, and the line of the package that offers the class of Python


@pytest.fixture(autouse=True)
def _spring(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    for (module, name), function in branches().items():
        monkeypatch.setattr(module, name, function)
    Path("damped.toml").write_text("[spring]\nstiffness = 3\ndamping = 2\n", encoding="utf-8")
    Path("loose.toml").write_text("[spring]\nstiffness = 0\ndamping = 2\n", encoding="utf-8")
    Path("wrong.toml").write_text("[spring]\nstiffness = -1\ndamping = 2\n", encoding="utf-8")


def test_it_takes_ten_files_at_most() -> None:
    changed = {module.__name__ for module, _ in branches()}
    changed -= {"nonsmooth.reports.derivations.derivation"}  # it names what stands in parts
    assert len(changed) == BRANCHES
    assert KIND + len(changed) + len(OWN) + OFFERED <= 10


def test_commands_check_report_and_refuse_it(invoke: Invoke) -> None:
    assert invoke("check", "damped.toml", "--json").record == {
        "schema": "toy-spring/1", "scene": "damped", "verdict": "asymptotically stable"
    }  # fmt: skip
    assert invoke("check", "loose.toml").status == 1
    refused = invoke("check", "wrong.toml")
    assert (refused.status, refused.out) == (2, "")
    assert "spring.stiffness: required an integer of at least 0, received -1" in refused.err
    report = invoke("derive", "damped.toml")
    assert report.status == 0
    assert "# Derivation report: damped" in report.out
    assert "The energy falls at the rate 2 times the square of v." in report.out
    for ending in (".html", ".tex", ".json"):
        assert invoke("derive", "damped.toml", "--only", "energy", "-o", f"r{ending}").status == 0
    assert "required" in invoke("derive", "damped.toml", "--only", "cells").err


def test_other_scenes_are_what_they_were(invoke: Invoke) -> None:
    assert invoke("check", "eq-4", "--json").record["schema"].startswith("nonsmooth-")
    assert isinstance(ns.load("four-wheel"), ns.Array)


def test_python_holds_the_same(invoke: Invoke) -> None:
    held: Any = ns.load("damped.toml")
    found = held.check()
    assert isinstance(found, SpringResult)
    assert held.kind is ToyKind.SPRING
    assert found.to_dict() == invoke("check", "damped.toml", "--json").record
    assert held.check(damping=0).verdict == "stable"
    assert held.derive(only="energy").sections == ("Energy",)
