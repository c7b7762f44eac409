"""Forces and moments of all arrays of a box, for several quadrangles of places and several boxes of twists at once.

Directions are those of the ray through the middle of a quadrangle: ``e_0`` along it, ``J e_0`` across it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from nonsmooth.proofs.robust.annulus import AnnulusPiece
from nonsmooth.proofs.robust.box_wheel import BoxWheel
from nonsmooth.proofs.robust.friction_forces import ForceLaw
from nonsmooth.proofs.robust.intervals import Intervals
from nonsmooth.proofs.robust.load_box import LoadBox
from nonsmooth.symbolic.numbers.coefficients import as_fmpq

Floats: TypeAlias = NDArray[np.float64]
Pair: TypeAlias = tuple[Intervals, Intervals]
BallPair: TypeAlias = tuple[arb, arb]
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
        speeds: of the rows of each wheel (wheels).
        frictions: of its rows (wheels).
        loads: in the middle of each quadrangle (pieces, 1, wheels).
        by_place: how they change along ``e_0`` and ``J e_0`` (pieces, 1, wheels).
        offset: of a place from there, along ``e_0`` and ``J e_0`` (pieces, 1).
        cosine: of the angle between ``e_0`` and a place (pieces, 1).
        sine: of the same.
        basis: slips by unit velocities along ``e_0`` and ``J e_0``, and by a unit rotation (pieces, 1, wheels).
        length: mean distance of the wheels.
    """

    law: ForceLaw
    speeds: Pair
    frictions: Pair
    loads: Intervals
    by_place: Pair
    offset: Pair
    cosine: Intervals
    sine: Intervals
    basis: tuple[Pair, Pair, Pair]
    length: float

    @classmethod
    def of(cls, bound: ArrayBox, pieces: Sequence[AnnulusPiece]) -> PieceForces:
        """Of all arrays of a box."""
        angles = [(arb(as_fmpq(piece.width)) * arb.pi() + ROUNDED) * arb(0, 1) for piece in pieces]
        turns = [arb(as_fmpq(2 * piece.start + piece.width)) for piece in pieces]
        rays = [(turn.cos_pi(), turn.sin_pi()) for turn in turns]
        return cls._of(bound, angles, rays, [_hull(piece, ray) for piece, ray in zip(pieces, rays, strict=True)])

    @classmethod
    def at_point(cls, bound: ArrayBox) -> PieceForces:
        """With the body at the origin, as for one quadrangle; ``e_0`` is the x axis."""
        zero, one = arb(0), arb(1)
        return cls._of(bound, [zero], [(one, zero)], [((zero, zero), (zero, zero))])

    @classmethod
    def _of(
        cls, bound: ArrayBox, angles: list[arb], rays: list[tuple[arb, arb]], hulls: list[tuple[BallPair, BallPair]]
    ) -> PieceForces:
        wheels, forms = bound.wheels, bound.loads.forms
        moved = [[_moved(wheel, *ray) for wheel in wheels] for ray in rays]
        along, across, turned = (
            (_table([[of[k][0] for of in row] for row in moved]), _table([[of[k][1] for of in row] for row in moved]))
            for k in range(3)
        )
        places = [math.hypot(*(float(entry) for entry in wheel.place)) for wheel in wheels]
        return cls(
            law=bound.law,
            speeds=_pair([wheel.speeds for wheel in wheels]),
            frictions=_pair([(w.nominal[0] * w.shares[0], w.nominal[1] * w.shares[1]) for w in wheels]),
            loads=_table([bound.loads.at(middle) for middle, _ in hulls]),
            by_place=(
                _table([[by_x * x + by_y * y for _, by_x, by_y in forms] for x, y in rays]),
                _table([[by_y * x - by_x * y for _, by_x, by_y in forms] for x, y in rays]),
            ),
            offset=_columns(_pair([reach for _, reach in hulls])),
            cosine=Intervals.about([angle.cos() for angle in angles])[:, None],
            sine=Intervals.about([angle.sin() for angle in angles])[:, None],
            basis=(along, across, turned),
            length=sum(places) / len(places) or 1.0,
        )

    def at(self, chosen: NDArray[np.intp]) -> PieceForces:
        """Of some quadrangles."""
        along, across, turned = ((r[chosen], s[chosen]) for r, s in self.basis)
        return replace(
            self,
            loads=self.loads[chosen],
            by_place=(self.by_place[0][chosen], self.by_place[1][chosen]),
            offset=(self.offset[0][chosen], self.offset[1][chosen]),
            cosine=self.cosine[chosen],
            sine=self.sine[chosen],
            basis=(along, across, turned),
        )

    def forces(self, twists: Triple) -> Pair:
        """Of each wheel along its friction axis and across it, per unit of load.

        Args:
            twists: velocities along ``e_0`` and ``J e_0``, and rotations (pieces, parts).
        """
        r, s = self._moved(twists)
        return self.law(*self.frictions, r - self.speeds[0], s - self.speeds[1])

    def power(self, forces: Pair, twists: Triple) -> Intervals:
        """Of all wheels' forces in twists (pieces, parts), the loads those of any place of the quadrangle."""
        r, s = self._moved(twists)
        powers = forces[0] * r + forces[1] * s
        middle, along, across = ((factor * powers).sum(axis=-1) for factor in (self.loads, *self.by_place))
        return middle + self.offset[0] * along + self.offset[1] * across

    def least_power(self, forces: Pair, direction: tuple[Floats, Floats, Floats]) -> Floats:
        """About the lower end of the power in a direction (pieces, parts), in floats."""
        total = np.zeros(())
        for k, force in enumerate(forces):
            moved = sum(
                (entry[..., None] * basis[k].middle for entry, basis in zip(direction, self.basis, strict=True)),
                np.zeros(()),
            )
            total = total + force.middle * moved - force.reach * np.abs(moved)
        return np.asarray((self.loads.middle * total).sum(axis=-1))

    def _moved(self, twists: Triple) -> Pair:
        """Slips of each wheel by twists alone, without its speed."""
        (first, *rest), (entry, *others) = self.basis, twists
        r, s = first[0] * entry[..., None], first[1] * entry[..., None]
        for (by_r, by_s), other in zip(rest, others, strict=True):
            r, s = r + by_r * other[..., None], s + by_s * other[..., None]
        return r, s


def _moved(wheel: BoxWheel, x: arb, y: arb) -> list[tuple[arb, arb]]:
    """Slips of a wheel by unit velocities along ``e_0 = (x, y)`` and across it, and by a unit rotation."""
    zero = arb(0)
    return [wheel.moved((x, y, zero)), wheel.moved((-y, x, zero)), wheel.moved((zero, zero, arb(1)))]


def _hull(piece: AnnulusPiece, ray: BallPair) -> tuple[BallPair, BallPair]:
    """A point on the middle ray of a quadrangle, and balls of how far its places are from it, along and across."""
    x, y = ray
    corners = [(arb(as_fmpq(a)), arb(as_fmpq(b))) for a, b in piece.corners]
    middle = arb(as_fmpq((piece.inner + piece.outer) / 2))
    along, across = [a * x + b * y - middle for a, b in corners], [b * x - a * y for a, b in corners]
    return (middle * x, middle * y), (_union(along), _union(across))


def _union(balls: Sequence[arb]) -> arb:
    found = balls[0]
    for ball in balls[1:]:
        found = found.union(ball)
    return found


def _pair(rows: Sequence[tuple[arb, arb]]) -> Pair:
    return Intervals.about([row[0] for row in rows]), Intervals.about([row[1] for row in rows])


def _columns(pair: Pair) -> Pair:
    return pair[0][:, None], pair[1][:, None]


def _table(rows: Sequence[Sequence[arb]]) -> Intervals:
    """(pieces, 1, wheels)."""
    found = [Intervals.about(row) for row in rows]
    return Intervals(np.stack([each.low for each in found]), np.stack([each.high for each in found]))[:, None]
