"""Normal forces in floats: against closed forms, two independent solvers and the exact regions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from nonsmooth.analysis.cells.loads import LoadError, load_regions, value_at
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.float_loads import ON_HULL, _outside, elastic_loads, loads_at, table_loads
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable
from tests.four_wheel import CORNERS

Floats = NDArray[np.float64]

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
