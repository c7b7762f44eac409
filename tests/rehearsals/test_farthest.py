"""A new contact rule is one class and one line of the registry: every command takes it from there."""

from __future__ import annotations

import inspect
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import all_rules
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.proofs.findings import Theorem4
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from tests.rehearsals.farthest import FarthestRule
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

SCENES = ["four-wheel", "conveyor-3", "ring-6", "rectangle"]


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CONTACT_RULES, "farthest", "tests.rehearsals.farthest:FarthestRule")


def test_the_rule_is_one_short_class() -> None:
    assert len(inspect.getsource(FarthestRule).splitlines()) <= 60
    assert [rule.name for rule in all_rules()] == ["nearest", "box", "ellipse", "roller", "farthest"]


@few(2)
@pytest.mark.parametrize("name", SCENES)
def test_its_cells_tile_and_hold_the_literal_twists(name: str) -> None:
    scene = load_scene(name, rule="farthest").recentred()
    partition = build_partition(scene)
    assert partition.tiles
    points = float(scene.check.radius) * np.random.default_rng(3).uniform(-1, 1, (400, 2))
    literal = FarthestRule().literal_twists(scene, points)
    np.testing.assert_allclose(PointLocator(partition).twists(points), literal, rtol=1e-9, atol=1e-9)


@few(2)
@pytest.mark.parametrize("name", SCENES)
def test_its_verdicts_carry_evidence(name: str) -> None:
    result = check_theorem4(load_scene(name, rule="farthest"))
    assert result.check()
    other = Theorem4.FAILS if result.verdict is Theorem4.HOLDS else Theorem4.HOLDS
    assert not replace(result, verdict=other).check()


def test_the_commands_take_it(invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    checked = invoke("check", "four-wheel", "--rule", "farthest", "--json")
    assert checked.status == 1
    assert json.loads(checked.out)["rule"] == "farthest"
    many = json.loads(invoke("check", "four-wheel", "--rule", "all", "--json").out)
    assert [record["rule"] for record in many["checks"]] == ["nearest", "box", "ellipse", "roller", "farthest"]
    cells = json.loads(invoke("partition", "four-wheel", "--rule", "farthest", "--json").out)
    assert cells["rule"] == "farthest"
    assert cells["area_error"] == "0"
    path = invoke("simulate", "four-wheel", "--rule", "farthest", "--from", "0.2,0.1,0", "--until", "0.1", "--json")
    assert json.loads(path.out)["end"]["t"] == pytest.approx(0.1)
    compared = json.loads(invoke("partition", "four-wheel", "--compare", "--json").out)["agreement"]
    assert set(compared) == {
        "nearest_box", "nearest_farthest", "box_farthest", "ellipse_nearest", "ellipse_box", "ellipse_farthest",
        "roller_nearest", "roller_box", "roller_farthest"
    }  # fmt: skip


@thorough  # the small one: the numbers of the comparison, in test_the_commands_take_it
def test_a_picture_takes_it(invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert invoke("partition", "four-wheel", "--compare", "-o", "a.png").status == 0


SOME, MOST = "--only verdict,cells,rules", "--without precision"


@pytest.mark.parametrize(("parts", "file"), keep(1, [(SOME, "a.md"), (SOME, "a.html"), (MOST, "a.html")]))
def test_a_report_takes_it(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, parts: str, file: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert invoke("derive", "four-wheel", "--rule", "farthest", *parts.split(), "-o", file).status == 0
    assert "farthest" in (tmp_path / file).read_text(encoding="utf-8")


def test_the_checker_of_certificates_does_not_know_it(invoke: Invoke, tmp_path: Path) -> None:
    refused = invoke("check", "four-wheel", "--rule", "farthest", "--certificate", str(tmp_path / "a.json"))
    assert refused.status == 2
    assert 'required contact.rule "nearest" or "box", received "farthest"' in refused.err
