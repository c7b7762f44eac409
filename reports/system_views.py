"""Plain switched systems and audited Lyapunov functions, as tables and as JSON records."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.proofs.facts import Fact
from nonsmooth.proofs.system_audit import AuditResult
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.system_facts import (
    audit_facts,
    displacement_facts,
    gain_words,
    rate_words,
    reached_words,
    region_rate_words,
    rewriting_words,
    system_facts,
)
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.facts import fact_record, fact_rows
from nonsmooth.reports.records import SYSTEM_SCHEMA
from nonsmooth.reports.terminal import MORE, answers_table, notes_lines, two_columns, verdict_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene_error import one_line

AUDIT_SCHEMA = "nonsmooth-audit/1"
MEANINGS = {
    Translation.ASYMPTOTICALLY_STABLE: "every solution from near the equilibrium stays near it and comes to it",
    Translation.STABLE: "every solution from near the equilibrium stays near it",
    Translation.UNSTABLE: "from as near the equilibrium as one likes some solution goes away",
}  # of the verdicts, for solutions of the inclusion


class SystemAnswer(NamedTuple):
    """What somebody wants to know of a plain system.

    Attributes:
        question: a word or two.
        answer: likewise.
        sentence: what it says, with its numbers and where they hold.
    """

    question: str
    answer: str
    sentence: str


def system_record(result: StabilityResult) -> Record:
    """The verdict on a plain system."""
    scene = result.scene
    head = {"schema": SYSTEM_SCHEMA, "scene": scene.name, "states": list(scene.states)}
    radius = with_exact({"radius": scene.check.radius})
    return {**head, **radius, **fact_record(system_facts(result)), "notes": list(angle_notes(scene.field))}


def audit_record(result: AuditResult) -> Record:
    """The verdict on somebody's Lyapunov function."""
    return {"schema": AUDIT_SCHEMA, "scene": result.scene.name, **fact_record(audit_facts(result))}


def system_answers(result: StabilityResult) -> Iterator[SystemAnswer]:
    """Whether the point is stable, from where and how fast solutions come to it, and what proves it."""
    verdict = result.verdict
    if verdict is Translation.UNDECIDED:
        yield SystemAnswer("stability", str(verdict), result.reason)
    else:
        yield SystemAnswer("stability", str(verdict), MEANINGS[verdict])
    if verdict is Translation.ASYMPTOTICALLY_STABLE:
        yield _from_where(result)
        yield _how_fast(result)
        if result.reach.gain is not None:
            yield SystemAnswer("disturbed", "bounded", gain_words(result.reach, result.scene.states))
    if verdict is not Translation.UNDECIDED:
        yield SystemAnswer("proved by", str(result.method), _proof_words(result))
    tried = result.given
    if tried is not None and tried is not result.function and not result.scene.check.is_default:
        words = f"V = {tried.text}: {tried.reason} (on {tried.domain.text(result.scene.states)})"
        yield SystemAnswer("the scene's V", tried.decrease.name.lower(), words)


def _from_where(result: StabilityResult) -> SystemAnswer:
    """The most starts that are certified to reach an asymptotically stable point."""
    question, reach, states = "from where", result.reach, result.scene.states
    if reach.everywhere:
        return SystemAnswer(question, "everywhere", "every start reaches the equilibrium")
    if reach.region is not None:
        return SystemAnswer(question, "a region", reached_words(reach.region, states))
    for fact in result.deciding.facts:
        if fact.key == "region" and fact.words:  # in one state an interval
            return SystemAnswer(question, "an interval", fact.words)
    return SystemAnswer(question, "from near it", "how far around it is not certified")


def _how_fast(result: StabilityResult) -> SystemAnswer:
    """The rate at which solutions come to an asymptotically stable point."""
    question, reach, states = "how fast", result.reach, result.scene.states
    if reach.rate is not None:
        kind = "in finite time" if reach.rate.decay is DecayKind.FINITE else "exponentially"
        farther = f"; {region_rate_words(reach, states)}" if reach.region_rate is not None else ""
        return SystemAnswer(question, kind, f"{rate_words(reach, states)}{farther}")
    if reach.in_finite_time:
        return SystemAnswer(
            question, "in finite time", "solutions near the equilibrium arrive; no bound on the time is proved"
        )
    return SystemAnswer(question, "not known", "no rate is proved")


def _proof_words(result: StabilityResult) -> str:
    """The reason, behind the V that it speaks of."""
    function = result.function
    if function is None:
        return result.reason
    shown = f"a V in {len(function.pieces)} pieces" if function.pieces else f"V = {function.text}"
    return f"{shown}, on {function.domain.text(result.scene.states)}: {result.reason}"


def system_view(result: StabilityResult, *, evidence: bool) -> RenderableType:
    """The answers, with what the letters in them stand for.

    Args:
        result: the verdict.
        evidence: add all that was found: the V that proves the verdict, or what the scene's V shows, and the ladder of
            derivatives.
    """
    scene = result.scene
    head = Text(one_line(scene.name), "bold")
    head.append(f": plain switched system in {', '.join(scene.states)}", "not bold")
    stated = fact_rows(displacement_facts(scene)) if len(scene.states) > 1 else []
    if scene.written or scene.others:
        stated.append(("field", rewriting_words(scene)))
    details = [_rows(system_facts(result))] if evidence else [Text(f"{name}: {words}") for name, words in stated]
    more = [] if evidence else [Text(MORE, "dim")]
    return Group(head, answers_table(system_answers(result)), *details, *notes_lines(scene.field), *more)


def audit_view(result: AuditResult) -> RenderableType:
    """The verdict on V in words."""
    return Group(Text(f"{one_line(result.scene.name)}: audit of a Lyapunov function"), _rows(audit_facts(result)))


def _rows(facts: Iterable[Fact]) -> Table:
    """A row for each fact that has one, verdicts in their colors."""
    rows = two_columns()
    for name, words in fact_rows(facts):
        rows.add_row(name, verdict_text(words))
    return rows
