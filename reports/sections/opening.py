"""The first sections of the derivation report: verdict, array, conventions."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable
from importlib.metadata import version
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.proofs.answers.answer import Answer
from nonsmooth.proofs.answers.answers import OtherRule
from nonsmooth.proofs.theorem4 import Check
from nonsmooth.reports.checks.answers import THEOREM_IN_WORDS, StatedAnswers, destinations_table, stated_answers
from nonsmooth.reports.checks.equilibrium_headings import headings_table, notes, title
from nonsmooth.reports.checks.subject import ArraySubject, ReportSubject, how_to_cite
from nonsmooth.reports.figures import wheels
from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.output.console import own_version
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Code,
    Entry,
    Figure,
    Inline,
    Listing,
    Math,
    Section,
    Table,
    Text,
    Tone,
    Verdict,
    number,
    point,
    sentences,
    table,
)
from nonsmooth.reports.output.prose import paragraph, prose, with_formulas
from nonsmooth.symbolic.mechanics.contact_states import askew_wheels
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.springs import EqualSprings
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number_field import angle_notes
from nonsmooth.symbolic.numbers.number_text import decimal_latex, float_text
from nonsmooth.symbolic.numbers.plane import in_floats

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.heading import HeadingsOfRest


ANSWERS = "answers"  # the section that shows the array first


def verdict_section(result: Check) -> Section:
    """The clauses in one table."""
    rows = [(clause.name, str(found.verdict), with_formulas(found.reason)) for clause, found in result.clauses]
    rows.append(("Theorem 4", str(result.verdict), with_formulas(result.reason)))
    return Section("Verdict", (table(("clause", "verdict", "because"), rows, (2, 3, 8)),))


def array_section(subject: ArraySubject) -> Section:
    """The wheels, drawn and listed."""
    scene = subject.scene
    length, speed = (f" [{unit}]" if unit else "" for unit in (scene.units.length, scene.units.speed))
    header: list[Entry] = ["wheel", prose("`p_i`{}", length), prose("`d_i`"), prose("`u_i`{}", speed)]
    header += [prose(f"`{name}`") for name in ("mu_R", "mu_S")]
    rows: list[tuple[Entry, ...]] = [
        (
            str(wheel.index) if str(wheel.index) == f"{wheel.index:d}" else f"{wheel.index:d}: {wheel.index}",
            point(wheel.position),
            _heading(wheel, scene.units),
            number(wheel.speed),
            number(wheel.friction.roll),
            number(wheel.friction.side),
        )
        for wheel in scene.wheels
    ]
    widths: tuple[float, ...] = (1.7, 4, 5, 2, 1.6, 1.6)
    askew = bool(askew_wheels(scene))
    if askew:
        header.append(prose("`a_i`"))
        rows = [(*row, point(wheel.unit_grip)) for row, wheel in zip(rows, scene.wheels, strict=True)]
        widths = (*widths, 5)
    if scene.contact.rule == MIXED:
        header.append("contact")
        rows = [(*row, scene.rule_of_wheel(wheel)) for row, wheel in zip(rows, scene.wheels, strict=True)]
        widths = (*widths, 2)
    intro = paragraph(
        "{} wheels: position `p_i`, rim direction `d_i`, surface speed `u_i` along the rim, friction "
        "coefficients `mu_R` along and `mu_S` across it.",
        str(len(scene.wheels)),
    )
    axes = "`mu_R` and `mu_S` act along and across the friction axis `a_i`, which is not the rim everywhere."
    notes: list[Block] = [paragraph(axes)] * askew
    notes += sentences(*(f"Note: {note}." for note in angle_notes(scene.field)))
    listing = table(header, rows, widths)
    picture = () if ANSWERS in subject.parts else (array_figure(subject),)  # the first section shows it
    return Section("The array", (intro, *notes, *picture, listing))


def _heading(wheel: Wheel, units: Units) -> Math:
    """The direction of a rim: its vector, or its angle where the scene's angles are read in degrees."""
    if not units.in_degrees:
        return point(wheel.unit_direction)
    x, y = in_floats(wheel.direction)
    angle = float_text(math.degrees(math.atan2(y, x)))
    return Math(rf"{decimal_latex(angle)}^\circ", f"{angle} deg")


def array_figure(subject: ArraySubject) -> Figure:
    """The wheels from above."""
    scene = subject.scene
    return Figure(
        "array",
        prose("The wheels with their rims and surface speeds, and the square of centres of mass that is checked."),
        f"Plan of the {len(scene.wheels)} wheels with rims and speeds around the checked square.",
        subject.invocation.line("partition", "--show", "array", "-o", "array.pdf"),
        drawn(wheels.array_figure, scene),
    )


def conventions_section(scene: Scene) -> Section:
    """Frames, coordinates, and what is checked."""
    centre, radius = point(scene.check.equilibrium), number(scene.check.radius)
    square = Math(
        rf"\lvert x - x^* \rvert, \lvert y - y^* \rvert \le {radius.latex}", f"|x - x*|, |y - y*| <= {radius.plain}"
    )
    units, stated = scene.units, "lengths and times in the units of the scene"
    if units.length:
        stated = f"lengths in {units.length}, times in {units.time}, angles in {units.angle}"
    items = [
        prose(f"World frame; {stated}; `J = [[0, -1], [1, 0]]` turns by a quarter counterclockwise."),
        prose("Reference point of the body: its centre of mass `c = (x, y)`; orientation `theta`."),
        prose(
            "Spatial twist `xi = (v, omega)`: the body point now at p moves with `v + omega J p`. Pose rate: "
            "`c' = v + omega J c, theta' = omega`."
        ),
        prose(
            "Contact rule: {}. Checked point {}, checked square {}.",
            str(scene.contact.rule),
            Math(f"c^* = {centre.latex}", f"c* = {centre.plain}"),
            square,
        ),
        prose("R1 is the roll row of wheel 1, S1 its side row."),
    ]
    if rule_of(scene).needs_loads:
        items.append(prose("Normal forces: {}.", (scene.contact.loads or EqualSprings()).words))
    if any(scene.check.equilibrium):
        items.append(
            prose(
                "From the constraints on, positions, twists and figures are measured from the checked point; "
                "the commands beneath the figures draw them in the coordinates of the scene."
            )
        )
    return Section("Conventions", (Bullets(tuple(items)),))


# ---- the last section ----------------------------------------------------------------------------


LIBRARIES = ("python-flint", "sympy", "numpy", "scipy", "matplotlib")


def references_section(subject: ReportSubject) -> Section:
    """The works that this report rests on, and how to cite the program."""
    works = sorted(subject.works, key=lambda work: work.authors.split()[-1])
    listed = Bullets(tuple((work.text,) for work in works))
    return Section("References", (listed, paragraph("To cite this program:"), Listing(how_to_cite())))


def reproduction_section(subject: ReportSubject) -> Section:
    """Versions and the command that writes this report."""
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    words = "nonsmooth {}, Python {}, {}. This report is written by {}."
    command = Code(subject.invocation.derive)
    versions = paragraph(words, own_version(), platform.python_version(), libraries, command)
    return Section("Versions and reproduction", (versions,))


# ---- the answers ---------------------------------------------------------------------------------
#
# The first section of the derivation report: what a builder asked, answered on one screen.


_TONES = {0: Tone.GOOD, 1: Tone.BAD, 3: Tone.OPEN}


def answers_section(subject: ArraySubject) -> Section:
    """The three answers, the array, the rule, the other rules, where bodies go, and the theorem in one line."""
    scene, answered = subject.scene, subject.answers
    unit = scene.units.after_length
    intro = paragraph(
        f"What a rigid body does that lies on {{}} driven wheels, near the point {{}} (within {{}}{unit}): first in "
        "words, then every step with its proof.",
        str(len(scene.wheels)),
        point(scene.check.equilibrium),
        number(scene.check.radius),
    )
    stated = stated_answers(subject.result, answered)
    said = answers_table(stated.answers)
    header = ("a body that starts in the square", "sampled share", "near there", "heading")
    goes = [] if answered.destinations is None else [destinations_table(answered.destinations, header)]
    headings = _headings(answered.headings)
    return Section("Answers", (intro, said, _items(subject, stated), *goes, *headings, array_figure(subject)))


def answers_table(answers: Iterable[Answer]) -> Table:
    """Every question with its answer and its sentence."""
    rows = [(answer.name, _verdict(answer), answer.sentence) for answer in answers]
    return table(("question", "answer", "how far, how fast, on what conditions"), rows, (2, 3, 8))


def _items(subject: ArraySubject, stated: StatedAnswers) -> Bullets:
    """The contact rule in a sentence, what the other rules say, and the theorem."""
    verdict = subject.result.verdict
    return Bullets(
        (
            (f"Contact {stated.rule}.",),
            *((f"Note: {note}.",) for note in stated.notes),
            (f"Contact: {stated.contact}.",),
            *(_other_rule(other) for other in subject.answers.others),
            *(("; ".join(lines) + ".",) for lines in stated.contradictions),
            (THEOREM_IN_WORDS, Verdict(str(verdict), _TONES[verdict.exit_status]), "."),
        )
    )


def _other_rule(other: OtherRule) -> Text:
    """What one of the other rules says."""
    if not other.answers:
        return (f"Under rule {other.name} there is no answer: {other.why_not}.",)
    parts: list[Inline] = [f"Under rule {other.name}: "]
    for answer in other.answers:
        parts += [f"{answer.name} ", _verdict(answer), ", "]
    return (*parts[:-1], ".")


def _verdict(answer: Answer) -> Verdict:
    return Verdict(str(answer.verdict), Tone(answer.tone))


def _headings(headings: HeadingsOfRest | None) -> list[Block]:
    """At which headings a body with an outline rests."""
    if headings is None:
        return []
    said = [title(headings).removesuffix(":"), *notes(headings)]
    return [paragraph(" ".join(f"{one[0].upper()}{one[1:]}." for one in said)), *headings_table(headings)]
