"""A path: one solution of an array or of a plain system, with its events.

The command ``simulate`` prints and saves the object that Python users hold.  What all paths share is said by
:class:`PathResult`; what a plain system and an array add (cells, a film), by the classes below it.  Paths under a law
(:mod:`nonsmooth.reports.simulations.closed_paths`) and of a body with mass
(:mod:`nonsmooth.reports.simulations.masses`) are paths of an array that say more.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from nonsmooth.analysis.bodies.settling import Settling, SettlingResult
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.trajectories.result import UNFINISHED, EventKind, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.answer import has_dynamics
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.files import FILMS, output_path, write_whole
from nonsmooth.reports.output.progress import steps
from nonsmooth.reports.output.study_options import PathMethod
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
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.analysis.fields.sign_field import SignField
    from nonsmooth.reports.animation.film import Film
    from nonsmooth.reports.figures.path import PathPicture
    from nonsmooth.reports.laws.driven_loop import DrivenLoop
    from nonsmooth.reports.laws.feedback_loop import FeedbackLoop
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SCHEMA = "nonsmooth-trajectory/1"
SHOWN = 12  # events listed on a terminal
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
    loop: FeedbackLoop | DrivenLoop | None = None

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

    scene = partition = None

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
    from nonsmooth.analysis.fields.system_field import system_field

    start = options.place(system.stated_states)
    field = system_field(system, start)
    return SystemPath(system, field, _without_refuted_doubts(system, by_method(field, start, options)))


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


def by_method(field: Any, start: tuple[float, ...], options: SimulateOptions) -> Trajectory:
    """The solution of a field from a start, by events or by one of the methods that are compared with them."""
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
        heavy: what becomes of a body with inertia from the same start, or why it is not followed; None where it is not
            asked for, as of scenes without units.
    """

    scene: Scene
    trajectory: Trajectory
    partition: Partition | None = None
    heavy: SettlingResult | str | None = None

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
        assumption = "without inertia: " if self.heavy is not None else ""
        return end.record(), assumption + end.words()

    def beside(self) -> Sequence[str]:
        """What becomes of a body with inertia."""
        if self.heavy is None:
            return ()
        if isinstance(self.heavy, str):
            return (f"with inertia: not followed: {self.heavy}",)
        last = float_text(self.heavy.until, 3) + self.scene.units.after_time
        rests = "its place rests at " if self.heavy.kind is Settling.AT_REST else ""
        followed = f"with inertia (simulated, from rest until {rests}t = {last})"
        return (f"{followed}: {settled_words(self.scene, self.heavy)}",)

    def facts(self) -> Record:
        """The record of the trajectory, and what becomes of a body with inertia; there is no law."""
        record: Record = super().facts() | {"law": None, "speeds": None}
        if isinstance(self.heavy, SettlingResult):
            record["inertia"] = settled_record(self.scene, self.heavy)
        return record

    def head(self) -> Sequence[str]:
        """The kinematics and the method."""
        path = self.trajectory
        rule = "" if self.partition is not None else f" (rule {self.scene.contact.rule})"
        return [f"{one_line(self.name)}: {path.kinematics} kinematics, method {path.method}{rule}"]

    def speeds(self, times: Iterable[float] | None = None) -> Floats:
        """The speeds of all wheels in a closed loop at times, those of its samples unless given (m, n).

        Raises:
            ValueError: in the open loop.
        """
        raise ValueError("required a closed loop, received the scene's own speeds")

    def film(self, ending: str) -> bytes:
        """The motion itself: a page with a slider, or a .gif."""
        from nonsmooth.reports.animation.movie import gif_bytes
        from nonsmooth.reports.animation.page import film_page

        film = self._frames()
        return gif_bytes(film) if ending == ".gif" else film_page(film, (self.ending[1], *self.beside())).encode()

    def _frames(self) -> Film:
        """What moves over which wheels."""
        from nonsmooth.reports.animation.film import build_film

        return build_film(whole(self.scene), self.trajectory, self.partition)

    def picture(self) -> PathPicture:
        """The pose over time and the path over the cells, or between the wheels."""
        from nonsmooth.reports.figures.path import cells_picture, wheels_picture

        if self.partition is None:
            said = f"rule {self.scene.contact.rule}, {self.trajectory.kinematics} kinematics"
            return wheels_picture(self.scene, self.trajectory, f"{one_line(self.name)}: {said}")
        return cells_picture(self.partition, self.trajectory)


def follow_array(scene: Scene, options: SimulateOptions) -> ArrayPath:
    """The path of a body without mass in the open loop: through the cells of its rule, or by the rule's own field.

    Raises:
        OptionError: for a start that is no pose, and a method or kinematics that the rule does not offer.
        ValueError: for a start outside the checked square.
        RefusalError: where the motion is not determined.
        SceneError: for a body with an outline that this run does not follow.
        TrajectoryError: where the path cannot be followed.
    """
    start, rule = options.pose, rule_of(scene)
    if options.is_plain and (isinstance(rule, SmoothRule) or scene.body is not None):
        from nonsmooth.analysis.bodies.mass_study import rule_path  # bodies: a path through cells needs none

        path = rule_path(scene, rule.name, start, options.last)
        return ArrayPath(scene, path, heavy=_with_inertia(scene, start))
    require_no_outline(scene)
    partition = build_partition(standing(scene))
    return ArrayPath(scene, follow_cells(partition, options), partition)


def _with_inertia(scene: Scene, start: Pose) -> SettlingResult | str | None:
    """What becomes of a body with inertia; None of scenes that do not say what gravity is."""
    if not has_dynamics(scene):
        return None
    from nonsmooth.proofs.answers.inertia import settled_from

    with steps("with inertia"):
        try:
            return settled_from(scene, start)
        except (ValueError, TrajectoryError, LoadError) as error:
            return one_line(str(error))


def follow_cells(partition: Partition, options: SimulateOptions) -> Trajectory:
    """The path through cells at the scene's own speeds.

    Raises:
        ValueError: for a start outside the square.
    """
    return by_method(array_field(partition, options.kinematics), options.pose, options)
