"""Event-driven simulation against hysteresis and against SciPy's own events; ratios of times within one run."""

from __future__ import annotations

import time
from functools import partial
from statistics import median

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis
from nonsmooth.analysis.trajectories.maps import grid_starts, settle_map
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.steppers import StiffAware
from nonsmooth.analysis.trajectories.trajectory import follow_smooth, simulate
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from tests.benchmarks.conftest import Stopwatch

START, UNTIL = (0.8, 0.3, 0.0), 1.0
REQUIRED_ERROR = 1e-3  # of hysteresis; event-driven paths are exact to rounding
RTOL, ATOL = 1e-11, 1e-13
ROUNDS = 51  # of alternating runs: medians of fewer vary by some hundredths
FLOWER = np.array([[-0.1, 1], [-5, -0.1]]), np.array([[-0.1, 5], [-1, -0.1]])  # switched on the diagonals


@pytest.mark.parametrize("kinematics", list(Kinematics))
def test_events_against_hysteresis(kinematics: Kinematics, stopwatch: Stopwatch) -> None:
    """The cheapest of adaptive and fixed-step hysteresis whose error is at most 1e-3, found by halving its width."""
    field = array_field(build_nearest_partition(load_scene("four-wheel", radius="1")), kinematics)
    reference = simulate(field, START, UNTIL)
    events = stopwatch.best(lambda: simulate(field, START, UNTIL))
    best = np.inf
    for fixed in (False, True):
        width, error = 4e-3, np.inf
        while error > REQUIRED_ERROR:
            width /= 2
            work = partial(simulate_hysteresis, field, START, UNTIL, width, width if fixed else None)
            path = work()
            error = float(np.abs(reference.sample(path.times) - path.array).max())
        best = min(best, stopwatch.best(work, runs=3))
    stopwatch.report(
        f"{kinematics.value}: events {events * 1e3:.2f} ms, hysteresis at an error of 1e-3 {best * 1e3:.1f} ms, "
        f"ratio {best / events:.0f} (required 10)"
    )
    assert best >= 10 * events


def linear(matrix: np.ndarray, t: float, x: np.ndarray) -> np.ndarray:
    """The fastest form for SciPy of those tried: with ``matrix @ x``, or sums of single floats, it takes longer."""
    return np.asarray(matrix.dot(x))


def height(normal: np.ndarray, t: float, x: np.ndarray) -> float:
    return float(normal.dot(x))


def scipy_events(dense: bool) -> np.ndarray:
    """The flower by solve_ivp with terminal events, restarted in the other field at each."""
    t, x, sides = 0.0, np.array([1.0, 0.2]), np.array([1.0, 1.0])
    normals = np.array([[1, -1], [1, 1]])
    while t < UNTIL * 10:
        flow = partial(linear, FLOWER[0] if sides[0] * sides[1] > 0 else FLOWER[1])
        events = [partial(height, side * normal) for side, normal in zip(sides, normals, strict=True)]
        for event in events:
            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]  # SciPy reads these
        part = solve_ivp(
            flow, (t, UNTIL * 10), x, method="DOP853", rtol=RTOL, atol=ATOL, events=events, dense_output=dense
        )
        t, x = float(part.t[-1]), part.y[:, -1]
        for k, found in enumerate(part.t_events):
            sides[k] *= -1 if len(found) else 1
    return np.asarray(x)


def flower_path(field: SignField) -> Trajectory:
    """The same path by our events."""
    return follow_smooth(field, (1.0, 0.2), UNTIL * 10, stepper=StiffAware(RTOL, ATOL, field.size))


def test_dop853_with_events_against_scipy(stopwatch: Stopwatch) -> None:
    """26 crossings, no sliding; medians of ratios of alternating runs.  Our path can be evaluated anywhere.

    Ours is the built-in system as it is stated.
    """
    field = system_field(load_system("flower"))

    def ours() -> np.ndarray:
        return np.array(flower_path(field).end.state)

    assert ours() == pytest.approx(scipy_events(dense=False), abs=1e-9)
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(ROUNDS):
        start = time.perf_counter()
        ours()
        own = time.perf_counter() - start
        for dense, values in ratios.items():
            start = time.perf_counter()
            scipy_events(dense)
            values.append((time.perf_counter() - start) / own)
    stopwatch.report(
        f"SciPy's events take {median(ratios[True]):.2f} times as long with dense output, "
        f"{median(ratios[False]):.2f} times without (required 4)"
    )
    assert median(ratios[True]) >= 4
    assert median(ratios[False]) >= 4


@pytest.mark.parametrize("name", ["four-wheel", "spiral-30"])
@pytest.mark.parametrize("kinematics", list(Kinematics))
def test_maps_of_200_by_200_starts(name: str, kinematics: Kinematics, stopwatch: Stopwatch) -> None:
    field = array_field(build_nearest_partition(load_scene(name)), kinematics)
    seconds = stopwatch.best(lambda: settle_map(field, grid_starts(field, 200)), runs=1)
    stopwatch.report(f"{name}, {kinematics.value}: 200 x 200 starts in {seconds:.2f} s (required 20)")
    assert seconds <= 20
