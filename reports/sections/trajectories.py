"""Trajectories in the derivation report: one path in full, and many starts to choose from."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import SupportsFloat

from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.reports.document import Block, Entry, Figure, Frame, Math, Section, decimal, table
from nonsmooth.reports.figures.path import start_mark, starts_figure
from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.papers.murphey_burdick_2001.paper import is_paper_array
from nonsmooth.reports.paths import ArrayPath
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.sections.closed_loop import closed_loop_section
from nonsmooth.reports.sections.law import without_cell_law
from nonsmooth.reports.sections.starts import Start, start_text, starts, typed_start
from nonsmooth.reports.subject import ArraySubject
from nonsmooth.symbolic.number_text import float_text

SHOWN_EVENTS = 8  # in the table of the first path
AFTERWARDS = 1.4  # how long the figure goes on, in units of the time to the rest, so that the rest can be seen


def trajectories_section(subject: ArraySubject) -> Section:
    """Filippov solutions with the scene's own speeds, and under feedback where there is a law."""
    try:
        return _trajectories(subject)
    except TrajectoryError as error:
        return Section("Trajectories", (paragraph("They could not be followed to their end: {}.", str(error)),))


def _trajectories(subject: ArraySubject) -> Section:
    field = array_field(subject.cells.partition, Kinematics.EXACT)
    places = starts(subject.cells.partition)
    paths = [_whole_path(field, start) for start in places]
    first = _first_path(field, places[0], paths[0])
    intro = paragraph(
        "Filippov solutions of the exact kinematics, followed from event to event: in closed form, with no step size, "
        "where the speeds are the scene's own."
    )
    parts = [_first_section(subject, places[0], first, paths[0]), _starts_section(subject, places, paths)]
    if not without_cell_law(subject):
        parts.append(closed_loop_section(subject))
    return Section("Trajectories", (intro,), tuple(parts))


def _first_section(subject: ArraySubject, start: Start, path: Trajectory, whole: Trajectory) -> Section:
    words = paragraph("From (x, y, theta) = {}:", Math(start_text(start), start_text(start)))
    blocks = (words, _first_figure(subject, start, path), *_first_words(whole), _event_table(path))
    return Section("Without feedback", blocks)


def _starts_section(subject: ArraySubject, places: list[Start], paths: list[Trajectory]) -> Section:
    words = paragraph(
        "{} starts on a circle about the checked point, each until the body rests, leaves the square, or the time is "
        "over:",
        str(len(places)),
    )
    return Section("Many starts", (words, _starts_figure(subject, places, paths), _starts_table(places, paths)))


def _whole_path(field: ConstantField, start: Start) -> Trajectory:
    """To the rest where there is one; once around where the path circles, and as far as can be seen to a limit."""
    path = simulate(field, start)
    last = path.pieces[-1] if path.pieces else None
    if path.end.reason is EndReason.APPROACH:
        return _cut(path, simulate(field, start, float(path.times[-1]) or 1.0))
    if path.end.reason is EndReason.CIRCLES and last is not None and last.end is None:
        rate = abs(float(last.state(1.0)[2]) - float(last.state(0.0)[2]))
        return _cut(path, simulate(field, start, float(last.start) + (2 * math.pi / rate if rate else 1.0)))
    return path


def _cut(path: Trajectory, shown: Trajectory) -> Trajectory:
    """The part that is shown of a path without end, with the reason why it has none."""
    return replace(shown, end=replace(shown.end, reason=path.end.reason))


def _first_path(field: ConstantField, start: Start, whole: Trajectory) -> Trajectory:
    """The path with some time of rest after it."""
    if whole.end.reason not in {EndReason.REST, EndReason.TURNING}:
        return whole
    return simulate(field, start, AFTERWARDS * float(whole.end.t) or 1.0)


def _first_words(path: Trajectory) -> list[Block]:
    """How theta changes at first, and where it ends."""
    end, theta = _number(path.end.t), _number(path.end.state[2])
    unique = "No other solution branches off." if path.unique else "Other solutions branch off on the way."
    if not path.end.t or not path.pieces[0].end:
        return [paragraph("The path ends where it begins: {}. {}", str(path.end.reason), unique)]
    first = float(path.pieces[0].end)
    rate = (float(path.at(first)[2]) - float(path.at(0.0)[2])) / first
    kind = "constant" if len(path.pieces[0].cells) == 1 else "mean"
    words = "Until t = {} the orientation changes at the {} rate {}; the path ends at t = {} with `theta` = {}: {}. {}"
    return [paragraph(words, _number(first), kind, _number(rate), end, theta, str(path.end.reason), unique)]


def _number(value: SupportsFloat) -> Math:
    return decimal(float_text(value))


def _event_table(path: Trajectory) -> Block:
    rows: list[tuple[Entry, ...]] = [
        (_short(event.t), *(_short(value) for value in event.state), str(event.kind), event.surface)
        for event in path.events[:SHOWN_EVENTS]
    ]
    header = ("t", "x", "y", prose("`theta`"), "event", "where")
    return table(header, rows, (2, 2.2, 2.2, 2.2, 2.2, 4.5))


def _short(value: SupportsFloat) -> str:
    return float_text(round(float(value), 12) + 0.0, 4)


def _first_figure(subject: ArraySubject, start: Start, path: Trajectory) -> Figure:
    partition = subject.cells.partition
    papers = " (the paper's Figure 4)" if is_paper_array(subject.scene) else ""

    return Figure(
        "open-loop",
        prose("Without feedback{}: x, y and `theta` over time, and the path over the cells.", papers),
        "Curves of x, y and theta over time without feedback, and the path over the cells.",
        subject.invocation.line(
            "simulate",
            "--from",
            typed_start(start, subject.scene),
            "--until",
            float_text(path.end.t),
            "-o",
            "open-loop.pdf",
        ),
        ArrayPath(partition.scene, path, partition).content,
    )


def _starts_figure(subject: ArraySubject, places: list[Start], paths: list[Trajectory]) -> Figure:
    labels = [_label(k, start, path) for k, (start, path) in enumerate(zip(places, paths, strict=True), 1)]
    return Figure(
        "starts",
        prose("Paths from many starts, one at a time where they can be chosen; all are listed below."),
        "Path over the cells and curves over time from one of the starts.",
        subject.invocation.line("simulate", "--from", typed_start(places[0], subject.scene), "-o", "path.pdf"),
        drawn(starts_figure, subject.cells.partition, paths),
        tuple(Frame(start_mark(k), label) for k, label in enumerate(labels, 1)),
    )


def _label(number: int, start: Start, path: Trajectory) -> str:
    x, y, theta = (_short(value) for value in path.end.state)
    end = f"({x}, {y}), theta = {theta} at t = {_short(path.end.t)}"
    return f"{number}: from ({_short(start[0])}, {_short(start[1])}) to {end}"


def _starts_table(places: list[Start], paths: list[Trajectory]) -> Block:
    rows: list[tuple[Entry, ...]] = [
        (
            str(k),
            f"({_short(start[0])}, {_short(start[1])})",
            _short(path.end.t),
            f"({_short(path.end.state[0])}, {_short(path.end.state[1])})",
            _short(path.end.state[2]),
            str(path.end.reason),
        )
        for k, (start, path) in enumerate(zip(places, paths, strict=True), 1)
    ]
    header = ("start", "(x, y)", "last t", "ends at (x, y)", prose("`theta` there"), "how it ends")
    marks = [(start_mark(k),) for k in range(1, len(rows) + 1)]
    return table(header, rows, (1.5, 3, 1.6, 3, 2.2, 4), marks)
