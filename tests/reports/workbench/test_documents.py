"""Documents: scenes as JSON, the way to TOML and back, and layouts written out."""

from __future__ import annotations

import json
from decimal import Decimal
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.documents import canonical, document_of, opened, read_toml, written
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene

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


def test_a_table_of_wheels_is_written_out(tmp_path: Any) -> None:
    (tmp_path / "w.csv").write_text("x,y,heading\n1,1,inward\n-1,1,45 deg\n-1,-1,inward\n1,-1,pi/6\n")
    file = tmp_path / "s.toml"
    file.write_text("[wheels]\nfile = 'w.csv'\n[friction]\nmu_roll = 1\nmu_side = 0.5\n")
    document = document_of(str(file))
    assert "wheels" not in document
    array = opened(document)
    assert isinstance(array, Array)
    assert [str(w.direction) for w in array.scene.wheels] == [str(w.direction) for w in load_scene(str(file)).wheels]
