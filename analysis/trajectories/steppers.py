"""Steppers: methods that solve one mode of a path, in steps with dense output.

:class:`Integrator` is any method of SciPy's.  :class:`StiffAware` takes DOP853 while accuracy rules its step, and Radau
once stability does: where a motion decays fast towards a slow one (feedback of high gain), the step of an explicit
method is held at the border of its region of stability, however little happens, and the number of steps grows with the
gain.  So every :data:`PROBED` steps the fastest decay is measured, ``rate = -min Re eig(df/dx)`` by forward
differences.  If it holds the step (``h rate >= HELD``; DOP853 is stable up to about 6) and many more such steps lie
ahead, the rest is integrated by Radau IIA of order 5, which is implicit and damps at every step (Hairer & Wanner 1996,
sec. IV.2 and IV.8).  Oscillations without decay never count as stiff: an implicit method would not gain there.

Another method is a class with ``steps``, as in ``tests/rehearsals/midpoint.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.follow import DenseStep, Interpolant, Rate
from nonsmooth.analysis.trajectories.result import TrajectoryError

# Growth of the step that DOP853 proposes: its error was some (0.9/4)^8 of the tolerance, a millionth.
EASY_GROWTH = 4.0
IMPLICIT_STEP = 120  # evaluations of all fields that cost as much as an implicit step
PROBED = 50  # steps from one measurement to the next: four evaluations each, against 12 per step of DOP853
# Step times rate: what is stable is 6, but two may cost steps that the fast motion spoils; at 1e-12 accuracy alone
# keeps it well below.
HELD = 1.5
MANY = 500  # steps still to go at the present size: fewer are cheaper than an implicit method
DIFFERENCE = 1e-8  # step of the differences, relative to the states: half the digits, plenty for a rate
# Step of the differences for Radau, relative to the size of the states, however small a state is: SciPy's own shrinks
# with each state, and finds but rounding once one of them is zero and others are not.
JACOBIAN_STEP = 1e-11


def stepped(solver: Any, *, again: Callable[[], Interpolant] | None = None, easy: bool = False) -> DenseStep:
    """The next step of one of SciPy's solvers.

    Raises:
        TrajectoryError: where the solver gives up.
    """
    before, evaluations = (solver.t, solver.y), solver.nfev
    message = solver.step()
    if solver.status == "failed":
        raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
    work = solver.nfev - evaluations
    return DenseStep(before, (float(solver.t), solver.y), solver.dense_output, again=again, easy=easy, work=work)


class Integrator:
    """One of SciPy's methods for ordinary differential equations.

    Args:
        method: its name in :mod:`scipy.integrate`.
        rtol, atol: tolerances per step, relative and absolute.
        exact_slopes: whether an implicit method takes the ``jacobian`` of a rate that has one; else differences.
    """

    def __init__(self, method: str, rtol: float, atol: float | Vector, *, exact_slopes: bool = True) -> None:
        self._method, self._tolerances, self._exact_slopes = method, {"rtol": rtol, "atol": atol}, exact_slopes

    def steps(self, rate: Any, t: float, x: Vector, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time."""
        from scipy import integrate

        jacobian = getattr(rate, "jacobian", None) if self._exact_slopes else None
        options = {} if jacobian is None else {"jac": jacobian}
        solver = getattr(integrate, self._method)(rate, t, x, until, **self._tolerances, **options)
        begun = solver.nfev
        while solver.status == "running":
            step = stepped(solver)
            step.work, begun = step.work + begun, 0
            yield step


class FixedSteps:
    """The classical Runge-Kutta method of fourth order, with steps of one size, and straight lines between."""

    def __init__(self, size: float) -> None:
        self._size = size

    def steps(self, rate: Rate, t: float, x: Vector, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time; the last one is shorter."""
        while t < until:
            h = min(self._size, until - t)
            k1 = rate(t, x)
            k2 = rate(t + h / 2, x + h / 2 * k1)
            k3 = rate(t + h / 2, x + h / 2 * k2)
            k4 = rate(t + h, x + h * k3)
            mean = (k1 + 2 * k2 + 2 * k3 + k4) / 6
            yield DenseStep((t, x), (t + h, x + h * mean), partial(_straight, t, x, mean))
            t, x = t + h, x + h * mean


def _straight(start: float, x: Vector, rate: Vector) -> Interpolant:
    return lambda t: (x + np.multiply.outer(t - start, rate)).T


class StiffAware:
    """DOP853, until a stretch turns out stiff; Radau from there on, and rest where nothing moves any more.

    Args:
        rtol, atol: tolerances per step, relative and absolute.
        size: the unit of the states.

    Attributes:
        was_stiff: whether any stretch so far was.
    """

    def __init__(self, rtol: float, atol: float, size: float) -> None:
        self._tolerances, self._size = {"rtol": rtol, "atol": atol}, size
        self._step: float | None = None  # of the last stretch, to begin the next one with
        self.was_stiff = False

    def steps(self, rate: Rate, t: float, x: Vector, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time."""
        from scipy.integrate import DOP853

        first = None if self._step is None else min(self._step, until - t)
        solver, taken = DOP853(rate, t, x, until, first_step=first, **self._tolerances), 1
        while solver.status == "running" and (taken % PROBED or not holds_the_step(rate, solver, until, self._size)):
            yield self._explicit(rate, solver)
            taken += 1
        if solver.status == "running":
            self.was_stiff = True
            yield from self._implicit_steps(rate, solver, until)

    def _explicit(self, rate: Rate, solver: Any) -> DenseStep:
        """A step of DOP853; its dense output, which costs evaluations, is made late: by taking the step once more."""
        start, x, slope = solver.t, solver.y, solver.f

        def again() -> Interpolant:
            from scipy.integrate import DOP853

            same = DOP853(rate, start, x, step.end, first_step=step.end - start, **self._tolerances)
            same.step()
            return same.dense_output()

        step = stepped(solver, again=again)
        self._step = step.end - float(start)
        step.slopes, step.easy = (slope, solver.f), solver.h_abs >= EASY_GROWTH * self._step
        return step

    def _implicit_steps(self, rate: Rate, explicit: Any, until: float) -> Iterator[DenseStep]:
        """Radau, from where an explicit solver is."""
        from scipy.integrate import Radau

        jacobian, atol = jacobian_of(rate, self._size), self._tolerances["atol"]
        first = explicit.step_size
        solver = Radau(rate, explicit.t, explicit.y, until, jac=jacobian, first_step=first, **self._tolerances)
        while solver.status == "running":
            slope = solver.f
            step = stepped(solver, easy=True)
            self._step, step.work, step.slopes = step.end - step.start, IMPLICIT_STEP, (slope, solver.f)
            yield step
            if solver.status == "running" and comes_to_rest(rate, solver, until, self._size, atol):
                yield _resting(step, until)
                return


def _resting(step: DenseStep, until: float) -> DenseStep:
    """A step in which the last state stays."""
    last = step.last

    def still(t: Any) -> Vector:
        return last if np.ndim(t) == 0 else np.repeat(last[:, None], len(t), axis=1)

    return DenseStep((step.end, last), (until, last), lambda: still)


# ---- stiffness -----------------------------------------------------------------------------------


def holds_the_step(rate: Rate, solver: Any, until: float, size: float) -> bool:
    """Whether stability, not accuracy, rules the step of an explicit solver, with many steps to go."""
    step = float(solver.step_size)
    if until - solver.t <= MANY * step:
        return False
    return decay_rate(rate, float(solver.t), solver.y, size) * step >= HELD


def decay_rate(rate: Rate, t: float, x: Vector, size: float) -> float:
    """``-min Re eig(df/dx)``, 1/time; ``size`` is the unit of the states.

    Zero where nothing decays or the field is not finite beside the state.
    """
    return max(0.0, -float(_eigenvalues(rate, t, x, DIFFERENCE * np.maximum(np.abs(x), DIFFERENCE * size)).min()))


def comes_to_rest(rate: Rate, solver: Any, until: float, size: float, atol: float) -> bool:
    """Whether what is left moves the state by less than the tolerance, and nothing beside it grows until the end.

    Below the tolerance the field is rounding, on which an implicit method would take tiny steps for ever.
    """
    left = until - float(solver.t)
    if float(np.abs(rate(float(solver.t), solver.y)).max()) * left > atol:
        return False
    growth = _eigenvalues(rate, float(solver.t), solver.y, np.full(len(solver.y), DIFFERENCE * size))
    return float(growth.max()) * left <= 1


def jacobian_of(rate: Rate, size: float) -> Callable[[float, Vector], Vector]:
    """``df/dx`` for an implicit solver, as a function of time and state."""

    def jacobian(t: float, x: Vector) -> Vector:
        return _differences(rate, t, x, JACOBIAN_STEP * np.maximum(np.abs(x), size))

    return jacobian


def _eigenvalues(rate: Rate, t: float, x: Vector, steps: Vector) -> Vector:
    """Real parts of the eigenvalues of ``df/dx`` by forward differences; zeros where the field is not finite."""
    jacobian = _differences(rate, t, x, steps)
    if not np.isfinite(jacobian).all():
        return np.zeros(len(x))
    return np.asarray(np.linalg.eigvals(jacobian).real)


def _differences(rate: Rate, t: float, x: Vector, steps: Vector) -> Vector:
    """``df/dx`` by forward differences."""
    here = rate(t, x)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.column_stack([(rate(t, x + move) - here) / move[k] for k, move in enumerate(np.diag(steps))])
