"""Which cell holds a point, for many points at once: the explicit minimizer as a table look-up.

The half-planes of all cells become arrays; a point belongs to the first cell none of whose sides it violates.
Points within rounding of a side may land on either side of it, which is as exact as a float point can be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.contact_rule import contact_rule
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import forces_at
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.force_balance import balance_forces
from nonsmooth.analysis.minimizers.minimum import Minima

OUTSIDE = -1
# Length relative to the square's half-width: absorbs the rounding of a point that lies on a side.
SIDE_SLACK = 1e-12
_BLOCK = 4096  # points per block: keeps the slack matrix within the processor's cache


class PointLocator:
    """Float form of a partition."""

    def __init__(self, partition: Partition) -> None:
        self.partition = partition
        self.scale = float(partition.scene.check.radius) * SIDE_SLACK
        self._normals: list[NDArray[np.float64]] = []
        self._offsets: list[NDArray[np.float64]] = []
        for cell in partition.cells:
            normals = np.array([[float(x) for x in side.normal] for side in cell.polygon.sides])
            lengths = np.hypot(*normals.T)
            self._normals.append(normals / lengths[:, None])
            self._offsets.append(np.array([float(side.offset) for side in cell.polygon.sides]) / lengths)
        self._twists = np.array([[float(x) for x in cell.twists[0]] for cell in partition.cells])

    def locate(self, points: NDArray[np.float64]) -> NDArray[np.int_]:
        """Position in ``partition.cells`` for points (m, 2); :data:`OUTSIDE` where no cell holds the point."""
        found = np.full(len(points), OUTSIDE)
        for start in range(0, len(points), _BLOCK):
            block = slice(start, start + _BLOCK)
            found[block] = self._locate_block(points[block])
        return found

    def _locate_block(self, points: NDArray[np.float64]) -> NDArray[np.int_]:
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

    def twists(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Twist (vx, vy, omega) of each point's cell, NaN outside the square."""
        found = self.locate(points)
        return np.where((found != OUTSIDE)[:, None], self._twists[found], np.nan)

    def minima(self, points: NDArray[np.float64]) -> Minima:
        """The explicit minimizer of rule ``box`` at points (m, 2), with the forces that prove it.

        Raises:
            ValueError: for a point outside the square, or a partition of another rule.
        """
        twists = self.twists(points)
        if contact_rule(self.partition.rule).functional is not Functional.BOX or np.isnan(twists).any():
            raise ValueError("required points inside the checked square of a partition of rule box")
        model = contact_model(self.partition.scene)
        loads = loads_at(model, points)
        forces = np.array([forces_at(model, load, twist) for load, twist in zip(loads, twists, strict=True)])
        return Minima(Functional.BOX, model, loads, twists, balance_forces(Functional.BOX, model, loads, forces))
