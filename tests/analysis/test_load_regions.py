from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.loads import LoadError, LoadRegion, load_regions, value_at
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.float_loads import elastic_loads
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from tests.conftest import Arrays
from tests.hulls import stands
from tests.thorough import few, keep

SEEDS = range(40)
MOST_CORNERS = 4, 12  # or some more, evenly over those of one array: some have a hundred, a tenth of a second each


def check_optimality(scene: Scene, region: LoadRegion, point: tuple[Fraction, Fraction]) -> None:
    """The KKT conditions of min |N|^2: balance, no tension, N = m . y on loaded wheels and m . y <= 0 elsewhere."""
    x, y = (scene.field(value) for value in point)
    loads = [value_at(form, (x, y)) for form in region.forces]
    assert all(load >= 0 for load in loads)
    assert sum(loads) == 1
    assert sum(n * w.position[0] for n, w in zip(loads, scene.wheels, strict=True)) == x
    assert sum(n * w.position[1] for n, w in zip(loads, scene.wheels, strict=True)) == y
    rows = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    loaded = [wheel.index in region.loaded for wheel in scene.wheels]
    multiplier, _, _, _ = np.linalg.lstsq(rows[loaded], [float(n) for n in np.array(loads)[loaded]], rcond=None)
    assert np.abs(rows[loaded] @ multiplier - [float(n) for n in np.array(loads)[loaded]]).max() < 1e-12
    assert (rows[~np.array(loaded)] @ multiplier <= 1e-12).all()


@pytest.mark.parametrize("radius", [Fraction(1, 2), Fraction(3, 4), Fraction(1)])
def test_four_wheel_loads_split_the_square_where_a_wheel_lifts_off(arrays: Arrays, radius: Fraction) -> None:
    scene = arrays.four_wheel(radius=radius)
    regions = load_regions(scene)
    assert len(regions) == (1 if radius == Fraction(1, 2) else 5)
    assert sum(region.polygon.area for region in regions) == (2 * radius) ** 2
    inner = next(region for region in regions if len(region.loaded) == 4)
    quarter = Fraction(1, 4)
    for form, wheel in zip(inner.forces, scene.wheels, strict=True):
        assert form == (quarter, wheel.position[0] * quarter, wheel.position[1] * quarter)


def random_scene(arrays: Arrays, seed: int) -> Scene:
    scene = arrays.random(seed, int(np.random.default_rng(seed).integers(4, 10)))
    return replace(scene, check=replace(scene.check, radius=scene.field(1) / 8))


@pytest.mark.parametrize("seed", SEEDS)
def test_loads_are_optimal_in_every_region_and_refused_where_the_body_tips(arrays: Arrays, seed: int) -> None:
    scene, rng = random_scene(arrays, seed), np.random.default_rng(seed)
    if not stands(scene):
        with pytest.raises(LoadError, match=r"check\.radius: required .* the body tips"):
            load_regions(scene)
        return
    regions = load_regions(scene)
    assert sum(region.polygon.area for region in regions) == (2 * scene.check.radius) ** 2
    for region in regions:
        x, y = arrays.interior_point(region.polygon, rng)
        check_optimality(scene, region, (Fraction(str(x)), Fraction(str(y))))


def test_most_random_arrays_stand_and_many_lose_contact_somewhere(arrays: Arrays) -> None:
    standing = [scene for seed in SEEDS if stands(scene := random_scene(arrays, seed))]
    assert len(standing) == 29
    assert sum(len(load_regions(scene)) > 1 for scene in standing) == 17


@pytest.mark.parametrize("seed", SEEDS)
def test_the_regions_that_hold_a_point_are_found_without_the_others(arrays: Arrays, seed: int) -> None:
    scene = random_scene(arrays, seed)
    if not stands(scene):
        return
    regions = load_regions(scene)
    corners = {vertex for region in regions for vertex in region.polygon.vertices}
    for point in [scene.check.equilibrium, *corners]:
        found = load_regions(scene, point)
        expected = [region for region in regions if region.polygon.contains(point)]
        assert len(found) == len(expected)
        assert {region.loaded for region in found} == {region.loaded for region in expected}


def test_a_body_that_would_tip_is_refused_with_the_largest_radius(arrays: Arrays) -> None:
    with pytest.raises(LoadError, match=r"check.radius: required at most 1, received 11/10: at .* tips"):
        load_regions(arrays.four_wheel(radius=Fraction(11, 10)))


def test_collinear_wheels_are_refused(arrays: Arrays) -> None:
    scene = arrays.scene(arrays.inward([(1, 1), (2, 2), (-1, -1)]))
    with pytest.raises(LoadError, match="collinear"):
        load_regions(scene)


def test_a_table_of_loads_is_taken_as_it_is_and_may_not_be_negative(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    quarter, zero = scene.field(1) / 4, scene.field.zero
    table = LoadTable(((quarter, zero, zero),) * 4)
    given = replace(scene, contact=Contact("box", table))
    (region,) = load_regions(given)
    assert region.forces == table.rows
    bad = LoadTable(((quarter, quarter * 4, zero), *table.rows[1:]))
    with pytest.raises(LoadError, match=r"negative load of wheel 1 at \(-1/2"):
        load_regions(replace(scene, contact=Contact("box", bad)))


@few(1)
@pytest.mark.parametrize("most", keep(1, MOST_CORNERS))
@pytest.mark.parametrize("seed", [38, 8, 18, 31, 50, 58, 66, 70])
def test_a_line_of_wheels_that_takes_the_whole_load_is_crossed(arrays: Arrays, seed: int, most: int) -> None:
    """Several wheels change at once there: the body tilts about the line until others touch."""
    scene, rng = arrays.cocircular(seed), np.random.default_rng(seed)
    regions = load_regions(scene)
    assert sum(region.polygon.area for region in regions) == (2 * scene.check.radius) ** 2
    for region in regions:
        x, y = arrays.interior_point(region.polygon, rng)
        check_optimality(scene, region, (Fraction(str(x)), Fraction(str(y))))
    alone = [one.loaded ^ other.loaded for one in regions for other in regions if one is not other]
    assert max(map(len, alone)) > 1
    corners = list(dict.fromkeys(vertex for region in regions for vertex in region.polygon.vertices))
    for corner in corners[:: max(1, len(corners) // most)]:
        here = load_regions(scene, corner)
        assert {region.loaded for region in here} == {r.loaded for r in regions if r.polygon.contains(corner)}


@few(1)
@pytest.mark.parametrize("seed", [38, 8, 18, 31])
def test_loads_beside_such_a_line_are_those_of_floats(arrays: Arrays, seed: int) -> None:
    scene, rng = arrays.cocircular(seed), np.random.default_rng(seed)
    for region in load_regions(scene):
        x, y = (Fraction(str(entry)) for entry in arrays.interior_point(region.polygon, rng))
        exact = [float(value_at(form, (scene.field(x), scene.field(y)))) for form in region.forces]
        floats = elastic_loads(contact_model(scene), [float(x), float(y)])[0]
        np.testing.assert_allclose(floats, exact, atol=1e-9)
