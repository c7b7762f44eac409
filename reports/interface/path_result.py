"""A path that was followed, as a script or a notebook holds it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.bodies.mass_study import rule_path
from nonsmooth.analysis.bodies.one_contact_set import OneContactSet
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.choices import PathMethod
from nonsmooth.reports.console import RefusedError
from nonsmooth.reports.files import PICTURES, output_path, write_whole
from nonsmooth.reports.interface.row_results import Tabular
from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.shown import file_bytes
from nonsmooth.reports.simulate import POSE, PathRun, ShownTrajectory, follow, loop_of
from nonsmooth.reports.smooth_paths import SmoothPath
from nonsmooth.reports.system_paths import SystemPath
from nonsmooth.symbolic.contact_set import require_no_outline, standing
from nonsmooth.symbolic.number_text import float_text, place_text
from nonsmooth.symbolic.scene_error import SceneError, StatedFact

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.reports.driven_paths import DrivenPath
    from nonsmooth.reports.dynamics import ShownPath
    from nonsmooth.reports.feedback_loop import FeedbackLoop
    from nonsmooth.symbolic.scene import Scene

PATH_FORMATS = (".csv", ".json", *PICTURES)


@dataclass(frozen=True, repr=False)
class PathResult(Tabular):
    """A path with its events.

    Attributes:
        name: of the array or system.
        states: names of the states.
        shown: the path in every form that the command ``simulate`` offers.
        scene: the array; None for systems.
    """

    name: str
    states: tuple[str, ...]
    shown: ShownTrajectory | SmoothPath | SystemPath | ShownPath | DrivenPath
    scene: Scene | None = None

    @property
    def trajectory(self) -> Trajectory:
        """Samples, events, pieces, end, and whether the solution is unique."""
        return self.shown.trajectory

    @property
    def partition(self) -> Partition | None:
        """The cells it goes through; None for systems and rules without cells."""
        return self.shown.partition if isinstance(self.shown, ShownTrajectory) else None

    @property
    def loop(self) -> FeedbackLoop | None:
        """The closed loop, where a law sets the speeds."""
        return self.shown.loop if isinstance(self.shown, ShownTrajectory) else None

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
        """The JSON record of ``nonsmooth simulate --json``."""
        return self.shown.record()

    def rows(self) -> list[dict[str, float | None]]:
        """The rows of the ``.csv``: time and states of each sample, in a closed loop its speeds (None without one)."""
        names, *lines = self.shown.lines()
        return [
            {name: None if cell == "" else float(cell) for name, cell in zip(names, line, strict=True)}
            for line in lines
        ]

    def save(self, file: str | Path) -> Path:
        """Write it as ``nonsmooth simulate -o`` does: samples (.csv, .json), or a picture (.svg, .png, .pdf).

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), PATH_FORMATS)
        write_whole(path, file_bytes(self.shown, path.suffix.lower()))
        return path

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the path in the plane of the first two states, over the cells where there are some."""
        from nonsmooth.reports.interface.plots import plot_path

        return plot_path(self, ax)

    def animate(self, file: str | Path) -> Path:
        """Write the motion of the body over the wheels: .html (a page with a slider) or .gif.

        Raises:
            OutputError: for another suffix, or a file that cannot be written.
            ValueError: for the path of a plain system, and a closed loop of which there are no films.
        """
        from nonsmooth.reports.animation.output import FILMS

        path = output_path(str(file), FILMS)
        if self.scene is None:
            raise ValueError("required a path of an array, received one of a plain system")
        try:
            film = file_bytes(self.shown, path.suffix.lower())
        except RefusedError as error:
            raise ValueError(str(error)) from None
        write_whole(path, film)
        return path

    def __repr__(self) -> str:
        end, path = self.trajectory.end, self.trajectory
        unique = {True: "unique", False: "not unique", None: "uniqueness not known"}[path.unique]
        place = place_text([float(value) for value in end.state], 5)
        head = f"path of {self.name}, method {path.method}: {len(path.events)} events, {unique}"
        return short_lines(head, [(f"{end.reason}:", f"{place} at t = {float_text(end.t)}")])

    def _repr_html_(self) -> str:
        return self.trajectory._repr_html_()


def follow_array(scene: Scene, run: PathRun) -> PathResult:
    """The path of a body over an array: by the cells of its rule or the rule's own field, or of a body with mass.

    Raises:
        ValueError: for a start outside the checked square, and a law that does not apply.
        RefusalError: where the motion is not determined.
        ArgumentError: for a mass or an inertia that cannot be used.
        SceneError: for a body with an outline that this run does not follow.
        TrajectoryError: where the path cannot be followed.
    """
    if run.method is PathMethod.DYNAMICS:
        from nonsmooth.reports.interface.mass_result import follow_body

        return PathResult(scene.name, POSE, follow_body(scene, run), scene)
    rule = rule_of(scene)
    if run.is_plain and (isinstance(rule, SmoothRule) or scene.body is not None):
        return PathResult(scene.name, POSE, SmoothPath(scene, rule_path(scene, rule.name, run.start, run.until)), scene)
    if run.law is not None and not rule.keeps_rows:
        from nonsmooth.reports.driven_paths import follow_driven

        return PathResult(scene.name, POSE, follow_driven(scene, run), scene)
    if run.law is not None and scene.loop_errors is not None:
        expected = "one of the other contact rules for a law whose pose is late or wrong"
        raise SceneError(scene.origin, "feedback", expected, StatedFact("nearest: it may lie in another contact state"))
    contacts = _one_contact_set(scene, run)
    partition = build_partition(standing(scene))
    loop = loop_of(partition, run)
    path = follow(partition, run, loop)
    path = path if contacts is None else contacts.until_change(path)
    return PathResult(scene.name, POSE, ShownTrajectory(partition, run, path, loop), scene)


def _one_contact_set(scene: Scene, run: PathRun) -> OneContactSet | None:
    """The wheels on which a closed loop starts, and ends when they change; None without an outline.

    Raises:
        SceneError: for a run that does not follow an outline.
        ValueError: for a start on other wheels.
    """
    if scene.body is None:
        return None
    if run.method is not PathMethod.EVENTS or run.kinematics is not Kinematics.EXACT:
        require_no_outline(scene)
    contacts = OneContactSet(standing(scene))
    contacts.require_start(run.start)
    return contacts
