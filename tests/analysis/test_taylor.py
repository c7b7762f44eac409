"""Taylor series of affine motions against the matrix exponential, and paths with them against paths without."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from scipy.linalg import expm

from nonsmooth.analysis.fields.switched_field import AffineVelocity, ScalarVelocity
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.steppers import DEGREE, StiffAware, TaylorSteps, series_code
from nonsmooth.analysis.trajectories.trajectory import follow_smooth
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.plain import built

ROUNDING = 1e-14  # of states of size one after a step


def affine(matrix: object, offset: object) -> AffineVelocity:
    a, b = np.array(matrix, float), np.array(offset, float)
    return AffineVelocity(lambda *x: tuple((a @ np.array(x) + b).tolist()), a, b)


def exactly(matrix: Floats, offset: Floats, x: Floats, t: float) -> Floats:
    """``x(t)`` by the exponential of ``((A, b), (0, 0))``."""
    count = len(x)
    block = np.zeros((count + 1, count + 1))
    block[:count, :count], block[:count, count] = matrix, offset
    return np.asarray((expm(block * t) @ np.append(x, 1.0))[:count])


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_steps_are_the_exponential(count: int, scale: float) -> None:
    random = np.random.default_rng(count)
    for _ in range(20):
        matrix, offset, x = (scale * random.normal(size=(count, count)), random.normal(size=count), np.ones(count))
        velocity = affine(matrix, offset * scale)
        step = TaylorSteps(velocity, 1.0, x, 1e9).step()
        length = step.end - step.start
        assert 0.3 < velocity.size * length <= 2.0 + 1e-9
        for share in (0.3, 0.7, 1.0):
            t = step.start + share * length
            found, there = step(t), exactly(matrix, offset * scale, x, t - 1.0)
            rounding = ROUNDING + velocity.size * np.spacing(t)  # of the time that the exponential is told
            assert found == pytest.approx(there, abs=10 * rounding * max(1.0, float(np.abs(there).max())))
        slope = np.asarray(step.slopes)[1]
        assert slope == pytest.approx(matrix @ step.last + offset * scale, rel=1e-12, abs=1e-12 * scale)


def test_motions_that_are_polynomials_take_one_step() -> None:
    thrown = affine([[0, 1e6], [0, 0]], [0, -9.81])
    step = TaylorSteps(thrown, 0.0, np.array([2.0, 3.0]), 1e8).step()
    assert step.end == 1e8
    t = 1e7
    assert step(t) == pytest.approx([2 + 3e6 * t - 9.81e6 * t**2 / 2, 3 - 9.81 * t], rel=1e-14)
    at_rest = TaylorSteps(affine(np.zeros((3, 3)), [1, 2, 3]), 0.0, np.zeros(3), 5.0).step()
    assert at_rest.last.tolist() == [5, 10, 15]


def test_fast_and_slow_parts_keep_their_digits() -> None:
    """Rounding of the fast one would grow in steps that are too long for it."""
    velocity = affine([[-1e4, 0], [0, -1]], [0, 0])
    solver = TaylorSteps(velocity, 0.0, np.array([0.0, 1.0]), 0.1)
    while solver.t < 0.1:
        solver.step()
    assert solver.y == pytest.approx([0, np.exp(-0.1)], abs=ROUNDING)


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:overflow")
def test_a_motion_beyond_floats_ends_the_steps() -> None:
    solver = TaylorSteps(affine([[1e200]], [0]), 1.0, np.array([1e200]), 2.0)
    with pytest.raises(TrajectoryError, match="floats do not hold its next step"):
        solver.step()


def test_stiff_motions_go_on_implicitly() -> None:
    velocity = affine([[-1e6, 0], [1, -1]], [0, 0])
    method = StiffAware(1e-10, 1e-12, 1.0)
    steps = list(method.steps(velocity, 0.0, np.ones(2), 10.0))
    assert method.was_stiff
    assert len(steps) < 1000
    assert steps[-1].last == pytest.approx([0, np.exp(-10)], abs=1e-9)


@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "-x - sign(y)"],
        ["y", "z", "-sign(x) - y - 2*z"],
        ["-x + 3*y - sign(y)", "-3*x - y/2 + max(x, 0)"],
    ],
)
def test_paths_are_those_of_runge_kutta(rhs: list[str]) -> None:
    """The same events at the same times as with DOP853, of which it is hidden that the field is affine."""
    field = system_field(built(rhs))
    plain = replace(field, flow=lambda signs: ScalarVelocity(cast("AffineVelocity", field.flow(signs)).rates))
    paths = [follow_smooth(own, [0.9, -0.4, 0.3][: len(rhs)], 6.0) for own in (field, plain)]
    one, two = paths
    assert [event.kind for event in one.events] == [event.kind for event in two.events]
    assert [event.t for event in one.events] == pytest.approx([event.t for event in two.events], abs=1e-9)
    assert one.end.state == pytest.approx(two.end.state, abs=1e-9)


def test_the_code_that_is_compiled_holds_names_and_floats_only() -> None:
    names = {name for function in series_code(3) for name in function.__code__.co_names}
    assert names <= {"abs", "max"}
    assert series_code(2).value(0.5, *[1.0] * (DEGREE + 1)) == pytest.approx(2.0, abs=1e-6)
