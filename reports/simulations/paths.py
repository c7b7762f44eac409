"""A path: one solution of an array or of a plain system, with its events.

The command ``simulate`` prints and saves the object that Python users hold.  What all paths share is said by
:class:`PathResult`; what an array adds (cells, a law with its speeds, a film), a law of imposed twists, a body with
mass and a plain system, by the classes below it.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nonsmooth.analysis.bodies.settling import Settled, Settling
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import UNFINISHED, EndReason, EventKind, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.answer import half_life, has_dynamics, how_far
from nonsmooth.proofs.findings import Feedback, Record
from nonsmooth.reports.laws.feedback_loop import FeedbackLoop, build_loop
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.files import FILMS, output_path, write_whole
from nonsmooth.reports.output.progress import steps
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.output.study_options import LawName, PathMethod
from nonsmooth.reports.simulations.path_ends import (
    ArrayPathEnd,
    is_at_point,
    pose_text,
    settled_record,
    settled_words,
    system_end,
)
from nonsmooth.reports.simulations.simulate_options import POSE, SimulateOptions
from nonsmooth.reports.studies.result import FORMATS, DataTable, Formats, Result, short_lines
from nonsmooth.symbolic.mechanics.contact_set import require_no_outline, standing, whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose, in_floats, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.analysis.bodies.path import OneContactSet
    from nonsmooth.reports.figures.path import PathPicture, SpeedCurves
    from nonsmooth.reports.laws.driven_loop import DrivenLoop

SCHEMA = "nonsmooth-trajectory/1"
SHOWN = 12  # events listed on a terminal
NO_FILM = (
    "-o: required samples or a picture (.csv, .json, .svg, .png, .pdf) of a law under a rule with friction sets, "
    "received a film"
)
UNIQUE = {
    True: "unique: no other solution from this start",
    False: "not unique: other solutions branch off",
    None: "uniqueness not decided",
}
UNIQUE_SO_FAR = "unique so far: no other solution from this start until then"


class PathResult(Result):
    """A path with its events.

    Attributes:
        trajectory: samples, events, pieces, end, and whether the solution is unique.
        scene: the array; None for systems.
        partition: the cells it goes through; None for systems and rules without cells.
        loop: the closed loop, where a law sets the speeds.
    """

    trajectory: Trajectory
    scene: Scene | None
    partition: Partition | None
    loop: FeedbackLoop | DrivenLoop | None

    @property
    @abstractmethod
    def name(self) -> str:
        """Of the array or system."""

    @property
    @abstractmethod
    def states(self) -> Sequence[str]:
        """Their names."""

    @abstractmethod
    def head(self) -> Sequence[str]:
        """Lines that say what is followed, and how."""

    @abstractmethod
    def picture(self) -> PathPicture:
        """What is drawn."""

    @property
    @abstractmethod
    def ending(self) -> tuple[Record, str]:
        """How it ends, where and when: a record, and one sentence."""

    @property
    def t(self) -> Floats:
        """Sample times, shape (m,)."""
        return self.trajectory.t

    @property
    def state(self) -> Floats:
        """Sampled states, shape (m, n)."""
        return self.trajectory.array

    @property
    def end(self) -> str:
        """Why the path ends."""
        return str(self.trajectory.end.reason)

    def facts(self) -> Record:
        """The record of the trajectory, with the scene."""
        ending, _ = self.ending
        return {"schema": SCHEMA, "scene": self.name, "feedback": None, **self.trajectory.record(), "ending": ending}

    def table(self) -> DataTable:
        """Time and states of every sample."""
        path = self.trajectory
        lines = [list(map(float, (t, *state))) for t, state in zip(path.times, path.states, strict=True)]
        return DataTable(("t", *self.states), lines)

    def blocks(self) -> Sequence[Block]:
        """Events and end under what is followed, and whether other solutions branch off."""
        head = sentences(*self.head())
        _, ends = self.ending
        said = (ends, *self.beside(), self._unique)
        return [*head, findings(self._events()), *sentences(*said)]

    def beside(self) -> Sequence[str]:
        """What else is said of the end."""
        return ()

    @property
    def _unique(self) -> str:
        """Whether other solutions branch off, as far as the path is followed."""
        path = self.trajectory
        return UNIQUE_SO_FAR if path.unique and path.end.reason in UNFINISHED else UNIQUE[path.unique]

    def summary(self) -> str:
        """How many events, and how it ends."""
        return f"{_counted(len(self.trajectory.events))}, {self.end}"

    def written(self, ending: str) -> str:
        """The same, and below it where the path ends, when and how."""
        _, ends = self.ending
        return "\n".join((self.summary(), ends, *self.beside()))

    def draw(self, ax: Axes) -> None:
        """The path in the plane of the first two states, or over time where there is one state only."""
        from nonsmooth.reports.figures.path import draw_plane, label_plane

        picture = self.picture()
        draw_plane(ax, picture)
        label_plane(ax, picture)

    def figure(self) -> Figure:
        """The states over time too, and in a closed loop the speeds of the wheels."""
        from nonsmooth.reports.figures.path import path_figure

        return path_figure(self.picture())

    def animate(self, file: str | Path) -> Path:
        """Write the motion of the body over the wheels: .html (a page with a slider) or .gif.

        Raises:
            OutputError: for another suffix, or a file that cannot be written.
            ValueError: for the path of a plain system, and a closed loop of which there are no films.
        """
        path = output_path(str(file), FILMS)
        if self.scene is None:
            raise ValueError("required a path of an array, received one of a plain system")
        write_whole(path, self.content(path.suffix.lower()))
        return path

    def __repr__(self) -> str:
        end, path = self.trajectory.end, self.trajectory
        unique = {True: "unique", False: "not unique", None: "uniqueness not known"}[path.unique]
        place = place_text(end.state, 5)
        head = f"path of {self.name}, method {path.method}: {_counted(len(path.events))}, {unique}"
        return short_lines(head, [(f"{end.reason}:", f"{place} at t = {float_text(end.t)}")])

    def _events(self) -> list[tuple[str, str]]:
        """When something happens, and what; the end last."""
        events, end = self.trajectory.events, self.trajectory.end
        second = "" if self.scene is None else self.scene.units.after_time
        rows = []
        for event in events[:SHOWN]:
            note = f"; {event.note}" if event.note else ""
            what = f"{event.kind} at {self._place(event.state, 6)}: {event.surface}{note}"
            rows.append((f"t = {float(event.t):.6g}{second}", what))
        if len(events) > SHOWN:
            rows.append(("...", _counted(len(events) - SHOWN, "more ")))
        return [*rows, (f"end, t = {float(end.t):.6g}{second}", f"{self._place(end.state, 10)}: {end.why}")]

    def _place(self, state: Sequence[Any], digits: int) -> str:
        """A state in words; positions of a body as a point."""
        if self.scene is not None:
            return pose_text(self.scene.units, state, digits)
        values = [f"{float(value):.{digits}g}" for value in state]
        return ", ".join(f"{name} = {value}" for name, value in zip(self.states, values, strict=True))


def _counted(number: int, more: str = "") -> str:
    """``1 event``, ``2 events``, ``3 more events``."""
    return f"{number} {more}event{'' if number == 1 else 's'}"


# ---- plain systems -------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class SystemPath(PathResult):
    """A solution of a plain system.

    Attributes:
        system: the system.
        field: the field it solves.
        trajectory: the solution.
    """

    scene = partition = loop = None

    system: SwitchedSystem
    field: SignField
    trajectory: Trajectory

    @property
    def name(self) -> str:
        """Of the system."""
        return self.system.name

    @property
    def states(self) -> Sequence[str]:
        """Those that were stated."""
        return tuple(self.system.stated_states)

    def facts(self) -> Record:
        """The keys of an array's path, and the names of the states; there are no kinematics."""
        return super().facts() | {"kinematics": None, "states": list(self.states)}

    def head(self) -> Sequence[str]:
        """The system and the method."""
        states = ", ".join(self.states)
        return [f"{one_line(self.name)}: plain switched system in {states}, method {self.trajectory.method}"]

    @cached_property
    def ending(self) -> tuple[Record, str]:
        """How far from the checked point, and whether it rests there."""
        return system_end(self.system, self.trajectory)

    def picture(self) -> PathPicture:
        """The states over time, and of two states the path over the switching surfaces."""
        from nonsmooth.reports.figures.path import system_picture

        title = f"{one_line(self.name)}: method {self.trajectory.method}"
        return system_picture(self.system, self.field, self.trajectory, title)


def follow_system(system: SwitchedSystem, options: SimulateOptions) -> SystemPath:
    """A solution of a plain system.

    Raises:
        OptionError: for a start that is no place.
        ValueError: for a switching function without a gradient where it vanishes.
        TrajectoryError: where the integrator gives up.
        SceneError: for formulas that are no polynomials where the solution goes.
    """
    start = options.place(system.stated_states)
    field = system_field(system, start)
    return SystemPath(system, field, _without_refuted_doubts(system, _by_method(field, start, options)))


def _without_refuted_doubts(system: SwitchedSystem, path: Trajectory) -> Trajectory:
    """The same path, unique where it is only doubted whether another solution leaves a point that is proved stable.

    A solution that starts at a stable point stays there: it is as near to it as one likes.
    """
    doubted = [event for event in path.events if event.kind is EventKind.NONUNIQUE]
    if path.unique is not None or not doubted or not all(is_at_point(system, event.state) for event in doubted):
        return path
    from nonsmooth.proofs.system_decision import decide_system  # most paths need no proof

    try:
        if decide_system(system).exit_status:
            return path
    except SceneError:
        return path
    certain = tuple(event for event in path.events if event.kind is not EventKind.NONUNIQUE)
    return replace(path, events=certain, unique=True)


def _by_method(field: Any, start: tuple[float, ...], options: SimulateOptions) -> Trajectory:
    if options.method is PathMethod.EVENTS:
        return simulate(field, start, options.last)
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed

    compared = simulate_hysteresis if options.method is PathMethod.HYSTERESIS else simulate_smoothed
    return compared(field, start, options.last, options.width)


# ---- arrays --------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class ArrayPath(PathResult):
    """A path of a body over an array.

    Attributes:
        scene: the array.
        trajectory: the path, in the world's frame.
        partition: its cells; None under rules without cells, and for a body with an outline in the open loop, whose
            cells change with the wheels under it.
        loop: the law that sets the speeds; None for the scene's own.
        heavy: what becomes of a body with inertia from the same start, or why it is not followed; None where it is not
            asked for, as of scenes without units.
    """

    scene: Scene
    trajectory: Trajectory
    partition: Partition | None = None
    loop: FeedbackLoop | DrivenLoop | None = None
    heavy: Settled | str | None = None

    formats: ClassVar[Formats] = {
        **FORMATS,
        **dict.fromkeys(FILMS, lambda path, ending: path.film(ending)),
    }

    @property
    def name(self) -> str:
        """Of the scene."""
        return self.scene.name

    @property
    def states(self) -> Sequence[str]:
        """Position and heading."""
        return POSE

    @cached_property
    def ending(self) -> tuple[Record, str]:
        """How far from the point, at which heading, and whether it rests there."""
        end = ArrayPathEnd(self.scene, self.trajectory)
        own = "without inertia: " if self.heavy is not None else ""
        return end.record(), own + end.words()

    def beside(self) -> Sequence[str]:
        """What becomes of a body with inertia; of a law that is still at work that the clock stopped there."""
        if self.heavy is None:
            return self._clock()
        if isinstance(self.heavy, str):
            return (f"with inertia: not followed: {self.heavy}",)
        last = float_text(self.heavy.until, 3) + self.scene.units.after_time
        rests = "its place rests at " if self.heavy.kind is Settling.AT_REST else ""
        followed = f"with inertia (simulated, from rest until {rests}t = {last})"
        return (f"{followed}: {settled_words(self.scene, self.heavy)}",)

    def _clock(self) -> Sequence[str]:
        """That a path under a law ends with the time, and whether before its error is certified to halve."""
        end = self.trajectory.end
        is_over = end.reason is EndReason.TIME and ArrayPathEnd(self.scene, self.trajectory).ending.since is None
        if self.loop is None or not is_over:
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
        """The record of the trajectory, with the law and the speeds of the wheels."""
        if self.loop is None:
            own: Record = super().facts() | {"law": None, "speeds": None}
            if isinstance(self.heavy, Settled):
                own["inertia"] = settled_record(self.scene, self.heavy)
            return own
        return super().facts() | {"feedback": self.loop.name, "law": self._law(), "speeds": self._speed_rows()}

    def _law(self) -> Record | None:
        """The law of a closed loop, whether it is certified, and from where."""
        loop = self.loop
        if loop is None:
            return None
        return {
            "name": loop.name,
            "formula": loop.formula,
            "gain": loop.gain,
            "certified": loop.is_certified,
            "status": loop.status,
            "region": loop.region_text,
            "starts_inside": loop.holds(self._centred_start),
        }

    def table(self) -> DataTable:
        """Time and pose of every sample, and in a closed loop the speeds of the wheels."""
        columns, lines = super().table()
        if self.loop is None:
            return DataTable(columns, lines)
        names = (f"u_{wheel.index:d}" for wheel in self._carrying.wheels)
        return DataTable((*columns, *names), [[*a, *b] for a, b in zip(lines, self._speed_rows(), strict=True)])

    def head(self) -> Sequence[str]:
        """The kinematics and the method, and what is certified of the law."""
        path = self.trajectory
        rule = "" if self.partition is not None else f" (rule {self.scene.contact.rule})"
        lines = [f"{one_line(self.name)}: {path.kinematics} kinematics, method {path.method}{rule}"]
        if self.loop is None:
            return lines
        lines += self.loop.words(self._centred_start)
        if self.scene.body is not None:
            wheels = self._carrying.numbers
            lines.append(f"certified while wheels {numbers_text(wheels)} carry the body, and no others")
        return lines

    def summary(self) -> str:
        """How many events, how it ends, and under which law."""
        return super().summary() + ("" if self.loop is None else f"; {self.loop.title}")

    def speeds(self, times: Iterable[float] | None = None) -> Floats:
        """The speeds of all wheels in a closed loop at times, those of its samples unless given (m, n).

        At a switch they are those of the motion that begins there; nan where a wheel does not act and is given none.

        Raises:
            ValueError: in the open loop.
        """
        from nonsmooth.analysis.motion.frames import build_frames

        if self.partition is None or not isinstance(self.loop, FeedbackLoop):
            raise ValueError("required a closed loop, received the scene's own speeds")
        at = self.trajectory.t.tolist() if times is None else list(map(float, times))
        leading = self.trajectory.kinematics != Kinematics.EXACT
        pivot = self.scene.check.place if leading else None
        inputs = self.loop.inputs(self.partition)
        path, cells = self.trajectory, self.partition
        return build_frames(self._carrying, path, at, partition=cells, inputs=inputs, pivot=pivot).speeds

    def _speed_rows(self) -> list[list[float | None]]:
        """The speeds of every sample; None where a wheel is given none."""
        return [[None if math.isnan(u) else u for u in row] for row in self.speeds().tolist()]

    def film(self, ending: str) -> bytes:
        """The motion itself: a page with a slider, or a .gif."""
        from nonsmooth.reports.animation.film import build_film
        from nonsmooth.reports.animation.movie import gif_bytes
        from nonsmooth.reports.animation.page import film_page

        loop = self.loop if isinstance(self.loop, FeedbackLoop) else None
        film = build_film(whole(self.scene), self.trajectory, self.partition, loop)
        return gif_bytes(film) if ending == ".gif" else film_page(film, (self.ending[1], *self.beside())).encode()

    def picture(self) -> PathPicture:
        """The pose over time and the path over the cells, or between the wheels."""
        from nonsmooth.reports.figures.path import cells_picture, wheels_picture

        if self.partition is None:
            said = f"rule {self.scene.contact.rule}, {self.trajectory.kinematics} kinematics"
            return wheels_picture(self.scene, self.trajectory, f"{one_line(self.name)}: {said}")
        law = "" if self.loop is None else self.loop.title
        return cells_picture(self.partition, self.trajectory, law, self._speed_curves())

    def _speed_curves(self) -> SpeedCurves | None:
        """The speeds over time; None in the open loop."""
        from nonsmooth.reports.figures.path import SAMPLES, SpeedCurves
        from nonsmooth.reports.figures.style import time_label

        if not isinstance(self.loop, FeedbackLoop):
            return None
        (times, _), units = self.trajectory.dense(SAMPLES), self.scene.units
        labels = time_label("t", units), f"speeds u_i [{units.speed or 'speed'}]"
        return SpeedCurves(times, self.speeds(times), self._carrying.numbers, self.loop.limits, labels)

    @property
    def _carrying(self) -> Scene:
        """The array of the wheels that the law drives."""
        return self.scene if self.partition is None else self.partition.scene

    @property
    def _centred_start(self) -> Pose:
        """The start, measured from the checked point."""
        x, y, theta = pose_in_floats(self.trajectory.states[0])
        at_x, at_y = self._carrying.check.equilibrium
        return x - float(at_x), y - float(at_y), theta


@dataclass(frozen=True, repr=False, kw_only=True)
class DrivenPath(ArrayPath):
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
    def _carrying(self) -> Scene:
        return self.loop.scene

    @property
    def _centred_start(self) -> Pose:
        x, y, theta = pose_in_floats(self.own.states[0])
        return x, y, theta


def follow_array(scene: Scene, options: SimulateOptions) -> ArrayPath:
    """The path of a body without mass: through the cells of its rule, or by the rule's own field.

    Args:
        scene: the array.
        options: what to simulate.

    Raises:
        OptionError: for a start that is no pose, and a law, a method or kinematics that the rule does not offer.
        ValueError: for a start outside the checked square, and a law that does not apply.
        RefusalError: where the motion is not determined.
        SceneError: for a body with an outline that this run does not follow.
        TrajectoryError: where the path cannot be followed.
        ContradictionError: for a closed-loop path that contradicts the verdict about its law.
    """
    start, rule, law = options.pose, rule_of(scene), options.closed_by
    if options.is_plain and (isinstance(rule, SmoothRule) or scene.body is not None):
        from nonsmooth.analysis.bodies.mass_study import rule_path  # bodies: a path through cells needs none

        path = rule_path(scene, rule.name, start, options.last)
        return ArrayPath(scene, path, heavy=_with_inertia(scene, start))
    if law is not None and not rule.keeps_rows:
        return _follow_driven(scene, options)
    if law is not None and scene.loop_errors is not None:
        expected = "one of the other contact rules for a law whose pose is late or wrong"
        raise SceneError(scene.origin, "feedback", expected, StatedFact("nearest: it may lie in another contact state"))
    contacts = _one_contact_set(scene, options)
    partition = build_partition(standing(scene))
    loop = None if law is None else build_loop(partition, law, options.kinematics, gain=options.gain)
    path = follow_cells(partition, options, loop)
    return ArrayPath(scene, path if contacts is None else contacts.until_change(path), partition, loop)


def _with_inertia(scene: Scene, start: Pose) -> Settled | str | None:
    """What becomes of a body with inertia; None of scenes that do not say what gravity is."""
    if not has_dynamics(scene):
        return None
    from nonsmooth.proofs.answers.inertia import settled_from

    with steps("with inertia"):
        try:
            return settled_from(scene, start)
        except (ValueError, TrajectoryError, LoadError) as error:
            return one_line(str(error))


def follow_cells(partition: Partition, options: SimulateOptions, loop: FeedbackLoop | None = None) -> Trajectory:
    """The path through cells; one by events is compared with what is certified about its start.

    A closed loop is followed with the length l of the scene for its unit: steps are the same in every unit of length.

    Raises:
        ValueError: for a start outside the square, or a law without control fields.
        ContradictionError: for a closed-loop path that contradicts the verdict about its law.
    """
    start = options.pose
    if loop is None:
        return _by_method(array_field(partition, options.kinematics), start, options)
    length = float(partition.scene.check.length)
    field, (x, y, theta) = loop.field(partition), start
    if not field.faces_at(np.array(start)):
        raise ValueError(f"required a start inside the domain of the cells, received {[x, y, theta]}")
    in_length = replace(options, width=options.width / length)
    path = _by_method(field.in_unit(length), (x / length, y / length, theta), in_length).in_lengths(length)
    if options.method is PathMethod.EVENTS:
        at = partition.scene.check.equilibrium
        loop.refuse_contradiction(path, in_floats(at))
    return loop.with_saturation(partition, path)


def _one_contact_set(scene: Scene, options: SimulateOptions) -> OneContactSet | None:
    """The wheels on which a closed loop starts, and ends when they change; None without an outline.

    Raises:
        SceneError: for a run that does not follow an outline.
        ValueError: for a start on other wheels.
    """
    if scene.body is None:
        return None
    if options.method is not PathMethod.EVENTS or options.kinematics is not Kinematics.EXACT:
        require_no_outline(scene)
    return _started_on(standing(scene), options.pose)


def _started_on(scene: Scene, start: Pose) -> OneContactSet:
    """The wheels that carry the body of an array.

    Raises:
        ValueError: where others carry it at the start.
    """
    from nonsmooth.analysis.bodies.path import OneContactSet

    contacts = OneContactSet(scene, how_far(scene, "the checked point", "the checked heading"))
    contacts.require_start(start)
    return contacts


def _follow_driven(scene: Scene, options: SimulateOptions) -> DrivenPath:
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
    if options.law is not LawName.CERTIFIED:
        raise OptionError(f"{required} the certified law, received --law {options.law}")
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
    own = _until_other_wheels(loop, own_start, options.last)
    return DrivenPath(scene, own.shifted(x, y), loop=loop, own=own)


def _until_other_wheels(loop: DrivenLoop, start: Pose, until: float) -> Trajectory:
    """The path; of a body with an outline until other wheels carry it."""
    if loop.scene.body is None:
        return loop.follow(start, until)
    return _started_on(loop.scene, start).until_change(loop.follow(start, until))
