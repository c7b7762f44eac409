"""Tables of wheels as spreadsheets write them: separators, headers, comments, and columns that are not read."""

from __future__ import annotations

import codecs
from fractions import Fraction
from itertools import permutations
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.wheel_csv import parse_wheels
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.numbers.number_field import FirstRemark

SCENE = '[friction]\nmu_roll = 1\nmu_side = 0.5\n[wheels]\nfile = "w.csv"\n'
UNTOLD = "w.csv states no heading: all wheels drive toward (0, 0); a column heading, or [field], says otherwise"
CELLS = [
    {"x": "0.5", "y": "1", "heading": "pi/2", "speed": "2", "mu_roll": "3", "mu_side": "4"},
    {"x": "-1", "y": "1e-1", "heading": "[3, 4]", "speed": "", "mu_roll": "", "mu_side": ""},
]


def load(folder: Path, table: str | bytes) -> Scene:
    (folder / "my.toml").write_text(SCENE, encoding="utf-8")
    (folder / "w.csv").write_bytes(table.encode() if isinstance(table, str) else table)
    return load_scene(folder / "my.toml")


def table_of(columns: tuple[str, ...], separator: str = ",") -> str:
    quoted = [[f'"{row[c]}"' if separator in row[c] else row[c] for c in columns] for row in CELLS]
    return "\n".join(separator.join(line) for line in [list(columns), *quoted]) + "\n"


def check_wheels(scene: Scene) -> None:
    first, second = scene.wheels
    assert list(first.position) == [Fraction(1, 2), 1]
    assert list(first.direction) == [0, 1]
    assert [first.speed, first.friction.roll, first.friction.side] == [2, 3, 4]
    assert list(second.position) == [-1, Fraction(1, 10)]
    assert list(second.direction) == [3, 4]
    assert [second.speed, second.friction.roll, second.friction.side] == [1, 1, Fraction(1, 2)]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("columns", list(permutations(CELLS[0]))[::97])
def test_any_order_of_columns_and_any_separator(tmp_path: Path, columns: tuple[str, ...], separator: str) -> None:
    scene = load(tmp_path, table_of(columns, separator))
    check_wheels(scene)
    assert angle_notes(scene.field) == ()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_marks_ends_of_lines_and_upper_case(tmp_path: Path, end: str) -> None:
    text = table_of(tuple(CELLS[0])).replace("x,y,heading,speed", ' X ,Y,"Heading",SPEED').replace("\n", end)
    check_wheels(load(tmp_path, codecs.BOM_UTF8 + text.encode()))


def test_comments_and_blank_lines_keep_the_numbers_of_lines(tmp_path: Path) -> None:
    head, *rows = table_of(tuple(CELLS[0])).splitlines()
    lines = ['# from "CAD, 5" wheels', "", head, "  # the front", rows[0], "", "#;,", rows[1]]
    check_wheels(load(tmp_path, "\n".join(lines)))
    with pytest.raises(SceneError, match=r"w\.csv:9\.x: required .*, received 'one'$"):
        load(tmp_path, "\n".join([*lines, "one,1,,,,"]))


def test_other_columns_are_not_read_and_a_note_says_so(tmp_path: Path) -> None:
    text = "z;x;Colour;y\n1;0.5;=cmd|' /C calc'!A0;1\n2;-1;;1e-1\n"
    scene = load(tmp_path, text)
    assert [list(wheel.position) for wheel in scene.wheels] == [[Fraction(1, 2), 1], [-1, Fraction(1, 10)]]
    assert angle_notes(scene.field) == (UNTOLD, "columns of the table of wheels that are not read: z, Colour")


@pytest.mark.parametrize("column", ["angle", "Direction", "theta", "orientation", "angle_deg", "Winkel [deg]"])
def test_a_column_that_looks_like_a_heading_is_refused(tmp_path: Path, column: str) -> None:
    with pytest.raises(SceneError, match=r"\(is heading meant\?\)"):
        load(tmp_path, f"x,y,{column}\n1,1,225\n-1,1,-45\n")
    assert angle_notes(load(tmp_path, f"x,y,heading,{column}\n1,1,pi,225\n-1,1,0,-45\n").field) == (
        f"columns of the table of wheels that are not read: {column}",
    )


def test_no_heading_at_all_is_said_above_all_results(tmp_path: Path) -> None:
    (note,) = load(tmp_path, "x,y\n1,1\n-1,1\n").field.remarks
    assert (note, type(note)) == (UNTOLD, FirstRemark)
    assert load(tmp_path, "x,y,heading\n1,1,pi\n-1,1,\n").field.remarks == ()
    (tmp_path / "w.csv").write_text("x,y\n1,1\n-1,1\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(f'{SCENE}[field]\nkind = "radial"\n', encoding="utf-8")
    assert load_scene(tmp_path / "my.toml").field.remarks == ()


def test_the_note_is_short_and_shows_names_only(tmp_path: Path) -> None:
    names = ["x", "y", "a", "b" * 31, "wheel no. 1", "\x1b[1m", "d", "", ""]
    rows = [["1", "2", *["?"] * 7], ["2", "2", *[""] * 7]]
    scene = load(tmp_path, "\n".join(",".join(row) for row in [names, *rows]))
    expected = "columns of the table of wheels that are not read: a, (no name), wheel no. 1, (no name), 1 more"
    assert angle_notes(scene.field) == (UNTOLD, expected)


def test_a_cell_of_another_column_may_hold_anything() -> None:
    rows = parse_wheels('x,y,remark\n1,2,"two\nlines, and ""quotes"""\n3,4,\n', "w.csv", "my.toml").rows
    assert [[row.x, row.y] for row in rows] == [[Fraction(1), Fraction(2)], [Fraction(3), Fraction(4)]]


@pytest.mark.parametrize("name", ["type", "supplier", "z", "diameter", "index", "colour", "note", "anglet"])
def test_columns_that_are_not_taken_for_misspelt_ones(name: str) -> None:
    assert parse_wheels(f"x,y,{name}\n1,2,\n", "w.csv", "my.toml").ignored == (name,)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("headings", "heading"),
        ("heading_deg", "heading"),
        ("speeds", "speed"),
        ("mu_rol", "mu_roll"),
        ("MuSide", "mu_side"),
    ],
)
def test_misspelt_columns(name: str, meant: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_wheels(f"x,y,{name}\n1,2,\n", "w.csv", "my.toml")
    known = "x,y,heading,speed,mu_roll,mu_side,speed_limit,axis,contact"
    assert (
        str(caught.value)
        == f"my.toml: w.csv:1: required a header out of {known} (is {meant} meant?), received '{name}'"
    )


def test_more_columns_than_a_table_of_wheels_has() -> None:
    with pytest.raises(SceneError, match=r"^my\.toml: w\.csv:1: required at most 200 columns, received 1000002$"):
        parse_wheels(f"x,y{',a' * 1_000_000}\n", "w.csv", "my.toml")


def test_beside_the_column_itself_a_similar_name_is_no_mistake() -> None:
    assert parse_wheels("x,y,heading,heading_old\n1,2,0,7\n", "w.csv", "my.toml").ignored == ("heading_old",)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x;y\n0,5;1\n", "w.csv:2.x: required a decimal point instead of a comma, received '0,5'"),
        ("x\ty\n1\t,5\n", "w.csv:2.y: required a decimal point instead of a comma, received ',5'"),
        ('x,y\n"1,234",0\n', "w.csv:2.x: required a decimal point instead of a comma, received '1,234'"),
        ("x,y\n0,5,1\n", "w.csv:2: required 2 cells (decimals with a point, not a comma), received 3"),
        ("x;y\n0;5;1\n", "w.csv:2: required 2 cells, received 3"),
        ("x,y\n1\n", "w.csv:2: required 2 cells, received 1"),
    ],
)
def test_decimal_commas_are_refused(text: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_wheels(text, "w.csv", "my.toml")
    assert str(caught.value) == f"my.toml: {line}"
