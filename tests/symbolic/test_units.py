"""Units of a scene: labels, and speeds that a file states in another unit of length."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.proofs.certificate import scene_record
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import LengthUnit, SpeedUnit, Units
from nonsmooth.symbolic.messages.scene_error import SceneError

HEAD = "[friction]\nmu_roll = 1\nmu_side = 0.5\n"
WHEELS = (
    "[[wheel]]\nposition = [1, 1]\nspeed = 2\n[[wheel]]\nposition = [-1, 2]\n"
    '[[wheel]]\nposition = [0, -3]\nheading = "inward"\n'
)


def load(folder: Path, text: str) -> Scene:
    (folder / "my.toml").write_text(HEAD + text, encoding="utf-8")
    return load_scene(folder / "my.toml")


def test_a_scene_without_units_has_empty_labels(tmp_path: Path) -> None:
    units = load(tmp_path, WHEELS).units
    assert units == Units()
    assert {units.length, units.speed, units.time} == {""}


@pytest.mark.parametrize("length", ["m", "cm", "mm", "in"])
def test_labels(tmp_path: Path, length: str) -> None:
    scene = load(tmp_path, f'{WHEELS}[units]\nlength = "{length}"\n')
    units = scene.units
    assert (units.length, units.speed, units.time) == (length, f"{length}/s", "s")
    assert [wheel.speed for wheel in scene.wheels] == [2, 1, 1]


@pytest.mark.parametrize(
    ("length", "speed", "factor"),
    [
        ("mm", "m/s", Fraction(1000)),
        ("m", "mm/s", Fraction(1, 1000)),
        ("mm", "in/s", Fraction(127, 5)),
        ("in", "cm/s", Fraction(50, 127)),
        ("m", "in/s", Fraction(127, 5000)),
        ("cm", "cm/s", Fraction(1)),
    ],
)
@pytest.mark.parametrize(("field", "at_field"), [("", 1), ('speed = "unit"', 1), ('speed = "7/2"', Fraction(7, 2))])
def test_every_speed_is_converted(
    tmp_path: Path, length: str, speed: str, factor: Fraction, field: str, at_field: Fraction
) -> None:
    units = f'[units]\nlength = "{length}"\nspeed = "{speed}"\n'
    scene = load(tmp_path, f'{WHEELS}{units}[field]\nkind = "radial"\n{field}\n')
    assert [wheel.speed for wheel in scene.wheels] == [2 * factor, at_field * factor, factor]
    assert scene.units == Units(length, in_degrees=True)
    assert scene.continuum is not None
    assert scene.continuum.speed == at_field * factor


def test_a_magnitude_is_in_lengths_per_second(tmp_path: Path) -> None:
    units = '[units]\nlength = "mm"\nspeed = "m/s"\n'
    scene = load(tmp_path, f'{WHEELS}{units}[field]\nkind = "radial"\nspeed = "magnitude"\n')
    assert scene.wheels[1].speed ** 2 == 5


def test_the_speeds_of_a_table_are_converted(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("x,y,speed\n1,0,0.5\n0,1,\n", encoding="utf-8")
    scene = load(tmp_path, '[wheels]\nfile = "w.csv"\n[units]\nlength = "cm"\nspeed = "m/s"\n')
    assert [wheel.speed for wheel in scene.wheels] == [50, 100]


def test_units_follow_the_scene_and_are_no_part_of_equality_or_certificates(tmp_path: Path) -> None:
    scene = load(tmp_path, f'{WHEELS}[units]\nlength = "mm"\n[check]\nequilibrium = [0, 1]\n')
    plain = replace(scene, units=Units())
    assert scene == plain
    assert scene_record(scene) == scene_record(plain)
    assert scene.recentred().units == Units("mm", in_degrees=True)


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ('length = "ft"', "units.length: required 'm', 'cm', 'mm' or 'in', received 'ft'"),
        ('length = "m"\nspeed = "m"', "units.speed: required 'm/s', 'cm/s', 'mm/s' or 'in/s', received 'm'"),
        ('speed = "m/s"', "units.length: required a unit of length beside speed = m/s, received nothing"),
        ('angle = "grad"', "units.angle: required 'deg' or 'rad', received 'grad'"),
        ('time = "s"', "units.time: required one of the keys length, speed, angle, received an unknown key"),
    ],
)
def test_what_is_no_unit(tmp_path: Path, table: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, f"{WHEELS}[units]\n{table}\n")
    assert str(caught.value) == f"{tmp_path / 'my.toml'}: {line}"


def test_every_unit_of_length_has_its_unit_of_speed() -> None:
    assert [unit.length for unit in SpeedUnit] == list(LengthUnit)
    assert [str(unit) for unit in SpeedUnit] == [f"{unit}/s" for unit in LengthUnit]
