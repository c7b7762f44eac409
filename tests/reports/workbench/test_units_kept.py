"""A table of wheels in millimetres and degrees, written out as a scene file, says what the table says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.array_view import fast_stage
from nonsmooth.reports.workbench.documents import document_of, read_toml, written
from nonsmooth.reports.workbench.exact_edits import edited
from nonsmooth.symbolic.files.scene_file import load_scene

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
    text = written(document_of(tmp_path / "table.toml"))
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
