"""The first section of the derivation report: what a builder asked, answered on one screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from nonsmooth.proofs.answers.answer import Answer, of_length
from nonsmooth.proofs.answers.answers import OtherRule
from nonsmooth.reports.checks.answers import THEOREM_IN_WORDS, StatedAnswers, destinations_table, stated_answers
from nonsmooth.reports.checks.equilibrium_headings import headings_table, notes, title
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Inline,
    Section,
    Table,
    Text,
    Tone,
    Verdict,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.reports.sections.opening import array_figure

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.destinations import Destinations
    from nonsmooth.proofs.answers.heading import HeadingsOfRest

_TONES = {0: Tone.GOOD, 1: Tone.BAD, 3: Tone.OPEN}


def answers_section(subject: ArraySubject) -> Section:
    """The three answers, the array, the rule, the other rules, where bodies go, and the theorem in one line."""
    scene, answered = subject.scene, subject.answers
    unit = of_length(scene)
    intro = paragraph(
        f"What a rigid body does that lies on {{}} driven wheels, near the point {{}} (within {{}}{unit}): first in "
        "words, then every step with its proof.",
        str(len(scene.wheels)),
        point(scene.check.equilibrium),
        number(scene.check.radius),
    )
    stated = stated_answers(subject.result, answered)
    said = answers_table(stated.answers)
    goes = _destinations(answered.destinations)
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


def _destinations(destinations: Destinations | None) -> list[Table]:
    """Where bodies go that start all over the square."""
    if destinations is None:
        return []
    header = ("a body that starts in the square", "sampled share", "near there", "heading")
    return [destinations_table(destinations, header)]


def _headings(headings: HeadingsOfRest | None) -> list[Block]:
    """At which headings a body with an outline rests."""
    if headings is None:
        return []
    said = [title(headings).removesuffix(":"), *notes(headings)]
    return [paragraph(" ".join(f"{one[0].upper()}{one[1:]}." for one in said)), *headings_table(headings)]
