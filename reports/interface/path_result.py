"""A path that was followed, as a script or a notebook holds it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.choices import LawName, Method
from nonsmooth.reports.interface.rows import Tabular
from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.simulate import POSE, PathRun, follow, loop_of
from nonsmooth.symbolic.contact_set import require_no_outline
from nonsmooth.symbolic.number_text import float_text, place_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.reports.feedback_loop import FeedbackLoop
    from nonsmooth.symbolic.scene import Scene

WIDTH = 1e-3  # of hysteresis and smoothing


@dataclass(frozen=True, repr=False)
class PathResult(Tabular):
    """A path with its events.

    Attributes:
        name: of the array or system.
        states: names of the states.
        trajectory: samples, events, pieces, end, and whether the solution is unique.
        partition: the cells it goes through; None for systems and rules without cells.
        scene: the array; None for systems.
        loop: the closed loop, where a law sets the speeds.
    """

    name: str
    states: tuple[str, ...]
    trajectory: Trajectory
    partition: Partition | None = None
    scene: Scene | None = None
    loop: FeedbackLoop | None = None

    @property
    def t(self) -> NDArray[np.float64]:
        """Sample times, shape (m,)."""
        return np.array([float(t) for t in self.trajectory.times])

    @property
    def state(self) -> NDArray[np.float64]:
        """Sampled states, shape (m, n)."""
        return self.trajectory.array

    @property
    def end(self) -> str:
        """Why the path ends."""
        return str(self.trajectory.end.reason)

    def to_dict(self) -> dict[str, Any]:
        """Samples, events, pieces and end, as JSON has them."""
        return self.trajectory.record()

    def rows(self) -> list[dict[str, float]]:
        """One row for each sample: time and states."""
        names = ("t", *self.states)
        return [dict(zip(names, (t, *state), strict=True)) for t, state in zip(self.t, self.state, strict=True)]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the path in the plane of the first two states, over the cells where there are some."""
        from nonsmooth.reports.interface.plots import plot_path

        return plot_path(self, ax)

    def animate(self, file: str | Path) -> Path:
        """Write the motion of the body over the wheels: .html (a page with a slider), .gif or .mp4 (needs ffmpeg).

        Raises:
            OutputError: for another suffix, or a file that cannot be written.
            ValueError: for the path of a plain system; for .mp4 without ffmpeg.
        """
        from nonsmooth.reports.animation.film import build_film
        from nonsmooth.reports.animation.output import FILMS, film_bytes
        from nonsmooth.reports.files import output_path, write_whole

        path = output_path(str(file), FILMS)
        if self.scene is None:
            raise ValueError("required a path of an array, received one of a plain system")
        film = build_film(self.scene, self.trajectory, self.partition, self.loop)
        write_whole(path, film_bytes(film, path.suffix.lower()))
        return path

    def __repr__(self) -> str:
        end, path = self.trajectory.end, self.trajectory
        unique = {True: "unique", False: "not unique", None: "uniqueness not known"}[path.unique]
        place = place_text([float(value) for value in end.state], 5)
        head = f"path of {self.name}, method {path.method}: {len(path.events)} events, {unique}"
        return short_lines(head, [(f"{end.reason}:", f"{place} at t = {float_text(end.t)}")])

    def _repr_html_(self) -> str:
        return self.trajectory._repr_html_()


def follow_array(  # one keyword for each option of the command
    scene: Scene,
    start: Sequence[float],
    until: float,
    *,
    feedback: bool | str = False,
    method: str = "events",
    gain: float = 1.0,
    kinematics: str = "exact",
    width: float = WIDTH,
) -> PathResult:
    """The path of a body over an array; see :meth:`nonsmooth.reports.interface.array.Array.simulate`.

    Raises:
        ValueError: for a start outside the checked square, a law that does not apply, or an unknown method.
        RefusalError: where the motion is not determined.
    """
    x, y, theta = (float(value) for value in start)
    rule = rule_of(scene)
    if isinstance(rule, SmoothRule) and not feedback:
        return PathResult(scene.name, POSE, rule.path(scene, (x, y, theta), until), scene=scene)
    law = None if feedback is False else LawName.CERTIFIED if feedback is True else LawName(feedback)
    if not (math.isfinite(gain) and gain > 0):
        raise ValueError(f"gain: required a positive number, received {gain}")
    run = PathRun((x, y, theta), until, Kinematics(kinematics), Method(method), law, width, gain)
    require_no_outline(scene)
    partition = build_partition(scene)
    loop = loop_of(partition, run)
    return PathResult(scene.name, POSE, follow(partition, run, loop), partition, scene, loop)
