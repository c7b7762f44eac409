"""Enclosures of friction forces over boxes of slips, for friction sets with a support function.

Per unit of load the force is a subgradient of the support function of the friction set at the slip ``(r, s)``:

- rule ``ellipse``: ``(mu_R u_1, mu_S u_2)``, u the unit vector along ``(mu_R r, mu_S s)``;
- rule ``roller``: ``f_S = mu_R u_2`` cut to ``|f_S| <= mu_S``, u the unit vector along ``(r, s)``, and ``f_R = +-
  sqrt(mu_R^2 - f_S^2)`` with the sign of r.

Where a slip may vanish, the enclosure holds the whole friction set, or the part of it that its sign allows: whatever
subgradient acts, it is inside.  Wheels of a ``mixed`` array have the law of the rule that each of them names.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.intervals import Intervals, cosine
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import Scene

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


def mixed_force(
    rolls: NDArray[np.bool_], roll: Intervals, side: Intervals, r: Intervals, s: Intervals
) -> tuple[Intervals, Intervals]:
    """The same for wheels of which some have rollers: ``rolls`` says it of each, along the last axis."""
    pairs = zip(roller_force(roll, side, r, s), ellipse_force(roll, side, r, s), strict=True)
    along, across = (
        Intervals(np.where(rolls, of_roller.low, of_rim.low), np.where(rolls, of_roller.high, of_rim.high))
        for of_roller, of_rim in pairs
    )
    return along, across


# The rules whose forces are written here, and whether rollers cut the disc; another rule has no entry and is a fault.
HAS_ROLLERS = {"ellipse": False, "roller": True}
FOLLOWED = frozenset({*HAS_ROLLERS, MIXED})


def rollers(scene: Scene) -> list[bool]:
    """Of each wheel of a scene under one of the rules :data:`FOLLOWED`, whether rollers cut its friction disc."""
    return [HAS_ROLLERS[wheel.friction.rule or scene.contact.rule] for wheel in scene.wheels]


def force_law(scene: Scene) -> ForceLaw:
    """The force of each wheel of such a scene."""
    rolls = rollers(scene)
    if all(rolls):
        return roller_force
    return partial(mixed_force, np.array(rolls)) if any(rolls) else ellipse_force
