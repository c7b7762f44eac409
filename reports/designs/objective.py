"""What a design is judged by: the exact answers to a check of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answer import Answer, Position
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.inertia import inertia_answer
from nonsmooth.proofs.robust.decide import certified_factor
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.symbolic.mechanics.contact_set import TipsError, standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

HEADINGS = 36  # in a full turn, as of ``simulate --headings 36``
UNITS = 3_000_000  # of exact arithmetic for one candidate: a few seconds
UNMET = 1e6  # what a requirement that is not met costs
OPEN = 0.5  # of that, where the answer is undecided


@dataclass(frozen=True)
class Evaluation:
    """One candidate.

    Attributes:
        answers: position, heading and pose; empty where the scene is refused.
        unmet: names of requirements that do not hold.
        value: of the objective, larger is better; None where the requirements are not met, or it is not known.
        cost: what the search makes small.
        why_not: why the scene is refused, else empty.
        is_refuted: whether it is proved that the requirements are not met.
    """

    answers: tuple[Answer, ...]
    unmet: tuple[str, ...]
    value: float | None
    cost: float
    why_not: str = ""
    is_refuted: bool = False


Objective = Callable[[Check, Sequence[Answer]], float | None]


def _rate(check: Check, answers: Sequence[Answer]) -> float | None:
    """How fast a body comes home: length per time where it arrives, else the exponential rate (1/time).

    Where it comes near, at least the part of its way that is certified over the time that it takes.
    """
    position = answers[0].numbers
    if answers[0].verdict is Position.COMES_NEAR:
        return float((position["within"] - position["ends_within"]) / position["after"])
    seconds = position.get("seconds_per_distance")
    if seconds is not None:
        return 1 / float(seconds)
    rate = position.get("rate")
    return None if rate is None else float(rate)


def _held_rate(check: Check, answers: Sequence[Answer]) -> float | None:
    """Kappa: how fast feedback holds the pose, per unit of gain."""
    rate = answers[2].numbers.get("rate")
    return None if rate is None else float(rate)


def _margin(check: Check, answers: Sequence[Answer]) -> float | None:
    """The part of the distance to the point by which feedback may misjudge the position."""
    error = answers[2].numbers.get("position_error")
    return None if error is None else float(error)


def _basin(check: Check, answers: Sequence[Answer]) -> float | None:
    """Radius of the disc of starts that come home."""
    within = answers[0].numbers.get("within")
    return None if within is None else float(within)


def _tolerance(check: Check, answers: Sequence[Answer]) -> float | None:
    """The multiple of the scene's tolerances that is certified."""
    factor = certified_factor(check.scene)
    return float(factor) if factor else None


def _settling(check: Check, answers: Sequence[Answer]) -> float | None:
    """One over the time after which bodies with inertia keep within the accuracy of where they end (1/time): simulated.

    It is that of the ring of starts of a check, half the half-width of the checked square away.
    """
    found = inertia_answer(check.scene)
    after = None if found is None else found.numbers.get("settles_after")
    return 1 / float(after) if after else None


def _returning(check: Check, answers: Sequence[Answer]) -> float | None:
    """The widest arc of headings, in degrees, from which bodies at the checked point return to one of them: sampled."""
    from nonsmooth.reports.simulations.heading_maps import from_headings

    x, y = check.scene.check.place
    arcs = from_headings(check.scene, (x, y), HEADINGS).returning
    return max((math.degrees(arc.last - arc.first) for arc in arcs), default=0.0)


OBJECTIVES: dict[str, Objective] = {
    "rate": _rate,
    "gain": _held_rate,
    "margin": _margin,
    "basin": _basin,
    "tolerance": _tolerance,
    "settling": _settling,
    "heading": _returning,
}


def evaluate(scene: Scene, required: Sequence[str], objective: Objective) -> Evaluation:
    """Check a candidate and judge it."""
    try:
        with work_limit(scene.field, UNITS):
            check = check_theorem4(standing(scene))
            answers = answers_of(check)
    except TipsError as error:
        return Evaluation((), tuple(required), None, UNMET * (len(required) + 1), str(error), is_refuted=True)
    except (RefusalError, SceneError, WorkLimitError) as error:
        return Evaluation((), tuple(required), None, UNMET * (len(required) + 1), str(error))
    bad = [answer for answer in answers if answer.name in required and answer.exit_status]
    if bad:
        cost = sum(UNMET * (OPEN if answer.exit_status == 3 else 1) for answer in bad)
        unmet, refuted = tuple(answer.name for answer in bad), any(answer.exit_status == 1 for answer in bad)
        return Evaluation(answers, unmet, None, cost + _distance(check, answers), is_refuted=refuted)
    value = objective(check, answers)
    return Evaluation(answers, (), value, 0.0 if value is None else -value)


def _distance(check: Check, answers: Sequence[Answer]) -> float:
    """What guides the search where requirements are not met: how far V is from falling, and how fast the body turns."""
    rate, turns = getattr(check.results["translation"], "worst_rate", None), answers[1].numbers.get("largest_rate")
    falling = 1.0 if rate is None else 0.5 + math.atan(float(rate)) / math.pi
    return falling + (1.0 if turns is None else math.atan(float(turns)) / math.pi)
