"""Rule ``box``: the exact minimizer of the power dissipation functional, one twist per polygon of the plane.

Each slope of D at a vertex of the arrangement (:mod:`nonsmooth.analysis.cells.arrangement`) is affine in the
centre of mass, so the cell of a vertex, where all its slopes are non-negative, is a convex polygon in explicit
half-plane form.  Where a slope vanishes, D is flat along that edge up to the next vertex: that vertex owns the cell
beyond. So the partition is found by walking from cell to neighbouring cell, one ratio test per side, never by trying
all C(2n, 3) triples.  Ties beyond a side (symmetric arrays) are resolved by an exact descent just outside it: slopes
are compared by value first, then by derivative along the outward normal.  The cells' areas must add up to the
domain's: that checks the walk, and it is Theorem 1 of Murphey & Burdick made checkable.

Whole numbers and floats with certified errors decide nearly every sign (:mod:`nonsmooth.analysis.cells.outline`), field
elements the others; a vertex, a half-plane or a twist is made as a field element when it is asked for.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.arrangement import (
    Arrangement,
    Beside,
    FilteredPlace,
    RowLines,
    SlopeOfD,
    Vertex,
    beyond_floats,
    is_multiple,
)
from nonsmooth.analysis.cells.loads import LoadRegion, at_least_zero, load_regions
from nonsmooth.analysis.cells.nearest import preferred_rows
from nonsmooth.analysis.cells.outline import ROUNDING, Filtered, Outline, OutlineSide, between
from nonsmooth.analysis.cells.partition import PARTITION_UNITS, Cell, Partition, affordable, require_rank
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, checked_square
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Twist, rows_with_friction, wheel_rows
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import Lazy, is_long

STEP = "cells of rule box"

Found: TypeAlias = tuple[list[Vertex], Outline]


class WalkedCell(Cell):
    """A cell of which polygon and states are exact on demand."""

    _walk: _Walk
    _found: Found

    def __init__(self, index: int, walk: _Walk, found: Found) -> None:
        vars(self).update(index=index, _walk=walk, _found=found)
        if not walk.arrangement.is_exact:  # what rounding decides of them is counted where the partition is built
            _ = self.states  # of the polygon nothing is left to decide: its corners are quotients

    @cached_property
    def polygon(self) -> Polygon:
        """Exactly."""
        with affordable(self._walk.scene, PARTITION_UNITS, STEP):
            return self._found[1].polygon

    @cached_property
    def states(self) -> tuple[ContactState, ...]:
        """Exactly."""
        with affordable(self._walk.scene, PARTITION_UNITS, STEP):
            return tuple(self._walk.state(vertex) for vertex in self._found[0])


@beyond_floats
def build_box_partition(scene: Scene, domain: Polygon | None = None) -> Partition:
    """Cells of rule ``box`` in the checked square, or in another domain within the support polygon.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
    """
    require_rank(rows_with_friction(scene), "friction: required rows")
    domain = domain or checked_square(scene)
    cells: list[Cell] = []
    before: Vertex | None = None
    with affordable(scene, PARTITION_UNITS, STEP):
        lines = RowLines(scene)
        for region in load_regions(scene, domain=domain):
            walk = _Walk(scene, region, lines)
            before = walk.first(before)
            for found in walk.cells(before):
                cells.append(WalkedCell(len(cells) + 1, walk, found))
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
        lines = RowLines(scene)
        for region in load_regions(scene):
            walk = _Walk(scene, region, lines)
            found = walk.cell_of(Twist(zero, zero, zero)) if region.polygon.contains((zero, zero)) else None
            if found is not None:
                cells.append(WalkedCell(len(cells) + 1, walk, found))
    inner = [cell for cell in cells if _surrounds(cell.polygon, (zero, zero))]
    if len(cells) != len(inner):
        return None
    domain = checked_square(scene)
    return Partition(scene, "box", domain, tuple(inner), len(scene.wheels), complete=False) if inner else None


def _surrounds(polygon: Polygon, point: Point) -> bool:
    """Whether no side of the cell passes through the point, but for the boundary of a load region."""
    return all(side.slack(point).sign() > 0 for side in polygon.sides if side.label.startswith("slope"))


class _Walk:
    """The cells of one load region.

    Args:
        scene: the array.
        region: where the loads are affine.
        lines: the rows of the array.
    """

    def __init__(self, scene: Scene, region: LoadRegion, lines: RowLines) -> None:
        self.scene = scene
        self.region = region
        self.arrangement = Arrangement(scene, region, lines)
        loaded = (row for row in self.arrangement.rows if any(region.forces[scene.places[row.wheel.index]]))
        require_rank((row for row in loaded if row.friction), "contact.loads: required loaded rows")
        self._slopes: dict[Vertex, Slopes] = {}
        self._crossed: defaultdict[Vertex, list[SlopeOfD]] = defaultdict(list)
        self._whole = Outline.of(region.polygon)

    def slopes(self, vertex: Vertex) -> Slopes:
        """The slopes of D at a vertex (cached)."""
        if vertex not in self._slopes:
            self._slopes[vertex] = Slopes(self.arrangement, vertex.signs)
        return self._slopes[vertex]

    def cell_of(self, twist: Twist) -> Found | None:
        """Vertices and outline of one twist that solves three independent rows; None where it owns no cell."""
        vertex = self.arrangement.vertex_at(twist)
        outline = None if vertex is None else self._outline(vertex)
        return None if vertex is None or outline is None else (self._face(vertex), outline)

    def cells(self, first: Vertex) -> Iterator[Found]:
        """Cells (vertices that tie there, outline) of the region, each once, from one that owns a cell.

        The least value of D is the least of affine functions of c, one for each vertex, so cells meet in whole sides:
        beyond a side on a line across which the walk came lies the cell from which it came.
        """
        done: set[Vertex] = set()
        waiting = [first]
        while waiting:
            vertex = waiting.pop()
            if vertex in done:
                continue
            face = self._face(vertex)
            done.update(face)
            outline = self._outline(vertex)
            if outline is None:
                continue
            yield face, outline
            explored = [slope for v in face for slope in self._crossed[v]]
            for k, side in enumerate(outline.sides):
                slope = side.origin
                if isinstance(slope, SlopeOfD) and not any(is_same_line(slope, line) for line in explored):
                    neighbour, back = self._descend(vertex, _beside(outline, k, slope), slope)
                    self._crossed[neighbour].append(back or slope)
                    waiting.append(neighbour)

    def first(self, before: Vertex | None) -> Vertex:
        """Descend to the optimal vertex just beside the centre of the region, from that of another region if known."""
        centre = self.region.polygon.centre
        if before is None:
            # both rows of the nearest wheel and one of the next at another place: any independent rows would do
            near, *others = sorted(self.scene.wheels, key=lambda w: sum(float(p) * float(p) for p in w.position))
            numbers = {row.name: k for k, row in enumerate(self.arrangement.rows)}
            first, second = (numbers[row.name] for row in wheel_rows(near))
            rows = (numbers[row.name] for wheel in others for row in preferred_rows(wheel))
            third = next(k for k in rows if self.arrangement.spans((first, second), k))
            vertex = self.arrangement.vertex((first, second, third), (first, second, third))
        else:
            vertex = self.arrangement.vertex(before.basis, before.tight)
        one = self.scene.field.one
        outward = (one, one * 7 / 11)  # a direction along no usual symmetry axis: it only breaks ties
        place = FilteredPlace(
            Filtered.of((one, *centre)), Filtered.of((one * 0, *outward)), lambda: Beside(centre, outward)
        )
        return self._descend(vertex, place)[0]

    def _descend(
        self, vertex: Vertex, place: FilteredPlace, falling: SlopeOfD | None = None
    ) -> tuple[Vertex, SlopeOfD | None]:
        """Exact descent beside a point, first along a slope that falls there if one is known.

        Every step lowers D, so it ends at the minimizer.  With it comes the slope back on the same line, where the
        first step along the first edge ends there.
        """
        first, back = falling, None
        falling = falling or self._falling(vertex, place, None)
        while falling is not None:
            vertex, before = self.arrangement.line_search(vertex, falling, place)
            back = self.slopes(vertex).learn(falling, before)
            first = first if before is first else None
            falling = self._falling(vertex, place, back)
        return vertex, first and back

    def _falling(self, vertex: Vertex, place: FilteredPlace, back: SlopeOfD | None) -> SlopeOfD | None:
        """A slope that falls beside a point; the one back to where the descent came from rises there.

        A slope that floats show to fall is taken at once; only where there is none, those in doubt are looked at.
        """
        slopes = self.slopes(vertex)
        point, sizes = (np.array(part, dtype=float) for part in place.point[:2])
        steepest, doubtful = slopes.at(point, sizes)
        if steepest is not None:
            return slopes[steepest]
        inexact = (slopes[k] for k in doubtful if slopes[k] is not back)
        return next((slope for slope in inexact if place.order(slope) < (0, 0)), None)

    def _outline(self, vertex: Vertex) -> Outline | None:
        """The vertex's cell: where no slope is negative."""
        outline: Outline | None = self._whole
        slopes = self.slopes(vertex)
        likely = [k for k in slopes.sides() if k not in slopes.flat]
        for number in likely:
            outline = outline and outline.clipped(_side(slopes[number]))
        if outline is None:
            return None
        others = [k for k in slopes.possible if k not in likely and k not in slopes.flat]
        for number in others:
            if outline is not None and not outline.keeps(slopes.filtered(number)):
                outline = outline.clipped(_side(slopes[number]))
        return outline

    def _face(self, vertex: Vertex) -> list[Vertex]:
        """All vertices that tie with this one on its whole cell (Theorem 2: their hull minimizes D)."""
        face, waiting = [vertex], [vertex]
        while waiting:
            here = waiting.pop()
            for slope in self.slopes(here).flat.values():
                beyond = self.arrangement.next_vertex(here, slope)
                if beyond not in face:
                    face.append(beyond)
                    waiting.append(beyond)
        return face

    def state(self, vertex: Vertex) -> ContactState:
        """All rows that hold at a vertex."""
        return ContactState(tuple(self.arrangement.rows[k] for k in vertex.tight), vertex.twist)


def _side(slope: SlopeOfD) -> OutlineSide:
    """Where a slope is not negative."""

    def build() -> HalfPlane:
        form = slope.exact
        if any(is_long(entry) for entry in form):
            form = (Lazy.of(form[0]), Lazy.of(form[1]), Lazy.of(form[2]))
        return at_least_zero(form, "slope")

    return OutlineSide(slope.filtered, build, slope)


def _beside(outline: Outline, k: int, slope: SlopeOfD) -> FilteredPlace:
    """Just beyond the middle of a side."""
    first, second = outline.corners[k], outline.corners[(k + 1) % len(outline.corners)]
    (_, a, b), (_, r, s), error = slope.filtered

    def exactly() -> Beside:
        (x1, y1), (x2, y2) = first.point, second.point
        return Beside(((x1 + x2) / 2, (y1 + y2) / 2), outline.sides[k].exact.normal, slope.exact)

    return FilteredPlace(
        between(first.filtered, second.filtered), Filtered((0, -a, -b), (0, r, s), error), exactly, slope
    )


def is_same_line(slope: SlopeOfD, other: SlopeOfD) -> bool:
    """Whether the forms of two slopes are multiples of each other."""
    if slope is other:
        return True
    (a, b, c), (r, s, t), error = slope.filtered
    (x, y, z), (u, v, w), more = other.filtered
    minors = (a * y - b * x, r * v + s * u), (a * z - c * x, r * w + t * u), (b * z - c * y, s * w + t * v)
    if any(abs(minor) > size * (error and error + more + ROUNDING) for minor, size in minors):
        return False
    return not error or is_multiple(slope.exact, other.exact)


def rest_cells(partition: Partition) -> Sequence[Cell]:
    """Cells whose twist is zero: the dead zone."""
    return [cell for cell in partition.cells if cell.rests]
