"""Edits of wheels: exact in all numbers, and their own inverses where they should be."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.documents import document_of, opened, written
from nonsmooth.reports.workbench.exact_edits import edited
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.mechanics.scene import Wheel

SCENES = ("four-wheel", "ring-5", "spiral-30", "off-center", "omni-3", "elliptic")


def after(document: dict[str, Any], **operation: Any) -> dict[str, Any]:
    return edited(document, operation).document


def wheels(document: dict[str, Any]) -> tuple[Wheel, ...]:
    array = opened(document)
    assert isinstance(array, Array)
    return array.scene.wheels


def same(first: dict[str, Any], second: dict[str, Any]) -> bool:
    """Whether two documents are the same wheels, rim directions up to a positive factor."""
    return [_said(wheel) for wheel in wheels(first)] == [_said(wheel) for wheel in wheels(second)]


def _said(wheel: Wheel) -> tuple[float, ...]:
    exact = (*wheel.position, *wheel.unit_direction, wheel.speed, wheel.friction.roll, wheel.friction.side)
    return tuple(round(float(value), 12) for value in exact)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_mirror_twice_is_nothing(name: str, axis: str) -> None:
    document = document_of(name)
    once = after(document, kind="mirror", axis=axis)
    assert same(after(once, kind="mirror", axis=axis), after(document, kind="expand"))


@pytest.mark.parametrize("name", SCENES)
def test_a_full_turn_in_steps_is_nothing(name: str) -> None:
    document = document_of(name)
    turned = document
    for _ in range(4):
        turned = after(turned, kind="rotate", angle="90 deg")
    assert same(turned, after(document, kind="expand"))


def test_a_rotation_is_exact() -> None:
    document = after(document_of("four-wheel"), kind="rotate", angle="15 deg", wheels=[1])
    assert document["wheel"][0]["heading"] == "inward"
    x, y = wheels(document)[0].position
    assert 2 * x * x == 1  # sqrt(2) at 45 + 15 degrees
    assert 2 * y * y == 3
    assert x > 0
    assert y > 0


def test_a_rotation_is_about_the_checked_point() -> None:
    document = document_of("four-wheel")
    document["check"]["equilibrium"] = ["1/4", "1/8"]
    turned = after(document, kind="rotate", angle="pi/2", wheels=[1])
    first = wheels(turned)[0]
    assert [str(value) for value in first.position] == ["-5/8", "7/8"]
    assert [str(value) for value in first.direction] == ["1", "-1"]


def test_what_is_not_chosen_stays_to_the_letter() -> None:
    document = document_of("ring-5")
    for operation in (
        {"kind": "mirror", "axis": "y"},
        {"kind": "rotate", "angle": "10 deg"},
        {"kind": "snap", "step": 1},
    ):
        found = edited(document, {**operation, "wheels": [2]})
        assert found.wheels == [2]
        assert [found.document["wheel"][k] for k in (0, 2, 3, 4)] == [document["wheel"][k] for k in (0, 2, 3, 4)]


def test_copies_are_the_last_wheels() -> None:
    found = edited(document_of("four-wheel"), {"kind": "copy", "wheels": [1, 3], "offset": ["1/2", 0.1]})
    assert found.wheels == [5, 6]
    assert found.document["wheel"][4]["position"] == ["3/2", "11/10"]
    mirrored = edited(document_of("off-center"), {"kind": "mirror", "axis": "x", "copy": True, "wheels": [1]})
    assert len(mirrored.document["wheel"]) == mirrored.wheels[0]


def test_a_wheel_comes_and_goes() -> None:
    document = document_of("four-wheel")
    found = edited(document, {"kind": "add", "position": [0.35, "1/3"]})
    assert found.wheels == [5]
    assert found.document["wheel"][4] == {"position": [0.35, "1/3"], "heading": "inward", "speed": 1}
    assert written(after(found.document, kind="delete", wheels=[5])) == written(document)


def test_loads_follow_their_wheels() -> None:
    document = document_of("four-wheel")
    rows = [["1/4", "1/4", "1/4"], ["1/4", "-1/4", "1/4"], ["1/4", "-1/4", "-1/4"], ["1/4", "1/4", "-1/4"]]
    document["contact"] = {"rule": "ellipse", "loads": rows}
    more = after(document, kind="add", position=[0, "1/2"])
    assert more["contact"]["loads"] == [*rows, [0, 0, 0]]
    assert after(more, kind="delete", wheels=[5])["contact"]["loads"] == rows


def test_expanded_wheels_need_no_field() -> None:
    document = after(document_of("elliptic"), kind="expand")
    assert "field" not in document
    assert same(document, document_of("elliptic"))


def test_snapping_is_to_the_nearest_multiple() -> None:
    document = document_of("four-wheel")
    document["wheel"][0]["position"] = [0.87, 1.12]
    assert after(document, kind="snap", step="1/4")["wheel"][0]["position"] == ["3/4", 1]


@pytest.mark.parametrize(
    "operation",
    [
        {},
        {"kind": "explode"},
        {"kind": "mirror"},
        {"kind": "mirror", "axis": "z"},
        {"kind": "mirror", "axis": "x", "wheels": [5]},
        {"kind": "mirror", "axis": "x", "wheels": [True]},
        {"kind": "mirror", "axis": "x", "wheels": "1"},
        {"kind": "rotate", "angle": "1 rad"},
        {"kind": "rotate", "angle": "9**9**9"},
        {"kind": "rotate", "angle": None},
        {"kind": "copy", "offset": [1]},
        {"kind": "copy", "offset": [0, 0]},
        {"kind": "copy", "offset": ["x", 0]},
        {"kind": "snap", "step": 0},
        {"kind": "snap", "step": "-1/4"},
        {"kind": "snap", "step": "sqrt(2)"},
        {"kind": "snap"},
        {"kind": "add"},
        {"kind": "add", "position": [1, 1]},
        {"kind": "add", "position": ["1/0", 1]},
        {"kind": "delete"},
        {"kind": "delete", "wheels": [1, 2, 3]},
    ],
)
def test_what_cannot_be_done_is_refused(operation: dict[str, Any]) -> None:
    document = document_of("four-wheel")
    before = copy.deepcopy(document)
    with pytest.raises((RequestError, ValueError)):
        edited(document, operation)
    assert document == before
