"""Angles and units of scene files: exact where they can be, with their unit as people write it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from mpmath import mp

from nonsmooth.proofs.certificate import scene_record
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.scene_values import AngleReading, read_angle, read_start_angle
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, SpeedUnit, Units
from nonsmooth.symbolic.numbers.number_field import (
    MOST_DEGREE,
    ROUNDING,
    NumberField,
    angle_notes,
    choose_angles,
    degree_of,
    turn_of_radians,
)
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS, rational_direction, simplest_between
from tests.thorough import few

# ---- Angles of scene files: numbers in degrees and radians, with their unit or in that of [units], and multiples of
# pi.

DIGITS = 60
DEGREE, RADIAN = AngleUnit.DEGREE, AngleUnit.RADIAN
WITHOUT_UNIT = "angles without a unit are read in degrees, as long as [units] states none"
ROUNDED = "angles in radians within 1e-12 of a multiple of pi are taken as that multiple"
FLOAT_CLOSENESS = 1e-12  # radians; what the file format promises


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
    assert abs(angle_of(scene) - radians) < FLOAT_CLOSENESS
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
    assert float(second.direction[1]) == pytest.approx(mp.sin(0.25), abs=FLOAT_CLOSENESS)
    assert list(third.direction) == [0, 1]
    field = first.position[0].field
    assert isinstance(field, NumberField)
    notes = angle_notes(field)
    assert notes[0] == WITHOUT_UNIT
    assert "14.32394488 deg" in notes[1]
    (tmp_path / "my.toml").write_text(head + '[units]\nangle = "rad"\n', encoding="utf-8")
    assert float(load_scene(tmp_path / "my.toml").wheels[0].direction[0]) == pytest.approx(
        mp.cos(45), abs=FLOAT_CLOSENESS
    )


# ---- Measured angles: rational directions against mpmath, and which angles of a scene stay exact.

ONE_DEGREE = Fraction(1, 180)
DIRECTION_DIGITS = 40


def degrees(*values: int) -> list[Fraction]:
    return [value * ONE_DEGREE for value in values]


@few(4)
@pytest.mark.parametrize("start", range(0, 720, 90))
def test_directions_are_close_and_of_length_one(start: int) -> None:
    with mp.workdps(DIRECTION_DIGITS):
        for turn in degrees(*range(start, start + 90)):
            cosine, sine = rational_direction(turn)
            angle = mp.pi * turn.numerator / turn.denominator
            beside = mpmath.mpf(cosine.numerator) / cosine.denominator - mp.cos(angle)
            above = mpmath.mpf(sine.numerator) / sine.denominator - mp.sin(angle)
            assert cosine**2 + sine**2 == 1
            assert mp.hypot(beside, above) < mpmath.mpf(CLOSENESS.numerator) / CLOSENESS.denominator


def test_mirrored_and_turned_angles_have_mirrored_and_turned_directions() -> None:
    for turn in degrees(*range(1, 45), *range(46, 90)):  # no rational direction is its own mirror image at 45
        cosine, sine = rational_direction(turn)
        assert rational_direction(-turn) == (cosine, -sine)
        assert rational_direction(1 - turn) == (-cosine, sine)
        assert rational_direction(turn + Fraction(1, 2)) == (-sine, cosine)
        assert rational_direction(Fraction(1, 2) - turn) == (sine, cosine)


@pytest.mark.parametrize(
    ("low", "high", "simplest"),
    [("1/3", "1/2", "1/2"), ("3/10", "33/100", "3/10"), ("314/100", "315/100", "22/7"), ("1/7", "1/7", "1/7")],
)
def test_the_simplest_fraction_between_two(low: str, high: str, simplest: str) -> None:
    found = simplest_between(Fraction(low), Fraction(high))
    assert Fraction(low) <= found <= Fraction(high)
    assert found.denominator <= Fraction(simplest).denominator


@pytest.mark.parametrize("values", [(0, 15, 30, 45, 60, 75, 345), (10, 50, 110), (18, 36, 54), (9, 27), (5, 355)])
def test_small_fields_stay_exact(values: tuple[int, ...]) -> None:
    choice = choose_angles(degrees(*values))
    assert not choice.measured
    assert degree_of(choice.order) <= MOST_DEGREE


@pytest.mark.parametrize(
    ("values", "measured"), [((37,), (37,)), ((10, 18), (10, 18)), ((30, 45, 37, 60, 18), (18, 37)), ((1, 90), (1,))]
)
def test_all_angles_of_a_scene_count_together(values: tuple[int, ...], measured: tuple[int, ...]) -> None:
    for order in (values, values[::-1]):
        choice = choose_angles(degrees(*order))
        assert choice.measured == tuple(degrees(*measured))
        assert choice.order == 1


def test_a_field_knows_its_measured_angles() -> None:
    field = choose_angles(degrees(37, 30)).field
    assert [field.has_angle(turn) for turn in degrees(37, -323, 30, 38)] == [True, True, True, False]
    assert field.cos_pi(37 * ONE_DEGREE) ** 2 + field.sin_pi(37 * ONE_DEGREE) ** 2 == 1
    assert field.cos_pi(30 * ONE_DEGREE) ** 2 == Fraction(3, 4)
    with pytest.raises(ValueError, match="order 1"):
        field.cos_pi(38 * ONE_DEGREE)


def measured_scene(folder: Path, heading: str) -> Scene:
    path = folder / "my.toml"
    wheels = "".join(f'[[wheel]]\nposition = [{x}, 1]\nheading = "{heading}"\n' for x in (0, 1, 2))
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.5\n{wheels}", encoding="utf-8")
    return load_scene(path)


def test_a_scene_in_whole_degrees_has_rational_rims_and_says_so(tmp_path: Path) -> None:
    scene = measured_scene(tmp_path, "37*pi/180")
    assert scene.field.modulus is None
    assert not scene.field.radicands
    assert all(dot(wheel.direction, wheel.direction) == 1 == wheel.length for wheel in scene.wheels)
    (note,) = angle_notes(scene.field)
    assert "37/180*pi" in note
    assert "1e-15" in note


@pytest.mark.parametrize("heading", ["pi/6", "35*pi/180", "pi/5"])
def test_a_scene_of_exact_angles_has_no_note(tmp_path: Path, heading: str) -> None:
    assert angle_notes(measured_scene(tmp_path, heading).field) == ()


def test_a_ring_of_many_wheels_at_an_odd_phase_is_placed_on_its_circle(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('[friction]\nmu_roll = 1\nmu_side = 1\n[ring]\ncount = 359\nphase = "pi/7"\n', encoding="utf-8")
    scene = load_scene(path)
    assert all(dot(wheel.position, wheel.position) == 1 for wheel in scene.wheels)
    assert len({wheel.position for wheel in scene.wheels}) == len(scene.wheels)


def test_an_exact_field_has_no_measured_angles() -> None:
    assert NumberField(20).measured == ()


# ---- Angles are read with their unit as people write it, in scene files, tables and starts -------

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
def test_a_heading_of_a_scene_and_of_a_table(word: str, tmp_path: Path) -> None:
    wheels = "".join(f'[[wheel]]\nposition = [{x}, {y}]\nheading = "{word}"\nspeed = 1\n' for x, y in PLACES)
    rows = "".join(f"{x},{y},{word},1\n" for x, y in PLACES)
    (tmp_path / "wheels.csv").write_text(f"x,y,heading,speed\n{rows}", encoding="utf-8")
    for table in (wheels, '[wheels]\nfile = "wheels.csv"\n'):
        (tmp_path / "scene.toml").write_text(HEAD + table, encoding="utf-8")
        for wheel in load_scene(tmp_path / "scene.toml").wheels:
            found = tuple(map(float, wheel.unit_direction))
            assert found == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5)), abs=1e-15)


# ---- Units of a scene: labels, and speeds that a file states in another unit of length -----------

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


def test_every_unit_of_length_has_its_unit_of_speed() -> None:
    assert [unit.length for unit in SpeedUnit] == list(LengthUnit)
    assert [str(unit) for unit in SpeedUnit] == [f"{unit}/s" for unit in LengthUnit]
