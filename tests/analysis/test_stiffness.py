"""Stiff stretches: when Radau takes over, and that nothing is lost by it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.cellwise_field import CellwiseField, feedback_field
from nonsmooth.analysis.fields.feedback_laws import corrected_law, gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Vector, affine_surface
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.smooth_path import EXPLICIT, IMPLICIT
from nonsmooth.analysis.trajectories.steppers import comes_to_rest, decay_rate
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.conftest import Arrays
from tests.four_wheel import ROLL
from tests.thorough import few

ACCURACY = 1e-10  # a hundred steps of 1e-12 each
FEW = 1_000  # samples: an explicit method would need a million
START = (0.2, 0.1, 0.3)


def closed_loop(gain: float) -> CellwiseField:
    partition = build_nearest_partition(load_scene("four-wheel"))
    return feedback_field(partition, corrected_law(gain), Kinematics.EXACT)


def linear(matrix: Vector) -> SignField:
    """``x' = A x``, with a surface that is never met."""
    return SignField(("x", "y"), (affine_surface("far", (1.0, 0.0), -10.0),), lambda signs: lambda t, x: matrix @ x)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_the_decay_rate_is_that_of_the_fastest_mode(size: float) -> None:
    turn = np.array([[3.0, -4.0], [4.0, 3.0]]) / 5
    matrix = turn @ np.diag([-7e5, -2.0]) @ turn.T
    found = decay_rate(lambda t, x: matrix @ x, 0.0, size * np.array([0.3, 0.7]), size)
    assert found == pytest.approx(7e5, rel=1e-6)
    assert decay_rate(lambda t, x: -matrix @ x, 0.0, np.array([0.3, 0.7]), 1.0) == 0
    assert decay_rate(lambda t, x: np.full(2, math.inf), 0.0, np.ones(2), 1.0) == 0


@few(1)
@pytest.mark.parametrize("gain", [1e4, 1e6, 1e8])
def test_feedback_of_high_gain_is_that_of_gain_one_in_its_own_time(gain: float) -> None:
    slow, fast = simulate(closed_loop(1), START, 6), simulate(closed_loop(gain), START, 2)
    assert (slow.method, fast.method) == (EXPLICIT, IMPLICIT)
    assert fast.end.reason is EndReason.TIME
    assert len(fast.times) < FEW
    times = np.linspace(0, 6, 40)
    assert np.abs(fast.sample(times / gain) - slow.sample(times)).max() <= ACCURACY
    assert np.abs(np.array(fast.end.state)).max() <= ACCURACY


def test_a_stiff_path_follows_its_slow_part_between_the_steps_too() -> None:
    path = simulate(linear(np.array([[-1.0, 0.0], [0.0, -1e7]])), (1.0, 1.0), 3.0)
    assert path.method == IMPLICIT
    assert len(path.times) < FEW
    times = np.linspace(0, 3, 77)
    assert np.abs(path.sample(times)[:, 0] - np.exp(-times)).max() <= ACCURACY
    assert np.abs(path.sample(times[1:])[:, 1]).max() <= ACCURACY


def test_a_loop_that_is_down_to_rounding_rests(arrays: Arrays) -> None:
    """At the equilibrium the corrected law is rounding, on which Radau once took tiny steps without end."""
    partition = build_nearest_partition(arrays.cocircular(4))
    path = simulate(feedback_field(partition, corrected_law(1e6), Kinematics.EXACT), (0.417, 0.244, 0.3), 2.0)
    assert (path.method, path.end.reason) == (IMPLICIT, EndReason.TIME)
    assert len(path.times) < FEW
    assert np.abs(path.sample([1.0, 1.5, 2.0])).max() <= ACCURACY


@pytest.mark.parametrize(("growth", "rests"), [(-1.0, True), (0.1, True), (40.0, False)])
def test_what_grows_until_the_end_does_not_rest(growth: float, rests: bool) -> None:
    matrix = np.diag([growth, -1e6])

    class At:
        t, y = 0.0, np.array([1e-20, 1e-20])

    assert comes_to_rest(lambda t, x: matrix @ x, At, 1.0, 1.0, 1e-13) is rests
    assert not comes_to_rest(lambda t, x: matrix @ x + 1e-3, At, 1.0, 1.0, 1e-13)


def test_oscillations_are_not_stiff() -> None:
    path = simulate(linear(np.array([[0.0, 1.0], [-1.0, 0.0]])), (1.0, 0.0), 400.0)
    assert path.method == EXPLICIT
    assert path.end.state == pytest.approx((math.cos(400), -math.sin(400)), abs=1e-9)


@pytest.mark.parametrize(("seed", "start"), [(2, (-0.286, -0.242, 0.377)), (36, (-0.383, -0.122, 0.473))])
def test_a_trial_step_beyond_floats_is_shortened(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    """Exact kinematics under feedback are cubic in the pose, so a step too long for the next cell overflows.

    ``V = |c|^2 + theta^2`` falls all the same.
    """
    partition = build_nearest_partition(arrays.cocircular(seed, ROLL))
    path = simulate(feedback_field(partition, gradient_law(1.0), Kinematics.EXACT), start, 3)
    assert path.end.reason is EndReason.TIME
    heights = (np.array(path.states) ** 2).sum(axis=1)
    assert (np.diff(heights) <= ACCURACY).all()
    assert heights[-1] < heights[0] / 2


def test_a_slide_is_stiff_before_its_step_is_as_long_as_is_stable(arrays: Arrays) -> None:
    """A rate of 820 holds the step at 1.8 of its inverse; along the edge little happens in 12 units of time."""
    partition = build_nearest_partition(arrays.cocircular(57, ROLL))
    shape = (49 / 64, 17 / 32)  # of the V that is certified for this array
    field = feedback_field(partition, gradient_law(1.0, shape), Kinematics.EXACT)
    path = simulate(field, (-0.31157103, 0.80144174, -0.25690855), 12.0)
    assert path.method == IMPLICIT
    assert len(path.times) < FEW  # 4,874 with DOP853
    x, y, theta = path.array.T
    values = (1 + shape[0]) * x**2 + 2 * shape[1] * x * y + (1 - shape[0]) * y**2 + theta**2
    assert (np.diff(values) < 0).all()
    assert np.abs(path.array[-1] - [-0.1200123462, 0.3360345692, 0.0270193447]).max() < 1e-6  # DOP853's, from nearby
