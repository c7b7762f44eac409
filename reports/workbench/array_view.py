"""The stages of the view of an array."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.shapes import (
    body_record,
    cells_record,
    contact_record,
    edges_record,
    square_record,
    wheels_record,
)
from nonsmooth.symbolic.contact_set import contact_set, standing


def array_stages(array: Array, request: dict[str, Any], announce: Callable[[str], None]) -> Iterator[dict[str, Any]]:
    """Geometry at once, then the verdicts."""
    began = time.perf_counter()
    yield {**_geometry(array), "stage": "fast", "answers": None, "time": time.perf_counter() - began}
    announce("answers")
    result = array.check()
    answers = [
        {
            "key": answer.name,
            "question": answer.name,
            "answer": str(answer.verdict),
            "tone": answer.tone,
            "sentence": answer.sentence,
        }
        for answer in (result.position, result.heading, result.pose)
    ]
    clauses = [
        {"key": clause.name, "title": clause.name, "verdict": str(found.verdict), "reason": found.reason, "facts": []}
        for clause, found in result.evidence.clauses
    ]
    yield {
        "stage": "exact",
        "answers": answers,
        "clauses": clauses,
        "verdict": result.theorem4,
        "reason": result.evidence.reason,
        "time": time.perf_counter() - began,
    }


def _geometry(array: Array) -> dict[str, Any]:
    scene = standing(array.scene)
    contact = contact_set(scene)
    record: dict[str, Any] = {
        "kind": "array",
        "rule": scene.contact.rule,
        "wheels": wheels_record(scene, contact.wheels),
        "body": body_record(scene),
        "square": square_record(scene),
        "contact": contact_record(contact),
        "cells": [],
        "edges": [],
        "field": [],
    }
    if isinstance(rule_of(scene), CellRule):
        partition = array.partition
        record.update(cells=cells_record(partition), edges=edges_record(partition))
    return record
