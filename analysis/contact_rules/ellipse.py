"""Rule ``ellipse``: the motion minimizes the dissipation with the friction ellipse of the paper's Fig. 3."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import SmoothRule

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction


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
