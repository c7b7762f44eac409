"""From where the law of the feedback clause is certified: levels against samples, W against differences of its own."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import TurnRegion
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.findings.verdicts import Feedback
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.four_wheel import CORNERS
from tests.thorough import few, keep

Floats: TypeAlias = NDArray[np.float64]

J = np.array([[0.0, -1.0], [1.0, 0.0]])
ROLL = (1, Fraction(1, 2))


def decided(name: str, radius: str | None = None) -> FeedbackResult:
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
    wheels = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
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
    feedback = decided(name)
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
