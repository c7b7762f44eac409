"""Where the contact rules agree: exact shares of area, and differences of twist on a grid.

Two rules with cells give polygons with constant twists, so the share of the square on which they agree is a sum of
areas of intersections, exact like the cells.  The twist of a rule without cells is compared with theirs on a fixed
grid, in the norm ``sqrt(|v|^2 + (R omega)^2)``, R the largest distance of a wheel from the
checked point, relative to the larger of the two.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.cell_complex import float_polygon
from nonsmooth.analysis.cells.contact_rule import SmoothRule, all_rules, cell_rules
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import clipped_by
from nonsmooth.analysis.fields.polygon_field import CellSides
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.minimum import minima_without_proof, proved
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Indices,
    float_points,
    grid_points,
    norms,
    places_of,
    row_norms,
)

RulePair: TypeAlias = tuple[str, str]

GRID = 40  # points per side of the comparison grid
ALIKE = 9  # digits to which two sampled differences count as equal


@dataclass(frozen=True)
class SharedArea:
    """Area on which two partitions of one square prescribe the same set of twists.

    Attributes:
        area: the common area.
        share: divided by the square's area.
        shared_twists: twists that own common area.
    """

    area: Number | Lazy
    share: Number | Lazy
    shared_twists: tuple[Twist, ...]


def shared_area(first: Partition, second: Partition) -> SharedArea:
    """Exact area of agreement of two partitions of the same square."""
    by_motion: dict[frozenset[Twist], list[Cell]] = defaultdict(list)
    for cell in second.cells:
        by_motion[frozenset(cell.twists)].append(cell)
    total: Number | Lazy = first.scene.field.zero
    twists: dict[Twist, None] = {}
    for cell in first.cells:
        for other in by_motion.get(frozenset(cell.twists), []):
            common = clipped_by(cell.polygon, other.polygon.sides)
            if common is not None:
                total = total + common.area
                twists.update(dict.fromkeys(cell.twists))
    return SharedArea(total, total / first.domain.area, tuple(twists))


@dataclass(frozen=True)
class TwistDifference:
    """Relative difference of two rules' twists over a grid.

    Attributes:
        points: number of grid points that count: those at which the motion under the rule without cells is proved.
        mean: mean relative difference; None where no point counts.
        largest: largest relative difference.
        at: where it occurs.
        not_certified: what is missing, in words; empty where all points count.
    """

    points: int
    mean: float | None
    largest: float | None
    at: tuple[float, float] | None
    not_certified: str = ""


@dataclass(frozen=True, repr=False)
class Agreement(ShortRepr):
    """The contact rules side by side, by their names.

    Attributes:
        partitions: of every rule with cells, in the scene's coordinates.
        shared: where two of these prescribe the same motion.
        differences: of a rule without cells from one with cells.
    """

    partitions: Mapping[str, Partition]
    shared: Mapping[RulePair, SharedArea]
    differences: Mapping[RulePair, TwistDifference]


def compare_rules(scene: Scene) -> Agreement:
    """Compare all contact rules on the checked square.

    Raises:
        nonsmooth.analysis.cells.partition.RefusalError: where the loads do not exist.
    """
    partitions: dict[str, Partition] = {}
    for rule in cell_rules():
        partitions[rule.name] = rule.build_partition(scene.under(rule.name))
    shared = {(p, q): shared_area(partitions[p], partitions[q]) for p, q in combinations(partitions, 2)}
    differences: dict[RulePair, TwistDifference] = {}
    for other in all_rules(scene):
        if isinstance(other, SmoothRule):
            found = _differences(scene, other, partitions)
            differences.update({(other.name, name): difference for name, difference in found.items()})
    return Agreement(partitions, shared, differences)


def _differences(scene: Scene, rule: SmoothRule, partitions: Mapping[str, Partition]) -> dict[str, TwistDifference]:
    """How far a rule without cells is from every rule with cells, over the grid points where its motion is proved."""
    points = comparison_grid(scene)
    minima = minima_under(rule, scene, points)
    found = proved(minima)
    points, twists, missing = points[found], minima.twists[found], minima_without_proof(found)
    return {
        name: _difference(scene, points, twists, PointLocator(partition).twists(points), missing)
        for name, partition in partitions.items()
    }


def comparison_grid(scene: Scene) -> Floats:
    """One point in each field of a GRID x GRID raster of the square, off its axes and diagonals, shape (GRID^2, 2)."""
    centre = np.array(scene.check.place)
    across, up = (scene.check.half_width * ((np.arange(GRID) + shift) * 2 / GRID - 1) for shift in (0.5, 0.3))
    return centre + grid_points(across, up)


def _difference(scene: Scene, points: Floats, first: Floats, second: Floats, missing: str) -> TwistDifference:
    if not len(points):
        return TwistDifference(0, None, None, None, missing)
    centre = np.array(scene.check.place)
    wheels = places_of(scene.wheels)
    scale = np.array([1.0, 1.0, norms(wheels - centre).max()])
    sizes = np.maximum(row_norms(first * scale), row_norms(second * scale))
    apart = row_norms((first - second) * scale)
    relative = np.divide(apart, sizes, out=np.zeros_like(apart), where=sizes > 0)
    # Mirror images differ by rounding alone: the first of them is named, on every machine.
    worst = int(np.argmax(np.round(relative / (relative.max() or 1.0), ALIKE)))
    at = (points[worst, 0], points[worst, 1])
    return TwistDifference(len(points), float(relative.mean()), float(relative[worst]), at, missing)


# ---- which cell holds a point --------------------------------------------------------------------
#
# For many points at once: the explicit minimizer as a table look-up.
#
# The half-planes of all cells become arrays; a point belongs to the first cell none of whose sides it violates.
# Points within rounding of a side may land on either side of it, which is as exact as a float point can be.
#
# Many points are looked up in a grid of buckets first. Cells are convex, so a bucket whose four corners lie in one cell
# lies in it as a whole; only points of buckets that a side crosses are compared with half-planes.


OUTSIDE = -1
# Length relative to the square's half-width: absorbs the rounding of a point that lies on a side.
SIDE_SLACK = 1e-12
_BLOCK = 256  # points per block: keeps the depths in all cells within the processor's cache
_BUCKETS = 128  # along each axis
_MANY = _BUCKETS**2  # points for which the table of buckets is worth building
_MIXED = -2  # of a bucket that a side crosses


class PointLocator:
    """Float form of a partition."""

    def __init__(self, partition: Partition) -> None:
        self.partition = partition
        self.scale = partition.scene.check.half_width * SIDE_SLACK
        self._sides = CellSides([float_polygon(cell.polygon).sides for cell in partition.cells])
        # the last row belongs to OUTSIDE
        self._twists = np.array([*(cell.twists[0] for cell in partition.cells), [np.nan] * 3], float)

    def locate(self, points: Floats) -> Indices:
        """Position in ``partition.cells`` for points (m, 2); :data:`OUTSIDE` where no cell holds the point."""
        if len(points) < _MANY:
            return self._search(points)
        found = self._buckets.cells_of(points)
        mixed = np.flatnonzero(found == _MIXED)
        found[mixed] = self._search(points[mixed])
        return found

    @cached_property
    def _buckets(self) -> _Buckets:
        vertices = float_points(self.partition.domain.vertices)
        return _Buckets(vertices.min(axis=0), vertices.max(axis=0), self._search)

    def _search(self, points: Floats) -> Indices:
        """The first cell of each point none of whose sides it violates."""
        found = np.full(len(points), OUTSIDE)
        for start in range(0, len(points), _BLOCK):
            block = slice(start, start + _BLOCK)
            inside = self._sides.depths(points[block]) >= -self.scale
            found[block] = np.where(inside.any(axis=1), inside.argmax(axis=1), OUTSIDE)
        return found

    def twists(self, points: Floats) -> Floats:
        """Twist (vx, vy, omega) of each point's cell, NaN outside the square."""
        return self._twists[self.locate(points)]


class _Buckets:
    """Rectangles of equal size, each with the cell that holds all of it, :data:`_MIXED` where none does.

    Args:
        low, high: corners of the rectangle that is divided.
        search: the cells of points (m, 2).
    """

    def __init__(
        self,
        low: Floats,
        high: Floats,
        search: Callable[[Floats], Indices],
    ) -> None:
        self._low, self._per_unit = low, _BUCKETS / (high - low)
        lines = low + (high - low) * np.linspace(0, 1, _BUCKETS + 1)[:, None]
        corners = np.stack(np.meshgrid(*lines.T, indexing="ij"), axis=-1).reshape(-1, 2)
        at = search(corners).reshape(_BUCKETS + 1, _BUCKETS + 1)
        one = (at[:-1, :-1] == at[1:, :-1]) & (at[:-1, :-1] == at[:-1, 1:]) & (at[:-1, :-1] == at[1:, 1:])
        # Around the buckets one layer of mixed ones: a point outside the rectangle is searched for, as any in doubt.
        self._table = np.full((_BUCKETS + 2, _BUCKETS + 2), _MIXED)
        self._table[1:-1, 1:-1] = np.where(one & (at[:-1, :-1] != OUTSIDE), at[:-1, :-1], _MIXED)

    def cells_of(self, points: Floats) -> Indices:
        """The cell of each point (m, 2) whose bucket lies in one, :data:`_MIXED` for the others."""
        column, row = (self._numbers(points[:, axis], axis) for axis in (0, 1))
        return self._table[column, row]

    def _numbers(self, coordinates: Floats, axis: int) -> Indices:
        """Numbers of buckets along one axis, counted with the layer around them, in which NaN lies too."""
        places = (coordinates - self._low[axis]) * self._per_unit[axis] + 1
        return np.fmax(np.fmin(places, _BUCKETS + 1), 0).astype(int)
