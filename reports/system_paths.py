"""The command ``simulate`` for plain switched systems: a solution as text, JSON, a table of samples or a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rich.console import RenderableType

from nonsmooth.analysis.fields.equations_field import build_sign_field
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.reports.choices import Method
from nonsmooth.reports.console import json_text
from nonsmooth.reports.simulate import SCHEMA, events_view, trajectory_table
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_equations import SwitchedEquations


@dataclass(frozen=True)
class SystemPath:
    """A solution of a plain system with the field it solves."""

    equations: SwitchedEquations
    field: SignField
    trajectory: Trajectory


def follow_system(
    equations: SwitchedEquations, start: tuple[float, ...], until: float, method: Method, width: float
) -> SystemPath:
    """Simulate.

    Raises:
        ValueError: for a switching function without a gradient where it vanishes.
        TrajectoryError: where the integrator gives up.
        SceneError: for formulas that are no polynomials where the solution goes.
    """
    field = build_sign_field(equations, start)
    if method is Method.EVENTS:
        return SystemPath(equations, field, simulate(field, start, until))
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed

    compared = simulate_hysteresis if method is Method.HYSTERESIS else simulate_smoothed
    return SystemPath(equations, field, compared(field, start, until, width))


def system_path_record(path: SystemPath) -> dict[str, Any]:
    """JSON with the keys of an array's trajectory, and the names of the states; there are no kinematics."""
    head = {"schema": SCHEMA, "scene": path.equations.name, "feedback": None}
    return {**head, **path.trajectory.record(), "kinematics": None, "states": list(path.equations.states)}


def system_path_bytes(suffix: str, path: SystemPath) -> bytes:
    """The file of a solution: a table, JSON or a picture."""
    match suffix:
        case ".csv":
            return trajectory_table(path.trajectory, path.equations.states)
        case ".json":
            return json_text(system_path_record(path)).encode()
        case _:
            from nonsmooth.reports.figures.phase_plane import phase_plane_figure

            return phase_plane_figure(path, suffix)


def system_path_view(path: SystemPath) -> RenderableType:
    """Events and end as a table."""
    name, states = one_line(path.equations.name), path.equations.states
    head = f"{name}: plain switched system in {', '.join(states)}, method {path.trajectory.method}"
    return events_view(head, path.trajectory, states)
