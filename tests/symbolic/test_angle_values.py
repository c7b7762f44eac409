"""Angles of scene files: numbers in degrees and radians, with their unit or in that of [units], and multiples of pi."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from mpmath import mp

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.scene_values import AngleReading, read_angle
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.numbers.measured_angles import ROUNDING, angle_notes, choose_angles, degree_of, turn_of_radians
from nonsmooth.symbolic.numbers.number_field import NumberField

DIGITS = 60
DEGREE, RADIAN = AngleUnit.DEGREE, AngleUnit.RADIAN
WITHOUT_UNIT = "angles without a unit are read in degrees, as long as [units] states none"
ROUNDED = "angles in radians within 1e-12 of a multiple of pi are taken as that multiple"
CLOSENESS = 1e-12  # radians; what the file format promises


@pytest.mark.parametrize(
    ("value", "unit", "turn"),
    [
        (225, None, "5/4"),
        ("225", None, "5/4"),
        ("045", None, "1/4"),
        ("-22.5", None, "-1/8"),
        ("1/3", None, "1/540"),
        (225, DEGREE, "5/4"),
        ("45 deg", None, "1/4"),
        ("45deg", RADIAN, "1/4"),
        (" 1e2 deg ", RADIAN, "5/9"),
        (0, None, "0"),
        (0, RADIAN, "0"),
        ("0 rad", None, "0"),
        ("pi/6", None, "1/6"),
        ("pi/6", DEGREE, "1/6"),
        ("pi/6", RADIAN, "1/6"),
        ("pi/6 rad", DEGREE, "1/6"),
        ("pi/361", None, "1/361"),
    ],
)
def test_angles_that_are_exact_multiples_of_pi(value: object, unit: AngleUnit | None, turn: str) -> None:
    assert read_angle(value, unit).turn == Fraction(turn)


@pytest.mark.parametrize(
    ("value", "unit", "radians"),
    [
        ("3.927 rad", None, "3.927"),
        ("3.927 rad", DEGREE, "3.927"),
        ("3.927", RADIAN, "3.927"),
        (-1, RADIAN, "-1"),
        ("22/7 rad", None, "22/7"),
        ("1e30 rad", None, "1e30"),
        ("1e-9 rad", None, "1e-9"),
    ],
)
def test_radians(value: object, unit: AngleUnit | None, radians: str) -> None:
    angle = read_angle(value, unit)
    assert angle.reading is AngleReading.AS_WRITTEN
    with mp.workdps(DIGITS):
        exact = Fraction(radians)
        error = mp.pi * angle.turn.numerator / angle.turn.denominator - mpmath.mpf(exact.numerator) / exact.denominator
        assert abs(error) < mpmath.mpf(10) ** -30


def test_a_multiple_of_pi_may_have_radians_beside_it() -> None:
    with mp.workdps(DIGITS):
        turn = read_angle("pi/2 + 0.1 rad").turn
        assert abs(mp.pi * turn.numerator / turn.denominator - mp.pi / 2 - mp.mpf("0.1")) < mp.mpf(10) ** -30


@pytest.mark.parametrize(
    ("text", "turn"), [("2.356194490192345 rad", "3/4"), ("0.523598775598 rad", "1/6"), ("1e-30 rad", "0")]
)
def test_radians_that_are_rounded_multiples_of_pi_are_taken_as_these(text: str, turn: str) -> None:
    angle = read_angle(text)
    assert (angle.turn, angle.reading) == (Fraction(turn), AngleReading.ROUNDED)
    value = Fraction(text.removesuffix(" rad"))
    assert abs(value - Fraction(turn) * Fraction(math.pi)) < ROUNDING  # a float of pi is near enough here


def test_fewer_digits_are_no_multiple_of_pi() -> None:
    assert turn_of_radians(Fraction("2.35619"))[1] is False


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("pi deg", "required degrees without pi, received 'pi deg'"),
        ("pi + 1", "required a rational multiple of pi such as \"pi/3\", received 'pi + 1'"),
        ("deg", "required a formula of numbers, + - * / **, sqrt, sin, cos, pi, received 'deg'"),
        ("sqrt(2) rad", "required a rational multiple of pi such as \"2*pi/3\", received 'sqrt(2)'"),
        ("inf deg", "required a finite number, received 'inf'"),
        (True, "required a number or a formula in quotes, received true"),
    ],
)
def test_what_is_no_angle(value: object, words: str) -> None:
    with pytest.raises(ExpressionError, match=f"^{re.escape(words)}$"):
        read_angle(value)


def test_large_orders_are_known_to_have_a_large_degree() -> None:
    """The bound that spares the count of units for long fractions."""
    assert min(degree_of(order) for order in range(91, 3_000)) > 12
    assert choose_angles([Fraction(1, 10**40), Fraction(1, 4)]).measured == (Fraction(1, 10**40),)


# ---- in scenes -------------------------------------------------------------------------------------------


def scene_with(folder: Path, heading: str, units: str = "", field: str = "") -> Scene:
    path = folder / "my.toml"
    wheels = f"[[wheel]]\nposition = [1, 1]\nheading = {heading}\n[[wheel]]\nposition = [-1, 2]\n"
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.5\n{wheels}{units}\n{field}", encoding="utf-8")
    return load_scene(path)


def angle_of(scene: Scene) -> mpmath.mpf:
    x, y = (Fraction(str(entry)) for entry in scene.wheels[0].direction)
    return mp.atan2(mp.mpf(y.numerator) / y.denominator, mp.mpf(x.numerator) / x.denominator)


@pytest.mark.parametrize(
    ("heading", "units", "notes"),
    [
        ("225", "", [WITHOUT_UNIT]),
        ('"225"', "", [WITHOUT_UNIT]),
        ("225", '[units]\nangle = "deg"', []),
        ('"225 deg"', "", []),
        ('"225 deg"', '[units]\nangle = "rad"', []),
        ('"5*pi/4"', '[units]\nangle = "deg"', []),
        ('"3.926990816987241 rad"', "", [ROUNDED]),
        ("3.926990816987241", '[units]\nangle = "rad"', [ROUNDED]),
        ("[-3, -3]", "", []),
    ],
)
def test_one_direction_written_in_many_ways(tmp_path: Path, heading: str, units: str, notes: list[str]) -> None:
    scene = scene_with(tmp_path, heading, units)
    x, y = scene.wheels[0].unit_direction
    assert x == y
    assert x * x == Fraction(1, 2)
    assert x < 0
    assert list(angle_notes(scene.field)) == notes


@pytest.mark.parametrize(
    ("heading", "radians", "shown"),
    [
        ('"3.927 rad"', mp.mpf("3.927") - 2 * mp.pi, "-134.9994739 deg"),
        ('"12.345 deg"', mp.mpf("12.345") * mp.pi / 180, "12.345 deg"),
        ('"pi/361"', mp.pi / 361, "0.4986149584 deg"),
    ],
)
def test_other_angles_are_rational_directions_and_a_note_says_so(
    tmp_path: Path, heading: str, radians: mpmath.mpf, shown: str
) -> None:
    scene = scene_with(tmp_path, heading)
    x, y = scene.wheels[0].direction
    assert x.as_rational() is not None
    assert x * x + y * y == 1
    assert abs(angle_of(scene) - radians) < CLOSENESS
    (note,) = angle_notes(scene.field)
    assert note.startswith(f"angles taken as measured: {shown}: no number field of degree up to 12 holds them all")


def test_a_heading_of_zero_needs_no_unit(tmp_path: Path) -> None:
    assert angle_notes(scene_with(tmp_path, "0").field) == ()


def test_the_unit_is_that_of_fields_and_phases_too(tmp_path: Path) -> None:
    spiral = scene_with(tmp_path, "0", '[units]\nangle = "deg"', '[field]\nkind = "spiral"\nangle = 30\n')
    assert spiral.field.radicands == [3]
    path = tmp_path / "ring.toml"
    ring = '[friction]\nmu_roll = 1\nmu_side = 1\n[ring]\ncount = 3\nphase = "20 deg"\n'
    path.write_text(ring, encoding="utf-8")
    x, y = load_scene(path).wheels[0].position
    assert (float(x), float(y)) == pytest.approx((mp.cos(mp.pi / 9), mp.sin(mp.pi / 9)), abs=1e-15)


def test_headings_of_a_table(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text('x,y,heading\n1,0,045\n0,1,"0.25 rad"\n1,1,90 deg\n', encoding="utf-8")
    head = '[friction]\nmu_roll = 1\nmu_side = 1\n[wheels]\nfile = "w.csv"\n'
    (tmp_path / "my.toml").write_text(head, encoding="utf-8")
    first, second, third = load_scene(tmp_path / "my.toml").wheels
    assert first.direction[0] == first.direction[1] > 0
    assert float(second.direction[1]) == pytest.approx(mp.sin(0.25), abs=CLOSENESS)
    assert list(third.direction) == [0, 1]
    field = first.position[0].field
    assert isinstance(field, NumberField)
    notes = angle_notes(field)
    assert notes[0] == WITHOUT_UNIT
    assert "14.32394488 deg" in notes[1]
    (tmp_path / "my.toml").write_text(head + '[units]\nangle = "rad"\n', encoding="utf-8")
    assert float(load_scene(tmp_path / "my.toml").wheels[0].direction[0]) == pytest.approx(mp.cos(45), abs=CLOSENESS)
