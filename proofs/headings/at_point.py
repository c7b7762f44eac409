"""Headings with the centre of mass at one point, or near it: where the body rests, where its turns meet, what is open.

The motion depends on the point and on the wheels under the outline, and on the heading through these alone.  So with
the centre of mass at c0, every heading between two that bring wheels under the edge has one verdict.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, combinations
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.loads import LoadRegion, load_regions
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.boxes.linearization import gradient, slips_at
from nonsmooth.proofs.headings.stay import BodyAtPoint, Stay, Stays
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.edge_headings import BallOutline, Gap, HeadingCluster, clusters, gaps, places_of, seen
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.numbers.plane import Vector, around, cross
from nonsmooth.symbolic.numbers.plane_arrays import float_points, norm
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.edge_rests import SeenRest


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
            self.places = places_of(self.scene.positions, point)
            self.stays = BodyAtPoint(self.scene)

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
            rest = _at_edge(here, cluster, sectors[k - 1], sectors[k])
        if isinstance(rest, SampledRest):
            singles.append(rest)
        elif rest is not None:
            left.append(rest)
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
        motions = here.stays.rates(sorted((*inside, *some)))
        if motions is None:
            return False
        rates += motions
    way = _shortest(rates)
    return all((rate * way)[0, 0] > 0 for rate in rates)


def _shortest(rates: list[arb_mat]) -> arb_mat:
    """The shortest mixture of some rates, in floats, as a column (Gilbert's algorithm)."""
    points = float_points(rate.entries() for rate in rates)
    shortest = points[0]
    for _ in range(STEPS):
        change = points[(points @ shortest).argmin()] - shortest
        square = float(change @ change)
        share = 0.0 if square <= 0 else min(1.0, max(0.0, -float(shortest @ change) / square))
        shortest = shortest + share * change
    return arb_mat([[arb(float(entry))] for entry in shortest])


# ---- equilibrium headings of a body with an outline ----------------------------------------------
#
# Where it rests for a range of headings, and where for one.
#
# At the checked point every range of headings is decided or named as undecided, under every contact rule.  Under a rule
# without cells rest is also looked for around that point, in floats; on one set of wheels what is found is decided
# exactly.  That search may miss poses, among them all off the point with several wheels under the edge.  What is not
# proved, among it every single heading with wheels under the edge, is called sampled.


MOST_POINTS = 24  # points of rest on one set of wheels that are decided, the nearest first
UNITS = 400_000  # of exact arithmetic for one of them
UNDER_THE_EDGE = "rest with a wheel under the edge is seen in floats, not proved"
TOO_MUCH = "its exact point takes too much arithmetic, or is none"
NEAR = 10**6  # denominator of a rational point beside a sampled one: the same wheels are loaded there


def heading_matters(scene: Scene) -> bool:
    """Whether the wheels under the body at the checked point, or close by, depend on its heading."""
    body = scene.body
    if body is None or body.is_round:
        return False
    if isinstance(body.outline, Disc):
        offset = math.hypot(*(float(entry) for entry in body.centroid))
        radius = float(body.outline.radius)
        inner, outer = radius - offset, radius + offset
    else:
        corners = [(float(x), float(y)) for x, y in body.vertices]
        inner = min(cross(a, b) / float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in around(corners))
        outer = max(norm(corner) for corner in corners)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    wheels = [(float(wheel.position[0]) - x, float(wheel.position[1]) - y) for wheel in whole(scene).wheels]
    distances = np.array([np.hypot(*wheel) for wheel in wheels])
    close = outer - inner  # how far from the point a wheel may be met under the edge and still count as close by
    return bool(((distances > inner - close) & (distances < outer + close)).any())


def equilibrium_headings(scene: Scene, *, around: bool = False) -> EquilibriumHeadings | None:
    """Headings at which the body of a scene rests; None where the heading does not matter, and for unknown loads.

    Args:
        scene: with the body at the checked pose.
        around: search around the checked point too, under a rule without cells and with elastic loads.
    """
    rule = rule_of(scene)
    if not heading_matters(scene) or (rule.needs_loads and scene.contact.loads_are_unknown):
        return None
    at_point = point_headings(HeadingsAt(scene, scene.check.equilibrium))
    if not around or not isinstance(rule, SmoothRule) or not can_search(scene):
        return at_point
    return _with_surroundings(at_point, whole(scene), rule)


def can_search(scene: Scene) -> bool:
    """Whether the surroundings of the checked point can be searched: under a rule without cells, on elastic loads."""
    return isinstance(rule_of(scene), SmoothRule) and scene.contact.loads is None


def _with_surroundings(at_point: EquilibriumHeadings, every: Scene, rule: SmoothRule) -> EquilibriumHeadings:
    """What is found around the point beside what is known at it."""
    from nonsmooth.analysis.bodies.edge_rests import RestSearch  # SciPy: only a search loads it

    search = RestSearch(every, rule)
    met = search.meet()
    intervals, sampled = list(at_point.intervals), list(at_point.sampled)
    sampled += [_sampled(every, rest, UNDER_THE_EDGE) for rest in search.under_the_edge(met)]
    elsewhere = search.on_one_set(met)
    for rest in elsewhere[:MOST_POINTS]:
        proved = _intervals_of(every, rest)
        intervals += proved
        if not proved:
            sampled.append(_sampled(every, rest, TOO_MUCH))
    left_out = max(len(elsewhere) - MOST_POINTS, 0)
    return replace(at_point, intervals=tuple(intervals), sampled=tuple(sampled), reach=search.reach, left_out=left_out)


def _sampled(scene: Scene, rest: SeenRest, reason: str) -> SampledRest:
    wheels, edge = (tuple(scene.wheels[k].index for k in some) for some in (rest.wheels, rest.edge))
    return SampledRest(rest.place, rest.theta, wheels, edge, reason)


def _intervals_of(scene: Scene, rest: SeenRest) -> list[RestInterval]:
    """The intervals of one candidate: its exact point, and the headings at which its wheels carry."""
    try:
        with work_limit(scene.field, UNITS):
            points = list(_exact_points(scene, rest))
    except (RefusalError, SceneError, WorkLimitError):
        return []
    wheels = tuple(scene.wheels[k].index for k in rest.wheels)
    sectors = [sector for point in points[:1] for sector in HeadingsAt(scene, point).sectors(wheels)]
    return [sector for sector in sectors if sector.stay.is_equilibrium]


def _exact_points(scene: Scene, rest: SeenRest) -> Iterator[Vector]:
    """Where forces balance on these wheels, for each form that the loads have near the sampled point."""
    if any(scene.wheels[k].axis is not None for k in rest.wheels):
        return  # forces along friction axes are no numbers of the scene
    near = tuple(scene.field(Fraction(value).limit_denominator(NEAR)) for value in rest.place)
    wheels = tuple(replace(scene.wheels[k], index=number) for number, k in enumerate(rest.wheels, 1))
    there = replace(scene, wheels=wheels, body=None, check=replace(scene.check, equilibrium=(near[0], near[1])))
    small = replace(there.check, radius=scene.field(Fraction(1, NEAR)))
    for region in load_regions(replace(there, check=small), there.check.equilibrium):
        point = _balance(there, region)
        if point is not None:
            yield point


def _balance(scene: Scene, region: LoadRegion) -> Vector | None:
    """``c`` at which the forces of the wheels that slip at rest balance; None where that is no point."""
    zero = scene.field.zero
    slips = [slip for slip in slips_at(scene, region, zero) if slip.piece is not BorderPiece.KINK]
    (p, q, _), (a, c, _), (b, d, _) = (gradient(zero, slips, part) for part in range(3))
    determinant = a * d - b * c
    if not determinant:
        return None
    inverse = determinant.inverse()
    return (b * q - d * p) * inverse, (c * p - a * q) * inverse
