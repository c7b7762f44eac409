"""``nonsmooth rules``: the contact rules, and for which machines each is a good guess."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.contact_rule import CellRule, all_rules
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.console import write_json, write_views
from nonsmooth.reports.output.study_options import Json
from nonsmooth.reports.output.terminal import header_table
from nonsmooth.symbolic.mechanics.rule import DEFAULT_RULE


def rules(json: Json = False) -> int:
    """List the contact rules: what each says, and for which hardware it is a good guess."""
    if json:
        write_json(rules_record())
    else:
        write_views([rules_view()])
    return 0


# ---- the rules as a result -----------------------------------------------------------------------


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
