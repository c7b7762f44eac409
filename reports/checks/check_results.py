"""What a check of arrays has found: of one array, of a body that tips, under every contact rule, of many scenes."""

from __future__ import annotations

import shlex
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeAlias

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.answers.answers import THEOREM, Answers, exit_status, full_answers
from nonsmooth.proofs.answers.contradictions import (
    contradictions_of_certificate,
    contradictions_of_rules,
    reconciled,
    rests_under,
)
from nonsmooth.proofs.findings import Contradiction, Record, Theorem4, said
from nonsmooth.proofs.theorem4 import Check
from nonsmooth.reports.checks.answers import (
    CHECK_SCHEMA,
    answer_lines,
    answers_record,
    answers_view,
    check_record,
    checks_record,
    tipped_view,
)
from nonsmooth.reports.output.progress import progress, steps
from nonsmooth.reports.output.terminal import (
    MORE,
    answers_table,
    check_view,
    clauses_view,
    header_table,
    headline,
    legend,
    notes_lines,
    verdict_text,
)
from nonsmooth.reports.studies.result import DataTable, Result, counted_words, short_lines
from nonsmooth.symbolic.mechanics.contact_set import ContactSet, contact_set, tipped, wheels_text
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import exact_place, numbers_text
from nonsmooth.symbolic.numbers.plane import XY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.analysis.bodies.continuum import Prediction
    from nonsmooth.proofs.answers.array_basin import ArrayBasin, NoBasin
    from nonsmooth.proofs.answers.destinations import Destinations, RestPoint
    from nonsmooth.proofs.answers.failures import Failure
    from nonsmooth.proofs.answers.heading import HeadingsOfRest
    from nonsmooth.reports.laws.law_languages import LawResult
    from nonsmooth.reports.output.document import Block
    from nonsmooth.symbolic.mechanics.contact_set import TipsError
    from nonsmooth.symbolic.mechanics.scene import Scene

QUESTION = ("question", "verdict", "why")
WORST_FIRST = (2, 1, 3)  # exit statuses: refused, does not hold, undecided
COLUMNS = ("scene", "rule", "position", "heading", "pose", "Theorem 4")  # of many scenes
NONE = "-"  # the contact rule of a plain system, and what is not asked of it
REFUSED = "refused"
NOT_ASKED = "not asked: the body tips"

Line: TypeAlias = tuple[str, str, str]  # question, verdict, why


class ArrayAnswers(Result):
    """What there is to say of one array: answers first."""

    scene: Scene

    @property
    @abstractmethod
    def _answers(self) -> Mapping[str, Answer]:
        """The answers by their names."""

    @property
    @abstractmethod
    def theorem4(self) -> str:
        """The verdict of Theorem 4: holds, fails, hypotheses not met or undecided."""

    @property
    @abstractmethod
    def reason(self) -> str:
        """Why, in one sentence."""

    @property
    def position(self) -> Answer:
        """Where a body goes that starts near the point."""
        return self._answers["position"]

    @property
    def heading(self) -> Answer:
        """What its heading does."""
        return self._answers["heading"]

    @property
    def pose(self) -> Answer:
        """Whether feedback can hold both."""
        return self._answers["pose"]

    def lines(self) -> Iterator[Line]:
        """Question, verdict and why of everything that is said."""
        yield from answer_lines(self._answers.values())

    def table(self) -> DataTable:
        """One line for each question."""
        return DataTable(QUESTION, list(self.lines()))

    def blocks(self) -> Sequence[Block]:
        """The lines as a table."""
        from nonsmooth.reports.output.document import sentences, table

        return [*sentences(self.headline()), table(QUESTION, self.lines(), (1.0, 1.0, 4.0))]

    def draw(self, ax: Axes) -> None:
        """The wheels."""
        from nonsmooth.reports.figures.wheels import draw_array

        draw_array(ax, self.scene)

    def headline(self) -> str:
        """What is checked."""
        return f"{self.scene.name}: {wheels_text(self.scene)}, rule {self.scene.contact.rule}"

    def summary(self) -> str:
        """The answers."""
        return ", ".join(f"{name} {answer.verdict}" for name, answer in self._answers.items())

    def _said(self) -> Iterator[tuple[str, str]]:
        for answer in self._answers.values():
            yield answer.name, repr(answer)

    def __repr__(self) -> str:
        return short_lines(self.headline(), self._said())


@dataclass(frozen=True, repr=False)
class CheckResult(ArrayAnswers):
    """What a check of an array found.

    What it says has been compared (:mod:`nonsmooth.proofs.answers.contradictions`): what contradicts something else is
    undecided.

    Attributes:
        decided: every clause as it was decided.
        ask_others: whether the answers say what the other contact rules say.
        around: whether headings of rest are looked for around the checked point too.
        rest_points: with ``at="auto"`` the places of rest among which the point was chosen, the best first.
        required: the answers that exit status 0 asks for.
        continuum: what a continuous field would do, where that was asked.
        failures: the answers with any one wheel failed, where these were asked.
        shows_evidence: whether a terminal shows why, too.
        region: from where bodies come, as triangles, or why there are none, where these were asked.
        elsewhere: contradictions with what is said in other results.
    """

    decided: Check
    ask_others: bool = True
    around: bool = False
    rest_points: tuple[RestPoint, ...] | None = None
    required: tuple[str, ...] = (THEOREM,)
    continuum: tuple[Prediction, ...] | None = None
    failures: tuple[Failure, ...] | None = None
    shows_evidence: bool = False
    region: ArrayBasin | NoBasin | None = None
    elsewhere: tuple[Contradiction, ...] = ()

    @cached_property
    def _brief(self) -> tuple[Check, Answers]:
        """The answers to the questions alone, compared with a few samples."""
        return reconciled(self.decided, None, *self.elsewhere)

    @cached_property
    def _full(self) -> tuple[Check, Answers]:
        """Everything, compared with each other."""
        asked = {"ask_others": self.ask_others, "around": self.around}
        with steps("answers"):
            answered = full_answers(self.decided, **asked, rest_points=self.rest_points)
            return reconciled(self.decided, answered, *self.elsewhere)

    @property
    def _known(self) -> tuple[Check, Answers]:
        """Everything, once somebody has asked for what takes longer."""
        return self._full if "_full" in vars(self) else self._brief

    @property
    def scene(self) -> Scene:  # type: ignore[override]  # it is that of the evidence
        """The array, of the wheels that carry the body."""
        return self.decided.scene

    @property
    def evidence(self) -> Check:
        """Every clause with its evidence; ``evidence.check()`` asks the stand-alone checker."""
        return self._known[0]

    @property
    def contradictions(self) -> tuple[Contradiction, ...]:
        """Statements about the array that contradict each other, and on which nobody may rely."""
        return self.evidence.contradictions

    @property
    def _answers(self) -> Mapping[str, Answer]:
        return {answer.name: answer for answer in self._known[1].answers}

    @property
    def answers(self) -> Answers:
        """The answers with what takes a little longer: where bodies go, and what the other rules say."""
        return self._full[1]

    @property
    def tolerances(self) -> Answer | None:
        """What holds for every array within the tolerances; None for a scene that states none."""
        return self.answers.robust

    @property
    def theorem4(self) -> str:
        """See :class:`ArrayAnswers`."""
        return str(self.evidence.verdict)

    @property
    def reason(self) -> str:
        """See :class:`ArrayAnswers`."""
        return self.evidence.reason

    @property
    def at(self) -> XY:
        """The point that was checked."""
        return self.scene.check.place

    @property
    def contact_set(self) -> ContactSet:
        """The wheels that carry the body at the checked pose, and how far it may move before that changes."""
        return contact_set(self.scene)

    @property
    def destinations(self) -> Destinations | None:
        """Where bodies go that start all over the square; None where all come home."""
        return self.answers.destinations

    @property
    def equilibrium_headings(self) -> HeadingsOfRest | None:
        """At which headings a body with an outline rests, and which of them attract; None where none matters."""
        return self.answers.headings

    def law(self, name: str = "certified") -> LawResult:
        """The certified feedback law: a function of the pose, a table of regions and speeds, programs.

        Args:
            name: under rule ``nearest`` also of another law, certified or not: printed, corrected, gradient, cascade.

        Raises:
            NoLawError: where the feedback clause certifies none, or the array has none of this name.
            ValueError: for another name.
        """
        from nonsmooth.reports.laws.law_languages import law_of
        from nonsmooth.reports.output.study_options import LawName, read_keyword

        return law_of(self.evidence, read_keyword("name", LawName, name))

    def with_triangles(self, search: str) -> Self:
        """The same with the region as triangles, or why there are none: see ``nonsmooth check --region``.

        Args:
            search: ``fast`` or ``best``.
        """
        from nonsmooth.proofs.answers.array_basin import find_array_basin

        with progress("region") as report:
            found = find_array_basin(self.scene, search, lambda what, done, total: report(done, total, what))
        return replace(self, region=found)

    @property
    def basin(self) -> ArrayBasin | None:
        """The region as triangles; None where it was not asked for, and where none are certified."""
        from nonsmooth.proofs.answers.array_basin import ArrayBasin

        return self.region if isinstance(self.region, ArrayBasin) else None

    def draw(self, ax: Axes) -> None:
        """The wheels, and the certified triangles among the sampled starts that come."""
        super().draw(ax)
        if self.basin is not None:
            from nonsmooth.reports.figures.cells import draw_array_basin

            draw_array_basin(ax, self.basin, self.at)

    def certificate(self) -> Record:
        """What ``--certificate`` writes; see :meth:`Result.certificate`."""
        from nonsmooth.proofs.kernel.subject import NoCertificateError

        compared, certificate = self.certified()
        if compared.contradictions:
            raise NoCertificateError("certificate: required a check that does not contradict itself, received one")
        return certificate

    def certified(self) -> tuple[Self, Record]:
        """The result compared with its certificate, with which it may contradict itself, and the certificate.

        Raises:
            NoCertificateError: where there is none.
            UnverifiedError: where the stand-alone checker rejects it.
        """
        from nonsmooth.proofs.certificate import build_certificate

        _ = self.answers  # all of them: they may contradict what is certified
        further = [] if self.basin is None else [(self.basin.claim, self.basin.entry)]
        certificate = build_certificate(self.evidence, further)
        found = tuple(contradictions_of_certificate(certificate, self.evidence))
        compared = replace(self, elsewhere=(*self.elsewhere, *found)) if found else self
        _ = compared.answers
        return compared, certificate

    @property
    def exit_status(self) -> int:
        """0 if all that was required is as hoped for, 1 if one is not, else 3."""
        check, answered = self._full
        return exit_status(check, self.required, answered)

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth check --json``."""
        check, answered = self._full
        continuum = None
        if self.continuum is not None:
            from nonsmooth.reports.checks.continuum import continuum_record

            continuum = continuum_record(self.continuum, check)
        region = {} if self.basin is None else {"basin": self.basin.record(self.scene.units.length)}
        return check_record(check, answered, continuum, self.failures) | region

    def lines(self) -> Iterator[Line]:
        """The answers, every clause, the theorem, and what contradicts itself."""
        yield from super().lines()
        if self.region is not None:
            yield "region", *region_words(self)
        for clause, found in self.evidence.clauses:
            yield clause.name, str(found.verdict), found.reason
        yield "Theorem 4", self.theorem4, self.reason
        for one in self.contradictions:
            yield "contradiction", "undecided", one.text

    def views(self) -> Sequence[RenderableType]:
        """The answers, then why."""
        return check_views([self])

    def headline(self) -> str:
        """What is checked, and where."""
        return f"{super().headline()}, at {exact_place(self.scene.check.equilibrium)}"

    def _said(self) -> Iterator[tuple[str, str]]:
        yield from super()._said()
        yield "Theorem 4", f"{self.theorem4}: {self.reason}"
        for one in self.contradictions:
            yield "contradiction", one.text


@dataclass(frozen=True, repr=False)
class TippedResult(ArrayAnswers):
    """The answer to a check of a body that does not stand at the checked pose: that it tips; there is no verdict.

    Attributes:
        scene: the array, with the body.
        tipping: which wheels are under the body, and why it does not stand on them.
        is_drawn: whether only the picture was asked for.
    """

    scene: Scene
    tipping: TipsError
    is_drawn: bool = False

    @property
    def _answers(self) -> Mapping[str, Answer]:
        tips = Answer("position", Position.TIPS, (said(f"a body with {self.tipping.why}"),))
        heading = Answer("heading", Heading.UNDECIDED, (said(NOT_ASKED),))
        return {"position": tips, "heading": heading, "pose": Answer("pose", Pose.UNDECIDED, (said(NOT_ASKED),))}

    @property
    def theorem4(self) -> str:
        """Its hypotheses are not met."""
        return str(Theorem4.HYPOTHESES_NOT_MET)

    @property
    def reason(self) -> str:
        """Why it does not stand."""
        return self.tipping.why

    @property
    def exit_status(self) -> int:
        """1, whatever is required: the body is not where it should be."""
        return int(not self.is_drawn)

    def draw(self, ax: Axes) -> None:
        """The wheels under the body and those that it misses, its outline, and its centre of mass."""
        from nonsmooth.reports.figures.wheels import draw_array

        draw_array(ax, tipped(self.scene, self.tipping))

    def figure(self) -> Figure:
        """The same with a legend, and why it tips."""
        from nonsmooth.reports.figures.wheels import array_figure

        return array_figure(tipped(self.scene, self.tipping), self.tipping.why)

    def summary(self) -> str:
        """Why it tips."""
        return self.tipping.why

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth check --json``."""
        return {
            "schema": CHECK_SCHEMA,
            "scene": self.scene.name,
            "wheels": len(self.scene.wheels),
            "rule": self.scene.contact.rule,
            "contact_set": {"wheels": list(self.tipping.carrying), "margin": None},
            "answers": answers_record([*self._answers.values()], None),
            "theorem4": {"verdict": self.theorem4, "reason": self.reason},
        }

    def views(self) -> Sequence[RenderableType]:
        """The answers."""
        drawn = Text(f"nonsmooth partition {shlex.quote(self.scene.origin)} --show array -o array.png draws it")
        return [tipped_view(self.scene, [*self._answers.values()]), drawn, *notes_lines(self.scene.field)]


# ---- under every contact rule --------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class RulesResult(Result):
    """Checks of one array under several contact rules, compared with each other."""

    results: tuple[CheckResult, ...]

    @property
    def exit_status(self) -> int:
        """That of the worst."""
        return worst({result.exit_status for result in self.results})

    def facts(self) -> Record:
        """One record for each rule."""
        return checks_record(result.facts() for result in self.results)

    def table(self) -> DataTable:
        """One line for each rule and question."""
        lines = [(str(result.scene.contact.rule), *line) for result in self.results for line in result.lines()]
        return DataTable(("rule", *QUESTION), lines)

    def blocks(self) -> Sequence[Block]:
        """One result below the other."""
        return [block for result in self.results for block in result.blocks()]

    def views(self) -> Sequence[RenderableType]:
        """The same for a terminal."""
        return check_views(self.results)

    def summary(self) -> str:
        """How many rules."""
        return f"{len(self.results)} contact rules"


def compared(results: Sequence[CheckResult]) -> RulesResult:
    """Checks of one array under several contact rules with all their answers, compared with each other."""
    for result in results:
        _ = result.answers
    asked = {str(result.scene.contact.rule): rests_under(result.evidence) for result in results}
    found = tuple(contradictions_of_rules(results[0].scene, asked))
    words = {word for one in found for word in one.between.split()}
    pairs = zip(asked, results, strict=True)
    renewed = [replace(result, elsewhere=found) if rule in words else result for rule, result in pairs]
    for result in renewed:
        _ = result.answers
    return RulesResult(tuple(renewed))


def region_words(result: CheckResult) -> tuple[str, str]:
    """Whether a region of an array is certified by triangles, and which, or why none."""
    from nonsmooth.proofs.answers.array_basin import NoBasin

    if isinstance(result.region, NoBasin):
        return "no triangles", f"{result.region.why}: what the position says stands"
    return "certified", "" if result.basin is None else result.basin.words(result.scene.units.length)


def check_views(results: Sequence[CheckResult]) -> Sequence[RenderableType]:
    """Answers and verdicts of one array under one rule or several, and why where that was asked."""
    views: list[RenderableType] = []
    evidence, continuum = results[0].shows_evidence, results[0].continuum
    for result in results:
        answered = result.answers  # before the verdicts, which may contradict them
        check = result.evidence
        answers = [headline(check), answers_view(check, answered)]
        if evidence:
            views += [Group(*answers), check_view(check)]
        else:
            views.append(Group(*answers, clauses_view(check, answered.answers)))
        if result.region is not None:
            verdict, why = region_words(result)
            views.append(answers_table([("region", verdict, why)]))
        if result.failures is not None:
            views.append(failures_view(result, result.failures))
    if continuum is not None:
        from nonsmooth.reports.checks.continuum import continuum_view

        views.append(continuum_view(continuum, [result.evidence for result in results]))
    return [*views, *notes_lines(results[0].scene.field), legend() if evidence else Text(MORE, "dim")]


# ---- many scenes ---------------------------------------------------------------------------------


class SummaryLine(NamedTuple):
    """One scene under one rule.

    Attributes:
        origin: file or built-in name.
        rule: the contact rule; a dash for a plain system.
        answers: of position, heading and pose; of a plain system its stability.
        theorem: the verdict of Theorem 4; a dash where there is none.
        status: the exit status that the scene alone would give.
        record: JSON.
        refusal: why the scene was refused; empty where it was not.
    """

    origin: str
    rule: str
    answers: tuple[str, ...]
    theorem: str
    status: int
    record: Record
    refusal: str = ""


@dataclass(frozen=True, repr=False)
class SummaryResult(Result):
    """Many scenes: one line each, all records, and the worst exit status.

    Attributes:
        checked: checks all scenes, with records or without.
    """

    checked: Callable[..., tuple[SummaryLine, ...]]

    @cached_property
    def _brief(self) -> tuple[SummaryLine, ...]:
        return self.checked(records=False)

    @cached_property
    def _full(self) -> tuple[SummaryLine, ...]:
        return self.checked(records=True)

    @property
    def lines(self) -> tuple[SummaryLine, ...]:
        """One for each scene and rule."""
        return self._full if "_full" in vars(self) else self._brief

    @property
    def exit_status(self) -> int:
        """Refused, else not holding, else undecided, else 0."""
        return worst({line.status for line in self.lines})

    def facts(self) -> Record:
        """All records."""
        return checks_record(line.record for line in self._full)

    def table(self) -> DataTable:
        """One line for each scene and rule."""
        lines = []
        for line in self.lines:
            unsaid = (NONE,) * (len(COLUMNS) - 3 - len(line.answers))
            lines.append((one_line(line.origin), line.rule, *line.answers, *unsaid, line.theorem))
        return DataTable(COLUMNS, lines)

    def blocks(self) -> Sequence[Block]:
        """The table, why scenes were refused, and how many there are of each verdict."""
        from nonsmooth.reports.output.document import sentences, table

        refused = [line for line in self.lines if line.refusal]
        reasons = [f"refused: {one_line(line.origin)}, rule {line.rule}: {line.refusal}" for line in refused]
        rows = table(*self.table(), (3.0, 1.0, 1.0, 1.0, 1.0, 1.0))
        return [rows, *sentences(*reasons, self.summary())]

    def summary(self) -> str:
        """``position: 5 comes home, 2 leaves; Theorem 4: 5 holds, 2 fails; plain systems: 1 stable``."""
        arrays = [line for line in self.lines if line.rule != NONE]
        groups = (
            ("position", [line.answers[0] for line in arrays]),
            ("Theorem 4", [line.theorem for line in arrays if line.theorem != NONE]),
            ("plain systems", [line.answers[0] for line in self.lines if line.rule == NONE]),
        )
        return counted_words(groups)


def worst(statuses: set[int]) -> int:
    """The worst of some exit statuses."""
    return next((status for status in WORST_FIRST if status in statuses), 0)


# ---- one wheel failed ----------------------------------------------------------------------------


RANKED = "by what is proved: position before heading before pose; simulate --fail any ranks by where paths end"


def failures_view(result: CheckResult, failures: Sequence[Failure]) -> RenderableType:
    """Which wheels fail with which answers, the worst first, and why; wheel by wheel where evidence is shown."""
    head = Text("with any one wheel stopped (its friction stays) or lifted:")
    alike = _grouped(failures, lambda failure: failure.badness)
    worst = alike[0][0]
    answers = f"position {worst.position}, heading {worst.heading}, pose {worst.pose}"
    said = Text(f"the worst: {_names(alike[0])}: {answers}", "bold").append(f" ({RANKED})", "not bold")
    if result.shows_evidence:
        every = header_table("wheel", "failure", "position", "heading", "pose", "why")
        for failure in failures:
            every.add_row(Text(str(failure.wheel)), Text(failure.kind), *_verdicts(failure), Text(failure.why))
        return Group(head, every, said)
    table = header_table("position", "heading", "pose", "failed")
    whole = (result.position, result.heading, result.pose)
    table.add_row(*(verdict_text(answer.verdict) for answer in whole), Text("none"))
    for group in alike:
        table.add_row(*_verdicts(group[0]), Text(_names(group)))
    reasons = _grouped([failure for failure in failures if failure.why], lambda failure: failure.why)
    return Group(head, table, said, *(Text(f"{_names(group)}: {group[0].why}") for group in reasons))


def _verdicts(failure: Failure) -> Iterator[Text]:
    return map(verdict_text, (failure.position, failure.heading, failure.pose))


def _grouped(failures: Sequence[Failure], key: Callable[[Failure], Any]) -> list[list[Failure]]:
    """Failures that are alike, the worst first; of those that are equally bad in the order of wheels."""
    groups: dict[Any, list[Failure]] = {}
    for failure in sorted(failures, key=lambda failure: failure.badness, reverse=True):
        groups.setdefault(key(failure), []).append(failure)
    return list(groups.values())


def _names(group: Sequence[Failure]) -> str:
    """``wheels 1-5 stopped, 7 lifted``."""
    kinds = dict.fromkeys(failure.kind for failure in group)
    numbers = [tuple(failure.wheel for failure in group if failure.kind is kind) for kind in kinds]
    said = ", ".join(f"{numbers_text(wheels)} {kind}" for wheels, kind in zip(numbers, kinds, strict=True))
    return f"wheel{'s' * (len(group) > 1)} {said}"
