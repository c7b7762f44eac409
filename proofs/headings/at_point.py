"""Every heading with the centre of mass at one point: where the body rests, where its turns meet, what is undecided.

The motion depends on the point and on the wheels under the outline, and on the heading through these alone.  So with
the centre of mass at c0, every heading between two that bring wheels under the edge has one verdict.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, combinations
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.proofs.headings.stay import Stay, Stays, StaysAt
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.edge_headings import BallOutline, Gap, HeadingCluster, clusters, gaps, places_of, seen
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.numbers.plane import Vector

Wheels: TypeAlias = tuple[int, ...]  # numbers, ascending

MOST_AT_ONCE = 4  # wheels under the edge at one heading whose motions are looked at: 16 sets
STEPS = 200  # towards the shortest mixture of motions
MOVES = "whether mixtures of the motions on both sides rest is not decided"
CORNER = "a wheel that may lie under a corner of the body"
TOWARDS = "the body turns to it from both sides; whether it comes back to it is not decided"
AWAY = "the body turns away from it on both sides; what becomes of it is not decided"


@dataclass(frozen=True)
class RestInterval:
    """An open interval of headings on the same wheels, with the centre of mass at one point.

    Attributes:
        scene: all wheels, with the body at the point, at the checked heading.
        gap: the interval, in radians from that heading.
        wheels: numbers of the wheels that carry; None where that is not certain.
        stay: what the body does there.
    """

    scene: Scene
    gap: Gap
    wheels: Wheels | None
    stay: Stay

    @property
    def ends(self) -> tuple[Wheels, Wheels]:
        """Numbers of the wheels under the edge at the lower and at the upper end."""
        below, above = (tuple(self.scene.wheels[k].index for k in ends) for ends in self.gap.ends)
        return below, above


@dataclass(frozen=True)
class OpenHeadings:
    """Headings of which nothing is proved.

    Attributes:
        low: the lowest of them, in radians from the checked heading.
        high: the highest.
        edge: numbers of the wheels under the edge, at a single heading; empty for an interval.
        reason: why.
    """

    low: arb
    high: arb
    edge: Wheels
    reason: str


@dataclass(frozen=True)
class SampledRest:
    """A pose at which a body seems to rest, and nothing is proved.

    Attributes:
        place: ``(x, y)``, in floats.
        theta: the heading, or one at which the same wheels carry where none lies under the edge.
        wheels: numbers of those well under the body.
        edge: numbers of those under its edge.
        reason: what is not decided.
    """

    place: tuple[float, float]
    theta: float
    wheels: Wheels
    edge: Wheels
    reason: str


@dataclass(frozen=True)
class EquilibriumHeadings:
    """Headings at which a body rests, about the checked point of a scene.

    Attributes:
        intervals: ranges of headings on one set of wheels, proved.
        undecided: headings at the checked point of which nothing is proved.
        sampled: what seems to be rest: single headings with wheels under the edge, and points on one set of wheels.
        reach: half-width of the square of places that was searched; None where it was the checked point alone.
        left_out: points on one set of wheels that were found but not decided, for there were too many.
    """

    intervals: tuple[RestInterval, ...]
    undecided: tuple[OpenHeadings, ...] = ()
    sampled: tuple[SampledRest, ...] = ()
    reach: float | None = None
    left_out: int = 0


class HeadingsAt:
    """The headings at one point of one scene."""

    def __init__(self, scene: Scene, point: Vector) -> None:
        """For a scene with a body, at a point in its numbers.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        self.scene = replace(whole(scene), check=replace(scene.check, equilibrium=point))
        with ctx.workprec(PRECISION):
            self.outline = BallOutline(scene.body)
            self.places = places_of([wheel.position for wheel in self.scene.wheels], point)
            self.stays = StaysAt(self.scene)

    def clusters(self) -> list[HeadingCluster]:
        """Headings with wheels under the edge, in ascending order."""
        with ctx.workprec(PRECISION):
            return clusters([edge for k, at in enumerate(self.places) for edge in self.outline.edge_headings(k, at)])

    def sectors(self, only: Wheels | None = None) -> Iterator[RestInterval]:
        """All intervals between these headings, in ascending order.

        Args:
            only: numbers of wheels; then the intervals in which these carry, and no others.
        """
        with ctx.workprec(PRECISION):
            between = gaps(self.clusters())
            for k, gap in enumerate(between):
                tell_count(k, len(between), "intervals of headings")
                wheels = self.carrying((gap.low + gap.high) / 2) if gap.low < gap.high else None
                if only in (None, wheels):
                    yield RestInterval(self.scene, gap, wheels, self._stay(wheels))

    def carrying(self, theta: arb) -> Wheels | None:
        """Numbers of the wheels under the body at a heading; None where that is not certain."""
        theta = theta.mid()
        sides = [self.outline.side_of(seen(place, theta)) for place in self.places]
        if 0 in sides:
            return None
        return tuple(wheel.index for wheel, side in zip(self.scene.wheels, sides, strict=True) if side > 0)

    def _stay(self, wheels: Wheels | None) -> Stay:
        if wheels is None:
            return Stay(Stays.UNDECIDED, reason="headings that balls do not tell apart")
        return self.stays.on(wheels)


def point_headings(here: HeadingsAt) -> EquilibriumHeadings:
    """Decide every heading at a point; the ends of intervals of rest are headings of rest too, and not listed.

    Sampled are single headings with wheels under the edge, at which turns one way meet turns the other way.
    """
    sectors = list(here.sectors())
    open_ones = [sector for sector in sectors if sector.stay.kind is Stays.UNDECIDED]
    left = [OpenHeadings(sector.gap.low, sector.gap.high, (), sector.stay.reason) for sector in open_ones]
    singles: list[SampledRest] = []
    edges = here.clusters()
    for k, cluster in enumerate(edges):
        tell_count(k, len(edges), "headings with a wheel under the edge")
        with ctx.workprec(PRECISION):
            found = _at_edge(here, cluster, sectors[k - 1], sectors[k])
        if isinstance(found, SampledRest):
            singles.append(found)
        elif found is not None:
            left.append(found)
    staying = tuple(sector for sector in sectors if sector.stay.is_equilibrium)
    return EquilibriumHeadings(staying, tuple(left), tuple(singles))


def _at_edge(
    here: HeadingsAt, cluster: HeadingCluster, below: RestInterval, above: RestInterval
) -> SampledRest | OpenHeadings | None:
    """The heading between two intervals; None where it is an end of rest or of what is left open, or no rest."""
    kinds = {below.stay.kind, above.stay.kind}
    if kinds & {Stays.RESTS, Stays.UNDECIDED}:
        return None
    inside, edge = _inside(here, cluster), tuple(here.scene.wheels[k].index for k in cluster.wheels)
    turns_meet = kinds == {Stays.TURNS} and below.stay.turning * above.stay.turning < 0
    if turns_meet and inside is not None:
        x, y = (float(entry) for entry in here.scene.check.equilibrium)
        reason = TOWARDS if below.stay.turning > 0 else AWAY
        return SampledRest((x, y), float(cluster.theta.mid()), inside, edge, reason)
    if not turns_meet and len(cluster.edges) == 1 and _passes(here, kinds):
        return None
    if not turns_meet and inside is not None and _moves_off(here, cluster, inside):
        return None
    return OpenHeadings(cluster.theta, cluster.theta, edge, CORNER if inside is None else MOVES)


def _passes(here: HeadingsAt, kinds: set[Stays]) -> bool:
    """Whether no mixture of the motions on both sides of one wheel's edge rests, where they are no opposite turns.

    Where the body tips on one side the other motion is alone.  Under a rule without cells each side has one motion; if
    one is a turn on the spot, the other is a turn the same way or moves the centre of mass.
    """
    return Stays.TIPS in kinds or (here.stays.rule is not None and Stays.TURNS in kinds)


def _inside(here: HeadingsAt, cluster: HeadingCluster) -> Wheels | None:
    """Numbers of the wheels well under the body at a heading; None where another one may lie under the edge."""
    theta = cluster.theta
    sides = {k: here.outline.side_of(seen(place, theta)) for k, place in enumerate(here.places)}
    sides = {k: side for k, side in sides.items() if k not in cluster.wheels}
    if 0 in sides.values() or len(cluster.edges) > len(cluster.wheels):
        return None
    return tuple(here.scene.wheels[k].index for k, side in sides.items() if side > 0)


def _moves_off(here: HeadingsAt, cluster: HeadingCluster, inside: Wheels) -> bool:
    """Whether all motions have a positive component in one direction of the space of poses."""
    numbers = [here.scene.wheels[k].index for k in cluster.wheels]
    if len(numbers) > MOST_AT_ONCE:
        return False
    subsets = chain.from_iterable(combinations(numbers, k) for k in range(len(numbers) + 1))
    rates: list[arb_mat] = []
    for some in subsets:
        found = here.stays.rates(sorted((*inside, *some)))
        if found is None:
            return False
        rates += found
    way = _shortest(rates)
    return all((rate * way)[0, 0] > 0 for rate in rates)


def _shortest(rates: list[arb_mat]) -> arb_mat:
    """The shortest mixture of some rates, in floats, as a column (Gilbert's algorithm)."""
    points = np.array([[float(entry) for entry in rate.entries()] for rate in rates])
    shortest = points[0]
    for _ in range(STEPS):
        change = points[(points @ shortest).argmin()] - shortest
        square = float(change @ change)
        share = 0.0 if square <= 0 else min(1.0, max(0.0, -float(shortest @ change) / square))
        shortest = shortest + share * change
    return arb_mat([[arb(float(entry))] for entry in shortest])
