"""Angles are read with their unit as people write it, in scene files, tables and starts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.start_values import read_start_angle

if TYPE_CHECKING:
    from pathlib import Path

WORDS = ["-45deg", "-45 deg", "-45 degrees", "-45degree", "-45\N{DEGREE SIGN}", "-45 \N{DEGREE SIGN}", "-pi/4 rad"]
HEAD = "[friction]\nmu_roll = 1\nmu_side = 0.5\n"
PLACES = ((1, 1), (-1, 1), (-1, -1), (1, -1))


@pytest.mark.parametrize("word", [*WORDS, "-pi/4 radians"])
def test_a_start(word: str) -> None:
    assert read_start_angle(word) == pytest.approx(-math.pi / 4, rel=1e-15)


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
