"""Loads of wheels: of springs in floats, regions with the same signs, and sets of loads that are unknown."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from nonsmooth.analysis.cells.load_sets import AdmissibleLoads, LoadSet, SpringLoads, load_set
from nonsmooth.analysis.cells.loads import LoadError, LoadRegion, load_regions, require_support, value_at
from nonsmooth.analysis.cells.polygon import checked_square
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.float_loads import ON_HULL, _outside, elastic_loads, loads_at, table_loads
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.load_model import LoadScatter, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from tests.conftest import Arrays, WheelData
from tests.four_wheel import CORNERS
from tests.hulls import stands
from tests.oracles.floats import Floats
from tests.springs import pressed
from tests.thorough import few, keep

# ---- Normal forces in floats: against closed forms, two independent solvers and the exact regions.


ROUNDING = 1e-12  # of loads of order 1
CONE_PROGRAM = 1e-4  # Clarabel minimizes |N| to 1e-8, which leaves N its square root
FOUR = np.array(CORNERS, float)


def array(positions: Floats, table: Floats | None = None) -> ContactModel:
    """Only positions matter for loads."""
    return ContactModel.build(positions, np.ones_like(positions), np.ones(len(positions)), (1, 1), table)


def random_points(positions: Floats, rng: np.random.Generator, count: int) -> Floats:
    """Centres of mass inside the support polygon, many near its boundary, the wheels themselves among them."""
    weights = rng.dirichlet(np.full(len(positions), 0.2), size=count)
    points: Floats = np.concatenate([weights @ positions, positions])
    return points


def random_positions(rng: np.random.Generator) -> Floats:
    """Up to a dozen wheels, not collinear, on a lattice or free, in any unit and any aspect."""
    while True:
        count = int(rng.integers(3, 13))
        if rng.random() < 0.5:
            positions: Floats = np.unique(rng.integers(-2, 3, (count, 2)).astype(float), axis=0)
        else:
            positions = rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-3, 3, 2)
        if np.linalg.matrix_rank(positions - positions[0]) == 2:
            return positions


def unit_balance(positions: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Balance equations ``A N = b`` with orthonormal rows, so that units do not matter."""
    rows = np.column_stack([np.ones(len(positions)), positions])
    q, r = np.linalg.qr(rows)
    return q.T, np.linalg.solve(r.T, np.column_stack([np.ones(len(points)), points]).T).T


def test_four_wheels_closed_form() -> None:
    """``N_i = (1 + c . p_i)/4`` while no wheel lifts off: for ``|x| + |y| <= 1``."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.5, 0.5, (200, 2))
    np.testing.assert_allclose(elastic_loads(array(FOUR), points), (1 + points @ FOUR.T) / 4, atol=ROUNDING)


def test_a_wheel_lifts_off() -> None:
    """Beyond ``x + y = 1`` the wheel at (-1, -1) is idle and three wheels carry barycentric loads."""
    loads = elastic_loads(array(FOUR), [(0.75, 0.75)])[0]
    np.testing.assert_allclose(loads, [0.75, 0.125, 0, 0.125], atol=ROUNDING)
    assert loads[2] == 0


@pytest.mark.parametrize("seed", range(40))
def test_loads_balance_and_are_optimal(seed: int) -> None:
    """KKT: loaded wheels carry an affine function of position, which is not positive at idle ones."""
    rng = np.random.default_rng(seed)
    positions = random_positions(rng)
    points = random_points(positions, rng, 100)
    loads = elastic_loads(array(positions), points)
    assert (loads >= 0).all()
    rows, goals = unit_balance(positions, points)
    np.testing.assert_allclose(loads @ rows.T, goals, atol=ROUNDING)
    for load in loads:
        loaded = load > 0
        plane, *_ = np.linalg.lstsq(rows.T[loaded], load[loaded])
        np.testing.assert_allclose(rows.T[loaded] @ plane, load[loaded], atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_against_nonnegative_least_squares(seed: int) -> None:
    """NNLS with the balance weighted a million times; the loads it finds are right to 1e-6."""
    from scipy.optimize import nnls

    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(int(rng.integers(3, 10)), 2))
    points = random_points(positions, rng, 10)
    rows, goals = unit_balance(positions, points)
    for load, goal in zip(elastic_loads(array(positions), points), goals, strict=True):
        reference, _ = nnls(
            np.vstack([1e6 * rows, np.eye(len(positions))]), np.r_[1e6 * goal, np.zeros(len(positions))]
        )
        np.testing.assert_allclose(load, reference, atol=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_against_a_cone_program(seed: int) -> None:
    """The same minimum of |N|, by CVXPY."""
    import cvxpy as cp

    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(int(rng.integers(3, 10)), 2))
    points = random_points(positions, rng, 5)[:5]
    rows = np.column_stack([np.ones(len(positions)), positions]).T
    for load, point in zip(elastic_loads(array(positions), points), points, strict=True):
        forces, size = cp.Variable(len(positions), nonneg=True), cp.Variable()
        balance = rows @ forces == np.r_[1, point]
        cp.Problem(cp.Minimize(size), [cp.SOC(size, forces), balance]).solve(solver=cp.CLARABEL)
        np.testing.assert_allclose(load, np.asarray(forces.value), atol=CONE_PROGRAM)


@pytest.mark.parametrize("name", ["four-wheel", "rectangle", "elliptic", "grid-4x4", "off-center"])
def test_against_the_exact_regions(name: str) -> None:
    scene = load_scene(name, rule="box")
    model, rng = contact_model(scene), np.random.default_rng(0)
    for region in load_regions(scene):
        vertices = np.array([[float(x) for x in vertex] for vertex in region.polygon.vertices])
        points = rng.dirichlet(np.ones(len(vertices)), size=5) @ vertices
        forms = [(float(a), float(b), float(c)) for a, b, c in region.forces]
        exact = [[value_at(form, (x, y)) for form in forms] for x, y in points]
        np.testing.assert_allclose(elastic_loads(model, points), exact, atol=ROUNDING)


def test_hundreds_of_wheels() -> None:
    side = np.arange(15.0)
    positions = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    points = random_points(positions, np.random.default_rng(0), 50)[:60]
    rows, goals = unit_balance(positions, points)
    np.testing.assert_allclose(elastic_loads(array(positions), points) @ rows.T, goals, atol=ROUNDING)


def test_on_edge_and_wheel() -> None:
    """On an edge of the support polygon its two wheels carry everything, on a wheel this one."""
    loads = elastic_loads(array(FOUR), [(1, 0.5), (1, 1)])
    np.testing.assert_allclose(loads, [(0.75, 0, 0, 0.25), (1, 0, 0, 0)], atol=ROUNDING)


@pytest.mark.parametrize("point", [(1.01, 0), (0, -7), (np.nan, 0), (np.inf, 0)])
def test_outside_the_support_polygon(point: tuple[float, float]) -> None:
    with pytest.raises(LoadError, match=rf"inside the support polygon, received \({point[0]:g}, {point[1]:g}\)"):
        elastic_loads(array(FOUR), [(0, 0), point])


@pytest.mark.parametrize("positions", [[(0, 0), (1, 1)], [(0, 0), (1, 1), (2, 2)], [(0, 0), (1e-12, 0), (0, 1)]])
def test_collinear_wheels(positions: list[tuple[float, float]]) -> None:
    with pytest.raises(LoadError, match="not collinear"):
        elastic_loads(array(np.array(positions, float)), [(0.5, 0.5)])


def test_table() -> None:
    table = np.array([(0.25, x / 4, y / 4) for x, y in FOUR])
    model = array(FOUR, table)
    points = [(0.1, 0.2), (0.0, 0.5)]
    np.testing.assert_array_equal(loads_at(model, points), table_loads(model, points))
    np.testing.assert_allclose(loads_at(model, points), elastic_loads(model, points), atol=ROUNDING)


def test_table_of_a_scene() -> None:
    scene = load_scene("four-wheel")
    row = (scene.field(1) / 4, scene.field(0), scene.field(0))
    model = contact_model(replace(scene, contact=Contact("box", LoadTable((row,) * 4))))
    np.testing.assert_array_equal(loads_at(model, [(5, -3)]), [[0.25] * 4])


def test_table_with_a_negative_load() -> None:
    model = array(FOUR, np.array([(0.25, x / 4, y / 4) for x, y in FOUR]))
    with pytest.raises(LoadError, match=r"received -0\.25 of wheel 3 at \(1, 1\)"):
        loads_at(model, [(0, 0), (1, 1)])


def test_no_table() -> None:
    with pytest.raises(LoadError, match="load table"):
        table_loads(array(FOUR), [(0, 0)])


def test_hull_of_floats_as_qhull_finds_it() -> None:
    """Which places lie outside, for wheels anywhere, in rows, and turned by an angle."""
    rng = np.random.default_rng(3)
    turned = np.array([[0.6, 0.8], [-0.8, 0.6]])
    for count in (3, 4, 9, 200):
        for corners in (rng.normal(size=(count, 2)), rng.integers(-4, 5, size=(count + 9, 2)) @ turned):
            sides = ConvexHull(corners).equations
            places = np.vstack([rng.normal(size=(300, 2)) * 3, corners])
            beyond = (places @ sides[:, :2].T + sides[:, 2] > ON_HULL).any(axis=1)
            assert beyond.any()
            assert (_outside(corners, places) == beyond).all()


# ---- Sets of loads against a linear program, and against springs that are pressed one by one -----

OPTIMUM_ROUNDING = 1e-9


def random_array(arrays: Arrays, rng: np.random.Generator, wheels: int) -> Scene:
    """Wheels at random places of a lattice, some of them around the origin."""
    places = {(1, 1), (-2, 1), (0, -2)}
    while len(places) < wheels:
        x, y = (int(k) for k in rng.integers(-3, 4, 2))
        places.add((x, y))
    return arrays.scene([WheelData(place, (1, 0)) for place in sorted(places)], radius=Fraction(1, 16))


def with_loads(scene: Scene, height: Fraction | None = None, stiffness: Fraction = Fraction(0)) -> Scene:
    """The array with all admissible loads, or with scattered springs."""
    scatter = None if height is None else LoadScatter(scene.field(height), scene.field(stiffness))
    return replace(scene, contact=Contact("ellipse", UnknownLoads(scatter)))


def moments_of(scene: Scene) -> Floats:
    return np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])


def least_price(scene: Scene, prices: Floats) -> float:
    """By HiGHS, from the definition of admissible loads."""
    found = linprog(prices, A_eq=moments_of(scene).T, b_eq=[1, 0, 0], bounds=(0, None), method="highs")
    assert found.status == 0
    return float(found.fun)


def floats(loads: tuple[object, ...]) -> Floats:
    return np.array([float(load) for load in loads])  # type: ignore[arg-type]


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_vertices_are_admissible_and_reach_the_optima_of_linear_programs(arrays: Arrays, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(3, 9))))
    every = load_set(scene)
    assert every.bound is every.reached
    assert isinstance(every.bound, AdmissibleLoads)
    for vertex in (*every.bound.vertices, every.bound.middle):
        assert all(load >= 0 for load in vertex)
        assert sum(vertex) == 1
        for axis in (0, 1):
            assert not sum(n * w.position[axis] for n, w in zip(vertex, scene.wheels, strict=True))
    assert all(load > 0 for load in every.bound.middle)
    for _ in range(20):
        whole = rng.integers(-9, 10, len(scene.wheels))
        lowest = floats(every.bound.lowest([scene.field(int(k)) for k in whole]))
        assert lowest @ whole == pytest.approx(least_price(scene, whole.astype(float)), abs=OPTIMUM_ROUNDING)


@pytest.mark.parametrize(
    ("height", "stiffness"), [("1/10", "0"), ("0", "1/10"), ("1/5", "1/20"), ("1", "0"), ("4", "0")]
)
@pytest.mark.parametrize("seed", range(6))
def test_pressed_springs_stay_in_the_bound(arrays: Arrays, seed: int, height: str, stiffness: str) -> None:
    """Whatever the springs of a scatter do, lift-off included, their loads are in the set."""
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(4, 8))), Fraction(height), Fraction(stiffness))
    found, moments, count = load_set(scene), moments_of(scene), len(scene.wheels)
    prices = [rng.integers(-9, 10, count) for _ in range(10)]
    lowest = [floats(found.bound.lowest([scene.field(int(k)) for k in price])) @ price for price in prices]
    for _ in range(60):
        corner = rng.random() < 0.5
        heights, changes = rng.choice([-1.0, 1.0], (2, count)) if corner else rng.uniform(-1, 1, (2, count))
        stiff = 1 + changes * float(Fraction(stiffness))
        loads = pressed(moments, heights * float(Fraction(height)) / count, stiff)
        assert (loads >= floats(found.bound.least) - OPTIMUM_ROUNDING).all()
        assert (loads <= floats(found.bound.largest) + OPTIMUM_ROUNDING).all()
        assert all(loads @ price >= bound - OPTIMUM_ROUNDING for price, bound in zip(prices, lowest, strict=True))


def is_reached_by_springs(scene: Scene, loads: Floats, height: float, stiffness: float) -> bool:
    """Whether heights and stiffnesses of the scatter give these positive loads, for some pose y of the body.

    ``m_i . y - h_i = N_i/(1 + t_i)`` lies between ``N_i/(1 + s)`` and ``N_i/(1 - s)``: linear in y.
    """
    moments, reach = moments_of(scene), height / len(loads)
    upper, lower = (
        loads / (1 - stiffness) + reach + OPTIMUM_ROUNDING,
        loads / (1 + stiffness) - reach - OPTIMUM_ROUNDING,
    )
    rows, limits = np.vstack([moments, -moments]), np.concatenate([upper, -lower])
    found = linprog(np.zeros(3), A_ub=rows, b_ub=limits, bounds=(None, None), method="highs")
    return bool((loads > 0).all() and found.status == 0)


@pytest.mark.parametrize(("height", "stiffness"), [("1/10", "0"), ("0", "1/10"), ("1/5", "1/20"), ("3", "1/2")])
@pytest.mark.parametrize("seed", range(6))
def test_witnesses_are_loads_that_springs_reach(arrays: Arrays, seed: int, height: str, stiffness: str) -> None:
    rng = np.random.default_rng(seed)
    scene = with_loads(random_array(arrays, rng, int(rng.integers(4, 8))), Fraction(height), Fraction(stiffness))
    reached = load_set(scene).reached
    loads = [reached.middle]
    loads += [reached.lowest([scene.field(int(k)) for k in rng.integers(-9, 10, len(scene.wheels))]) for _ in range(8)]
    springs = isinstance(reached, SpringLoads) and bool(reached.generators)
    for load in loads if springs else ():
        assert is_reached_by_springs(scene, floats(load), float(Fraction(height)), float(Fraction(stiffness)))


def test_loads_after_lift_off_leave_the_cut_zonotope(arrays: Arrays) -> None:
    """The zonotope of linear loads, cut at N >= 0, is no bound there: all admissible loads are taken instead."""
    fifth = Fraction(1, 5)
    places = [(2 * fifth, 2 * fifth), (-8 * fifth, 2 * fifth), (-8 * fifth, -8 * fifth), (2 * fifth, -8 * fifth)]
    scene = with_loads(arrays.scene([WheelData(p, (1, 0)) for p in places], radius=fifth), Fraction(1, 10))
    found, moments = load_set(scene), moments_of(scene)
    assert found.remark
    assert isinstance(found.bound, AdmissibleLoads)
    projection = np.eye(4) - moments @ np.linalg.pinv(moments)
    reach = np.abs(projection).sum(axis=1) / 40
    linear = moments @ np.linalg.solve(moments.T @ moments, [1, 0, 0])
    rng = np.random.default_rng(0)
    for _ in range(20):
        loads = pressed(moments, rng.choice([-1.0, 1.0], 4) / 40, np.ones(4))
        assert (np.abs(loads - linear) > reach + OPTIMUM_ROUNDING).any()
        assert loads.min() > -OPTIMUM_ROUNDING


def test_small_scatter_lifts_no_wheel(arrays: Arrays) -> None:
    scene = with_loads(arrays.four_wheel(), Fraction(1, 10))
    found = load_set(scene)
    assert (found.bound, found.remark) == (found.reached, "")
    assert [str(n) for n in found.bound.least] == ["9/40"] * 4
    assert [str(n) for n in found.bound.largest] == ["11/40"] * 4


def test_sets_exist_inside_the_support_polygon_only(arrays: Arrays) -> None:
    with pytest.raises(LoadError, match="support polygon"):
        load_set(with_loads(arrays.four_wheel(radius=Fraction(11, 10))))
    line = arrays.scene([WheelData((k, 0), (1, 0)) for k in (-1, 0, 1)])
    with pytest.raises(LoadError, match="collinear"):
        load_set(with_loads(line))


def test_known_loads_are_no_set(arrays: Arrays) -> None:
    with pytest.raises(TypeError, match="unknown loads"):
        load_set(arrays.four_wheel())


def test_many_wheels_are_refused_in_one_line(arrays: Arrays) -> None:
    places = [(x, y) for x in range(-4, 4) for y in range(-4, 4)]
    scene = with_loads(arrays.scene([WheelData(place, (1, 0)) for place in places]))
    with pytest.raises(LoadError, match="at most 50 wheels"):
        load_set(scene)


def test_a_set_is_a_bound_and_what_is_reached(arrays: Arrays) -> None:
    """With stiffnesses the bound is wider than what is surely reached; at both, springs carry everywhere."""
    scene = with_loads(random_array(arrays, np.random.default_rng(3), 6), Fraction(1, 20), Fraction(1, 20))
    found: LoadSet = load_set(scene)
    assert (floats(found.bound.largest) >= floats(found.reached.largest)).all()


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
        tips = r"check\.(radius: required .* the body tips|equilibrium: required a point inside the support polygon)"
        with pytest.raises(LoadError, match=tips):
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
    with pytest.raises(LoadError, match=r"check.radius: required at most 1, received 11/10: measured .*, at .* tips"):
        load_regions(arrays.four_wheel(radius=Fraction(11, 10)))


def test_the_largest_radius_is_said_once(tmp_path: Path) -> None:
    """Its exact form is too long for the line: it is told in digits alone."""
    places = ["sqrt(2)", 0], ["-1/7", "sqrt(3)"], [-1, "-sqrt(5)/2"]
    wheels = ", ".join(f"{{ position = {json.dumps(place)} }}" for place in places)
    (tmp_path / "roots.toml").write_text(f"friction = {{ mu_roll = 1, mu_side = 1 }}\nwheel = [{wheels}]\n")
    with pytest.raises(LoadError) as refused:
        load_regions(load_scene(tmp_path / "roots.toml", radius="3"))
    ((said, told),) = re.findall(r"required at most (~?)([0-9.]+), received 3: ", str(refused.value))
    assert said == "~"
    corners = [np.array(corner) for corner in ((2**0.5, 0.0), (-1 / 7, 3**0.5), (-1.0, -(5**0.5) / 2))]
    rooms = []  # how far a square may reach before a corner of it is on the line through two wheels
    for corner, following in zip(corners, corners[1:] + corners[:1], strict=True):
        along = following - corner
        rooms.append(abs(along[0] * corner[1] - along[1] * corner[0]) / np.abs(along).sum())
    assert float(told) == pytest.approx(min(rooms), abs=1e-6)


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


def test_a_point_at_which_the_body_tips_is_told_as_such() -> None:
    """It was the radius that was refused, and places were those of a plane that had been moved, without a word."""
    scene = load_scene("off-center", rule="ellipse", at="5,1").recentred()
    with pytest.raises(LoadError, match=r"^check.equilibrium: required a point inside.*measured from it"):
        require_support(scene, checked_square(scene))
    near = load_scene("off-center", rule="ellipse", at="1/4,1/4", radius="9")
    for seen in (near, near.recentred()):
        with pytest.raises(LoadError, match=r"from the checked point, at \(-9, -9\) the body tips.*polygon \(-"):
            require_support(seen, checked_square(seen))
