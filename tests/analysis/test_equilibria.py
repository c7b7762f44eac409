from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace, find_equilibria, shared_sides
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.hulls import hull_holds_zero
from tests.thorough import few, keep


def holds_zero(partition: Partition, point: Point) -> bool:
    """0 in the hull of the velocities at a point, by an independent linear program."""
    return hull_holds_zero(t.pose_rate(point) for cell in partition.cells_at(point) for t in cell.twists)


def places(found: tuple[RestPlace, ...]) -> set[tuple[str, frozenset[tuple[str, str]]]]:
    return {(str(e.place), frozenset((str(x), str(y)) for x, y in e.points)) for e in found}


def test_four_wheel_rests_at_the_origin_alone(arrays: Arrays) -> None:
    found = find_equilibria(build_nearest_partition(arrays.four_wheel()))
    assert places(found) == {("vertex", frozenset({("0", "0")}))}


def test_with_side_friction_first_both_axes_are_equilibria(arrays: Arrays) -> None:
    found = find_equilibria(build_nearest_partition(arrays.four_wheel(SIDE)))
    ends = [("1/2", "0"), ("-1/2", "0"), ("0", "1/2"), ("0", "-1/2")]
    assert places(found) == {("segment", frozenset({("0", "0"), end})) for end in ends}


def test_the_rest_area_of_rule_box_is_one_diamond(arrays: Arrays) -> None:
    (area,) = find_equilibria(build_box_partition(arrays.four_wheel((1, Fraction(1, 5)))))
    assert area.place is EquilibriumPlace.AREA
    assert {(str(x), str(y)) for x, y in area.points} == {("1/5", "0"), ("-1/5", "0"), ("0", "1/5"), ("0", "-1/5")}


def test_a_shifted_array_has_its_equilibrium_where_the_array_is(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    shift = (scene.field(1) / 4, scene.field(1) / 8)
    wheels = tuple(replace(w, position=(w.position[0] + shift[0], w.position[1] + shift[1])) for w in scene.wheels)
    (found,) = find_equilibria(build_nearest_partition(replace(scene, wheels=wheels)))
    assert found.points == (shift,)


def test_a_cell_may_turn_about_a_point_of_its_own(arrays: Arrays) -> None:
    """Three tangential rims: every cell turns about the origin, which all of them share."""
    scene = arrays.scene(arrays.inward([(1, 0), (-1, 0), (0, 1), (0, -1)], turn=(0, 1)), friction=(1, Fraction(1, 10)))
    found = find_equilibria(build_box_partition(replace(scene, check=replace(scene.check, radius=scene.field(1) / 4))))
    assert (str(EquilibriumPlace.CENTRE), frozenset({("0", "0")})) in places(found)


@pytest.mark.parametrize("count", keep(1, [100, 300]))
def test_motions_that_tie_in_a_cell_may_cancel_along_a_line_or_everywhere(arrays: Arrays, count: int) -> None:
    """Isotropic friction leaves two twists per cell; where they oppose each other the body may rest."""
    partition = build_nearest_partition(arrays.four_wheel((1, 1)))
    for equilibrium in find_equilibria(partition):
        n = len(equilibrium.points)
        assert holds_zero(partition, tuple(sum(p[k] for p in equilibrium.points) / n for k in (0, 1)))
    scanned = np.random.default_rng(0).uniform(-0.5, 0.5, (count, 2))
    areas = [e for e in find_equilibria(partition) if e.place is EquilibriumPlace.AREA]
    assert not areas
    assert not any(holds_zero(partition, (Fraction(x), Fraction(y))) for x, y in scanned)


@few(1)
@pytest.mark.parametrize("seed", range(20))
def test_every_equilibrium_of_a_random_array_is_one_and_none_is_missed(arrays: Arrays, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = arrays.random(seed, int(rng.integers(3, 7)))
    partition = build_nearest_partition(scene)
    found = find_equilibria(partition)
    for equilibrium in found:
        n = len(equilibrium.points)
        middle = (sum(p[0] for p in equilibrium.points) / n, sum(p[1] for p in equilibrium.points) / n)
        assert holds_zero(partition, middle)
    isolated = {p for e in found if len(e.points) == 1 for p in e.points}
    segments = [e for e in found if len(e.points) > 1]
    for cell in partition.cells:
        for vertex in cell.polygon.vertices:
            known = vertex in isolated or any(vertex in e.points or _on(e, vertex) for e in segments)
            assert known == holds_zero(partition, vertex)


def _on(equilibrium: RestPlace, point: Point) -> bool:
    (x1, y1), (x2, y2) = equilibrium.points[0], equilibrium.points[-1]
    ax, ay, bx, by = point[0] - x1, point[1] - y1, point[0] - x2, point[1] - y2
    return bool(ax * by == ay * bx and ax * bx + ay * by <= 0)


def opposed_rates(first: Twist, second: Twist, point: np.ndarray) -> tuple[float, float]:
    """Cross and inner product of two velocities, in floats."""
    u, v = ([float(w.vx) - float(w.omega) * point[1], float(w.vy) + float(w.omega) * point[0]] for w in (first, second))
    return u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]


@pytest.mark.parametrize("seed", range(20))
def test_equilibria_on_sides_against_a_scan(arrays: Arrays, seed: int) -> None:
    """Where two velocities become parallel along a side, the point is listed iff they oppose each other."""
    rng = np.random.default_rng(seed)
    scene = arrays.with_friction(arrays.random(seed, int(rng.integers(3, 7))), ROLL)
    partition = build_nearest_partition(scene)
    found = [
        np.array([float(x) for x in e.points[0]])
        for e in find_equilibria(partition)
        if e.place is EquilibriumPlace.SIDE
    ]
    crossings = opposed = 0
    for side in shared_sides(partition):
        a, b = side.first.twists[0], side.second.twists[0]
        start, end = (np.array([float(x) for x in p]) for p in (side.start, side.end))
        at_start, at_end = (opposed_rates(a, b, p)[0] for p in (start, end))
        if at_start * at_end >= 0 or max(abs(at_start), abs(at_end)) < 1e-9:  # no zero between, or zero throughout
            continue
        crossings += 1
        point = start + (end - start) * at_start / (at_start - at_end)
        cross, product = opposed_rates(a, b, point)
        assert abs(cross) < 1e-9 * max(1, abs(at_start), abs(at_end))  # linear along the side
        assert any(np.hypot(*(point - p)) < 1e-9 for p in found) == (product < 0)
        opposed += product < 0
    assert crossings > 0
    assert opposed == len(found)


# ---- verdicts of their own -----------------------------------------------------------------------


def test_each_isolated_equilibrium_is_judged_about_its_own_point(arrays: Arrays) -> None:
    """Checked beside its middle, the four-wheel array has its one equilibrium where a direct check has it."""
    scene = arrays.four_wheel()
    beside = replace(scene, check=replace(scene.check, equilibrium=(scene.field(1) / 8, scene.field(1) / 16)))
    (other,) = check_cells(beside).others or ()
    direct = check_cells(scene)
    assert other.found.points == ((-scene.field(1) / 8, -scene.field(1) / 16),)
    assert (other.translation, other.rotation) == (direct.translation.verdict, direct.rotation.verdict)


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_judged_verdicts_equal_a_check_at_the_point(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 5)
    isolated = [judged for judged in check_cells(scene).others or () if judged.translation is not None]
    assert isolated
    for judged in isolated:
        x, y = judged.found.points[0]
        at = (scene.check.equilibrium[0] + x, scene.check.equilibrium[1] + y)
        there = check_cells(replace(scene, check=replace(scene.check, equilibrium=at)))
        assert (judged.translation, judged.rotation) == (there.translation.verdict, there.rotation.verdict)


# ---- the border of the square ---------------------------------------------------------------------


def beside_the_point(scene: Scene, x: Fraction, y: Fraction, radius: Fraction) -> Scene:
    """The array checked at (x, y) on a square of a half-width."""
    at = (scene.field.zero + x, scene.field.zero + y)
    return replace(scene, check=replace(scene.check, equilibrium=at, radius=scene.field(1) * radius))


@pytest.mark.parametrize(("x", "y"), [(1, 1), (1, -1), (-1, 1), (1, 0), (0, -1), (1, Fraction(1, 3))])
def test_an_equilibrium_on_the_border_is_found_whatever_the_radius(arrays: Arrays, x: Fraction, y: Fraction) -> None:
    """The middle of the four-wheel array at a corner, or on a side, of the square, and well inside a larger one."""
    scene, quarter = arrays.four_wheel(), Fraction(1, 4)
    for radius in (quarter, quarter * Fraction(5, 4)):
        checked = check_cells(beside_the_point(scene, x * quarter, y * quarter, radius))
        (other,) = checked.others or ()
        assert other.found.points == ((scene.field.zero - x * quarter, scene.field.zero - y * quarter),)
        assert other.translation is Translation.ASYMPTOTICALLY_STABLE


@few(3)
@pytest.mark.parametrize(("x", "y"), [(1, 1), (-1, 1), (1, 0), (0, 1), (1, Fraction(1, 2))])
def test_equilibria_along_the_border_are_those_of_the_plane(arrays: Arrays, x: Fraction, y: Fraction) -> None:
    """With side friction first both axes rest: sides of the square may lie on them.  By the hull on a larger square."""
    quarter = Fraction(1, 4)
    scene = beside_the_point(arrays.four_wheel(SIDE), x * quarter, y * quarter, quarter).recentred()
    large = build_nearest_partition(replace(scene, check=replace(scene.check, radius=scene.field(1) / 2)))
    listed = [judged.found for judged in check_cells(scene).others or ()]
    seen = 0
    for share in (Fraction(k, 8) for k in range(-8, 9)):
        for own in ((1, share), (-1, share), (share, 1), (share, -1)):
            point = (scene.field.zero + quarter * own[0], scene.field.zero + quarter * own[1])
            known = any(point in e.points or (len(e.points) > 1 and _on(e, point)) for e in listed)
            assert known == holds_zero(large, point)
            seen += known
    assert seen
