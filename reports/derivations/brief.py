"""``derive --brief``: two pages about an array for somebody who decides and has no time for the derivation.

The answers with their accuracy, the array from above, where and when bodies end, what binds, the law to program if one
is certified, and what was not decided.  Everything is taken from the same check as the whole report.
"""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.proofs.answers.answer import DIGITS, UNDECIDED, Answer, Pose, at_least, at_most, of_length
from nonsmooth.proofs.findings.verdicts import Theorem4
from nonsmooth.reports.checks.answers import GOES, destinations_head, destinations_table, stated_answers
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Code,
    Document,
    Paragraph,
    Section,
    Text,
    decimal,
    number,
    point,
)
from nonsmooth.reports.output.prose import paragraph, with_formulas
from nonsmooth.reports.sections.answers import answers_table
from nonsmooth.reports.sections.opening import array_figure
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text


def brief_document(subject: ArraySubject) -> Document:
    """Two pages."""
    sections = (_answers(subject), _ends(subject), _binding(subject), _law(subject), _open(subject))
    return Document(f"In brief: {one_line(subject.scene.name)}", sections)


def _answers(subject: ArraySubject) -> Section:
    """What was asked of which array, the answers, and the picture."""
    scene, unit = subject.scene, of_length(subject.scene)
    intro = paragraph(
        f"A rigid body on {{}} driven wheels, put down within {{}}{unit} of {{}}; near is within {{}}{unit}.",
        str(len(scene.wheels)),
        number(scene.check.radius),
        point(scene.check.equilibrium),
        decimal(float_text(scene.accuracy, DIGITS)),
    )
    stated = stated_answers(subject.result, subject.answers)
    notes = Bullets(((f"Contact {stated.rule}.",), *((f"Note: {note}.",) for note in stated.notes)))
    return Section("Answers", (intro, answers_table(stated.answers), notes, array_figure(subject)))


def _ends(subject: ArraySubject) -> Section:
    """Where and when bodies end: what is proved of it, what is simulated, and where sampled starts go."""
    answers, scene, unit = subject.answers, subject.scene, of_length(subject.scene)
    second = " s"  # which every answer says of its times
    found = answers.answers[0].numbers
    start = "the point" if found.get("within") is None else f"anywhere within {at_least(found['within'])}{unit} of it"
    items = []
    if found.get("at") is not None and found.get("after") is not None:
        within = found.get("ends_within")
        place = f"about {place_text([float(entry) for entry in found['at']])}" if within != 0 else "at the point"
        near = f", within {at_most(within)}{unit} of the checked point" if within else ""
        after = f"after at most {at_most(found['after'])}{second}"
        items.append(f"Without inertia: {place}{near}, {after}, from {start} (proved).")
    elif found.get("seconds_per_distance") is not None:
        per = at_most(found["seconds_per_distance"])
        items.append(
            f"Without inertia: at the point, after at most {per}{second} for each 1{unit} of distance (proved)."
        )
    else:
        items.append("Without inertia: where and when is not proved.")
    settles = None if answers.inertia is None else answers.inertia.numbers.get("settles_after")
    if settles is not None:
        accuracy, after = (float_text(float(number), DIGITS) for number in (scene.accuracy, settles))
        when = f"after {after}{second}" if float(settles) else "already at the start"
        items.append(f"With inertia: within {accuracy}{unit} of where it ends {when} (simulated).")
    blocks: list[Block] = [Bullets(tuple((item,) for item in items))]
    if answers.destinations is not None:
        blocks.append(Paragraph((f"{destinations_head(scene, answers.destinations.starts).capitalize()}:",)))
        blocks.append(destinations_table(answers.destinations, GOES))
    return Section("Where and when bodies end", tuple(blocks))


def _binding(subject: ArraySubject) -> Section:
    """What would have to change before an answer does."""
    items = tuple((f"{said[0].upper()}{said[1:]}.",) for said in _bindings(subject))
    return Section("What binds", (Bullets(items),))


def _bindings(subject: ArraySubject) -> Iterator[str]:
    answers, unit = subject.answers, of_length(subject.scene)
    numbers = answers.answers[0].numbers
    ends, accuracy = numbers.get("ends_within"), float(subject.scene.accuracy)
    if ends == 0:
        yield "accuracy: without inertia bodies come to the point itself"
    elif ends is not None:
        share = float_text(100 * float(ends) / accuracy, 2)
        yield f"accuracy: without inertia bodies end within {share} % of what is allowed"
    if answers.inertia is not None:
        inertia = answers.inertia.numbers
        low, high = inertia.get("stable_to"), inertia.get("unstable_at")
        if low is not None:
            least = f"speed: a body with inertia is stable up to {at_least(low)} times these speeds"
            yield f"{least} (proved)" if high is None else f"{least}, and unstable at {at_most(high)} times (proved)"
        holds = inertia.get("massless_holds_to")
        if holds is not None:
            within = f"{float_text(accuracy, 3)}{unit}"
            only = "; at these, reckon with the simulated times" if holds < 1 else ""
            most = f"up to {holds:g} times these speeds (simulated){only}"
            yield f"speed: paths without inertia serve, within {within}, {most}"
    robust = answers.robust
    if robust is None:
        yield "tolerances: none are stated, so nothing is said of tables that are built a little differently"
        return
    if robust.numbers.get("binding") is None:
        yield f"tolerances: {robust.verdict}; which one binds is not known"
    yield from (
        f"tolerances: {fact.words}" for fact in robust.facts if fact.key in {"factor", "binding"} and fact.words
    )


def _law(subject: ArraySubject) -> Section:
    """The certified law, and the command that writes it."""
    pose = subject.answers.answers[2]
    if pose.verdict is not Pose.CAN_BE_HELD:
        return Section("Law", (Paragraph(("None is certified: ", *with_formulas(pose.sentence), ".")),))
    command = Code(subject.invocation.line("check", "--law", "law.st"))
    words = (
        "One is certified, see the answer on the pose. As a program for the controller (.st, .c or .py), whose header "
        "states units, rate, region and the largest speed of a rim: {}."
    )
    return Section("Law", (paragraph(words, command),))


def _open(subject: ArraySubject) -> Section:
    """What nobody may rely on."""
    open_answers = filter(_is_open, subject.answers.rows)
    items: list[Text] = [(f"{answer.name}: ", *with_formulas(answer.sentence), ".") for answer in open_answers]
    result = subject.result
    if result.verdict is not Theorem4.HYPOTHESES_NOT_MET:  # else its clauses are about something else
        for clause, found in result.clauses:
            if str(found.verdict) == UNDECIDED:
                items.append((f"Clause {clause.name}: ", *with_formulas(found.reason), "."))
    for other in subject.answers.others:
        asked = [answer.name for answer in other.answers if _is_open(answer)]
        if asked or not other.answers:
            items.append((f"Under rule {other.name}: {', '.join(asked) or other.why_not}.",))
    blocks: list[Block] = [Bullets(tuple(items))] if items else [paragraph("Nothing that was asked.")]
    sampled = [name for name, is_there in _sampled(subject) if is_there]
    if sampled:
        blocks.append(Paragraph((f"Simulated or sampled, which proves nothing: {', '.join(sampled)}.",)))
    report, check = (Code(subject.invocation.line(*words)) for words in (("derive", "-o", "report.html"), ("check",)))
    blocks.append(paragraph("Every step and its proof: {}. The answers alone: {}.", report, check))
    return Section("Not decided", tuple(blocks))


def _is_open(answer: Answer) -> bool:
    return str(answer.verdict) == UNDECIDED


def _sampled(subject: ArraySubject) -> Iterator[tuple[str, bool]]:
    yield "when and where bodies with inertia settle", subject.answers.inertia is not None
    yield "shares of the starts that end somewhere", subject.answers.destinations is not None
