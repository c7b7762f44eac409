"""Rule ``nearest``, the paper's: the rows of the nearest wheels are kept (Murphey & Burdick, sec. 3.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import CellRule

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
    from nonsmooth.symbolic.numbers.plane_arrays import Floats


class NearestRule(CellRule):
    """Three independent rows, taken wheel by wheel in the order of distance to the centre of mass.

    How: :mod:`nonsmooth.analysis.cells.nearest`.
    """

    name = "nearest"
    summary = (
        "the two wheels nearest to the centre of mass carry the body; "
        "the nearest does not slip, the other slips one way"
    )
    hardware = "the paper's distributed manipulator; cilia and other MEMS actuators, where two contacts carry the part"
    keeps_rows = True

    def remark(self, scene: Scene) -> str:
        """Equal frictions leave open which row of the second wheel holds."""
        if any(wheel.friction.roll == wheel.friction.side for wheel in scene.wheels):
            return "mu_roll = mu_side leaves open which way the second wheel slips: every mixture is taken; see ellipse"
        return ""

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
