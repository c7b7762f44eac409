"""The closed loop in the derivation report: the certified law from starts in its certified region, and one path."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory, TrajectoryError
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.reports.choices import LawName
from nonsmooth.reports.document import Block, Entry, Figure, Section, table
from nonsmooth.reports.feedback_loop import GAIN, FeedbackLoop, build_loop
from nonsmooth.reports.figures.path import cells_picture, path_figure
from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.papers.murphey_burdick_2001.paper import is_paper_array
from nonsmooth.reports.paths import follow_cells
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.sections.starts import STARTS, Start, start_text, starts, typed_start
from nonsmooth.reports.simulate_options import SimulateOptions
from nonsmooth.reports.subject import ArraySubject
from nonsmooth.symbolic.number_text import float_text

HEADING = 0.3  # radian at the start: a heading to be brought back, small beside a turn
QUARTERS = 4  # starts on a circle, the headings of their signs in turn
TIMES = (8.0, 16.0, 32.0, 64.0, 100.0)  # followed to the first of these at which the body is as good as home
ARRIVED = 1e-3  # of V at the start: a figure shows no less, and beyond it paths of many switches take long
HALVINGS = 20  # of a start until it lies in the region, or, where that is not known, until its path stays in the square


@dataclass(frozen=True)
class _Path:
    """A start with its path."""

    start: Start
    path: Trajectory
    until: float

    @property
    def leaves(self) -> bool:
        """Whether the body leaves the checked square."""
        return self.path.end.reason is EndReason.OUTSIDE


def closed_loop_section(subject: ArraySubject) -> Section:
    """Where the certified law leads from four sides, and one of the paths."""
    loop = _loop(subject)
    try:
        paths = [_from(subject, loop, start) for start in _quarters(subject)]
    except TrajectoryError as error:
        return Section("With feedback", (paragraph("A path could not be followed to its end: {}.", str(error)),))
    if any(path.leaves for path in paths):  # only where no region is known
        none = "Even from starts of 1e-6 of the square the path first leaves it, so none is drawn."
        return Section("With feedback", (paragraph(none),))
    words = paragraph(
        "Under the {} law, {}, with `k` = {}, each start was followed until the body is as good as home, at most to "
        "t = {}:",
        str(loop.law),
        loop.status,
        f"{GAIN:g}",
        f"{TIMES[-1]:g}",
    )
    return Section("With feedback", (words, _ends(loop, paths), _figure(subject, loop, paths[0])))


def _loop(subject: ArraySubject) -> FeedbackLoop:
    feedback = subject.cells.feedback
    if not isinstance(feedback, FeedbackResult):
        raise TypeError(f"required rule nearest, received {subject.scene.contact.rule}")
    return build_loop(subject.cells.partition, LawName.CERTIFIED, Kinematics.EXACT, feedback)


def _quarters(subject: ArraySubject) -> list[Start]:
    """Four places about the checked point, with headings of both signs."""
    places = starts(subject.cells.partition)[:: STARTS // QUARTERS]
    return [(x, y, HEADING * (-1) ** k) for k, (x, y, _) in enumerate(places)]


def _from(subject: ArraySubject, loop: FeedbackLoop, start: Start) -> _Path:
    """The path from the start, moved nearer until it lies in the certified region, or else stays in the square."""
    if loop.region is not None:
        return _followed(subject, loop, _inside(loop, start))
    for _ in range(HALVINGS):
        path = _followed(subject, loop, start)
        if not path.leaves:
            break
        start = _smaller(start, 1 / 2)
    return path


def _followed(subject: ArraySubject, loop: FeedbackLoop, start: Start) -> _Path:
    """The path to the first of the times at which the body is as good as home."""
    for until in TIMES:
        options = SimulateOptions(start=start, until=until, feedback=True)
        path = _Path(start, follow_cells(subject.cells.partition, options, loop), until)
        if path.path.end.reason is not EndReason.TIME or _is_home(loop, path):
            break
    return path


def _is_home(loop: FeedbackLoop, path: _Path) -> bool:
    """Whether V, or the squared size of the pose where there is none, has fallen to a small part of what it was."""
    x, y, theta = (float(value) for value in path.path.end.state)
    if loop.region is not None:
        return loop.region.value((x, y, theta)) < ARRIVED * loop.region.value(path.start)
    weight = float(loop.partition.scene.check.length) ** 2
    sizes = [a * a + b * b + weight * turn * turn for a, b, turn in (path.start, (x, y, theta))]
    return sizes[1] < ARRIVED * sizes[0]


def _inside(loop: FeedbackLoop, start: Start) -> Start:
    """The start in the certified region: the heading alone, then the place, are halved until they are."""
    region = loop.region
    if region is None:
        return start
    x, y, theta = start
    for _ in range(HALVINGS):
        if 4 * region.value((0.0, 0.0, theta)) < region.level:
            break
        theta /= 2
    for _ in range(HALVINGS):
        if region.contains((x, y, theta)):
            break
        x, y = x / 2, y / 2
    return _smaller((x, y, theta), 1)


def _smaller(start: Start, factor: float) -> Start:
    """A part of a start, as a command line would hold it."""
    x, y, theta = (float(float_text(value * factor)) for value in start)
    return x, y, theta


def _ends(loop: FeedbackLoop, paths: list[_Path]) -> Block:
    value = "V" if loop.region is None or loop.feedback.cascade is None else "W"
    header = ("start (x, y, theta)", f"{value} there", "last t", "x", "y", prose("`theta`"), f"{value}", "how it ended")
    return table(header, [_row(loop, path) for path in paths], (2.8, 2, 1.5, 2.1, 2.1, 2.1, 1.9, 2.5))


def _row(loop: FeedbackLoop, path: _Path) -> tuple[Entry, ...]:
    end = path.path.end
    x, y, theta = (float(value) for value in end.state)
    first, last = ("", "") if loop.region is None else (loop.region.value(path.start), loop.region.value((x, y, theta)))
    levels = [value if isinstance(value, str) else float_text(value, 2) for value in (first, last)]
    # What rounding leaves of zero differs from machine to machine: it is shown as zero.
    place = [float_text(round(value, 12) + 0.0, 2) for value in (x, y, theta)]
    return start_text(path.start), levels[0], float_text(end.t, 4), *place, levels[1], str(end.reason)


def _figure(subject: ArraySubject, loop: FeedbackLoop, path: _Path) -> Figure:
    papers = "; the paper's Figure 5 is of its own law" if is_paper_array(subject.scene) else ""

    start = typed_start(path.start, subject.scene)
    options = ("--from", start, "--until", f"{path.until:g}", "--feedback", "-o", "closed-loop.pdf")
    return Figure(
        "closed-loop",
        prose(
            "The closed loop under the {} law of clause 4{}: x, y and `theta` over time, and the path.",
            str(loop.law),
            papers,
        ),
        "Curves of x, y and theta over time under feedback, and the path over the cells.",
        subject.invocation.line("simulate", *options),
        drawn(path_figure, cells_picture(subject.cells.partition, path.path, loop.title)),
    )
