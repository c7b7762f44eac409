"""The feedback clause as a JSON record: law, V, rate, margin, ranks of the inputs, and what was sampled."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from nonsmooth.analysis.contact_rule import rule_of
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.control_lyapunov import SQUARES
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, rim_speeds
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.proofs.clauses.feedback.input_ranks import input_ranks
from nonsmooth.proofs.clauses.feedback.level_region import LevelRegion
from nonsmooth.proofs.theorem4_result import AnyFeedback, CellCheck, Check
from nonsmooth.reports.exact_record import Record, floats, with_exact, witness_record
from nonsmooth.symbolic.formulas import real_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene


def feedback_record(result: Check) -> Record:
    """The clause with its evidence."""
    feedback, authority = result.feedback, result.authority
    cells = feedback.cells if isinstance(feedback, FeedbackResult) else ()
    return {
        "verdict": str(feedback.verdict),
        "law": feedback.law,
        **_rate_record(feedback, result.scene),
        "lyapunov": _control_lyapunov_record(feedback, result.scene),
        "region": _region_record(feedback),
        "none_serves": feedback.none_serves if isinstance(feedback, FeedbackResult) else None,
        "margin": _margin_record(feedback),
        "ranks": _ranks_record(result),
        "witness": witness_record(feedback.witness, "theta"),
        "reason": feedback.reason,
        "printed_sign_fails": list(feedback.printed_sign_fails) if isinstance(feedback, FeedbackResult) else [],
        "cells": [_input_cell_record(data) for data in cells],
        "obstruction": None if feedback.obstruction is None else with_exact({"normal": feedback.obstruction}),
        "cascade": _cascade_record(feedback),
        "cones": _cones_record(result),
        "sampled": _samples_record(feedback) if isinstance(feedback, DrivenFeedback) else [],
        "authority": {"rank": authority.rank, **with_exact({"missing": authority.missing})},
    }


def _ranks_record(result: Check) -> Record | None:
    """Independent inputs by cell, by pair of neighbouring cells and at the checked point (rule ``nearest``)."""
    if not isinstance(result, CellCheck) or not rule_of(result.scene).keeps_rows:
        return None
    ranks = input_ranks(result.partition)
    return {
        "cells": [{"cell": cell, "rank": rank} for cell, rank in ranks.cells.items()],
        "sides": [{"cells": list(pair), "rank": rank} for pair, rank in ranks.sides.items()],
        "equilibrium": ranks.equilibrium,
    }


def _rate_record(feedback: AnyFeedback, scene: Scene) -> Record:
    """The certified rate: ``V' <= -rate k V`` near the equilibrium, within ``rate_reach`` where that is known.

    The reach is a distance under rule ``nearest``, the half-width of a square under rule ``box``.
    """
    reach: Number | None = None
    if isinstance(feedback, DrivenFeedback):
        kappa, reach = feedback.kappa, feedback.reach
    else:
        kappa = None if feedback.rate is None else feedback.rate.kappa
        bound = None if feedback.rate is None else feedback.rate.reach
        reach = None if bound is None else scene.field(bound)
    if kappa is None:
        return {"rate": None, "rate_reach": None}
    return with_exact({"rate": scene.field(2 * kappa), "rate_reach": reach})


def _control_lyapunov_record(feedback: AnyFeedback, scene: Scene) -> Record | None:
    """``V = c^T P c + w theta^2`` of the law."""
    known = feedback.has_lyapunov if isinstance(feedback, FeedbackResult) else feedback.law is not None
    if not known:
        return None
    lyapunov = feedback.lyapunov if isinstance(feedback, FeedbackResult) else SQUARES
    (e, f), w = lyapunov.shape, lyapunov.weight
    field = scene.field
    return with_exact({"P": ((field(1 + e), field(f)), (field(f), field(1 - e))), "w": field(w)})


def _region_record(feedback: AnyFeedback) -> Record | None:
    """The starts from which the law of rule ``nearest`` is certified to bring the body home, where these are known."""
    region = feedback.region if isinstance(feedback, FeedbackResult) else None
    if region is None:
        return None
    level = {"level": float(region.level), "exact": {"level": str(region.level)}}
    return {"text": str(region), "function": "V" if isinstance(region, LevelRegion) else "W", **level}


def _cascade_record(feedback: AnyFeedback) -> Record | None:
    """How c comes home where theta is taken first, and the sign of the translation along each nearest rim."""
    cascade = feedback.cascade if isinstance(feedback, FeedbackResult) else None
    if cascade is None:
        return None
    signs = [{"wheel": wheel.index, "sign": s} for wheel, s in zip(cascade.wheels, cascade.signs, strict=True)]
    gains = list(cascade.fan.gains.values())
    return {"descent": str(cascade.descent), "signs": signs, **with_exact({"gain": gains[0] if gains else None})}


def _cones_record(result: Check) -> list[Record]:
    """The twists of the law with the speeds that impose them, by cone of directions (rules ``box``, ``ellipse``)."""
    cones = result.feedback.cones if isinstance(result.feedback, DrivenFeedback) else ()
    return [_cone_record(cone, result.scene.recentred()) for cone in cones]


def _cone_record(cone: LawCone, scene: Scene) -> Record:
    twists = [
        {**with_exact({"twist": imposed.twist}), "speeds": floats(rim_speeds(scene, imposed))}
        for imposed in cone.twists
    ]
    rays = {"from": None, "to": None} if cone.rays is None else with_exact({"from": cone.rays[0], "to": cone.rays[1]})
    return {**rays, "twists": twists}


def _margin_record(feedback: AnyFeedback) -> Record | None:
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


def _samples_record(feedback: DrivenFeedback) -> list[Record]:
    return [
        {
            "law": str(sample.law),
            "states": sample.states,
            "worst_rate": floats(sample.worst_rate),
            "worst_state": floats(sample.worst_state),
            "fails": sample.fails,
            "not_certified": sample.not_certified or None,
        }
        for sample in feedback.samples
    ]
