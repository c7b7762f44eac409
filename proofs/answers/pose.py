"""Can feedback hold position and heading together at the checked point?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, cast

from nonsmooth.proofs.answers.answer import WHY_BELOW, Answer, Pose, Results, half_life
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.clauses.feedback.loop_bounds import (
    BY_CELLS,
    UltimateBound,
    certified_error,
    limited_speed,
    ultimate_bound,
    wheel_speed,
)
from nonsmooth.proofs.findings import Certainty, Fact, Feedback, Quantity, said
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Scene
from nonsmooth.symbolic.numbers.number_text import float_text, lower_text, upper_text
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback

NEARBY = "from close by (how near is not known)"
DIGITS = 4  # of an error
ROOTS = 10**9  # roots are rounded down to its parts


def pose_answer(scene: Scene, results: Results) -> Answer:
    """From the clause on feedback; where Theorem 4 asks nothing of it, from the same decision beyond the theorem."""
    feedback = cast("AnyFeedback", results["feedback"]).holding
    return Answer("pose", _verdict(feedback), _facts(feedback, scene))


def _verdict(feedback: AnyFeedback) -> Pose:
    if feedback.verdict is Feedback.STABILIZABLE:
        return Pose.CAN_BE_HELD
    return Pose.UNDECIDED if feedback.obstruction is None else Pose.CANNOT_BE_HELD


def _facts(feedback: AnyFeedback, scene: Scene) -> Iterator[Fact]:
    """What the law must know, how fast it is, and how much it may misjudge."""
    held = feedback.verdict is Feedback.STABILIZABLE
    yield Fact("law", feedback.law)
    yield Fact("must_know", list(feedback.must_know) if held else None, _knowing(feedback) if held else "")
    yield from _rate(feedback, scene)
    yield _wheel_speed(feedback, scene)
    error = feedback.position_error if held else None
    yield Fact("position_error", error, "" if error is None else _misjudging(error))
    if not held:
        yield said(_why_not(feedback))
    if scene.loop_errors is not None:
        yield late_and_wrong(feedback, scene.loop_errors, scene)


def _knowing(feedback: AnyFeedback) -> str:
    *first, last = feedback.must_know
    return f"by feedback that knows {', '.join(first)} and {last}"


def _misjudging(error: float) -> str:
    if not error:
        return "at some borders of cells it must not misjudge the position at all"
    return f"it may misjudge the position by {float_text(error, 4)} of the distance"


def _rate(feedback: AnyFeedback, scene: Scene) -> Iterator[Fact]:
    """``V' <= -2 k kappa V``, so the error ``sqrt(V)`` shrinks like ``exp(-k kappa t)``; slower where speeds end."""
    kappa = feedback.certified_kappa
    speed = _speed(feedback, scene)
    if kappa is None:
        yield from (Fact("rate", Quantity(None)), Fact("speed", Quantity(None)))
        return
    words = f"with gain k the error halves at least every {half_life(kappa)}/k s, {_from_where(feedback, scene)}"
    yield Fact("rate", Quantity(kappa), words)
    unit = scene.units.speed or "per s"
    how = "at a speed that is not known" if speed is None else f"at {lower_text(speed, 4)} {unit} or faster"
    slower = f"farther away, where speeds are limited, it falls {how}" if scene.speed_limits else ""
    yield Fact("speed", Quantity(speed), slower)


def _from_where(feedback: AnyFeedback, scene: Scene) -> str:
    """From which errors the rate is certified: those below the root of a level of V, where one is known.

    Of imposed twists that is the level that fits into the square in which speeds impose them.
    """
    if not isinstance(feedback, FeedbackResult):
        reach = feedback.reach
        return NEARBY if reach is None else f"from errors below {lower_text(reach, DIGITS)}{scene.units.after_length}"
    level = feedback.rate_level
    if level is None:
        return NEARBY
    text = f"from errors below {_root_text(level, scene)}"
    whole = feedback.region.level if isinstance(feedback.region, LevelRegion) else level
    return (
        text if whole == level else f"{text} (from those below {_root_text(whole, scene)} it falls, how fast is open)"
    )


def _root_text(level: Fraction, scene: Scene) -> str:
    """The error sqrt(V) on a level of V, rounded down."""
    root = Fraction(math.isqrt(math.floor(level * ROOTS**2)), ROOTS)
    return f"{lower_text(root, DIGITS)}{scene.units.after_length}"


def _speed(feedback: AnyFeedback, scene: Scene) -> Fraction | None:
    """With which sqrt(V) falls at least where speeds are limited; None without limits, and where it is not known."""
    if not scene.speed_limits:
        return None
    if isinstance(feedback, FeedbackResult):
        return None if feedback.limited is None else feedback.limited.speed
    return limited_speed(feedback, scene)


def _wheel_speed(feedback: AnyFeedback, scene: Scene) -> Fact:
    """The speed of the fastest rim at gain k = 1 for each unit of the error sqrt(V)."""
    bound = wheel_speed(feedback, scene) if feedback.verdict is Feedback.STABILIZABLE else None
    error = certified_error(feedback)
    if bound is None or (bound.by_level and error is None):
        return Fact("wheel_speed", Quantity(None))
    fastest = bound.by_root + bound.by_level * (error or 0)
    units, heading = scene.units, feedback.lyapunov.length
    speed = f"{upper_text(fastest, 4)} k{units.after_speed}"
    words = f"its wheels run at up to {speed} for each {units.length or 'unit'} of error"
    if heading is None:
        words += f", the square root of {feedback.lyapunov}"
    elif heading != 1:
        words += f" (a radian counts as {float_text(heading, 4)}{units.after_length})"
    return Fact("wheel_speed", float(fastest), words)


def _why_not(feedback: AnyFeedback) -> str:
    if feedback.verdict is Feedback.NOT_APPLICABLE:
        return f"not examined: {feedback.reason}"
    if BY_ROUNDING in feedback.reason:
        return f"rounding decides{WHY_BELOW}"
    if feedback.obstruction is None:
        return f"no law was found, and none is excluded{WHY_BELOW}"
    turns = not any(feedback.obstruction[:2])
    what = "no speeds turn the body" if turns else "the wheels cannot push it in every direction"
    return f"{what} near the point, so no law of the pose alone holds it"


# ---- a pose that is late and wrong ---------------------------------------------------------------


def late_and_wrong(feedback: AnyFeedback, errors: LoopErrors, scene: Scene) -> Fact:
    """The ultimate bound of the loop at gain k = 1, in the scene's unit of length, or why there is none."""
    if isinstance(feedback, FeedbackResult):
        bound = UltimateBound(Certainty.UNDECIDED, BY_CELLS)
    else:
        bound = ultimate_bound(feedback, errors)
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
        "gain": Quantity(bound.gain),
    }
    return Fact("loop", record, _words(bound, within, start, scene.units.after_length))


def _words(bound: UltimateBound, within: Fraction | None, start: Fraction | None, unit: str) -> str:
    if bound.verdict is Certainty.UNDECIDED:
        serves = "no gain k is known that serves"
        if bound.gain is not None:
            serves = f"take a gain k of at most {lower_text(bound.gain, 2)}: with these it is certified"
        return f"with a pose as late and wrong as [feedback] says: undecided, {bound.reason}; {serves}"
    where = "near the point" if start is None else f"from errors below {lower_text(start, 4)}{unit}"
    ends = f"within {upper_text(within, 4)}{unit}" if within else "at zero"
    return f"with a pose as late and wrong as [feedback] says, and gain k = 1, {where} the error ends {ends}"
