"""Every table and key of scene files stands in the tutorial's table of them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from nonsmooth.symbolic.files.layouts import Grid, Ring, WheelTable
from nonsmooth.symbolic.files.scene_document import (
    BodyTable,
    CheckTable,
    DriveTable,
    FeedbackTable,
    FrictionTable,
    SceneDocument,
    ToleranceTable,
    UnitsTable,
    WheelFile,
)
from nonsmooth.symbolic.files.scene_values import keys_of
from nonsmooth.symbolic.files.vehicle_file import VehicleTable
from nonsmooth.symbolic.files.wheel_csv import COLUMNS

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "tutorial.md").read_text(encoding="utf-8")
TABLES: dict[str, type[BaseModel]] = {
    "[units]": UnitsTable,
    "[friction]": FrictionTable,
    "[drive]": DriveTable,
    "[[wheel]]": WheelTable,
    "[ring]": Ring,
    "[grid]": Grid,
    "[wheels]": WheelFile,
    "[body]": BodyTable,
    "[tolerance]": ToleranceTable,
    "[feedback]": FeedbackTable,
    "[check]": CheckTable,
    "[vehicle]": VehicleTable,
}


def row(table: str) -> str:
    (found,) = re.findall(rf"^\| (?:or )?`{re.escape(table)}` \| (.*) \|$", PAGE, re.MULTILINE)
    return str(found)


@pytest.mark.parametrize("table", TABLES)
def test_every_key_of_a_table_is_named(table: str) -> None:
    words = set(re.findall(r"\w+", row(table)))
    assert set(TABLES[table].model_fields) <= words


def test_every_table_is_named() -> None:
    for name in keys_of(SceneDocument):
        assert f"`[{name}]`" in PAGE or f"`[[{name}]]`" in PAGE or f"`{name}`" in PAGE, name


def test_every_column_is_named() -> None:
    (text,) = re.findall(r"`x` and `y` are required; (.*?) are optional columns", PAGE)
    assert {"x", "y", *re.findall(r"`(\w+)`", text)} == set(COLUMNS)
