"""The square that a scene checks by default: a part of the array, inside its support polygon, in any unit the same."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.mechanics.body import FEW, default_radius, outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import Vector, cross, minus

SCENES = Path(__file__).resolve().parents[2] / "symbolic" / "scenes"
HEAD = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
SCALES = (Fraction(1), Fraction(1000), Fraction(1, 1000), Fraction(5000, 127), Fraction(1, 3))


def positions(*points: tuple[object, object], scale: Fraction = Fraction(1)) -> list[Vector]:
    field = NumberField()
    return [(field(Fraction(str(x)) * scale), field(Fraction(str(y)) * scale)) for x, y in points]


def radius_at(array: list[Vector], x: object, y: object, scale: Fraction = Fraction(1)) -> Fraction:
    (point,) = positions((x, y), scale=scale)
    field = array[0][0].field
    found = default_radius(array, (field(Fraction(str(point[0]))), field(Fraction(str(point[1])))))
    return Fraction(str(found))


def square_fits(array: list[Vector], x: Fraction, y: Fraction, half: Fraction) -> bool:
    """Whether all corners of a square lie left of every side that two wheels span, literally."""
    field = array[0][0].field
    corners = [(field(x + a * half), field(y + b * half)) for a in (-1, 1) for b in (-1, 1)]
    for p in array:
        for q in array:
            is_side = p != q and all(cross(minus(q, p), minus(other, p)) >= 0 for other in array)
            if is_side and any(cross(minus(q, p), minus(corner, p)) < 0 for corner in corners):
                return False
    return True


SQUARE = ((1, 1), (-1, 1), (-1, -1), (1, -1))
TABLE = tuple((Fraction(k, 5), Fraction(j, 5)) for j in (0, 1) for k in range(4))


@pytest.mark.parametrize(
    ("points", "at", "radius"),
    [
        (SQUARE, (0, 0), "1/2"),
        (TABLE, ("0.3", "0.1"), "1/20"),  # 0.6 times 0.2: half of the half width
        (TABLE, ("0.25", "0.1"), "1/20"),
        (SQUARE, ("1/2", "1/4"), "1/4"),
        (SQUARE, ("0.999", 0), "1/2000"),
        (((0, 0), (4, 0), (0, 4)), (1, 1), "1/2"),
        (((0, 0), (4, 0), (0, 4)), ("4/3", "4/3"), "1/3"),
    ],
)
def test_a_part_of_the_size_of_which_twice_fits(
    points: tuple[tuple[object, object], ...], at: tuple[object, object], radius: str
) -> None:
    assert radius_at(positions(*points), *at) == Fraction(radius)


@pytest.mark.parametrize(
    ("points", "at"),
    [
        (SQUARE, (1, 0)),
        (SQUARE, (1, 1)),
        (SQUARE, (3, 0)),
        (((0, 0), (1, 2)), (0, 0)),
        (((0, 0), (1, 1), (2, 2)), (1, 1)),
    ],
)
def test_a_quarter_of_the_size_without_support(
    points: tuple[tuple[object, object], ...], at: tuple[object, object]
) -> None:
    assert radius_at(positions(*points), *at) == Fraction(1, 2)


@pytest.mark.parametrize("seed", range(8))
def test_random_arrays_in_every_unit(seed: int) -> None:
    rng = random.Random(seed)
    points = [(Fraction(rng.randint(-50, 50), 7), Fraction(rng.randint(-20, 20), 11)) for _ in range(3 + seed)]
    x, y = (sum(values, Fraction(0)) / len(points) for values in zip(*points, strict=True))
    array = positions(*points)
    radius = radius_at(array, x, y)
    extents = [max(values) - min(values) for values in zip(*points, strict=True)]
    parts = max(extents) / radius
    assert parts.denominator == 1
    assert square_fits(array, x, y, 2 * radius)
    assert not square_fits(array, x, y, 2 * max(extents) / (parts - 1))
    for scale in SCALES:
        assert radius_at(positions(*points, scale=scale), x, y, scale) == radius * scale


def test_positions_need_not_be_rational(tmp_path: Path) -> None:
    scene = load(tmp_path, '[grid]\nrows = 2\ncolumns = 2\npitch = "sqrt(2)"\n')
    assert scene.check.radius * scene.check.radius == Fraction(1, 8)
    ring = load(tmp_path, "[ring]\ncount = 359\n")
    assert float(ring.check.radius) == pytest.approx(2 / 6, rel=1e-4)  # a circle: 1/(2 sqrt(2)) rounded to 2/6


def test_large_arrays_are_thinned_out_by_floats() -> None:
    side = 40
    array = positions(*((x, y) for x in range(side) for y in range(side)))
    outer = outer_positions(array)
    assert len(array) > FEW
    assert len(outer) < len(array) / 4
    assert support_polygon(outer) == support_polygon(array)
    assert radius_at(array, 1, 1) == Fraction(side - 1, 78)


# ---- in scenes -------------------------------------------------------------------------------------------


def load(folder: Path, text: str) -> Scene:
    (folder / "my.toml").write_text(HEAD + text, encoding="utf-8")
    return load_scene(folder / "my.toml")


def test_one_table_in_metres_millimetres_and_inches(tmp_path: Path) -> None:
    found = []
    for unit, size in (("m", 1), ("mm", 1000), ("in", Fraction(5000, 127))):
        wheels = "".join(f'[[wheel]]\nposition = ["{x * size}", "{y * size}"]\nheading = "30 deg"\n' for x, y in TABLE)
        check = f'[check]\nequilibrium = ["{Fraction(3, 10) * size}", "{Fraction(1, 10) * size}"]\n'
        scene = load(tmp_path, f'{wheels}[units]\nlength = "{unit}"\n{check}')
        found.append(scene.check.radius)
    assert found == [Fraction(1, 20), 50, Fraction(19, 10)]  # of 1.968... in: two digits, not above


def test_a_radius_that_is_named_counts(tmp_path: Path) -> None:
    grid = "[grid]\nrows = 6\ncolumns = 6\n"
    assert load(tmp_path, grid).check.radius == Fraction(5, 4)
    assert load(tmp_path, f"{grid}[check]\nradius = 2\n").check.radius == 2
    assert load_scene(tmp_path / "my.toml", radius="1/3").check.radius == Fraction(1, 3)


def test_the_built_in_arrays_name_theirs_and_plain_systems_keep_one_half() -> None:
    assert {str(load_scene(name).check.radius) for name in builtin_scenes()} == {"1/2", "1/4", "1/5"}
    assert all("radius" in (SCENES / f"{name}.toml").read_text() for name in builtin_scenes())
    assert {str(load_system(name).check.radius) for name in builtin_systems()} == {"1/2"}
