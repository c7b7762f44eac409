"""The exact stage of a view says what ``nonsmooth check --json`` says, for every built-in scene."""

from __future__ import annotations

import json
from typing import Any

import pytest

from nonsmooth.proofs.clauses.workspace import unheard
from nonsmooth.reports.checks.check import check_scene
from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.interface.load import load
from nonsmooth.reports.workbench import array_view
from nonsmooth.reports.workbench.documents import document_of
from nonsmooth.reports.workbench.jobs import view
from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.thorough import few

SLOW = {"flower"}  # a verdict of seconds


def exact(document: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The first two stages."""
    request = {"document": document, "want": []}
    stages = {stage["stage"]: stage for stage in view(json.dumps(request).encode(), unheard)}
    return stages["fast"], stages["exact"]


def record(scene: Scene) -> dict[str, Any]:
    """What the command says, without a word of the other rules."""
    return check_scene(scene, ask_others=False).to_dict()


@few(4)
@pytest.mark.parametrize("name", builtin_scenes())
def test_an_array_is_judged_as_by_the_command(name: str) -> None:
    fast, found = exact(document_of(name))
    assert_equal(fast, found, record(load_scene(name)))


@few(1)
@pytest.mark.parametrize("rule", CONTACT_RULES)
def test_every_rule_is_judged_as_by_the_command(rule: str) -> None:
    document = document_of("four-wheel")
    document["wheel"][0]["position"] = [1.05, 0.9]
    document["contact"] = {"rule": rule}
    assert_equal(*exact(document), record(Array.of_document(document).scene))


def assert_equal(fast: dict[str, Any], found: dict[str, Any], expected: dict[str, Any]) -> None:
    theorem = expected["theorem4"]
    assert (found["verdict"], found["reason"]) == (theorem["verdict"], theorem["reason"])
    for answer in found["answers"]:
        said = expected["answers"][answer["key"]]
        assert (answer["answer"], answer["sentence"]) == (said["verdict"], said["reason"])
    for clause in found["clauses"]:
        said = expected[clause["key"]]
        assert (clause["verdict"], clause["reason"]) == (said["verdict"], said["reason"])
    for guess in fast["answers"] or ():
        assert guess["answer"] == expected["answers"][guess["key"]]["verdict"]


def test_cells_that_take_long_come_later(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_view, "FAST_UNITS", 100)
    request = {"document": document_of("ring-6"), "want": []}
    stages = list(view(json.dumps(request).encode(), unheard))
    assert [stage["stage"] for stage in stages] == ["fast", "fast", "exact"]
    assert [stage["geometry"] for stage in stages[:2]] == ["later", "exact"]
    assert len(stages[0]["wheels"]) == 6
    assert not stages[0]["cells"]


def test_cells_that_take_too_long_are_told_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_view, "FAST_UNITS", 100)
    monkeypatch.setattr(array_view, "CELL_SECONDS", 0.0)
    request = {"document": document_of("ring-6"), "want": ["comparison"]}
    later, none, told, others = view(json.dumps(request).encode(), unheard)
    assert (later["geometry"], none["geometry"]) == ("later", "none")
    assert none["wheels"] == later["wheels"]
    assert told["stage"] == "unanswered"
    assert "cells of rule nearest within 0 s" in told["message"]
    assert "\n" not in told["message"]
    assert all(rule["answers"] for rule in others["rules"])


@few(4)
@pytest.mark.parametrize("name", sorted(set(builtin_systems()) - SLOW))
def test_a_system_is_judged_as_by_the_command(name: str) -> None:
    _, found = exact(document_of(name))
    expected = load(name).check().to_dict()["translation"]
    assert (found["verdict"], found["reason"]) == (expected["verdict"], expected["reason"])
