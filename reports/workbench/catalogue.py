"""What there is to choose from: built-in scenes and contact rules."""

from __future__ import annotations

from typing import Any

from nonsmooth.analysis.contact_rule import CellRule, all_rules
from nonsmooth.symbolic.files.scene_file import builtin_descriptions
from nonsmooth.symbolic.files.system_file import system_descriptions


def catalogue() -> dict[str, Any]:
    """Scenes and rules, each with one line about it."""
    kinds = {"array": builtin_descriptions(), "system": system_descriptions()}
    scenes = [
        {"name": name, "summary": summary, "kind": kind}
        for kind, found in kinds.items()
        for name, summary in found.items()
    ]
    rules = [
        {"name": rule.name, "summary": rule.summary, "has_cells": isinstance(rule, CellRule)} for rule in all_rules()
    ]
    return {"scenes": scenes, "rules": rules}
