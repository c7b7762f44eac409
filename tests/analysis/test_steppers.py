"""Our DOP853 against SciPy's: the same steps and the same solution between them, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import DOP853

from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.steppers import STAGES, Dop853
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
