"""What the feedback clause says of rules that minimize the dissipation: imposed twists, rate and samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, in_scene, rim_speeds
from nonsmooth.proofs.facts import Fact, Quantity, Record, said
from nonsmooth.symbolic.number_text import float_text, lower_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import in_own_length

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampled_feedback import LoopSample
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback


def driven_facts(feedback: DrivenFeedback, scene: Scene) -> Iterator[Fact]:
    """The cones of the law, its certified rate, and what was sampled."""
    own = in_own_length(scene.recentred())
    yield Fact(
        "cones", [_cone_record(cone, own, feedback) for cone in feedback.cones], _twists(feedback), explained=True
    )
    if feedback.certified_kappa is not None:
        where = "near c*" if feedback.reach is None else f"where |x|, |y| < {lower_text(feedback.reach, 3)}"
        yield said(f"{where}: V' <= -{lower_text(2 * feedback.certified_kappa, 4)} k V (certified)", explained=True)
        yield said(f"V = {feedback.lyapunov}", explained=True)
    yield Fact("sampled", [_sample_record(sample) for sample in feedback.samples])
    for sample in feedback.samples:
        if sample.worst_rate is not None:
            yield said(
                f"{sample.law} (sampled): largest V'/V found {sample.rate_text} k over {sample.states} states",
                explained=True,
            )
        if sample.not_certified:
            yield said(f"{sample.law} (sampled): largest V'/V not certified: {sample.not_certified}", explained=True)


def _twists(feedback: DrivenFeedback) -> str:
    """The twists of the law, where they fit a line."""
    if len(feedback.cones) > 1:
        return f"xi_l: by direction of c, {len(feedback.cones)} cones; the report and --json list them"
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


def _cone_record(cone: LawCone, own: Scene, feedback: DrivenFeedback) -> Record:
    """The twists of the law with the speeds that impose them, for a cone of directions of c."""
    twists = [
        {
            "twist": Quantity(in_scene(imposed.twist, feedback.length)),
            "speeds": [float(speed) for speed in rim_speeds(own, imposed)],
        }
        for imposed in cone.twists
    ]
    if cone.rays is None:
        return {"from": None, "to": None, "twists": twists}
    return {"from": Quantity(cone.rays[0]), "to": Quantity(cone.rays[1]), "twists": twists}
