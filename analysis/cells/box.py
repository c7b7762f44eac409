"""Rule ``box``: the exact minimizer of the power dissipation functional, one twist per polygon of the plane.

Each slope of D at a vertex of the arrangement (:mod:`nonsmooth.analysis.cells.arrangement`) is affine in the
centre of mass, so the cell of a vertex, where all its slopes are non-negative, is a convex polygon in explicit
half-plane form.  Where a slope vanishes, D is flat along that edge up to the next vertex: that vertex owns the cell
beyond. So the partition is found by walking from cell to neighbouring cell, one ratio test per side, never by trying
all C(2n, 3) triples.  Ties beyond a side (symmetric arrays) are resolved by an exact descent just outside it: slopes
are compared by value first, then by derivative along the outward normal.  The cells' areas must add up to the
domain's: that checks the walk, and it is Theorem 1 of Murphey & Burdick made checkable.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.arrangement import (
    Arrangement,
    Beside,
    SlopeOfD,
    Vertex,
    beyond_floats,
    float_corners,
    is_multiple,
    normal_floats,
    order,
)
from nonsmooth.analysis.cells.loads import Affine, LoadRegion, at_least_zero, load_regions
from nonsmooth.analysis.cells.nearest import preferred_rows
from nonsmooth.analysis.cells.partition import PARTITION_UNITS, Cell, Partition, affordable, require_rank
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, square
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.symbolic.mechanics.constraints import Twist, independent, rows_with_friction, scene_rows, wheel_rows
from nonsmooth.symbolic.mechanics.contact_states import ContactState, solve_rows
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import Lazy, is_long

STEP = "cells of rule box"


@beyond_floats
def build_box_partition(scene: Scene, domain: Polygon | None = None) -> Partition:
    """Cells of rule ``box`` in the checked square, or in another domain within the support polygon.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
    """
    require_rank(rows_with_friction(scene), "friction: required rows")
    cells: list[Cell] = []
    with affordable(scene, PARTITION_UNITS, STEP):
        for region in load_regions(scene, domain=domain):
            known = dict.fromkeys(twist for cell in cells for twist in cell.twists)
            for states, polygon in _Walk(scene, region, tuple(known)).cells():
                cells.append(Cell(len(cells) + 1, polygon, states))
    domain = domain or square(scene.check.equilibrium, scene.check.radius)
    return Partition(scene, "box", domain, tuple(cells), len(scene.wheels))


@beyond_floats
def build_rest_partition(scene: Scene) -> Partition | None:
    """The cells of rest alone, where they hold the centred equilibrium in their interior; None where they do not.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
    """
    zero = scene.field.zero
    cells: list[Cell] = []
    with affordable(scene, PARTITION_UNITS, STEP):
        for region in load_regions(scene):
            walk = _Walk(scene, region)
            found = walk.cell_of(Twist(zero, zero, zero)) if region.polygon.contains((zero, zero)) else None
            if found is not None:
                states, polygon = found
                cells.append(Cell(len(cells) + 1, polygon, states))
    inner = [cell for cell in cells if _surrounds(cell.polygon, (zero, zero))]
    if len(cells) != len(inner):
        return None
    domain = square(scene.check.equilibrium, scene.check.radius)
    return Partition(scene, "box", domain, tuple(inner), len(scene.wheels), complete=False) if inner else None


def _surrounds(polygon: Polygon, point: Point) -> bool:
    """Whether no side of the cell passes through the point, but for the boundary of a load region."""
    return all(side.slack(point).sign() > 0 for side in polygon.sides if side.label.startswith("slope"))


class Crossing(NamedTuple):
    """A side across which the walk came to a cell: its line and its ends."""

    line: Affine
    ends: tuple[Point, Point]


class _Walk:
    """The cells of one load region.

    Args:
        scene: the array.
        region: where the loads are affine.
        known: twists that own cells of other regions: the descent starts from the best of them.
    """

    def __init__(self, scene: Scene, region: LoadRegion, known: tuple[Twist, ...] = ()) -> None:
        rows = (row for row in scene_rows(scene) if row.friction and any(region.forces[scene.places[row.wheel.index]]))
        require_rank(rows, "contact.loads: required loaded rows")
        self.scene = scene
        self.region = region
        self.known = known
        self.arrangement = Arrangement(scene, region)
        self._slopes: dict[Vertex, Slopes] = {}
        self._crossed: defaultdict[Vertex, list[Crossing]] = defaultdict(list)

    def slopes(self, vertex: Vertex) -> Slopes:
        """The slopes of D at a vertex (cached)."""
        if vertex not in self._slopes:
            self._slopes[vertex] = Slopes(self.arrangement, vertex.signs)
        return self._slopes[vertex]

    def cell_of(self, twist: Twist) -> tuple[tuple[ContactState, ...], Polygon] | None:
        """States and polygon of one twist that solves three independent rows; None where it owns no cell."""
        signs = [row.residual(twist).sign() for row in self.arrangement.rows]
        tight = [row.normal for row, sign in zip(self.arrangement.rows, signs, strict=True) if not sign]
        if len(independent(tight)) < 3:
            return None
        vertex = self.arrangement.vertex(twist)
        polygon, _ = self._polygon(vertex)
        return None if polygon is None else (tuple(self._state(v) for v in self._face(vertex)), polygon)

    def cells(self) -> Iterator[tuple[tuple[ContactState, ...], Polygon]]:
        """Cells (tied states, polygon) of the region, each once.

        The least value of D is the least of affine functions of c, one for each vertex, so cells meet in whole sides:
        beyond a side on a line across which the walk came lies the cell from which it came.
        """
        done: set[Vertex] = set()
        waiting = [self._first()]
        while waiting:
            vertex = waiting.pop()
            if vertex in done:
                continue
            face = self._face(vertex)
            done.update(face)
            polygon, origins = self._polygon(vertex)
            if polygon is None:
                continue
            yield tuple(self._state(v) for v in face), polygon
            explored = [crossing.line for v in face for crossing in self._crossed[v]]
            for k, side in enumerate(polygon.sides):
                slope = origins.get(side.label)
                if slope is None or any(is_multiple(slope.form, line) for line in explored):
                    continue
                place = Beside(_midpoint(polygon, k), side.normal, slope.form)
                neighbour = self._descend(vertex, place, slope)
                self._crossed[neighbour].append(Crossing(slope.form, _ends(polygon, k)))
                waiting.append(neighbour)

    def _first(self) -> Vertex:
        """Descend to the optimal vertex just beside the centre of the region, from the best twist at hand."""
        centre = self.region.polygon.centre
        # both rows of the nearest wheel and one of the next at another place: any independent rows would do
        near, *others = sorted(self.scene.wheels, key=lambda w: sum(float(p) * float(p) for p in w.position))
        rows = (row for wheel in others for row in preferred_rows(wheel))
        state = next(state for row in rows if (state := solve_rows((*wheel_rows(near), row))) is not None)
        twists = (state.twist, *self.known)
        start = min(twists, key=lambda twist: self.arrangement.float_dissipation(twist, centre))
        one = self.scene.field.one
        outward = (one, one * 7 / 11)  # a direction along no usual symmetry axis: it only breaks ties
        return self._descend(self.arrangement.vertex(start), Beside(centre, outward))

    def _descend(self, vertex: Vertex, place: Beside, falling: SlopeOfD | None = None) -> Vertex:
        """Exact descent beside a point, first along a slope that falls there if one is known.

        Every step lowers D, so it ends at the minimizer.
        """
        falling = falling or self._falling(vertex, place, None)
        while falling is not None:
            vertex, back = self.arrangement.line_search(vertex, falling, place)
            falling = self._falling(vertex, place, self.slopes(vertex).learn(back))
        return vertex

    def _falling(self, vertex: Vertex, place: Beside, back: int | None) -> SlopeOfD | None:
        """A slope that falls beside a point; the one back to where the descent came from, by its number, rises there.

        A slope that floats show to fall is taken at once; only where there is none, those in doubt are built.
        """
        slopes = self.slopes(vertex)
        steepest, doubtful = slopes.at(np.array([1.0, *normal_floats(place.point)]))
        if steepest is not None:
            return slopes[steepest]
        inexact = (slopes[k] for k in doubtful if k != back)
        return next((slope for slope in inexact if order(slope.form, place) < (0, 0)), None)

    def _polygon(self, vertex: Vertex) -> tuple[Polygon | None, dict[str, SlopeOfD]]:
        """The vertex's cell, and the slope behind each of its inner sides, by label.

        No slope falls at the ends of a side across which the walk came: there both twists minimize D.
        """
        polygon: Polygon | None = self.region.polygon
        origins: dict[str, SlopeOfD] = {}
        slopes, crossed = self.slopes(vertex), self._crossed[vertex]
        likely = slopes.sides_of(self.arrangement.corners)
        waiting = [*likely, *(k for k in slopes.possible if k not in likely)]
        while waiting and polygon is not None:
            k = waiting.pop(0)
            if not any(slopes[k].form):
                continue
            origins[f"slope {k}"] = slopes[k]
            clipped = polygon.clipped(self._half_plane(slopes[k].form, f"slope {k}"))
            is_cut, is_last = clipped is not polygon and k not in likely, k in likely[-1:]
            if clipped is not None and (is_cut or is_last):
                waiting = slopes.doubtful(float_corners(clipped.vertices), waiting)
                if waiting and crossed:
                    waiting = slopes.doubtful(float_corners(_not_among(crossed, clipped)), waiting)
            polygon = clipped
        return polygon, origins

    def _half_plane(self, form: Affine, label: str) -> HalfPlane:
        if any(is_long(entry) for entry in form):
            form = (Lazy.of(form[0]), Lazy.of(form[1]), Lazy.of(form[2]))
        return at_least_zero(form, label)

    def _face(self, vertex: Vertex) -> list[Vertex]:
        """All vertices that tie with this one on its whole cell (Theorem 2: their hull minimizes D)."""
        face, waiting = [vertex], [vertex]
        while waiting:
            here = waiting.pop()
            for slope in self.slopes(here).flat:
                beyond = self.arrangement.next_vertex(here, slope)
                if beyond not in face:
                    face.append(beyond)
                    waiting.append(beyond)
        return face

    def _state(self, vertex: Vertex) -> ContactState:
        return ContactState(tuple(self.arrangement.rows[k] for k in vertex.tight), vertex.twist)


def _ends(polygon: Polygon, k: int) -> tuple[Point, Point]:
    return polygon.vertices[k], polygon.vertices[(k + 1) % len(polygon.vertices)]


def _midpoint(polygon: Polygon, k: int) -> Point:
    (x1, y1), (x2, y2) = _ends(polygon, k)
    return (x1 + x2) / 2, (y1 + y2) / 2


def _not_among(crossed: Sequence[Crossing], polygon: Polygon) -> list[Point]:
    """The vertices of a polygon but those known to be ends of sides across which the walk came.

    Lazy quotients are not compared: to find that they are equal is long work.
    """
    ends = [end for crossing in crossed for end in crossing.ends if not _is_lazy(end)]
    return [vertex for vertex in polygon.vertices if _is_lazy(vertex) or vertex not in ends]


def _is_lazy(point: Point) -> bool:
    return any(isinstance(x, Lazy) for x in point)


def rest_cells(partition: Partition) -> Sequence[Cell]:
    """Cells whose twist is zero: the dead zone."""
    return [cell for cell in partition.cells if cell.rests]
