"""The command ``simulate`` where a path has no partition of its own: as text, JSON, samples, picture or film.

That is so under rules without cells, and for bodies with an outline, whose cells change with the wheels under them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rich.console import RenderableType

from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.animation.output import FILMS, film_bytes
from nonsmooth.reports.simulate import POSE, SCHEMA, events_view, path_summary, sample_lines
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line


@dataclass(frozen=True)
class SmoothPath:
    """One path of an array in the open loop, drawn between the wheels."""

    scene: Scene
    trajectory: Trajectory

    def record(self) -> dict[str, Any]:
        """The keys of an array's trajectory; there is no law."""
        head = {"schema": SCHEMA, "scene": self.scene.name, "feedback": None, "law": None}
        return {**head, **self.trajectory.record(), "speeds": None}

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time and pose of every sample."""
        return sample_lines(self.trajectory, POSE)

    def picture(self, suffix: str) -> bytes:
        """The pose over time and the path between the wheels; or the motion itself."""
        if suffix in FILMS:
            from nonsmooth.reports.animation.film import build_film

            return film_bytes(build_film(self.scene, self.trajectory), suffix)
        from nonsmooth.reports.figures.dynamics import rule_path_figure

        return rule_path_figure(self.scene, self.trajectory, suffix)

    def summary(self) -> str:
        """How many events, and how it ends."""
        return path_summary(self.trajectory)

    def view(self) -> RenderableType:
        """The end as a table."""
        rule, path = self.scene.contact.rule, self.trajectory
        head = f"{one_line(self.scene.name)}: {path.kinematics} kinematics, method {path.method} (rule {rule})"
        return events_view(head, path, POSE)
