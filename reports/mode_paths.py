"""The command ``simulate`` for systems with modes: a path as text, JSON, a table of samples or a picture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rich.console import RenderableType

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.trajectories.modes import ModePath, follow_modes, mode_fields
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.simulate import SCHEMA, events_view, path_summary, sample_lines
from nonsmooth.symbolic.mode_system import ModeSystem
from nonsmooth.symbolic.scene_error import one_line


@dataclass(frozen=True)
class ShownModePath:
    """A path of a system with modes.

    Attributes:
        system: the system.
        field: the field of the first mode with its guards, for a picture's surfaces.
        path: the path with its modes.
    """

    system: ModeSystem
    field: SignField
    path: ModePath

    @property
    def trajectory(self) -> Trajectory:
        """Samples, events, pieces and end."""
        return self.path.trajectory

    def record(self) -> dict[str, Any]:
        """The keys of a plain system's trajectory, and the modes with their times."""
        head = {"schema": SCHEMA, "scene": self.system.name, "feedback": None}
        modes = [{"mode": name, "start": start, "end": end} for name, start, end in self.path.modes]
        states = list(self.system.states)
        return {**head, **self.trajectory.record(), "kinematics": None, "states": states, "modes": modes}

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time, states and mode of every sample; at a switch the mode that begins."""
        header, *lines = sample_lines(self.trajectory, self.system.states)
        yield (*header, "mode")
        for line, time in zip(lines, self.trajectory.times, strict=True):
            yield (*line, self._mode_at(float(time)))

    def _mode_at(self, time: float) -> str:
        return next(name for name, start, _ in reversed(self.path.modes) if start <= time)

    def picture(self, suffix: str) -> bytes:
        """The states over time, and of two states the path over the guards of the first mode."""
        from nonsmooth.reports.figures.phase_plane import phase_plane_figure

        title = f"{one_line(self.system.name)}: {self.summary()}"
        return phase_plane_figure(self.system.modes[0].system, self.field, self.trajectory, suffix, title)

    def summary(self) -> str:
        """How many events, and how it ends."""
        return path_summary(self.trajectory)

    def view(self) -> RenderableType:
        """Events and end as a table."""
        first, *_ = self.path.modes
        head = f"{one_line(self.system.name)}: system with modes in {', '.join(self.system.states)}, first {first[0]}"
        return events_view(head, self.trajectory, self.system.states)


def follow_mode_system(
    system: ModeSystem, start: tuple[float, ...], until: float, first: str | None = None
) -> ShownModePath:
    """Simulate.

    Args:
        system: with modes.
        start: one number for each state.
        until: last time.
        first: the mode it begins in; the first of the file unless given.

    Raises:
        ValueError: for another name than a mode's, and a guard without a gradient where it vanishes.
        TrajectoryError: where modes follow each other without end at one time.
    """
    names = [mode.name for mode in system.modes]
    begin = names[0] if first is None else first
    if begin not in names:
        raise ValueError(f"mode: required one of {', '.join(names)}, received {begin!r}")
    fields = mode_fields(system, start)
    return ShownModePath(system, fields[begin].guarded, follow_modes(fields, begin, start, until))
