"""The length l of ``V = |c|^2 + l^2 theta^2``: stated, by default a part of the array, the same in every unit."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene, default_length, rational_size
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length, moved, scaled
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_field import NumberField

FACTORS = (Fraction(1000), Fraction(100), Fraction(5000, 127), Fraction(1, 3), Fraction(10) ** 200)
ROUNDING = 6e-3  # relative, of three digits


def length_of(scene: Scene) -> Fraction:
    return default_length([wheel.position for wheel in scene.wheels], scene.check.equilibrium)


def mean_distance(scene: Scene) -> float:
    x, y = (float(entry) for entry in scene.check.equilibrium)
    squares = [(float(w.position[0]) - x) ** 2 + (float(w.position[1]) - y) ** 2 for w in scene.wheels]
    return math.sqrt(math.fsum(squares) / len(squares))


def written(folder: Path, check: str) -> Path:
    path = folder / "my.toml"
    text = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 5\nradius = 3\n[check]\n'
    path.write_text(text + check, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", builtin_scenes())
def test_it_is_the_root_mean_square_distance_in_every_unit(name: str) -> None:
    scene = load_scene(name)
    assert float(length_of(scene)) == pytest.approx(mean_distance(scene), rel=ROUNDING)
    for factor in FACTORS:
        assert length_of(scaled(scene, factor)) == factor * length_of(scene)
    assert length_of(moved(scene, Fraction(7, 3), Fraction(-2))) == length_of(scene)


def test_a_tie_of_the_rounding_is_one_in_every_unit() -> None:
    """Distances 2001 and 2001 of a size 4000 (one of them aside): the ratio 0.50025 is no tie, 2002/4000 is one."""
    field = NumberField(1)
    for far in (2001, 2002, 2006):
        found = set()
        for factor in (Fraction(1), Fraction(1, 1000), Fraction(1, 7), Fraction(5, 127)):
            places = [(field(x * factor), field(0)) for x in (-2000, 2000)]
            away = field(factor) * Fraction(far * far - 4_000_000, 1)
            point = (field(0), (away * factor).sqrt())
            found.add(default_length(places, point) / factor)
        assert len(found) == 1


def test_the_size_of_a_number_scales_with_it() -> None:
    field = NumberField(10)
    for value in (field(7), field.sqrt(2) * 3 - 1, field.cos_pi(Fraction(2, 5)) - field.sqrt(3)):
        for factor in (*FACTORS, Fraction(-3)):
            assert rational_size(value * factor) == abs(factor) * rational_size(value) > 0


def test_the_built_in_scenes_take_the_papers_length() -> None:
    assert {load_scene(name).check.length for name in builtin_scenes()} == {1}
    assert load_scene("four-wheel", at="0,1/4").check.length == 1


def test_a_scene_file_states_it_or_takes_the_default(tmp_path: Path) -> None:
    assert load_scene(written(tmp_path, 'length = "7/5"')).check.length == Fraction(7, 5)
    assert load_scene(written(tmp_path, 'length = "sqrt(2)**2"')).check.length == 2
    scene = load_scene(written(tmp_path, ""))
    assert scene.check.length == 3
    assert scene.check.has_default_length


def test_a_default_length_follows_the_point_and_a_stated_one_stays(tmp_path: Path) -> None:
    moved_along = load_scene(written(tmp_path, ""), at="4,0")
    assert moved_along.check.length == length_of(moved_along)
    assert float(moved_along.check.length) == pytest.approx(5, rel=ROUNDING)
    assert load_scene(written(tmp_path, "length = 2"), at="4,0").check.length == 2
    for check, length in (("", moved_along.check.length), ("length = 2", Fraction(2))):
        scene = load_scene(written(tmp_path, check))
        point = (scene.field(4), scene.field(0))
        there = scene.checked_at(point, scene.check.radius)
        assert (there.check.length, there.check.equilibrium) == (length, point)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ('"sqrt(2)"', "check.length: required a rational number, received sqrt(2)"),
        ("0", "check.length: required a positive number, received 0"),
        ('"-1/2"', "check.length: required a positive number, received -1/2"),
        ('"l"', "check.length: required a formula of numbers"),
    ],
)
def test_another_length_is_refused_in_one_line(tmp_path: Path, value: str, message: str) -> None:
    with pytest.raises(SceneError) as refusal:
        load_scene(written(tmp_path, f"length = {value}"))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_in_its_own_length_a_scene_has_length_one() -> None:
    given = load_scene("ring-5")
    scene = scaled(given, Fraction(7, 5))
    own = in_own_length(scene)
    assert scene.check.length == Fraction(7, 5)
    assert own.check == given.check
    assert [wheel.position for wheel in own.wheels] == [wheel.position for wheel in given.wheels]
    assert in_own_length(own) is own
