"""Results as JSON records with stable keys: floats for reading, an ``exact`` object beside those that are exact.

In every object, ``exact`` maps a key of the same object to the exact text of its value, nested like the value
(``"worst_rate": -2.0, "exact": {"worst_rate": "-2"}``).  The texts are formulas that scene files accept; where the
exact form of a vertex would be endless, an enclosure ``[0.123 +/- 4e-21]`` stands instead.  Sampled values have none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb

from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.proofs.clauses.ellipse_clauses import EllipseTranslation
from nonsmooth.proofs.clauses.feedback import FeedbackResult, InputCell
from nonsmooth.proofs.clauses.input_ranks import input_ranks
from nonsmooth.proofs.clauses.rotation import Drift
from nonsmooth.proofs.clauses.sampled_feedback import SampledFeedback
from nonsmooth.proofs.clauses.translation import LYAPUNOV, TranslationResult, Witness
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium
from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
from nonsmooth.symbolic.contact_states import ContactState
from nonsmooth.symbolic.formulas import real_text
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.rule import Rule

CHECK_SCHEMA = "nonsmooth-check/1"
CHECKS_SCHEMA = "nonsmooth-checks/1"
PARTITION_SCHEMA = "nonsmooth-partition/1"
SCENES_SCHEMA = "nonsmooth-scenes/1"

Record: TypeAlias = dict[str, Any]
Check: TypeAlias = CellCheck | EllipseCheck


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
        "feedback": _feedback_record(result),
        "theorem4": {"verdict": str(result.verdict), "reason": result.reason},
        "continuum": continuum,
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
                "rows": row_names(cell.states[0]),
                "alternatives": [
                    {**with_exact({"twist": state.twist}), "rows": row_names(state)} for state in cell.states[1:]
                ],
            }
            for cell in partition.cells
        ],
        **with_exact({"domain": partition.domain.vertices}),
        "area_error": real_text(partition.area_error) if partition.complete else None,
    }


def states_record(partition: Partition) -> list[Record]:
    """The contact states that own a cell, with their control vector fields by wheel (None beyond three rows)."""
    return [
        {
            "rows": row_names(state),
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


def row_names(state: ContactState) -> list[str]:
    """For example ``["R1", "S1", "R4"]``."""
    return [row.name for row in state.rows]


def _census_record(result: Check) -> Record:
    census = result.census
    return {
        "possible": census.possible,
        "singular": census.singular,
        "distinct_twists": census.distinct_twists,
        "minimizing": minimizing_states(result),
    }


def minimizing_states(result: Check) -> int | None:
    """How many contact states own a cell of the square; None where not all cells were built, or there are none."""
    if isinstance(result, CellCheck) and result.partition.complete:
        return len(result.partition.states)
    return None


def other_equilibria(result: Check) -> list[JudgedEquilibrium] | None:
    """Equilibria of the square beside the checked point; None where they were not searched for."""
    if not isinstance(result, CellCheck) or result.others is None:
        return None
    return [e for e in result.others if len(e.found.points) > 1 or any(e.found.points[0])]


def _equilibrium_record(result: Check) -> Record:
    found = other_equilibria(result)
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
    sampled = translation.sampled if isinstance(translation, EllipseTranslation) else None
    if sampled is not None:
        rate = {"worst_rate": sampled.largest_relative, "exact": {}}
    return {
        "verdict": str(translation.verdict),
        "lyapunov": LYAPUNOV,
        "quadratic": _quadratic_record(translation),
        **rate,
        "samples": None if sampled is None else sampled.samples,
        "region": None if radius is None else {"shape": "disc", **with_exact({"radius": radius})},
        "witness": _witness_record(translation.witness, "value"),
        "reason": translation.reason,
    }


def _quadratic_record(translation: TranslationResult | EllipseTranslation) -> Record | None:
    """The Lyapunov function ``c^T P c`` that serves where |c|^2 does not: its decay ``V* <= -decay |c|`` and region."""
    found = translation.quadratic if isinstance(translation, TranslationResult) else None
    if found is None:
        return None
    return {"lyapunov": str(found), "decay": float(found.decay), **with_exact({"level": found.level})}


def _rotation_record(result: Check) -> Record:
    rotation = result.rotation
    drift = rotation.drift
    return {
        "verdict": str(rotation.verdict),
        "weakly_stable": result.theta_is_weakly_stable if isinstance(result, CellCheck) else None,
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


def _feedback_record(result: Check) -> Record:
    feedback, authority = result.feedback, result.authority
    cells = feedback.cells if isinstance(feedback, FeedbackResult) else ()
    return {
        "verdict": str(feedback.verdict),
        "law": feedback.law,
        **_rate_record(feedback),
        "lyapunov": _control_lyapunov_record(feedback),
        "none_serves": feedback.none_serves if isinstance(feedback, FeedbackResult) else None,
        "margin": _margin_record(feedback),
        "ranks": _ranks_record(result),
        "witness": _witness_record(feedback.witness, "theta"),
        "reason": feedback.reason,
        "printed_sign_fails": list(feedback.printed_sign_fails) if isinstance(feedback, FeedbackResult) else [],
        "cells": [_input_cell_record(data) for data in cells],
        "sampled": _samples_record(feedback) if isinstance(feedback, SampledFeedback) else [],
        "authority": {"rank": authority.rank, **with_exact({"missing": authority.missing})},
    }


def _ranks_record(result: Check) -> Record | None:
    """Independent inputs by cell, by pair of neighbouring cells and at the checked point (rule ``nearest``)."""
    if not isinstance(result, CellCheck) or result.partition.rule is not Rule.NEAREST:
        return None
    ranks = input_ranks(result.partition)
    return {
        "cells": [{"cell": cell, "rank": rank} for cell, rank in ranks.cells.items()],
        "sides": [{"cells": list(pair), "rank": rank} for pair, rank in ranks.sides.items()],
        "equilibrium": ranks.equilibrium,
    }


def _rate_record(feedback: FeedbackResult | SampledFeedback) -> Record:
    """The certified rate: ``V' <= -rate k V`` near the equilibrium, within ``rate_reach`` where that is bounded."""
    rate = feedback.rate if isinstance(feedback, FeedbackResult) else None
    if not isinstance(feedback, FeedbackResult) or rate is None:
        return {"rate": None, "rate_reach": None}
    field = feedback.cells[0].cell.twists[0].omega.field
    return with_exact({"rate": field(2 * rate.kappa), "rate_reach": None if rate.reach is None else field(rate.reach)})


def _control_lyapunov_record(feedback: FeedbackResult | SampledFeedback) -> Record | None:
    """``V = c^T P c + w theta^2`` of the law."""
    if not isinstance(feedback, FeedbackResult) or feedback.law is None:
        return None
    (e, f), w = feedback.lyapunov.shape, feedback.lyapunov.weight
    field = feedback.cells[0].cell.twists[0].omega.field
    return with_exact({"P": ((field(1 + e), field(f)), (field(f), field(1 - e))), "w": field(w)})


def _margin_record(feedback: FeedbackResult | SampledFeedback) -> Record | None:
    """The error in c, as a part of |c|, up to which one input serves; side by side, and over all."""
    margin = feedback.margin if isinstance(feedback, FeedbackResult) else None
    if margin is None:
        return None
    sides = [
        {
            "cells": list(side.cells),
            **_root_record(side.squared),
            "witness": _witness_record(side.witness, "theta"),
        }
        for side in margin.sides
    ]
    return {**_root_record(margin.squared), "is_exact": margin.is_exact, "sides": sides}


def _root_record(squared: Any) -> Record:
    """``sqrt(squared)``."""
    text = str(squared) if isinstance(squared, Fraction) else real_text(squared)
    return {"relative": float(squared) ** 0.5, "exact": {"relative": f"sqrt({text})"}}


def _input_cell_record(data: InputCell) -> Record:
    return {
        "cell": data.cell.index,
        "rows": row_names(data.state),
        "nearest": data.nearest.index,
        "second": data.second.index,
        "sign_needed": -data.torque_sign or None,  # of u_j for theta > 0; None where u_j does not act
    }


def _samples_record(feedback: SampledFeedback) -> list[Record]:
    return [
        {
            "law": str(sample.law),
            "states": sample.states,
            "worst_rate": _floats(sample.worst_rate),
            "worst_state": _floats(sample.worst_state),
            "fails": bool(sample.fails),
        }
        for sample in feedback.laws
    ]


def _witness_record(witness: Witness | None, value: str) -> Record | None:
    if witness is None:
        return None
    return {**with_exact({"point": witness.point, value: witness.value}), "meaning": witness.meaning}


def with_exact(values: Record) -> Record:
    """The values as floats, and their exact texts under ``exact``."""
    exact = {key: _texts(value) for key, value in values.items() if value is not None}
    return {**{key: _floats(value) for key, value in values.items()}, "exact": exact}


def _floats(value: Any) -> Any:
    """Numbers as floats, through nested tuples; None beyond the range of floats (JSON has no infinity)."""
    if value is None:
        return None
    if isinstance(value, Number | Lazy | arb | float | int):
        number = float(value)
        return number if math.isfinite(number) else None
    return [_floats(entry) for entry in value]


def _texts(value: Any) -> Any:
    return real_text(value) if isinstance(value, Number | Lazy | arb) else [_texts(entry) for entry in value]
