"""Clause 4: the discontinuous law, the points where it fails, and the arrays it does not speak of."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import Descent
from nonsmooth.proofs.clauses.feedback.control_fields import InputCell
from nonsmooth.proofs.clauses.feedback.control_lyapunov import SQUARES
from nonsmooth.proofs.findings.verdicts import Feedback
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.mechanics.constraints import RowKind
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import dot, turned
from tests.conftest import HALF, Arrays, WheelData
from tests.four_wheel import CORNERS, ROLL, SIDE
from tests.thorough import thorough

Rational: TypeAlias = int | Fraction

SEEDS = range(40)
ANGLES = 3000
# Smallest singular value of a 2 x 2 matrix with entries of order 1: rounding 1e-15; where the criterion holds it stays
# above the smallest |c . d_i| on the cone, and rational directions of small height keep that above 1e-3.
ZERO = 1e-9


@lru_cache(maxsize=len(SEEDS))
def cocircular(seed: int) -> Scene:
    return Arrays().cocircular(seed, ROLL)


@lru_cache(maxsize=len(SEEDS))
def decide(scene: Scene) -> FeedbackResult:
    return decide_feedback(build_nearest_partition(scene.recentred()))


def local_cells(result: FeedbackResult, scene: Scene) -> list[InputCell]:
    zero = scene.field.zero
    return [data for data in result.cells if data.cell.polygon.contains((zero, zero))]


# ---- the law, from the control vector fields -----------------------------------------------------


def law_coefficients(data: InputCell, point: tuple[Number, Number], theta: Number) -> tuple[Number, Number]:
    """(a, b) as the module's text states them, with unit rim directions."""
    p, q = data.nearest.position, data.second.position
    d, e = data.nearest.unit_direction, data.second.unit_direction
    lever = dot(e, turned((q[0] - p[0], q[1] - p[1])))
    b = (theta - dot(point, turned(p))) / lever
    return dot(point, d) - dot(d, e) * b, b


@thorough  # about all random cases, which `make bench` runs
def test_both_verdicts_occur_among_the_random_arrays_and_nearly_all_cells_have_a_lever(arrays: Arrays) -> None:
    results = [decide(cocircular(seed)) for seed in SEEDS]
    seen = Counter((result.verdict, result.has_lyapunov) for result in results)
    assert seen == {
        (Feedback.STABILIZABLE, True): 36,
        (Feedback.STABILIZABLE, False): 3,
        (Feedback.NO_CERTIFICATE, False): 1,
    }
    assert Counter(data.lever is not None for result in results for data in result.cells) == {True: 592, False: 2}


@pytest.mark.parametrize("seed", SEEDS)
def test_the_formulas_for_a_and_b_are_v_dot_along_the_control_fields(arrays: Arrays, seed: int) -> None:
    """``V'/2 = c . v + theta omega = a u_i + b u_j`` with the annihilator's own control fields."""
    scene = cocircular(seed)
    rng = np.random.default_rng(seed)
    for data in decide(scene).cells:
        if data.lever is not None:
            point = arrays.interior_point(data.cell.polygon, rng)
            theta = scene.field(Fraction(int(rng.integers(-9, 10)), 7))
            a, b = law_coefficients(data, point, theta)
            fields = data.state.control_fields
            assert dict(zip(fields, SQUARES.coefficients(data.fields, point, theta), strict=True)) == {
                data.nearest.index: a,
                data.second.index: b,
            }


@pytest.mark.parametrize("seed", SEEDS)
def test_under_the_law_v_falls_off_the_equilibrium_in_every_closed_cell(arrays: Arrays, seed: int) -> None:
    """With ``u = -(a, b)``, ``V'/2 = -(a^2 + b^2) < 0`` at vertices, sides and centres, for theta on both sides.

    Also at the theta at which b vanishes, under exact kinematics.
    """
    scene = cocircular(seed)
    result = decide(scene)
    if result.verdict is not Feedback.STABILIZABLE:
        return
    for data in local_cells(result, scene):
        vertices = data.cell.polygon.vertices
        middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pairwise(vertices)]
        for point in (*vertices, *middles, data.cell.polygon.centre):
            stalling = result.lyapunov.stalling_theta(point, data.nearest.position)
            for theta in (stalling, scene.field.one, -scene.field.one):
                a, b = result.lyapunov.coefficients(data.fields, point, theta)
                assert a * a + b * b > 0 or (not any(point) and not theta)


# ---- the criterion against brute force -----------------------------------------------------------


def input_matrix(data: InputCell) -> NDArray[np.float64]:
    """Rows ``g_w`` for unit input at each driven wheel, by a float solve of the three rows."""
    rows, unit = [], []
    for row in data.state.rows:
        d = np.array([float(x) for x in row.wheel.unit_direction])
        p = np.array([float(x) for x in row.wheel.position])
        along = d if row.kind is RowKind.ROLL else np.array([-d[1], d[0]])
        rows.append([*along, along @ [-p[1], p[0]]])
        unit.append(row.kind is RowKind.ROLL)
    return np.linalg.inv(np.array(rows)).T[np.array(unit)]


def smallest_response(data: InputCell, shape: tuple[float, float] = (0.0, 0.0)) -> float:
    """min over the cell's directions c and over all theta of ``sqrt(a^2 + b^2)/|(c, theta)|``; 0 at a sign change.

    For one direction c it is the smallest singular value of the map (|c|, theta) -> (a, b); a sign change of its
    determinant between neighbouring directions is a zero in between.  To first order in c, for ``w = 1``.
    """
    g = input_matrix(data)
    if len(g) < 2:
        return 0.0
    angles = directions(data)
    p = np.array([[1 + shape[0], shape[1]], [shape[1], 1 - shape[0]]])
    along = g[:, :2] @ p @ np.array([np.cos(angles), np.sin(angles)])
    responses = np.stack([along.T, np.broadcast_to(g[:, 2], along.T.shape)], axis=2)
    determinants = np.linalg.det(responses)
    if (determinants[:-1] * determinants[1:] < 0).any():
        return 0.0
    return float(np.linalg.svd(responses, compute_uv=False).min())


def directions(data: InputCell) -> NDArray[np.float64]:
    """Angles of the cell's directions from the equilibrium, ascending: the corners' and many between them."""
    x, y = (float(entry) for entry in data.cell.polygon.centre)
    corners = np.array([[float(a), float(b)] for a, b in data.cell.polygon.vertices if a or b])
    turns = np.arctan2(corners @ [-y, x], corners @ [x, y])
    turns = np.sort(np.concatenate([turns, np.linspace(-np.pi, np.pi, ANGLES)]))
    angles = np.arctan2(y, x) + turns
    inside = np.ones(len(angles), dtype=bool)
    for side in data.cell.polygon.sides:
        if not side.offset:  # the sides that meet at the equilibrium bound the cone
            normal = [float(entry) for entry in side.normal]
            inside &= np.column_stack([np.cos(angles), np.sin(angles)]) @ normal <= ZERO
    return angles[inside]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_criterion_agrees_with_brute_force(arrays: Arrays, seed: int) -> None:
    scene = cocircular(seed)
    result = decide(scene)
    cells = local_cells(result, scene)
    response = min(smallest_response(data) for data in cells)
    if result.lyapunov == SQUARES:
        assert result.has_lyapunov == (response > ZERO)
    else:
        e, f = (float(x) for x in result.lyapunov.shape)
        assert response <= ZERO < min(smallest_response(data, (e, f)) for data in cells)


@thorough  # about all random cases, which `make bench` runs
def test_the_random_arrays_show_both_verdicts(arrays: Arrays) -> None:
    found = {decide(cocircular(seed)).verdict for seed in SEEDS}
    assert found == {Feedback.STABILIZABLE, Feedback.NO_CERTIFICATE}


@pytest.mark.parametrize(
    ("turn", "descent"),
    [
        ((1, 0), None),
        ((Fraction(4, 5), Fraction(3, 5)), None),  # 36.9 degrees
        ((Fraction(21, 29), Fraction(20, 29)), None),  # 43.6 degrees
        # at 45 degrees c . d_i = 0 on the axes, the cells' common sides, and a cell's rim points along its side
        ((1, 1), Feedback.NO_CERTIFICATE),
        ((1, -1), Feedback.NO_CERTIFICATE),
        ((Fraction(20, 29), Fraction(21, 29)), Descent.TURNS),  # 46.4 degrees: just inside
        ((Fraction(3, 5), Fraction(-4, 5)), Descent.TURNS),
        ((0, 1), Descent.SLOW_TURNS),  # tangential rims: c . d_i = 0 on the diagonals
        ((-1, 0), None),  # outward rims: inputs of either sign are allowed
    ],
)
def test_four_wheels_turned_have_a_v_below_45_degrees(
    arrays: Arrays, turn: tuple[Rational, Rational], descent: Descent | Feedback | None
) -> None:
    """The quarter plane of a wheel on its diagonal holds the normal of its rim from 45 degrees on: then c turns."""
    scene = arrays.four_wheel(ROLL, turn)
    result = decide(scene)
    assert result.has_lyapunov == (descent is None)
    if descent is Feedback.NO_CERTIFICATE:
        assert result.verdict is descent
    elif descent is not None:
        assert result.cascade is not None
        assert result.cascade.descent is descent
    response = min(smallest_response(data) for data in local_cells(result, scene))
    assert (response > ZERO) == (descent is None)


@pytest.mark.parametrize("seed", SEEDS)
def test_at_a_witness_no_input_changes_v(arrays: Arrays, seed: int) -> None:
    """All control fields of a cell there have ``c . g_v + theta g_omega = 0``, and it is not the equilibrium."""
    scene = cocircular(seed)
    result = decide(scene)
    if result.verdict is Feedback.NO_CERTIFICATE:
        assert result.witness is not None
        point, theta = result.witness.point, result.witness.value
        assert any((*point, theta))
        idle = [
            all(not (point[0] * g[0] + point[1] * g[1] + theta * g[2]) for g in data.state.control_fields.values())
            for data in local_cells(result, scene)
            if data.cell.polygon.contains(point)
        ]
        assert any(idle)


def test_one_input_alone_never_suffices(arrays: Arrays) -> None:
    """Facing wheels: the roll row of the second repeats the first, so its side row is held and one input is left."""
    scene = arrays.scene(arrays.inward([(1, 0), (-1, 0)]), ROLL)
    result = decide(scene)
    assert result.verdict is Feedback.NO_CERTIFICATE
    assert result.witness is not None
    assert any((*result.witness.point, result.witness.value))
    for data in result.cells:
        assert data.lever is None
        assert data.torque_sign == 0


def test_one_turning_input_alone_never_suffices(arrays: Arrays) -> None:
    """As above with g_omega != 0: the plane ``c . g_v + theta g_omega = 0`` passes through every c."""
    wheels = arrays.inward([(1, 0), (-1, 0)])
    wheels[0] = wheels[0]._replace(direction=(-1, 1))
    scene = arrays.scene(wheels, ROLL)
    result = decide(scene)
    one_input = [data for data in result.cells if data.lever is None]
    assert result.verdict is Feedback.NO_CERTIFICATE
    assert result.witness is not None
    assert one_input
    point, theta = result.witness.point, result.witness.value
    assert any(point)
    assert theta
    (data,) = one_input
    assert not any(SQUARES.coefficients(data.fields, point, theta))


# ---- signs in the paper's law --------------------------------------------------------------------


def test_the_printed_sign_fails_in_four_of_the_eight_cells(arrays: Arrays) -> None:
    """``u_j = -k theta`` helps iff u_j turns the body the positive way: the omega entry of g_j."""
    result = decide(arrays.four_wheel(ROLL))
    turning = {data.cell.index: data.state.control_fields[data.second.index][2].sign() for data in result.cells}
    assert result.printed_sign_fails == tuple(index for index, s in turning.items() if s < 0)
    assert len(result.printed_sign_fails) == 4
    assert result.law is not None


@pytest.mark.parametrize("seed", SEEDS)
def test_the_lever_has_the_sign_of_the_turning_input(arrays: Arrays, seed: int) -> None:
    for data in decide(cocircular(seed)).cells:
        if data.lever is not None:
            assert data.torque_sign == data.state.control_fields[data.second.index][2].sign() != 0


# ---- arrays the clause does not speak of ---------------------------------------------------------


@pytest.mark.parametrize("friction", [SIDE, (1, 1)])
def test_the_clause_needs_less_friction_across_the_rims(arrays: Arrays, friction: tuple[Rational, Rational]) -> None:
    result = decide(arrays.four_wheel(friction))
    assert result.verdict is Feedback.NOT_APPLICABLE
    assert result.law is None
    assert "mu_side < mu_roll is required" in result.reason


def with_friction_of(scene: Scene, index: int, friction: tuple[Rational, Rational]) -> Scene:
    slip = Friction(scene.field(friction[0]), scene.field(friction[1]))
    return replace(scene, wheels=tuple(replace(w, friction=slip) if w.index == index else w for w in scene.wheels))


def test_one_slippery_wheel_at_the_equilibrium_ends_it(arrays: Arrays) -> None:
    result = decide(with_friction_of(arrays.four_wheel(ROLL), 3, SIDE))
    assert result.verdict is Feedback.NOT_APPLICABLE
    assert "wheel 3" in result.reason


def test_a_slippery_wheel_that_only_acts_far_away_does_not_matter(arrays: Arrays) -> None:
    """Feedback is about the equilibrium: wheel 5 owns cells of the square, but none that meets there."""
    near = arrays.inward(CORNERS)
    for turn, expected in (((1, 0), Feedback.STABILIZABLE), ((1, 1), Feedback.NO_CERTIFICATE)):
        near = arrays.inward([w.position for w in near], turn)
        far = arrays.inward([(2, 0)])[0]._replace(friction=SIDE)
        scene = arrays.scene([*near, far], ROLL, radius=2)
        assert any(5 in cell.wheels for cell in build_nearest_partition(scene).cells)
        assert decide(scene).verdict is expected


# ---- evidence ------------------------------------------------------------------------------------


def test_one_input_acts_where_the_cell_is_centred_on_the_equilibrium(arrays: Arrays) -> None:
    """The witness lies off the equilibrium: at the cell's centre theta would be zero too."""
    wheels = [
        WheelData((0, 0), (1, 0)),
        WheelData((1, 2), (-1, -4)),
        WheelData((2, Fraction(-5, 2)), (3, -1)),
        WheelData((Fraction(-3, 2), -HALF), (3, 1)),
    ]
    scene = arrays.scene(wheels, ROLL)
    result = decide_feedback(build_nearest_partition(scene))
    assert result.verdict is Feedback.NO_CERTIFICATE
    assert result.witness is not None
    assert any(result.witness.point)
    assert check_theorem4(scene).check()
