"""Clause 4 of Theorem 4 as the check asks it, and what it says beside its verdict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause, witness_record
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, InputMargin, decide_feedback
from nonsmooth.proofs.clauses.feedback.control_fields import InputCell, input_ranks, obstruction_text
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion, LimitedRate
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Fact, Feedback, Quantity, Record, Theorem4, said
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.number_text import decimal_text, float_text, lower_text, real_text

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import LoopSample
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
    from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw
    from nonsmooth.proofs.clauses.feedback.driven_law import LawCone


# ---- what the feedback clause says beside verdict and reason -------------------------------------
#
# Law, V, rate, region, limits, margin, inputs, samples.
#
# Every key stands in every record; of laws that do not have a thing it is empty.


# Twists that speeds impose are loaded only under rules that ask for them: they take a tenth of a second.
AnyFeedback: TypeAlias = "FeedbackResult | DrivenFeedback"

LIMITED = (
    "limited speeds: where a wheel would exceed its limit all are scaled alike, which keeps the paths of the law "
    "and only slows them"
)
UNKNOWN_SPEED = "how fast the limited law is, is not known"
MOST_CELLS = 12  # that are named in a sentence


def feedback_facts(feedback: AnyFeedback, check: CheckedArray) -> Iterator[Fact]:
    """All of it, in the order in which it is shown."""
    scene, rows = check.scene, feedback if isinstance(feedback, FeedbackResult) else None
    yield Fact("law", feedback.law, feedback.law or "", explained=True)
    yield from _imposed_twists(feedback, scene)
    kappa, reach = feedback.certified_kappa, feedback.reach
    yield Fact("rate", None if kappa is None else Quantity(scene.field(2 * kappa)))
    yield Fact("rate_reach", None if kappa is None else Quantity(reach))
    if rows is not None and kappa is not None:
        yield from _rate_words(rows, kappa, "near c*" if reach is None else f"where |c| <= {decimal_text(reach, 3)}")
    yield from _limits(feedback, scene)
    yield Fact("lyapunov", _lyapunov_record(feedback, scene) if feedback.has_lyapunov else None)
    yield from _region(rows)
    yield Fact("none_serves", None if rows is None else rows.none_serves)
    margin = None if rows is None else rows.margin
    yield Fact("margin", margin and _margin_record(margin), str(margin or ""), explained=True)
    yield Fact("ranks", _ranks_record(check))
    fails = [] if rows is None else list(rows.printed_sign_fails)
    words = f"the paper's u_j = -k theta has the wrong sign in {_cells(fails)}" if fails else ""
    yield Fact("printed_sign_fails", fails, words, explained=True)
    yield Fact("cells", [] if rows is None else [_cell_record(data) for data in rows.cells])
    cascade = None if rows is None else rows.cascade
    yield Fact("cascade", cascade and _cascade_record(cascade))
    yield Fact("witness", witness_record(feedback.witness, "theta"))
    normal = feedback.obstruction
    yield Fact("obstruction", None if normal is None else {"normal": Quantity(normal)})
    rank, missing = check.authority.rank, check.authority.missing
    record = {"rank": rank, "missing": Quantity(missing)}
    yield Fact("authority", record, f"torque authority: rank {rank} of 3", explained=True)


def _rate_words(feedback: AnyFeedback, kappa: Fraction, where: str) -> Iterator[Fact]:
    """``V' <= -rate k V``, and where."""
    yield said(f"{where}: V' <= -{lower_text(2 * kappa, 4)} k V (certified)", explained=True)
    yield said(f"V = {feedback.lyapunov}", explained=True)


def _limits(feedback: AnyFeedback, scene: Scene) -> Iterator[Fact]:
    """What limits of speed leave of the rate; nothing where no wheel has one."""
    limited: LimitedRate | None = getattr(feedback, "limited", None)
    if scene.speed_limits and feedback.law is not None:
        yield said(LIMITED, explained=True)
        words = [UNKNOWN_SPEED] if limited is None else _limit_words(limited, feedback, scene)
        yield from (said(sentence, explained=True) for sentence in words)
    if limited is None:
        yield Fact("limited")
    else:
        yield Fact("limited", {key: Quantity(scene.field(value)) for key, value in vars(limited).items()})


def _limit_words(limited: LimitedRate, feedback: AnyFeedback, scene: Scene) -> list[str]:
    free, held, speed, level = (lower_text(value, 4) for value in vars(limited).values())
    unit = scene.units.after_speed
    gain = "" if feedback.lyapunov.length is not None else ", k >= 1"
    return [
        f"where V < {level}: no wheel is at its limit while k^2 V <= {free}{gain} (certified)",
        f"the rate holds while k^2 V <= {held}; beyond, sqrt(V) falls at {speed}{unit} or faster (certified)",
    ]


def _lyapunov_record(feedback: AnyFeedback, scene: Scene) -> Record:
    """``V = c^T P c + w theta^2`` of the law."""
    (e, f), w = feedback.lyapunov.shape, feedback.lyapunov.weight
    exact = scene.field
    return {"P": Quantity(((exact(1 + e), exact(f)), (exact(f), exact(1 - e)))), "w": Quantity(exact(w))}


# ---- rules that keep rows ----------------------------------------------------------------


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


def _ranks_record(check: CheckedArray) -> Record | None:
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


# ---- rules that minimize D ---------------------------------------------------------------


def _imposed_twists(feedback: AnyFeedback, scene: Scene) -> Iterator[Fact]:
    """The cones of the law by imposed twists, its certified rate, and what was sampled."""
    if isinstance(feedback, FeedbackResult):
        yield from (Fact("cones", []), Fact("sampled", []))
        return
    scaled = in_own_length(scene.recentred())
    cones = [_cone_record(cone, scaled, feedback.length) for cone in feedback.cones]
    yield Fact("cones", cones, _twists(feedback), explained=True)
    if feedback.certified_kappa is not None:
        reach = feedback.reach
        where = "near c*" if reach is None else f"where |x|, |y| < {lower_text(reach, 3)}"
        yield from _rate_words(feedback, feedback.certified_kappa, where)
    yield Fact("sampled", [_sample_record(sample) for sample in feedback.samples])
    for sample in feedback.samples:
        rate = f"largest V'/V found {sample.rate_text} k over {sample.states} states"
        if sample.worst_rate is not None:
            yield said(f"{sample.law} (sampled): {rate}", explained=True)
        if sample.not_certified:
            yield said(f"{sample.law} (sampled): largest V'/V not certified: {sample.not_certified}", explained=True)


def _twists(feedback: DrivenFeedback) -> str:
    """The twists of the law, where they fit a line."""
    if len(feedback.cones) > 1:
        return f"xi_l: by direction of c, {len(feedback.cones)} cones; the report and --json list them"
    from nonsmooth.proofs.clauses.feedback.driven_law import in_scene

    vectors = [in_scene(twist, feedback.length) for cone in feedback.cones for twist in cone.vectors]
    twists = [", ".join(float_text(x, 4) for x in twist) for twist in vectors]
    return "xi_l = " + ", ".join(f"({twist})" for twist in twists) if twists else ""


def _sample_record(sample: LoopSample) -> Record:
    return {
        "law": str(sample.law),
        "states": sample.states,
        "worst_rate": sample.worst_rate,
        "worst_state": None if sample.worst_state is None else [float(entry) for entry in sample.worst_state],
        "fails": sample.fails,
        "not_certified": sample.not_certified or None,
    }


def _cone_record(cone: LawCone, scaled: Scene, length: Fraction) -> Record:
    """The twists of the law with the speeds that impose them, for a cone of directions of c."""
    from nonsmooth.proofs.clauses.feedback.driven_law import in_scene, rim_speeds

    start, end = (None, None) if cone.rays is None else map(Quantity, cone.rays)
    twists = [
        {"twist": Quantity(in_scene(imposed.twist, length)), "speeds": [float(u) for u in rim_speeds(scaled, imposed)]}
        for imposed in cone.twists
    ]
    return {"from": start, "to": end, "twists": twists}


# ---- the clause ----------------------------------------------------------------------------------


class FeedbackClause(Clause[AnyFeedback]):
    """Whether a discontinuous law makes a Lyapunov function of (c, theta) decrease."""

    name = "feedback"

    def decide(self, work: Workspace) -> AnyFeedback:
        """Through the control vector fields where the rule keeps rows, else through the twists that speeds impose.

        Two laws are sampled where the clause stays undecided, or when nothing is to be left out.
        """
        if work.rule.keeps_rows and work.partition is not None:
            feedback = decide_feedback(work.partition)
            # what rounding decides of these counts for the clause; and what is shown beside the verdicts is built while
            # the field holds few square roots: over many, numbers are written as balls
            if work.sample or work.scene.field.measured:
                _ = feedback.margin, feedback.region, feedback.limited
            if feedback.verdict is Feedback.NOT_APPLICABLE:
                work.skip("feedback search", 1, feedback.reason)
            return feedback
        return _driven(work)

    def undecided(self, result: AnyFeedback, reason: str) -> AnyFeedback:
        """Neither a law nor none, nor one beyond the theorem; where the clause does not apply, it still does not."""
        if result.verdict is Feedback.NOT_APPLICABLE:
            beyond = getattr(result, "beyond", None)
            return result if beyond is None else replace(result, beyond=beyond.undecided(reason))
        return result.undecided(reason)

    def settles(self, result: AnyFeedback) -> tuple[Theorem4, str] | None:
        """A plane of twists that no input leaves refutes every static feedback."""
        if result.obstruction is not None:
            return Theorem4.FAILS, obstruction_text(result.obstruction)
        return None

    def is_open(self, result: AnyFeedback) -> bool:
        """No certificate is no refutation."""
        return result.verdict in (Feedback.UNDECIDED, Feedback.NO_CERTIFICATE)

    def applies(self, result: AnyFeedback) -> bool:
        """The theorem's law needs wheels that grip along their rims."""
        return result.verdict is not Feedback.NOT_APPLICABLE

    def facts(self, result: AnyFeedback, check: CheckedArray) -> Iterator[Fact]:
        """Law, V, certified rate, region, margin, what was sampled, and the torque authority.

        Where the theorem asks nothing of feedback, they are about the law that holds the pose all the same.
        """
        if result.holding is not result:
            yield said(f"beyond the theorem: {result.holding.reason}")
        yield from feedback_facts(result.holding, check)


def _driven(work: Workspace) -> DrivenFeedback:
    """About the checked point, and about a place of rest that only rounding tells from it."""
    from nonsmooth.proofs.clauses.feedback.by_friction import (
        BESIDE_OPEN,
        decide_driven_feedback,
        decided_around,
        with_samples,
    )

    at_point = decide_driven_feedback(work.scene)
    distance = getattr(work.earlier["equilibrium"], "rounding_distance", None)
    feedback = at_point if distance is None else decided_around(at_point, distance)
    if feedback.holding.reason == BESIDE_OPEN:
        work.by_rounding.add(FeedbackClause.name)
    if feedback.verdict is Feedback.NOT_APPLICABLE or work.leaves_loads_open:
        return feedback
    if feedback.verdict is Feedback.UNDECIDED or not work.prune:
        return with_samples(feedback, work.scene)
    work.skip("samples of the closed loop", 2, "the feedback clause is decided exactly")
    return feedback
