"""Contact rules: how contacts become motion, one class each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import CellRule, LimitedForces, SmoothRule, contact_rule
from nonsmooth.symbolic.mechanics.rule import MIXED

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.analysis.cells.polygon import Polygon
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction, Scene, Wheel
    from nonsmooth.symbolic.numbers.plane_arrays import Floats

# ---- rule ``nearest`` ----------------------------------------------------------------------------
#
# The paper's: the rows of the nearest wheels are kept (Murphey & Burdick, sec. 3.1).


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
    sees_order_of_friction = True

    def remark(self, scene: Scene) -> str:
        """Equal frictions leave open which row of the second wheel holds."""
        if any(wheel.friction.roll == wheel.friction.side for wheel in scene.wheels):
            return "mu_roll = mu_side leaves open which way the second wheel slips: every mixture is taken; see ellipse"
        return ""

    def build_partition(self, scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
        """Ordered Voronoi cells."""
        from nonsmooth.analysis.cells.nearest import build_nearest_partition

        return build_nearest_partition(scene, prune=prune, domain=domain)

    def partition_like(self, scene: Scene, known: Partition) -> Partition | None:
        """Wheels that stand alike have the same cells."""
        from nonsmooth.analysis.cells.nearest import nearest_partition_like

        return nearest_partition_like(scene, known)

    def literal_twists(self, scene: Scene, points: Floats) -> Floats:
        """Wheels by distance, rows greedily to rank three."""
        from nonsmooth.analysis.minimizers.sampling import literal_twists

        return literal_twists(scene, points)

    def wheels_that_matter(self, scene: Scene) -> tuple[Wheel, ...]:
        """Those that are among the nearest somewhere in the square."""
        from nonsmooth.analysis.cells.nearest import relevant_wheels

        return relevant_wheels(scene)


# ---- rule ``box`` --------------------------------------------------------------------------------
#
# The motion minimizes the dissipation, with friction limited along and across the rim apart.


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

    def build_partition(self, scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
        """Cells by walking from one to its neighbours; every wheel carries load, so there is none to leave out."""
        from nonsmooth.analysis.cells.box import build_box_partition

        return build_box_partition(scene, domain)

    def build_standing_partition(self, scene: Scene) -> Partition:
        """Loads exist in the hull of the wheels."""
        from nonsmooth.analysis.cells.polygon import convex_polygon
        from nonsmooth.symbolic.mechanics.body import support_polygon
        from nonsmooth.symbolic.mechanics.similar_scenes import covering

        hull = convex_polygon(support_polygon(scene.positions))
        return self.build_partition(covering(scene), domain=hull)

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


# ---- rule ``ellipse`` ----------------------------------------------------------------------------
#
# The motion minimizes the dissipation with the friction ellipse of the paper's Fig. 3.


class EllipseRule(SmoothRule):
    """``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``, the quasi-static limit of Newton-Euler dynamics."""

    name = "ellipse"
    summary = "friction losses are least under the friction ellipse: how a light body moves"
    hardware = "rubber wheels and belts, alike in all directions or ribbed: one friction limit, without passive rollers"
    is_massless_limit = True

    def friction_set(self, friction: Friction) -> FrictionSet:
        """The ellipse with half-axes mu_R and mu_S."""
        from nonsmooth.symbolic.mechanics.friction_set import FrictionSet

        return FrictionSet(friction.roll, friction.side, friction.roll.field.one)


# ---- rule ``roller`` -----------------------------------------------------------------------------
#
# Wheels with passive rollers, the friction disc cut by what the bearings of the rollers pass on.
#
# The rim of a wheel carries rollers that turn freely across it but for the friction of their bearings.  A roller that
# rolls at the speed t takes ``mu_S N |t|``, and the contact slips by ``(r, s - t)``.  The least of both is ::
#
#     D/N = min over t of  mu_R |(r, s - t)| + mu_S |t|
#         = mu_R sqrt(r^2 + s^2)                              where |s| <= k |r|: the rollers stand
#         = sqrt(mu_R^2 - mu_S^2) |r| + mu_S |s|              elsewhere: the rollers turn,  k = mu_S/sqrt(mu_R^2 -
# mu_S^2)
#
# This infimal convolution is the support function of the intersection of both sets of forces (Rockafellar 1970, theorem
# 16.4): the disc ``|f| <= mu_R N`` of the contact and the strip ``|f_S| <= mu_S N`` of the bearings.  For mu_S >= mu_R
# it is the disc, for ``mu_S = 0`` no force acts across the rim.


class RollerRule(SmoothRule):
    """The friction disc of radius mu_R, cut at mu_S across the rim."""

    name = "roller"
    summary = "friction losses are least, with rollers on each rim that stand or turn against bearing friction mu_side"
    hardware = "omniwheels and other wheels with passive rollers: mu_side is the friction of the rollers' bearings"

    def remark(self, scene: Scene) -> str:
        """Bearings that hold more than the contact never turn."""
        if all(wheel.friction.side >= wheel.friction.roll for wheel in scene.wheels):
            return "mu_side >= mu_roll: rollers never turn, so this is rule ellipse with mu_side = mu_roll"
        return ""

    def friction_set(self, friction: Friction) -> FrictionSet:
        """The disc cut by the strip; a segment without bearing friction."""
        from nonsmooth.symbolic.mechanics.friction_set import FrictionSet

        roll, side, one = friction.roll, friction.side, friction.roll.field.one
        if not side:
            return FrictionSet(roll, side, one)
        return FrictionSet(roll, roll, one if side >= roll else side / roll)


# ---- rule ``mixed`` ------------------------------------------------------------------------------
#
# Every wheel by the friction set of the rule that it names, or of its scene's.
#
# A table may hold rubber wheels beside omniwheels.  D is the sum of their support functions, each of its own set.


class MixedRule(SmoothRule):
    """The friction sets of several rules in one array; which wheel has which stands with its friction."""

    name = MIXED
    summary = "friction losses are least, each wheel with the friction set of its own rule"

    def friction_set(self, friction: Friction) -> FrictionSet:
        """That of the rule which the friction names.

        Raises:
            TypeError: for friction that names no rule with friction sets.
        """
        rule = contact_rule(friction.rule)
        if not isinstance(rule, SmoothRule):
            raise TypeError(f"required a rule with friction sets, received {friction.rule!r}")
        return rule.friction_set(friction)
