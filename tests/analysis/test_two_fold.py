"""Slides on which both normal speeds vanish, in a point or on the way home: the weights there are no quotient."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.cellwise_field import CellwiseField, Speeds, feedback_field
from nonsmooth.analysis.fields.convex_weights import origin_distance
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import affine_surface
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.thorough import few

Floats: TypeAlias = NDArray[np.float64]

ROLL = (1, Fraction(1, 2))
# Opposite pairs of wheels by seed, and starts whose paths slide into a two-fold.
TWO_FOLDS = [(177, (0.05438333, -0.79814939, -0.24)), (67, (-0.98065471, -0.99606556, 0.19279027))]
# The same, and paths that slide home along an edge, theta following c.
HOMECOMINGS = [(231, (-0.70211890, -0.38344367, 0.24)), (277, (-0.04006792, 0.20585195, -0.06291456))]
MOMENT = 1e-7  # half a time over which a velocity is read off a path
OFF = 1e-5  # of a velocity read off a path: its states err by 1e-12
BESIDE = 1e-6  # cells within this of a state are around it: more than the paths move in a moment


def closed_loop(scene: Scene, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> CellwiseField:
    """The array under the gradient law about its checked point, gain one."""
    centre = np.array([*map(float, scene.check.equilibrium), 0.0])
    centred = {s.name: s for cell in build_nearest_partition(scene.recentred()).cells for s in cell.states}
    law = gradient_law(1.0, shape, weight)

    def prepared(state: ContactState) -> Speeds:
        speeds = law(centred[state.name])
        return lambda pose: speeds(pose - centre)

    return feedback_field(build_nearest_partition(scene), prepared, Kinematics.EXACT)


def velocities_around(field: CellwiseField, x: Floats) -> Floats:
    """Fields of the cells beside a position, told from their sides alone."""
    beside = [
        member.velocity(0.0, x)
        for polygon, member in zip(field.cells.polygons, field.members, strict=True)
        if all(side.normal[0] * x[0] + side.normal[1] * x[1] <= side.offset + BESIDE for side in polygon.sides)
    ]
    return np.array(beside)


def distance_from_inclusion(field: CellwiseField, path: Trajectory, time: float) -> float:
    """How far the velocity of a path is from the hull of the velocities around; relative to these, if above one."""
    before, here, after = path.sample([time - MOMENT, time, time + MOMENT])
    around = velocities_around(field, here)
    return origin_distance(around - (after - before) / (2 * MOMENT)) / max(1.0, float(np.abs(around).max()))


def energies(path: Trajectory, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> Floats:
    """V along a path."""
    x, y, theta = path.array.T
    return np.asarray((1 + shape[0]) * x**2 + 2 * shape[1] * x * y + (1 - shape[0]) * y**2 + weight * theta**2)


def assert_is_a_solution(field: CellwiseField, path: Trajectory) -> None:
    """In the differential inclusion, at even times and close about every event."""
    events = np.unique([float(event.t) for event in path.events])
    late = [time + step for time in events for step in (1e-6, 1e-5, 1e-4, 1e-3)]
    times = [*np.linspace(1e-3, path.end.t - 1e-3, 300), *late]
    for time in times:
        if np.abs(events - time).min() > 2 * MOMENT and time < path.end.t - MOMENT:
            assert distance_from_inclusion(field, path, time) < OFF, time


@pytest.mark.parametrize(("seed", "start"), TWO_FOLDS)
def test_rounding_does_not_decide_how_a_two_fold_is_passed(
    arrays: Arrays, seed: int, start: tuple[float, float, float]
) -> None:
    """Wherever among speeds that count as zero a slide is found to end: where one is, and where both are."""
    field = closed_loop(arrays.cocircular(seed, ROLL))
    for nearby in range(60):
        path = simulate(field, tuple(value * (1 + nearby * 1e-9) for value in start), 1.6)
        assert path.end.reason is EndReason.TIME
        assert path.unique is False


@few(1)
@pytest.mark.parametrize(("seed", "start"), TWO_FOLDS)
def test_a_slide_goes_through_a_two_fold(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    field = closed_loop(arrays.cocircular(seed, ROLL))
    path = simulate(field, start, 6.0)
    assert path.end.reason is EndReason.TIME
    assert len(path.events) < 50
    assert_is_a_solution(field, path)
    assert (np.diff(energies(path)) <= 1e-12).all()
    fold = next(event for event in path.events if event.kind == "nonunique")
    x = np.array(fold.state)
    around = velocities_around(field, x)
    across = np.array([-x[1], x[0], 0.0]) / np.hypot(*x[:2])  # the edges of these arrays lead to the origin
    assert np.abs(around @ across).max() <= 1e-8  # both are tangent
    assert np.ptp(around, axis=0).max() > 0.1  # and still differ
    assert path.unique is False


def test_a_stiff_slide_into_a_two_fold_is_followed(arrays: Arrays) -> None:
    shape, weight = (19 / 64, -41 / 64), 8.0  # of the V that is certified for this array
    wheels = [WheelData((-2, 1), (1, 0)), WheelData((-1, 2), (-1, 1)), WheelData((1, -2), (-1, -3))]
    scene = arrays.scene([*wheels, WheelData((1, 2), (2, 3))], ROLL, radius=Fraction(5, 2))
    field = closed_loop(scene, shape, weight)
    path = simulate(field, (0.1775988071108182, 1.412774159257611, 0.25322290401431646), 12.0)
    assert path.end.reason is EndReason.TIME
    assert "Radau" in path.method
    assert_is_a_solution(field, path)
    assert (np.diff(energies(path, shape, weight)) <= 1e-12).all()


def test_weights_in_a_two_fold_by_a_line_that_is_known() -> None:
    """With speeds ``N_1 = a, N_2 = b`` and constant drifts the slide on ``b = -2 a`` is a straight line."""
    drifts = {1: (1.0, -3.0), -1: (1.0, 0.0)}
    surfaces = (affine_surface("z", (0, 0, 1)),)
    field = SignField(
        ("a", "b", "z"), surfaces, lambda signs: lambda t, x: np.array([*drifts[signs[0]], x[0 if signs[0] > 0 else 1]])
    )
    share = 2 / 3  # l a + (1 - l) b = 0 on the line
    speed = share * np.array(drifts[1]) + (1 - share) * np.array(drifts[-1])
    path = simulate(field, (*(-speed), 0.0), 2.0)
    assert path.end.reason is EndReason.TIME
    assert np.allclose(path.sample([0.5, 1.0])[:, :2], [-speed / 2, 0 * speed], atol=1e-8)


@few(1)
@pytest.mark.parametrize(("seed", "start"), HOMECOMINGS)
def test_a_slide_comes_home(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    field = closed_loop(arrays.cocircular(seed, ROLL))
    path = simulate(field, start, 6.0)
    assert path.end.reason is EndReason.TIME
    assert path.unique
    assert len(path.times) < 1000  # tens of thousands before, and no end
    assert_is_a_solution(field, path)
    values = energies(path)
    assert (np.diff(values) <= 1e-12 * values[0]).all()
    assert values[-1] < 1e-30


@few(1)
@pytest.mark.parametrize(("seed", "start"), HOMECOMINGS)
def test_home_may_lie_anywhere(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    """Rounding of the coordinates grows with the distance from their origin; the path does not care."""
    scene = arrays.cocircular(seed, ROLL)
    dx, dy = move = scene.field(Fraction(31, 7)), scene.field(Fraction(-45, 11))
    wheels = tuple(replace(w, position=(w.position[0] + dx, w.position[1] + dy)) for w in scene.wheels)
    moved = replace(scene, wheels=wheels, check=replace(scene.check, equilibrium=move))
    by = np.array([float(dx), float(dy), 0.0])
    times = np.linspace(0, 6, 25)
    far = simulate(closed_loop(moved), (np.array(start) + by).tolist(), 6.0).sample(times) - by
    assert np.abs(far - simulate(closed_loop(scene), start, 6.0).sample(times)).max() < 1e-9  # corners: 1e-10
