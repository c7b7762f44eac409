"""The command ``simulate`` for plain switched systems: a solution as text, JSON, a table of samples or a picture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rich.console import RenderableType

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.reports.choices import PathMethod
from nonsmooth.reports.simulate import SCHEMA, events_view, path_summary, sample_lines
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class SystemPath:
    """A solution of a plain system with the field it solves."""

    system: SwitchedSystem
    field: SignField
    trajectory: Trajectory

    def record(self) -> dict[str, Any]:
        """The keys of an array's trajectory, and the names of the states; there are no kinematics."""
        head = {"schema": SCHEMA, "scene": self.system.name, "feedback": None}
        return {**head, **self.trajectory.record(), "kinematics": None, "states": list(self.system.stated_states)}

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time and states of every sample."""
        return sample_lines(self.trajectory, self.system.stated_states)

    def picture(self, suffix: str) -> bytes:
        """The states over time, and of two states the path over the switching surfaces."""
        from nonsmooth.reports.figures.phase_plane import phase_plane_figure

        return phase_plane_figure(self.system, self.field, self.trajectory, suffix)

    def summary(self) -> str:
        """How many events, and how it ends."""
        return path_summary(self.trajectory)

    def view(self) -> RenderableType:
        """Events and end as a table."""
        name, states = one_line(self.system.name), self.system.stated_states
        head = f"{name}: plain switched system in {', '.join(states)}, method {self.trajectory.method}"
        return events_view(head, self.trajectory, states)


def follow_system(
    system: SwitchedSystem, start: tuple[float, ...], until: float, method: PathMethod, width: float
) -> SystemPath:
    """Simulate.

    Raises:
        ValueError: for a switching function without a gradient where it vanishes.
        TrajectoryError: where the integrator gives up.
        SceneError: for formulas that are no polynomials where the solution goes.
    """
    field = system_field(system, start)
    if method is PathMethod.EVENTS:
        return SystemPath(system, field, simulate(field, start, until))
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed

    compared = simulate_hysteresis if method is PathMethod.HYSTERESIS else simulate_smoothed
    return SystemPath(system, field, compared(field, start, until, width))
