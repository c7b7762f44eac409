"""Rule ``nearest``: its exact cells against the rule's own words, also where floats are of little use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import bisector, build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.sampling import literal_twist
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import (
    Row,
    Twist,
    independent,
    roll_row,
    side_row,
    solve_rows,
    wheel_rows,
)
from nonsmooth.symbolic.mechanics.scene import Friction, Scene, Wheel
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays, Pair, WheelData
from tests.four_wheel import CORNERS, ROLL, SIDE
from tests.oracles.nearest_states import nearest_states
from tests.thorough import few, keep, thorough

# ---- Rule ``nearest``: its exact cells against the rule's own words, point by point --------------

WheelTolerance: TypeAlias = "Callable[[Arrays], Scene]"

TIE = (1, 1)


def random(seed: int) -> WheelTolerance:
    return lambda arrays: arrays.random(seed, 2 + seed % 7)


def cocircular(seed: int) -> WheelTolerance:
    return lambda arrays: arrays.cocircular(seed)


SCENES: dict[str, WheelTolerance] = {
    "four-wheel": lambda arrays: arrays.four_wheel(radius=3),
    "ring-3": lambda arrays: arrays.ring(3, SIDE),
    "ring-5": lambda arrays: arrays.ring(5, ROLL, radius=2),
    "ring-8": lambda arrays: arrays.ring(8, SIDE),
    "ring-9": lambda arrays: arrays.ring(9, ROLL),
    "grid-1x2": lambda arrays: arrays.grid(1, 2, radius=3),
    "grid-3x3": lambda arrays: arrays.grid(3, 3, TIE, radius=2),
    "grid-4x5": lambda arrays: arrays.grid(4, 5, SIDE, radius=3),
    "line": lambda arrays: arrays.grid(1, 5, SIDE, radius=2),
    **{f"random-{seed}": random(seed) for seed in range(14)},
    **{f"cocircular-{seed}": cocircular(seed) for seed in range(8)},
}

FRICTIONLESS = ((1, 0), (0, 1), (1, 0), (1, Fraction(1, 2)), (1, 1), (Fraction(1, 2), 1))


def frictionless(seed: int) -> WheelTolerance:
    """Wheels some of whose rows have no friction; in some arrays all rims are alike."""

    def build(arrays: Arrays) -> Scene:
        scene = arrays.random(seed, 3 + seed % 4)
        rng = np.random.default_rng([seed, 1])
        kinds = FRICTIONLESS[: 3 if seed % 3 == 0 else 6]
        chosen = [kinds[rng.integers(len(kinds))] for _ in scene.wheels]
        field = scene.field
        wheels = tuple(
            replace(w, friction=Friction(field(roll), field(side)))
            for w, (roll, side) in zip(scene.wheels, chosen, strict=True)
        )
        return replace(scene, wheels=wheels)

    return build


# A float solve of three rows of length about 1; triples of small determinant lose some digits.
ROUNDING = 1e-8


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest, arrays: Arrays) -> Scene:
    return SCENES[request.param](arrays)


def squared_distance(wheel: Wheel, point: Point) -> Number:
    (x, y), (px, py) = point, wheel.position
    return (x - px) ** 2 + (y - py) ** 2


def literal_rows(scene: Scene, point: Point) -> list[Row]:
    """The rule in its own words, exactly: nearest wheels first, larger friction first, greedy until three."""
    chosen: list[Row] = []
    for wheel in sorted(scene.wheels, key=lambda w: squared_distance(w, point)):
        rows = wheel_rows(wheel)
        for row in rows if wheel.friction.roll >= wheel.friction.side else rows[::-1]:
            if len(chosen) < 2 or (len(chosen) == 2 and len(independent([r.normal for r in (*chosen, row)])) == 3):
                chosen.append(row)
    return chosen


def every_greedy_choice(scene: Scene, point: Point) -> set[frozenset[str]]:
    """The rule in its own words, with rows without friction and ties: each order that the tied wheels allow."""
    nearest_first = sorted(scene.wheels, key=lambda w: squared_distance(w, point))
    orders = []
    for wheel in nearest_first:
        roll, side = roll_row(wheel), side_row(wheel)
        both = {(roll, side)} if roll.friction > side.friction else {(side, roll)}
        orders.append(both if roll.friction != side.friction else {(roll, side), (side, roll)})
    found = set()
    for chosen_orders in product(*orders):
        chosen: list[Row] = []
        for row in (row for rows in chosen_orders for row in rows if row.friction > 0):
            normals = [r.normal for r in (*chosen, row)]
            if len(chosen) < 3 and len(independent(normals)) == len(normals):
                chosen.append(row)
        found.add(frozenset(row.name for row in chosen))
    return found


def generic_point(scene: Scene, rng: np.random.Generator) -> Point:
    """A point of the square with large denominators: on no bisector of a test array."""
    (x, y), radius = scene.check.equilibrium, scene.check.radius
    a, b = rng.integers(-99990, 99991, 2).tolist()
    return x + radius * Fraction(a, 99991), y + radius * Fraction(b, 99991)


def picture(partition: Partition) -> set[tuple[tuple[int, ...], frozenset[Point], frozenset[Twist]]]:
    """Wheels, vertices and twists of every cell, whatever their order."""
    return {(c.wheels, frozenset(c.polygon.vertices), frozenset(c.twists)) for c in partition.cells}


# ---- the cells are those of the rule -------------------------------------------------------------


@few(6)
def test_cells_tile_the_square_exactly(scene: Scene) -> None:
    partition = build_nearest_partition(scene)
    assert partition.area_error == 0
    assert all(cell.polygon.area > 0 for cell in partition.cells)


@few(6)
def test_a_generic_point_lies_in_one_cell_only(scene: Scene) -> None:
    partition = build_nearest_partition(scene)
    rng = np.random.default_rng(1)
    for _ in range(15):
        assert len(partition.cells_at(generic_point(scene, rng))) == 1


@few(3)
def test_each_cell_follows_the_literal_rule(scene: Scene, arrays: Arrays) -> None:
    rng = np.random.default_rng(2)
    for cell in build_nearest_partition(scene).cells:
        for _ in range(3):
            point = arrays.interior_point(cell.polygon, rng)
            assert cell.states == nearest_states(scene, point)
            names = {row.name for row in literal_rows(scene, point)}
            assert {row.name for row in cell.states[0].rows} == names


@few(4)
def test_each_cell_has_the_twist_of_the_float_rule(scene: Scene, arrays: Arrays) -> None:
    rng = np.random.default_rng(3)
    for cell in build_nearest_partition(scene).cells:
        point = arrays.interior_point(cell.polygon, rng)
        twist = literal_twist(contact_model(scene), np.array([float(x) for x in point]))
        assert twist == pytest.approx([float(x) for x in cell.twists[0]], rel=ROUNDING, abs=ROUNDING)


@few(6)
def test_cells_say_which_wheels_are_nearest(scene: Scene, arrays: Arrays) -> None:
    rng = np.random.default_rng(4)
    for cell in build_nearest_partition(scene).cells:
        point = arrays.interior_point(cell.polygon, rng)
        distances = {wheel.index: squared_distance(wheel, point) for wheel in scene.wheels}
        nearest, second = cell.wheels
        others = [d for index, d in distances.items() if index not in (nearest, second)]
        assert distances[nearest] < distances[second]
        assert all(distances[second] < d for d in others)


@pytest.mark.parametrize("seed", range(20))
def test_the_rule_of_a_pair_is_the_greedy_rule(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 6)
    rng = np.random.default_rng(seed)
    for _ in range(10):
        point = generic_point(scene, rng)
        (first, *_) = nearest_states(scene, point)
        assert {row.name for row in first.rows} == {row.name for row in literal_rows(scene, point)}


# ---- rows without friction -----------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(60))
def test_rows_without_friction_are_never_taken(arrays: Arrays, seed: int) -> None:
    scene = frictionless(seed)(arrays)
    partition = build_nearest_partition(scene)
    assert partition.tiles
    assert partition.area_error == 0
    rng = np.random.default_rng(seed)
    for cell in partition.cells:
        point = arrays.interior_point(cell.polygon, rng)
        assert {frozenset(state.row_names) for state in cell.states} == every_greedy_choice(scene, point)
        assert set(cell.twists) == {state.twist for state in nearest_states(scene, point)}
        for state in cell.states:
            assert not any(row.residual(state.twist) for row in state.rows)
        twist = literal_twist(contact_model(scene), np.array([float(x) for x in point]))
        assert any(twist == pytest.approx([float(x) for x in t], rel=1e-6, abs=1e-6) for t in cell.twists)


@thorough  # about all random cases, which `make bench` runs
def test_arrays_of_every_kind_are_among_them(arrays: Arrays) -> None:
    """Cells of two and three wheels, and tied ones."""
    scenes = [frictionless(seed)(arrays) for seed in range(60)]
    cells = [cell for scene in scenes for cell in build_nearest_partition(scene).cells]
    assert {len(cell.wheels) for cell in cells} == {2, 3}
    assert any(len(cell.states) > 1 and len(cell.wheels) == 3 for cell in cells)
    assert any(not cell.states[0].is_of_a_pair for cell in cells)


@pytest.mark.parametrize("seed", range(20))
def test_pruning_changes_nothing_without_friction(arrays: Arrays, seed: int) -> None:
    scene = frictionless(seed)(arrays)
    pruned, whole = (build_nearest_partition(scene, prune=prune) for prune in (True, False))
    assert picture(pruned) == picture(whole)


@pytest.mark.parametrize(
    ("rims", "rank"),
    [([(-1, 0), (1, -1), (1, 1)], 2), ([(1, 0), (1, 0), (1, 0)], 2), ([(1, 0), (1, 0), (-2, 0)], 2)],
)
def test_too_few_rows_with_friction_are_refused(arrays: Arrays, rims: list[tuple[int, int]], rank: int) -> None:
    """Free rollers with rims inward leave the rotation free, parallel ones the translation across them."""
    positions: list[Pair] = [(1, 0), (-1, 1), (-1, -1)]
    scene = arrays.scene([WheelData(p, d) for p, d in zip(positions, rims, strict=True)], friction=(1, 0))
    assert len(independent([roll_row(wheel).normal for wheel in scene.wheels])) == rank
    message = f"three independent directions, received {rank}: the motion is not determined"
    with pytest.raises(RefusalError, match=message):
        build_nearest_partition(scene)


def test_omniwheels_translate_as_their_roll_rows_say(arrays: Arrays) -> None:
    """Three free rollers, driven for the translation (1, 0): it is the only motion without slip along any rim."""
    positions: list[Pair] = [(1, 0), (-1, 1), (-1, -1)]
    rims: list[Pair] = [(0, 1), (Fraction(3, 5), Fraction(4, 5)), (1, 0)]
    wheels = [WheelData(p, d, d[0]) for p, d in zip(positions, rims, strict=True)]
    scene = arrays.scene(wheels, friction=(1, 0))
    partition = build_nearest_partition(scene)
    for twist in (twist for cell in partition.cells for twist in cell.twists):
        assert twist.vx == 1
        assert not twist.vy
        assert not twist.omega


def test_a_wheel_without_grip_along_its_rim_holds_its_side(arrays: Arrays) -> None:
    """A caster-like support (mu_roll 0) beside two wheels: only its side row counts."""
    wheels = [
        WheelData((0, 0), (1, 0), 1, (0, 1)),
        WheelData((0, 2), (1, 0), 1, (1, Fraction(1, 2))),
        WheelData((0, -2), (1, 0), 3, (1, Fraction(1, 2))),
    ]
    (upper, lower) = build_nearest_partition(arrays.scene(wheels, radius=Fraction(1, 4))).cells
    assert {frozenset(cell.states[0].row_names) for cell in (upper, lower)} == {
        frozenset(("S1", "R2", "R3")),
    }


# ---- looking only at wheels that can matter ------------------------------------------------------


@few(4)
def test_pruning_changes_nothing(scene: Scene) -> None:
    pruned, whole = (build_nearest_partition(scene, prune=prune) for prune in (True, False))
    assert picture(pruned) == picture(whole)
    assert pruned.wheels_considered <= whole.wheels_considered == len(scene.wheels)


@few(1)
@pytest.mark.parametrize("seed", range(6))
def test_pruning_keeps_wheels_closer_together_than_doubles_resolve(arrays: Arrays, seed: int) -> None:
    """Positions differ by 1e-17 beside 1: as floats, near wheels and far ones are mixed up."""
    rng = np.random.default_rng(seed)
    tiny = Fraction(1, 10**17)
    places = dict.fromkeys((x, y) for x, y in rng.integers(-12, 13, (14, 2)).tolist())
    scene = arrays.scene(arrays.inward([(1 + x * tiny, 1 + y * tiny) for x, y in places]), radius=Fraction(3, 2))
    pruned, whole = (build_nearest_partition(scene, prune=prune) for prune in (True, False))
    assert picture(pruned) == picture(whole)


@few(1)
@pytest.mark.parametrize("seed", [36, 83, 85])  # seeds at which relative margins alone would lose a wheel
@pytest.mark.parametrize("unit", [Fraction(1, 10**323), Fraction(1, 10**400)], ids=["denormal", "underflow"])
def test_pruning_keeps_wheels_in_units_below_the_floats(arrays: Arrays, unit: Fraction, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = dict.fromkeys((x, y) for x, y in rng.integers(-9, 10, (14, 2)).tolist() if x or y)
    scene = arrays.scene(arrays.inward([(x * unit / 2, y * unit / 2) for x, y in places]), radius=3 * unit)
    pruned, whole = (build_nearest_partition(scene, prune=prune) for prune in (True, False))
    assert picture(pruned) == picture(whole)


def test_far_wheels_do_not_matter(arrays: Arrays) -> None:
    near = arrays.four_wheel()
    far = [replace(wheel, position=(wheel.position[0] * 50, wheel.position[1] * 50)) for wheel in near.wheels]
    crowd = replace(near, wheels=near.wheels + tuple(replace(w, index=w.index + 4) for w in far))
    partition = build_nearest_partition(crowd)
    assert partition.wheels_considered == 4
    assert picture(partition) == picture(build_nearest_partition(near))


def test_only_a_handful_of_a_large_grid_is_considered(arrays: Arrays) -> None:
    scene = arrays.grid(30, 30)
    partition = build_nearest_partition(scene)
    assert partition.wheels_considered <= 24
    assert partition.area_error == 0
    assert {w for cell in partition.cells for w in cell.wheels} == {w.index for w in middle(scene, 2)}


def middle(scene: Scene, reach: int) -> list[Wheel]:
    """Wheels that are among the two nearest somewhere within 1/2 of the origin."""
    return [w for w in scene.wheels if abs(w.position[0]) + abs(w.position[1]) < reach]


# ---- special arrays ------------------------------------------------------------------------------


def test_two_wheels_share_the_square_along_their_bisector(arrays: Arrays) -> None:
    scene = arrays.scene(arrays.inward([(2, 0), (0, 2)]), radius=1)
    partition = build_nearest_partition(scene)
    assert [cell.wheels for cell in partition.cells] == [(1, 2), (2, 1)]
    assert [cell.polygon.area for cell in partition.cells] == [2, 2]
    assert all(c.polygon.contains((scene.field.zero, scene.field.zero)) for c in partition.cells)


@pytest.mark.parametrize("n", range(3, 11))
def test_cocircular_wheels_meet_at_the_centre(arrays: Arrays, n: int) -> None:
    scene = arrays.ring(n)
    partition = build_nearest_partition(scene)
    assert len(partition.cells_at((scene.field.zero, scene.field.zero))) == len(partition.cells) == 2 * n


def test_a_wheel_on_the_equilibrium_owns_its_neighbourhood(arrays: Arrays) -> None:
    scene = arrays.grid(3, 3)
    partition = build_nearest_partition(scene)
    zero = scene.field.zero
    at_rest = partition.cells_at((zero, zero))
    assert {cell.wheels for cell in at_rest} == {(5, 2), (5, 4), (5, 6), (5, 8)}
    assert {cell.wheels[0] for cell in partition.cells} == {5}


@pytest.mark.parametrize("seeds", keep(1, [range(3), range(3, 10)]))
def test_equal_frictions_put_both_states_into_the_hull(arrays: Arrays, seeds: range) -> None:
    for seed in seeds:
        scene = arrays.random(seed, 5)
        tie, roll, side = (build_nearest_partition(arrays.with_friction(scene, f)) for f in (TIE, ROLL, SIDE))
        for cell, with_roll, with_side in zip(tie.cells, roll.cells, side.cells, strict=True):
            assert cell.polygon == with_roll.polygon == with_side.polygon
            assert set(cell.twists) == set(with_roll.twists) | set(with_side.twists)


def test_the_second_wheel_s_own_friction_decides_its_row(arrays: Arrays) -> None:
    scene = arrays.four_wheel(ROLL)
    slippery = Friction(scene.field(Fraction(1, 2)), scene.field(1))
    scene = replace(scene, wheels=(replace(scene.wheels[0], friction=slippery), *scene.wheels[1:]))
    for cell in build_nearest_partition(scene).cells:
        third = cell.states[0].rows[2]
        assert third.name == ("S1" if cell.wheels[1] == 1 else f"R{cell.wheels[1]}")


@pytest.mark.parametrize(("friction", "fallback"), [(ROLL, "S"), (SIDE, "R")])
def test_a_dependent_row_gives_way_to_the_next(
    arrays: Arrays, friction: tuple[Fraction | int, Fraction | int], fallback: str
) -> None:
    """The line of wheel 2's preferred row passes through wheel 1: the row repeats what wheel 1 says along it."""
    along, across = ((-1, 0), (0, 1))
    rims = (along, along) if friction == ROLL else (along, across)
    positions = ((1, 0), (-1, 0))
    wheels = [arrays.inward([p])[0]._replace(direction=d) for p, d in zip(positions, rims, strict=True)]
    scene = arrays.scene(wheels, friction)
    first, second = scene.wheels
    preferred = roll_row(second) if friction == ROLL else side_row(second)
    assert solve_rows((*wheel_rows(first), preferred)) is None
    cell = build_nearest_partition(scene).cells[0]
    assert [row.name for row in cell.states[0].rows] == ["R1", "S1", f"{fallback}2"]


@pytest.mark.parametrize("seed", range(6))
def test_bisectors_compare_distances(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 4)
    rng = np.random.default_rng(seed)
    for near, far in product(scene.wheels, repeat=2):
        if near is not far:
            line = bisector(near, far)
            point = generic_point(scene, rng)
            difference = squared_distance(far, point) - squared_distance(near, point)
            assert line.slack(point) == difference
            (a, b), (c, d) = near.position, far.position
            assert not line.slack(((a + c) / 2, (b + d) / 2))


@pytest.mark.parametrize("seed", range(6))
def test_recentring_moves_cells_with_the_origin(arrays: Arrays, seed: int) -> None:
    """Cells shift by -c*, pose rates at shifted points agree, rotation rates stay."""
    scene = arrays.random(seed, 5)
    x, y = scene.check.equilibrium
    before, after = build_nearest_partition(scene), build_nearest_partition(scene.recentred())
    for old, new in zip(before.cells, after.cells, strict=True):
        assert new.wheels == old.wheels
        assert new.polygon.vertices == tuple((a - x, b - y) for a, b in old.polygon.vertices)
        for twist, moved in zip(old.twists, new.twists, strict=True):
            assert moved.omega == twist.omega
            a, b = old.polygon.centre
            assert moved.pose_rate((a - x, b - y)) == twist.pose_rate((a, b))


# ---- Cells where floats are of little use: coordinates of 1e-300 and 1e300, wheels on one circle but for 1e-300,
# ties.
#
# Their oracle is a change of units: exact arithmetic does not know how long a length is, so a scaled array has the
# same contact states in the same number of cells, and cells add up to the whole square exactly.

TEN = Fraction(10)
BUILDERS: dict[str, Callable[[Scene], Partition]] = {"box": build_box_partition, "nearest": build_nearest_partition}


def four_wheel(
    arrays: Arrays,
    *,
    scale: Fraction = Fraction(1),
    speed: Fraction = Fraction(1),
    off: Fraction = Fraction(0),
    side: Fraction = Fraction(1, 5),
) -> Scene:
    """The four wheels in other units, the first a little off its corner."""
    wheels = [
        WheelData((x * scale + (off if k == 0 else 0), y * scale), (-x, -y), speed) for k, (x, y) in enumerate(CORNERS)
    ]
    return arrays.scene(wheels, (1, side), radius=scale / 2)


def signature(partition: Partition) -> list[tuple[str, ...]]:
    assert partition.tiles
    return sorted(tuple(sorted(state.name for state in cell.states)) for cell in partition.cells)


@pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)
@pytest.mark.parametrize(("length", "speed"), [(-300, 0), (-160, 160), (160, -160), (300, 0), (0, 300), (0, -300)])
def test_units_do_not_matter(arrays: Arrays, build: Callable[[Scene], Partition], length: int, speed: int) -> None:
    scaled = build(four_wheel(arrays, scale=TEN**length, speed=TEN**speed))
    assert signature(scaled) == signature(build(four_wheel(arrays)))


@pytest.mark.parametrize("side", [Fraction(1, 5), Fraction(1)], ids=["one fifth", "one"])
@pytest.mark.parametrize("exponent", [-300, -17])
def test_a_wheel_that_is_hardly_off_the_circle(arrays: Arrays, exponent: int, side: Fraction) -> None:
    """What no float tells from a tie is told apart: the cells are those of an offset that floats see."""
    for build in BUILDERS.values():
        near = build(four_wheel(arrays, off=TEN**exponent, side=side))
        assert signature(near) == signature(build(four_wheel(arrays, off=TEN**-9, side=side)))


def test_quotients_of_numbers_beyond_floats() -> None:
    field = NumberField()
    small, large = field(TEN**-400), field(TEN**400)
    for numerator, denominator in ((small, small * 3), (large, large * 3)):
        lazy = Lazy.of(numerator) / Lazy.of(denominator)
        assert float(lazy) == 1 / 3
    root = field.sqrt(field(2))
    difference = Lazy(field, (Lazy.of(root) - Lazy.of(root)).ball, lambda: (small * root, large * 0 + small * 2))
    assert float(difference) == pytest.approx(2**0.5 / 2, rel=1e-15)


@pytest.mark.parametrize("length", ["1e-300", "1e150"])
def test_whole_checks(length: str, tmp_path: Path) -> None:
    """Every number of a check under rule ``box`` can be printed."""
    from nonsmooth.reports.checks.check import check_array

    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    places = [[f"{'-' * (a < 0)}{length}" for a in corner] for corner in corners]
    wheels = "\n".join(f'[[wheel]]\nposition = {place}\nheading = "inward"'.replace("'", '"') for place in places)
    path = tmp_path / "far.toml"
    path.write_text(f'{wheels}\n[friction]\nmu_roll = 1\nmu_side = "1/5"\n[contact]\nrule = "box"\n', encoding="utf-8")
    result, usual = check_array(load_scene(path)), check_array(load_scene("four-wheel", rule="box"))
    assert result.evidence.partition is not None
    assert {k: str(v.verdict) for k, v in result.evidence.results.items()} == {
        k: str(v.verdict) for k, v in usual.evidence.results.items()
    }
    assert result.views()
