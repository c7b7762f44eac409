"""The registered contact rules as a table and as JSON."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.contact_rule import CellRule, all_rules
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.rule import DEFAULT_RULE

RULES_SCHEMA = "nonsmooth-rules/1"
IN_DOUBT = "Not sure? check --rule all asks every rule; where they agree, the choice does not matter."


def rules_view() -> RenderableType:
    """A row for each rule."""
    table = header_table("rule", "what it says", "good for")
    table.columns[1].ratio = 1
    table.show_lines = True
    for rule in all_rules():
        needs = ". It needs to know the loads" if rule.needs_loads else ""
        table.add_row(Text(rule.name, no_wrap=True), Text(f"{rule.summary}{needs}."), Text(rule.hardware))
    return Group(table, Text(f"A scene that names none is checked under rule {DEFAULT_RULE}. {IN_DOUBT}"))


def rules_record() -> Record:
    """JSON with stable keys."""
    rules = [
        {
            "name": rule.name,
            "summary": rule.summary,
            "hardware": rule.hardware,
            "has_cells": isinstance(rule, CellRule),
            "needs_loads": rule.needs_loads,
        }
        for rule in all_rules()
    ]
    return {"schema": RULES_SCHEMA, "default": DEFAULT_RULE, "rules": rules}
