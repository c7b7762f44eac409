"""Paths of ordinary differential equations as trajectories: one smooth piece with dense output, ended by the loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from nonsmooth.analysis.dynamics.moving_loads import MovingLoads
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import End, EndReason, Piece, State, Trajectory, TrajectoryError

Rate = Callable[[float, Floats], Floats]


def finite_start(start: Sequence[float], until: float) -> Floats:
    """The state at time zero.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
    """
    state = np.array(start, float)
    if np.isfinite(state).all() and 0 < until < math.inf:
        return state
    raise ValueError(f"required a finite start and a positive last time, received {state.tolist()} and {until}")


def continuous_path(
    name: str, rate: Rate, loads: MovingLoads, start: Floats, until: float, **options: Any
) -> tuple[Trajectory, Any]:
    """The pose along a solution, and SciPy's solution: a smooth equation has one, which ends where loads do.

    Args:
        name: of the method, for the trajectory.
        rate: time derivative of the state, whose first three entries are the pose.
        loads: along the path.
        start: the state at time zero.
        until: last time.
        options: as for ``solve_ivp``.

    Raises:
        TrajectoryError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    def margin(t: float, state: Floats) -> float:
        return loads.margin(state[:2])

    def poses(since: Floats) -> Floats:
        return np.asarray(solution.sol(since)[:3].T)

    def pose(since: Any) -> State:
        return tuple(poses(np.asarray(since, float)).tolist())

    margin.terminal, margin.direction = True, -1  # type: ignore[attr-defined]  # SciPy reads these
    solution = solve_ivp(rate, (0.0, until), start, events=margin, dense_output=True, **options)
    if solution.status < 0:
        raise TrajectoryError(f"the integrator stopped at t = {solution.t[-1]:.6g}: {solution.message}")
    times, states = tuple(solution.t.tolist()), tuple(map(tuple, solution.y[:3].T.tolist()))
    reason = EndReason.TIME
    if solution.status:
        reason = EndReason.TIPS if loads.model.load_table is None else EndReason.LOADS
    end, piece = End(times[-1], states[-1], reason), Piece(0.0, times[-1], name, (), pose, times, poses)
    return Trajectory(Kinematics.EXACT.value, name, times, states, (), end, True, (piece,)), solution
