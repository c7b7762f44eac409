"""Fields of arrays and of plain systems, in cells and by formulas."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.cell_complex import AtCorner, CellComplex, InCell, OnEdge
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, square
from nonsmooth.analysis.fields.constant_field import (
    array_field,
    feedback_field,
    flow_of,
    piecewise_constant,
    smooth_form,
)
from nonsmooth.analysis.fields.convex_weights import basic_weights, columns_of, least_mix, least_norm_weights
from nonsmooth.analysis.fields.feedback_laws import corrected_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import DegenerateSurfaceError, SignField
from nonsmooth.analysis.fields.switched_field import ScalarVelocity, affine_surface
from nonsmooth.analysis.fields.system_field import constant_system, system_field
from nonsmooth.analysis.trajectories import faces as faces_module
from nonsmooth.analysis.trajectories.faces import FaceMotion, face_choices
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.built_in import planar_systems
from tests.conftest import Arrays
from tests.hulls import hull_holds_zero
from tests.oracles.differences import STEP, smooth_surface

# ---- Cell complexes, the two kinds of switched fields, and small problems on convex hulls --------


def complex_of(partition: Partition) -> CellComplex:
    return partition.complex


def assert_is_a_complex(cells: CellComplex) -> None:
    """Euler's formula of a disc, and both sides of every edge where they are said to be."""
    assert len(cells.corners) - len(cells.edges) + len(cells.polygons) == 1
    for number, edge in enumerate(cells.edges):
        (x1, y1), (x2, y2) = cells.points[edge.start], cells.points[edge.end]
        middle = ((x1 + x2) / 2, (y1 + y2) / 2)
        assert cells.locate(middle) == OnEdge(number)
        holders = {k for k, polygon in enumerate(cells.polygons) if polygon.contains(middle)}
        assert holders == set(edge.cells)
        assert edge.left is None or sign(_turn((x1, y1), (x2, y2), cells.polygons[edge.left].centre)) > 0
        assert edge.right is None or sign(_turn((x1, y1), (x2, y2), cells.polygons[edge.right].centre)) < 0
    for number, corner in enumerate(cells.corners):
        assert cells.locate(corner.point) == AtCorner(number)
        holders = {k for k, polygon in enumerate(cells.polygons) if polygon.contains(corner.point)}
        assert holders == set(corner.cells)
    for number, polygon in enumerate(cells.polygons):
        assert cells.locate(polygon.centre) == InCell(number)


def _turn(p: Point, q: Point, r: Point) -> object:
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


@pytest.mark.parametrize("seed", range(12))
def test_cells_of_random_arrays_form_a_complex(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 3 + seed % 4)
    cells = complex_of(build_nearest_partition(scene))
    assert_is_a_complex(cells)
    rounded = cells.floats
    assert (rounded.edges, rounded.borders) == (cells.edges, cells.borders)
    for k, point in enumerate(rounded.points):
        assert rounded.locate(point) == AtCorner(k)


@pytest.mark.parametrize("side", [Fraction(1, 2), Fraction(1, 5)])
def test_cells_of_rule_box_form_a_complex(arrays: Arrays, side: Fraction) -> None:
    """A side of the rest cell meets several cells: it is cut where they meet."""
    assert_is_a_complex(complex_of(build_box_partition(arrays.four_wheel((1, side)))))


def test_nothing_lies_outside_the_domain(arrays: Arrays) -> None:
    cells = complex_of(build_nearest_partition(arrays.four_wheel()))
    assert cells.locate((Fraction(3, 4), Fraction(0))) is None
    assert cells.floats.locate((0.75, 0.0)) is None


def test_kinematics_differ_by_the_turning_term(arrays: Arrays) -> None:
    twist = build_nearest_partition(arrays.four_wheel()).cells[0].twists[0]
    one = twist.omega.field.one
    point = (one / 4, one / 3)
    assert flow_of(twist, Kinematics.EXACT).velocity(point) == twist.pose_rate(point)
    assert flow_of(twist, Kinematics.LEADING).velocity(point) == twist.velocity


def test_piecewise_constant_reads_floats_exactly() -> None:
    domain = square((Fraction(0), Fraction(0)), Fraction(1))
    field = piecewise_constant(domain, [([HalfPlane((0.1, -1.0), 0.3)], (0.1, 0, 0))], exact=True)
    assert field.flows[0][0].vx == Fraction(0.1)
    with pytest.raises(ValueError, match="piece 1"):
        piecewise_constant(domain, [([HalfPlane((1, 0), -2)], (1, 0, 0))])
    with pytest.raises(ValueError, match="leading-order"):
        piecewise_constant(domain, [([], (1, 0, 0))], Kinematics.EXACT, exact=True)


def four_lines() -> SignField:
    normals = {"x": (1, 0), "y": (0, 1), "y - x": (-1, 1), "y + x": (1, 1)}
    surfaces = tuple(affine_surface(name, normal) for name, normal in normals.items())
    return SignField(("x", "y"), surfaces, lambda signs: lambda t, x: np.array(signs[:2], dtype=float))


def test_four_lines_through_one_point_give_eight_cells_and_eight_rays() -> None:
    faces = four_lines().faces_at(np.zeros(2))
    held = [len(face.keep) for face in faces]
    assert [held.count(k) for k in (0, 1, 4)] == [8, 8, 1]
    assert len(faces) == 17
    assert {len(face.members) for face in faces if len(face.keep) == 1} == {2}
    assert len(faces[0].members) == 8
    assert [len(face.keep) for face in four_lines().faces_at(np.array([0.3, 0.3]))] == [1, 0, 0]
    assert [len(face.keep) for face in four_lines().faces_at(np.array([0.3, 0.1]))] == [0]


def test_a_surface_without_gradient_is_refused_with_advice() -> None:
    surface = smooth_surface("y^2 - x^2", lambda x: float(x[1] ** 2 - x[0] ** 2))
    field = SignField(("x", "y"), (surface,), lambda signs: lambda t, x: -x)
    with pytest.raises(DegenerateSurfaceError, match="product of the signs of its factors"):
        field.faces_at(np.zeros(2))


def test_gradients_by_difference() -> None:
    surface = smooth_surface("h", lambda x: math.sin(x[0]) * x[1] ** 2)
    for point in np.random.default_rng(0).uniform(-2, 2, (20, 2)):
        x, y = point
        assert surface.gradient(point) == pytest.approx([math.cos(x) * y * y, 2 * math.sin(x) * y], abs=1e-9)


def test_faces_of_an_array_are_those_of_its_complex(arrays: Arrays) -> None:
    field = smooth_form(array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.EXACT))
    assert [len(face.keep) for face in field.faces_at(np.zeros(3))] == [2] + [1] * 8 + [0] * 8
    assert [face.name for face in field.faces_at(np.array([0.3, 0.3, 1.0]))] == ["cell 2 | cell 1", "cell 1", "cell 2"]
    assert field.on_border(np.array([0.5, 0.1, 0]))
    assert not field.on_border(np.array([0.4, 0.1, 0]))
    assert field.faces_at(np.array([0.6, 0.1, 0])) == []


def test_feedback_moves_the_body_by_its_control_fields(arrays: Arrays) -> None:
    """xi = g_i u_i + g_j u_j, written out for cell 1 of the four-wheel array (wheels 1 and 2)."""
    partition = build_nearest_partition(arrays.four_wheel())
    pose = np.array([0.1, 0.3, -0.2])
    state = partition.cells[0].states[0]
    columns = {wheel: np.array([float(v) for v in g]) for wheel, g in state.control_fields.items()}
    steer = 2 * 0.2 * np.sign(columns[2][2])
    twist = columns[1] * (abs(steer) + 2 * math.hypot(0.1, 0.3)) + columns[2] * steer
    for kinematics, turn in ((Kinematics.LEADING, 0.0), (Kinematics.EXACT, twist[2])):
        field = feedback_field(partition, corrected_law(2), kinematics)
        expected = twist + turn * np.array([-0.3, 0.1, 0])
        assert field.members[0].velocity(0, pose) == pytest.approx(expected, abs=1e-15)


def random_vectors(rng: np.random.Generator) -> NDArray[np.float64]:
    count, dimension = int(rng.integers(1, 9)), int(rng.integers(1, 4))
    return rng.integers(-2, 3, (count, dimension)).astype(float)


def test_about_half_of_the_random_hulls_hold_zero() -> None:
    assert sum(hull_holds_zero(random_vectors(np.random.default_rng(seed))) for seed in range(40)) == 27


@pytest.mark.parametrize("seed", range(40))
def test_basic_weights_against_linear_programs(seed: int) -> None:
    """They exist iff the hull holds zero, and they attain the extremes of any linear form over all solutions."""
    rng = np.random.default_rng(seed)
    vectors = random_vectors(rng)
    count, dimension = vectors.shape
    weights = basic_weights(columns_of(vectors))
    if not hull_holds_zero(vectors):
        assert not len(weights)
        return
    assert weights.min() >= 0
    assert weights.sum(axis=1) == pytest.approx(1)
    assert np.abs(weights @ vectors).max() <= 1e-12
    form = rng.normal(size=count)
    system, right = np.vstack([vectors.T, np.ones(count)]), np.append(np.zeros(dimension), 1)
    assert (weights @ form).min() == pytest.approx(linprog(form, A_eq=system, b_eq=right).fun, abs=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_the_point_of_least_norm(seed: int) -> None:
    """No vertex lies on the near side of the plane through it: v . p >= |p|^2."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(2, 7)), 3)) + 1
    weights = least_norm_weights(points)
    nearest = weights @ points
    assert weights.min() >= 0
    assert weights.sum() == pytest.approx(1)
    assert (points @ nearest >= nearest @ nearest - 1e-9).all()


def test_the_least_mix_of_two_is_exact() -> None:
    third = Fraction(1, 3)
    assert least_mix((Fraction(-1), third), (Fraction(2), third)) == Fraction(2, 3)
    assert least_mix((third, third), (third, third)) == Fraction(1, 2)
    assert least_mix((Fraction(1), third), (Fraction(2), third)) == 1


def test_the_patterns_at_a_point_are_those_with_states_beside_it() -> None:
    """Ten lines through a point: a pattern counts iff some direction has its signs, of very many that are tried."""
    angles = np.linspace(0.1, 3.0, 10)
    normals = [np.array([np.cos(a), np.sin(a)]) for a in angles]
    surfaces = tuple(affine_surface(f"s{k}", n.tolist()) for k, n in enumerate(normals))
    field = SignField(("x", "y"), surfaces, lambda signs: lambda t, x: np.zeros(2))
    turns = np.linspace(0, 2 * np.pi, 20_001)
    heights = np.stack([np.cos(turns), np.sin(turns)], axis=1) @ np.array(normals).T
    open_cones = {tuple(signs) for signs in np.sign(heights).astype(int).tolist() if 0 not in signs}
    faces = field.faces_at(np.zeros(2))
    cells = [tuple(side for _, side in face.bounds) for face in faces if not face.keep]
    assert len(cells) == 20
    assert set(cells) == open_cones
    assert [len(face.keep) for face in faces] == [10] + [1] * 20 + [0] * 20


def test_smoothed_fields_are_sums_over_all_patterns() -> None:
    """Products of ``(1 +- clip(h/width))/2`` over every pattern, those of weight zero left out."""
    field = four_lines()
    for x in (np.array([0.3, 0.1]), np.array([0.05, 0.02]), np.array([0.1, 0.1])):
        clipped = [float(np.clip(h / 0.1, -1, 1)) for h in field._heights(x)]
        literal = [
            float(np.prod([(1 + s * v) / 2 for s, v in zip(pattern, clipped, strict=True)]))
            for pattern in itertools.product((-1, 1), repeat=len(clipped))
        ]
        assert [weight for _, weight in field.blend(x, 0.1)] == [weight for weight in literal if weight]


# ---- Plain systems as fields to simulate: both forms agree with the formulas and with each other.

ROUNDING = 1e-14


ROOT_HALF = 0.5**0.5
LITERAL: dict[str, Callable[[float, float], tuple[float, float]]] = {
    "relay-oscillator": lambda x, y: (np.sign(y), -np.sign(x)),
    "relay-oscillator-damped": lambda x, y: (np.sign(y), -np.sign(x) - np.sign(y) / 2),
    "flower": lambda x, y: (-x / 10 + y, -5 * x - y / 10) if abs(x) >= abs(y) else (-x / 10 + 5 * y, -x - y / 10),
    "escaping-slide": lambda x, y: (-np.sign(x), 1.0),
    "line-of-equilibria": lambda x, y: (0.0, -np.sign(y)),
    "eq-3": lambda x, y: (
        -ROOT_HALF * np.sign(x) * (np.sign(y**2 - x**2) + 1),
        ROOT_HALF * np.sign(y) * (np.sign(y**2 - x**2) - 1),
    ),
    "eq-4": lambda x, y: (
        ROOT_HALF * np.sign(x) * (np.sign(y**2 - x**2) - 1),
        -ROOT_HALF * np.sign(y) * (np.sign(y**2 - x**2) + 1),
    ),
    "stick-slip": lambda x, v: (v, -5 / 6 - x - np.sign(v - 0.5) * (1 - abs(v - 0.5) / 3)),
}


@pytest.mark.parametrize("name", planar_systems())
def test_modes_are_the_formulas_off_the_surfaces(name: str) -> None:
    field, rng = system_field(load_system(name)), np.random.default_rng(1)
    for x in rng.uniform(-0.5, 0.5, (40, 2)):
        assert field.flow(field.mode_at(x))(0.0, x) == pytest.approx(LITERAL[name](x[0], x[1]), abs=ROUNDING)


@pytest.mark.parametrize("surface", ["x + y/3", "x**2 + y - 1/4"], ids=("flat", "curved"))
def test_slides_in_single_floats_are_those_of_arrays(surface: str) -> None:
    field = system_field(ns.System(["x", "y"], [f"y - 2*sign({surface})", f"x*y - sign({surface})"]).system)
    for x in np.random.default_rng(3).uniform(-0.5, 0.5, 20):
        place = np.array([x, -3 * x if surface == "x + y/3" else 0.25 - x**2])
        motion = FaceMotion(field.faces_at(place)[0])
        velocity = motion.velocity
        assert motion.is_pair
        assert isinstance(velocity, ScalarVelocity)
        assert velocity(0.0, place) == pytest.approx(motion(0.0, place), abs=ROUNDING)
        assert float(motion.face.keep[0].normal(place) @ velocity(0.0, place)) == pytest.approx(0, abs=ROUNDING)


def test_crossings_taken_at_once_are_those_that_trials_find(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside them the places where the field slides, escapes or nearly touches, which trials decide in any case."""
    rhs = ["y - 2*sign(x + y/3) + x*sign(x - y)", "x*y - sign(x + y/3)/3 - sign(x - y)/2"]
    field, crossings = system_field(ns.System(["x", "y"], rhs).system), 0
    for x in np.random.default_rng(4).uniform(-1, 1, 60):
        for place in (np.array([x, -3 * x]), np.array([x, x])):
            faces, at_once = field.faces_at(place), faces_module._crossing(field.faces_at(place), 0.0, place)
            with monkeypatch.context() as without:
                without.setattr(faces_module, "_crossing", lambda *_: None)
                tried = face_choices(field, faces, 0.0, place)
            if at_once is not None:
                crossings += 1
                assert [choice.motion.face for choice in tried] == [at_once.motion.face]
                assert (tried[0].sure, tried[0].free, tried[0].orders) == (at_once.sure, at_once.free, at_once.orders)
    assert 40 < crossings < 110


def test_written_polynomials_name_their_arguments_alone() -> None:
    """No word of a scene gets into the code that is compiled."""
    velocity = system_field(ns.System(["abs_x", "max_y"], ["max_y - abs_x**3/7", "-abs_x"]).system).flow(())
    assert isinstance(velocity, ScalarVelocity)
    assert velocity.rates.__code__.co_varnames == ("x0", "x1")
    assert velocity.rates.__code__.co_names == ()


def test_relays_may_ask_for_patterns_without_a_cell() -> None:
    """Beside the corner of eq. (4) hysteresis keeps x < 0 while |y| > |x| has changed: no cell, but a motion."""
    field = system_field(load_system("eq-4"))
    for signs in product((-1, 1), repeat=len(field.surfaces)):
        assert np.isfinite(field.flow(signs)(0.0, np.array([0.1, 0.2]))).all()


@pytest.mark.parametrize("power", [2, 16])  # the first is written out, the second has 1785 factors: too many for that
def test_polynomials_are_those_stated(power: int) -> None:
    velocity = system_field(ns.System(["x", "y"], [f"(x/2 + y + 1)**{power} - x", "y**2*x/3 - 3/7"]).system).flow(())
    for x, y in np.random.default_rng(power).uniform(-1, 1, (20, 2)):
        stated = ((x / 2 + y + 1) ** power - x, y**2 * x / 3 - 3 / 7)
        assert velocity(0.0, np.array([x, y])) == pytest.approx(stated, abs=1e-14 * 2.5**power)


@pytest.mark.parametrize("name", [name for name in planar_systems() if name not in {"flower", "stick-slip"}])
def test_constant_systems_have_closed_forms(name: str) -> None:
    scene = load_system(name)
    smooth, exact = system_field(scene), constant_system(scene)
    assert exact is not None
    for start in ((0.31, 0.17), (-0.05, 0.4), (0.2, -0.45)):
        end = simulate(exact, (*start, 0), 0.03).end
        assert simulate(smooth, start, float(end.t)).end.state == pytest.approx(
            [float(x) for x in end.state[:2]], abs=1e-11
        )


def test_linear_modes_have_none(tmp_path: Path) -> None:
    assert constant_system(load_system("flower")) is None
    (tmp_path / "my.toml").write_text('[system]\nstates = ["x", "y"]\nrhs = ["-sign(x**2 + y**2 - 1)", "0"]\n')
    assert constant_system(load_system(tmp_path / "my.toml")) is not None  # the curve lies outside the square


# ---- formulas in any number of states, read as Python would ----

POLYNOMIAL_ROUNDING = 1e-13  # of polynomials of degree three at states of size two
DIFFERENCE = 1e-8  # of central differences

FORMULAS: list[tuple[list[str], list[str], Callable[[Floats], list[float]]]] = [
    (["x"], ["-x*sign(x - 1)"], lambda s: [-s[0] * np.sign(s[0] - 1)]),
    (
        ["x", "v"],
        ["v", "-x - Abs(v)*v/2 - sign(x*v)"],
        lambda s: [s[1], -s[0] - abs(s[1]) * s[1] / 2 - np.sign(s[0] * s[1])],
    ),
    (
        ["x", "y", "z"],
        ["sign(x + Abs(y - z))", "x*y*z - sqrt(2)*sign(x**2 + y**2 - z)", "3"],
        lambda s: [
            np.sign(s[0] + abs(s[1] - s[2])),
            s[0] * s[1] * s[2] - np.sqrt(2) * np.sign(s[0] ** 2 + s[1] ** 2 - s[2]),
            3.0,
        ],
    ),
]


@pytest.mark.parametrize(("states", "rhs", "value"), FORMULAS)
def test_the_flow_of_the_mode_at_a_state_is_the_formula(
    states: list[str], rhs: list[str], value: Callable[[Floats], list[float]], tmp_path: Path
) -> None:
    file = tmp_path / "my.toml"
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n")
    field = system_field(load_system(file), [1.0] * len(states))
    rng = np.random.default_rng(7)
    for state in rng.uniform(-2, 2, (200, len(states))):
        found = field.flow(field.mode_at(state))(0.0, state)
        assert found == pytest.approx(value(state), abs=POLYNOMIAL_ROUNDING)
        for surface in field.surfaces:
            for k, slope in enumerate(surface.gradient(state)):
                step = STEP * np.eye(len(states))[k]
                change = (surface.value(state + step) - surface.value(state - step)) / (2 * STEP)
                assert slope == pytest.approx(change, abs=DIFFERENCE)


def test_the_size_of_the_states(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text('[system]\nstates = ["x"]\nrhs = ["sign(x)"]\n[check]\nradius = 3\n')
    equations = load_system(file)
    assert (system_field(equations, [0.0]).size, system_field(equations, [-5.0]).size) == (3.0, 5.0)
