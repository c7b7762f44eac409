"""Documents of the workbench: scenes as JSON and TOML, exact edits, units, and what a check says of them."""

from __future__ import annotations

import copy
import json
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.proofs.clauses.workspace import unheard
from nonsmooth.reports.checks.check import check_array
from nonsmooth.reports.interface.array import Array, load
from nonsmooth.reports.workbench import array_view
from nonsmooth.reports.workbench.array_view import fast_stage
from nonsmooth.reports.workbench.documents import canonical, document_of, opened, read_toml, written
from nonsmooth.reports.workbench.exact_edits import edited
from nonsmooth.reports.workbench.jobs import view
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from tests.random_edits import Hand
from tests.thorough import few
from tests.workbench_server import Workbench

# ---- Documents: scenes as JSON, the way to TOML and back, and layouts written out ----------------

NUMBERS = st.one_of(
    st.integers(-(10**20), 10**20), st.floats(allow_nan=False, allow_infinity=False), st.decimals(-9, 9)
)


def through_a_browser(document: dict[str, Any]) -> dict[str, Any]:
    """What a page sends back: floats for all numbers, integers without a point."""
    return read_request(json.dumps(json.loads(json.dumps(document))).encode())


@pytest.mark.parametrize("name", [*builtin_scenes(), *builtin_systems()])
def test_built_in_scenes_come_back_byte_for_byte(name: str) -> None:
    document = document_of(name)
    text = written(document)
    assert written(read_toml(text)) == text
    assert written(through_a_browser(document)) == text


@pytest.mark.parametrize("name", builtin_scenes())
def test_layouts_are_written_out_exactly(name: str) -> None:
    array, given_scene = opened(document_of(name)), load_scene(name)
    assert isinstance(array, Array)
    for wheel, expected in zip(array.scene.wheels, given_scene.wheels, strict=True):
        for found, wanted in zip(
            (*wheel.position, *wheel.direction), (*expected.position, *expected.direction), strict=True
        ):
            assert str(found) == str(wanted)
        assert str(wheel.speed) == str(expected.speed)
    assert array.scene.check.lyapunov == given_scene.check.lyapunov
    assert str(array.scene.check.radius) == str(given_scene.check.radius)


@given(NUMBERS)
def test_no_digit_is_lost_on_the_way_through_a_page(number: int | float | Decimal) -> None:
    entry = canonical(number)
    again = canonical(through_a_browser({"x": entry})["x"])
    assert again == entry
    assert Decimal(str(entry)) == Decimal(repr(number) if isinstance(number, float) else number)
    text = written({"x": entry})
    assert written(read_toml(text)) == text


@given(st.text(max_size=30))
def test_any_text_comes_back(text: str) -> None:
    if not text.isprintable():
        return
    assert read_toml(written({"name": text})) == {"name": text}


def test_dates_and_other_documents_are_refused() -> None:
    for text in ("name = 1979-05-27", "a = ", "a = 1\na = 2", "x = nan"):
        with pytest.raises((RequestError, ValueError)):
            opened(read_toml(text))


def test_speeds_of_a_table_keep_their_unit(tmp_path: Any) -> None:
    """They are converted when they are read, so the document holds them in the unit that it states."""
    (tmp_path / "w.csv").write_text(
        "x,y,heading,speed,speed_limit\n1,1,inward,100,250\n-1,1,45 deg,150,\n-1,-1,0,1,2\n"
    )
    file = tmp_path / "scene.toml"
    units = "[units]\nlength = 'm'\nspeed = 'mm/s'\n"
    file.write_text(f"{units}[wheels]\nfile = 'w.csv'\n[friction]\nmu_roll = 1\nmu_side = 0.5\n")
    again, scene = opened(read_toml(written(document_of(str(file))))), load_scene(str(file))
    assert isinstance(again, Array)
    for mine, theirs in zip(again.scene.wheels, scene.wheels, strict=True):
        assert float(mine.speed) == float(theirs.speed)
        assert (mine.speed_limit is None) == (theirs.speed_limit is None)
        assert mine.speed_limit is None or float(mine.speed_limit or 0) == float(theirs.speed_limit or 1)
    assert float(again.scene.wheels[0].speed) == 0.1


# ---- Edits of wheels: exact in all numbers, and their own inverses where they should be ----------

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


# ---- A table of wheels in millimetres and degrees, written out as a scene file, says what the table says.

TABLE = """Name;X;Y;Heading;mu_side;contact
M1;-100.5;-80;34.1;0.62;ellipse
M2;100.5;-80;145.9 deg;0.62;roller
M3;0;120.25;[0, -1];0.31;
"""
SCENE = """
units = { length = "mm", speed = "m/s", angle = "deg" }
friction = { mu_roll = 0.62 }
contact = { rule = "ellipse" }
wheels = { file = "wheels.csv" }
"""


def test_a_table_written_out_keeps_names_millimetres_and_degrees(tmp_path: Path) -> None:
    (tmp_path / "wheels.csv").write_text(TABLE, encoding="utf-8")
    (tmp_path / "table.toml").write_text(SCENE, encoding="utf-8")
    document = document_of(tmp_path / "table.toml")
    text = written(document)
    assert "wheels" not in document
    assert written(read_toml(text)) == text
    for said in ('name = "M1"', "position = [-100.5, -80]", "heading = 34.1", 'heading = "145.9 deg"', "[0, -1]"):
        assert said in text
    (tmp_path / "out.toml").write_text(text, encoding="utf-8")
    before, after = (load_scene(tmp_path / name).wheels for name in ("table.toml", "out.toml"))
    for wheel, again in zip(before, after, strict=True):
        assert str(wheel.index) == str(again.index)
        for mine, its in ((wheel.position, again.position), (wheel.unit_direction, again.unit_direction)):
            assert [str(value) for value in mine] == [str(value) for value in its]
        assert (str(wheel.speed), str(wheel.friction.side)) == (str(again.speed), str(again.friction.side))
        assert wheel.friction.rule == again.friction.rule


@pytest.mark.parametrize(
    "operation", [{"kind": "expand"}, {"kind": "mirror", "axis": "x"}, {"kind": "rotate", "angle": "30 deg"}]
)
def test_edits_keep_speeds_in_their_unit(operation: dict[str, Any]) -> None:
    """Wheels that name no speed run at 1 m/s: written out, and shown, as 1 beside lengths in millimetres."""
    grid = "grid = { rows = 2, columns = 2, pitch = 100 }\nfriction = { mu_roll = 1, mu_side = 1 }"
    document = read_toml(f'name = "grid"\nunits = {{ length = "mm", speed = "m/s" }}\n{grid}')
    after = edited(document, operation).document
    assert {wheel["speed"] for wheel in after["wheel"]} == {1}
    for one in (document, after):
        array = Array.of_document(one)
        assert {float(wheel.speed) for wheel in array.scene.wheels} == {1000}
        wheels = fast_stage(array)["wheels"]
        assert [(wheel["speed"], wheel["exact"]["speed"]) for wheel in wheels] == [(1, "1")] * 4


# ---- The exact stage of a view says what ``nonsmooth check --json`` says, for every built-in scene.

SLOW = {"flower"}  # a verdict of seconds


def exact(document: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The first two stages."""
    request = {"document": document, "want": []}
    stages = {stage["stage"]: stage for stage in view(json.dumps(request).encode(), unheard)}
    return stages["fast"], stages["exact"]


def record(scene: Scene) -> dict[str, Any]:
    """What the command says, without a word of the other rules."""
    return check_array(scene, ask_others=False).to_dict()


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


# ---- Many random edits: every view comes to its end, no worker is left over, and nothing is written to the log.

EDITS = 80  # the benchmark makes 10,000


def test_random_edits_leave_nothing_behind(server: Workbench) -> None:
    hand = Hand(server, "four-wheel", seed=1)
    for _ in range(EDITS):
        hand.edit()
    assert hand.seen["exact"] > EDITS // 20
    assert hand.seen["error"] > EDITS // 200
    assert len(server.workers_left(3)) == 3
    assert "Traceback" not in server.log.read_text()
