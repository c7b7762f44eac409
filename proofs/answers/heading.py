"""What does the heading of a body do that rests, or nearly rests, at the checked point?

The clause on theta speaks of that point.  A body on a table that was measured rests beside it, where forces in the
plane balance and the moment hardly ever does: there it turns all the time, at the rotation rate of least dissipation.
So where it is shown at which place bodies from near the point end, and their rest there is enclosed, its rotation rate
is the answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import cast

from nonsmooth.proofs.answers.answer import WHY_BELOW, Answer, Heading, Results, is_by_rounding
from nonsmooth.proofs.answers.bounds import DIGITS, angle_at_most, at_most, of_length
from nonsmooth.proofs.answers.nearness import nearness, place_of_rest
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult
from nonsmooth.proofs.findings.facts import Fact, Quantity, said
from nonsmooth.proofs.findings.verdicts import Equilibrium, Rotation
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import float_text

# On one set of wheels no open loop brings the heading back.
OF_ROTATION = {
    Rotation.UNSTABLE: Heading.DRIFTS,
    Rotation.NEUTRAL: Heading.KEEPS,
    Rotation.UNDECIDED: Heading.UNDECIDED,
}


def heading_answer(scene: Scene, results: Results) -> Answer:
    """From the clause on theta; where the point itself is no place of rest, from the one beside it."""
    beside = _beside(scene, results)
    if beside is not None:
        return Answer("heading", _of_rates(beside.rates), tuple(_facts_beside(scene, beside.rates)))
    return Answer("heading", OF_ROTATION[_rotation(results).verdict], tuple(_facts(scene, results)))


def _beside(scene: Scene, results: Results) -> EnclosedRest | None:
    """The place of rest beside the point in which bodies end; None where none is enclosed."""
    if results["equilibrium"].verdict is not Equilibrium.FAILS:
        return None
    found = nearness(scene, results)
    return None if found.ends is None else place_of_rest(scene, found.ends)


def _of_rates(rates: tuple[Fraction, Fraction]) -> Heading:
    """Bounds of one rotation rate: zero is never shown by an enclosure."""
    low, high = rates
    return Heading.DRIFTS if low > 0 or high < 0 else Heading.UNDECIDED


def _facts_beside(scene: Scene, rates: tuple[Fraction, Fraction]) -> Iterator[Fact]:
    """The rotation rate at the place of rest."""
    low, high = rates
    fastest = max(-low, high)
    most = angle_at_most(fastest, scene.units)
    if _of_rates(rates) is Heading.DRIFTS:
        words = f"where it ends it turns all the time, at {most}/s"
    else:
        words = f"where it ends it turns at up to {most}/s, if at all"
    yield Fact("largest_rate", Quantity(Fraction(at_most(fastest))), words)
    yield Fact("turn_per_distance", Quantity(None))


def _rotation(results: Results) -> RotationResult:
    return cast("RotationResult", results["rotation"])


def _facts(scene: Scene, results: Results) -> Iterator[Fact]:
    """The largest rate of the drift, and how far the way home may turn the body."""
    found = _rotation(results)
    yield from _drift(scene, found)
    turn = found.rotation_per_distance if found.verdict is Rotation.NEUTRAL else None
    if turn:
        most = angle_at_most(turn, scene.units)
        words = f"the way home turns it by at most {most} for each 1{of_length(scene)} of distance"
        yield Fact("turn_per_distance", Quantity(turn), words)
    else:
        yield Fact("turn_per_distance", Quantity(turn))
    if found.verdict is Rotation.UNDECIDED:
        yield said(_why_undecided(results))


def _drift(scene: Scene, found: RotationResult) -> Iterator[Fact]:
    """The rates at which the body can turn while it rests, or the sentence that it cannot."""
    if found.verdict is Rotation.UNSTABLE and found.spin is not None:
        spin = max(map(abs, found.spin))
        words = f"at rest it turns all the time, at up to {angle_at_most(spin, scene.units)}/s"
        yield Fact("largest_rate", Quantity(Fraction(at_most(spin))), words)
        return
    if found.verdict is not Rotation.UNSTABLE or found.drift is None:
        yield Fact("largest_rate", Quantity(None))
        if found.verdict is Rotation.NEUTRAL:
            yield said("a body at rest does not turn")
        return
    low, high = found.drift.interval
    fastest = max(-low, high)
    most = angle_at_most(fastest, scene.units)
    if low == high:
        rate = math.degrees(float(fastest)) if scene.units.in_degrees else fastest
        words = f"at rest it turns all the time, at {float_text(rate, DIGITS)} {scene.units.angle}/s"
    elif low.sign() > 0 or high.sign() < 0:
        words = f"at rest it turns all the time, at up to {most}/s"
    else:
        words = f"at rest it may turn, at up to {most}/s"
    yield Fact("largest_rate", Quantity(fastest), words)


def _why_undecided(results: Results) -> str:
    if results["equilibrium"].verdict is Equilibrium.FAILS:
        return "the body does not stay at the point; --at auto asks about a place where it rests"
    if is_by_rounding(results, "equilibrium", "rotation"):
        return f"rounding decides{WHY_BELOW}"
    return f"whether a body at rest turns is not decided{WHY_BELOW}"
