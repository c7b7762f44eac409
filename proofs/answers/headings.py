"""At which headings does a body with an outline rest, about the checked point, and which of them attract?

A list for people of what :mod:`nonsmooth.proofs.headings` proves, and of what is only sampled.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from flint import arb

from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.proofs.answers.heading import OF_ROTATION
from nonsmooth.proofs.answers.position import OF_PLACE
from nonsmooth.proofs.headings.search import can_search, equilibrium_headings
from nonsmooth.proofs.headings.stay import Stays
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number import Number

if TYPE_CHECKING:
    from nonsmooth.proofs.headings.at_point import EquilibriumHeadings, OpenHeadings, RestInterval, SampledRest


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
    found = equilibrium_headings(scene, around=around)
    if found is None:
        return None
    entries = sorted(_entries(found), key=_rank)
    return HeadingsOfRest(tuple(entries), found.undecided, found.reach, found.left_out, can_search(scene), scene.units)


def _entries(found: EquilibriumHeadings) -> Iterator[HeadingOfRest]:
    yield from (_of_interval(interval) for interval in found.intervals)
    yield from (_of_sample(sample) for sample in found.sampled)


def _rank(entry: HeadingOfRest) -> tuple[bool, bool, bool, bool, float]:
    start = entry.heading if entry.low is None else entry.low
    where = 0.0 if start is None else float(start)
    turns, single = entry.kind is HeadingKind.TURNING, entry.kind is HeadingKind.ISOLATED
    return not entry.attracts, turns, not entry.proved, not single, where


def _of_interval(interval: RestInterval) -> HeadingOfRest:
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
