"""Where do bodies go that start all over the checked square?

Exact: every rest point, rest line and rest area of the square, and every point about which the body turns, with what a
body near it does.  Sampled: the share of starts that ends there, from paths of a grid of starts.  Of
the rest points the one with the largest certified disc of starts is worth checking (:func:`best_point`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from typing import TypeVar

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import has_cells, rule_of
from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace, find_equilibria
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import Partition, RefusalError, affordable
from nonsmooth.analysis.cells.polygon import Point, convex_polygon
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.maps import AT, STAYS, SettleMap, grid_starts, places_reached, settle_maps
from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError
from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.proofs.answers.heading import OF_ROTATION
from nonsmooth.proofs.answers.position import OF_PLACE
from nonsmooth.proofs.boxes.enclosed_rest import enclosed_rest
from nonsmooth.proofs.clauses.clause import JudgedEquilibrium
from nonsmooth.proofs.clauses.translation.at_point import decide_translation_at
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.theorem4 import CHECK_UNITS, Theorem4Result, judge_equilibria
from nonsmooth.symbolic.mechanics.contact_set import alone, standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import html_table
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import percent_text, place_text
from nonsmooth.symbolic.numbers.plane import Vector
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, are_finite, finite_rows, grid_points, norms
from nonsmooth.symbolic.numbers.rounded import either_way, enclosed, plain

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
        return finite_rows(self.ends)

    @property
    def distances(self) -> tuple[Floats, Floats]:
        """From the checked point, at the start and at the end."""
        return norms(self.starts), norms(self.ends)


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
    if not has_cells(check.scene):
        return sampled_destinations(check.scene)
    partition, places = check.partition, check.equilibria
    if partition is None or places is None or not partition.complete:
        return None
    try:
        ends, reached = _followed(partition, [place.found for place in places])
    except TrajectoryError:  # cells so thin that floats lose their edges: nothing is known
        return None
    destinations = [_at_place(check, place, float(np.mean(reached == k))) for k, place in enumerate(places)]
    destinations = list(_merged(destinations, AT * check.scene.check.half_width))
    destinations += _without_place(ends, reached)
    return Destinations(_in_order(destinations), len(ends.starts), _ends_of(ends))


def ends_from(maps: Sequence[tuple[ConstantField, Floats]]) -> list[SampledEnds | None]:
    """How paths from the starts of each field end; None where they cannot be followed, or begin outside."""
    try:
        return list(map(_ends_of, _settled(maps)))
    except (TrajectoryError, ValueError):
        return [None] if len(maps) == 1 else [ends for one in maps for ends in ends_from([one])]


def _settled(maps: Sequence[tuple[ConstantField, Floats]]) -> list[SettleMap]:
    """The ends of paths.

    Raises:
        ValueError: for a start outside the cells.
        TrajectoryError: where paths cannot be followed, and for starts beyond the range of floats.
    """
    if not all(are_finite(starts) for _, starts in maps):
        raise TrajectoryError("required starts within the range of floats")
    return settle_maps(maps)


def _ends_of(ends: SettleMap) -> SampledEnds:
    stays = np.array([reason in STAYS for reason, _ in ends.ends])[ends.basin]
    leaves = np.array([_OF_END.get(reason) in (Goal.LEAVES, Goal.TIPS) for reason, _ in ends.ends])[ends.basin]
    return SampledEnds(ends.starts, np.where(stays[:, None], ends.points, np.nan), leaves, ends.theta)


def _in_order(destinations: list[Destination]) -> tuple[Destination, ...]:
    return tuple(sorted(destinations, key=lambda d: -d.share))


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
    (ends,) = _settled([(cells, starts)])
    return ends, places_reached(partition, places, ends)


def sampled_destinations(scene: Scene) -> Destinations | None:
    """Under a rule without cells: where sampled paths stand still; None where the motion is not determined,
    or floats do not reach.

    What is near such a place is not judged.
    """
    from nonsmooth.analysis.trajectories.smooth_ends import LEFT, MOVING, UndeterminedError, smooth_ends

    x, y = scene.check.place
    side = np.linspace(-1, 1, FEW_STARTS) * scene.check.half_width * INSIDE
    starts = grid_points(side, side)
    if not are_finite(starts):
        return None
    try:
        ends = smooth_ends(scene.recentred(), starts, (x, y))
    except UndeterminedError:
        return None
    shares = [float(np.mean(ends.reached == k)) for k in range(len(ends.places))]
    if len(shares) > MOST_PLACES:
        (left, low), (right, high) = ends.places.min(axis=0).tolist(), ends.places.max(axis=0).tolist()
        destinations = [Destination(Goal.AREA, ((left, low), (right, high)), None, None, sum(shares))]
    else:
        destinations = [
            Destination(Goal.POINT, ((px, py),), None, None, share)
            for (px, py), share in zip(ends.places.tolist(), shares, strict=True)
        ]
    for code, goal in ((LEFT, Goal.LEAVES), (MOVING, Goal.OTHER)):
        share = float(np.mean(ends.reached == code))
        destinations += [Destination(goal, (), None, None, share)] if share else []
    places = np.where(ends.speeds[:, None] <= VANISHES, ends.places - (x, y), np.nan)
    reached = np.vstack([places, np.full((2, 2), np.nan)])[ends.reached]  # -1 and -2 stay nowhere
    sampled = SampledEnds(starts, reached, ends.reached == LEFT, np.full(len(starts), np.nan))
    return Destinations(_in_order(destinations), len(starts), sampled)


def _at_place(check: Theorem4Result, place: JudgedEquilibrium, share: float) -> Destination:
    x, y = check.scene.check.equilibrium
    points = tuple((px + x, py + y) for px, py in place.found.points)
    position = None if place.translation is None else OF_PLACE[place.translation]
    heading = None if place.rotation is None else OF_ROTATION[place.rotation]
    return Destination(_OF_PLACE[place.found.place], points, position, heading, share)


def _merged(destinations: list[Destination], distance: float) -> Iterator[Destination]:
    """Points closer together than sampled ends can be told apart as one, with what holds near all of them."""
    left = list(destinations)
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


# ---- which point of the checked square is worth checking -----------------------------------------
#
# The rest point with the largest certified disc of starts.


_RANK: dict[Position | None, int] = {
    Position.COMES_HOME: 0,
    Position.COMES_NEAR: 1,
    Position.STAYS_NEAR: 2,
    None: 2,
    Position.UNDECIDED: 3,
    Position.UNSTABLE: 4,
}
DENOMINATORS = (1, 10, 100, 1_000)  # of the coordinates that are tried under a rule without cells
OTHER_MEMBERS = (0.7390851, -0.5671433)  # of the two coordinates of an enclosed point
SHORT_BITS = 256  # of a coordinate; the numbers of measured tables have about fifty
MIDDLE_DIGITS = (2, 4, 8)  # of the middle of an area, below the half side of the square; tried in turn
NEAR_SAMPLE = Fraction(1)  # of the accuracy: an enclosed point farther from the sampled place is another one
_HALVINGS = 6  # of the square about a point near the border of the support polygon
_NONE_FOUND = "--at auto: required a rest point in the checked square, found none"

Judged = TypeVar("Judged")


@dataclass(frozen=True)
class RestPoint:
    """A place where bodies rest, and how far about it that is certified.

    Attributes:
        points: the point, the ends of a line or the corners of an area, in the coordinates of the scene.
        position: where a body goes that starts near; None where that was not judged.
        within: radius of a disc of starts that come home, or, where bodies only stay near, of one in which none gets
            farther away; None where no disc is certified.
    """

    points: tuple[Point, ...]
    position: Position | None = None
    within: Number | None = None


@dataclass(frozen=True)
class BestPoint:
    """The array checked at the best rest point of its square, and all places of rest that are known, the best first."""

    scene: Scene
    found: tuple[RestPoint, ...]


def best_point(scene: Scene) -> BestPoint:
    """Choose the rest point of the checked square that takes the most noise.

    Points that bodies come home to go first, then those that they stay near; among equals the one with the largest
    certified disc; where the discs are equal, or none is certified, the one where most starts end, sampled.  Of a line
    or an area of rest the middle is taken.  Where the square about the point would leave what the contact rule can
    judge, it is halved until it does not.

    Under a rule without cells rest points are only sampled: those with simple coordinates are taken that are proved to
    be equilibria, and of the others those that Krawczyk's operator encloses; their coordinates are decimal numbers that
    stand for the enclosures.

    Raises:
        RefusalError: where no point is known, and where the exact arithmetic would take too long.
    """
    if rule_of(scene).needs_loads and scene.contact.loads_are_unknown:
        raise RefusalError("--at auto: required loads that are known, which say where a body rests under this rule")
    with affordable(scene, CHECK_UNITS, "the rest points of --at auto"):
        if not has_cells(scene):
            return _best_proved_point(scene)
        return _best_of_cells(scene)


def _order(point: RestPoint) -> tuple[int, Number | int]:
    """A key that sorts the better point first."""
    return _RANK[point.position], 0 if point.within is None else -point.within


# ---- rules with cells ----------------------------------------------------------------------


def _best_of_cells(scene: Scene) -> BestPoint:
    """Every place of rest in the cells, with its disc in the square that would be checked."""
    centred = standing(scene).recentred()
    partition = build_partition(centred)
    places = judge_equilibria(centred, find_equilibria(partition))
    if not places:
        raise RefusalError(_NONE_FOUND)
    judged = [(_rest_point(scene, place), place) for place in places]
    least = min(_order(point) for point, _ in judged)
    if sum(_order(point) == least for point, _ in judged) > 1:
        shares = shares_at(partition, [place.found for place in places])
        judged = [pair for _, pair in sorted(zip(shares, judged, strict=True), key=lambda entry: -entry[0])]
    points = tuple(sorted((point for point, _ in judged), key=_order))
    return BestPoint(_in_a_square_that_fits(scene, _middle(scene, points[0]), _partition)[0], points)


def _rest_point(scene: Scene, place: JudgedEquilibrium) -> RestPoint:
    """A place in the coordinates of the scene; its disc where bodies come home or stay near."""
    x, y = scene.check.equilibrium
    points = tuple((px + x, py + y) for px, py in place.found.points)
    if place.translation is None:
        return RestPoint(points)
    point = RestPoint(points, OF_PLACE[place.translation])
    if place.translation in (Translation.UNSTABLE, Translation.UNDECIDED):
        return point
    _, partition = _in_a_square_that_fits(scene, _middle(scene, point), _partition)
    return point if partition is None else replace(point, within=_disc(decide_translation(partition)))


def _partition(there: Scene) -> Partition:
    return build_partition(standing(there).recentred())


def _disc(translation: AnyTranslation) -> Number | None:
    """Radius of the certified disc: of starts that come home, or in which bodies do not get farther away."""
    attracts = translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    return translation.home_radius if attracts else translation.region_radius


def _middle(scene: Scene, place: RestPoint) -> Vector:
    """The mean of the corners, in the numbers of the scene; in an area whose corners are long, a short point beside it.

    Corners of areas may have thousands of digits, and every number of a check at their mean has as many.  Of rounded
    corners it is the mean of the members that are given: a single point moves with the numbers that were rounded, a
    point inside a line or an area is free to choose.
    """
    corners = place.points
    if len(corners) > 2 and any(isinstance(x, Lazy) or x.size_bits > SHORT_BITS for point in corners for x in point):
        near = _short_middle(scene, corners)
        if near is not None:
            return near
    share = Fraction(1, len(corners))
    x, y = (_carried_out(scene, [point[k] for point in corners]) * share for k in (0, 1))
    return (x, y) if len(corners) == 1 else (plain(x), plain(y))


def _short_middle(scene: Scene, corners: tuple[Point, ...]) -> Vector | None:
    """The mean of the corners of an area, rounded to as few decimals as leave it inside; None where too many would."""
    area, scale = convex_polygon(corners), math.floor(math.log10(scene.check.half_width))
    middle = [sum(float(point[k]) for point in corners) / len(corners) for k in (0, 1)]
    for digits in MIDDLE_DIGITS:
        step = Fraction(10) ** (scale - digits)
        near = scene.field(round(middle[0] / step) * step), scene.field(round(middle[1] / step) * step)
        if area.contains(near):
            return near
    return None


def _carried_out(scene: Scene, values: list[Number | Lazy]) -> Number:
    total = scene.field.zero
    for value in values:
        total += value.exact() if isinstance(value, Lazy) else value
    return total


# ---- rules without cells -------------------------------------------------------------------


def _best_proved_point(scene: Scene) -> BestPoint:
    """Sampled places propose simple fractions; the exact motion at the point disposes."""
    sampled = sampled_destinations(standing(scene))
    places = [place.points for place in (() if sampled is None else sampled.found) if place.points]
    proved: list[tuple[RestPoint, Scene]] = []
    open_places: list[RestPoint] = []
    for points in places:
        near = _proved_near(scene, points[0]) or _enclosed_near(scene, points[0])
        if near is None:
            open_places.append(RestPoint(points))
        elif all(near[0].points != other.points for other, _ in proved):
            proved.append(near)
    if not proved:
        raise RefusalError(_no_exact_point(scene, places))
    proved.sort(key=lambda pair: _order(pair[0]))
    return BestPoint(proved[0][1], (*(point for point, _ in proved), *open_places))


def _proved_near(scene: Scene, place: Point) -> tuple[RestPoint, Scene] | None:
    """The equilibrium with the simplest coordinates near a sampled place, and the array checked there."""
    for largest in DENOMINATORS:
        x, y = (scene.field(Fraction(value).limit_denominator(largest)) for value in place)
        there, _ = _in_a_square_that_fits(scene, (x, y), _loads_exist)
        try:
            work = Workspace(standing(there), sample=False)
            if work.point.equilibrium is Equilibrium.HOLDS:
                translation = decide_translation_at(work.point, work.lemma)
                return RestPoint(((x, y),), OF_PLACE[translation.verdict], _disc(translation)), there
        except RefusalError:
            continue
    return None


def _enclosed_near(scene: Scene, place: Point) -> tuple[RestPoint, Scene] | None:
    """The rest point that is enclosed near a sampled place, and the array checked there."""
    x, y = (scene.field.rational(Fraction(float(value)).limit_denominator(DENOMINATORS[-1])) for value in place)
    with either_way(scene.field):  # the enclosure holds for every member of what was rounded
        try:
            array = alone(scene.checked_at((x, y), scene.check.radius)).recentred()
        except SceneError:
            return None
        rest = enclosed_rest(array)
    if rest is None or rest.distance > NEAR_SAMPLE * scene.accuracy:
        return None
    offsets = zip((x, y), rest.place, OTHER_MEMBERS, strict=True)
    at_x, at_y = (enclosed(scene.field, start.ball() + offset, share) for start, offset, share in offsets)
    there, _ = _in_a_square_that_fits(scene, (at_x, at_y), _loads_exist)
    return RestPoint(((at_x, at_y),), OF_PLACE[rest.stability]), there


def _no_exact_point(scene: Scene, places: list[tuple[Point, ...]]) -> str:
    """That the rest points are no exact numbers, and where they are about."""
    seen = f", with rest at about {', '.join(place_text(place[0]) for place in places)}" if places else ""
    name = scene.contact.rule
    wanted = f"required a rest point that is simple or can be enclosed under rule {name}, which has no cells"
    return f"--at auto: {wanted}, found none{seen}"


def _loads_exist(there: Scene) -> object:
    centred = there.recentred()
    return load_regions(centred, centred.check.equilibrium)


# ---- the square ----------------------------------------------------------------------------


def _in_a_square_that_fits(scene: Scene, at: Vector, judge: Callable[[Scene], Judged]) -> tuple[Scene, Judged | None]:
    """The array checked at a point, in its square or the largest half, quarter, ... of it that is not refused.

    Beside it what the judge says of it; None where every square is refused.
    """
    radius = scene.check.radius
    for halving in range(_HALVINGS):
        there = scene.checked_at(at, radius / 2**halving)
        try:
            return there, judge(there)
        except RefusalError:
            continue
    return scene.checked_at(at, radius), None
