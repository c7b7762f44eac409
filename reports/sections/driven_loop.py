"""The closed loop under the rules ``box`` and ``ellipse`` in the derivation report, as far as it can be followed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.reports.document import Block, Code, Entry, Figure, Math, Section, table
from nonsmooth.reports.driven_loop import DrivenLoop
from nonsmooth.reports.feedback_loop import GAIN
from nonsmooth.reports.figures.path import centre_picture, path_figure
from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.sections.starts import Start, start_text
from nonsmooth.reports.subject import ArraySubject
from nonsmooth.symbolic.number_text import float_text, lower_text

UNTIL = 16.0
DIRECTIONS = ((0.4, 0.8, 0.3), (-0.8, 0.4, -0.3), (-0.4, -0.8, 0.3), (0.8, -0.4, -0.3))  # of (c/l, theta)
WITHIN = 0.9  # of the certified region, in sqrt(V)
NEAR = 0.1  # of the square's half-width, in sqrt(V), where no region is known
FEW = 1  # of the directions where every motion is a minimization


@dataclass(frozen=True)
class _Path:
    start: Start
    path: Trajectory


def driven_law_section(subject: ArraySubject) -> Section:
    """The law of imposed twists: where it stands, from where it is certified, and its closed loop."""
    feedback = subject.result.feedback
    if not isinstance(feedback, DrivenFeedback):
        raise TypeError(f"required a law of imposed twists, received rule {subject.scene.contact.rule}")
    loop = DrivenLoop(subject.scene.recentred(), feedback.holding)
    words = paragraph(
        "Clause 4 certifies a law that imposes one of three twists at a time; formula, twists and speeds are given "
        "there, and {} writes them as a program.",
        Code("nonsmooth check --law FILE.py"),
    )
    return Section("Feedback law", (words, *_region_blocks(loop), *_loop_blocks(subject, loop)))


def _region_blocks(loop: DrivenLoop) -> list[Block]:
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
        paths = [_Path(start, loop.follow(start, UNTIL)) for start in _starts(loop)]
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
    return [said, _ends(loop, paths), _figure(subject, loop, paths[0])]


def _starts(loop: DrivenLoop) -> list[Start]:
    """One place for each direction, as a command line would hold it."""
    reach = loop.reach
    size = NEAR * float(loop.scene.check.radius) if reach is None else WITHIN * reach
    chosen = DIRECTIONS[:FEW] if loop.is_smooth else DIRECTIONS
    return [_start(loop, np.array(direction), size) for direction in chosen]


def _start(loop: DrivenLoop, direction: Vector, size: float) -> Start:
    x, y, theta = size * direction / float(np.linalg.norm(direction))
    place = (float(float_text(float(x), 3)), float(float_text(float(y), 3)))
    return (*place, float(float_text(float(theta) / loop.length, 3)))


def _ends(loop: DrivenLoop, paths: list[_Path]) -> Block:
    header = ("start (x, y, theta)", "V there", "last t", "x", "y", prose("`theta`"), "V", "switches")
    return table(header, [_row(loop, path) for path in paths], (2.8, 1.7, 1.5, 1.7, 1.7, 1.7, 1.7, 2.2))


def _row(loop: DrivenLoop, path: _Path) -> tuple[Entry, ...]:
    end = path.path.end
    place = [float_text(float(value), 2) for value in end.state]
    values = [float_text(loop.value(pose), 2) for pose in (path.start, end.state)]
    switches = "not located" if loop.is_sampled else str(len(path.path.events))
    return start_text(path.start), values[0], float_text(end.t, 4), *place, values[1], switches


def _figure(subject: ArraySubject, loop: DrivenLoop, path: _Path) -> Figure:
    picture = centre_picture(loop.scene, path.path, "certified law, measured from the checked point")
    return Figure(
        "closed-loop",
        prose("The closed loop of clause 4 from {}: x, y and `theta` over time, and the path.", start_text(path.start)),
        "Curves of x, y and theta over time under feedback, and the path.",
        subject.invocation.line("derive", "--only", "feedback", "-o", "closed-loop.html"),
        drawn(path_figure, picture),
    )
