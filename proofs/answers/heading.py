"""What does the heading of a body do that rests, or nearly rests, at the checked point?

The clause on theta speaks of that point.  A body on a table that was measured rests beside it, where forces in the
plane balance and the moment hardly ever does: there it turns all the time, at the rotation rate of least dissipation.
So where it is shown at which place bodies from near the point end, and their rest there is enclosed, its rotation rate
is the answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from typing import TYPE_CHECKING, cast

from flint import arb

from nonsmooth.proofs.answers.answer import (
    DIGITS,
    WHY_BELOW,
    Answer,
    Heading,
    Position,
    Results,
    angle_at_most,
    at_most,
    is_by_rounding,
)
from nonsmooth.proofs.answers.nearness import nearness, place_of_rest
from nonsmooth.proofs.answers.position import OF_PLACE
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.at_point import EveryLoadTranslation
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity, Rotation, said
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import float_text

if TYPE_CHECKING:
    from nonsmooth.proofs.headings.at_point import EquilibriumHeadings, OpenHeadings, RestInterval, SampledRest


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
        return Answer("heading", _of_rates(beside[0]), tuple(_facts_beside(scene, *beside)))
    return Answer("heading", OF_ROTATION[_rotation(results).verdict], tuple(_facts(scene, results)))


def _beside(scene: Scene, results: Results) -> tuple[tuple[Fraction, Fraction], str] | None:
    """The rotation rate at a place of rest beside the point, and what bodies do there; None where none is enclosed."""
    if results["equilibrium"].verdict is not Equilibrium.FAILS:
        return None
    near = nearness(scene, results)
    if near.turning is not None:
        return near.turning.rates, "about that place it turns"
    place = None if near.ends is None else place_of_rest(scene, near.ends)
    return None if place is None else (place.rates, "where it ends it turns")


def _of_rates(rates: tuple[Fraction, Fraction]) -> Heading:
    """Bounds of one rotation rate: zero is never shown by an enclosure."""
    low, high = rates
    return Heading.DRIFTS if low > 0 or high < 0 else Heading.UNDECIDED


def _facts_beside(scene: Scene, rates: tuple[Fraction, Fraction], turns: str) -> Iterator[Fact]:
    """The rotation rate at the place of rest."""
    low, high = rates
    fastest = max(-low, high)
    most = angle_at_most(fastest, scene.units)
    if _of_rates(rates) is Heading.DRIFTS:
        words = f"{turns} all the time, at {most}/s"
    else:
        words = f"{turns} at up to {most}/s, if at all"
    yield Fact("largest_rate", Quantity(Fraction(at_most(fastest))), words)
    yield Fact("turn_per_distance", Quantity(None))


def _rotation(results: Results) -> RotationResult:
    return cast("RotationResult", results["rotation"])


def _facts(scene: Scene, results: Results) -> Iterator[Fact]:
    """The largest rate of the drift, and how far the way home may turn the body."""
    rotation = _rotation(results)
    yield from _drift(scene, rotation)
    turn = rotation.rotation_per_distance if rotation.verdict is Rotation.NEUTRAL else None
    if turn:
        most = angle_at_most(turn, scene.units)
        words = f"the way home turns it by at most {most} for each 1{scene.units.after_length} of distance"
        yield Fact("turn_per_distance", Quantity(turn), words)
    else:
        yield Fact("turn_per_distance", Quantity(turn))
    if rotation.verdict is Rotation.UNDECIDED:
        yield said(_why_undecided(results))


def _drift(scene: Scene, rotation: RotationResult) -> Iterator[Fact]:
    """The rates at which the body can turn while it rests, or the sentence that it cannot."""
    if rotation.verdict is Rotation.UNSTABLE and rotation.spin is not None:
        spin = max(map(abs, rotation.spin))
        words = f"at rest it turns all the time, at up to {angle_at_most(spin, scene.units)}/s"
        yield Fact("largest_rate", Quantity(Fraction(at_most(spin))), words)
        return
    if rotation.verdict is not Rotation.UNSTABLE or rotation.drift is None:
        yield Fact("largest_rate", Quantity(None))
        if rotation.verdict is Rotation.NEUTRAL:
            yield said("a body at rest does not turn")
        return
    low, high = rotation.drift.interval
    fastest = max(-low, high)
    most = angle_at_most(fastest, scene.units)
    if low == high:
        rate = math.degrees(float(fastest)) if scene.units.in_degrees else fastest
        words = f"at rest it turns all the time, at {float_text(rate, DIGITS)} {scene.units.angle}/s"
    elif rotation.turns_on:
        words = f"at rest it turns all the time, at up to {most}/s"
    else:
        words = f"at rest it may turn, at up to {most}/s"
    yield Fact("largest_rate", Quantity(fastest), words)


def _why_undecided(results: Results) -> str:
    if results["equilibrium"].verdict is Equilibrium.FAILS:
        return "the body does not stay at the point; --at auto asks about a place where it rests"
    if is_by_rounding(results, "equilibrium", "rotation"):
        return f"rounding decides{WHY_BELOW}"
    if _rotation(results).drift is not None and not isinstance(results["translation"], EveryLoadTranslation):
        return f"a body at rest does not turn, but how far it turns on its way is not decided{WHY_BELOW}"
    return f"whether a body at rest turns is not decided{WHY_BELOW}"


# ---- at which headings does a body with an outline rest ------------------------------------------
#
# About the checked point, and which of them attract?
#
# A list for people of what :mod:`nonsmooth.proofs.headings` proves, and of what is only sampled.


class HeadingKind(StrEnum):
    """Kinds of headings of rest."""

    INTERVAL = "interval"  # rest at every heading between two
    TURNING = "turning"  # the centre of mass rests, the body turns through the interval
    ISOLATED = "isolated"  # rest at one heading, with a wheel under the edge


@dataclass(frozen=True)
class HeadingOfRest:
    """One entry.

    Attributes:
        kind: see :class:`HeadingKind`.
        low: lower end of an interval, in radians from the checked heading; None of an isolated heading.
        high: upper end.
        heading: an isolated heading, or one at which a sampled interval was seen; else None.
        at: the centre of mass.
        wheels: numbers of those well under the body.
        edge: numbers of those under the edge: at an isolated heading, or at the ends of an interval.
        position: where a body goes that starts near it, on these wheels.
        verdict: what its heading does.
        proved: whether rest and verdicts are proved; elsewhere they are sampled.
        reason: why something is not decided; empty where all is.
    """

    kind: HeadingKind
    low: arb | None
    high: arb | None
    heading: float | None
    at: tuple[Number | float, Number | float]
    wheels: tuple[int, ...]
    edge: tuple[int, ...]
    position: Position
    verdict: Heading
    proved: bool
    reason: str = ""

    @property
    def is_every_heading(self) -> bool:
        """Whether an interval is all headings: no wheel comes under the edge."""
        return self.low is not None and not self.edge

    @property
    def rests(self) -> bool:
        """Whether the body may stand still there; otherwise it turns on the spot."""
        return self.kind is not HeadingKind.TURNING

    @property
    def attracts(self) -> bool:
        """Whether bodies nearby come to rest there."""
        return self.position is Position.COMES_HOME and self.verdict is not Heading.DRIFTS


@dataclass(frozen=True)
class HeadingsOfRest:
    """All entries: those that attract first.

    Attributes:
        found: the entries.
        undecided: headings at the checked point of which nothing is proved; at all others the body does not rest there.
        reach: half-width of the square of places about the checked point that was searched; None: that point alone.
        left_out: points of rest that were seen and not decided, for there were too many.
        can_search: whether the surroundings of the point could be searched.
        units: those in which headings are read.
    """

    found: tuple[HeadingOfRest, ...]
    undecided: tuple[OpenHeadings, ...]
    reach: float | None
    left_out: int
    can_search: bool = False
    units: Units = field(default_factory=Units)


def headings_of_rest(scene: Scene, *, around: bool = False) -> HeadingsOfRest | None:
    """The headings at which the body of a scene rests, verified; None where the heading does not matter.

    Args:
        scene: with the body at the checked pose.
        around: search around the checked point too.
    """
    from nonsmooth.proofs.headings.at_point import can_search, equilibrium_headings

    headings = equilibrium_headings(scene, around=around)
    if headings is None:
        return None
    entries = sorted(_entries(headings), key=_rank)
    return HeadingsOfRest(
        tuple(entries), headings.undecided, headings.reach, headings.left_out, can_search(scene), scene.units
    )


def _entries(headings: EquilibriumHeadings) -> Iterator[HeadingOfRest]:
    yield from (_of_interval(interval) for interval in headings.intervals)
    yield from (_of_sample(sample) for sample in headings.sampled)


def _rank(entry: HeadingOfRest) -> tuple[bool, bool, bool, bool, float, tuple[int, ...]]:
    start = entry.heading if entry.low is None else entry.low
    where = 0.0 if start is None else float(start)
    turns, single = entry.kind is HeadingKind.TURNING, entry.kind is HeadingKind.ISOLATED
    return not entry.attracts, turns, not entry.proved, not single, where, entry.wheels


def _of_interval(interval: RestInterval) -> HeadingOfRest:
    from nonsmooth.proofs.headings.stay import Stays

    edge = tuple(sorted({wheel for end in interval.ends for wheel in end}))
    stay, gap = interval.stay, interval.gap
    kind = HeadingKind.INTERVAL if stay.kind is Stays.RESTS else HeadingKind.TURNING
    position, verdict = OF_PLACE[stay.translation], OF_ROTATION[stay.rotation]
    at, wheels = interval.scene.check.equilibrium, interval.wheels or ()
    return HeadingOfRest(kind, gap.low, gap.high, None, at, wheels, edge, position, verdict, proved=True)


def _of_sample(sample: SampledRest) -> HeadingOfRest:
    return HeadingOfRest(
        HeadingKind.ISOLATED if sample.edge else HeadingKind.INTERVAL,
        None,
        None,
        sample.theta,
        sample.place,
        sample.wheels,
        sample.edge,
        Position.UNDECIDED,
        Heading.UNDECIDED,
        proved=False,
        reason=sample.reason,
    )
