"""Plain switched systems and audited Lyapunov functions, as tables and as JSON records."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.proofs.facts import Fact
from nonsmooth.proofs.system_audit import AuditResult
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.system_facts import audit_facts, system_facts
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.facts import fact_record, fact_rows
from nonsmooth.reports.records import SYSTEM_SCHEMA
from nonsmooth.reports.terminal import notes_lines, two_columns, verdict_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene_error import one_line

AUDIT_SCHEMA = "nonsmooth-audit/1"


def system_record(result: StabilityResult) -> Record:
    """The verdict on a plain system."""
    scene = result.scene
    head = {"schema": SYSTEM_SCHEMA, "scene": scene.name, "states": list(scene.states)}
    radius = with_exact({"radius": scene.check.radius})
    return {**head, **radius, **fact_record(system_facts(result)), "notes": list(angle_notes(scene.field))}


def audit_record(result: AuditResult) -> Record:
    """The verdict on somebody's Lyapunov function."""
    return {"schema": AUDIT_SCHEMA, "scene": result.scene.name, **fact_record(audit_facts(result))}


def system_view(result: StabilityResult) -> RenderableType:
    """The verdict with the V that proves it, or else what the scene's V shows, and the ladder of derivatives."""
    scene = result.scene
    head = f"{one_line(scene.name)}: plain switched system in {', '.join(scene.states)}"
    return Group(Text(head), _rows(system_facts(result)), *notes_lines(scene.field))


def audit_view(result: AuditResult) -> RenderableType:
    """The verdict on V in words."""
    return Group(Text(f"{one_line(result.scene.name)}: audit of a Lyapunov function"), _rows(audit_facts(result)))


def _rows(facts: Iterable[Fact]) -> Table:
    """A row for each fact that has one, verdicts in their colors."""
    rows = two_columns()
    for name, words in fact_rows(facts):
        rows.add_row(name, verdict_text(words))
    return rows
