"""Rule ``nearest``, the paper's: the rows of the nearest wheels are kept (Murphey & Burdick, sec. 3.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.contact_rule import CellRule

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.analysis.fields.contact_model import Floats
    from nonsmooth.symbolic.scene import Scene, Wheel


class NearestRule(CellRule):
    """Three independent rows, taken wheel by wheel in the order of distance to the centre of mass.

    How: :mod:`nonsmooth.analysis.cells.nearest`.
    """

    name = "nearest"
    summary = "keeps both rows of the nearest wheel and one row of the second-nearest"
    keeps_rows = True

    def build_partition(self, scene: Scene, *, prune: bool = True) -> Partition:
        """Ordered Voronoi cells."""
        from nonsmooth.analysis.cells.nearest import build_nearest_partition

        return build_nearest_partition(scene, prune=prune)

    def literal_twists(self, scene: Scene, points: Floats) -> Floats:
        """Wheels by distance, rows greedily to rank three."""
        from nonsmooth.analysis.minimizers.sampling import literal_twists

        return literal_twists(scene, points)

    def wheels_that_matter(self, scene: Scene) -> tuple[Wheel, ...]:
        """Those that are among the nearest somewhere in the square."""
        from nonsmooth.analysis.cells.nearest import float_positions, relevant_wheels

        return relevant_wheels(scene, float_positions(scene))
