"""What the feedback clause says of rules that keep rows: V, certified rate and region, margin, signs by cell.

The keys stand in every record; under other rules they hold what the law by imposed twists has of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.contact_rule import rule_of
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.proofs.clauses.feedback.input_margin import InputMargin
from nonsmooth.proofs.clauses.feedback.input_ranks import input_ranks
from nonsmooth.proofs.clauses.feedback.level_region import LevelRegion
from nonsmooth.proofs.clauses.witness import witness_record
from nonsmooth.proofs.facts import Fact, Quantity, Record, said
from nonsmooth.symbolic.number_text import decimal_text, lower_text, real_text
from nonsmooth.symbolic.scene import Scene

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
    from nonsmooth.proofs.theorem4_result import Theorem4Result

LIMITED = (
    "limited speeds: where a wheel would exceed its limit all are scaled alike, which keeps the paths of the law "
    "and only slows them"
)
UNKNOWN_SPEED = "how fast the limited law is, is not known"
MOST_CELLS = 12  # that are named in a sentence


def row_facts(feedback: FeedbackResult | DrivenFeedback, check: Theorem4Result) -> Iterator[Fact]:
    """V, rate, region, margin, ranks of the inputs, and the signs that the cells need."""
    yield from _rate(feedback, check.scene)
    yield from limit_facts(feedback, check.scene)
    rows = feedback if isinstance(feedback, FeedbackResult) else None
    yield Fact("lyapunov", _lyapunov_record(feedback, check.scene))
    yield from _region(rows)
    yield Fact("none_serves", None if rows is None else rows.none_serves)
    margin = None if rows is None else rows.margin
    if margin is None:
        yield Fact("margin")
    else:
        yield Fact("margin", _margin_record(margin), str(margin), explained=True)
    yield Fact("ranks", _ranks_record(check))
    fails = [] if rows is None else list(rows.printed_sign_fails)
    words = f"the paper's u_j = -k theta has the wrong sign in {_cells(fails)}" if fails else ""
    yield Fact("printed_sign_fails", fails, words, explained=True)
    yield Fact("cells", [] if rows is None else [_cell_record(data) for data in rows.cells])
    cascade = None if rows is None else rows.cascade
    yield Fact("cascade", None if cascade is None else _cascade_record(cascade))


def _rate(feedback: FeedbackResult | DrivenFeedback, scene: Scene) -> Iterator[Fact]:
    """The certified rate: ``V' <= -rate k V`` near the equilibrium, within ``rate_reach`` where that is known.

    The reach is a distance under rules that keep rows, the half-width of a square under others.
    """
    if not isinstance(feedback, FeedbackResult):
        kappa, reach = feedback.certified_kappa, feedback.reach
    else:
        kappa = None if feedback.rate is None else feedback.rate.kappa
        bound = None if feedback.rate is None else feedback.rate.reach
        reach = None if bound is None else scene.field(bound)
    if kappa is None:
        yield from (Fact("rate"), Fact("rate_reach"))
        return
    yield Fact("rate", Quantity(scene.field(2 * kappa)))
    yield Fact("rate_reach", Quantity(reach))
    if isinstance(feedback, FeedbackResult):
        where = "near c*" if reach is None else f"where |c| <= {decimal_text(reach, 3)}"
        yield said(f"{where}: V' <= -{lower_text(2 * kappa, 4)} k V (certified)", explained=True)
        yield said(f"V = {feedback.lyapunov}", explained=True)


def limit_facts(feedback: FeedbackResult | DrivenFeedback, scene: Scene) -> Iterator[Fact]:
    """What limits of speed leave of the rate; nothing where no wheel has one."""
    if not scene.speed_limits or feedback.law is None:
        yield Fact("limited")
        return
    limited = feedback.limited if isinstance(feedback, FeedbackResult) else None
    yield said(LIMITED, explained=True)
    if limited is None:
        yield said(UNKNOWN_SPEED, explained=True)
        yield Fact("limited")
        return
    unit = f" {scene.units.speed}".rstrip()
    gain = "" if feedback.lyapunov.length is not None else ", k >= 1"
    level = lower_text(limited.level, 4)
    words = f"where V < {level}: no wheel is at its limit while k^2 V <= {lower_text(limited.free, 4)}{gain}"
    yield said(f"{words} (certified)", explained=True)
    rate = f"the rate holds while k^2 V <= {lower_text(limited.held, 4)}"
    speed = f"beyond, sqrt(V) falls at {lower_text(limited.speed, 4)}{unit} or faster (certified)"
    yield said(f"{rate}; {speed}", explained=True)
    keys = ("free", "held", "speed", "level")
    yield Fact("limited", {key: Quantity(scene.field(getattr(limited, key))) for key in keys})


def _lyapunov_record(feedback: FeedbackResult | DrivenFeedback, scene: Scene) -> Record | None:
    """``V = c^T P c + w theta^2`` of the law."""
    known = feedback.has_lyapunov if isinstance(feedback, FeedbackResult) else feedback.law is not None
    if not known:
        return None
    (e, f), w = feedback.lyapunov.shape, feedback.lyapunov.weight
    exact = scene.field
    shape = ((exact(1 + e), exact(f)), (exact(f), exact(1 - e)))
    return {"P": Quantity(shape), "w": Quantity(exact(w))}


def _region(rows: FeedbackResult | None) -> Iterator[Fact]:
    """The starts from which the law is certified to bring the body home, where these are known."""
    region = None if rows is None else rows.region
    if rows is not None and rows.law is not None:
        where = "near c*; how near is not known" if region is None else str(region)
        yield said(f"certified region: {where}", explained=True)
    if region is None:
        yield Fact("region")
        return
    level = {"level": float(region.level), "exact": {"level": str(region.level)}}
    function = "V" if isinstance(region, LevelRegion) else "W"
    yield Fact("region", {"text": str(region), "function": function, **level})


def _margin_record(margin: InputMargin) -> Record:
    """The error in c, as a part of |c|, up to which one input serves; side by side, and over all."""
    sides = [
        {"cells": list(side.cells), **_root_record(side.squared), "witness": witness_record(side.witness, "theta")}
        for side in margin.sides
    ]
    return {**_root_record(margin.squared), "is_exact": margin.is_exact, "sides": sides}


def _root_record(squared: Any) -> Record:
    """``sqrt(squared)``."""
    text = str(squared) if isinstance(squared, Fraction) else real_text(squared)
    return {"relative": float(squared) ** 0.5, "exact": {"relative": f"sqrt({text})"}}


def _ranks_record(check: Theorem4Result) -> Record | None:
    """Independent inputs by cell, by pair of neighbouring cells and at the checked point."""
    if check.partition is None or not rule_of(check.scene).keeps_rows:
        return None
    ranks = input_ranks(check.partition)
    return {
        "cells": [{"cell": cell, "rank": rank} for cell, rank in ranks.cells.items()],
        "sides": [{"cells": list(pair), "rank": rank} for pair, rank in ranks.sides.items()],
        "equilibrium": ranks.equilibrium,
    }


def _cell_record(data: InputCell) -> Record:
    return {
        "cell": data.cell.index,
        "rows": data.state.row_names,
        "nearest": data.nearest.index,
        "second": data.second.index,
        "sign_needed": -data.torque_sign or None,  # of u_j for theta > 0; None where u_j does not act
    }


def _cascade_record(cascade: CascadeLaw) -> Record:
    """How c comes home where theta is taken first, and the sign of the translation along each nearest rim."""
    signs = [{"wheel": wheel.index, "sign": s} for wheel, s in zip(cascade.wheels, cascade.signs, strict=True)]
    gains = list(cascade.fan.gains.values())
    return {"descent": str(cascade.descent), "signs": signs, "gain": Quantity(gains[0] if gains else None)}


def _cells(indices: Sequence[int]) -> str:
    more = ", ..." if len(indices) > MOST_CELLS else ""
    shown = ", ".join(str(index) for index in indices[:MOST_CELLS]) + more
    return f"{len(indices)} cells ({shown})" if len(indices) > 1 else f"cell {shown}"
