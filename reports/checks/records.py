"""Results as JSON records with stable keys; how values are written: :mod:`nonsmooth.reports.output.facts`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.contact_rule import rule_notes
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.answers.answers import Answers, answers_of
from nonsmooth.proofs.answers.contact_wheels import contact_facts
from nonsmooth.proofs.clauses.clause import Clause
from nonsmooth.proofs.theorem4_result import Check, Contradiction
from nonsmooth.reports.checks.answers import answers_record, robust_record
from nonsmooth.reports.output.facts import Record, fact_record, with_exact
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.numbers.number_text import real_text

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.failures import Failure

CHECK_SCHEMA = "nonsmooth-check/2"
CHECKS_SCHEMA = "nonsmooth-checks/1"
PARTITION_SCHEMA = "nonsmooth-partition/1"
SCENES_SCHEMA = "nonsmooth-scenes/1"
FAILURE = ("position", "heading", "pose", "theorem4")  # the answers of a failure, beside wheel, kind and why


def check_record(
    result: Check,
    answered: Answers | None = None,
    continuum: Record | None = None,
    failures: Sequence[Failure] | None = None,
) -> Record:
    """The verdicts of one check; points and twists are measured from ``equilibrium.at``.

    Args:
        result: the verdicts.
        answered: where bodies go and what the other rules say, where that was asked.
        continuum: the record of the continuous idealization, where it is asked for.
        failures: the answers with any one wheel failed, where they are asked for.
    """
    scene = result.scene
    return {
        "schema": CHECK_SCHEMA,
        "scene": scene.name,
        "wheels": len(scene.wheels),
        "rule": str(scene.contact.rule),
        **with_exact({"radius": scene.check.radius, "length": scene.field(scene.check.length)}),
        "contact_set": fact_record(contact_facts(result)),
        "answers": answers_record(answers_of(result), answered),
        "robust": robust_record(answered),
        "contact_states": _census_record(result),
        **{clause.name: _clause_record(result, clause) for clause, _ in result.clauses},
        "theorem4": {"verdict": str(result.verdict), "reason": result.reason},
        **contradictions_record(result.contradictions),
        "continuum": continuum,
        "failures": None if failures is None else failure_records(failures),
        "notes": [*angle_notes(scene.field), *rule_notes(scene)],
        "skipped": [{"what": s.what, "count": s.count, "why": s.why} for s in result.skipped],
        "seconds": {step: round(seconds, 6) for step, seconds in result.seconds.items()},
    }


def contradictions_record(found: Sequence[Contradiction]) -> Record:
    """What contradicts what, with both sides; without a key where nothing does."""
    sides = [{"between": one.between, "sides": list(one.sides)} for one in found]
    return {"contradictions": sides} if sides else {}


def checks_record(records: Iterable[Record]) -> Record:
    """Checks of one scene under several rules, by their records."""
    return {"schema": CHECKS_SCHEMA, "checks": list(records)}


def failure_records(failures: Sequence[Failure]) -> list[Record]:
    """Failures wheel by wheel as JSON; exactly one of them is the worst."""
    from nonsmooth.proofs.answers.failures import worst_failure

    worst = worst_failure(tuple(failures))
    return [
        {
            "wheel": failure.wheel,
            "failure": str(failure.kind),
            **{name: str(getattr(failure, name)) for name in FAILURE},
            "why": failure.why or None,
            "worst": failure is worst,
        }
        for failure in failures
    ]


def partition_record(partition: Partition) -> Record:
    """The cells, in the partition's coordinates; a cell where the rule ties lists its other motions as alternatives."""
    return {
        "schema": PARTITION_SCHEMA,
        "scene": partition.scene.name,
        "rule": str(partition.rule),
        "cells": [
            {
                **with_exact(
                    {"twist": cell.states[0].twist, "polygon": cell.polygon.vertices, "area": cell.polygon.area}
                ),
                "rows": cell.states[0].row_names,
                "alternatives": [
                    {**with_exact({"twist": state.twist}), "rows": state.row_names} for state in cell.states[1:]
                ],
            }
            for cell in partition.cells
        ],
        **with_exact({"domain": partition.domain.vertices}),
        "area_error": real_text(partition.area_error) if partition.complete else None,
        "notes": list(angle_notes(partition.scene.field)),
    }


def states_record(partition: Partition) -> list[Record]:
    """The contact states that own a cell, with their control vector fields by wheel (None beyond three rows)."""
    return [
        {
            "rows": state.row_names,
            **with_exact({"twist": state.twist}),
            "control_fields": None if len(state.rows) > 3 else _control_fields_record(state),
        }
        for state in partition.states
    ]


def _control_fields_record(state: ContactState) -> list[Record]:
    fields = sorted(state.control_fields.items())
    return [{"wheel": wheel, **with_exact({"field": field})} for wheel, field in fields]


def scenes_record(descriptions: dict[str, str]) -> Record:
    """The built-in scenes."""
    return {
        "schema": SCENES_SCHEMA,
        "scenes": [{"name": name, "description": text} for name, text in descriptions.items()],
    }


def _clause_record(result: Check, clause: Clause[Any]) -> Record:
    found = result.results[clause.name]
    return {"verdict": str(found.verdict), "reason": found.reason, **fact_record(result.facts(clause))}


def _census_record(result: Check) -> Record:
    census = result.census
    return {
        "possible": census.possible,
        "singular": census.singular,
        "distinct_twists": census.distinct_twists,
        "minimizing": result.minimizing_states,
    }
