"""Clause 4: the discontinuous law, its rate, where it fails, and how far the contact state may be in doubt."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache, lru_cache
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from nonsmooth.analysis.cells.fan import CellCone, build_fan
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, InputMargin, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import Descent
from nonsmooth.proofs.clauses.feedback.control_fields import SQUARES, ControlLyapunov, InputCell, RowInputs, input_ranks
from nonsmooth.proofs.clauses.feedback.gradient_law import ConeRate, certified_rate, exponent_of
from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import RowKind
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import dot, turned
from tests.conftest import HALF, Arrays, WheelData
from tests.four_wheel import CORNERS, ROLL, SIDE
from tests.thorough import few, keep, thorough

# ---- Clause 4: the discontinuous law, the points where it fails, and the arrays it does not speak of.

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
    counts = Counter((result.verdict, result.has_lyapunov) for result in results)
    assert counts == {
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
    verdicts = {decide(cocircular(seed)).verdict for seed in SEEDS}
    assert verdicts == {Feedback.STABILIZABLE, Feedback.NO_CERTIFICATE}


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


# ---- The certified rate of the feedback law, against brute force ---------------------------------


def sampled_kappa(cone: ConeRate, samples: int = 40_000) -> float:
    """Least ``(a^2 + b^2)/(|c|^2 + theta^2)`` over random points of the cone."""
    rng = np.random.default_rng(0)
    rays = np.array([[float(x) for x in ray] for ray in cone.rays])
    c = rng.uniform(0, 1, (samples, 2)) ** 2 @ rays
    theta = rng.normal(size=samples) * np.hypot(*c.T) * 10 ** rng.uniform(-2, 2, samples)
    value = np.zeros(samples)
    for field in cone.fields:
        x, y, turn = (float(entry) for entry in field)
        value += (c[:, 0] * x + c[:, 1] * y + theta * turn) ** 2
    return float((value / ((c**2).sum(axis=1) + theta**2)).min())


@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "ring-5", "ring-6", "rectangle", "elliptic", "spiral-30"])
def test_the_rate_is_certified_and_nearly_the_best(name: str) -> None:
    rate = certified_rate(RowInputs(build_nearest_partition(load_scene(name).recentred())))
    assert rate is not None
    assert all(cone.holds(rate.kappa) for cone in rate.cones)
    best = min(sampled_kappa(cone) for cone in rate.cones)
    assert float(rate.kappa) <= best
    assert float(rate.kappa) >= 0.9 * best  # the samples come within a few per cent of the minimum
    assert not all(cone.holds(rate.kappa * Fraction(102, 100)) for cone in rate.cones)


def test_four_wheel_rate_in_closed_form(arrays: Arrays) -> None:
    """kappa = (3 - sqrt 5)/4 on every cone."""
    rate = certified_rate(RowInputs(build_nearest_partition(arrays.four_wheel())))
    assert rate is not None
    assert 0 <= (3 - np.sqrt(5)) / 4 - float(rate.kappa) < 3e-4


@pytest.mark.parametrize("unit", [1, Fraction(1, 10**40), 10**12])
def test_the_largest_rate_of_a_cone_is_told_apart_exactly(unit: Fraction) -> None:
    """Inputs along x, along y, and that turn: ``a^2 + b^2 >= kappa V`` iff ``kappa <= 1``, closer than floats are."""
    field = NumberField(1)
    one, zero = field.rational(1), field.rational(0)
    cone = ConeRate(
        ((one * unit, zero), (zero, one / unit)), ((one, zero, zero), (zero, one, zero), (zero, zero, 2 * one))
    )
    assert cone.holds(Fraction(1))
    for digits in range(1, 60):
        assert cone.holds(1 - Fraction(1, 10**digits))
        assert not cone.holds(1 + Fraction(1, 10**digits))


@thorough  # the small one: test_the_rate_is_certified_and_nearly_the_best
def test_random_arrays_have_a_rate_iff_the_law_stabilizes(arrays: Arrays) -> None:
    with_rate = without = 0
    for seed in range(25):
        partition = build_nearest_partition(arrays.cocircular(seed, ROLL))
        feedback = decide_feedback(partition)
        if feedback.has_lyapunov:
            with_rate += 1
            assert feedback.rate is not None, seed
        elif feedback.cells and all(data.lever is not None for data in feedback.cells):
            without += 1
            assert feedback.rate is None, seed
            assert certified_rate(RowInputs(partition)) is None, seed
    assert (with_rate, without) == (22, 2)  # in the last one a cell has no lever


@pytest.mark.parametrize("turn", [Fraction(1, 180), Fraction(89, 180), Fraction(7, 180)])
def test_the_size_of_a_number_over_a_field_of_high_degree(turn: Fraction) -> None:
    """At the precision of a float its ball holds zero, and the size of that ended in a traceback."""
    field = NumberField(360)
    for number in (field.cos_pi(turn), -field.sin_pi(turn), field.cos_pi(turn) ** 5 / 1000):
        for value in (number, Lazy.of(number)):
            assert exponent_of(value) == pytest.approx(math.log2(abs(float(number))), abs=0.51)


# ---- How far the contact state may be in doubt, against linear programs over all cells within reach.

ARRAYS = Arrays()

NAMES = ("four-wheel", "rectangle", "ring-3", "ring-5", "ring-6", "elliptic", "spiral-30", "outward", "ring-8")
STATES = 60  # for each array, each one linear program
FEASIBLE = 1e-9  # of a linear program in covectors of length one and inputs up to one

Matrix = NDArray[np.float64]


@cache
def decided(key: str | int) -> tuple[tuple[CellCone, ...], FeedbackResult, int]:
    scene: Scene = load_scene(key).recentred() if isinstance(key, str) else ARRAYS.cocircular(key, (1, Fraction(1, 2)))
    partition = build_nearest_partition(scene)
    return build_fan(partition), decide_feedback(partition), len(scene.wheels)


def margin_of(key: str | int) -> InputMargin | None:
    return decided(key)[1].margin


class Literal:
    """The fan in floats: cells within reach of a direction, and the largest common decrease by a linear program."""

    def __init__(self, fan: Sequence[CellCone], wheels: int, lyapunov: ControlLyapunov) -> None:
        (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
        self.p, self.w = np.array([[1 + e, f], [f, 1 - e]]), w
        self.rays = np.array([[[float(x) for x in ray] for ray in (cone.start, cone.end)] for cone in fan])
        self.fields = np.zeros((len(fan), wheels, 3))
        self.arms = np.array([[float(x) for x in cone.cell.states[0].rows[0].wheel.position] for cone in fan])
        for k, cone in enumerate(fan):
            for wheel, field in cone.cell.states[0].control_fields.items():
                self.fields[k, wheel - 1] = [float(x) for x in field]

    def distances(self, c: Matrix) -> Matrix:
        """Of c from each closed cone."""
        (a, b), lengths = np.moveaxis(self.rays, 1, 0), []
        for start, end in zip(a, b, strict=True):
            inside = np.cross([*start, 0], [*c, 0])[2] >= 0 and np.cross([*c, 0], [*end, 0])[2] >= 0
            feet = [ray * max(0.0, c @ ray) / (ray @ ray) for ray in (start, end)]
            lengths.append(0.0 if inside else min(float(np.hypot(*(c - foot))) for foot in feet))
        return np.array(lengths)

    def decrease(self, cells: NDArray[np.intp], c: Matrix, tau: float) -> float:
        """Largest t with ``alpha . u <= -t`` for the unit covectors of all cells, and ``|u_w| <= 1``."""
        slope = self.p @ c
        covectors = self.fields[cells] @ np.array([*slope, tau])
        covectors /= np.maximum(np.linalg.norm(covectors, axis=1), 1e-300)[:, None]
        count = covectors.shape[1]
        result = linprog(
            [*np.zeros(count), -1.0],
            A_ub=np.column_stack([covectors, np.ones(len(covectors))]),
            b_ub=np.zeros(len(covectors)),
            bounds=[*[(-1, 1)] * count, (None, 1)],
        )
        return float(result.x[-1])

    def trying_taus(self, c: Matrix, rng: np.random.Generator) -> list[float]:
        """Where some cell's second input vanishes, near it, and anywhere."""
        turned = np.column_stack([-self.arms[:, 1], self.arms[:, 0]])
        stalls = turned @ (self.p @ c)
        spread = float(np.ptp(stalls)) + 1.0
        return [*np.unique(stalls), *(stalls + rng.normal(0, 1e-3, len(stalls))), *rng.normal(0, spread, 6)]


def directions_within(rng: np.random.Generator, margin: InputMargin, sigma: float) -> list[Matrix]:
    """Unit vectors anywhere, and just within reach of the sides."""
    angles = list(rng.uniform(-np.pi, np.pi, 6))
    for side in margin.sides:
        x, y = (float(v) for v in side.cones[0].end)
        angles += [np.arctan2(y, x) + s * np.arcsin(sigma) * 0.999 for s in (-1, 1)]
    return [np.array([np.cos(t), np.sin(t)]) for t in angles]


@few(1)
@pytest.mark.parametrize("key", keep(8, [*NAMES[:4], *SEEDS[:12], *NAMES[4:]]))
def test_within_the_margin_all_cells_in_reach_have_a_common_input(key: str | int) -> None:
    fan, result, wheels = decided(key)
    margin = margin_of(key)
    if margin is None or not margin.value:
        return
    literal, rng = Literal(fan, wheels, result.lyapunov), np.random.default_rng(0)
    tried = 0
    for c in directions_within(rng, margin, margin.value):
        cells = np.flatnonzero(literal.distances(c) <= margin.value * 0.999)
        for tau in literal.trying_taus(c, rng):
            tried += 1
            assert literal.decrease(cells, c, tau) > FEASIBLE, (c, tau, cells)
            if tried % STATES == 0:
                break


@few(6)
@pytest.mark.parametrize("key", [*NAMES, *SEEDS])
def test_at_a_sides_distance_its_two_cells_have_no_common_input(key: str | int) -> None:
    """By a linear program at the witness, which lies at the stated angle from the side; just inside there is one."""
    fan, result, wheels = decided(key)
    margin = margin_of(key)
    if margin is None:
        return
    literal = Literal(fan, wheels, result.lyapunov)
    for side in margin.sides:
        c = np.array([float(x) for x in side.witness.point])
        ray = np.array([float(x) for x in side.cones[0].end])
        sine = abs(c[0] * ray[1] - c[1] * ray[0]) / (np.hypot(*c) * np.hypot(*ray))
        assert sine == pytest.approx(float(side.squared) ** 0.5, abs=1e-12)
        turning = (literal.p @ c) @ np.array([-c[1], c[0]])
        tau = literal.w * float(side.witness.value) + float(turning)
        cells = np.array([fan.index(cone) for cone in side.cones])
        covectors = literal.fields[cells] @ np.array([*(literal.p @ c), tau])
        sizes = np.linalg.norm(covectors, axis=1)
        vanishing = sizes.min() <= 1e-9 * (1 + sizes.max())
        assert vanishing or literal.decrease(cells, c, tau) <= FEASIBLE
        assert vanishing == (side.squared != 0)


def test_margins_in_closed_form() -> None:
    """Inward rims at angle 2 pi/n: a side is pi/n from each of its wheels, so the sine is cos(pi/n)."""
    exact = {
        "four-wheel": Fraction(1, 2),
        "outward": Fraction(1, 2),
        "ring-3": Fraction(1, 4),
        "rectangle": Fraction(1, 5),
    }
    for name, squared in exact.items():
        margin = margin_of(name)
        assert margin is not None
        assert margin.is_exact
        assert margin.squared == squared
    for count in (5, 6, 8):
        margin = margin_of(f"ring-{count}")
        assert margin is not None
        assert margin.is_exact
        assert margin.value == pytest.approx(np.cos(np.pi / count), abs=1e-12)
    bound = margin_of("elliptic")  # rims that do not meet: three nearest wheels come within reach, 60 degrees apart
    assert bound is not None
    assert not bound.is_exact
    assert bound.squared == Fraction(1, 4)
    spiral = margin_of("spiral-30")  # 45 degrees less 30
    assert spiral is not None
    assert spiral.value == pytest.approx(np.sin(np.pi / 12))


@thorough  # about all random cases, which `make bench` runs
def test_random_arrays_show_all_kinds() -> None:
    margins = [margin for key in SEEDS if (margin := margin_of(key)) is not None]
    assert {(bool(m.squared), m.is_exact) for m in margins} == {(False, True), (True, True), (True, False)}


# ---- Ranks of the control vector fields against numerical rank -----------------------------------


def test_four_wheel_ranks(arrays: Arrays) -> None:
    """Two inputs per cell with roll rows, one with side rows; together they span all three directions."""
    roll = input_ranks(build_nearest_partition(arrays.four_wheel(ROLL)))
    side = input_ranks(build_nearest_partition(arrays.four_wheel(SIDE)))
    assert set(roll.cells.values()) == {2}
    assert set(side.cells.values()) == {1}
    assert roll.equilibrium == side.equilibrium == 3
    assert len(roll.sides) == 8


@pytest.mark.parametrize("seed", range(15))
def test_ranks_against_floats(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.cocircular(seed))
    ranks = input_ranks(partition)
    fields = {
        cell.index: [[float(x) for x in f] for state in cell.states for f in state.control_fields.values()]
        for cell in partition.cells
    }
    for index, rank in ranks.cells.items():
        assert rank == np.linalg.matrix_rank(np.array(fields[index]), tol=1e-9)
    for (first, second), rank in ranks.sides.items():
        assert rank == np.linalg.matrix_rank(np.array(fields[first] + fields[second]), tol=1e-9)


def test_one_input_alone_leaves_a_plane_on_which_v_cannot_fall(arrays: Arrays) -> None:
    feedback = decide_feedback(build_nearest_partition(arrays.four_wheel(SIDE)))
    assert feedback.verdict is Feedback.NOT_APPLICABLE
    assert feedback.witness is not None
    assert "plane" in feedback.witness.meaning
    assert any(feedback.witness.point) or feedback.witness.value
