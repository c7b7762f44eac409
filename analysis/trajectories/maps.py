"""Maps of where a body comes to rest: heading, arrival time and basin over many starts at once.

For cells with constant twist, under both kinematics; all starts are followed together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace
from nonsmooth.analysis.cells.fan import RaySpeeds, sliding
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow
from nonsmooth.analysis.trajectories.closed_forms import (
    ASYMPTOTE_DOUBT,
    PROPORTIONAL_DOUBT,
    SERIES_BELOW,
    SERIES_TERMS,
    CornerSpiral,
    Free,
    Junction,
    Turns,
    junction_at,
    line_times,
    signs_of,
    times_back,
)
from nonsmooth.analysis.trajectories.piecewise_constant import Choice, choices_at, follow_cells
from nonsmooth.analysis.trajectories.result import EndReason, EventKind
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.plane import cross, dot
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, float_points, turned


@dataclass(frozen=True, repr=False)
class SettleMap(ShortRepr):
    """Ends of paths from m starts.

    Attributes:
        starts: (m, 2) positions.
        theta: heading at the end (radian), infinite where the body turns forever, not a number where nothing is known.
        arrival: time of arrival, infinite where an equilibrium is only approached or never reached.
        points: (m, 2) final positions.
        basin: number of the end in ``ends``.
        ends: reason and place of every kind of end that occurs.
        unique: whether no other solution branches off before the end; that theta may drift at rest is not counted.
    """

    starts: Floats
    theta: Floats
    arrival: Floats
    points: Floats
    basin: Indices
    ends: tuple[tuple[EndReason, str], ...]
    unique: Mask

    @property
    def settled(self) -> Mask:
        """Whether the heading has a limit where c comes to rest or approaches an equilibrium."""
        return self._ends_by(EndReason.REST, EndReason.APPROACH) & np.isfinite(self.theta)

    @property
    def arrived(self) -> Mask:
        """Whether c comes to rest in finite time (theta may turn on)."""
        return self._ends_by(EndReason.REST, EndReason.TURNING) & np.isfinite(self.arrival)

    def _ends_by(self, *reasons: EndReason) -> Mask:
        return np.array([reason in reasons for reason, _ in self.ends])[self.basin]

    @property
    def shares(self) -> tuple[float, ...]:
        """The share of the starts that has each kind of end."""
        return tuple(float(np.mean(self.basin == k)) for k in range(len(self.ends)))

    def seen_until(self, time: float) -> SettleMap:
        """What is known at a time: a start that arrives later is still on its way, to nowhere known.

        Ends that are never reached stay as they are.
        """
        late = np.isfinite(self.arrival) & (self.arrival > time)
        if not late.any():
            return self
        basin, ends = np.where(late, len(self.ends), self.basin), (*self.ends, (EndReason.TIME, ""))
        kept = np.unique(basin)
        return replace(
            self,
            theta=np.where(late, np.nan, self.theta),
            arrival=np.where(late, np.inf, self.arrival),
            points=np.where(late[:, None], np.nan, self.points),
            basin=np.searchsorted(kept, basin),
            ends=tuple(ends[k] for k in kept),
        )

    def record(self) -> dict[str, Any]:
        """JSON-ready; None for what is not finite."""
        return {
            "starts": self.starts.tolist(),
            "theta": _finite(self.theta),
            "arrival": _finite(self.arrival),
            "points": [_finite(point) for point in self.points],
            "basin": self.basin.tolist(),
            "ends": [{"reason": reason.value, "place": place} for reason, place in self.ends],
            "unique": self.unique.tolist(),
        }


def _finite(values: Floats) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]


def grid_starts(field: ConstantField, count: int) -> Floats:
    """``count x count`` starts, evenly over the bounding box of the domain, borders included; x runs first.

    Args:
        field: on its domain; shape of what is returned: (count^2, 2).
        count: starts in a row, and rows; two at least.

    Raises:
        ValueError: for fewer than two starts in a row.
    """
    if count < 2:
        raise ValueError(f"required at least two starts in a row, received {count}")
    corners = float_points(field.cells.points)
    axes = [np.linspace(low, high, count) for low, high in zip(corners.min(axis=0), corners.max(axis=0), strict=True)]
    x, y = np.meshgrid(*axes)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def settle_map(field: ConstantField, starts: Floats, theta: float = 0.0, report: OnRow | None = None) -> SettleMap:
    """Follow every start to its end.

    Args:
        field: constant twists on polygons (exact numbers are rounded).
        starts: (m, 2) positions inside the domain.
        theta: initial heading of all.
        report: told from time to time how many of all starts have ended.

    Raises:
        ValueError: for a start outside the domain.
    """
    paths = BatchPaths(field.floats() if field.exact else field, np.array(starts, dtype=float), theta)
    paths.run(report)
    kinds = dict.fromkeys(end for end in paths.ends if end is not None)
    numbers = {end: k for k, end in enumerate(kinds)}
    basin = np.array([DONE if end is None else numbers[end] for end in paths.ends], dtype=int)
    return SettleMap(np.array(starts), paths.theta, paths.time, paths.points, basin, tuple(kinds), paths.unique)


# ---- at which equilibria the paths of a map end --------------------------------------------------


AT = 1e-6  # of the half side of the square: a path that ends within it of a place ends there
STAYS = (EndReason.REST, EndReason.TURNING, EndReason.APPROACH)


def places_reached(partition: Partition, places: Sequence[RestPlace], ends: SettleMap) -> Indices:
    """For every start the number of the place where its path ends, shape (m,); -1 for none.

    Args:
        partition: the cells.
        places: their equilibria.
        ends: where paths of the same cells end, in the same coordinates.
    """
    reached = np.full(len(ends.starts), -1)
    reasons = [reason for reason, _ in ends.ends]
    stays = np.array([reason in STAYS for reason in reasons])[ends.basin]
    circles = np.array([reason is EndReason.CIRCLES for reason in reasons])[ends.basin]
    within = AT * float(partition.scene.check.radius)
    for k, place in enumerate(places):
        at = stays & (_distance(ends.points, place.points) <= within)
        if place.place is EquilibriumPlace.CENTRE:
            # an orbit inside a cell with one twist is a circle about the point where that twist vanishes
            cell = next(cell for cell in partition.cells if cell.index == place.cells[0])
            at |= circles & (_distance(ends.points, cell.polygon.vertices) == 0)
        reached[at & (reached < 0)] = k
    return reached


def _distance(points: Floats, corners: Sequence[Point]) -> Floats:
    """Distance of points (m, 2) to a point, a segment or a convex polygon, shape (m,); infinite where unknown."""
    shape = float_points(corners)
    nearest = np.full(len(points), np.inf)
    inside = np.full(len(points), len(shape) > 2)
    for start, end in zip(shape, np.roll(shape, -1, axis=0), strict=True):
        along, away = end - start, points - start
        length = max(float(along @ along), np.finfo(float).tiny)
        foot = np.clip(away @ along / length, 0, 1)
        nearest = np.fmin(nearest, np.hypot(*(away - foot[:, None] * along).T))
        inside &= along[0] * away[:, 1] - along[1] * away[:, 0] >= 0
    return np.where(inside, 0.0, nearest)


# ---- many paths at once --------------------------------------------------------------------------
#
# The method is that of :mod:`nonsmooth.analysis.trajectories.piecewise_constant`; all starts that are in the same cell,
# on the same edge or at the same corner move together.  Only the generic case is vectorized: paths through cells,
# strict crossings, strict sliding and rest on an edge.  What happens at a corner or where sliding ends is the same for
# all that get there, so it is decided once.  Every other start (on an edge, tangent to one) is handed to the scalar
# integrator.


MAX_LEGS = 2_000  # legs per start; paths of the built-in scenes have fewer than 20
DONE = -1

OnRow: TypeAlias = Callable[[int, int], None]


class BatchPaths:
    """Starts on their way.

    ``place`` numbers cells, then edges, then corners; ``entry`` is the edge or corner from which a cell was entered.
    """

    def __init__(self, field: ConstantField, points: Floats, theta: float) -> None:
        count = len(points)
        self.field, self.cells, self.signs = field, field.cells, signs_of(field)
        self.turns = Turns(field, self.signs)
        self.points, self.theta, self.time = points.copy(), np.full(count, theta), np.zeros(count)
        self.unique = np.ones(count, dtype=bool)
        self.ends: list[tuple[EndReason, str] | None] = [None] * count
        self.first_edge = len(field.flows)
        self.first_corner = self.first_edge + len(field.cells.edges)
        self.place, self.entry = np.full(count, DONE), np.full(count, DONE)
        self.anchors, self.anchored = np.full((count, 2), np.nan), np.full((count, 2), DONE)
        self.corners: dict[int, tuple[Junction, list[Choice]]] = {}
        inside = field.depths(points) > self.cells.slack
        held = inside.any(axis=1)
        self.place[held] = inside[held].argmax(axis=1)
        self._one_by_one(np.flatnonzero(~held))

    def run(self, report: OnRow | None = None) -> None:
        """Leg after leg; ``report`` is told how many of all starts have ended."""
        for leg in range(MAX_LEGS):
            self._find_orbits(np.flatnonzero(self.place != DONE), anchor=leg & (leg - 1) == 0)
            going = np.flatnonzero(self.place != DONE)
            if report is not None:
                report(len(self.place) - len(going), len(self.place))
            if not len(going):
                return
            groups, member = np.unique(
                np.stack([self.place[going], self.entry[going]], axis=1), axis=0, return_inverse=True
            )
            for k, (place, entry) in enumerate(groups.tolist()):
                self._move(place, entry, going[member.ravel() == k])
        rest = np.flatnonzero(self.place != DONE)
        self.time[rest], self.theta[rest] = np.inf, np.nan
        self._finish(rest, EndReason.EVENTS, "")

    def _move(self, place: int, entry: int, own: Indices) -> None:
        if place < self.first_edge:
            self._through(place, entry, own)
        elif place < self.first_corner:
            self._on_edge(place - self.first_edge, own)
        else:
            self._at_corner(place - self.first_corner, own)

    def _find_orbits(self, going: Indices, *, anchor: bool) -> None:
        """Paths that enter a cell where they entered it before are periodic (Brent: remember legs 1, 2, 4, 8, ...)."""
        inside = going[(self.place[going] < self.first_edge) & (self.entry[going] != DONE)]
        same = (self.anchored[inside] == np.stack([self.place[inside], self.entry[inside]], axis=1)).all(axis=1)
        back = same & (np.abs(self.points[inside] - self.anchors[inside]).max(axis=1, initial=0) <= self.cells.slack)
        for k in inside[back]:
            rate = self.field.flows[self.place[k]][0].omega
            self.time[k], self.theta[k] = np.inf, np.copysign(np.inf, rate) if rate else np.nan
            self._finish(np.array([k]), EndReason.CIRCLES, self.field.names[self.place[k]])
        if anchor:
            self.anchors[inside] = self.points[inside]
            self.anchored[inside] = np.stack([self.place[inside], self.entry[inside]], axis=1)

    # ---- legs ----------------------------------------------------------------------------

    def _through(self, cell: int, entry: int, own: Indices) -> None:
        """Through a cell to its border."""
        self.unique[own] &= not self.field.tied(cell)
        flow, name = self.field.flows[cell][0], self.field.names[cell]
        still = np.abs(velocities(flow, self.points[own])).max(axis=1) <= self.signs.speed_slack
        self._rest(own[still], np.full(int(still.sum()), flow.omega), name)
        own = own[~still]
        active = self._active(cell, entry)
        times = crossing_times(flow, self.cells.polygons[cell].sides, self.points[own], active, self.signs.speed_slack)
        side = np.argmin(times, axis=1)
        time = times[np.arange(len(own)), side]
        circling = own[np.isinf(time)]
        self.time[circling], self.theta[circling] = np.inf, np.copysign(np.inf, flow.omega)
        self._finish(circling, EndReason.CIRCLES, name)
        own, side, time = (values[np.isfinite(time)] for values in (own, side, time))
        x, y, self.theta[own] = Free((self.points[own, 0], self.points[own, 1]), self.theta[own], flow).state(time)
        self.points[own] = np.column_stack([x, y])
        self.time[own] += time
        for k in sorted(set(side.tolist())):  # numpy.unique would import masked arrays
            self._land(cell, k, own[side == k])

    def _active(self, cell: int, entry: int) -> frozenset[int]:
        """Sides on which a cell was entered."""
        if entry == DONE:
            return frozenset()
        if entry < self.first_corner:
            return frozenset((self.cells.side_of(cell, entry - self.first_edge),))
        return frozenset(self.cells.active_sides(cell, entry - self.first_corner))

    def _land(self, cell: int, side: int, own: Indices) -> None:
        """Onto the edge or corner of a side, exactly."""
        for number in self.cells.borders[cell][side]:
            edge, r = self.cells.edges[number], np.array(self.cells.direction(number))
            start, end = np.array(self.cells.points[edge.start]), np.array(self.cells.points[edge.end])
            along, length = (self.points[own] - start) @ r, float((end - start) @ r)
            on = (along > self.cells.slack) & (along < length - self.cells.slack)
            self.points[own[on]], self.place[own[on]] = start + along[on, None] * r, self.first_edge + number
            for corner, distance in ((edge.start, along), (edge.end, along - length)):
                self._reach(corner, own[np.abs(distance) <= self.cells.slack])

    def _reach(self, corner: int, own: Indices) -> None:
        self.points[own], self.place[own] = self.cells.points[corner], self.first_corner + corner

    def _on_edge(self, number: int, own: Indices) -> None:
        """Across an edge, along it, or at rest on it."""
        edge, name = self.cells.edges[number], self.field.place_name(OnEdge(number))
        if edge.left is None or edge.right is None:
            self._finish(own, EndReason.OUTSIDE, name)
            return
        left, right = self.field.flows[edge.left][0], self.field.flows[edge.right][0]
        u, v = (edge_speeds(flow, self.cells.direction(number), self.points[own]) for flow in (left, right))
        n1, n2 = (np.where(np.abs(n) > self.signs.speed_slack, np.sign(n), 0).astype(int) for n in (u.normal, v.normal))
        push, *_ = sliding(v, u)
        opposed, moves = n1 * n2 < 0, np.abs(push) > self.signs.product_slack
        for sense, cell in ((1, edge.left), (-1, edge.right)):
            self._cross(number, cell, own[(n1 == sense) & (n2 == sense)])
        self.unique[own[opposed & (n1 > 0)]] = False
        self.unique[own[opposed]] &= not (self.field.tied(edge.left) or self.field.tied(edge.right))
        for direction in (1, -1):
            self._slide(number, direction, own[opposed & moves & (np.sign(push) * n2 == direction)])
        rests = opposed & ~moves
        turn = v.normal[rests] * left.omega - u.normal[rests] * right.omega
        self._rest(own[rests], turn / (v.normal - u.normal)[rests], name)
        self._one_by_one(own[n1 * n2 == 0])

    def _cross(self, number: int, cell: int, own: Indices) -> None:
        """Into a cell, or to the limit of infinitely many small turns around a corner of the edge."""
        self.place[own], self.entry[own] = cell, self.first_edge + number
        for corner in (self.cells.edges[number].start, self.cells.edges[number].end):
            distance = np.hypot(*(self.points[own] - self.cells.points[corner]).T)
            if not (distance <= self.turns.small).any():
                continue
            turn = self.turns.inward_from(number, cell, corner)
            if turn is None:
                continue
            near = (distance <= self.turns.small) & np.array([turn.fits(s) for s in distance])
            inward = own[near]
            spirals = CornerSpiral(turn, self.cells.points[corner], self.theta[inward], distance[near])
            time, self.theta[inward] = spirals.limit()
            self.time[inward] += time
            self._reach(corner, inward)

    def _slide(self, number: int, direction: int, own: Indices) -> None:
        """Along an edge to its corner, to where sliding ends, or towards an equilibrium."""
        edge = self.cells.edges[number]
        beside = (edge.left, edge.right) if direction > 0 else (edge.right, edge.left)
        left, right = (self.field.flows[cell][0] for cell in beside if cell is not None)
        rx, ry = self.cells.direction(number)
        r = (rx * direction, ry * direction)
        corner = edge.end if direction > 0 else edge.start
        ends = (np.array(self.cells.points[corner]) - self.points[own]) @ np.array(r)
        speeds = edge_speeds(left, r, self.points[own]), edge_speeds(right, r, self.points[own])
        reach, time, rotation = slide_ends(speeds, (left.omega, right.omega), ends)
        self.points[own] += reach[:, None] * np.array(r)
        self.time[own] += time
        self.theta[own] += rotation
        endless = np.isinf(time)
        self._finish(own[endless], EndReason.APPROACH, self.field.place_name(OnEdge(number)))
        there = ~endless & (ends - reach <= self.cells.slack)
        self._reach(corner, own[there])
        self._leave(number, own[~endless & ~there])

    def _leave(self, number: int, own: Indices) -> None:
        """Where sliding ends in between: at one point for all, hence decided once."""
        if not len(own):
            return
        x, y = self.points[own[0]].tolist()
        choices = choices_at(self.field, junction_at(self.field, OnEdge(number), (x, y)), 0.0, self.signs)
        same = float(np.ptp(self.points[own], axis=0).max()) <= self.cells.slack
        if same and len(choices) == 1 and choices[0].kind is EventKind.CROSS:
            self.place[own], self.entry[own] = choices[0].cells[0], self.first_edge + number
        else:
            self._one_by_one(own)

    def _at_corner(self, corner: int, own: Indices) -> None:
        """From a corner: all go the same way."""
        if corner not in self.corners:
            junction = junction_at(self.field, AtCorner(corner), self.cells.points[corner])
            self.corners[corner] = junction, choices_at(self.field, junction, 0.0, self.signs)
        junction, choices = self.corners[corner]
        name, only = self.field.place_name(AtCorner(corner)), len(choices) == 1
        if not choices and junction.border:
            self._finish(own, EndReason.OUTSIDE, name)
        elif only and choices[0].kind is EventKind.CROSS:
            self.place[own], self.entry[own] = choices[0].cells[0], self.first_corner + corner
        elif only and choices[0].kind is EventKind.REST:
            self.unique[own] &= not self.turns.lead_outward(corner)
            self._rest(own, np.full(len(own), choices[0].rate), name)
        else:
            self._one_by_one(own)

    # ---- ends ----------------------------------------------------------------------------

    def _rest(self, own: Indices, rates: Floats, name: str) -> None:
        """At rest; where theta drifts on, it has no limit."""
        turning = np.abs(rates) > self.signs.rate_slack
        self.theta[own[turning]] = np.copysign(np.inf, rates[turning])
        self._finish(own[turning], EndReason.TURNING, name)
        self._finish(own[~turning], EndReason.REST, name)

    def _finish(self, own: Indices, reason: EndReason, name: str) -> None:
        self.place[own] = DONE
        for k in own:
            self.ends[k] = (reason, name)

    def _one_by_one(self, own: Indices) -> None:
        """Follow starts by the scalar integrator from where they are; those at the same point, together.

        The velocity does not depend on theta, so that all who are at one point go the same way and turn by as much.
        """
        points, member = np.unique(self.points[own], axis=0, return_inverse=True)
        for k, (x, y) in enumerate(points.tolist()):
            together = own[member.ravel() == k]
            path = follow_cells(self.field, (x, y, 0.0))
            last = path.pieces[-1] if path.pieces else None
            name = last.place if last else self._place_of(points[k])
            self.time[together] += float(path.time)
            self.points[together] = path.pose[:2]
            self.theta[together] += float(path.pose[2])
            if path.reason is EndReason.TURNING and last is not None:
                self.theta[together] = np.copysign(np.inf, last.state(1.0)[2] - last.state(0.0)[2])
            elif path.reason in (EndReason.CIRCLES, EndReason.EVENTS):
                self.time[together], self.theta[together] = np.inf, np.nan
            self.unique[together] &= all(e.drift_only for e in path.events if e.kind is EventKind.NONUNIQUE)
            self._finish(together, path.reason, name)

    def _place_of(self, point: Floats) -> str:
        place = self.cells.locate((float(point[0]), float(point[1])))
        return "" if place is None else self.field.place_name(place)


# ---- motions of a batch --------------------------------------------------------------------------


def velocities(flow: Flow, points: Floats) -> Floats:
    """``c'`` at points (m, 2)."""
    return np.array([flow.vx, flow.vy]) + flow.turn * turned(points)


def crossing_times(
    flow: Flow, sides: Sequence[HalfPlane], points: Floats, active: frozenset[int], slack: float
) -> Floats:
    """Time until each side is crossed, (m, sides); infinite where it never is."""
    normals: Any = np.array([side.normal for side in sides], float).T
    velocity: Any = velocities(flow, points).T[..., None]
    at: Any = points.T[..., None]
    rate, bend = dot(velocity, normals), cross(velocity, normals)
    gap = np.array([side.offset for side in sides], float) - dot(normals, at)
    entered, w = sorted(active), float(flow.turn)
    if not w:
        found = np.divide(np.maximum(gap, 0.0), rate, out=np.full(rate.shape, np.inf), where=rate > 0)
        found[:, entered] = np.inf
        return found
    found = line_times(w, gap, rate, bend)
    if entered:
        back = times_back(w, rate[:, entered], bend[:, entered])
        found[:, entered] = np.where(np.abs(rate[:, entered]) > slack, back, np.inf)
    return found


def edge_speeds(flow: Flow, direction: Point, points: Floats) -> RaySpeeds:
    """Speeds of a neighbour of an edge of unit direction: towards the left of the edge, and along it."""
    velocity: Any = velocities(flow, points).T
    return RaySpeeds(cross(direction, velocity), flow.turn, dot(direction, velocity))


class SlideEnds(NamedTuple):
    """How slides end: distance covered, time taken (infinite: an equilibrium is approached), rotation."""

    reach: Floats
    time: Floats
    rotation: Floats


def slide_ends(speeds: tuple[RaySpeeds, RaySpeeds], omegas: tuple[float, float], ends: Floats) -> SlideEnds:
    """Slides along a unit direction from points with the given speeds to the corner at distance ``ends``.

    Speeds and rotation rates of the left and the right cell; the normal speeds are of opposite strict signs at the
    start.
    """
    (n1, b1, p1), (n2, b2, p2) = speeds
    a, b, c, d = sliding(speeds[1], speeds[0])
    k = n2 * omegas[0] - n1 * omegas[1]
    first, second = n1 * b2, n2 * b1
    fixed = np.abs(first - second) <= PROPORTIONAL_DOUBT * (np.abs(first) + np.abs(second))
    share = n2 / c
    a, c = np.where(fixed, share * p1 + (1 - share) * p2, a), np.where(fixed, 1.0, c)
    b, d = np.where(fixed, 0.0, b), np.where(fixed, 0.0, d)
    k = np.where(fixed, share * omegas[0] + (1 - share) * omegas[1], k)
    reach = np.array(ends)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for normal, turn in ((n1, b1), (n2, b2)):
            if turn:
                reach = np.where(-normal / turn > 0, np.minimum(reach, -normal / turn), reach)
        stop = -a / b
        endless = (stop > 0) & (stop <= reach * (1 + ASYMPTOTE_DOUBT))
        x = np.where(endless, 0.0, b * reach / a)
        time = c * reach / a * _logarithm(x) + d * reach**2 / a * _second_logarithm(x)
        rotation = k * reach / a * _logarithm(x)
    turning = np.where(k != 0, np.copysign(np.inf, k * a), 0.0)
    return SlideEnds(
        np.where(endless, stop, reach), np.where(endless, np.inf, time), np.where(endless, turning, rotation)
    )


def _logarithm(x: Floats) -> Floats:
    """``log(1 + x)/x``, one at zero."""
    safe = np.where(x == 0, 1.0, x)
    return np.where(x == 0, 1.0, np.log1p(safe) / safe)


def _second_logarithm(x: Floats) -> Floats:
    """``(x - log(1 + x))/x^2``, one half at zero."""
    small = np.abs(x) < SERIES_BELOW
    near = np.where(small, x, 0.0)
    series = sum((-near) ** k / (k + 2) for k in range(SERIES_TERMS))
    far = np.where(small, 1.0, x)
    return np.where(small, series, (far - np.log1p(far)) / far**2)
