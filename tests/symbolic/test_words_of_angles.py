"""Angles are read with their unit as people write it, in scene files, tables and starts."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.start_values import read_start_angle
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.mechanics.units import AngleUnit

WORDS = ["-45deg", "-45 deg", "-45 degrees", "-45degree", "-45\N{DEGREE SIGN}", "-45 \N{DEGREE SIGN}", "-pi/4 rad"]
HEAD = "[friction]\nmu_roll = 1\nmu_side = 0.5\n"
PLACES = ((1, 1), (-1, 1), (-1, -1), (1, -1))


@pytest.mark.parametrize("word", [*WORDS, "-pi/4 radians"])
def test_a_start(word: str) -> None:
    assert read_start_angle(word) == pytest.approx(-math.pi / 4, rel=1e-15)


@pytest.mark.parametrize("text", ["5", " 5 ", "10/2"])
def test_a_bare_number_is_in_the_unit_of_the_scene(text: str) -> None:
    assert read_start_angle(text, AngleUnit.DEGREE) == read_start_angle("5deg")
    assert read_start_angle(text, AngleUnit.RADIAN) == 5.0


@pytest.mark.parametrize("unit", [*AngleUnit, None])
@pytest.mark.parametrize(
    ("text", "expected"), [("pi/36", math.pi / 36), ("5deg", math.pi / 36), ("0", 0.0), ("1 rad", 1)]
)
def test_an_angle_that_names_its_unit_keeps_it(text: str, expected: float, unit: AngleUnit | None) -> None:
    assert read_start_angle(text, unit) == pytest.approx(expected, rel=1e-15)


def test_a_bare_number_where_no_unit_is_known_is_refused_with_both_spellings() -> None:
    with pytest.raises(ExpressionError, match="required a unit, as 5deg or 5rad "):
        read_start_angle("5", None)


@pytest.mark.parametrize("word", WORDS)
def test_a_heading_of_a_scene(word: str, tmp_path: Path) -> None:
    wheels = "".join(f'[[wheel]]\nposition = [{x}, {y}]\nheading = "{word}"\nspeed = 1\n' for x, y in PLACES)
    (tmp_path / "scene.toml").write_text(HEAD + wheels, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    for wheel in scene.wheels:
        assert tuple(map(float, wheel.unit_direction)) == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5)), abs=1e-15)


@pytest.mark.parametrize("word", WORDS)
def test_a_heading_of_a_table(word: str, tmp_path: Path) -> None:
    rows = "".join(f"{x},{y},{word},1\n" for x, y in PLACES)
    (tmp_path / "wheels.csv").write_text(f"x,y,heading,speed\n{rows}", encoding="utf-8")
    (tmp_path / "scene.toml").write_text(f'{HEAD}[wheels]\nfile = "wheels.csv"\n', encoding="utf-8")
    wheel = load_scene(tmp_path / "scene.toml").wheels[0]
    assert tuple(map(float, wheel.unit_direction)) == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5)), abs=1e-15)
