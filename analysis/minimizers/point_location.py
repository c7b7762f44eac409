"""Which cell holds a point, for many points at once: the explicit minimizer as a table look-up.

The half-planes of all cells become arrays; a point belongs to the first cell none of whose sides it violates.
Points within rounding of a side may land on either side of it, which is as exact as a float point can be.

Many points are looked up in a grid of buckets first. Cells are convex, so a bucket whose four corners lie in one cell
lies in it as a whole; only points of buckets that a side crosses are compared with half-planes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from nonsmooth.analysis.cells.contact_rule import contact_rule
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import forces_at
from nonsmooth.analysis.minimizers.dissipation import Functional, functional_of
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Minima, balance_forces
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, float_points

OUTSIDE = -1
# Length relative to the square's half-width: absorbs the rounding of a point that lies on a side.
SIDE_SLACK = 1e-12
_BLOCK = 4096  # points per block: keeps the slack matrix within the processor's cache
_BUCKETS = 128  # along each axis
_MANY = _BUCKETS**2  # points for which the table of buckets is worth building
_MIXED = -2  # of a bucket that a side crosses


class PointLocator:
    """Float form of a partition."""

    def __init__(self, partition: Partition) -> None:
        self.partition = partition
        self.scale = float(partition.scene.check.radius) * SIDE_SLACK
        self._normals: list[Floats] = []
        self._offsets: list[Floats] = []
        for cell in partition.cells:
            normals = float_points(side.normal for side in cell.polygon.sides)
            lengths = np.hypot(*normals.T)
            self._normals.append(normals / lengths[:, None])
            self._offsets.append(np.array([float(side.offset) for side in cell.polygon.sides]) / lengths)
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
            found[block] = self._search_block(points[block])
        return found

    def _search_block(self, points: Floats) -> Indices:
        found = np.full(len(points), OUTSIDE)
        waiting = np.arange(len(points))
        for k, (normals, offsets) in enumerate(zip(self._normals, self._offsets, strict=True)):
            slack = offsets - points[waiting] @ normals.T
            inside = (slack >= -self.scale).all(axis=1)
            found[waiting[inside]] = k
            waiting = waiting[~inside]
            if not len(waiting):
                break
        return found

    def twists(self, points: Floats) -> Floats:
        """Twist (vx, vy, omega) of each point's cell, NaN outside the square."""
        return self._twists[self.locate(points)]

    def minima(self, points: Floats) -> Minima:
        """The explicit minimizer of rule ``box`` at points (m, 2), with the forces that prove it.

        Raises:
            ValueError: for a point outside the square, or a partition of another rule.
        """
        twists = self.twists(points)
        if functional_of(contact_rule(self.partition.rule)) is not Functional.BOX or np.isnan(twists).any():
            raise ValueError("required points inside the checked square of a partition of rule box")
        model = contact_model(self.partition.scene)
        loads = loads_at(model, points)
        forces = np.array([forces_at(model, load, twist) for load, twist in zip(loads, twists, strict=True)])
        return Minima(Functional.BOX, model, loads, twists, balance_forces(Functional.BOX, model, loads, forces))


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
