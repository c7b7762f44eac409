"""Our DOP853 against SciPy's: the same steps and the same solution between them, bit by bit.

In single floats sums are rounded in another order, so there a step is compared within rounding, and by its order.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import DOP853

from nonsmooth.analysis.fields.switched_field import ScalarVelocity, Vector
from nonsmooth.analysis.measurements.harness import log_slope
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.steppers import STAGES, Dop853, ScalarDop853, StiffAware, written_out
from tests.thorough import few

TOLERANCES = {"rtol": 1e-9, "atol": 1e-11}


def van_der_pol(t: float, x: Vector) -> Vector:
    """Its steps are refused now and then."""
    return np.array([x[1], 20 * (1 - x[0] ** 2) * x[1] - x[0] + np.sin(t)])


@few(1)
@pytest.mark.parametrize("first", [None, 1e-3, 0.5])
def test_steps_are_those_of_scipy(first: float | None) -> None:
    start, until, refused = np.array([2.0, 0.0]), 30.0, 0
    theirs = DOP853(van_der_pol, 0.0, start, until, first_step=first, **TOLERANCES)
    ours = Dop853(van_der_pol, 0.0, start, until, first, **TOLERANCES)
    while theirs.status == "running":
        before = theirs.nfev
        step = ours.step()
        theirs.step()
        assert (step.end, ours.step_size, ours.following) == (theirs.t, theirs.step_size, theirs.h_abs)
        assert step.last.tolist() == theirs.y.tolist()
        assert step.work == theirs.nfev - before
        refused += step.work > STAGES
    assert ours.t == until
    assert refused > 2


def test_the_solution_between_is_that_of_scipy_when_it_is_asked_for_late() -> None:
    ours = Dop853(van_der_pol, 0.0, np.array([2.0, 0.0]), 30.0, 1e-2, **TOLERANCES)
    theirs = DOP853(van_der_pol, 0.0, np.array([2.0, 0.0]), 30.0, first_step=1e-2, **TOLERANCES)
    step = ours.step()
    theirs.step()
    between = theirs.dense_output()
    ours.step()
    times = np.linspace(step.start, step.end, 7)
    assert step(times).tolist() == between(times).tolist()
    assert step(float(times[3])).tolist() == between(times[3]).tolist()


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:overflow")
def test_a_field_that_is_no_number_ends_the_steps() -> None:
    solver = Dop853(lambda t, x: x * np.nan, 0.0, np.ones(1), 1.0, 0.1, **TOLERANCES)
    with pytest.raises(TrajectoryError, match="less than spacing between numbers"):
        solver.step()


# ---- single floats -------------------------------------------------------------------------------

ROUNDING = 1e-14  # of states of size one after a step
FIELDS = (
    ScalarVelocity(lambda x: (1 - x * x,)),
    ScalarVelocity(lambda x, y: (y - x * x / 3, -2 * x - y * x)),
    ScalarVelocity(lambda x, y, z: (y * z, -x * z - y, x - z / 2)),
    ScalarVelocity(lambda x, y, z, w: (y, -x + z * w, w * w - z, -y - w / 3)),
)
TURNING = ScalarVelocity(lambda x, y: (y, -x))


@pytest.mark.parametrize("field", FIELDS, ids=("one", "two", "three", "four"))
def test_a_step_in_single_floats_is_that_of_arrays(field: ScalarVelocity) -> None:
    count = 1 + FIELDS.index(field)
    for start in np.random.default_rng(count).uniform(-1, 1, (20, count)):
        single, arrays = (kind(field, 0.5, start, 9.0, 0.3, rtol=1e-3, atol=1e-5) for kind in (ScalarDop853, Dop853))
        ours, theirs = single.step(), arrays.step()
        assert (ours.start, ours.end, ours.work) == (theirs.start, theirs.end, theirs.work)
        assert ours.last == pytest.approx(theirs.last, abs=ROUNDING)
        assert np.array(ours.slopes) == pytest.approx(np.array(theirs.slopes), abs=10 * ROUNDING)
        assert single.following == pytest.approx(arrays.following, rel=1e-6)  # by errors of some 1e-8
        times = np.linspace(ours.start, ours.end, 7)
        assert ours(times) == pytest.approx(theirs(times), abs=ROUNDING)
        assert ours(float(times[3])) == pytest.approx(ours(times)[:, 3], abs=ROUNDING)


def test_a_step_in_single_floats_is_of_order_eight() -> None:
    """Of one step from (1, 0) on the circle the state errs by h^9, and the solution between by h^8."""
    lengths, at_end, between = [1.6, 1.2, 0.9, 0.7], [], []
    for h in lengths:
        step = ScalarDop853(TURNING, 0.0, np.array([1.0, 0.0]), 9.0, h, rtol=1.0, atol=1.0).step()
        assert step.end == h
        at_end.append(float(np.abs(step.last - [np.cos(h), -np.sin(h)]).max()))
        times = np.linspace(0.0, h, 50)
        between.append(float(np.abs(step(times) - [np.cos(times), -np.sin(times)]).max()))
    assert log_slope(lengths, at_end) == pytest.approx(9, abs=0.5)
    assert log_slope(lengths, between) == pytest.approx(8, abs=0.5)


def test_fields_in_single_floats_are_followed_in_them() -> None:
    """The stepper looks at the field: a step asks for its rates and never for arrays, but at the first time."""
    asked = []

    class Watched(ScalarVelocity):
        def __call__(self, t: float, x: Vector) -> Vector:
            asked.append(t)
            return super().__call__(t, x)

    steps = list(StiffAware(1e-9, 1e-11, 1.0).steps(Watched(TURNING.rates), 0.0, np.array([1.0, 0.0]), 3.0))
    assert steps[-1].last == pytest.approx([np.cos(3.0), -np.sin(3.0)], abs=1e-8)
    assert len(steps) > 5
    assert max(asked) < steps[0].end


def test_written_steps_name_two_functions_alone() -> None:
    names = {name for function in written_out(3) for name in function.__code__.co_names}
    assert names == {"abs", "max"}


def test_rates_in_single_floats_may_overflow() -> None:
    solver = ScalarDop853(ScalarVelocity(lambda x: (x * x * x,)), 0.0, np.array([1e200]), 1.0, 0.1, **TOLERANCES)
    with pytest.raises(TrajectoryError, match="less than spacing between numbers"):
        solver.step()
