"""One stretch of a smooth path: DOP853 on a face until the first of its guards falls below zero.

Where the stretch turns out stiff (:mod:`nonsmooth.analysis.trajectories.stiffness`), Radau takes over.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.analysis.fields.switched_field import FacedField, Surface, Vector, Velocity
from nonsmooth.analysis.trajectories.face_motion import FaceMotion
from nonsmooth.analysis.trajectories.faces import FaceChoice
from nonsmooth.analysis.trajectories.guards import IntegratorStep, Interpolant, first_event, guards_of
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.stiffness import (
    PROBED,
    comes_to_rest,
    holds_the_step,
    jacobian_of,
)
from nonsmooth.symbolic.under_way import tell

# Growth of the step that DOP853 proposes: its error was some (0.9/4)^8 of the tolerance, a millionth.
EASY_GROWTH = 4.0
IMPLICIT_STEP = 120  # evaluations of all fields that cost as much as an implicit step


@dataclass(frozen=True)
class Stretch:
    """A piece of solution.

    Attributes:
        times: step times, the event last.
        states: states at those times.
        interpolants: dense output of each step.
        met: the surface it met at its end, if any.
        step: size of the last full step, to start the next stretch with.
        work: evaluations of the members' fields; an implicit step counts as as many as it costs.
        stiff: whether an implicit method took over.
    """

    times: list[float]
    states: list[Vector]
    interpolants: list[Interpolant]
    met: tuple[Surface, ...]
    step: float
    work: int
    stiff: bool = False

    @property
    def end(self) -> Vector:
        """Last state."""
        return self.states[-1]

    def state_since_start(self, time: Any) -> tuple[float, ...]:
        """State a time after the start."""
        return tuple(self.state_at(self.times[0] + float(time)).tolist())

    def states_since_start(self, times: Vector) -> Vector:
        """States (m, n) at many times after the start: each step's dense output is asked once."""
        asked = self.times[0] + times
        steps = np.searchsorted(self.times, asked, side="right") - 1
        found = np.empty((len(asked), self.end.size))
        by_step = np.argsort(steps, kind="stable")
        for own in np.split(by_step, np.flatnonzero(np.diff(steps[by_step])) + 1):
            if not own.size:
                continue
            k = int(steps[own[0]])
            if k >= len(self.interpolants):
                found[own] = self.end
            else:
                found[own] = self.interpolants[k](asked[own]).T
                found[own[asked[own] == self.times[k]]] = self.states[k]
        return found

    def state_at(self, t: float) -> Vector:
        """State at a time of the path."""
        k = bisect_right(self.times, t) - 1
        if k >= len(self.interpolants):
            return self.states[-1]
        return self.states[k] if t == self.times[k] else self.interpolants[k](t)


class _LateInterpolant:
    """Dense output of a step, made only when it is asked for: by taking the same step once more."""

    def __init__(
        self, motion: FaceMotion, start: tuple[float, Vector], end: float, tolerances: tuple[float, float]
    ) -> None:
        self._data = motion, start, end, tolerances
        self._made: Interpolant | None = None

    def __call__(self, t: Any) -> Vector:
        """State at a time within the step, or states (n, m) at many."""
        if self._made is None:
            from scipy.integrate import DOP853

            motion, (first, x), end, (rtol, atol) = self._data
            solver = DOP853(motion, first, x, end, rtol=rtol, atol=atol, first_step=end - first)
            solver.step()
            self._made = solver.dense_output()
        return np.asarray(self._made(t))


@np.errstate(over="ignore", invalid="ignore")  # a trial beyond floats is refused, and a shorter one made
def follow_face(
    field: FacedField,
    choice: FaceChoice,
    start: tuple[float, Vector],
    until: float,
    *,
    tolerances: tuple[float, float],
    first_step: float | None,
    most_work: int,
) -> Stretch:
    """Integrate a face's motion to its first event, or to ``until``, or until it has done its work.

    Raises:
        TrajectoryError: where the integrator gives up, or what tells events is not a number.
    """
    from scipy.integrate import DOP853

    t, x = start
    step = None if first_step is None else min(first_step, until - t)
    velocity, (rtol, atol), stiff = choice.motion.velocity, tolerances, False
    solver: Any = DOP853(velocity, t, x, until, rtol=rtol, atol=atol, first_step=step)
    guards = guards_of(field, choice, t, x)
    values = [guard.value(t, x) for guard in guards]
    times, states = [t], [x]
    interpolants: list[Interpolant] = []
    work = 0
    while True:
        if not stiff and not len(times) % PROBED and holds_the_step(velocity, solver, until, field.size):
            stiff = True
            solver = _implicit(velocity, solver, until, (rtol, atol), field.size)
        before, evaluations = (solver.t, solver.y, solver.f), solver.nfev
        message = solver.step()
        work += len(choice.motion.face.members) * (IMPLICIT_STEP if stiff else solver.nfev - evaluations)
        if solver.status == "failed":
            raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
        tell(f"t = {solver.t:.6g} of {until:.6g}")
        following = [guard.value(solver.t, solver.y) for guard in guards]
        if any(map(math.isnan, following)):
            raise TrajectoryError(f"required numbers, received none at t = {solver.t:.6g}, {solver.y.tolist()}")
        size = float(solver.t - before[0])
        easy = stiff or solver.h_abs >= EASY_GROWTH * size
        last = IntegratorStep(before, (solver.t, solver.y, solver.f), solver.dense_output, easy)
        found = first_event(guards, values, following, last)
        if found is not None:
            met = () if found[1].surface is None else (found[1].surface,)
            interpolants.append(last.interpolant)
            states.append(last.interpolant(found[0]))
            return Stretch([*times, found[0]], states, interpolants, met, size, work, stiff)
        late = _LateInterpolant(choice.motion, before[:2], float(solver.t), tolerances)
        interpolants.append(last.interpolant if stiff else late)
        times.append(float(solver.t))
        states.append(solver.y)
        values = following
        if stiff and solver.status == "running" and comes_to_rest(velocity, solver, until, field.size, atol):
            return _resting(Stretch(times, states, interpolants, (), size, work, stiff), until)
        if solver.status == "finished" or work >= most_work:
            return Stretch(times, states, interpolants, (), size, work, stiff)


def _implicit(velocity: Velocity, solver: Any, until: float, tolerances: tuple[float, float], size: float) -> Any:
    """Radau, from where an explicit solver is."""
    from scipy.integrate import Radau

    rtol, atol = tolerances
    jacobian, step = jacobian_of(velocity, size), solver.step_size
    return Radau(velocity, solver.t, solver.y, until, rtol=rtol, atol=atol, jac=jacobian, first_step=step)


def _resting(stretch: Stretch, until: float) -> Stretch:
    """A stretch whose last state stays."""
    last = stretch.end

    def still(t: Any) -> Vector:
        return last if np.ndim(t) == 0 else np.repeat(last[:, None], len(t), axis=1)

    times, states = [*stretch.times, until], [*stretch.states, last]
    return replace(stretch, times=times, states=states, interpolants=[*stretch.interpolants, still])
