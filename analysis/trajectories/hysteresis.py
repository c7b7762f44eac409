"""Comparison methods: hysteresis, as the paper simulates, and smoothed signs.

Murphey & Burdick (sec. 5) integrate with hysteresis "to avoid the numerical difficulties of approaching a switching
boundary": a mode is kept until the state is ``width`` beyond its border.  Sliding then becomes a zigzag of that width,
and the error of a path is of the order of the width while the number of switches grows like its inverse.  Smoothing
replaces sign by ``clip(h/width, -1, 1)``; the error is of the same order and the system becomes stiff like 1/width.
Both follow one solution without noticing where others branch off: ``unique`` is None.  The event-driven method
(:mod:`nonsmooth.analysis.trajectories.trajectory`) has neither error nor cost of this kind.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields.switched_field import Mode, SwitchedField, Vector, Velocity
from nonsmooth.analysis.trajectories.result import End, EndReason, Event, EventKind, Trajectory, TrajectoryError

RELATIVE_TOLERANCE = 1e-9  # of the adaptive integrator within a mode: far below the error of any usable width
ABSOLUTE_TOLERANCE = 1e-12  # in units of the state
MAX_SWITCHES = 1_000_000  # a width of 1e-6 over a path of unit length
MAX_EVALUATIONS = 100_000  # of the smoothed field: some seconds; a layer thinner than the tolerance is never crossed
MAX_RELAY_EVALUATIONS = 300_000  # of the fields with hysteresis: some ten seconds
LOCATED = 0.5  # of the width: a switch farther off is not resolved by floats, and the zigzag would stand still


def simulate_hysteresis(
    field: SwitchedField, start: Sequence[float], until: float, width: float, step: float | None = None
) -> Trajectory:
    """Relay with hysteresis: a mode is left ``width`` beyond its border.

    Args:
        field: any switched field.
        start: initial state.
        until: last time.
        width: distance by which switches are late (units of the state).
        step: fixed step of the classical Runge-Kutta scheme, with switches between steps only; None integrates
            adaptively (SciPy's RK45) with located switches.

    Raises:
        ValueError: for a width, last time or step that is not positive, a start outside the domain, or a width so
            small that floats do not resolve its switches, or that the integrator does not get through them.
        TrajectoryError: where the integrator gives up.
    """
    if not width > 0 or not 0 < until < math.inf or (step is not None and not step > 0):
        raise ValueError(f"required a positive width, last time and step, received {width}, {until} and {step}")
    x = np.array([float(value) for value in start])
    mode = field.mode_at(x)
    if mode is None:
        raise ValueError(f"required a start inside the domain of the cells, received {x.tolist()}")
    run = _Relay(field, width, until)
    run.follow(mode, x, step)
    return run.result()


class _Relay:
    """A run with hysteresis."""

    def __init__(self, field: SwitchedField, width: float, until: float) -> None:
        self.field, self.width, self.until = field, width, until
        self.times: list[float] = []
        self.states: list[Vector] = []
        self.events: list[Event] = []
        self.reason = EndReason.TIME
        self.evaluations = itertools.count(1)

    def follow(self, mode: Mode, x: Vector, step: float | None) -> None:
        """Mode after mode."""
        self.times.append(0.0)
        self.states.append(x)
        following: Mode | None = mode
        while self.times[-1] < self.until:
            mode = following
            left = self._adaptive(mode) if step is None else self._fixed(mode, step)
            if not left:
                return
            following = self.field.following(mode, self.states[-1], self.width)
            if following is None:
                self.reason = EndReason.OUTSIDE
                return
            names = f"{self.field.mode_name(mode)} | {self.field.mode_name(following)}"
            self.events.append(Event(self.times[-1], tuple(self.states[-1].tolist()), EventKind.CROSS, names))
            if len(self.events) >= MAX_SWITCHES:
                self.reason = EndReason.EVENTS
                return

    def _adaptive(self, mode: Mode) -> bool:
        """To the border of a mode and ``width`` beyond; whether it was reached."""
        from scipy.integrate import solve_ivp

        def beyond(t: float, x: Vector) -> float:
            return self.field.margin(mode, x) + self.width

        beyond.terminal, beyond.direction = True, -1  # type: ignore[attr-defined]  # SciPy reads these
        velocity = self.field.velocity(mode)

        def counted(t: float, x: Vector) -> Vector:
            _require_within(next(self.evaluations), MAX_RELAY_EVALUATIONS, self.width, t)
            return velocity(t, x)

        solution = solve_ivp(
            counted,
            (self.times[-1], self.until),
            self.states[-1],
            events=beyond,
            rtol=RELATIVE_TOLERANCE,
            atol=ABSOLUTE_TOLERANCE,
        )
        if solution.status < 0:
            raise TrajectoryError(f"the integrator stopped at t = {solution.t[-1]:.6g}: {solution.message}")
        self.times += solution.t[1:].tolist()
        self.states += list(solution.y.T[1:])
        if solution.status == 1 and abs(beyond(self.times[-1], self.states[-1])) > LOCATED * self.width:
            raise ValueError(
                f"required a width whose switches floats resolve, received {self.width:g} at t = {self.times[-1]:.6g}"
            )
        return bool(solution.status == 1)

    def _fixed(self, mode: Mode, step: float) -> bool:
        """Steps of one size until a step ends ``width`` beyond the border of the mode."""
        velocity = self.field.velocity(mode)
        t, x = self.times[-1], self.states[-1]
        while t < self.until:
            size = min(step, self.until - t)
            t, x = t + size, _runge_kutta(velocity, t, x, size)
            self.times.append(t)
            self.states.append(x)
            if self.field.margin(mode, x) <= -self.width:
                return True
        return False

    def result(self) -> Trajectory:
        """The samples as a trajectory."""
        states = tuple(tuple(x.tolist()) for x in self.states)
        end = End(self.times[-1], states[-1], self.reason)
        return Trajectory(
            str(self.field.kinematics), "hysteresis", tuple(self.times), states, tuple(self.events), end, None
        )


def _require_within(evaluations: int, most: int, width: float, t: float) -> None:
    """Refuse a width that takes too much work.

    Raises:
        ValueError: for more evaluations than are allowed.
    """
    if evaluations > most:
        raise ValueError(f"required a width that {most} evaluations resolve, received {width:g} at t = {t:.6g}")


def _runge_kutta(velocity: Velocity, t: float, x: Vector, step: float) -> Vector:
    """One step of the classical scheme of fourth order."""
    k1 = velocity(t, x)
    k2 = velocity(t + step / 2, x + step / 2 * k1)
    k3 = velocity(t + step / 2, x + step / 2 * k2)
    k4 = velocity(t + step, x + step * k3)
    return x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def simulate_smoothed(field: SwitchedField, start: Sequence[float], until: float, width: float) -> Trajectory:
    """Signs smoothed over ``width`` to either side of a surface, by SciPy's LSODA (which turns implicit where stiff).

    Raises:
        ValueError: for a width or last time that is not positive, a start outside the domain, or a width so small
            that the integrator does not get through the layer.
        TrajectoryError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    if not width > 0 or not 0 < until < math.inf:
        raise ValueError(f"required a positive width and last time, received {width} and {until}")
    x = np.array([float(value) for value in start])
    if field.mode_at(x) is None:
        raise ValueError(f"required a start inside the domain of the cells, received {x.tolist()}")

    evaluations = itertools.count(1)

    def mixed(t: float, x: Vector) -> Vector:
        _require_within(next(evaluations), MAX_EVALUATIONS, width, t)
        return np.asarray(sum(weight * velocity(t, x) for velocity, weight in field.blend(x, width)))

    solution = solve_ivp(mixed, (0.0, until), x, method="LSODA", rtol=RELATIVE_TOLERANCE, atol=ABSOLUTE_TOLERANCE)
    if solution.status < 0:
        raise TrajectoryError(f"the integrator stopped at t = {solution.t[-1]:.6g}: {solution.message}")
    states = tuple(tuple(row) for row in solution.y.T.tolist())
    end = End(float(solution.t[-1]), states[-1], EndReason.TIME)
    return Trajectory(str(field.kinematics), "smoothed", tuple(solution.t.tolist()), states, (), end, None)
