"""The command ``simulate --feedback`` under rules that minimize the dissipation: the law of imposed twists.

Poses are measured from the checked point inside, and in the world's frame where they are shown.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rich.console import RenderableType

from nonsmooth.analysis.bodies.one_contact_set import OneContactSet
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.animation.output import FILMS
from nonsmooth.reports.choices import LawName, PathMethod
from nonsmooth.reports.console import RefusedError
from nonsmooth.reports.driven_loop import DrivenLoop
from nonsmooth.reports.simulate import POSE, SCHEMA, PathRun, events_view, path_summary, sample_lines
from nonsmooth.symbolic.contact_set import require_no_outline, standing
from nonsmooth.symbolic.number_text import numbers_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

NAME = "imposed twists"
NO_FILM = "-o: required samples or a picture (.csv, .json, .svg, .png, .pdf) of a loop under this rule, received a film"


@dataclass(frozen=True)
class DrivenPath:
    """One path of the closed loop.

    Attributes:
        scene: the array.
        loop: the certified law of the centred array.
        own: the path, measured from the checked point.
    """

    scene: Scene
    loop: DrivenLoop
    own: Trajectory

    @cached_property
    def trajectory(self) -> Trajectory:
        """The path in the world's frame."""
        x, y = self.scene.check.equilibrium
        return self.own.shifted(float(x), float(y))

    def record(self) -> dict[str, Any]:
        """The keys of an array's trajectory, with the law and the speeds that it asks for at each sample."""
        law = {
            "name": NAME,
            "formula": self.loop.feedback.law,
            "gain": self.loop.gain,
            "certified": True,
            "status": "certified by the feedback clause",
            "region": self._region,
            "starts_inside": self._starts_inside,
        }
        head = {"schema": SCHEMA, "scene": self.loop.scene.name, "feedback": NAME, "law": law}
        return {**head, **self.trajectory.record(), "speeds": self._speeds()}

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time, pose and speeds of every sample."""
        header, *lines = sample_lines(self.trajectory, POSE)
        yield (*header, *(f"u_{wheel.index}" for wheel in self.loop.scene.wheels))
        for line, speeds in zip(lines, self._speeds(), strict=True):
            yield (*line, *map(repr, speeds))

    def picture(self, suffix: str) -> bytes:
        """The pose over time and the path, measured from the checked point.

        Raises:
            RefusedError: for a film, which would show the speeds of the open loop.
        """
        if suffix in FILMS:
            raise RefusedError(NO_FILM)
        from nonsmooth.reports.figures.driven_loop import driven_loop_figure

        return driven_loop_figure(self.loop.scene, self.own, suffix)

    def summary(self) -> str:
        """How it ends, and under which law."""
        return f"{path_summary(self.trajectory)}; {NAME}, certified by the feedback clause"

    def view(self) -> RenderableType:
        """Events and end as a table, under what is certified."""
        name, rule = one_line(self.loop.scene.name), self.loop.scene.contact.rule
        region = self._region or "near c*; how near is not known"
        lines = [
            f"{name}: exact kinematics, method {self.trajectory.method} (rule {rule})",
            f"feedback: {NAME}, certified by the feedback clause, k = {self.loop.gain:g}",
            f"{self.loop.feedback.law}; certified for an exact pose: {region}",
        ]
        if self.loop.scene.body is not None:
            numbers = tuple(wheel.index for wheel in self.loop.scene.wheels)
            lines.append(f"certified while wheels {numbers_text(numbers)} carry the body, and no others")
        if self.loop.errors is not None:
            lines.append("the pose is late and off as [feedback] says, at every sample by the worst of 27 errors")
        return events_view("\n".join(lines), self.trajectory, POSE)

    def _speeds(self) -> list[list[float]]:
        """What the law asks for at the poses themselves."""
        return [self.loop.speeds(pose) for pose in self.own.states]

    @property
    def _region(self) -> str | None:
        reach = self.loop.reach
        return None if reach is None else f"sqrt(V) < {reach:.6g}"

    @property
    def _starts_inside(self) -> bool | None:
        if self.loop.reach is None:
            return None
        return self.loop.value(self.own.states[0]) < self.loop.reach**2


def follow_driven(scene: Scene, run: PathRun) -> DrivenPath:
    """The closed loop of the certified law, from a start in the world's frame.

    Raises:
        RefusedError: where no law is certified, and for another law, method or kinematics.
        SceneError: for a body with an outline under a law that is sampled and held.
        TrajectoryError: where a motion is not proved.
        ValueError: for a start on other wheels than those of which the law is certified.
    """
    required = f"--feedback: required, under rule {scene.contact.rule},"
    if run.law is not LawName.CERTIFIED:
        raise RefusedError(f"{required} the certified law, received --law {run.law}")
    if run.method is not PathMethod.EVENTS or run.kinematics is not Kinematics.EXACT:
        raise RefusedError(f"{required} --method events and exact kinematics, received {run.method}, {run.kinematics}")
    centred = standing(scene).recentred()
    feedback = verified(decide_driven_feedback(centred)).holding
    if feedback.verdict is not Feedback.STABILIZABLE:
        raise RefusedError(
            f"{required} a certified law; the feedback clause says {feedback.verdict}: {feedback.reason}"
        )
    loop = DrivenLoop(centred, feedback, run.gain)
    (x, y), (start_x, start_y, theta) = scene.check.equilibrium, run.start
    start = (start_x - float(x), start_y - float(y), theta)
    return DrivenPath(scene, loop, _followed(loop, start, run.until))


def _followed(loop: DrivenLoop, start: tuple[float, float, float], until: float) -> Trajectory:
    """The path; of a body with an outline until other wheels carry it.

    Raises:
        SceneError: for a body with an outline under a law that is sampled and held.
        ValueError: for a start on other wheels.
    """
    if loop.scene.body is None:
        return loop.follow(start, until)
    if loop.is_sampled:
        require_no_outline(loop.scene)
    contacts = OneContactSet(loop.scene)
    contacts.require_start(start)
    return contacts.until_change(loop.follow(start, until))
