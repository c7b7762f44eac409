"""The feedback clause as a JSON record: law, V, rate, margin, ranks of the inputs, and what was sampled."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from nonsmooth.proofs.clauses.feedback import FeedbackResult
from nonsmooth.proofs.clauses.input_cell import InputCell
from nonsmooth.proofs.clauses.input_ranks import input_ranks
from nonsmooth.proofs.clauses.sampled_feedback import SampledFeedback
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.exact_record import Record, floats, with_exact, witness_record
from nonsmooth.symbolic.formulas import real_text
from nonsmooth.symbolic.rule import Rule


def feedback_record(result: Check) -> Record:
    """The clause with its evidence."""
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
        "witness": witness_record(feedback.witness, "theta"),
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
            "witness": witness_record(side.witness, "theta"),
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
        "rows": data.state.row_names,
        "nearest": data.nearest.index,
        "second": data.second.index,
        "sign_needed": -data.torque_sign or None,  # of u_j for theta > 0; None where u_j does not act
    }


def _samples_record(feedback: SampledFeedback) -> list[Record]:
    return [
        {
            "law": str(sample.law),
            "states": sample.states,
            "worst_rate": floats(sample.worst_rate),
            "worst_state": floats(sample.worst_state),
            "fails": bool(sample.fails),
        }
        for sample in feedback.laws
    ]
