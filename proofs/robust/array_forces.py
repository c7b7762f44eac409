"""Forces and moments of all arrays of a box, for several quadrangles of places and several boxes of twists at once.

Directions are those of the ray through the middle of a quadrangle: ``e_0`` along it, ``J e_0`` across it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import Any, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.balanced_forces import LoadBox
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.boxes.intervals import Intervals, cosine
from nonsmooth.proofs.robust.box import BoxWheel
from nonsmooth.proofs.robust.level_sets import AnnulusPiece
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask

# ---- enclosures of friction forces over boxes of slips, for friction sets with a support function
#
# Per unit of load the force is a subgradient of the support function of the friction set at the slip ``(r, s)``:
#
# - rule ``ellipse``: ``(mu_R u_1, mu_S u_2)``, u the unit vector along ``(mu_R r, mu_S s)``;
# - rule ``roller``: ``f_S = mu_R u_2`` cut to ``|f_S| <= mu_S``, u the unit vector along ``(r, s)``, and ``f_R = +-
#   sqrt(mu_R^2 - f_S^2)`` with the sign of r.
#
# Where a slip may vanish, the enclosure holds the whole friction set, or the part of it that its sign allows: whatever
# subgradient acts, it is inside.  Wheels of a ``mixed`` array have the law of the rule that each of them names.


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
    rolls: Mask, roll: Intervals, side: Intervals, r: Intervals, s: Intervals
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


# ---- of all wheels -------------------------------------------------------------------------------


Pair: TypeAlias = tuple[Intervals, Intervals]
Triple: TypeAlias = tuple[Intervals, Intervals, Intervals]

ROUNDED = arb(2) ** -40  # of a ray's angle: rays are rounded to doubles


@dataclass(frozen=True)
class ArrayBox:
    """All arrays of a box.

    Attributes:
        wheels: with their parameters over the box.
        loads: affine in the place of the body.
        law: the force of a wheel under the contact rule.
    """

    wheels: list[BoxWheel]
    loads: LoadBox
    law: ForceLaw


@dataclass(frozen=True)
class PieceForces:
    """For several quadrangles; arrays of shape (pieces, parts, wheels), or (pieces, parts) for sums over wheels.

    Attributes:
        law: the force of a wheel.
        speeds: of the rows of each wheel (wheels, 2).
        frictions: of its rows (wheels, 2).
        loads: in the middle of each quadrangle, and how they change along ``e_0`` and ``J e_0`` (pieces, 1, wheels, 3).
        rows: slips by unit velocities along ``e_0`` and ``J e_0``, and by a unit rotation (pieces, 1, wheels, 3, 2).
        frame: of a place, how far it is from the middle along ``e_0`` and ``J e_0``, and the cosine and the sine of
            its angle with ``e_0`` (pieces, 1, 4).
        length: mean distance of the wheels.
    """

    law: ForceLaw
    speeds: Intervals
    frictions: Intervals
    loads: Intervals
    rows: Intervals
    frame: Intervals
    length: float

    @classmethod
    def of(cls, bound: ArrayBox, pieces: Sequence[AnnulusPiece]) -> PieceForces:
        """Of all arrays of a box."""
        return cls._of(bound, [_frame(piece) for piece in pieces])

    @classmethod
    def at_point(cls, bound: ArrayBox) -> PieceForces:
        """With the body at the origin, as for one quadrangle; ``e_0`` is the x axis."""
        zero, one = arb(0), arb(1)
        return cls._of(bound, [((one, zero), zero, (zero, zero, one, zero))])

    @classmethod
    def _of(cls, bound: ArrayBox, frames: Sequence[tuple[tuple[arb, arb], arb, Sequence[arb]]]) -> PieceForces:
        """From rays ``e_0``, distances of the middles, and what is known of the places there."""
        wheels, zero, one = bound.wheels, arb(0), arb(1)
        loads, rows = [], []
        for (x, y), middle, _ in frames:
            forms = zip(bound.loads.at((middle * x, middle * y)), bound.loads.forms, strict=True)
            loads.append([(load, p * x + q * y, q * x - p * y) for load, (_, p, q) in forms])
            units = (x, y, zero), (-y, x, zero), (zero, zero, one)
            rows.append([[wheel.moved(unit) for unit in units] for wheel in wheels])
        places = [math.hypot(*(float(entry) for entry in wheel.place)) for wheel in wheels]
        return cls(
            law=bound.law,
            speeds=Intervals.about([wheel.speeds for wheel in wheels]),
            frictions=Intervals.about([[a * b for a, b in zip(w.nominal, w.shares, strict=True)] for w in wheels]),
            loads=Intervals.about(loads)[:, None],
            rows=Intervals.about(rows)[:, None],
            frame=Intervals.about([frame for *_, frame in frames])[:, None],
            length=sum(places) / len(places) or 1.0,
        )

    def at(self, chosen: NDArray[np.intp]) -> PieceForces:
        """Of some quadrangles."""
        return replace(self, loads=self.loads[chosen], rows=self.rows[chosen], frame=self.frame[chosen])

    @property
    def turn(self) -> Pair:
        """Cosine and sine of the angle between ``e_0`` and a place (pieces, 1)."""
        return self.frame[..., 2], self.frame[..., 3]

    def forces(self, twists: Triple) -> Pair:
        """Of each wheel along its friction axis and across it, per unit of load.

        Args:
            twists: velocities along ``e_0`` and ``J e_0``, and rotations (pieces, parts).
        """
        r, s = self._moved(twists)
        return self.law(self.frictions[:, 0], self.frictions[:, 1], r - self.speeds[:, 0], s - self.speeds[:, 1])

    def power(self, forces: Pair, twists: Triple) -> Intervals:
        """Of all wheels' forces in twists (pieces, parts), the loads those of any place of the quadrangle."""
        r, s = self._moved(twists)
        return self._weighed(forces[0] * r + forces[1] * s)

    def wrench(self, forces: Pair) -> Triple:
        """Force along ``e_0`` and ``J e_0``, and moment, of all wheels (pieces, parts)."""
        along, across, moment = (
            self._weighed(forces[0] * self.rows[..., k, 0] + forces[1] * self.rows[..., k, 1]) for k in range(3)
        )
        return along, across, moment

    def least_power(self, forces: Pair, directions: Floats) -> Floats:
        """About the lower end of the power in several directions, in floats.

        Args:
            forces: of each wheel (pieces, 1, wheels).
            directions: along ``e_0`` and ``J e_0``, and rotation (pieces, choices, 3).

        Returns:
            Shape (pieces, choices).
        """
        total: Any = 0.0
        rows, loads = self.rows.middle[:, 0], self.loads.middle[:, 0, :, 0]
        for side, force in enumerate(forces):
            own = rows[..., side]
            moved = directions @ own.swapaxes(-1, -2)
            middle, reach = ((entry[:, 0] * loads)[..., None] for entry in (force.middle, force.reach))
            total = total + directions @ (own.swapaxes(-1, -2) @ middle) - np.abs(moved, out=moved) @ reach
        return np.asarray(total[..., 0])

    def _moved(self, twists: Triple) -> Pair:
        """Slips of each wheel by twists alone, without its speed."""
        x, y, spin = (entry[..., None] for entry in twists)
        r, s = (
            self.rows[..., 0, side] * x + self.rows[..., 1, side] * y + self.rows[..., 2, side] * spin
            for side in range(2)
        )
        return r, s

    def _weighed(self, powers: Intervals) -> Intervals:
        """Their sum over the wheels, with the loads of any place of the quadrangle."""
        middle, along, across = ((self.loads[..., k] * powers).sum(axis=-1) for k in range(3))
        return middle + self.frame[..., 0] * along + self.frame[..., 1] * across


def _frame(piece: AnnulusPiece) -> tuple[tuple[arb, arb], arb, Sequence[arb]]:
    """Of a quadrangle the middle ray, the distance of its middle, and the places there."""
    turn, angle = arb(as_fmpq(2 * piece.start + piece.width)), arb(as_fmpq(piece.width)) * arb.pi() + ROUNDED
    x, y = turn.cos_pi(), turn.sin_pi()
    corners = [(arb(as_fmpq(a)), arb(as_fmpq(b))) for a, b in piece.corners]
    middle = arb(as_fmpq((piece.inner + piece.outer) / 2))
    along, across = [a * x + b * y - middle for a, b in corners], [b * x - a * y for a, b in corners]
    hulls = reduce(arb.union, along), reduce(arb.union, across)
    return (x, y), middle, (*hulls, (angle * UNIT).cos(), (angle * UNIT).sin())
