"""Rule ``mixed``: every wheel by the friction set of the rule that it names, or of its scene's.

A table may hold rubber wheels beside omniwheels.  D is the sum of their support functions, each of its own set.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.symbolic.mechanics.rule import MIXED

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction


class MixedRule(SmoothRule):
    """The friction sets of several rules in one array; which wheel has which stands with its friction."""

    name = MIXED
    summary = "friction losses are least, each wheel with the friction set of its own rule"

    def friction_set(self, friction: Friction) -> FrictionSet:
        """That of the rule which the friction names.

        Raises:
            TypeError: for friction that names no rule with friction sets.
        """
        own = contact_rule(friction.rule)
        if not isinstance(own, SmoothRule):
            raise TypeError(f"required a rule with friction sets, received {friction.rule!r}")
        return own.friction_set(friction)
