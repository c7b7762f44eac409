from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.minimizers.agreement import compare_rules, comparison_grid, intersect, shared_area
from nonsmooth.analysis.minimizers.point_location import OUTSIDE, PointLocator
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.conftest import Arrays


@pytest.mark.parametrize("side", [Fraction(1, 2), Fraction(1, 5), Fraction(1, 100)])
def test_share_of_equal_twists_on_four_wheel(arrays: Arrays, side: Fraction) -> None:
    scene = arrays.four_wheel((1, side))
    shared = shared_area(build_nearest_partition(scene), build_box_partition(scene))
    assert shared.share == max(0, 1 - 2 * side)
    assert len(shared.shared_twists) == (8 if side < Fraction(1, 2) else 0)


def test_a_partition_agrees_with_itself_everywhere(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.ring(5))
    assert shared_area(partition, partition).share == 1


def test_share_against_counting_points(arrays: Arrays) -> None:
    scene = arrays.ring(6, (1, Fraction(1, 20)), Fraction(1, 4))
    first, second = build_nearest_partition(scene), build_box_partition(scene)
    points = np.random.default_rng(0).uniform(-0.25, 0.25, (40_000, 2))
    same = np.abs(PointLocator(first).twists(points) - PointLocator(second).twists(points)).max(axis=1) < 1e-12
    # 40,000 points: the share's standard error is below 0.0025
    assert abs(same.mean() - float(shared_area(first, second).share)) < 0.01


def test_points_are_located_in_the_cell_that_holds_them(arrays: Arrays) -> None:
    rng = np.random.default_rng(3)
    scene = arrays.grid(4, 4, (1, Fraction(1, 5)))
    partition = build_box_partition(scene)
    inside = [arrays.interior_point(cell.polygon, rng) for cell in partition.cells]
    points = np.array([[float(x), float(y)] for x, y in inside])
    assert PointLocator(partition).locate(points).tolist() == list(range(len(inside)))
    assert PointLocator(partition).locate(np.array([[9.0, 9.0]])).tolist() == [OUTSIDE]
    assert np.isnan(PointLocator(partition).twists(np.array([[9.0, 9.0]]))).all()


@pytest.mark.parametrize("name", ["four-wheel", "grid-4x4"])
def test_points_in_buckets_are_located_as_points_one_by_one(name: str) -> None:
    locator = PointLocator(build_box_partition(load_scene(name, rule="box")))
    reach = float(locator.partition.scene.check.radius)
    many = np.random.default_rng(0).uniform(-1.2 * reach, 1.2 * reach, (20_000, 2))
    many[:4] = [(reach, reach), (-reach, -reach), (np.nan, 0), (1e9, -1e9)]
    few = np.concatenate([locator.locate(points) for points in np.array_split(many, 20)])
    found = locator.locate(many)
    assert found.tolist() == few.tolist()
    inside = np.abs(many).max(axis=1) <= reach
    assert (found[inside] != OUTSIDE).all()
    assert (found[~inside] == OUTSIDE).all()


def test_disjoint_polygons_have_no_intersection(arrays: Arrays) -> None:
    cells = build_nearest_partition(arrays.four_wheel()).cells
    assert intersect(cells[0].polygon, cells[1].polygon) is None
    assert intersect(cells[0].polygon, cells[0].polygon) == cells[0].polygon


def test_the_three_rules_side_by_side(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 100)))
    agreement = compare_rules(scene)
    assert agreement.shared["nearest", "box"].share == Fraction(49, 50)
    # on the grid, whose points lie in the cells in the same shares, box and nearest differ on about 2 %
    points = comparison_grid(scene)
    near, box = (PointLocator(p).twists(points) for p in agreement.partitions.values())
    assert (np.abs(near - box).max(axis=1) > 1e-12).mean() == pytest.approx(1 / 50, abs=0.02)
    assert agreement.differences["ellipse", "box"].mean is not None
    assert agreement.differences["ellipse", "box"].largest is not None
    assert 0 < agreement.differences["ellipse", "box"].mean <= agreement.differences["ellipse", "box"].largest <= 2


def test_rules_agree_where_all_wheels_carry_the_body(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tangential rims of one speed: every rule gives the same rotation everywhere."""
    monkeypatch.setattr("nonsmooth.analysis.minimizers.agreement.GRID", 12)
    agreement = compare_rules(load_scene("conveyor-3"))
    assert agreement.shared["nearest", "box"].share == 1
    for difference in agreement.differences.values():
        assert difference.largest is not None
        assert difference.largest < 1e-6
