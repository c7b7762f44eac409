"""Enclosures of friction forces over boxes of slips, for friction sets with a support function.

Per unit of load the force is a subgradient of the support function of the friction set at the slip ``(r, s)``:

- rule ``ellipse``: ``(mu_R u_1, mu_S u_2)``, u the unit vector along ``(mu_R r, mu_S s)``;
- rule ``roller``: ``f_S = mu_R u_2`` cut to ``|f_S| <= mu_S``, u the unit vector along ``(r, s)``, and ``f_R = +-
  sqrt(mu_R^2 - f_S^2)`` with the sign of r.

Where a slip may vanish, the enclosure holds the whole friction set, or the part of it that its sign allows: whatever
subgradient acts, it is inside.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from nonsmooth.proofs.boxes.intervals import Intervals, cosine

ForceLaw: TypeAlias = Callable[[Intervals, Intervals, Intervals, Intervals], tuple[Intervals, Intervals]]


def ellipse_force(roll: Intervals, side: Intervals, r: Intervals, s: Intervals) -> tuple[Intervals, Intervals]:
    """Along the friction axis and across it, per unit of load.

    Args:
        roll: mu_R.
        side: mu_S.
        r: slip along the axis.
        s: slip across it.
    """
    a, b = roll * r, side * s
    return roll * cosine(a, b), side * cosine(b, a)


def roller_force(roll: Intervals, side: Intervals, r: Intervals, s: Intervals) -> tuple[Intervals, Intervals]:
    """The same for wheels with passive rollers."""
    across = (roll * cosine(s, r)).within(side)
    size = (roll.square - across.square).sqrt()
    along = Intervals(
        np.where(r.low > 0, size.low, -size.high),
        np.where(r.high < 0, -size.low, size.high),
    )
    return along, across


FORCE_LAWS: dict[str, ForceLaw] = {"ellipse": ellipse_force, "roller": roller_force}
