"""V* of |c|^2: exact on cells, edges and vertices, against formulas, samples, and hulls by convex programs."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.filippov import (
    RelativeRate,
    cell_derivatives,
    filippov_twists,
    largest_slope,
    lyapunov_rate,
    points_into,
    upper_derivative_at,
)
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, square
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.sampling import literal_twist, literal_twists
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import dot
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.oracles.cvxpy_programs import hull_upper_derivative_at, hull_upper_derivative_on
from tests.oracles.nearest_states import nearest_states
from tests.thorough import few

SEEDS = range(8)

# CVXPY hands these to CLARABEL, whose default accuracy is 1e-8 relative; numbers here are below 100.
SOLVER_TOLERANCE = 1e-6
# A floating-point rate is a sum of three products of numbers below 100.
ROUNDING = 1e-9
# Edges are sampled at 1/40 of their length and the slope V*/|c| turns by at most its own size per radian, but a cell
# may reach down to a corner near the equilibrium: relative to the largest speed.
SAMPLING_GAP = 0.02


def float_point(point: Point) -> NDArray[np.float64]:
    return np.array([float(x) for x in point])


def edge_midpoints(polygon: Polygon) -> list[Point]:
    following = polygon.vertices[1:] + polygon.vertices[:1]
    return [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in zip(polygon.vertices, following, strict=True)]


def fastest(partition: Partition) -> float:
    return max(math.hypot(float(t.vx), float(t.vy)) for cell in partition.cells for t in cell.twists)


# ---- the Filippov set ----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_an_inner_edge_holds_the_twists_of_its_two_sides(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 5).recentred()
    partition = build_nearest_partition(scene)
    for cell in partition.cells:
        for point, side in zip(edge_midpoints(cell.polygon), cell.polygon.sides, strict=True):
            if side.label != "domain":
                step = Fraction(1, 10**12)  # shorter than any cell of these arrays
                beside = [(point[0] + s * side.normal[0], point[1] + s * side.normal[1]) for s in (step, -step)]
                expected = {state.twist for p in beside for state in nearest_states(scene, p)}
                assert set(filippov_twists(partition, point)) == expected


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_every_twist_near_a_vertex_belongs_to_its_hull(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    partition = build_nearest_partition(scene)
    step = Fraction(1, 10**12)
    for x, y in {vertex for cell in partition.cells for vertex in cell.polygon.vertices}:
        around = [arrays.circle_point(Fraction(k, 7)) for k in range(-40, 41)]
        points = [(x + step * a, y + step * b) for a, b in around]
        inside = [p for p in points if partition.domain.contains(p)]
        found = {state.twist for p in inside for state in nearest_states(scene, p)}
        assert found <= set(filippov_twists(partition, (x, y)))


def test_eight_twists_meet_at_the_centre_of_the_four_wheel_array(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    zero = scene.field.zero
    assert len(filippov_twists(build_nearest_partition(scene), (zero, zero))) == 8


# ---- V* pointwise --------------------------------------------------------------------------------


@pytest.mark.parametrize(("friction", "pick"), [(ROLL, max), (SIDE, min)], ids=["eq. 4", "eq. 3"])
def test_four_wheel_upper_derivative_is_the_closed_form(
    arrays: Arrays, friction: tuple[Fraction | int, Fraction | int], pick: Callable[[int, int], int]
) -> None:
    """``-2 sqrt2 max(|x|, |y|)`` for eq. (4), ``-2 sqrt2 min(|x|, |y|)`` for eq. (3), on switching lines too."""
    scene = arrays.four_wheel(friction)
    partition, root = build_nearest_partition(scene), scene.field.sqrt(2)
    for a in range(-4, 5):
        for b in range(-4, 5):
            point = scene.field(Fraction(a, 8)), scene.field(Fraction(b, 8))
            assert upper_derivative_at(partition, point) == -2 * root * Fraction(pick(abs(a), abs(b)), 8)


@few(3)
@pytest.mark.parametrize("n", range(3, 13))
def test_ring_upper_derivative_on_its_symmetry_axes(arrays: Arrays, n: int) -> None:
    """Towards a wheel -2|c| in both cases; midway between two wheels -2 sec(delta/2)|c| (roll), 0 (side)."""
    for friction in (ROLL, SIDE):
        scene = arrays.ring(n, friction)
        field, partition = scene.field, build_nearest_partition(scene)
        half = Fraction(1, 2)
        slowest = -2 * half / field.cos_pi(Fraction(1, n)) if friction == ROLL else field.zero
        for k in range(n):
            wheel = field.cos_pi(Fraction(2 * k, n)) * half, field.sin_pi(Fraction(2 * k, n)) * half
            midway = field.cos_pi(Fraction(2 * k + 1, n)) * half, field.sin_pi(Fraction(2 * k + 1, n)) * half
            assert upper_derivative_at(partition, wheel) == -2 * half
            assert upper_derivative_at(partition, midway) == slowest


@pytest.mark.parametrize("seed", SEEDS)
def test_upper_derivative_bounds_every_mixture_and_is_attained(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    partition = build_nearest_partition(scene)
    rng = np.random.default_rng(seed)
    for cell in partition.cells[:6]:
        for point in (*cell.polygon.vertices, *edge_midpoints(cell.polygon)):
            twists = filippov_twists(partition, point)
            highest = upper_derivative_at(partition, point)
            rates = [2 * dot(point, t.pose_rate(point)) for t in twists]  # exact kinematics: omega J c drops out
            weights = rng.integers(0, 20, len(rates)).tolist()
            weights[0] += 1
            mixture = sum((w * r for w, r in zip(weights, rates, strict=True)), scene.field.zero) / sum(weights)
            assert mixture <= highest
            assert highest in rates


@pytest.mark.parametrize("seed", SEEDS)
def test_hull_by_convex_program_agrees_at_edges_and_vertices(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.cocircular(seed))
    cell = partition.cells[seed % len(partition.cells)]
    zero = partition.scene.field.zero
    for point in (cell.polygon.vertices[0], edge_midpoints(cell.polygon)[0], cell.polygon.centre, (zero, zero)):
        exact = float(upper_derivative_at(partition, point))
        assert hull_upper_derivative_at(partition, point) == pytest.approx(exact, abs=SOLVER_TOLERANCE)


@pytest.mark.parametrize("seed", SEEDS)
def test_hull_by_convex_program_agrees_on_cells(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.random(seed, 4).recentred())
    for cell in partition.cells[:4]:
        exact = max(d.largest[0] for d in cell_derivatives(partition) if d.cell is cell)
        assert hull_upper_derivative_on(cell) == pytest.approx(float(exact), abs=SOLVER_TOLERANCE)


def test_a_point_outside_the_square_is_refused(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    partition = build_nearest_partition(scene)
    with pytest.raises(ValueError, match="required a point of the checked square, received"):
        upper_derivative_at(partition, (scene.field(1), scene.field(0)))


# ---- V* over cells -------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_largest_rate_of_a_cell_bounds_its_points_and_is_attained(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 5).recentred()
    partition = build_nearest_partition(scene)
    rng = np.random.default_rng(seed)
    for derivative in cell_derivatives(partition):
        highest, where = derivative.largest
        assert lyapunov_rate(derivative.twist, where) == highest
        for _ in range(5):
            assert lyapunov_rate(derivative.twist, arrays.interior_point(derivative.cell.polygon, rng)) <= highest


def test_cell_derivatives_cover_every_twist_of_every_cell(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.four_wheel((1, 1)))
    pairs = [(d.cell.index, d.twist) for d in cell_derivatives(partition)]
    assert pairs == [(cell.index, twist) for cell in partition.cells for twist in cell.twists]
    assert len(pairs) == 16


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_samples_stay_below_the_exact_maximum(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 5).recentred()
    partition = build_nearest_partition(scene)
    derivatives = cell_derivatives(partition)
    largest = float(max(d.largest[0] for d in derivatives))
    slope = max(float(d.relative().value) for d in derivatives)
    radius = float(scene.check.radius)
    points = np.random.default_rng(seed).uniform(-radius, radius, size=(800, 2))
    rates = 2 * (literal_twists(scene, points)[:, :2] * points).sum(axis=1)
    assert rates.max() <= largest + ROUNDING
    assert (rates / np.hypot(*points.T)).max() <= slope + ROUNDING


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_dense_samples_along_edges_reach_the_exact_slope(arrays: Arrays, seed: int) -> None:
    """The float rule, just inside every edge: it comes up to the supremum of V*/|c|, and never above."""
    scene = arrays.cocircular(seed)
    partition = build_nearest_partition(scene)
    exact = max(float(d.relative().value) for d in cell_derivatives(partition))
    reached = -math.inf
    for cell in partition.cells:
        centre = float_point(cell.polygon.centre)
        corners = [float_point(v) for v in cell.polygon.vertices]
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            for t in np.linspace(0.0, 1.0, 41):
                point = (1 - 1e-6) * ((1 - t) * start + t * end) + 1e-6 * centre
                if np.hypot(*point) > 1e-4:  # nearer, the direction of the point is not resolved
                    rates = tied_rates(scene, point)
                    reached = max(reached, rates / float(np.hypot(*point)))
    assert reached <= exact + ROUNDING
    assert reached >= exact - SAMPLING_GAP * fastest(partition)


def tied_rates(scene: Scene, point: NDArray[np.float64]) -> float:
    """Largest ``2 c . v`` of the literal rule; where frictions tie, of both orders of the second wheel's rows."""
    if scene.wheels[0].friction.roll != scene.wheels[0].friction.side:
        return float(2 * literal_twist(contact_model(scene), point)[:2] @ point)
    place = scene.field(Fraction(point[0])), scene.field(Fraction(point[1]))
    return max(float(2 * float_point(s.twist.velocity) @ point) for s in nearest_states(scene, place))


# ---- slopes --------------------------------------------------------------------------------------


def polygon_of(field: NumberField, seed: int) -> Polygon:
    """A random polygon: near the origin, around it, or with the origin as a vertex."""
    rng = np.random.default_rng(seed)
    x, y = rng.integers(-3, 4, 2).tolist()
    polygon = square((field(x), field(y)), field(2))
    for _ in range(4):
        a, b, c = rng.integers(-4, 5, 3).tolist()
        cut = polygon.clipped(HalfPlane((field(a), field(b)), field(abs(c) * (seed % 3))))
        polygon = cut or polygon
    return polygon


@pytest.mark.parametrize("seed", range(40))
def test_largest_slope_against_fine_sampling(seed: int) -> None:
    field = NumberField()
    polygon = polygon_of(field, seed)
    rng = np.random.default_rng(seed + 1)
    corners = [float_point(v) for v in polygon.vertices]
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    points = np.array([(1 - t) * p + t * q for p, q in edges for t in np.linspace(0, 1, 2001)])
    points = points[np.hypot(*points.T) > 0]
    if polygon.contains((field.zero, field.zero)):  # the corner at the origin sees its directions on other edges
        points = np.vstack([points, points * 0.5])
    for a, b in rng.integers(-5, 6, (6, 2)).tolist():
        twist = Twist(field(a), field(b), field(3))
        exact = float(largest_slope(twist, polygon).value)
        sampled = (2 * points @ [a, b] / np.hypot(*points.T)).max()
        assert sampled <= exact + ROUNDING
        assert sampled >= exact - 0.002 * math.hypot(a, b)  # 2000 points per edge


@pytest.mark.parametrize("seed", range(40))
def test_a_ray_meets_a_polygon_iff_clipping_to_it_leaves_a_segment(seed: int) -> None:
    """Independent way: the polygon has points with ``cross = 0, dot > 0`` iff both half-planes reach such points."""
    field = NumberField()
    polygon = polygon_of(field, seed)
    zero = field.zero
    for x, y in np.random.default_rng(seed).integers(-3, 4, (8, 2)).tolist():
        if x or y:
            direction = field(x), field(y)
            ahead = polygon.clipped(HalfPlane((-direction[0], -direction[1]), zero))
            expected = False
            if ahead is not None:
                sides = [(direction[0] * v[1] - direction[1] * v[0]).sign() for v in ahead.vertices]
                beyond = [s for s, v in zip(sides, ahead.vertices, strict=True) if dot(direction, v).sign() > 0]
                flat = [s for s, v in zip(sides, ahead.vertices, strict=True) if not dot(direction, v)]
                expected = 0 in beyond or {1, -1} <= {*beyond, *flat}
            assert points_into(polygon, direction) == expected


def test_slopes_are_ordered_like_their_values() -> None:
    field = NumberField()
    rng = np.random.default_rng(5)
    slopes = [
        RelativeRate((field(a), field(b)), (field(c or 1), field(d)))
        for a, b, c, d in rng.integers(-3, 4, (40, 4)).tolist()
    ]
    for first in slopes:
        (a, b), (c, d) = float_point(first.velocity), float_point(first.direction)
        assert float(first.value) == pytest.approx(2 * (a * c + b * d) / math.hypot(c, d), abs=ROUNDING)
        for second in slopes:
            assert (first < second) == (first.value < second.value)
            bound = second.value
            assert isinstance(bound, Number)
            assert first.is_at_most(bound) == (first.value <= bound)
