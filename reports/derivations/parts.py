"""The sections of the derivation report in their order, each with what it needs of the scene.

A section is built only where it applies and was asked for; the others of the same kind of scene are named with the
reason in the section on what was left out.  To add a section, write a function ``(subject) -> Section`` and one line in
:data:`PARTS`; of plain systems :data:`nonsmooth.reports.sections.plain_system.SYSTEM_PARTS`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.proofs.answers.answer import (
    DIGITS,
    UNDECIDED,
    WHY_BELOW,
    Answer,
    Pose,
    Position,
    at_least,
    at_most,
    reason_below,
)
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.findings import Theorem4
from nonsmooth.proofs.theorem4 import CellCheck
from nonsmooth.reports.checks.answers import GOES, destinations_head, destinations_table, stated_answers
from nonsmooth.reports.checks.continuum import continuum_section
from nonsmooth.reports.checks.subject import UNMISSED, ArraySubject, ReportPart, ReportSubject
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
    sentences,
)
from nonsmooth.reports.output.prose import paragraph, with_formulas
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import is_paper_array, sign_form_section, without_sign_form
from nonsmooth.reports.sections.contact import (
    cells_section,
    constraining_wheels,
    constraints_section,
    contact_states_section,
    ellipse_derivative_section,
    rules_section,
    situation_section,
    without_rules,
)
from nonsmooth.reports.sections.measurements import precision_section, stress_section, without_precision
from nonsmooth.reports.sections.opening import (
    answers_section,
    answers_table,
    array_figure,
    array_section,
    conventions_section,
    references_section,
    reproduction_section,
    verdict_section,
)
from nonsmooth.reports.sections.stability import equilibria_section, filippov_section, lyapunov_section, theorem_section
from nonsmooth.reports.sections.trajectories import law_section, trajectories_section, without_law
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_text import float_text, place_text


def subject_of(kind: SceneKind) -> type[ReportSubject]:
    """What reports about scenes of a kind are about: arrays, or plain systems, which alone load what they need."""
    if kind is SceneKind.SYSTEM:
        from nonsmooth.reports.checks.system_subject import SystemSubject

        return SystemSubject
    return ArraySubject


def parts_of(kind: SceneKind) -> tuple[ReportPart, ...]:
    """The sections that reports about scenes of a kind may have, in their order."""
    if kind is SceneKind.SYSTEM:
        from nonsmooth.reports.sections.plain_system import SYSTEM_PARTS

        return (*SYSTEM_PARTS, *LAST_PARTS)
    return (*PARTS, *LAST_PARTS)


def names_of(kind: SceneKind) -> tuple[str, ...]:
    """Their names."""
    return tuple(part.name for part in parts_of(kind))


def chosen_parts(only: Collection[str], without: Collection[str], kind: SceneKind = SceneKind.ARRAY) -> tuple[str, ...]:
    """Names of the sections to write: those of ``only``, or all, less those of ``without``.

    Raises:
        ValueError: for a name that is none, and where nothing is left.
    """
    names = names_of(kind)
    unknown = next((name for name in (*only, *without) if name not in names), None)
    if unknown is not None:
        raise ValueError(f"required names among {', '.join(names)}, received {unknown[:60]!r}")
    left = tuple(name for name in names if (not only or name in only) and name not in without)
    if not left:
        raise ValueError("without: required fewer than all sections that are asked for, received all of them")
    return left


def sections_of(subject: ReportSubject) -> Iterator[Section]:
    """The sections that the subject asks for and has, each announced before it is built."""
    for part in parts_of(subject.scene.kind):
        if part.name in subject.parts and not part.lacks(subject):
            subject.announce(f"section {part.name}")
            yield part.build(subject)


def lacking(subject: ReportSubject) -> list[tuple[str, str]]:
    """The sections that were asked for and are not about the scene, each with the reason."""
    asked = [part for part in parts_of(subject.scene.kind) if part.name in subject.parts]
    return [(part.name, why) for part in asked if (why := part.lacks(subject)) not in {"", UNMISSED}]


def _left_out(subject: ReportSubject) -> Section:
    """What was not computed, and which sections were not written, with the reasons."""
    parts, reasons = parts_of(subject.scene.kind), lacking(subject)
    reasons += [(part.name, "not asked for") for part in parts if part.name not in subject.parts]
    items: list[Text] = [(said,) for said in subject.left_out]
    items += [(f"Section {name}: {why}.",) for name, why in reasons]
    return Section("What was left out, and why", (Bullets(tuple(items)) if items else paragraph("Nothing."),))


# ---- what sections need --------------------------------------------------------------------------


def _no_cells(subject: ArraySubject) -> str:
    if _unknown_loads(subject):
        return _unknown_loads(subject)
    has_cells = isinstance(subject.result, CellCheck)
    return "" if has_cells else f"rule {subject.scene.contact.rule} has no cells with one twist each"


def _no_whole_partition(subject: ArraySubject) -> str:
    if isinstance(subject.result, CellCheck) and not subject.result.partition.complete:
        return "cells away from the point were not built, and no verdict needs them"
    return _no_cells(subject)


def _unknown_loads(subject: ArraySubject) -> str:
    """The motion away from the point is that of one load."""
    needs = rule_of(subject.scene).needs_loads and subject.scene.contact.loads_are_unknown
    return "the loads are not known, and this is about one load" if needs else ""


def _no_situation(subject: ArraySubject) -> str:
    return UNMISSED if isinstance(subject.result, CellCheck) else _unknown_loads(subject)


def _not_the_papers(subject: ArraySubject) -> str:
    its_array = is_paper_array(subject.scene) and subject.scene.contact.rule == "nearest"
    return "" if its_array else "the audit is about the paper's own array under rule nearest"


def _audit(subject: ArraySubject) -> Section:
    from nonsmooth.reports.papers.murphey_burdick_2001.audit import audit_section  # SymPy takes half a second

    return audit_section()


def _no_idealization(subject: ArraySubject) -> str:
    return "" if continuum_section(subject.result) else "no continuous field stands for the wheels"


def _continuum(subject: ArraySubject) -> Section:
    section = continuum_section(subject.result)
    if section is None:
        raise TypeError("required wheels that sample a field")
    return section


def _constraints(subject: ArraySubject) -> Section:
    result = subject.result
    wheels = constraining_wheels(result) if isinstance(result, CellCheck) else subject.scene.recentred().wheels
    return constraints_section(wheels)


def _situation(subject: ArraySubject) -> Section:
    equilibrium = subject.result.equilibrium
    if not isinstance(equilibrium, EllipseEquilibrium):
        raise TypeError("required a check under rule ellipse")
    return situation_section(equilibrium.point)


def _derivative(subject: ArraySubject) -> Section:
    translation = subject.result.translation
    if isinstance(translation, EllipseTranslation):
        return ellipse_derivative_section(translation)
    return lyapunov_section(subject)


# ---- the sections --------------------------------------------------------------------------------


PARTS: tuple[ReportPart, ...] = (
    ReportPart("answers", answers_section),
    ReportPart("verdict", lambda subject: verdict_section(subject.result)),
    ReportPart("array", array_section),
    ReportPart("conventions", lambda subject: conventions_section(subject.scene)),
    ReportPart("constraints", _constraints),
    ReportPart("contact-states", lambda subject: contact_states_section(subject.cells), _no_cells),
    ReportPart("cells", cells_section, _no_cells),
    ReportPart(
        "sgn-form", sign_form_section, lambda subject: _no_whole_partition(subject) or without_sign_form(subject)
    ),
    ReportPart("situation", _situation, _no_situation),
    ReportPart("filippov", lambda subject: filippov_section(subject.cells), _no_cells),
    ReportPart("equilibria", lambda subject: equilibria_section(subject.cells), _no_cells),
    ReportPart("derivative", _derivative, _unknown_loads),
    ReportPart("theorem", lambda subject: theorem_section(subject.result)),
    ReportPart("feedback", law_section, lambda subject: _unknown_loads(subject) or without_law(subject)),
    ReportPart("trajectories", trajectories_section, _no_whole_partition),
    ReportPart("rules", rules_section, lambda subject: _unknown_loads(subject) or without_rules(subject)),
    ReportPart("continuum", _continuum, _no_idealization),
    ReportPart(
        "precision", precision_section, lambda subject: _no_whole_partition(subject) or without_precision(subject)
    ),
    ReportPart("stress", stress_section, _unknown_loads),
    ReportPart("audit", _audit, _not_the_papers),
)
LAST_PARTS = (  # of every report
    ReportPart("left-out", _left_out),
    ReportPart("references", references_section),
    ReportPart("versions", reproduction_section),
)


# ---- the report in brief -------------------------------------------------------------------------
#
# ``derive --brief``: two pages about an array for somebody who decides and has no time for the derivation.
#
# The answers with their accuracy, the array from above, where and when bodies end, what binds, the law to program if
# one is certified, and what was not decided. Everything is taken from the same check as the whole report.


def brief_document(subject: ArraySubject) -> Document:
    """Two pages."""
    sections = (_answers(subject), _ends(subject), _binding(subject), _law(subject), _open(subject))
    return Document(f"In brief: {one_line(subject.scene.name)}", sections)


def _answers(subject: ArraySubject) -> Section:
    """What was asked of which array, the answers, and the picture."""
    scene, unit = subject.scene, subject.scene.units.after_length
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


NEITHER = "where and when is not proved"
WITHOUT_TIMES: dict[object, str] = {
    Position.COMES_HOME: "at the point, from {} (proved); when is not proved",
    Position.LEAVES: "bodies go away from the point (proved); where they end is not",
}


def _ends(subject: ArraySubject) -> Section:
    """Where and when bodies end: what is proved of it, what is simulated, and where sampled starts go."""
    answers, scene, unit = subject.answers, subject.scene, subject.scene.units.after_length
    second = " s"  # which every answer says of its times
    found = answers.answers[0].numbers
    start = "the point" if found.get("within") is None else f"anywhere within {at_least(found['within'])}{unit} of it"
    items = []
    if found.get("at") is not None and found.get("after") is not None:
        within = found.get("ends_within")
        place = f"about {place_text(found['at'])}" if within != 0 else "at the point"
        near = f", within {at_most(within)}{unit} of the checked point" if within else ""
        after = f"after at most {at_most(found['after'])}{second}"
        items.append(f"Without inertia: {place}{near}, {after}, from {start} (proved).")
    elif found.get("seconds_per_distance") is not None:
        per = at_most(found["seconds_per_distance"])
        items.append(
            f"Without inertia: at the point, after at most {per}{second} for each 1{unit} of distance (proved)."
        )
    else:
        whence = "close by" if found.get("within") is None else start
        items.append(f"Without inertia: {WITHOUT_TIMES.get(answers.answers[0].verdict, NEITHER).format(whence)}.")
    settles = None if answers.inertia is None else answers.inertia.numbers.get("settles_after")
    if settles is not None:
        accuracy, after = (float_text(float(number), DIGITS) for number in (scene.accuracy, settles))
        when = f"after {after}{second}" if float(settles) else "already at the start"
        items.append(f"With inertia: within {accuracy}{unit} of where it ends {when} (simulated).")
    blocks: list[Block] = [Bullets(tuple((item,) for item in items))]
    if answers.destinations is not None:
        blocks += sentences(f"{destinations_head(scene, answers.destinations.starts).capitalize()}:")
        blocks.append(destinations_table(answers.destinations, GOES))
    return Section("Where and when bodies end", tuple(blocks))


def _binding(subject: ArraySubject) -> Section:
    """What would have to change before an answer does."""
    items = tuple((f"{said[0].upper()}{said[1:]}.",) for said in _bindings(subject))
    return Section("What binds", (Bullets(items),))


def _bindings(subject: ArraySubject) -> Iterator[str]:
    answers, unit = subject.answers, subject.scene.units.after_length
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
    result = subject.result
    reasons: set[str] = set()
    items: list[Text] = []
    for answer in open_answers:
        reason = reason_below(answer, result.results)
        reasons.add(reason)
        items.append((f"{answer.name}: ", *with_formulas(answer.sentence.replace(WHY_BELOW, f": {reason}")), "."))
    if result.verdict is not Theorem4.HYPOTHESES_NOT_MET:  # else its clauses are about something else
        for clause, found in result.clauses:
            if str(found.verdict) == UNDECIDED and found.reason not in reasons:
                items.append((f"Clause {clause.name}: ", *with_formulas(found.reason), "."))
    loop = subject.answers.answers[2].numbers.get("loop")
    if loop is not None and loop["verdict"] == UNDECIDED:
        items.append((f"pose that is late and wrong as [feedback] says: {loop['reason']}.",))
    for other in subject.answers.others:
        asked = [answer.name for answer in other.answers if _is_open(answer)]
        if asked or not other.answers:
            items.append((f"Under rule {other.name}: {', '.join(asked) or other.why_not}.",))
    blocks: list[Block] = [Bullets(tuple(items))] if items else [paragraph("Nothing that was asked.")]
    sampled = [name for name, is_there in _sampled(subject) if is_there]
    if sampled:
        blocks += sentences(f"Simulated or sampled, which proves nothing: {', '.join(sampled)}.")
    report, check = (Code(subject.invocation.line(*words)) for words in (("derive", "-o", "report.html"), ("check",)))
    blocks.append(paragraph("Every step and its proof: {}. The answers alone: {}.", report, check))
    return Section("Not decided", tuple(blocks))


def _is_open(answer: Answer) -> bool:
    return str(answer.verdict) == UNDECIDED


def _sampled(subject: ArraySubject) -> Iterator[tuple[str, bool]]:
    yield "when and where bodies with inertia settle", subject.answers.inertia is not None
    yield "shares of the starts that end somewhere", subject.answers.destinations is not None
