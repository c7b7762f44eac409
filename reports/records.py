"""Results as JSON records with stable keys; how values are written: :mod:`nonsmooth.reports.exact_record`."""

from __future__ import annotations

from collections.abc import Iterable

from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.proofs.clauses.at_point.ellipse_clauses import EllipseTranslation
from nonsmooth.proofs.clauses.rotation.on_cells import Drift
from nonsmooth.proofs.clauses.translation.on_cells import LYAPUNOV, TranslationResult
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.reports.exact_record import Record, with_exact, witness_record
from nonsmooth.reports.feedback_record import feedback_record
from nonsmooth.symbolic.contact_states import ContactState
from nonsmooth.symbolic.formulas import real_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes

CHECK_SCHEMA = "nonsmooth-check/1"
CHECKS_SCHEMA = "nonsmooth-checks/1"
PARTITION_SCHEMA = "nonsmooth-partition/1"
SCENES_SCHEMA = "nonsmooth-scenes/1"


def check_record(result: Check, continuum: Record | None = None) -> Record:
    """The verdicts of one check; points and twists are measured from ``equilibrium.at``.

    Args:
        result: the verdicts.
        continuum: the record of the continuous idealization, where it is asked for.
    """
    scene = result.scene
    return {
        "schema": CHECK_SCHEMA,
        "scene": scene.name,
        "wheels": len(scene.wheels),
        "rule": str(scene.contact.rule),
        **with_exact({"radius": scene.check.radius}),
        "contact_states": _census_record(result),
        "equilibrium": _equilibrium_record(result),
        "translation": _translation_record(result.translation),
        "rotation": _rotation_record(result),
        "feedback": feedback_record(result),
        "theorem4": {"verdict": str(result.verdict), "reason": result.reason},
        "continuum": continuum,
        "notes": list(angle_notes(scene.field)),
        "skipped": [{"what": s.what, "count": s.count, "why": s.why} for s in result.skipped],
        "seconds": {step: round(seconds, 6) for step, seconds in result.seconds.items()},
    }


def checks_record(records: Iterable[Record]) -> Record:
    """Checks of one scene under several rules, by their records."""
    return {"schema": CHECKS_SCHEMA, "checks": list(records)}


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


def _census_record(result: Check) -> Record:
    census = result.census
    return {
        "possible": census.possible,
        "singular": census.singular,
        "distinct_twists": census.distinct_twists,
        "minimizing": result.minimizing_states,
    }


def _equilibrium_record(result: Check) -> Record:
    found = result.other_equilibria
    others = [
        {
            "place": str(e.found.place),
            **with_exact({"points": e.found.points}),
            "cells": list(e.found.cells),
            "translation": None if e.translation is None else str(e.translation),
            "rotation": None if e.rotation is None else str(e.rotation),
        }
        for e in found or ()
    ]
    return {
        "verdict": str(result.equilibrium.verdict),
        **with_exact({"at": result.scene.check.equilibrium}),
        "others": None if found is None else others,
        "reason": result.equilibrium.reason,
    }


def _translation_record(translation: TranslationResult | EllipseTranslation) -> Record:
    radius = translation.region_radius
    rate = with_exact({"worst_rate": translation.worst_rate})
    sampled = translation.sampled
    if sampled is not None:
        rate = {"worst_rate": sampled.largest_relative, "exact": {}}
    return {
        "verdict": str(translation.verdict),
        "lyapunov": LYAPUNOV,
        "quadratic": _quadratic_record(translation),
        **rate,
        "samples": None if sampled is None else sampled.samples,
        "not_certified": None if sampled is None else sampled.not_certified or None,
        "region": None if radius is None else {"shape": "disc", **with_exact({"radius": radius})},
        "support": _support_record(translation),
        "witness": witness_record(translation.witness, "value"),
        "reason": translation.reason,
    }


def _support_record(translation: TranslationResult | EllipseTranslation) -> Record | None:
    """Distance of the point from the border of the support polygon, where the square leaves it (rule ``nearest``)."""
    if not isinstance(translation, TranslationResult) or translation.support is None:
        return None
    return {**with_exact({"distance": translation.support.distance}), "note": translation.support_note}


def _quadratic_record(translation: TranslationResult | EllipseTranslation) -> Record | None:
    """The Lyapunov function ``c^T P c`` that serves where |c|^2 does not: its decay ``V* <= -decay |c|`` and region."""
    found = translation.quadratic
    if found is None:
        return None
    return {"lyapunov": str(found), "decay": float(found.decay), **with_exact({"level": found.level})}


def _rotation_record(result: Check) -> Record:
    rotation = result.rotation
    drift = rotation.drift
    return {
        "verdict": str(rotation.verdict),
        "weakly_stable": result.theta_is_weakly_stable,
        **with_exact({"drift": None if drift is None else drift.interval}),
        "weights": None if drift is None else _weights_record(drift),
        "reason": rotation.reason,
    }


def _weights_record(drift: Drift) -> Record:
    """The convex weights that rest in (x, y) and turn at the lowest and highest rate."""
    return {
        end: [with_exact({"twist": drift.twists[k], "weight": w}) for k, w in mixture.weights.items()]
        for end, mixture in (("lowest", drift.lowest), ("highest", drift.highest))
    }
