"""Rule ``roller``: wheels with passive rollers, the friction disc cut by what the bearings of the rollers pass on.

The rim of a wheel carries rollers that turn freely across it but for the friction of their bearings.  A roller that
rolls at the speed t takes ``mu_S N |t|``, and the contact slips by ``(r, s - t)``.  The least of both is ::

    D/N = min over t of  mu_R |(r, s - t)| + mu_S |t|
        = mu_R sqrt(r^2 + s^2)                              where |s| <= k |r|: the rollers stand
        = sqrt(mu_R^2 - mu_S^2) |r| + mu_S |s|              elsewhere: the rollers turn,  k = mu_S/sqrt(mu_R^2 - mu_S^2)

This infimal convolution is the support function of the intersection of both sets of forces (Rockafellar 1970, theorem
16.4): the disc ``|f| <= mu_R N`` of the contact and the strip ``|f_S| <= mu_S N`` of the bearings.  For mu_S >= mu_R it
is the disc, for ``mu_S = 0`` no force acts across the rim.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import SmoothRule

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction, Scene


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
