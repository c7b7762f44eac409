"""Functions V of the feedback law, and from where its law is certified."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import islice
from typing import TypeAlias

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Polygon
from nonsmooth.analysis.fields.constant_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import TurnRegion
from nonsmooth.proofs.clauses.feedback.control_fields import (
    SQUARES,
    ControlLyapunov,
    InputCell,
    RowInputs,
    StrictSignCondition,
    find_shapes,
    shape_regions,
)
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion, certified_rate
from nonsmooth.proofs.findings import Feedback
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.four_wheel import CORNERS
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import places_of
from tests.proofs.test_feedback import input_matrix
from tests.thorough import few, keep

# ---- Control Lyapunov functions ``c^T P c + w theta^2``: every P that serves is found, and what is found serves.

Shape: TypeAlias = tuple[Fraction, Fraction]

ROLL = (1, Fraction(1, 2))
SEEDS = range(30)
MILD = (0, 9, 14, 18, 21)  # short control fields: the loops of others are too stiff for an explicit integrator
SAMPLES = 4_000
INTEGRATION = 1e-6  # relative, of the integrator
ROUNDING = 1e-9  # of V'/V, in terms of order one

ARRAYS = Arrays()


def opposite_alike(seed: int) -> Scene:
    """Wheels on the unit circle with any rims, opposite ones alike, so that the origin is an equilibrium."""
    rng = np.random.default_rng(seed)
    wheels: list[WheelData] = []
    for _ in range(int(rng.integers(2, 4))):
        x, y = ARRAYS.circle_point(Fraction(int(rng.integers(-8, 9)), int(rng.integers(1, 6))))
        a, b = rng.integers(-4, 5, 2).tolist()
        if (x, y) not in {w.position for w in wheels}:
            a, b = (a, b) if a or b else (1, 0)
            wheels += [WheelData((x, y), (a, b)), WheelData((-x, -y), (-a, -b))]
    return ARRAYS.scene(wheels, ROLL)


@cache
def decided(seed: int, *, any_rims: bool) -> tuple[Partition, FeedbackResult]:
    scene = opposite_alike(seed) if any_rims else ARRAYS.cocircular(seed, ROLL)
    partition = build_nearest_partition(scene)
    return partition, decide_feedback(partition)


def local_cells(result: FeedbackResult) -> list[InputCell]:
    return list(result.inputs.local)


def sign_conditions_of(result: FeedbackResult) -> list[StrictSignCondition]:
    return [data.sign_condition for data in local_cells(result)]


def shapes(seed: int, count: int) -> list[Shape]:
    """Random rational (e, f) in the unit disc."""
    rng = np.random.default_rng(seed)
    found: list[Shape] = []
    while len(found) < count:
        e, f = (Fraction(int(n), 1000) for n in rng.integers(-999, 1000, 2))
        if e * e + f * f < 1:
            found.append((e, f))
    return found


def serves(sign_conditions: list[StrictSignCondition], shape: Shape) -> bool:
    """By the definition: ``c^T P D_i`` has one strict sign at the vertices of each cell, P written out."""
    (e, f), good = shape, True
    for sign_condition in sign_conditions:
        d = sign_condition.direction
        values = [x * ((1 + e) * d[0] + f * d[1]) + y * (f * d[0] + (1 - e) * d[1]) for x, y in sign_condition.vertices]
        good = good and {value.sign() for value in values} in ({1}, {-1})
    return good


# ---- the search is complete ----------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("any_rims", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_regions_hold_exactly_the_p_that_serve(seed: int, any_rims: bool) -> None:
    _, result = decided(seed, any_rims=any_rims)
    sign_conditions = sign_conditions_of(result)
    regions = [polygon for _, polygon in shape_regions(sign_conditions)]
    field = sign_conditions[0].direction[0].field

    def strictly_inside(polygon: Polygon, shape: Shape) -> bool:
        point = (field(shape[0]), field(shape[1]))
        return all(side.slack(point).sign() > 0 for side in polygon.sides)

    for shape in shapes(seed, 60):
        assert serves(sign_conditions, shape) == any(strictly_inside(polygon, shape) for polygon in regions)


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_one_p_is_found_in_every_region(seed: int) -> None:
    _, result = decided(seed, any_rims=True)
    sign_conditions = sign_conditions_of(result)
    found = list(find_shapes(sign_conditions))
    assert len(found) == len(shape_regions(sign_conditions))
    assert all(serves(sign_conditions, shape) for shape in found)
    assert all(ControlLyapunov(shape).is_positive for shape in found)


@pytest.mark.parametrize(("seeds", "any_rims"), keep(1, [(range(3), False), (SEEDS, False), (SEEDS, True)]))
def test_where_squares_fail_a_p_is_found_or_excluded(seeds: range, any_rims: bool) -> None:
    """Two inputs in every cell: each array has a certified V or a proof that no such V exists; both occur."""
    outcomes = set()
    for seed in seeds:
        _, result = decided(seed, any_rims=any_rims)
        if all(data.lever is not None for data in local_cells(result)):
            found = result.has_lyapunov
            assert found != result.none_serves
            outcomes.add((found, result.lyapunov == SQUARES))
    assert outcomes == {(True, True), (True, False), (False, True)}


@pytest.mark.parametrize(
    ("half_width", "turn", "serves_square"),
    [
        (1, (20, 21), False),
        (1, (3, 4), False),
        (2, (4, 3), True),
        (2, (3, 4), True),
        (3, (1, 1), True),
        (3, (0, 1), False),
    ],
)
def test_turned_rims_on_a_rectangle(half_width: int, turn: tuple[int, int], serves_square: bool) -> None:
    """On a square no P helps where P = I does not, on a long rectangle one may: a circle has no long axis."""
    corners = [(half_width, 1), (-half_width, 1), (-half_width, -1), (half_width, -1)]
    result = decide_feedback(build_nearest_partition(ARRAYS.scene(ARRAYS.inward(corners, turn), ROLL)))
    assert result.has_lyapunov == serves_square == (result.lyapunov != SQUARES)
    assert result.none_serves != serves_square


# ---- what is found ---------------------------------------------------------------------------------


def shaped_results(count: int | None) -> list[tuple[Partition, FeedbackResult]]:
    """The first arrays whose certified V is no sum of squares, or all; no array after them is decided."""
    every = (decided(seed, any_rims=any_rims) for seed in SEEDS for any_rims in (False, True))
    return list(islice((pair for pair in every if pair[1].lyapunov != SQUARES), count))


def worst_rate(data: InputCell, lyapunov: ControlLyapunov, within: float, seed: int) -> float:
    """Largest ``V'/V`` under the law with gain one at random states of the cell, from the exact pose kinematics."""
    rng = np.random.default_rng(seed)
    corners = np.array([[float(x) for x in vertex] for vertex in data.sign_condition.vertices])
    (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
    p = np.array([[1 + e, f], [f, 1 - e]])
    c = rng.exponential(size=(SAMPLES, len(corners))) ** 2 @ corners
    c *= (within * rng.random(SAMPLES) / np.hypot(*c.T))[:, None]
    theta = rng.normal(size=SAMPLES) * np.hypot(*c.T) * 10 ** rng.uniform(-2, 2, SAMPLES)
    g = input_matrix(data).T
    gradient = 2 * np.column_stack([c @ p, w * theta])
    turned = np.column_stack([-c[:, 1], c[:, 0]])
    rates = np.stack([(gradient[:, :2] * (g[:2, k] + g[2, k] * turned)).sum(axis=1) for k in (0, 1)])
    rates += gradient[:, 2] * g[2, :, None]
    inputs = -rates / 2  # u = -k (a, b) with k = 1: a and b are the halves of the rates
    v = ((c @ p) * c).sum(axis=1) + w * theta**2
    return float(((rates * inputs).sum(axis=0) / v).max())


def best_rate(data: InputCell, lyapunov: ControlLyapunov) -> float:
    """Least ``(a^2 + b^2)/V`` to first order: by direction c the smaller eigenvalue of a pencil in (|c|, tau)."""
    corners = np.array([[float(x) for x in vertex] for vertex in data.sign_condition.vertices])
    x, y = corners.mean(axis=0)
    angles = np.arctan2(corners @ [-y, x], corners @ [x, y]) + np.arctan2(y, x)
    c = np.array([(np.cos(t), np.sin(t)) for t in np.linspace(angles.min(), angles.max(), SAMPLES)])
    (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
    slopes, g = c @ np.array([[1 + e, f], [f, 1 - e]]), input_matrix(data).T
    sizes = np.sqrt((slopes * c).sum(axis=1))
    response = np.stack([(slopes @ g[:2]) / sizes[:, None], np.broadcast_to(g[2] * np.sqrt(w), (SAMPLES, 2))], axis=2)
    return float(np.linalg.svd(response, compute_uv=False).min() ** 2)


@pytest.mark.parametrize("count", keep(1, [1, 2, None]))
def test_the_rate_holds_under_exact_kinematics_within_its_reach(count: int | None) -> None:
    """``V' <= -2 kappa V`` at sampled states, and kappa is the best to first order but for rounding and slack."""
    for k, (_, result) in enumerate(shaped_results(count)):
        assert result.rate is not None
        reach = result.rate.reach
        assert reach is not None
        worst = max(worst_rate(data, result.lyapunov, float(reach), k) for data in local_cells(result))
        assert worst <= -2 * float(result.rate.kappa) + ROUNDING
        best = min(best_rate(data, result.lyapunov) for data in local_cells(result))
        assert 0.98 * best <= float(result.rate.kappa) <= best


def test_the_closed_loop_decays_at_the_certified_rate() -> None:
    """``V(t) <= V(0) exp(-2 kappa t)`` along a Filippov solution through several cells, from a start within reach."""
    crossed = 0
    for seed in MILD:
        partition, result = decided(seed, any_rims=False)
        assert result.rate is not None
        assert result.rate.reach is not None
        (e, f), w = (float(x) for x in result.lyapunov.shape), float(result.lyapunov.weight)
        law = gradient_law(1, (e, f), w)
        size = float(result.rate.reach) / 4
        path = simulate(feedback_field(partition, law, Kinematics.EXACT), (0.9 * size, 0.4 * size, size), 4)
        x, y, theta = path.array.T
        v = (1 + e) * x**2 + 2 * f * x * y + (1 - e) * y**2 + w * theta**2
        bound = v[0] * np.exp(-2 * float(result.rate.kappa) * np.array(path.times))
        assert (v <= bound * (1 + INTEGRATION)).all()
        assert v[-1] < v[0]
        crossed += len(path.events)
    assert crossed > 8


@pytest.mark.parametrize("count", keep(1, [2, 6]))
def test_any_weight_serves_and_half_of_the_best_rate_is_reached(count: int) -> None:
    for partition, result in shaped_results(count):
        assert result.rate is not None
        shape = result.lyapunov.shape
        light, best = (
            certified_rate(RowInputs(partition), ControlLyapunov(shape, Fraction(2) ** k)) for k in (-20, 60)
        )
        assert light is not None
        assert best is not None
        assert 0 < light.kappa < result.rate.kappa <= best.kappa
        assert result.rate.kappa >= Fraction(49, 100) * best.kappa
        half = certified_rate(RowInputs(partition), replace(result.lyapunov, weight=result.lyapunov.weight / 2))
        assert half is not None
        assert half.kappa <= Fraction(51, 100) * best.kappa


# ---- From where the law of the feedback clause is certified: levels against samples, W against differences of its
# own.


J = np.array([[0.0, -1.0], [1.0, 0.0]])


def decided_scene(name: str, radius: str | None = None) -> FeedbackResult:
    return decide_feedback(build_nearest_partition(load_scene(name, rule="nearest", radius=radius).recentred()))


def least_on_segment(start: Floats, end: Floats, shape: Floats) -> float:
    points = start + np.linspace(0, 1, 2001)[:, None] * (end - start)
    return float(np.einsum("ki,ij,kj->k", points, shape, points).min())


def sampled_level(feedback: FeedbackResult, scene: Scene) -> float:
    """Least ``c^T P c`` on the border, on the cells where ``c^T P d_i`` takes no strict sign, and where the body tips.

    By dense samples; the support polygon is the hull of the wheels.
    """
    (e, f) = (float(x) for x in feedback.lyapunov.shape)
    shape = np.array([[1 + e, f], [f, 1 - e]])
    polygons = [np.array([[float(x) for x in v] for v in data.cell.polygon.vertices]) for data in feedback.cells]
    size = max(np.abs(polygon).max() for polygon in polygons)
    corners = size * np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1]])
    wheels = places_of(scene)
    borders = [corners, wheels[ConvexHull(wheels).vertices]]
    for data, polygon in zip(feedback.cells, polygons, strict=True):
        touches = np.abs(polygon @ shape @ [float(x) for x in data.nearest.direction])
        signs = np.sign(np.where(touches < 1e-12, 0, polygon @ shape @ [float(x) for x in data.nearest.direction]))
        if data in feedback.inputs.away and (data.lever is None or len(set(signs)) > 1 or 0 in signs):
            borders.append(polygon)
    sides = [(polygon[k - 1], polygon[k]) for polygon in borders for k in range(len(polygon))]
    return min(least_on_segment(start, end, shape) for start, end in sides)


@pytest.mark.parametrize(
    ("name", "radius"),
    [
        ("four-wheel", None),
        ("rectangle", None),
        ("ring-5", "9/10"),
        ("grid-4x4", "7/5"),
        ("grid-4x4", None),
        ("elliptic", None),
    ],
)
def test_the_level_is_what_border_and_stalling_cells_leave(name: str, radius: str | None) -> None:
    scene = load_scene(name, rule="nearest", radius=radius).recentred()
    feedback = decide_feedback(build_nearest_partition(scene))
    assert isinstance(feedback.region, LevelRegion)
    least = sampled_level(feedback, scene)
    assert least * (1 - 2e-3) <= float(feedback.region.level) <= least * (1 + 1e-6)


def test_a_level_ends_at_a_cell_that_stalls(arrays: Arrays) -> None:
    """A fifth wheel across the way is nearest where ``x > 1 + |y|``, and there ``c . d_i`` vanishes on ``y = 0``."""
    wheels = [*arrays.inward(CORNERS), WheelData((2, 0), (0, 1))]
    scene = arrays.scene(wheels, ROLL, radius=Fraction(6, 5))
    feedback = decide_feedback(build_nearest_partition(scene))
    assert isinstance(feedback.region, LevelRegion)
    assert feedback.region.level == 1
    assert sampled_level(feedback, scene) == pytest.approx(1)


@pytest.mark.parametrize("seed", range(40))
def test_levels_of_random_arrays_verify(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed, ROLL).recentred()
    feedback = decide_feedback(build_nearest_partition(scene))
    if len({wheel.position for wheel in scene.wheels}) == 2:
        assert feedback.region is None  # on two wheels the body tips
    elif feedback.verdict is Feedback.STABILIZABLE and feedback.cascade is None:
        assert isinstance(feedback.region, LevelRegion)
        least = sampled_level(feedback, scene)
        assert least * (1 - 2e-3) <= float(feedback.region.level) <= least * (1 + 1e-6)


# ---- slow turns ----------------------------------------------------------------------------------


def slow_turns(name: str) -> tuple[FeedbackResult, TurnRegion]:
    feedback = decided_scene(name)
    assert isinstance(feedback.region, TurnRegion)
    return feedback, feedback.region


class Loop:
    """The law of slow turns with W by their definitions; m and chi by quadrature over the angle of c."""

    def __init__(self, region: TurnRegion) -> None:
        tops = np.array([[float(x) for x in wheel.position] for wheel in region.cascade.wheels])
        units = tops / np.linalg.norm(tops, axis=1)[:, None]
        self.units = units[np.argsort(np.arctan2(*units.T[::-1]))]
        self.length, self.weight = float(region.length), float(region.weight)
        angles = np.unwrap(np.arctan2(*self.units.T[::-1]))
        after = np.append(angles[1:], angles[0] + 2 * np.pi)
        self.ends = np.tan((after - angles) / 2)  # z where the next wheel is as near; there it restarts at -z
        starts = -np.roll(self.ends, 1)
        grids = [np.linspace(a, b, 20_001) for a, b in zip(starts, self.ends, strict=True)]
        turn = sum(b - a for a, b in zip(starts, self.ends, strict=True))
        self.mean = sum(float(np.trapezoid(z**2, z)) for z in grids) / turn
        rises = [float(np.trapezoid(z**2 - self.mean, z)) for z in grids]
        borders = np.concatenate([[0.0], np.cumsum(rises)])
        constants = np.array([border - self.plain(a) for border, a in zip(borders, starts, strict=False)])
        self.constants = constants - (constants.max() + constants.min()) / 2  # chi is free up to one constant
        self.largest = float(self.ends.max())

    def plain(self, z: float) -> float:
        return float(z**3 / 3 - self.mean * z)

    def frame(self, c: Floats) -> tuple[float, float, int]:
        k = int(np.argmax(self.units @ c))
        return float(c @ self.units[k]), float(c @ (J @ self.units[k])), k

    def rate(self, pose: Floats) -> Floats:
        """The pose rate that the imposed motion gives: ``c' = v + omega J c``."""
        r, s, k = self.frame(pose[:2])
        omega = s / self.length - (pose[2] - s * s / (2 * r * self.length))
        return np.array([*((1 - omega) * r * (J @ self.units[k]) + omega * (J @ pose[:2])), omega])

    def w(self, pose: Floats) -> float:
        r, s, k = self.frame(pose[:2])
        x, z = r / self.length, s / r
        big = x + x * x * (self.plain(z) + self.constants[k])
        return float(big**2 + self.weight * (pose[2] - x * z * z / 2) ** 2)


def region_of(arrays: Arrays, array: str | int) -> TurnRegion:
    """That of a built-in scene, or of a random array of tangential rims."""
    if isinstance(array, str):
        return slow_turns(array)[1]
    feedback = decide_feedback(build_nearest_partition(arrays.cocircular(array, ROLL).recentred()))
    assert isinstance(feedback.region, TurnRegion)
    return feedback.region


def test_no_region_of_slow_turns_is_claimed_where_the_square_leaves_the_support_polygon(arrays: Arrays) -> None:
    feedback = decide_feedback(build_nearest_partition(arrays.cocircular(135, ROLL).recentred()))
    assert feedback.verdict is Feedback.STABILIZABLE
    assert feedback.region is None


@few(1)
@pytest.mark.parametrize("array", ["conveyor-3", "saddle", 1, 35, 91])
@pytest.mark.parametrize("count", keep(1, [1000, 4000]))
def test_w_falls_everywhere_in_the_region(arrays: Arrays, array: str | int, count: int) -> None:
    region = region_of(arrays, array)
    loop, rng = Loop(region), np.random.default_rng(4)
    reach = float(region.top) * loop.length * np.hypot(1, loop.largest)
    inside = 0
    for _ in range(count):
        angle, size = rng.uniform(0, 2 * np.pi), reach * rng.uniform(0.01, 1)
        heading = np.sqrt(float(region.level) / loop.weight) * rng.uniform(-1.2, 1.2)
        pose = np.array([size * np.cos(angle), size * np.sin(angle), heading])
        step = 1e-6
        before, after = pose - step * loop.rate(pose), pose + step * loop.rate(pose)
        if len({loop.frame(place[:2])[2] for place in (before, pose, after)}) > 1 or not region.contains(pose.tolist()):
            continue  # across a ray
        inside += 1
        assert region.value(pose.tolist()) == pytest.approx(loop.w(pose), rel=1e-6, abs=1e-12)
        assert loop.w(after) < loop.w(before)
        omega = loop.rate(pose)[2]
        assert 1 + omega * loop.largest**2 > 0  # rays are crossed in the sense of the turn
    assert inside > 3 * count / 40


@few(1)
@pytest.mark.parametrize("angles", keep(1, [91, 721]))
@pytest.mark.parametrize("name", ["conveyor-3", "saddle"])
def test_the_region_lies_in_the_square_and_on_its_border_w_is_not_below(name: str, angles: int) -> None:
    """No solution passes ``r = top l``: there W is at least the level, whatever the heading."""
    _, region = slow_turns(name)
    loop = Loop(region)
    for angle in np.linspace(0, 2 * np.pi, angles):
        unit = np.array([np.cos(angle), np.sin(angle)])
        r, _, _ = loop.frame(unit)
        c = unit * float(region.top) * loop.length / r
        assert np.abs(c).max() <= loop.length
        headings = np.linspace(-0.5, 0.5, 101)
        assert min(loop.w(np.array([*c, theta])) for theta in headings) >= float(region.level)
