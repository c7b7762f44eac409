"""A contact rule that the product does not have: the two wheels farthest from the centre of mass decide."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from nonsmooth.analysis.cells.contact_rule import CellRule
from nonsmooth.analysis.cells.nearest import bisector, greedy_states
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Polygon, square
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.sampling import greedy_twist
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.plane_arrays import Floats


class FarthestRule(CellRule):
    """Both rows of the farthest wheel and one row of the second-farthest."""

    name = "farthest"
    summary = "keeps both rows of the farthest wheel and one row of the second-farthest"
    keeps_rows = True

    def build_partition(self, scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
        """Cells of the ordered farthest-point Voronoi diagram; every wheel matters."""
        domain = domain or square(scene.check.equilibrium, scene.check.radius)
        cells: list[Cell] = []
        for first, second in permutations(scene.wheels, 2):
            farthest = self._region(first, scene.wheels, domain)
            if farthest is None:
                continue
            region = self._region(second, [wheel for wheel in scene.wheels if wheel is not first], farthest)
            if region is not None:
                cells.append(Cell(len(cells) + 1, region, greedy_states([first, second])))
        return Partition(scene, self.name, domain, tuple(cells), len(scene.wheels))

    def literal_twists(self, scene: Scene, points: Floats) -> Floats:
        """Wheels by distance, the farthest first, rows greedily to rank three."""
        model = contact_model(scene)
        orders = np.argsort(-np.linalg.norm(points[:, None, :] - model.positions, axis=2), axis=1)
        return np.array([greedy_twist(model, order)[0] for order in orders])

    @staticmethod
    def _region(wheel: Wheel, others: Sequence[Wheel], within: Polygon) -> Polygon | None:
        """Where a wheel is at least as far as all others."""
        region: Polygon | None = within
        for other in others:
            if region is not None and other is not wheel:
                region = region.clipped(bisector(other, wheel))
        return region
