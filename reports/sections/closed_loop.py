"""The closed loop in the derivation report: where three laws lead, and the path of one (the paper's Figure 5)."""

from __future__ import annotations

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.proofs.clauses.feedback import FeedbackResult
from nonsmooth.reports.choices import Law, Method
from nonsmooth.reports.document import Entry, Figure, Math, Section, table
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.sections.starts import start_text, typed_start, usual_start
from nonsmooth.reports.simulate import GAIN, Run, follow
from nonsmooth.reports.subject import Subject

HEADING = 0.3  # radian at the start: a heading to be brought back, small beside a turn
UNTIL = 8.0  # time: e^-8 of the start is below what a figure shows
_FIGURE_5 = {Law.CORRECTED: " (the paper's Figure 5)", Law.CASCADE: ""}
_LAWS = {
    Law.CORRECTED: prose("corrected: `u_j = -sgn(Delta) k theta`, `u_i = |u_j| + k |(x, y)|`"),
    Law.PRINTED: prose("as printed in sec. 3.3: `u_j = -k theta`, `u_i = |u_j| + k |(x, y)|`"),
    Law.GRADIENT: prose("gradient: `u_i = -k a`, `u_j = -k b`"),
    Law.CASCADE: prose("cascade: the law of clause 4"),
}


def closed_loop_section(subject: Subject) -> Section:
    """Where each law leads from one start, and the path of the paper's law, or of the cascade where it takes one."""
    proved = _proved(subject)
    paths = {law: _path(subject, law) for law in (Law.CORRECTED, Law.PRINTED, proved)}
    start = start_text(_start(subject))
    words = paragraph(
        "From (x, y, theta) = {} with `k` = {} each law was followed to t = {}:",
        Math(start, start),
        f"{GAIN:g}",
        f"{UNTIL:g}",
    )
    rows = [_row(law, path) for law, path in paths.items()]
    ends = table(("law", "last t", "x", "y", prose("`theta`"), "how it ended"), rows, (6, 1.5, 2, 2, 2, 3))
    shown = Law.CORRECTED if proved is Law.GRADIENT else proved
    return Section("With feedback", (words, ends, _figure(subject, shown, paths[shown])))


def _proved(subject: Subject) -> Law:
    """The law that the feedback clause certifies."""
    feedback = subject.cells.feedback
    by_cascade = isinstance(feedback, FeedbackResult) and feedback.cascade is not None
    return Law.CASCADE if by_cascade else Law.GRADIENT


def _start(subject: Subject) -> tuple[float, float, float]:
    x, y, _ = usual_start(subject.cells.partition)
    return x, y, HEADING


def _path(subject: Subject, law: Law) -> Trajectory:
    run = Run(_start(subject), UNTIL, Kinematics.EXACT, Method.EVENTS, law, width=1e-3)
    return follow(subject.cells.partition, run)


def _row(law: Law, path: Trajectory) -> tuple[Entry, ...]:
    x, y, theta = (f"{float(value):.3g}" for value in path.end.state)
    return _LAWS[law], f"{float(path.end.t):.4g}", x, y, theta, str(path.end.reason)


def _figure(subject: Subject, law: Law, path: Trajectory) -> Figure:
    partition = subject.cells.partition

    def draw() -> bytes:
        from nonsmooth.reports.figures.trajectory import trajectory_figure

        return trajectory_figure(partition, path, ".svg")

    options = (
        "--from",
        typed_start(_start(subject), subject.scene),
        "--until",
        f"{UNTIL:g}",
        "--feedback",
        *(() if law is Law.CORRECTED else ("--law", str(law))),
        "-o",
        "closed-loop.pdf",
    )
    return Figure(
        "closed-loop",
        prose(f"The closed loop under the {law} law{_FIGURE_5[law]}: x, y and `theta` over time, and the path."),
        "Curves of x, y and theta over time under feedback, and the path over the cells.",
        subject.invocation.line("simulate", *options),
        draw,
    )
