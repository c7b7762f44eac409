"""Lengths that a scene has by default, and scenes that must behave alike."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.body import FEW, default_radius, outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene, default_length, rational_size
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length, moved, scaled, with_friction_ratio
from nonsmooth.symbolic.mechanics.springs import under_rule
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import Vector, cross, minus
from nonsmooth.symbolic.systems.switched_system import scaled_system, with_rate_ratio
from tests.conftest import Arrays

# ---- The length l of ``V = |c|^2 + l^2 theta^2``: stated, by default a part of the array, the same in every unit.

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


def test_in_its_own_length_a_scene_has_length_one() -> None:
    given = load_scene("ring-5")
    scene = scaled(given, Fraction(7, 5))
    own = in_own_length(scene)
    assert scene.check.length == Fraction(7, 5)
    assert own.check == given.check
    assert [wheel.position for wheel in own.wheels] == [wheel.position for wheel in given.wheels]
    assert in_own_length(own) is own


# ---- The square that a scene checks by default: a part of the array, inside its support polygon, in any unit the
# same.

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


@pytest.mark.parametrize("name", ["carton", "whole"])
def test_of_many_wheels_on_springs_all_carry_in_the_square_under_box(tmp_path: Path, name: str) -> None:
    """The default of other rules and of few wheels is wider; what is stated stays."""
    body = '[body]\nshape = "disc"\nradius = 100\n' if name == "carton" else ""
    for count, narrow in ((8, False), (10, True)):
        (tmp_path / "grid.toml").write_text(
            f'{HEAD}[grid]\nrows = {count}\ncolumns = {count}\n[field]\nkind = "radial"\nspeed = "unit"\n{body}'
        )
        scene = standing(load_scene(tmp_path / "grid.toml", rule="box"))
        wide = standing(load_scene(tmp_path / "grid.toml"))
        assert (float(scene.check.radius) < float(wide.check.radius)) == narrow
        assert not narrow or len(load_regions(scene)) == 1
        assert standing(under_rule(wide, "box")).check.radius == Fraction(str(scene.check.radius))
        assert load_scene(tmp_path / "grid.toml", rule="box", radius="2").check.radius == 2


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


# ---- Scenes that must behave alike: what the changes do to wheels, loads and formulas ------------

FACTOR = Fraction(10) ** -9


def test_twists_of_a_scaled_array(arrays: Arrays) -> None:
    """The same velocities, rotation by 1/s; and a speed that was the rim's length stays."""
    scene = arrays.random(2, 5)
    before, after = (build_nearest_partition(s) for s in (scene, scaled(scene, FACTOR)))
    assert [c.twists[0].omega for c in after.cells] == [c.twists[0].omega / FACTOR for c in before.cells]
    x, y = scene.check.equilibrium
    for cell, small in zip(before.cells, after.cells, strict=True):
        assert small.twists[0].pose_rate((x * FACTOR, y * FACTOR)) == cell.twists[0].pose_rate((x, y))
    assert scaled(scene, FACTOR).check.radius == scene.check.radius * FACTOR


@pytest.mark.parametrize("change", ["scaled", "moved"])
def test_a_load_table_goes_along(arrays: Arrays, change: str) -> None:
    scene = arrays.four_wheel()
    rows = tuple((scene.field(k), scene.field(k + 1), scene.field(-k)) for k in range(1, 5))
    loaded = type(scene.contact)(scene.contact.rule, LoadTable(rows))
    table = type(scene)(scene.name, scene.field, scene.wheels, loaded, scene.check)
    after = scaled(table, FACTOR) if change == "scaled" else moved(table, Fraction(5), Fraction(-3))
    here = (Fraction(1, 7), Fraction(2, 5))
    there = (here[0] * FACTOR, here[1] * FACTOR) if change == "scaled" else (here[0] + 5, here[1] - 3)
    assert isinstance(after.contact.loads, LoadTable)
    for old, new in zip(rows, after.contact.loads.rows, strict=True):
        assert old[0] + old[1] * here[0] + old[2] * here[1] == new[0] + new[1] * there[0] + new[2] * there[1]


def test_friction_ratio(arrays: Arrays) -> None:
    ratio = Fraction(1, 10**12)
    for wheel in with_friction_ratio(arrays.random(1, 4), ratio).wheels:
        assert wheel.friction.side / wheel.friction.roll == ratio


@pytest.mark.parametrize("name", ["flower", "eq-4", "relay-oscillator-damped"])
def test_scaled_systems_are_the_same_motion_in_other_units(name: str) -> None:
    """``k s f(x/s)`` at ``s x`` is ``k s f(x)``."""
    scene, speed = load_system(name), Fraction(7, 3)
    other = scaled_system(scene, FACTOR, speed)
    point = (Fraction(3, 10), Fraction(-1, 7))

    def signs(at: tuple[Fraction, Fraction]):  # type: ignore[no-untyped-def]  # a sign function at a point
        return lambda inner: inner((scene.field(at[0]), scene.field(at[1]))).sign()

    there = (point[0] * FACTOR, point[1] * FACTOR)
    for own, changed in zip(scene.velocity(signs(point)), other.velocity(signs(there)), strict=True):
        assert changed(there) == own(point) * speed * FACTOR
    first, second = with_rate_ratio(scene, speed).velocity(signs(point))
    assert first(point) == scene.velocity(signs(point))[0](point)
    assert second(point) == scene.velocity(signs(point))[1](point) * speed
