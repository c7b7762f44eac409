"""``[tolerance]`` of a scene file: what it holds, and bad values in one line that names the key."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import scaled
from nonsmooth.symbolic.messages.scene_error import SceneError

FOUR_WHEEL = Path(__file__).parents[2] / "symbolic" / "scenes" / "four-wheel.toml"


def with_table(folder: Path, lines: str) -> Scene:
    file = folder / "scene.toml"
    file.write_text(f"{FOUR_WHEEL.read_text(encoding='utf-8')}\n[tolerance]\n{lines}\n", encoding="utf-8")
    return load_scene(file)


def test_entries_are_exact_and_wheels_keep_their_field(tmp_path: Path) -> None:
    """A tolerance of one degree brings no cosine of one degree into the scene's numbers."""
    scene = with_table(tmp_path, 'position = "1/1000"\nheading = "1 deg"\nspeed = 0.02\nmu_side = "1/5"')
    found = scene.tolerances
    assert found is not None
    entries = (found.position, found.speed, found.mu_roll, found.mu_side, found.centre_of_mass)
    assert [str(entry) for entry in entries] == ["1/1000", "1/50", "0", "1/5", "0"]
    assert found.heading == Fraction(1, 180)
    assert found.names == ("position", "heading", "speed", "mu_side")
    assert scene.field.base_degree == load_scene("four-wheel").field.base_degree
    assert load_scene("four-wheel").tolerances is None


def test_boxes_grow_and_shrink(tmp_path: Path) -> None:
    scene = with_table(tmp_path, 'position = "1/10"\nheading = "2 deg"')
    assert scene.tolerances is not None
    double = scene.tolerances.times(Fraction(2))
    assert (str(double.position), double.heading) == ("1/5", Fraction(4, 180))
    assert scene.tolerances.without("position").names == ("heading",)
    larger = scaled(scene, Fraction(10)).tolerances
    assert larger is not None
    assert (str(larger.position), larger.heading) == ("1", Fraction(2, 180))


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("position = -1", "tolerance.position: required a number of at least 0, received -1"),
        ('heading = "90 deg"', "tolerance.heading: required an angle of at least 0, below a quarter turn"),
        ("speed = 1", "tolerance.speed: required a share of at least 0 and below 1, received 1"),
        ('mu_roll = "x"', "tolerance.mu_roll: required a formula"),
        ("size = 1", "tolerance.size: required one of the keys position, heading, speed"),
        ("position = 0", "tolerance: required an entry that is not zero"),
    ],
)
def test_bad_values_name_the_key(tmp_path: Path, lines: str, said: str) -> None:
    with pytest.raises(SceneError) as raised:
        with_table(tmp_path, lines)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)
