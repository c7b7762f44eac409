"""Plain switched systems and audited Lyapunov functions, as tables and as JSON records."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.proofs.facts import Fact
from nonsmooth.proofs.many_states.audit import ManyStateAudit
from nonsmooth.proofs.many_states.decision import ManyStateResult
from nonsmooth.proofs.many_states.facts import many_state_audit_facts, many_state_facts
from nonsmooth.proofs.system_decision import DecidedSystem
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult
from nonsmooth.proofs.systems.scalar_facts import scalar_facts
from nonsmooth.proofs.systems.scalar_stability import ScalarResult
from nonsmooth.proofs.systems.system_facts import audit_facts, system_facts
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.facts import fact_record, fact_rows
from nonsmooth.reports.records import CHECK_SCHEMA
from nonsmooth.reports.terminal import notes_lines, two_columns, verdict_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene_error import one_line

AUDIT_SCHEMA = "nonsmooth-audit/1"


def facts_of(result: DecidedSystem) -> Iterable[Fact]:
    """The facts of a verdict in any number of states."""
    if isinstance(result, ManyStateResult):
        return many_state_facts(result)
    return scalar_facts(result) if isinstance(result, ScalarResult) else system_facts(result)


def audited_facts(result: AuditResult | ManyStateAudit) -> Iterable[Fact]:
    """The facts of an audit."""
    return many_state_audit_facts(result) if isinstance(result, ManyStateAudit) else audit_facts(result)


def system_record(result: DecidedSystem) -> Record:
    """The verdict on a plain system."""
    scene = result.scene
    head = {"schema": CHECK_SCHEMA, "scene": scene.name, "states": list(scene.states)}
    radius = with_exact({"radius": scene.check.radius})
    return {**head, **radius, **fact_record(facts_of(result)), "notes": list(angle_notes(scene.field))}


def audit_record(result: AuditResult | ManyStateAudit) -> Record:
    """The verdict on somebody's Lyapunov function."""
    return {"schema": AUDIT_SCHEMA, "scene": result.scene.name, **fact_record(audited_facts(result))}


def system_view(result: DecidedSystem) -> RenderableType:
    """The verdict with the V that proves it, or else what the scene's V shows, and the ladder of derivatives."""
    scene = result.scene
    head = f"{one_line(scene.name)}: plain switched system in {', '.join(scene.states)}"
    return Group(Text(head), _rows(facts_of(result)), *notes_lines(scene.field))


def audit_view(result: AuditResult | ManyStateAudit) -> RenderableType:
    """The verdict on V in words."""
    return Group(Text(f"{one_line(result.scene.name)}: audit of a Lyapunov function"), _rows(audited_facts(result)))


def _rows(facts: Iterable[Fact]) -> Table:
    """A row for each fact that has one, verdicts in their colors."""
    rows = two_columns()
    for name, words in fact_rows(facts):
        rows.add_row(name, verdict_text(words))
    return rows
