"""What the feedback law still does with a pose that is late and wrong, where the scene says how much."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.loop_bounds import BY_CELLS, UltimateBound, ultimate_bound
from nonsmooth.proofs.facts import Fact, Quantity
from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.symbolic.loop_errors import LoopErrors
from nonsmooth.symbolic.number_text import lower_text, upper_text
from nonsmooth.symbolic.scene import Scene

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.facts import AnyFeedback


def late_and_wrong(found: AnyFeedback, errors: LoopErrors, scene: Scene) -> Fact:
    """The ultimate bound of the loop at gain k = 1, in the scene's unit of length, or why there is none."""
    if isinstance(found, FeedbackResult):
        bound = UltimateBound(Certainty.UNDECIDED, BY_CELLS)
    else:
        bound = ultimate_bound(found, errors)
    length = scene.check.length
    within, start = (None if value is None else value * length for value in (bound.radius, bound.level))
    record = {
        "delay": Quantity(errors.delay),
        "position_error": Quantity(errors.position),
        "heading_error": float(errors.heading) * math.pi,
        "verdict": str(bound.verdict),
        "reason": bound.reason or None,
        "ends_within": Quantity(within),
        "from_within": Quantity(start),
        "largest_delay": Quantity(bound.largest_delay),
    }
    return Fact("loop", record, _words(bound, within, start))


def _words(bound: UltimateBound, within: Fraction | None, start: Fraction | None) -> str:
    if bound.verdict is Certainty.UNDECIDED:
        return f"with a pose as late and wrong as [feedback] says: undecided, {bound.reason}"
    where = "near the point" if start is None else f"from errors below {lower_text(start, 4)}"
    ends = f"within {upper_text(within, 4)}" if within else "at zero"
    return f"with a pose as late and wrong as [feedback] says, and gain k = 1, {where} the error ends {ends}"
