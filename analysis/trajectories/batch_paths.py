"""Many paths at once through cells with constant twist: where each ends, when, and with which heading.

They may go through several fields: then the cells, edges and corners of all of these are numbered in a row, and every
path stays among those of its own.

The method is that of :mod:`nonsmooth.analysis.trajectories.piecewise_constant`, without the path between its ends.  In
one leg all paths inside cells move together, whatever their cells, and so do all that are on edges.  Only the generic
case is vectorized: paths through cells, strict crossings, strict sliding and rest on an edge.  What happens at a corner
or where sliding ends is the same for all that get there, so it is decided once.  Every other start (on an edge, tangent
to one) is handed to the scalar integrator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import AtCorner, InCell, OnEdge
from nonsmooth.analysis.cells.fan import RaySpeeds, sliding
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow
from nonsmooth.analysis.trajectories.closed_forms import (
    ASYMPTOTE_DOUBT,
    PROPORTIONAL_DOUBT,
    SERIES_BELOW,
    SERIES_TERMS,
    CornerSpiral,
    Junction,
    Turns,
    junction_at,
    line_times,
    signs_of,
    times_back,
)
from nonsmooth.analysis.trajectories.piecewise_constant import Choice, choices_at, follow_cells
from nonsmooth.analysis.trajectories.result import EndReason, EventKind
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Indices,
    Mask,
    cross,
    dot,
    float_points,
    norms,
    spread,
    turned,
)

MAX_LEGS = 2_000  # legs per start; paths of the built-in scenes have fewer than 20
DONE = -1  # the place of a path that has ended
NONE = -1  # where there is no cell or edge

OnRow: TypeAlias = Callable[[int, int], None]


class JoinedField(NamedTuple):
    """A field among others, and the numbers of its first cell, edge and corner in the row of all."""

    field: ConstantField
    turns: Turns
    cell: int
    edge: int
    corner: int


class BatchPaths:
    """Starts on their way.

    ``place`` numbers cells, then edges, then corners; ``entry`` is the edge or corner from which a cell was entered.
    What counts as zero is for each path that of its field.
    """

    def __init__(self, fields: Sequence[ConstantField], starts: Sequence[Floats], theta: float) -> None:
        self.regions = list(_in_a_row(fields))
        self.arrays = CellArrays.joined(self.regions)
        self.first_edge = len(self.arrays.flows)
        self.first_corner = self.first_edge + len(self.arrays.starts)
        self.starts = np.concatenate([np.array(points, dtype=float) for points in starts])
        self.points = self.starts.copy()
        count = len(self.points)
        self.region = np.repeat(np.arange(len(fields)), [len(points) for points in starts])
        slacks = np.array([_slacks(region) for region in self.regions])[self.region]
        self.slack, self.speed_slack, self.product_slack, self.rate_slack, self.small = slacks.T
        self.theta, self.time = np.full(count, theta), np.zeros(count)
        self.unique = np.ones(count, dtype=bool)
        self.ends: list[tuple[EndReason, str] | None] = [None] * count
        self.place, self.entry = np.full(count, DONE), np.full(count, DONE)
        self.anchors, self.anchored = np.full((count, 2), np.nan), np.full((count, 2), DONE)
        self.corners: dict[int, tuple[Junction, list[Choice]]] = {}
        for number, region in enumerate(self.regions):
            paths = np.flatnonzero(self.region == number)
            inside = region.field.depths(self.points[paths]) > region.field.cells.slack
            held = inside.any(axis=1)
            self.place[paths[held]] = region.cell + inside[held].argmax(axis=1)
            self._one_by_one(paths[~held])

    def run(self, report: OnRow | None = None) -> None:
        """Leg after leg; ``report`` is told how many of all starts have ended."""
        for leg in range(MAX_LEGS):
            self._find_orbits(np.flatnonzero(self.place != DONE), anchor=leg & (leg - 1) == 0)
            going = np.flatnonzero(self.place != DONE)
            if report is not None:
                report(len(self.place) - len(going), len(self.place))
            if not len(going):
                return
            place = self.place[going]
            inside, corners = place < self.first_edge, place >= self.first_corner
            self._through(going[inside])
            self._on_edge(going[~(inside | corners)])
            for corner in sorted(set(place[corners].tolist())):  # numpy.unique would import masked arrays
                self._at_corner(corner - self.first_corner, going[place == corner])
        rest = np.flatnonzero(self.place != DONE)
        self.time[rest], self.theta[rest] = np.inf, np.nan
        self._finish(rest, EndReason.EVENTS, "")

    def _find_orbits(self, going: Indices, *, anchor: bool) -> None:
        """Paths that enter a cell where they entered it before are periodic (Brent: remember legs 1, 2, 4, 8, ...)."""
        inside = going[(self.place[going] < self.first_edge) & (self.entry[going] != DONE)]
        entered = np.column_stack([self.place[inside], self.entry[inside]])
        same = (self.anchored[inside] == entered).all(axis=1)
        back = same & (np.abs(self.points[inside] - self.anchors[inside]).max(axis=1, initial=0) <= self.slack[inside])
        if anchor:
            self.anchors[inside], self.anchored[inside] = self.points[inside], entered
        orbits = inside[back]
        rate = self.arrays.flow(self.place[orbits]).omega
        self.time[orbits], self.theta[orbits] = np.inf, np.where(rate != 0, np.copysign(np.inf, rate), np.nan)
        self._finish(orbits, EndReason.CIRCLES)

    # ---- legs ----------------------------------------------------------------------------

    def _through(self, paths: Indices) -> None:
        """Through cells to their borders."""
        cell = self.place[paths]
        self.unique[paths] &= ~self.arrays.tied[cell]
        flow = self.arrays.flow(cell)
        still = np.abs(velocities(flow, self.points[paths])).max(axis=1, initial=0) <= self.speed_slack[paths]
        self._rest(paths[still], flow.omega[still])
        paths, cell = paths[~still], cell[~still]
        flow, normals, offsets = self.arrays.flow(cell), self.arrays.normals[cell], self.arrays.offsets[cell]
        times = crossing_times(
            flow, normals, offsets, self.points[paths], self._entered(paths), self.speed_slack[paths]
        )
        time = times.min(axis=1)
        circles = np.isinf(time)
        self.time[paths[circles]], self.theta[paths[circles]] = np.inf, np.copysign(np.inf, flow.omega[circles])
        self._finish(paths[circles], EndReason.CIRCLES)
        paths, cell, side, time = (values[~circles] for values in (paths, cell, times.argmin(axis=1), time))
        flow = self.arrays.flow(cell)
        self.points[paths] = moved(flow, self.points[paths], time)
        self.theta[paths] += flow.omega * time
        self.time[paths] += time
        self._land(paths, self.arrays.borders[cell, side])

    def _entered(self, paths: Indices) -> Mask:
        """Through which sides of their cells paths came in, (m, sides)."""
        cell, entry = self.place[paths], self.entry[paths]
        entered = np.zeros(self.arrays.offsets[cell].shape, dtype=bool)
        by_edge = np.flatnonzero((entry != DONE) & (entry < self.first_corner))
        edge = entry[by_edge] - self.first_edge
        is_left = self.arrays.beside[edge, 0] == cell[by_edge]
        entered[by_edge, np.where(is_left, *self.arrays.sides[edge].T)] = True
        for k in np.flatnonzero(entry >= self.first_corner).tolist():
            region = self._region_of(paths[k])
            corner = int(entry[k]) - self.first_corner - region.corner
            entered[k, list(region.field.cells.active_sides(int(cell[k]) - region.cell, corner))] = True
        return entered

    def _land(self, paths: Indices, borders: Indices) -> None:
        """Onto one of the edges of a side, (m, edges), or onto a corner of them, exactly."""
        for edge in borders.T:
            there = edge != NONE
            self._land_on(paths[there], edge[there])

    def _land_on(self, paths: Indices, edge: Indices) -> None:
        """Onto edges or corners of them, where they are there."""
        r, start, end = self.arrays.directions[edge], self.arrays.starts[edge], self.arrays.ends[edge]
        begin = self.arrays.points[start]
        along, length = dot(self.points[paths] - begin, r), dot(self.arrays.points[end] - begin, r)
        slack = self.slack[paths]
        on = (along > slack) & (along < length - slack)
        self.points[paths[on]] = (begin + along[:, None] * r)[on]
        self.place[paths[on]] = self.first_edge + edge[on]
        for corner, distance in ((start, along), (end, along - length)):
            near = np.abs(distance) <= slack
            self._reach(paths[near], corner[near])

    def _reach(self, paths: Indices, corner: Indices) -> None:
        self.points[paths], self.place[paths] = self.arrays.points[corner], self.first_corner + corner

    def _on_edge(self, paths: Indices) -> None:
        """Across edges, along them, or at rest on them."""
        edge = self.place[paths] - self.first_edge
        inner = (self.arrays.beside[edge] != NONE).all(axis=1)
        self._finish(paths[~inner], EndReason.OUTSIDE)
        paths, edge = paths[inner], edge[inner]
        cells, r = self.arrays.beside[edge], self.arrays.directions[edge]
        left, right = (self.arrays.flow(cells[:, k]) for k in (0, 1))
        u, v = (edge_speeds(flow, r, self.points[paths]) for flow in (left, right))
        n1, n2 = (np.where(np.abs(n) > self.speed_slack[paths], np.sign(n), 0) for n in (u.normal, v.normal))
        push, *_ = sliding(v, u)
        opposed, moves = n1 * n2 < 0, np.abs(push) > self.product_slack[paths]
        for sense, k in ((1, 0), (-1, 1)):
            crosses = (n1 == sense) & (n2 == sense)
            self._cross(paths[crosses], edge[crosses], cells[crosses, k])
        self.unique[paths[opposed & (n1 > 0)]] = False
        self.unique[paths[opposed]] &= ~self.arrays.tied[cells[opposed]].any(axis=1)
        slides, rests = opposed & moves, opposed & ~moves
        self._slide(paths[slides], edge[slides], forward=np.sign(push[slides]) * n2[slides] > 0)
        turn = v.normal[rests] * left.omega[rests] - u.normal[rests] * right.omega[rests]
        self._rest(paths[rests], turn / (v.normal - u.normal)[rests])
        self._one_by_one(paths[n1 * n2 == 0])

    def _cross(self, paths: Indices, edge: Indices, cell: Indices) -> None:
        """Into cells, or to the limit of infinitely many small turns around a corner of the edge."""
        if not len(paths):
            return
        self.place[paths], self.entry[paths] = cell, self.first_edge + edge
        for corner in (self.arrays.starts[edge], self.arrays.ends[edge]):
            distance = norms(self.points[paths] - self.arrays.points[corner])
            for k in np.flatnonzero(distance <= self.small[paths]).tolist():
                region = self._region_of(paths[k])
                numbers = int(edge[k]) - region.edge, int(cell[k]) - region.cell, int(corner[k]) - region.corner
                turn = region.turns.inward_from(*numbers)
                if turn is not None and turn.fits(distance[k]):
                    around = region.field.cells.points[numbers[-1]]
                    spiral = CornerSpiral(turn, around, self.theta[paths[k]], distance[k])
                    time, self.theta[paths[k]] = spiral.limit()
                    self.time[paths[k]] += time
                    self._reach(paths[k : k + 1], corner[k : k + 1])

    def _slide(self, paths: Indices, edge: Indices, *, forward: Mask) -> None:
        """Along edges to a corner, to where sliding ends, or towards an equilibrium."""
        if not len(paths):
            return
        cells, r = self.arrays.beside[edge], self.arrays.directions[edge]
        cells, r = np.where(forward[:, None], cells, cells[:, ::-1]), np.where(forward[:, None], r, -r)
        corner = np.where(forward, self.arrays.ends[edge], self.arrays.starts[edge])
        ends = dot(self.arrays.points[corner] - self.points[paths], r)
        left, right = (self.arrays.flow(cells[:, k]) for k in (0, 1))
        speeds = edge_speeds(left, r, self.points[paths]), edge_speeds(right, r, self.points[paths])
        reach, time, rotation = slide_ends(speeds, (left.omega, right.omega), ends)
        self.points[paths] += reach[:, None] * r
        self.time[paths] += time
        self.theta[paths] += rotation
        endless = np.isinf(time)
        self._finish(paths[endless], EndReason.APPROACH)
        there = ~endless & (ends - reach <= self.slack[paths])
        self._reach(paths[there], corner[there])
        between = ~endless & ~there
        for number, ahead in sorted(set(zip(edge[between].tolist(), forward[between].tolist(), strict=True))):
            self._leave(number, paths[between & (edge == number) & (forward == ahead)])

    def _leave(self, number: int, paths: Indices) -> None:
        """Where sliding along an edge in one direction ends in between: at one point for all, hence decided once."""
        (x, y), region = self.points[paths[0]].tolist(), self._region_of(paths[0])
        _, choices = _ways_from(region, OnEdge(number - region.edge), (x, y))
        same = spread(self.points[paths]) <= region.field.cells.slack
        self._go_on(paths, choices if same else [], self.first_edge + number)

    def _at_corner(self, corner: int, paths: Indices) -> None:
        """From a corner: all go the same way."""
        region = self._region_of(paths[0])
        if corner not in self.corners:
            place = AtCorner(corner - region.corner)
            self.corners[corner] = _ways_from(region, place, region.field.cells.points[place.corner])
        junction, choices = self.corners[corner]
        if not choices and junction.border:
            self._finish(paths, EndReason.OUTSIDE)
        elif len(choices) == 1 and choices[0].kind is EventKind.REST:
            self.unique[paths] &= not region.turns.lead_outward(corner - region.corner)
            self._rest(paths, np.full(len(paths), choices[0].rate))
        else:
            self._go_on(paths, choices, self.first_corner + corner)

    def _go_on(self, paths: Indices, choices: Sequence[Choice], entry: int) -> None:
        """From an edge or corner into a cell, where that is the only choice of all paths; else one by one."""
        if len(choices) == 1 and choices[0].kind is EventKind.CROSS:
            self.place[paths], self.entry[paths] = self._region_of(paths[0]).cell + choices[0].cells[0], entry
        else:
            self._one_by_one(paths)

    # ---- ends ----------------------------------------------------------------------------

    def _rest(self, paths: Indices, rates: Floats) -> None:
        """At rest; where theta drifts on, it has no limit."""
        turning = np.abs(rates) > self.rate_slack[paths]
        self.theta[paths[turning]] = np.copysign(np.inf, rates[turning])
        self._finish(paths[turning], EndReason.TURNING)
        self._finish(paths[~turning], EndReason.REST)

    def _finish(self, paths: Indices, reason: EndReason, name: str | None = None) -> None:
        """The end of paths, where they are or at a place of another name."""
        for k in paths.tolist():
            self.ends[k] = reason, self._name_of(k) if name is None else name
        self.place[paths] = DONE

    def _name_of(self, path: int) -> str:
        """The name of the place where a path is."""
        region, place = self._region_of(path), int(self.place[path])
        if place < self.first_edge:
            return region.field.place_name(InCell(place - region.cell))
        if place < self.first_corner:
            return region.field.place_name(OnEdge(place - self.first_edge - region.edge))
        return region.field.place_name(AtCorner(place - self.first_corner - region.corner))

    def _one_by_one(self, paths: Indices) -> None:
        """Follow starts by the scalar integrator from where they are; those at the same point, together.

        The velocity does not depend on theta, so that all who are at one point go the same way and turn by as much.
        """
        if not len(paths):
            return
        points, member = np.unique(
            np.column_stack([self.region[paths], self.points[paths]]), axis=0, return_inverse=True
        )
        for k, (_, x, y) in enumerate(points.tolist()):
            together = paths[member.ravel() == k]
            field = self._region_of(together[0]).field
            path = follow_cells(field, (x, y, 0.0))
            last = path.pieces[-1] if path.pieces else None
            place = last.place if last else _place_at(field, x, y)
            self.time[together] += float(path.time)
            self.points[together] = path.pose[:2]
            self.theta[together] += float(path.pose[2])
            if path.reason is EndReason.TURNING and last is not None:
                self.theta[together] = np.copysign(np.inf, last.state(1.0)[2] - last.state(0.0)[2])
            elif path.reason in (EndReason.CIRCLES, EndReason.EVENTS):
                self.time[together], self.theta[together] = np.inf, np.nan
            self.unique[together] &= all(e.drift_only for e in path.events if e.kind is EventKind.NONUNIQUE)
            self._finish(together, path.reason, place)

    def _region_of(self, path: int) -> JoinedField:
        return self.regions[self.region[path]]


def _in_a_row(fields: Sequence[ConstantField]) -> Iterator[JoinedField]:
    cell = edge = corner = 0
    for field in fields:
        yield JoinedField(field, Turns(field, signs_of(field)), cell, edge, corner)
        cell, edge = cell + len(field.flows), edge + len(field.cells.edges)
        corner += len(field.cells.corners)


def _slacks(region: JoinedField) -> tuple[float, float, float, float, float]:
    """What counts as zero of lengths, speeds, their products and rates, and which distances from corners are small."""
    signs = region.turns.signs
    return region.field.cells.slack, signs.speed_slack, signs.product_slack, signs.rate_slack, region.turns.small


def _ways_from(region: JoinedField, place: OnEdge | AtCorner, point: Point) -> tuple[Junction, list[Choice]]:
    """What meets at a point of an edge or at a corner, and how paths go on there."""
    junction = junction_at(region.field, place, point)
    return junction, choices_at(region.field, junction, 0.0, region.turns.signs)


def _place_at(field: ConstantField, x: float, y: float) -> str:
    place = field.cells.locate((x, y))
    return "" if place is None else field.place_name(place)


# ---- fields as arrays, by the numbers of cells and edges -----------------------------------------


class CellArrays(NamedTuple):
    """What paths need of their cells and edges.

    Attributes:
        flows: ``(vx, vy, omega, turn)`` of every cell, (cells, 4).
        tied: whether several motions tie in a cell, (cells,).
        normals: outward unit normals of its sides, (cells, sides, 2); zero where a cell has fewer sides than another.
        offsets: of these sides, (cells, sides); infinite where there is none.
        borders: the edges on each side, (cells, sides, edges); :data:`NONE` where there are fewer.
        points: of corners, (corners, 2).
        starts, ends: corners of every edge, (edges,).
        directions: from start to end, of unit length, (edges, 2).
        beside: the cells on the left and on the right, (edges, 2); :data:`NONE` beyond the domain.
        sides: on which of their sides the edge lies, (edges, 2).
    """

    flows: Floats
    tied: Mask
    normals: Floats
    offsets: Floats
    borders: Indices
    points: Floats
    starts: Indices
    ends: Indices
    directions: Floats
    beside: Indices
    sides: Indices

    @classmethod
    def of(cls, field: ConstantField) -> Self:
        """Those of a field in floats."""
        cells, edges = field.cells, field.cells.edges
        shape = len(cells.polygons), max(len(polygon.sides) for polygon in cells.polygons)
        normals, offsets = np.zeros((*shape, 2)), np.full(shape, np.inf)
        borders = np.full(
            (*shape, max(len(border) for borders_of_cell in cells.borders for border in borders_of_cell)), NONE
        )
        beside, sides = np.full((2, len(edges), 2), NONE)
        for cell, (polygon, cell_borders) in enumerate(zip(cells.polygons, cells.borders, strict=True)):
            for k, (side, border) in enumerate(zip(polygon.sides, cell_borders, strict=True)):
                normals[cell, k], offsets[cell, k], borders[cell, k, : len(border)] = side.normal, side.offset, border
                for edge in border:
                    column = 0 if edges[edge].left == cell else 1
                    beside[edge, column], sides[edge, column] = cell, k
        flows = np.array([(motions[0].vx, motions[0].vy, motions[0].omega, motions[0].turn) for motions in field.flows])
        tied = np.array([field.tied(cell) for cell in range(len(flows))])
        points, (starts, ends) = float_points(cells.points), np.array([(edge.start, edge.end) for edge in edges]).T
        along = points[ends] - points[starts]
        directions = along / norms(along)[:, None]
        return cls(flows, tied, normals, offsets, borders, points, starts, ends, directions, beside, sides)

    @classmethod
    def joined(cls, regions: Sequence[JoinedField]) -> Self:
        """Those of several fields, numbered in a row."""
        arrays = [cls.of(region.field) for region in regions]
        if len(arrays) == 1:
            return arrays[0]
        most_sides, most_edges = np.array([table.borders.shape[1:] for table in arrays]).max(axis=0)
        rows = [
            (
                table.flows,
                table.tied,
                _padded(table.normals, (most_sides, 2), 0.0),
                _padded(table.offsets, (most_sides,), np.inf),
                _padded(_further(table.borders, region.edge), (most_sides, most_edges), NONE),
                table.points,
                table.starts + region.corner,
                table.ends + region.corner,
                table.directions,
                _further(table.beside, region.cell),
                table.sides,
            )
            for table, region in zip(arrays, regions, strict=True)
        ]
        return cls(*map(np.concatenate, zip(*rows, strict=True)))

    def flow(self, cell: Indices) -> Flow:
        """The motions in cells (m,), each entry of shape (m,)."""
        return Flow(*self.flows[cell].T)


def _further(numbers: Indices, first: int) -> Indices:
    """Numbers that begin at another one; where there is none there is none."""
    return np.where(numbers == NONE, NONE, numbers + first)


def _padded(values: Any, shape: tuple[int, ...], fill: float) -> Any:
    """An array with longer axes after its first one; what is new is filled."""
    longer = np.full((len(values), *shape), fill, dtype=values.dtype)
    longer[tuple(map(slice, values.shape))] = values
    return longer


# ---- motions of a batch: flows with entries of shape (m,) ----------------------------------------


def velocities(flow: Flow, points: Floats) -> Floats:
    """``c'`` at points (m, 2)."""
    return np.column_stack([flow.vx - flow.turn * points[:, 1], flow.vy + flow.turn * points[:, 0]])


def moved(flow: Flow, points: Floats, time: Floats) -> Floats:
    """Where motions from points (m, 2) are after a time of each, (m, 2)."""
    velocity, w = velocities(flow, points), flow.turn
    divisor = np.where(w != 0, w, 1.0)
    along = np.where(w != 0, np.sin(w * time) / divisor, time)
    across = 2 * np.sin(w * time / 2) ** 2 / divisor
    return points + along[:, None] * velocity + across[:, None] * turned(velocity)


def crossing_times(
    flow: Flow, normals: Floats, offsets: Floats, points: Floats, entered: Mask, slack: Floats
) -> Floats:
    """Time until each side of its cell is crossed, (m, sides); infinite where it never is.

    Args:
        flow: the motions.
        normals: of the sides, (m, sides, 2); zero where there is none.
        offsets: of the sides, (m, sides); infinite where there is none.
        points: inside the cells, (m, 2).
        entered: whether the path came in through the side, (m, sides): to it only an arc comes back.
        slack: normal speeds that are zero within rounding, (m,).
    """
    velocity = velocities(flow, points)[:, None]
    rate, bend, gap = dot(velocity, normals), cross(velocity, normals), offsets - dot(normals, points[:, None])
    found = np.divide(np.maximum(gap, 0.0), rate, out=np.full(rate.shape, np.inf), where=(rate > 0) & ~entered)
    arcs = flow.turn != 0
    if arcs.any():
        w, rate, bend, entered = flow.turn[arcs, None], rate[arcs], bend[arcs], entered[arcs]
        back = np.where(np.abs(rate) > slack[arcs, None], times_back(w, rate, bend), np.inf)
        found[arcs] = np.where(entered, back, line_times(w, gap[arcs], rate, bend))
    return found


def edge_speeds(flow: Flow, directions: Floats, points: Floats) -> RaySpeeds:
    """Speeds of neighbours of edges of unit directions (m, 2): towards the left of the edge, and along it."""
    velocity = velocities(flow, points)
    return RaySpeeds(cross(directions, velocity), flow.turn, dot(directions, velocity))


class SlideEnds(NamedTuple):
    """How slides end: distance covered, time taken (infinite: an equilibrium is approached), rotation."""

    reach: Floats
    time: Floats
    rotation: Floats


def slide_ends(speeds: tuple[RaySpeeds, RaySpeeds], omegas: tuple[Floats, Floats], ends: Floats) -> SlideEnds:
    """Slides along unit directions from points with the given speeds to the corners at distances ``ends`` (m,).

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
            vanishes = -normal / turn
            reach = np.where(vanishes > 0, np.minimum(reach, vanishes), reach)
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
    far = np.where(small, 1.0, x)
    found = (far - np.log1p(far)) / far**2
    if small.any():
        found[small] = sum((-x[small]) ** k / (k + 2) for k in range(SERIES_TERMS))
    return found
