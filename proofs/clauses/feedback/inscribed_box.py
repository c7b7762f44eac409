"""What rule ``box`` proves about imposed twists, for rules whose friction sets are cut: a box inside each set.

Let a cut friction set hold the box ``|f_R| <= rho N, |f_S| <= kappa beta N``, ``rho <= alpha sqrt(1 - kappa^2)``, that
spans it across the rim.  Then D is at least that of the boxes for every twist, and equal where no rim slips along.  So
a twist that is the only minimizer for boxes, at speeds at which no rim slips along, is the only minimizer here too, at
the same places c.  (Rule ``roller``: the rollers turn, ``rho <= sqrt(mu_R^2 - mu_S^2)``.)
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.symbolic.friction_set import FrictionSet
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Friction, Scene

_BITS = 20  # of the rational below sqrt(1 - kappa^2)
_SMALLEST = 2.0**-10  # of sqrt(1 - kappa^2): below it a box holds next to nothing of the set


def inscribed_boxes(scene: Scene) -> Scene | None:
    """The array under rule ``box`` with boxes inside the friction sets; None where a set is not cut, or hardly not."""
    rule, wheels = smooth_rule_of(scene), []
    for wheel in scene.wheels:
        limits = rule.friction_set(wheel.friction)
        width = box_width(limits)
        if width is None:
            return None
        wheels.append(replace(wheel, friction=Friction(limits.along * width, limits.across * limits.cut)))
    return replace(scene.under("box"), wheels=tuple(wheels))


def box_width(limits: FrictionSet) -> Fraction | None:
    """A rational of at most ``sqrt(1 - kappa^2)``: one for a segment along the rim, None for a whole ellipse."""
    if not limits.across:
        return Fraction(1)
    if not limits.is_cut:
        return None
    proposal = math.sqrt(1 - float(limits.cut) ** 2)
    width = Fraction(math.floor(proposal * 2**_BITS) - 1, 2**_BITS)
    return width if proposal > _SMALLEST and fits(limits.cut, width) else None


def fits(cut: Number, width: Fraction) -> bool:
    """Whether the corner (width, kappa) is in the unit disc, exactly."""
    return bool(cut * cut + width * width <= 1)
