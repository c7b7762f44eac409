"""Hysteresis and smoothed signs converge to the event-driven path, with errors of the order of their width."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.feedback_laws import corrected_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import SwitchedField, affine_surface
from nonsmooth.analysis.trajectories import hysteresis
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from tests.conftest import Arrays
from tests.four_wheel import ROLL
from tests.thorough import few

START, UNTIL = (0.4, 0.15, 0.0), 0.5
Method = Callable[[SwitchedField, float], Trajectory]
METHODS: dict[str, Method] = {
    "adaptive": lambda field, width: simulate_hysteresis(field, START, UNTIL, width),
    "fixed step": lambda field, width: simulate_hysteresis(field, START, UNTIL, width, step=width),
    "smoothed": lambda field, width: simulate_smoothed(field, START, UNTIL, width),
}
ERROR_PER_WIDTH = 4.0  # the zigzag overshoots by a width and a step, in each of two directions


def relay_system() -> SignField:
    """x' = -sgn(x - y/3) - 1/4, y' = 1/2 - y, theta' = sgn(y - 1/4)/4: slides along one line, crosses the other."""
    surfaces = (affine_surface("x - y/3", (1, -1 / 3, 0)), affine_surface("y - 1/4", (0, 1, 0), 0.25))
    return SignField(
        ("x", "y", "theta"), surfaces, lambda s: lambda t, x: np.array([-s[0] - 0.25, 0.5 - x[1], s[1] / 4])
    )


def error(path: Trajectory, reference: Trajectory) -> float:
    return float(np.abs(reference.sample(path.times) - path.array).max())


@pytest.fixture(params=["leading", "exact", "feedback", "plain"])
def field(request: pytest.FixtureRequest, arrays: Arrays) -> SwitchedField:
    if request.param == "plain":
        return relay_system()
    partition = build_nearest_partition(arrays.four_wheel())
    if request.param == "feedback":
        return feedback_field(partition, corrected_law(1), Kinematics.EXACT)
    return array_field(partition, Kinematics(request.param))


@few(3)
@pytest.mark.parametrize("method", METHODS)
def test_errors_shrink_with_the_width(field: SwitchedField, method: str) -> None:
    reference = simulate(field, START, UNTIL)
    for width in (2e-2, 5e-3, 1e-3):
        path = METHODS[method](field, width)
        assert error(path, reference) <= ERROR_PER_WIDTH * width
        assert path.end.t == UNTIL
        assert path.unique is None


def test_switches_are_counted_and_multiply_as_the_width_shrinks(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING)
    counts = [len(METHODS["adaptive"](field, width).events) for width in (1e-2, 1e-3)]
    assert counts[1] > 5 * counts[0] > 0
    path = METHODS["adaptive"](field, 1e-2)
    assert {event.kind for event in path.events} == {EventKind.CROSS}
    assert path.events[0].surface == "cell 2 | cell 1"
    assert path.method == "hysteresis"


def test_a_relay_keeps_the_period_of_its_width() -> None:
    """x' = -sgn x with hysteresis w is a triangle wave of period 4 w: switches every 2 w after the first."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    width = 0.05
    path = simulate_hysteresis(field, (0.2,), 1, width)
    times = [event.t for event in path.events]
    assert times[0] == pytest.approx(0.2 + width, abs=1e-9)
    assert np.diff(times) == pytest.approx(2 * width, abs=1e-9)


def test_paths_end_at_the_border_of_the_domain(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.pushed(1, 1)), Kinematics.LEADING)
    path = simulate_hysteresis(field, (0.2, 0.1, 0), 5, 1e-3)
    assert path.end.reason is EndReason.OUTSIDE
    assert max(abs(v) for v in path.end.state[:2]) == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(("width", "step"), [(0, None), (-1, None), (math.nan, None), (1e-2, 0)])
def test_widths_and_steps_are_positive(arrays: Arrays, width: float, step: float | None) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel(ROLL)), Kinematics.LEADING)
    with pytest.raises(ValueError, match="positive"):
        simulate_hysteresis(field, START, 1, width, step)
    if step is None:
        with pytest.raises(ValueError, match="positive"):
            simulate_smoothed(field, START, 1, width)


def test_starts_are_inside(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING)
    for method in (simulate_hysteresis, simulate_smoothed):
        with pytest.raises(ValueError, match="inside the domain"):
            method(field, (2, 0, 0), 1, 1e-2)


@pytest.mark.parametrize("width", [1e-17, 1e-30, 1e-300])
def test_a_width_that_floats_do_not_resolve_is_refused_at_once(width: float) -> None:
    """Its zigzag would never get on."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    with pytest.raises(ValueError, match="required a width whose switches floats resolve, received"):
        simulate_hysteresis(field, (0.5,), 1.0, width)


def test_a_tiny_width_is_followed_where_floats_resolve_it() -> None:
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    path = simulate_hysteresis(field, (0.0,), 1e-11, 1e-13)
    assert len(path.events) == 50  # one after every 2e-13 but the first, which takes 1e-13
    assert max(abs(state[0]) for state in path.states) <= 1.001e-13


@pytest.mark.parametrize("width", [1e-6, 5e-10, 1e-13])
def test_a_surface_away_from_the_origin_is_crossed_once(width: float) -> None:
    """Floats know the height above ``v = 1/2`` to 1e-16, which is less than all but a billionth of these widths."""
    surface = affine_surface("v - 1/2", (0, 1), 0.5)
    field = SignField(("x", "v"), (surface,), lambda signs: lambda t, x: np.array([x[1], -1.0]), 1.0)
    path = simulate_hysteresis(field, (0.3, 0.5 + 1e-3), 0.1, width)
    assert len(path.events) == 1
    assert float(path.end.t) == 0.1


def test_a_layer_that_is_never_crossed_is_refused(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thinner than the tolerance, it would be integrated for ever."""
    field = array_field(build_nearest_partition(arrays.four_wheel(ROLL)), Kinematics.EXACT)
    monkeypatch.setattr(hysteresis, "MAX_EVALUATIONS", 5_000)
    assert simulate_smoothed(field, START, UNTIL, 1e-3).end.t == UNTIL
    with pytest.raises(ValueError, match="required a width that 5000 evaluations resolve, received 1e-12"):
        simulate_smoothed(field, START, UNTIL, 1e-12)


def test_a_zigzag_of_too_many_switches_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A relay at rest switches every four widths: work grows like one over the width."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    monkeypatch.setattr(hysteresis, "MAX_RELAY_EVALUATIONS", 20_000)
    assert simulate_hysteresis(field, (0.0,), 1.0, 1e-2).end.t == 1.0
    with pytest.raises(ValueError, match="required a width that 20000 evaluations resolve, received 1e-06"):
        simulate_hysteresis(field, (0.0,), 1.0, 1e-6)
