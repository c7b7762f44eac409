"""Paths of an array under a feedback law: through the cells of a rule, and under a law of imposed twists."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.proofs.answers.answer import half_life, how_far
from nonsmooth.proofs.findings import Feedback, Record
from nonsmooth.reports.laws.feedback_loop import FeedbackLoop, build_loop
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.output.study_options import LawName, PathMethod
from nonsmooth.reports.simulations.path_ends import ArrayPathEnd
from nonsmooth.reports.simulations.paths import ArrayPath, by_method
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable
from nonsmooth.symbolic.mechanics.contact_set import require_no_outline, standing, whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose, in_floats, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.path import OneContactSet
    from nonsmooth.reports.animation.film import Film
    from nonsmooth.reports.figures.path import PathPicture
    from nonsmooth.reports.laws.driven_loop import DrivenLoop

NO_FILM = (
    "-o: required samples or a picture (.csv, .json, .svg, .png, .pdf) of a law under a rule with friction sets, "
    "received a film"
)


@dataclass(frozen=True, repr=False, kw_only=True)
class ClosedPath(ArrayPath):
    """A path under a law.

    Attributes:
        loop: the law that sets the speeds.
    """

    loop: FeedbackLoop | DrivenLoop

    @property
    @abstractmethod
    def driven(self) -> Scene:
        """The array of the wheels that the law drives."""

    @property
    @abstractmethod
    def centred_start(self) -> Pose:
        """The start, measured from the checked point."""

    def beside(self) -> Sequence[str]:
        """That it ends with the time, where it does, and whether before its error is certified to halve."""
        end = self.trajectory.end
        if end.reason is not EndReason.TIME or ArrayPathEnd(self.scene, self.trajectory).ending.since is not None:
            return ()
        second = self.scene.units.after_time
        said = f"that is where the clock stopped, at t = {float_text(float(end.t), 4)}{second}, not where the law leads"
        kappa = self.loop.feedback.certified_kappa if self.loop.is_certified else None
        if kappa is None or self.scene.loop_errors is not None or self.scene.speed_limits:
            return (said,)
        half = half_life(kappa * Fraction(self.loop.gain))
        shorter = float(end.t) < float(half)
        time = f"the certified time in which the error halves near the point, {half}{second} (--until)"
        return (f"{said}; that is sooner than {time}" if shorter else said,)

    def facts(self) -> Record:
        """The record of the trajectory, with the law, whether it is certified and from where, and the speeds."""
        loop = self.loop
        law = {
            "name": loop.name,
            "formula": loop.formula,
            "gain": loop.gain,
            "certified": loop.is_certified,
            "status": loop.status,
            "region": loop.region_text,
            "starts_inside": loop.holds(self.centred_start),
        }
        return super().facts() | {"feedback": loop.name, "law": law, "speeds": self._speed_rows()}

    def table(self) -> DataTable:
        """Time and pose of every sample, and the speeds of the wheels."""
        columns, lines = super().table()
        names = (f"u_{wheel.index:d}" for wheel in self.driven.wheels)
        return DataTable((*columns, *names), [[*a, *b] for a, b in zip(lines, self._speed_rows(), strict=True)])

    def head(self) -> Sequence[str]:
        """The kinematics and the method, and what is certified of the law."""
        lines = [*super().head(), *self.loop.words(self.centred_start)]
        if self.scene.body is not None:
            lines.append(f"certified while wheels {numbers_text(self.driven.numbers)} carry the body, and no others")
        return lines

    def summary(self) -> str:
        """How many events, how it ends, and under which law."""
        return f"{super().summary()}; {self.loop.title}"

    def _speed_rows(self) -> list[list[float | None]]:
        """The speeds of every sample; None where a wheel is given none."""
        return [[None if math.isnan(u) else u for u in row] for row in self.speeds().tolist()]


def follow_closed(scene: Scene, options: SimulateOptions, law: LawName) -> ClosedPath:
    """The path of a body without mass under a law.

    Raises:
        OptionError: for a start that is no pose, and a law, a method or kinematics that the rule does not offer.
        ValueError: for a start outside the checked square, and a law that does not apply.
        RefusalError: where the motion is not determined.
        SceneError: for a body with an outline that this run does not follow.
        TrajectoryError: where the path cannot be followed.
        ContradictionError: for a path that contradicts the verdict about its law.
    """
    if rule_of(scene).keeps_rows:
        return _through_cells(scene, options, law)
    return _under_imposed_twists(scene, options, law)


# ---- through cells -------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False, kw_only=True)
class CellLoopPath(ClosedPath):
    """A path through cells, each with its own rows of the law."""

    loop: FeedbackLoop
    partition: Partition

    @property
    def driven(self) -> Scene:
        """That of the cells."""
        return self.partition.scene

    @property
    def centred_start(self) -> Pose:
        """The start, measured from the checked point."""
        x, y, theta = pose_in_floats(self.trajectory.states[0])
        at_x, at_y = self.driven.check.equilibrium
        return x - float(at_x), y - float(at_y), theta

    def speeds(self, times: Iterable[float] | None = None) -> Floats:
        """The speeds of all wheels at times, those of its samples unless given (m, n).

        At a switch they are those of the motion that begins there; nan where a wheel does not act and is given none.
        """
        from nonsmooth.analysis.motion.frames import build_frames

        path, cells = self.trajectory, self.partition
        at = path.t.tolist() if times is None else list(map(float, times))
        pivot = self.scene.check.place if path.kinematics != Kinematics.EXACT else None
        return build_frames(self.driven, path, at, partition=cells, inputs=self.loop.inputs(cells), pivot=pivot).speeds

    def _frames(self) -> Film:
        from nonsmooth.reports.animation.film import build_film

        return build_film(whole(self.scene), self.trajectory, self.partition, self.loop)

    def picture(self) -> PathPicture:
        """The pose and the speeds over time, and the path over the cells."""
        from nonsmooth.reports.figures.path import SAMPLES, SpeedCurves, cells_picture
        from nonsmooth.reports.figures.style import time_label

        (times, _), units = self.trajectory.dense(SAMPLES), self.scene.units
        labels = time_label("t", units), f"speeds u_i [{units.speed or 'speed'}]"
        curves = SpeedCurves(times, self.speeds(times), self.driven.numbers, self.loop.limits, labels)
        return cells_picture(self.partition, self.trajectory, self.loop.title, curves)


def _through_cells(scene: Scene, options: SimulateOptions, law: LawName) -> CellLoopPath:
    """The closed loop on the cells of the rule; of a body with an outline until other wheels carry it."""
    if scene.loop_errors is not None:
        expected = "one of the other contact rules for a law whose pose is late or wrong"
        raise SceneError(scene.origin, "feedback", expected, StatedFact("nearest: it may lie in another contact state"))
    contacts = None
    if scene.body is not None:
        if options.method is not PathMethod.EVENTS or options.kinematics is not Kinematics.EXACT:
            require_no_outline(scene)
        contacts = _started_on(standing(scene), options.pose)
    partition = build_partition(standing(scene))
    loop = build_loop(partition, law, options.kinematics, gain=options.gain)
    path = follow_loop(partition, options, loop)
    return CellLoopPath(
        scene=scene,
        trajectory=path if contacts is None else contacts.until_change(path),
        partition=partition,
        loop=loop,
    )


def follow_loop(partition: Partition, options: SimulateOptions, loop: FeedbackLoop) -> Trajectory:
    """The path through cells under a law; one by events is compared with what is certified about its start.

    It is followed with the length l of the scene for its unit: steps are the same in every unit of length.

    Raises:
        ValueError: for a start outside the square, or a law without control fields.
        ContradictionError: for a path that contradicts the verdict about its law.
    """
    length = float(partition.scene.check.length)
    field, (x, y, theta) = loop.field(partition), options.pose
    if not field.faces_at(np.array((x, y, theta))):
        raise ValueError(f"required a start inside the domain of the cells, received {[x, y, theta]}")
    in_length = replace(options, width=options.width / length)
    path = by_method(field.in_unit(length), (x / length, y / length, theta), in_length).in_lengths(length)
    if options.method is PathMethod.EVENTS:
        loop.refuse_contradiction(path, in_floats(partition.scene.check.equilibrium))
    return loop.with_saturation(partition, path)


def _started_on(scene: Scene, start: Pose) -> OneContactSet:
    """The wheels that carry the body of an array.

    Raises:
        ValueError: where others carry it at the start.
    """
    from nonsmooth.analysis.bodies.path import OneContactSet

    contacts = OneContactSet(scene, how_far(scene, "the checked point", "the checked heading"))
    contacts.require_start(start)
    return contacts


# ---- under imposed twists ------------------------------------------------------------------------


@dataclass(frozen=True, repr=False, kw_only=True)
class DrivenPath(ClosedPath):
    """A path under the law of imposed twists.

    Attributes:
        loop: the law.
        own: the path as the law sees it, measured from the checked point.
    """

    loop: DrivenLoop
    own: Trajectory

    def speeds(self, times: Iterable[float] | None = None) -> Floats:
        """What the law asks for at the poses of the samples (m, n)."""
        del times
        return np.array([self.loop.speeds(pose) for pose in self.own.states])

    def film(self, ending: str) -> bytes:
        """There is none: it would show the speeds of the open loop.

        Raises:
            OptionError: always.
        """
        raise OptionError(NO_FILM)

    def picture(self) -> PathPicture:
        """The pose over time and the path about the checked point."""
        from nonsmooth.reports.figures.path import centre_picture

        return centre_picture(self.scene, self.trajectory, "certified law")

    @property
    def driven(self) -> Scene:
        """That of the law."""
        return self.loop.scene

    @property
    def centred_start(self) -> Pose:
        """The start, as the law sees it."""
        x, y, theta = pose_in_floats(self.own.states[0])
        return x, y, theta


def _under_imposed_twists(scene: Scene, options: SimulateOptions, law: LawName) -> DrivenPath:
    """The closed loop of the certified law of imposed twists.

    Raises:
        OptionError: where no law is certified, and for another law, method or kinematics.
        TrajectoryError: where a motion is not proved.
        LoadError: for a start at which the body tips.
        ValueError: for a start on other wheels than those of which the law is certified.
    """
    from nonsmooth.analysis.bodies.supports import tipping_edge
    from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
    from nonsmooth.reports.laws.driven_loop import DrivenLoop

    required = f"--feedback: required, under rule {scene.contact.rule},"
    method, kinematics = options.method, options.kinematics
    if law is not LawName.CERTIFIED:
        raise OptionError(f"{required} the certified law, received --law {law}")
    if method is not PathMethod.EVENTS or kinematics is not Kinematics.EXACT:
        raise OptionError(f"{required} --method events and exact kinematics, received {method}, {kinematics}")
    centred = standing(scene).recentred()
    feedback = decide_driven_feedback(centred).holding
    if feedback.verdict is not Feedback.STABILIZABLE:
        said = f"the feedback clause says {feedback.verdict}: {feedback.reason}"
        raise OptionError(f"{required} a certified law; {said}")
    loop = DrivenLoop(centred, feedback, options.gain)
    (x, y), (start_x, start_y, theta) = scene.check.place, options.pose
    own_start = (start_x - x, start_y - y, theta)
    if loop.held.tips(np.array(own_start) / loop.length):
        edge = tipping_edge(standing(scene), frozenset(range(len(centred.wheels))), np.array(options.pose))
        said = f"required centres of mass inside the support polygon, received {place_text((start_x, start_y))}"
        raise LoadError(f"{said}: the body tips there {edge}")
    centred_path = _until_other_wheels(loop, own_start, options.last)
    return DrivenPath(scene, centred_path.shifted(x, y), loop=loop, own=centred_path)


def _until_other_wheels(loop: DrivenLoop, start: Pose, until: float) -> Trajectory:
    """The path; of a body with an outline until other wheels carry it."""
    if loop.scene.body is None:
        return loop.follow(start, until)
    return _started_on(loop.scene, start).until_change(loop.follow(start, until))
