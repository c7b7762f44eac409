"""Where do bodies go that start all over the checked square?

Exact: every rest point, rest line and rest area of the square, and every point about which the body turns, with what a
body near it does.  Sampled: the share of starts that ends there, from paths of a grid of starts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.maps import AT, STAYS, SettleMap, grid_starts, places_reached, settle_map
from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError
from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.proofs.answers.heading import OF_ROTATION
from nonsmooth.proofs.answers.position import OF_PLACE
from nonsmooth.proofs.clauses.clause import JudgedEquilibrium
from nonsmooth.proofs.theorem4 import Theorem4Result
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import html_table
from nonsmooth.symbolic.numbers.number_text import percent_text, place_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask

STARTS = 31  # in a row and in a column: shares to about two per cent
FEW_STARTS = 11  # the same under rules without cells, whose paths cost more
INSIDE = 0.98  # of the square: how far these starts reach
VANISHES = 2.0**-30  # of the largest speed of the starts: as slow as a body is where the field is known to vanish
MOST_PLACES = 6  # where bodies stand still; more are taken for an area of rest


class Goal(StrEnum):
    """What a place is to a body that gets there."""

    POINT = "rests at a point"
    LINE = "rests on a line"
    AREA = "rests in an area"
    PIVOT = "turns on the spot or circles about it"
    ORBIT = "follows a closed orbit"
    LEAVES = "leaves the square"
    TIPS = "tips over the wheels"
    OTHER = "is still on its way"


_OF_PLACE = {
    EquilibriumPlace.VERTEX: Goal.POINT,
    EquilibriumPlace.SIDE: Goal.POINT,
    EquilibriumPlace.SEGMENT: Goal.LINE,
    EquilibriumPlace.AREA: Goal.AREA,
    EquilibriumPlace.CENTRE: Goal.PIVOT,
}
_OF_END = {
    EndReason.CIRCLES: Goal.ORBIT,
    EndReason.OUTSIDE: Goal.LEAVES,
    EndReason.TIPS: Goal.TIPS,
    EndReason.LOADS: Goal.TIPS,
}


@dataclass(frozen=True)
class Destination:
    """One place where bodies end, or one way in which they do not.

    Attributes:
        goal: what it is.
        points: the point, the ends of the line or the corners of the area, in the coordinates of the scene; of a
            sampled area two opposite corners of a rectangle around it; empty for an end without a place.
        position: where a body goes that starts near the place; None where that was not judged.
        heading: what its heading does there; None where that was not judged.
        share: of the starts that end so, sampled.
    """

    goal: Goal
    points: tuple[Point, ...]
    position: Position | None
    heading: Heading | None
    share: float


@dataclass(frozen=True, eq=False)
class SampledEnds:
    """How paths from m starts end, measured from the checked point; what is not known for sure is not said.

    Attributes:
        starts: (m, 2).
        ends: where the body stays for ever, or what it approaches, (m, 2); not a number elsewhere.
        leaves: whether it leaves the square, or tips at the border of the support polygon, (m,).
        turning: the angle by which it has turned at the end, (m,): infinite where it turns for ever, not a number where
            nothing is known.
    """

    starts: Floats
    ends: Floats
    leaves: Mask
    turning: Floats

    @property
    def stays(self) -> Mask:
        """Whether it is known where the body stays, (m,)."""
        return np.asarray(np.isfinite(self.ends).all(axis=1))

    @property
    def distances(self) -> tuple[Floats, Floats]:
        """From the checked point, at the start and at the end."""
        return np.hypot(*self.starts.T), np.hypot(*self.ends.T)


@dataclass(frozen=True)
class Destinations:
    """All of them, the largest share first, and how many starts the shares are sampled from.

    Attributes:
        found: the places, and the other ways to end.
        starts: their number.
        sampled: how each start ends.
    """

    found: tuple[Destination, ...]
    starts: int
    sampled: SampledEnds = field(compare=False, repr=False)

    def _repr_html_(self) -> str:
        """Each with its share, for a notebook."""
        rows = [
            (percent_text(d.share), d.goal, " ".join(place_text(point) for point in d.points), d.position or "")
            for d in self.found
        ]
        return html_table(f"ends of {self.starts} starts", ("share", "the body", "where", "bodies near it"), rows)


def destinations_of(check: Theorem4Result) -> Destinations | None:
    """Every destination in the checked square.

    None where not all cells were built, where loads decide and are unknown, and where paths cannot be followed.
    """
    if rule_of(check.scene).needs_loads and check.scene.contact.loads_are_unknown:
        return None
    if isinstance(rule_of(check.scene), SmoothRule):
        return sampled_destinations(check.scene)
    partition, places = check.partition, check.equilibria
    if partition is None or places is None or not partition.complete:
        return None
    try:
        ends, reached = _followed(partition, [place.found for place in places])
    except TrajectoryError:  # cells so thin that floats lose their edges: nothing is known
        return None
    found = [_at_place(check, place, float(np.mean(reached == k))) for k, place in enumerate(places)]
    found = list(_merged(found, AT * float(check.scene.check.radius)))
    found += _without_place(ends, reached)
    return Destinations(_in_order(found), len(ends.starts), _ends_of(ends))


def ends_from(partition: Partition, starts: Floats) -> SampledEnds | None:
    """How paths through all cells of a centred partition end; None where they cannot be followed, or begin outside."""
    try:
        return _ends_of(_settled(array_field(partition, Kinematics.EXACT), starts))
    except (TrajectoryError, ValueError):
        return None


def _settled(cells: ConstantField, starts: Floats) -> SettleMap:
    """The ends of paths.

    Raises:
        ValueError: for a start outside the cells.
        TrajectoryError: where paths cannot be followed, and for starts beyond the range of floats.
    """
    if not np.isfinite(starts).all():
        raise TrajectoryError("required starts within the range of floats")
    return settle_map(cells, starts)


def _ends_of(found: SettleMap) -> SampledEnds:
    stays = np.array([reason in STAYS for reason, _ in found.ends])[found.basin]
    leaves = np.array([_OF_END.get(reason) in (Goal.LEAVES, Goal.TIPS) for reason, _ in found.ends])[found.basin]
    return SampledEnds(found.starts, np.where(stays[:, None], found.points, np.nan), leaves, found.theta)


def _in_order(found: list[Destination]) -> tuple[Destination, ...]:
    return tuple(sorted(found, key=lambda d: -d.share))


def shares_at(partition: Partition, places: Sequence[RestPlace]) -> list[float]:
    """For every equilibrium of the cells the share of the starts that end there, sampled."""
    try:
        _, reached = _followed(partition, places)
    except TrajectoryError:  # cells so thin that floats lose their edges: no start is known to end anywhere
        return [0.0] * len(places)
    return [float(np.mean(reached == k)) for k in range(len(places))]


def _followed(partition: Partition, places: Sequence[RestPlace]) -> tuple[SettleMap, Indices]:
    """The ends of a grid of paths, and the number of the equilibrium at which each ends.

    Raises:
        TrajectoryError: where paths cannot be followed, and for cells beyond the range of floats.
    """
    cells = array_field(partition, Kinematics.EXACT)
    with np.errstate(over="ignore", invalid="ignore"):
        starts = grid_starts(cells, STARTS)
    ends = _settled(cells, starts)
    return ends, places_reached(partition, places, ends)


def sampled_destinations(scene: Scene) -> Destinations | None:
    """Under a rule without cells: where sampled paths stand still; None where the motion is not determined,
    or floats do not reach.

    What is near such a place is not judged.
    """
    from nonsmooth.analysis.trajectories.smooth_ends import LEFT, MOVING, UndeterminedError, smooth_ends

    x, y = scene.check.place
    side = np.linspace(-1, 1, FEW_STARTS) * float(scene.check.radius) * INSIDE
    starts = np.stack([grid.ravel() for grid in np.meshgrid(side, side)], axis=1)
    if not np.isfinite(starts).all():
        return None
    try:
        ends = smooth_ends(scene.recentred(), starts, (x, y))
    except UndeterminedError:
        return None
    shares = [float(np.mean(ends.reached == k)) for k in range(len(ends.places))]
    if len(shares) > MOST_PLACES:
        (left, low), (right, high) = ends.places.min(axis=0).tolist(), ends.places.max(axis=0).tolist()
        found = [Destination(Goal.AREA, ((left, low), (right, high)), None, None, sum(shares))]
    else:
        found = [
            Destination(Goal.POINT, ((px, py),), None, None, share)
            for (px, py), share in zip(ends.places.tolist(), shares, strict=True)
        ]
    for code, goal in ((LEFT, Goal.LEAVES), (MOVING, Goal.OTHER)):
        share = float(np.mean(ends.reached == code))
        found += [Destination(goal, (), None, None, share)] if share else []
    places = np.where(ends.speeds[:, None] <= VANISHES, ends.places - (x, y), np.nan)
    reached = np.vstack([places, np.full((2, 2), np.nan)])[ends.reached]  # -1 and -2 stay nowhere
    sampled = SampledEnds(starts, reached, ends.reached == LEFT, np.full(len(starts), np.nan))
    return Destinations(_in_order(found), len(starts), sampled)


def _at_place(check: Theorem4Result, place: JudgedEquilibrium, share: float) -> Destination:
    x, y = check.scene.check.equilibrium
    points = tuple((px + x, py + y) for px, py in place.found.points)
    position = None if place.translation is None else OF_PLACE[place.translation]
    heading = None if place.rotation is None else OF_ROTATION[place.rotation]
    return Destination(_OF_PLACE[place.found.place], points, position, heading, share)


def _merged(found: list[Destination], distance: float) -> Iterator[Destination]:
    """Points closer together than sampled ends can be told apart as one, with what holds near all of them."""
    left = list(found)
    while left:
        first, *others = left
        same = [one for one in others if _is_same_point(first, one, distance)]
        left = [one for one in others if one not in same]
        together = [first, *same]
        position, heading = ({getattr(one, key) for one in together} for key in ("position", "heading"))
        yield replace(
            first,
            position=first.position if len(position) == 1 else None,
            heading=first.heading if len(heading) == 1 else None,
            share=sum(one.share for one in together),
        )


def _is_same_point(one: Destination, two: Destination, distance: float) -> bool:
    if one.goal is not Goal.POINT or two.goal is not Goal.POINT:
        return False
    ((x, y),), ((other_x, other_y),) = one.points, two.points
    return abs(float(x) - float(other_x)) <= distance and abs(float(y) - float(other_y)) <= distance


def _without_place(ends: SettleMap, reached: Indices) -> Iterator[Destination]:
    """The starts that end at none of the places, by how they end."""
    goals = np.array([_OF_END.get(reason, Goal.OTHER) for reason, _ in ends.ends])[ends.basin]
    for goal in Goal:
        share = float(np.mean((goals == goal) & (reached < 0)))
        if share:
            yield Destination(goal, (), None, None, share)
