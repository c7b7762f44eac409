"""The first and the last sections of a plain system's report: verdict, formulas, phase portrait, solutions, works."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.system_facts import rewriting_words, system_facts
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.reports.document import (
    Block,
    Bullets,
    Code,
    Entry,
    Figure,
    Listing,
    Section,
    Tone,
    Verdict,
    decimal,
    point,
    table,
)
from nonsmooth.reports.facts import fact_rows
from nonsmooth.reports.paths import follow_system
from nonsmooth.reports.plain_systems.rewritten_text import tidied
from nonsmooth.reports.plain_systems.system_subject import SystemSubject
from nonsmooth.reports.prose import paragraph, with_formulas
from nonsmooth.reports.references import BACCIOTTI_CERAGIOLI, FILIPPOV, HOMOGENEITY, SHEVITZ_PADEN, how_to_cite
from nonsmooth.reports.simulate_options import SimulateOptions
from nonsmooth.symbolic.number_text import float_text, place_text
from nonsmooth.symbolic.scene_error import SceneError, one_line

TONES = {
    Translation.ASYMPTOTICALLY_STABLE: Tone.GOOD,
    Translation.STABLE: Tone.FAIR,
    Translation.UNSTABLE: Tone.BAD,
    Translation.UNDECIDED: Tone.OPEN,
}
STARTS = ((0.4, 0.8), (-0.8, 0.4), (-0.4, -0.8), (0.8, -0.4))  # of the half-width of the square, from its middle
UNTIL = 10.0  # last time of the solutions that are shown


def tone_of(result: StabilityResult) -> Tone:
    """The color that repeats what a verdict says."""
    return TONES[result.verdict]


def verdict_section(subject: SystemSubject) -> Section:
    """What is said about the checked point, and what that rests on."""
    result = subject.result
    said = paragraph(
        "The equilibrium is {}: {}.",
        Verdict(str(result.verdict), tone_of(result)),
        result.reason,
    )
    rows: list[list[Entry]] = [[name, with_formulas(words)] for name, words in fact_rows(system_facts(result))]
    return Section("The verdict", (said, table(("what", "found"), rows, (0.28, 0.72))))


def system_section(subject: SystemSubject) -> Section:
    """The formulas as they were written, and what is checked."""
    system = subject.system
    check = system.check
    where = paragraph(
        "Checked at {}, on the square of half-width {} about it. On switching surfaces the values of the formulas are "
        "ignored: solutions are those of Filippov's inclusion.",
        point(check.equilibrium),
        point([check.radius]) if len(str(check.radius)) > len("1000000") else Code(str(check.radius)),
    )
    blocks: list[Block] = []
    members = system.members
    if system.written:
        blocks += [_formulas(system.states, formulas) for formulas in system.written]
        blocks.append(paragraph("{} What is proved of the following is proved of that.", rewriting_words(system)))
    if system.others and system.has_one_field:
        blocks.append(paragraph("At every point the field is a mixture of these {}:", str(len(members))))
    elif system.others:
        blocks.append(paragraph("The field is any of these {}, or a mixture, at any time:", str(len(members))))
    shown = tidied if system.written else str  # formulas of the user stay as they are
    blocks += [_formulas(system.states, [shown(rhs.text) for rhs in member.rhs]) for member in members]
    return Section("The system", (*blocks, where))


def _formulas(states: Sequence[str], formulas: Sequence[str]) -> Listing:
    lines = (f"{name}' = {one_line(text)}" for name, text in zip(states, formulas, strict=True))
    return Listing("\n".join(lines))


def portrait_section(subject: SystemSubject) -> Section:
    """The phase portrait."""
    figure = Figure(
        "phase-portrait",
        (
            "Field lines, nullclines, borders, and level sets of the V that proves the verdict, over the checked "
            "square; measured from the checked point.",
        ),
        f"Phase portrait of {one_line(subject.system.name)}: {subject.result.verdict}.",
        subject.invocation.line("partition", "-o", "portrait.svg"),
        subject.portrait.content,
    )
    return Section("Phase portrait", (figure,))


def paths_section(subject: SystemSubject) -> Section:
    """Filippov solutions from four starts, followed from event to event."""
    system = subject.system
    radius = float(system.check.radius)
    middle = [float(value) for value in system.check.equilibrium]
    rows: list[list[Entry]] = []
    for shares in STARTS:
        start = tuple(m + share * radius for m, share in zip(middle, shares, strict=True))
        try:
            path = follow_system(system, SimulateOptions(start=start, until=UNTIL)).trajectory
        except (SceneError, TrajectoryError, ValueError) as error:
            rows.append([place_text(start), "", "", "", f"not followed: {error}"])
            continue
        rows.append(_path_row(start, path))
    words = paragraph("Filippov solutions from four starts, followed from event to event until t = {}:", f"{UNTIL:g}")
    header = ("start", "events", "ends at t", "in", "because")
    return Section("Solutions", (words, table(header, rows, (0.2, 0.1, 0.13, 0.25, 0.32))))


def _path_row(start: tuple[float, ...], path: Trajectory) -> list[Entry]:
    end = path.end
    unique = "" if path.unique else "; other solutions branch off"
    time = decimal(float_text(end.t))
    return [place_text(start), str(len(path.events)), time, place_text(end.state, 4), f"{end.reason}{unique}"]


def references_section(subject: SystemSubject) -> Section:
    """The works that this report rests on."""
    works = [FILIPPOV, SHEVITZ_PADEN, BACCIOTTI_CERAGIOLI]
    works += [HOMOGENEITY] if subject.result.by(Method.LEADING) is not None else []
    listed = Bullets(tuple((work.text,) for work in sorted(works, key=lambda work: work.authors.split()[-1])))
    return Section("References", (listed, paragraph("To cite this program:"), Listing(how_to_cite())))
