"""Built-in scenes: what their names promise."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from pathlib import Path

import pytest

import nonsmooth.symbolic.files.scene_file
from nonsmooth.symbolic.files.documents import builtin_descriptions, builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import Twist, cross_product, scene_rows, side_row
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import cross, dot
from tests.four_wheel import CORNERS

HALF = Fraction(1, 2)


def positions(scene: Scene) -> list[tuple[object, object]]:
    return [wheel.position for wheel in scene.wheels]


def frictions(scene: Scene) -> set[tuple[object, object]]:
    return {(wheel.friction.roll, wheel.friction.side) for wheel in scene.wheels}


def turn_of(scene: Scene) -> set[tuple[int, int]]:
    """Signs of the inward and the counterclockwise part of every rim direction."""
    return {
        (-dot(wheel.position, wheel.direction).sign(), -cross(wheel.position, wheel.direction).sign())
        for wheel in scene.wheels
    }


def test_names_are_those_on_disk() -> None:
    folder = Path(str(nonsmooth.symbolic.files.scene_file.__file__)).parents[1] / "scenes"
    assert sorted(builtin_scenes()) == sorted(path.stem for path in folder.glob("*.toml"))


def test_every_scene_has_a_description() -> None:
    descriptions = builtin_descriptions()
    assert tuple(descriptions) == builtin_scenes()
    assert len(set(descriptions.values())) == len(descriptions)
    assert all(10 < len(text) < 110 and "\n" not in text for text in descriptions.values())


@pytest.mark.parametrize("name", builtin_scenes())
def test_every_scene_loads(name: str) -> None:
    scene = load_scene(name)
    assert (scene.name, scene.source) == (name, name)
    assert scene.contact.rule == "nearest"
    assert scene.check.radius in (HALF, HALF / 2, Fraction(1, 5))
    assert not any(scene.check.equilibrium)
    special = {
        "four-wheel-side": {(HALF, 1)},
        "differential-drive": {(1, HALF), (Fraction(1, 100), Fraction(1, 1000))},
        "omni-3": {(1, 0)},
        "mecanum-4": {(1, 0)},
        "roller-bed": {(HALF, Fraction(1, 10))},
    }
    assert frictions(scene) == special.get(name, {(1, HALF)})
    speeds = {"differential-drive": {1, 2}, "mecanum-4": {3, -3}}
    assert {wheel.speed for wheel in scene.wheels} == speeds.get(name, {1})
    assert {wheel.axis is None for wheel in scene.wheels} == {name not in ("mecanum-4", "roller-bed")}


@pytest.mark.parametrize("name", ["four-wheel", "four-wheel-side"])
def test_four_wheel(name: str) -> None:
    scene = load_scene(name)
    assert positions(scene) == CORNERS  # in the order of the quadrants
    assert turn_of(scene) == {(1, 0)}


@pytest.mark.parametrize("count", [3, 5, 6, 8])
def test_rings(count: int) -> None:
    scene = load_scene(f"ring-{count}")
    assert len(scene.wheels) == count
    assert all(dot(p, p) == 1 for p in (wheel.position for wheel in scene.wheels))
    assert turn_of(scene) == {(1, 0)}
    angles = [math.atan2(float(w.position[1]), float(w.position[0])) % math.tau for w in scene.wheels]
    assert angles == pytest.approx([math.tau * k / count for k in range(count)])


def test_grid() -> None:
    scene = load_scene("grid-4x4")
    steps = [Fraction(k, 2) for k in (-3, -1, 1, 3)]
    assert positions(scene) == [(x, y) for y in steps for x in steps]
    assert turn_of(scene) == {(1, 0)}


def test_rectangle() -> None:
    scene = load_scene("rectangle")
    assert positions(scene) == [(2, 1), (-2, 1), (-2, -1), (2, -1)]
    assert turn_of(scene) == {(1, 0)}


def test_elliptic() -> None:
    scene = load_scene("elliptic")
    assert len(scene.wheels) == 6
    assert all(w.direction == (-w.position[0], -2 * w.position[1]) for w in scene.wheels)


def test_spiral_is_inward_turned_by_30_degrees() -> None:
    scene = load_scene("spiral-30")
    for wheel in scene.wheels:
        inward = -wheel.position[0], -wheel.position[1]
        assert 2 * cross(inward, wheel.unit_direction) == dot(inward, inward).sqrt()  # sin 30° = 1/2
        assert dot(inward, wheel.unit_direction) > 0


def test_conveyor_rims_are_tangential() -> None:
    scene = load_scene("conveyor-3")
    assert len(scene.wheels) == 3
    assert turn_of(scene) == {(0, 1)}
    first, second, _ = (wheel.position for wheel in scene.wheels)
    assert dot(first, second) == -HALF  # cos 120°


def test_outward() -> None:
    assert positions(load_scene("outward")) == CORNERS
    assert turn_of(load_scene("outward")) == {(-1, 0)}


def test_saddle() -> None:
    scene = load_scene("saddle")
    assert positions(scene) == CORNERS
    assert all(w.direction == (-w.position[0], w.position[1]) for w in scene.wheels)


def test_the_differential_drive_is_carried_about_the_middle_of_its_axle() -> None:
    """All four wheels agree with the spin (0, 0, -1), and the axle lines of the drive wheels are one line."""
    scene = load_scene("differential-drive")
    zero, one = scene.field.zero, scene.field.one
    assert all(not row.residual(Twist(zero, zero, -one)) for row in scene_rows(scene))
    first, second = (side_row(wheel).normal for wheel in scene.wheels[:2])
    assert not any(cross_product(first, second))


def test_omniwheels_stand_along_their_ring() -> None:
    assert turn_of(load_scene("omni-3")) == {(0, 1)}


def test_mecanum_wheels_are_driven_by_the_textbook_for_a_turn_of_one_radian_per_second() -> None:
    """Rollers on the ground along the ring, at 45 degrees to the rims: ``u = v_x -+ v_y -+ (l_x + l_y) omega``."""
    scene = load_scene("mecanum-4")
    vx, vy, omega, reach = 0, 0, 1, 2 + 1
    textbook = [vx - vy - reach * omega, vx + vy - reach * omega, vx - vy + reach * omega, vx + vy + reach * omega]
    assert [wheel.speed for wheel in scene.wheels] == textbook
    for wheel in scene.wheels:
        assert 2 * dot(wheel.unit_grip, wheel.unit_direction) ** 2 == 1  # cos 45 degrees, squared
        assert cross(wheel.position, wheel.grip)


def test_a_carton_of_2_6_by_1_6_pitches_lies_on_4_of_36_wheels() -> None:
    scene = load_scene("carton-on-6x6")
    assert len(scene.wheels) == 36
    assert len(standing(scene).wheels) == 4
    assert scene.body is not None
    assert "13/5 x 8/5" in scene.body.words


def test_rollers_of_the_bed_are_parallel_and_run_across_their_axes() -> None:
    for wheel in load_scene("roller-bed").wheels:
        assert [str(x) for x in (*wheel.grip, *wheel.direction)] == ["0", "1", "1", "0"]


def test_origin_of_off_center_lies_inside_one_cell_and_moves() -> None:
    """The two nearest wheels are unique, and their rims meet at the origin without being parallel."""
    wheels = sorted(load_scene("off-center").wheels, key=lambda w: dot(w.position, w.position))
    distances = [dot(w.position, w.position) for w in wheels]
    assert distances[0] < distances[1] < distances[2]
    nearest, second = wheels[:2]
    assert cross(nearest.direction, second.direction)
    assert not cross(nearest.position, nearest.direction)
    assert not cross(second.position, second.direction)
    assert nearest.speed == 1  # so the velocity v of the origin has d . v = 1: it is no equilibrium


def test_a_file_of_that_name_does_not_hide_a_built_in_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "four-wheel").write_text("nonsense", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert load_scene("four-wheel").name == "four-wheel"


def test_overrides_apply_to_built_in_scenes() -> None:
    scene = load_scene("ring-5", rule="box", radius="1/3", at="0,1/4")
    assert scene.contact.rule == "box"
    assert scene.check.radius == Fraction(1, 3)
    assert scene.check.equilibrium[1] == Fraction(1, 4)


def test_numbers_in_built_in_scenes_are_no_floats() -> None:
    folder = Path(str(nonsmooth.symbolic.files.scene_file.__file__)).parents[1] / "scenes"
    for path in folder.glob("*.toml"):
        assert not re.search(r"= *-?\d*\.\d", path.read_text(encoding="utf-8")), path.name
