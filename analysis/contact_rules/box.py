"""Rule ``box``: the motion minimizes the dissipation, with friction limited along and across the rim apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import CellRule, LimitedForces

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction, Scene
    from nonsmooth.symbolic.numbers.plane_arrays import Floats


class BoxRule(CellRule, LimitedForces):
    """``D = sum_i N_i (mu_R |r_i| + mu_S |s_i|)``, whose minimizer is piecewise constant.

    How: :mod:`nonsmooth.analysis.cells.box`.
    """

    name = "box"
    summary = "friction losses are least, with a limit along and a limit across each rim"
    hardware = "belts with rollers that turn easily (mu_side up to a tenth of mu_roll); see roller, also for rest"

    def remark(self, scene: Scene) -> str:
        """A square limit with equal sides is a rubber wheel's circle, cornered."""
        if all(wheel.friction.roll == wheel.friction.side for wheel in scene.wheels):
            return "friction is equal along and across, as of rubber: its limit is a circle, not a square; see ellipse"
        return ""

    def friction_set(self, friction: Friction) -> FrictionSet:
        """The box of mu_R along the axis and mu_S across it."""
        from nonsmooth.symbolic.mechanics.friction_set import Box

        return Box(friction.roll, friction.side, friction.roll.field.one)

    def build_partition(self, scene: Scene, *, prune: bool = True) -> Partition:
        """Cells by walking from one to its neighbours; every wheel carries load, so there is none to leave out."""
        from nonsmooth.analysis.cells.box import build_box_partition

        return build_box_partition(scene)

    def build_standing_partition(self, scene: Scene) -> Partition:
        """Loads exist in the hull of the wheels."""
        from nonsmooth.analysis.cells.box import build_box_partition
        from nonsmooth.analysis.cells.polygon import convex_polygon
        from nonsmooth.symbolic.mechanics.body import support_polygon
        from nonsmooth.symbolic.mechanics.similar_scenes import covering

        hull = convex_polygon(support_polygon([wheel.position for wheel in scene.wheels]))
        return build_box_partition(covering(scene), hull)

    def literal_twists(self, scene: Scene, points: Floats) -> Floats:
        """One linear program for each point."""
        from nonsmooth.analysis.fields.contact_model import contact_model
        from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
        from nonsmooth.analysis.minimizers.float_loads import loads_at

        model = contact_model(scene)
        return BoxHighs().minimize(model, loads_at(model, points)).twists

    def build_rest_partition(self, scene: Scene) -> Partition | None:
        """The cells of rest, where the point lies inside them."""
        from nonsmooth.analysis.cells.box import build_rest_partition

        return build_rest_partition(scene)
