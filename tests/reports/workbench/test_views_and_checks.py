"""The exact stage of a view says what ``nonsmooth check --json`` says, for every built-in scene."""

from __future__ import annotations

import json
from typing import Any

import pytest

from nonsmooth.proofs.clauses.workspace import unheard
from nonsmooth.reports.interface.load import load
from nonsmooth.reports.workbench import array_view
from nonsmooth.reports.workbench.documents import document_of
from nonsmooth.reports.workbench.jobs import view
from nonsmooth.symbolic.files.scene_file import builtin_scenes, builtin_systems
from nonsmooth.symbolic.rule import CONTACT_RULES

SLOW = {"flower"}  # a verdict of seconds


def exact(document: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The first two stages."""
    request = {"document": document, "want": []}
    stages = {stage["stage"]: stage for stage in view(json.dumps(request).encode(), unheard)}
    return stages["fast"], stages["exact"]


def record(document: dict[str, Any]) -> dict[str, Any]:
    """What the command says; its own other rules, counts and paths are left out."""
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.check_result import check_scene

    return check_scene(Array.of_document(document).scene, ask_others=False).to_dict()


@pytest.mark.parametrize("name", builtin_scenes())
def test_an_array_is_judged_as_by_the_command(name: str) -> None:
    fast, found = exact(document_of(name))
    expected = load(name).check().to_dict()
    assert_equal(fast, found, expected)


@pytest.mark.parametrize("rule", CONTACT_RULES)
@pytest.mark.parametrize("place", [[1, 1], [1.05, 0.9], [0.8, 1.3]])
def test_every_rule_is_judged_as_by_the_command(rule: str, place: list[float]) -> None:
    document = document_of("four-wheel")
    document["wheel"][0]["position"] = place
    document["contact"] = {"rule": rule}
    assert_equal(*exact(document), record(document))


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


@pytest.mark.parametrize("name", sorted(set(builtin_systems()) - SLOW))
def test_a_system_is_judged_as_by_the_command(name: str) -> None:
    _, found = exact(document_of(name))
    expected = load(name).check().to_dict()["translation"]
    assert (found["verdict"], found["reason"]) == (expected["verdict"], expected["reason"])
