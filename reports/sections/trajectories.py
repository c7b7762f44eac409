"""Trajectories in the derivation report: one path in full, many starts to choose from, and closed loops.

Under rule ``nearest`` the certified law is followed over the cells from four starts in its certified region; under the
other rules the law of imposed twists is a field of its own, which is followed as far as that can be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.findings import Feedback
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.figures.path import cells_picture, centre_picture, path_figure, start_mark, starts_figure
from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.laws.feedback_loop import GAIN, FeedbackLoop, build_loop, certified_law
from nonsmooth.reports.output.document import Block, Code, Entry, Figure, Frame, Math, Section, decimal, table
from nonsmooth.reports.output.prose import paragraph, prose
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import is_paper_array, law_of_section_3_3
from nonsmooth.reports.sections.feedback import law_formulas, region_blocks
from nonsmooth.reports.simulations.closed_paths import follow_loop
from nonsmooth.reports.simulations.path_ends import pose_text, shown_angle
from nonsmooth.reports.simulations.paths import ArrayPath
from nonsmooth.reports.simulations.simulate_options import SimulateOptions, unit_of_typed_angles
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import AngleUnit, Units
from nonsmooth.symbolic.numbers.number_text import float_text, lower_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from nonsmooth.reports.laws.driven_loop import DrivenLoop

# ---- starts --------------------------------------------------------------------------------------


STARTS = 24
# Off the axes and diagonals, so that symmetric arrays have no tie there, in half-widths of the square from the
# checked point: (0.2, 0.4) for the paper's array.
USUAL = (0.4, 0.8)


def starts(partition: Partition) -> list[Pose]:
    """STARTS places on a circle about the checked point, the usual one first, counterclockwise, at heading 0."""
    radius = partition.scene.check.half_width
    x, y = partition.scene.check.place
    places = []
    for k in range(STARTS):
        c, s = math.cos(2 * math.pi * k / STARTS), math.sin(2 * math.pi * k / STARTS)
        along, up = USUAL[0] * c - USUAL[1] * s, USUAL[0] * s + USUAL[1] * c
        places.append((_typed(x + radius * along), _typed(y + radius * up), 0.0))
    return places


def typed_start(start: Pose, scene: Scene) -> str:
    """``x,y,theta`` for ``--from``, which takes world coordinates; a report measures from the checked point."""
    x, y = (centre + value for centre, value in zip(scene.check.place, start, strict=False))
    names_unit = start[2] != 0 and unit_of_typed_angles(scene) is not AngleUnit.RADIAN
    return ",".join(map(float_text, (x, y, start[2]))) + "rad" * names_unit


def _typed(value: float) -> float:
    """The value as a command line would hold it."""
    return float(float_text(value))


# ---- without feedback ----------------------------------------------------------------------------

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
    if rule_of(subject.scene).keeps_rows and not without_law(subject):
        parts.append(closed_loop_section(subject))
    return Section("Trajectories", (intro,), tuple(parts))


def _first_section(subject: ArraySubject, start: Pose, path: Trajectory, whole: Trajectory) -> Section:
    units = subject.scene.units
    place = place_text((*start[:2], shown_angle(units, start[2]))) + " deg" * (units.in_degrees and start[2] != 0)
    words = paragraph("From (x, y, theta) = {}:", Math(place, place))
    blocks = (words, _first_figure(subject, start, path), *_first_words(whole, units), _event_table(path, units))
    return Section("Without feedback", blocks)


def _starts_section(subject: ArraySubject, places: list[Pose], paths: list[Trajectory]) -> Section:
    words = paragraph(
        "{} starts on a circle about the checked point, each until the body rests, leaves the square, or the time is "
        "over:",
        str(len(places)),
    )
    return Section(
        "Many starts",
        (words, _starts_figure(subject, places, paths), _starts_table(places, paths, subject.scene.units)),
    )


def _whole_path(field: ConstantField, start: Pose) -> Trajectory:
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


def _first_path(field: ConstantField, start: Pose, whole: Trajectory) -> Trajectory:
    """The path with some time of rest after it."""
    if whole.end.reason not in {EndReason.REST, EndReason.TURNING}:
        return whole
    return simulate(field, start, AFTERWARDS * float(whole.end.t) or 1.0)


def _first_words(path: Trajectory, units: Units) -> list[Block]:
    """How theta changes at first, and where it ends."""
    end, theta = _number(path.end.t), _number(shown_angle(units, float(path.end.state[2])))
    unique = "No other solution branches off." if path.unique else "Other solutions branch off on the way."
    if not path.end.t or not path.pieces[0].end:
        return [paragraph("The path ends where it begins: {}. {}", str(path.end.reason), unique)]
    first = float(path.pieces[0].end)
    rate = (float(path.at(first)[2]) - float(path.at(0.0)[2])) / first
    kind = "constant" if len(path.pieces[0].cells) == 1 else "mean"
    degrees, rates = (" deg", " deg/s") if units.in_degrees else ("", "")
    words = (
        f"Until t = {{}} the orientation changes at the {{}} rate {{}}{rates}; "
        f"the path ends at t = {{}} with `theta` = {{}}{degrees}: {{}}. {{}}"
    )
    shown = _number(shown_angle(units, rate))
    return [paragraph(words, _number(first), kind, shown, end, theta, str(path.end.reason), unique)]


def _shown_pose(state: Sequence[SupportsFloat], units: Units) -> Pose:
    """A pose with its heading as people read it."""
    x, y, theta = pose_in_floats(state)
    return x, y, shown_angle(units, theta)


def _theta(units: Units, where: str = "") -> Entry:
    """The head of a column of headings."""
    return prose(f"`theta`{where}{' (deg)' * units.in_degrees}")


def _number(value: SupportsFloat) -> Math:
    return decimal(float_text(value))


def _event_table(path: Trajectory, units: Units) -> Block:
    rows: list[tuple[Entry, ...]] = [
        (_short(event.t), *map(_short, _shown_pose(event.state, units)), str(event.kind), event.surface)
        for event in path.events[:SHOWN_EVENTS]
    ]
    header = ("t", "x", "y", _theta(units), "event", "where")
    return table(header, rows, (2, 2.2, 2.2, 2.2, 2.2, 4.5))


def _short(value: SupportsFloat) -> str:
    return float_text(round(float(value), 12) + 0.0, 4)


def _first_figure(subject: ArraySubject, start: Pose, path: Trajectory) -> Figure:
    partition = subject.cells.partition
    papers = " (the paper's Figure 4)" if is_paper_array(subject.scene) else ""
    options = ("--from", typed_start(start, subject.scene), "--until", float_text(path.end.t), "-o", "open-loop.pdf")
    return Figure(
        "open-loop",
        prose("Without feedback{}: x, y and `theta` over time, and the path over the cells.", papers),
        "Curves of x, y and theta over time without feedback, and the path over the cells.",
        subject.invocation.line("simulate", *options),
        ArrayPath(partition.scene, path, partition).content,
    )


def _starts_figure(subject: ArraySubject, places: list[Pose], paths: list[Trajectory]) -> Figure:
    units = subject.scene.units
    labels = [_label(k, start, path, units) for k, (start, path) in enumerate(zip(places, paths, strict=True), 1)]
    return Figure(
        "starts",
        prose("Paths from many starts, one at a time where they can be chosen; all are listed below."),
        "Path over the cells and curves over time from one of the starts.",
        subject.invocation.line("simulate", "--from", typed_start(places[0], subject.scene), "-o", "path.pdf"),
        drawn(starts_figure, subject.cells.partition, paths),
        tuple(Frame(start_mark(k), label) for k, label in enumerate(labels, 1)),
    )


def _label(number: int, start: Pose, path: Trajectory, units: Units) -> str:
    pose = [round(float(value), 12) + 0.0 for value in path.end.state]
    end = f"{pose_text(units, pose, 4)} at t = {_short(path.end.t)}"
    return f"{number}: from ({_short(start[0])}, {_short(start[1])}) to {end}"


def _starts_table(places: list[Pose], paths: list[Trajectory], units: Units) -> Block:
    rows: list[tuple[Entry, ...]] = [
        (
            str(k),
            f"({_short(start[0])}, {_short(start[1])})",
            _short(path.end.t),
            f"({_short(path.end.state[0])}, {_short(path.end.state[1])})",
            _short(shown_angle(units, float(path.end.state[2]))),
            str(path.end.reason),
        )
        for k, (start, path) in enumerate(zip(places, paths, strict=True), 1)
    ]
    header = ("start", "(x, y)", "last t", "ends at (x, y)", _theta(units, " there"), "how it ends")
    marks = [(start_mark(k),) for k in range(1, len(rows) + 1)]
    return table(header, rows, (1.5, 3, 1.6, 3, 2.2, 4), marks)


# ---- closed loops --------------------------------------------------------------------------------

HEADING = 0.3  # radian at the start: a heading to be brought back, small beside a turn
QUARTERS = 4  # starts on a circle, the headings of their signs in turn
TIMES = (8.0, 16.0, 32.0, 64.0, 100.0)  # followed to the first of these at which the body is as good as home
ARRIVED = 1e-3  # of V at the start: a figure shows no less, and beyond it paths of many switches take long
HALVINGS = 20  # of a start until it lies in the region, or, where that is not known, until its path stays in the square


@dataclass(frozen=True)
class FollowedStart:
    """A start with its path in a closed loop."""

    start: Pose
    path: Trajectory
    until: float

    @property
    def leaves(self) -> bool:
        """Whether the body leaves the checked square."""
        return self.path.end.reason is EndReason.OUTSIDE


def _ends_table(value: str, how: str, rows: Sequence[tuple[Entry, ...]], units: Units) -> Block:
    """Start, V there, last time, pose and V at the end, and one thing more, of each path."""
    header = ("start (x, y, theta)", f"{value} there", "last t", "x", "y", _theta(units), value, how)
    return table(header, rows, (2.8, 2, 1.5, 2.1, 2.1, 2.1, 1.9, 2.5))


def closed_loop_section(subject: ArraySubject) -> Section:
    """Where the certified law leads from four sides, and one of the paths."""
    loop = build_loop(subject.cells.partition, LawName.CERTIFIED, Kinematics.EXACT, _law_of_cells(subject))
    try:
        paths = [_path_from(subject, loop, start) for start in _quarters(subject)]
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
    value = "V" if loop.region is None or loop.feedback.cascade is None else "W"
    units = loop.partition.scene.units
    ends = _ends_table(value, "how it ended", [_cells_row(loop, path, units) for path in paths], units)
    return Section("With feedback", (words, ends, _cells_figure(subject, loop, paths[0])))


def _quarters(subject: ArraySubject) -> list[Pose]:
    """Four places about the checked point, with headings of both signs."""
    places = starts(subject.cells.partition)[:: STARTS // QUARTERS]
    return [(x, y, HEADING * (-1) ** k) for k, (x, y, _) in enumerate(places)]


def _path_from(subject: ArraySubject, loop: FeedbackLoop, start: Pose) -> FollowedStart:
    """The path from the start, moved nearer until it lies in the certified region, or else stays in the square."""
    if loop.region is not None:
        return _followed(subject, loop, _inside(loop, start))
    for _ in range(HALVINGS):
        path = _followed(subject, loop, start)
        if not path.leaves:
            break
        start = _smaller(start, 1 / 2)
    return path


def _followed(subject: ArraySubject, loop: FeedbackLoop, start: Pose) -> FollowedStart:
    """The path to the first of the times at which the body is as good as home."""
    for until in TIMES:
        options = SimulateOptions(start=start, until=until, feedback=True)
        path = FollowedStart(start, follow_loop(subject.cells.partition, options, loop), until)
        if path.path.end.reason is not EndReason.TIME or _is_home(loop, path):
            break
    return path


def _is_home(loop: FeedbackLoop, path: FollowedStart) -> bool:
    """Whether V, or the squared size of the pose where there is none, has fallen to a small part of what it was."""
    x, y, theta = pose_in_floats(path.path.end.state)
    if loop.region is not None:
        return loop.region.value((x, y, theta)) < ARRIVED * loop.region.value(path.start)
    weight = float(loop.partition.scene.check.length) ** 2
    sizes = [a * a + b * b + weight * turn * turn for a, b, turn in (path.start, (x, y, theta))]
    return sizes[1] < ARRIVED * sizes[0]


def _inside(loop: FeedbackLoop, start: Pose) -> Pose:
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


def _smaller(start: Pose, factor: float) -> Pose:
    """A part of a start, as a command line would hold it."""
    x, y, theta = (float(float_text(value * factor)) for value in start)
    return x, y, theta


def _cells_row(loop: FeedbackLoop, path: FollowedStart, units: Units) -> tuple[Entry, ...]:
    end, region = path.path.end, loop.region
    x, y, theta = pose_in_floats(end.state)
    first, last = ("" if region is None else float_text(region.value(p), 2) for p in (path.start, (x, y, theta)))
    # What rounding leaves of zero differs from machine to machine: it is shown as zero.
    place = [float_text(round(value, 12) + 0.0, 2) for value in _shown_pose((x, y, theta), units)]
    return place_text(_shown_pose(path.start, units)), first, float_text(end.t, 4), *place, last, str(end.reason)


def _cells_figure(subject: ArraySubject, loop: FeedbackLoop, path: FollowedStart) -> Figure:
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


# ---- the law that clause 4 certifies -------------------------------------------------------------


def law_section(subject: ArraySubject) -> Section:
    """The certified law; beside it, on the paper's own array, the law of its sec. 3.3."""
    if isinstance(subject.result.feedback, DrivenFeedback):
        return _driven_law(subject, subject.result.feedback)
    feedback = _law_of_cells(subject)
    words = paragraph(
        "Clause 4 certifies the {} law, in each cell with its nearest wheel `i` and second wheel `j`. The closed loops "
        "below follow it, and so does {}:",
        str(certified_law(feedback)),
        Code("nonsmooth simulate --feedback"),
    )
    papers = law_of_section_3_3() if is_paper_array(subject.scene) and subject.scene.check.length == 1 else []
    return Section("Feedback law", (words, *law_formulas(feedback), *region_blocks(feedback), *papers))


def _law_of_cells(subject: ArraySubject) -> FeedbackResult:
    feedback = subject.cells.feedback
    if not isinstance(feedback, FeedbackResult):
        raise TypeError(f"required rule nearest, received {subject.scene.contact.rule}")
    return feedback


def without_law(subject: ArraySubject) -> str:
    """Why the scene has no such law; empty where it has."""
    verdict = subject.result.feedback.holding.verdict
    return "" if verdict is Feedback.STABILIZABLE else f"the feedback clause says: {verdict}"


# ---- imposed twists ------------------------------------------------------------------------------

UNTIL = 16.0
DIRECTIONS = ((0.4, 0.8, 0.3), (-0.8, 0.4, -0.3), (-0.4, -0.8, 0.3), (0.8, -0.4, -0.3))  # of (c/l, theta)
WITHIN = 0.9  # of the certified region, in sqrt(V)
NEAR = 0.1  # of the square's half-width, in sqrt(V), where no region is known
FEW = 1  # of the directions where every motion is a minimization


def _driven_law(subject: ArraySubject, feedback: DrivenFeedback) -> Section:
    """The law of imposed twists: where it stands, from where it is certified, and its closed loop."""
    from nonsmooth.reports.laws.driven_loop import DrivenLoop  # rules with cells have another law

    loop = DrivenLoop(subject.scene.recentred(), feedback.holding)
    words = paragraph(
        "Clause 4 certifies a law that imposes one of three twists at a time; formula, twists and speeds are given "
        "there, and {} writes them as a program.",
        Code("nonsmooth check --law FILE.py"),
    )
    return Section("Feedback law", (words, *_driven_region(loop), *_loop_blocks(subject, loop)))


def _driven_region(loop: DrivenLoop) -> list[Block]:
    reach = loop.feedback.reach
    if loop.is_smooth:
        words = "The speeds impose these twists at `c*` only, and motions near them near `c*`: the law is certified "
        return [paragraph(words + "there, and how near is not known.")]
    if reach is None:
        return [paragraph("The law is certified near `c*`; how near is not known.")]
    square = lower_text(reach, 4)
    inside = Math(rf"V < {square}^2", f"V < {square}^2")
    words = "Certified region: while |x - x*| and |y - y*| are below {} the speeds impose exactly these twists and V "
    return [paragraph(words + "falls, so the body comes home from every start with {}.", square, inside)]


def _loop_blocks(subject: ArraySubject, loop: DrivenLoop) -> list[Block]:
    """Paths from some sides; or why there are none."""
    try:
        paths = [FollowedStart(start, loop.follow(start, UNTIL), UNTIL) for start in _driven_starts(loop)]
    except TrajectoryError as error:
        return [paragraph("The closed loop is not drawn: {}.", str(error))]
    words = "The closed loop with `k` = {}, a switched field of known motions:"
    if loop.is_smooth:
        words = "The closed loop with `k` = {}, from a start near `c*`: at every instant the motion minimizes D "
        words += "for the speeds of the law, proved by its forces. The path itself is computed in floats:"
    if loop.is_sampled:
        words = "The closed loop with `k` = {}, the law sampled and its speeds held in between, as a controller does; "
        words += "switches are not located:"
    said = paragraph(words, f"{GAIN:g}")
    units = loop.scene.units
    ends = _ends_table("V", "switches", [_driven_row(loop, path, units) for path in paths], units)
    return [said, ends, _driven_figure(subject, loop, paths[0])]


def _driven_starts(loop: DrivenLoop) -> list[Pose]:
    """One place for each direction, as a command line would hold it."""
    reach = loop.reach
    size = NEAR * loop.scene.check.half_width if reach is None else WITHIN * reach
    chosen = DIRECTIONS[:FEW] if loop.is_smooth else DIRECTIONS
    return [_start(loop, np.array(direction), size) for direction in chosen]


def _start(loop: DrivenLoop, direction: Floats, size: float) -> Pose:
    x, y, theta = size * direction / float(np.linalg.norm(direction))
    place = (float(float_text(float(x), 3)), float(float_text(float(y), 3)))
    return (*place, float(float_text(float(theta) / loop.length, 3)))


def _driven_row(loop: DrivenLoop, path: FollowedStart, units: Units) -> tuple[Entry, ...]:
    end = path.path.end
    place = [float_text(value, 2) for value in _shown_pose(end.state, units)]
    values = [float_text(loop.value(pose), 2) for pose in (path.start, end.state)]
    switches = "not located" if loop.is_sampled else str(len(path.path.events))
    return place_text(_shown_pose(path.start, units)), values[0], float_text(end.t, 4), *place, values[1], switches


def _driven_figure(subject: ArraySubject, loop: DrivenLoop, path: FollowedStart) -> Figure:
    begin = pose_text(loop.scene.units, path.start, 6) if loop.scene.units.in_degrees else place_text(path.start)
    picture = centre_picture(loop.scene, path.path, "certified law, measured from the checked point")
    return Figure(
        "closed-loop",
        prose("The closed loop of clause 4 from {}: x, y and `theta` over time, and the path.", begin),
        "Curves of x, y and theta over time under feedback, and the path.",
        subject.invocation.line("derive", "--only", "feedback", "-o", "closed-loop.html"),
        drawn(path_figure, picture),
    )
