"""The command ``simulate``: a trajectory of an array as text, JSON, a table of samples or a picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.fields.cellwise_field import Law as SpeedLaw
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import (
    cascade_law,
    corrected_law,
    gradient_law,
    printed_law,
    tangential_law,
)
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.switched_field import array_field
from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.reports.choices import Law, Method
from nonsmooth.reports.terminal import two_columns
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene_error import one_line

SCHEMA = "nonsmooth-trajectory/1"
GAIN = 1.0
SHOWN = 12  # events listed on a terminal
POSE = ("x", "y", "theta")

LAWS = {Law.CORRECTED: corrected_law, Law.PRINTED: printed_law}


@dataclass(frozen=True)
class Run:
    """What to simulate.

    Attributes:
        start: ``(x, y, theta)``.
        until: last time.
        kinematics: exact pose or leading order.
        method: see :class:`Method`.
        law: feedback law; None for the scene's own speeds.
        width: of the hysteresis or of the smoothing.
    """

    start: tuple[float, float, float]
    until: float
    kinematics: Kinematics
    method: Method
    law: Law | None
    width: float


def follow(partition: Partition, run: Run) -> Trajectory:
    """Simulate.

    Raises:
        ValueError: for a start outside the square, or a law without control fields.
    """
    field: Any = array_field(partition, run.kinematics)
    if run.law is not None:
        if partition.rule is not Rule.NEAREST:
            raise ValueError(f"--feedback: required rule nearest, received {partition.rule}")
        field = feedback_field(partition, _speeds(partition, run.law), run.kinematics)
    if run.method is Method.EVENTS:
        return simulate(field, run.start, run.until)
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed

    compared = simulate_hysteresis if run.method is Method.HYSTERESIS else simulate_smoothed
    return compared(field, run.start, run.until, run.width)


def _speeds(partition: Partition, law: Law) -> SpeedLaw:
    """The law in every cell; the gradient law is that of ``check``, with the V found there, and so is the cascade."""
    if law in LAWS:
        return LAWS[law](GAIN)
    from nonsmooth.proofs.clauses.cascade_law import Descent, find_cascade
    from nonsmooth.proofs.clauses.cones import build_fan
    from nonsmooth.proofs.clauses.feedback import decide_feedback

    if law is Law.CASCADE:
        cascade = find_cascade(build_fan(partition))
        if cascade is None:
            raise ValueError("--law cascade: required an array with a law that takes theta first, received one without")
        if cascade.descent is Descent.SLOW_TURNS:
            return tangential_law(GAIN, float(partition.scene.check.radius))
        return cascade_law(GAIN, {wheel.index: s for wheel, s in zip(cascade.wheels, cascade.signs, strict=True)})
    lyapunov = decide_feedback(partition).lyapunov
    return gradient_law(GAIN, (float(lyapunov.shape[0]), float(lyapunov.shape[1])), float(lyapunov.weight))


@dataclass(frozen=True)
class ShownTrajectory:
    """One path of an array."""

    partition: Partition
    run: Run
    trajectory: Trajectory

    def record(self) -> dict[str, Any]:
        """The record of the trajectory, with the scene and the law."""
        law = None if self.run.law is None else str(self.run.law)
        return {"schema": SCHEMA, "scene": self.partition.scene.name, "feedback": law, **self.trajectory.record()}

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time and pose of every sample."""
        return sample_lines(self.trajectory, POSE)

    def picture(self, suffix: str) -> bytes:
        """The pose over time and the path over the cells."""
        from nonsmooth.reports.figures.trajectory import trajectory_figure

        return trajectory_figure(self.partition, self.trajectory, suffix)

    def summary(self) -> str:
        """How many events, and how it ends."""
        return path_summary(self.trajectory)

    def view(self) -> RenderableType:
        """Events and end as a table."""
        name, path = one_line(self.partition.scene.name), self.trajectory
        return events_view(f"{name}: {path.kinematics} kinematics, method {path.method}", path, POSE)


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
