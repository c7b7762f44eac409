"""Paths of ordinary differential equations as trajectories: one smooth piece with dense output, ended by the loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    Piece,
    State,
    Trajectory,
    TrajectoryError,
)

Rate = Callable[[float, Floats], Floats]


def integrate(rate: Rate, loads: MovingLoads, state: Floats, until: float, **options: Any) -> Any:
    """SciPy's solution with dense output, ended where loads no longer exist; options as for ``solve_ivp``.

    Raises:
        TrajectoryError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    def margin(t: float, at: Floats) -> float:
        return loads.margin(at[:2])

    margin.terminal, margin.direction = True, -1  # type: ignore[attr-defined]  # SciPy reads these
    solution = solve_ivp(rate, (0.0, until), state, events=margin, dense_output=True, **options)
    if solution.status < 0:
        raise TrajectoryError(f"the integrator stopped at t = {solution.t[-1]:.6g}: {solution.message}")
    return solution


def as_trajectory(method: str, solution: Any, loads: MovingLoads) -> Trajectory:
    """The pose along a solution; smooth equations have one solution, so it is unique."""

    def state(t: Any) -> State:
        return tuple(solution.sol(float(t))[:3].tolist())

    def poses(since: Floats) -> Floats:
        return np.asarray(solution.sol(since)[:3].T)

    reason = EndReason.TIME
    if solution.status == 1:
        reason = EndReason.TIPS if loads.model.load_table is None else EndReason.LOADS
    times = tuple(solution.t.tolist())
    states = tuple(tuple(pose) for pose in solution.y[:3].T.tolist())
    piece = Piece(0.0, times[-1], method, (), state, times, poses)
    end = End(times[-1], states[-1], reason)
    return Trajectory(Kinematics.EXACT.value, method, times, states, (), end, True, (piece,))
