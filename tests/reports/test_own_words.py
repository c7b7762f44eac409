"""The user's own words: names of wheels, decimals and degrees wherever a table in millimetres is spoken of."""

from __future__ import annotations

import json
import math
import re
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.reports.designs.freedom import Freedom
from nonsmooth.reports.designs.toml_text import toml_text
from nonsmooth.reports.figures.wheels import wheel_labels
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.one_by_one import one_by_one
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.formulas.surfaces import constant
from nonsmooth.symbolic.mechanics.scene import WheelNumber
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_text import brief_text, numbers_text, short_text
from tests.reports.conftest import Invoke

TABLE = "wheel,x,y\nA1,100,100\nA2,-100,100\nB1,-100,-100\nB2,100,-100.4\n"
SCENE = """
name = "small table"
units = { length = "mm" }
friction = { mu_roll = 0.62, mu_side = 0.31 }
contact = { rule = "ellipse" }
field = { kind = "radial", speed = 100 }
wheels = { file = "wheels.csv" }
"""


def write(folder: Path, table: str = TABLE, scene: str = SCENE) -> Path:
    (folder / "wheels.csv").write_text(table, encoding="utf-8")
    (folder / "table.toml").write_text(scene, encoding="utf-8")
    return folder / "table.toml"


def test_a_number_with_a_name_is_written_by_its_name_and_counts_as_a_number() -> None:
    named = WheelNumber(3, "A1")
    assert (f"wheel {named}", f"u_{named:d}", json.dumps([named])) == ("wheel A1", "u_3", "[3]")
    assert named == 3
    assert {3: "x"}[named] == "x"
    assert (str(WheelNumber(3)), numbers_text((1, 2, 3))) == ("3", "1-3")
    assert numbers_text((WheelNumber(1, "A"), WheelNumber(2, "B"), WheelNumber(3, "C"))) == "A, B, C"


def test_wheels_have_the_names_of_their_table(tmp_path: Path) -> None:
    scene = load_scene(write(tmp_path))
    assert [str(wheel.index) for wheel in scene.wheels] == ["A1", "A2", "B1", "B2"]
    assert not scene.field.remarks  # the column is read


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ("name,x,y\nM1,1,1\nM2,-1,1\nM1,0,-1\n", "4.name: required each name once (it is that of wheels.csv:2)"),
        ("name,x,y\nM1,1,1\na|b,-1,1\n", "3.name: required a name of at most 30 letters"),
    ],
)
def test_equal_names_and_no_names_are_refused_in_one_line(tmp_path: Path, table: str, line: str) -> None:
    with pytest.raises(SceneError, match=re.escape(line)):
        load_scene(write(tmp_path, table))


def test_a_scene_with_units_writes_decimals_and_one_without_exact_forms(tmp_path: Path) -> None:
    field = load_scene(write(tmp_path)).field
    numbers = (field.rational(Fraction(31, 50)), field.rational(Fraction(1, 3)), field.sqrt(2))
    assert [short_text(number) for number in numbers] == ["0.62", "0.333333", "1.41421"]
    assert [brief_text(number) for number in numbers] == ["0.62", "0.333333", "1.41421"]
    plain = load_scene("four-wheel").field
    assert [short_text(plain.rational(Fraction(1, 3))), short_text(plain.sqrt(2))] == ["1/3", "sqrt(2)"]


def test_a_picture_writes_numbers_where_names_do_not_fit(tmp_path: Path) -> None:
    wheels = load_scene(write(tmp_path, TABLE.replace("A1", "front left of the belt"))).wheels
    assert [wheel_labels(wheels, gap)[1] for gap in (400, 40, 1)] == [[str(w.index) for w in wheels], list("1234"), []]


def test_a_chosen_radius_has_two_digits(tmp_path: Path) -> None:
    assert load_scene(write(tmp_path)).check.radius == 40  # of 200.4 mm/5 = 40.08 mm, not above it


@pytest.mark.parametrize(
    ("changed", "hint"),
    [
        ('length = "m"', '[units]: the wheels lie within 200.4 m: is length = "mm" meant?'),
        (
            'length = "mm", speed = "m/s"',
            "[units]: the fastest wheel runs at 1e+05 mm/s",
        ),
    ],
)
def test_sizes_a_thousand_times_off_are_told(tmp_path: Path, changed: str, hint: str) -> None:
    scene = load_scene(write(tmp_path, scene=SCENE.replace('length = "mm"', changed)))
    assert any(hint in remark for remark in scene.field.remarks)


@pytest.mark.parametrize("heading", [45, 1.5])
def test_radians_beyond_a_full_turn_are_told(tmp_path: Path, heading: float) -> None:
    table = TABLE.replace("x,y", "x,y,heading").replace("100\n", f"100,{heading}\n").replace(".4\n", f".4,{heading}\n")
    scene = load_scene(write(tmp_path, table, SCENE.replace('length = "mm"', 'length = "mm", angle = "rad"')))
    hints = [remark for remark in scene.field.remarks if "more than a full turn" in remark]
    assert hints == (['[units]: an angle is 45 rad, more than a full turn: is angle = "deg" meant?'] * (heading > 7))


def test_a_body_of_another_unit_than_its_wheels_is_told(tmp_path: Path) -> None:
    body = '[body]\nshape = "rectangle"\nwidth = 0.3\nheight = 0.3\n'
    assert any("[body]" in remark for remark in load_scene(write(tmp_path, scene=SCENE + body)).field.remarks)


@pytest.mark.parametrize(
    ("check", "hint"),
    [
        ("equilibrium = [10000, 5000]", "[check]: equilibrium is 9900 mm away from wheel A1, and the wheels"),
        ("radius = 40000", "[check]: radius is 40000 mm, and the wheels lie within 200.4 mm: are both in mm?"),
        ("radius = 0.04", "[check]: radius is 0.04 mm, and the wheels lie within 200.4 mm: are both in mm?"),
        ("equilibrium = [10, 5]\nradius = 1", None),
    ],
)
def test_a_checked_square_of_another_unit_than_the_wheels_is_told(
    tmp_path: Path, invoke: Invoke, check: str, hint: str | None
) -> None:
    """Above a refusal too; a small square that is meant is no cause for a hint."""
    file = write(tmp_path, scene=f"{SCENE}[check]\n{check}\n")
    said = [remark for remark in load_scene(file).field.remarks if "[check]" in remark]
    assert [hint is not None and remark.startswith(hint) for remark in said] == [True] * bool(hint)
    assert ("note: [check]" in invoke("partition", str(file)).out) == bool(hint)


def test_writing_a_number_decides_nothing(tmp_path: Path) -> None:
    """Numbers of measured angles count decisions that rounding made: one more, and verdicts would be `undecided`."""
    angles = (206, -26.3, 26.1, 154.7)
    rows = [f"{x},{y},{angle}" for (x, y), angle in zip(((2, 1), (-2, 1), (-2, -1), (2, -1)), angles, strict=True)]
    scene = load_scene(write(tmp_path, "\n".join(["x,y,heading", *rows])))
    direction = scene.wheels[1].unit_direction[0]
    before = scene.field.rounded_signs
    assert (brief_text(direction), short_text(-direction)) == ("0.896486", "-0.896486")
    assert constant(direction).latex(longest=30) == "0.896486"
    assert scene.field.rounded_signs == before


def test_a_table_that_is_written_wheel_by_wheel_keeps_its_names(tmp_path: Path) -> None:
    """As ``design`` writes it; equal places and directions, too."""
    scene = load_scene(file := write(tmp_path))
    other = tmp_path / "other.toml"
    other.write_text(toml_text(one_by_one(read_document(str(file))[0], scene)), encoding="utf-8")
    again = load_scene(other)
    assert [str(wheel.index) for wheel in again.wheels] == ["A1", "A2", "B1", "B2"]
    assert [str(wheel.position) for wheel in again.wheels] == [str(wheel.position) for wheel in scene.wheels]


def test_a_design_is_written_in_degrees_and_decimals_where_units_are_stated(tmp_path: Path) -> None:
    scene = load_scene(file := write(tmp_path))
    freedom = Freedom(("headings",))
    document = freedom.document(read_document(str(file))[0], scene, [0.5, 0.6, 0.4, 0.3])
    first, second, *_ = document["wheel"]
    assert first["position"] == [100, 100]
    assert document["wheel"][3]["position"] == [100, Decimal("-100.4")]
    assert [wheel["name"] for wheel in document["wheel"]] == ["A1", "A2", "B1", "B2"]
    assert first["heading"] == -135  # inward, as it was
    other = tmp_path / "other.toml"
    other.write_text(toml_text(document), encoding="utf-8")
    a, b = (float(part) for part in load_scene(other).wheels[1].unit_direction)
    assert math.degrees(math.atan2(b, a)) == pytest.approx(float(second["heading"]), abs=1e-9)
