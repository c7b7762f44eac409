"""The command ``simulate``: a trajectory of an array as text, JSON, a table of samples or a picture."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.reports.animation.output import FILMS, film_bytes
from nonsmooth.reports.choices import LawName, PathMethod
from nonsmooth.reports.feedback_loop import GAIN, FeedbackLoop, build_loop
from nonsmooth.reports.terminal import two_columns
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.number_text import numbers_text
from nonsmooth.symbolic.scene_error import one_line

SCHEMA = "nonsmooth-trajectory/1"
SHOWN = 12  # events listed on a terminal
POSE = ("x", "y", "theta")


@dataclass(frozen=True)
class PathRun:
    """What to simulate.

    Attributes:
        start: ``(x, y, theta)``.
        until: last time.
        kinematics: exact pose or leading order.
        method: see :class:`PathMethod`.
        law: feedback law, ``certified`` for that of the feedback clause; None for the scene's own speeds.
        width: of the hysteresis or of the smoothing.
        gain: of the law (1/time).
        mass: of a body under full dynamics, per weight; the default unless given.
        inertia: of such a body, per weight; unless given that of a plate of its outline, or of a disc as large as the
            array.
    """

    start: tuple[float, float, float]
    until: float
    kinematics: Kinematics
    method: PathMethod
    law: LawName | None
    width: float
    gain: float = GAIN
    mass: float | None = None
    inertia: float | None = None

    @property
    def is_plain(self) -> bool:
        """Whether it is the open loop by events with exact kinematics, which every rule offers."""
        return (self.method, self.kinematics, self.law) == (PathMethod.EVENTS, Kinematics.EXACT, None)


def loop_of(partition: Partition, run: PathRun, feedback: FeedbackResult | None = None) -> FeedbackLoop | None:
    """The closed loop that a run asks for; None for the scene's own speeds.

    Args:
        partition: the cells.
        run: what to simulate.
        feedback: the verdict on the centred partition, where it is known already.

    Raises:
        ValueError: where no such law applies.
    """
    return None if run.law is None else build_loop(partition, run.law, run.kinematics, feedback, run.gain)


def follow(partition: Partition, run: PathRun, loop: FeedbackLoop | None = None) -> Trajectory:
    """Simulate; a path by events is compared with what is certified about its start.

    A closed loop is followed with the length l of the scene for its unit: steps are the same in every unit of length.

    Raises:
        ValueError: for a start outside the square, or a law without control fields.
        ContradictionError: for a closed-loop path that contradicts the verdict about its law.
    """
    if loop is None:
        return _by_method(array_field(partition, run.kinematics), run)
    length = float(partition.scene.check.length)
    field, (x, y, theta) = loop.field(partition), run.start
    if not field.faces_at(np.array(run.start)):
        raise ValueError(f"required a start inside the domain of the cells, received {[x, y, theta]}")
    own = replace(run, start=(x / length, y / length, theta), width=run.width / length)
    path = _by_method(field.in_unit(length), own).in_lengths(length)
    if run.method is PathMethod.EVENTS:
        at = partition.scene.check.equilibrium
        loop.refuse_contradiction(path, (float(at[0]), float(at[1])))
    return loop.with_saturation(partition, path)


def _by_method(field: Any, run: PathRun) -> Trajectory:
    if run.method is PathMethod.EVENTS:
        return simulate(field, run.start, run.until)
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed

    compared = simulate_hysteresis if run.method is PathMethod.HYSTERESIS else simulate_smoothed
    return compared(field, run.start, run.until, run.width)


@dataclass(frozen=True)
class ShownTrajectory:
    """One path of an array."""

    partition: Partition
    run: PathRun
    trajectory: Trajectory
    loop: FeedbackLoop | None = None

    def record(self) -> dict[str, Any]:
        """The record of the trajectory, with the scene and the law."""
        return {
            "schema": SCHEMA,
            "scene": self.partition.scene.name,
            "feedback": None if self.loop is None else str(self.loop.law),
            "law": None if self.loop is None else law_record(self.loop, self._starts_inside),
            **self.trajectory.record(),
            "speeds": None if self._inputs is None else [[_known(u) for u in row] for row in self._inputs.tolist()],
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time and pose of every sample, and in a closed loop the speeds of the wheels, empty where it gives none."""
        if self._inputs is None:
            yield from sample_lines(self.trajectory, POSE)
            return
        header, *lines = sample_lines(self.trajectory, POSE)
        yield (*header, *(f"u_{wheel.index}" for wheel in self.partition.scene.wheels))
        for line, row in zip(lines, self._inputs.tolist(), strict=True):
            yield (*line, *("" if math.isnan(u) else repr(u) for u in row))

    @cached_property
    def _inputs(self) -> NDArray[np.float64] | None:
        """The speeds of the wheels at every sample (m, n); nan where a law gives none; None in the open loop."""
        return None if self.loop is None else loop_speeds(self.partition, self.trajectory, self.loop)

    def picture(self, suffix: str) -> bytes:
        """The pose over time and the path over the cells; or the motion itself."""
        if suffix in FILMS:
            from nonsmooth.reports.animation.film import build_film

            return film_bytes(
                build_film(whole(self.partition.scene), self.trajectory, self.partition, self.loop), suffix
            )
        from nonsmooth.reports.figures.trajectory import SpeedCurves, dense_times, trajectory_figure

        if self.loop is None:
            return trajectory_figure(self.partition, self.trajectory, suffix)
        times = dense_times(self.trajectory)
        curves = SpeedCurves(times, loop_speeds(self.partition, self.trajectory, self.loop, times), self.loop.limits)
        return trajectory_figure(self.partition, self.trajectory, suffix, self.loop.title, curves)

    def summary(self) -> str:
        """How many events, how it ends, and under which law."""
        law = "" if self.loop is None else f"; {self.loop.title}"
        return path_summary(self.trajectory) + law

    def view(self) -> RenderableType:
        """Events and end as a table."""
        name, path = one_line(self.partition.scene.name), self.trajectory
        head = f"{name}: {path.kinematics} kinematics, method {path.method}"
        law = [] if self.loop is None else law_lines(self.loop, self._starts_inside)
        if self.partition.scene.body is not None:
            wheels = tuple(wheel.index for wheel in self.partition.scene.wheels)
            law.append(f"certified while wheels {numbers_text(wheels)} carry the body, and no others")
        return events_view("\n".join((head, *law)), path, POSE)

    @property
    def _starts_inside(self) -> bool | None:
        """Whether the start lies in the certified region; None where there is none."""
        if self.loop is None or self.loop.region is None:
            return None
        x, y, theta = self.run.start
        centre = self.partition.scene.check.equilibrium
        return self.loop.region.contains((x - float(centre[0]), y - float(centre[1]), theta))


def loop_speeds(
    partition: Partition, trajectory: Trajectory, loop: FeedbackLoop, times: Iterable[float] | None = None
) -> NDArray[np.float64]:
    """The speeds of all wheels in a closed loop at times, those of its samples unless given (m, n).

    At a switch they are those of the motion that begins there; nan where a wheel does not act and is given none.
    """
    from nonsmooth.analysis.motion.frames import build_frames

    at = [float(time) for time in (trajectory.times if times is None else times)]
    leading = trajectory.kinematics != Kinematics.EXACT
    pivot = [float(x) for x in partition.scene.check.equilibrium] if leading else None
    inputs = loop.inputs(partition)
    return build_frames(partition.scene, trajectory, at, partition=partition, inputs=inputs, pivot=pivot).speeds


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def law_record(loop: FeedbackLoop, starts_inside: bool | None) -> dict[str, Any]:
    """The law of a closed loop, whether it is certified, and from where."""
    return {
        "name": str(loop.law),
        "formula": loop.formula,
        "gain": loop.gain,
        "certified": loop.is_certified,
        "status": loop.status,
        "region": None if loop.region is None else str(loop.region),
        "starts_inside": starts_inside,
    }


def law_lines(loop: FeedbackLoop, starts_inside: bool | None) -> list[str]:
    """The same for a terminal."""
    lines = [f"feedback: {loop.title}, k = {loop.gain:g}", loop.formula]
    if not loop.is_certified:
        return lines
    if loop.region is None:
        return [*lines, "certified near c*; how near is not known"]
    where = "inside" if starts_inside else "outside"
    return [*lines, f"certified region: {loop.region}; the start lies {where} it"]


def sample_lines(trajectory: Trajectory, states: Sequence[str]) -> Iterable[Iterable[Any]]:
    """Samples as lines of a CSV file: t and the states."""
    yield ("t", *states)
    for time, state in zip(trajectory.times, trajectory.states, strict=True):
        yield tuple(repr(float(value)) for value in (time, *state))


def path_summary(trajectory: Trajectory) -> str:
    """How many events, and how it ends."""
    return f"{len(trajectory.events)} events, {trajectory.end.reason}"


def events_view(head: str, trajectory: Trajectory, states: Sequence[str]) -> RenderableType:
    """Events and end as a table under a headline."""
    rows = two_columns()
    for event in trajectory.events[:SHOWN]:
        note = f"; {event.note}" if event.note else ""
        place = f"{event.kind} at {_place(event.state, states, 6)}: {event.surface}{note}"
        rows.add_row(Text(f"t = {float(event.t):.6g}"), Text(place))
    if len(trajectory.events) > SHOWN:
        rows.add_row(Text("..."), Text(f"{len(trajectory.events) - SHOWN} more events"))
    end = f"{_place(trajectory.end.state, states, 10)}: {trajectory.end.reason}"
    rows.add_row(Text(f"end, t = {float(trajectory.end.t):.6g}", "bold"), Text(end))
    said = {True: "unique", False: "not unique: other solutions branch off", None: "uniqueness not decided"}
    return Group(Text(head), rows, Text(said[trajectory.unique]))


def _place(state: Sequence[Any], states: Sequence[str], digits: int) -> str:
    """A state in words; positions of a body as a point."""
    values = [f"{float(value):.{digits}g}" for value in state]
    if states == POSE:
        return f"({values[0]}, {values[1]}), theta = {values[2]}"
    return ", ".join(f"{name} = {value}" for name, value in zip(states, values, strict=True))
