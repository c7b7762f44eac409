"""Measured angles: rational directions against mpmath, and which angles of a scene stay exact."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from mpmath import mp

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.measured_angles import MOST_DEGREE, angle_notes, choose_angles, degree_of
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.rational_directions import CLOSENESS, rational_direction, simplest_between
from tests.thorough import few

DEGREE = Fraction(1, 180)
DIGITS = 40


def degrees(*values: int) -> list[Fraction]:
    return [value * DEGREE for value in values]


@few(4)
@pytest.mark.parametrize("start", range(0, 720, 90))
def test_directions_are_close_and_of_length_one(start: int) -> None:
    with mp.workdps(DIGITS):
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
    assert field.cos_pi(37 * DEGREE) ** 2 + field.sin_pi(37 * DEGREE) ** 2 == 1
    assert field.cos_pi(30 * DEGREE) ** 2 == Fraction(3, 4)
    with pytest.raises(ValueError, match="order 1"):
        field.cos_pi(38 * DEGREE)


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
