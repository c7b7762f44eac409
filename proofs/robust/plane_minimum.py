"""The least value of D on a plane ``e . v = -kappa``, in floats, for the scene itself: where a proof looks first.

Nothing rests on it but where boxes of twists lie.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.contact_rule import friction_sets, smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import regular_triples
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import affine_loads
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.robust.level_sets import AnnulusPiece
from nonsmooth.symbolic.mechanics.friction_set import float_sets
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, are_finite, max_norm, norms, squared_norms

# ---- the rows of an array and the limits of its friction forces ----------------------------------
#
# In floats: what proofs look at to find their guesses.


class ArrayRows:
    """Of a centred scene with known loads.

    Attributes:
        length: by which moments are divided.
        rows: of each wheel along and across its friction axis, by ``(v, length omega)`` (2n, 3).
        speeds: their right sides (2n).
        friction: their coefficients of friction (2n).
    """

    def __init__(self, scene: Scene) -> None:
        model = contact_model(scene)
        self.length = float(np.sqrt(squared_norms(model.positions).mean())) or 1.0
        self.rows = model.rows / [1.0, 1.0, self.length]
        self.speeds, self.friction = model.targets, model.friction
        every = np.arange(model.wheels)
        self._forms = affine_loads(model, every) if model.load_table is None else model.load_table

    def limits(self, place: Sequence[float]) -> Floats:
        """Largest friction force of each row with the body at a place."""
        return self.friction * np.repeat(self.loads(place), 2)

    def loads(self, place: Sequence[float]) -> Floats:
        """Of all wheels with the body at a place."""
        return self._forms @ np.array([1.0, *place])

    @property
    def fastest(self) -> float:
        """Speed of the fastest row."""
        return max_norm(self.speeds)


# ---- the least value on a plane ------------------------------------------------------------------


STEPS = 30  # of Newton's method
SHORT = 2.0**-20  # of the fastest wheel's speed: the shortest step
SINGULAR = 2.0**-44  # of the largest curvature of D: a smaller one is rounding
DONE = 2.0**-40  # of the sum of all friction: gradient that is small enough


class PlaneMinimum(NamedTuple):
    """Twists ``v = -kappa e + lateral J e``, ``omega = spin``, near the least value of D.

    With ``xi = xi^ + T z``, T with the rows ``(a, b)`` by ``lateral`` and ``(c, d)`` by ``spin``, D curves by one in z.
    """

    kappa: float
    lateral: float
    spin: float
    a: float
    b: float
    c: float
    d: float


class PlaneMinima:
    """Guesses for a centred scene under a rule with friction sets, each found once."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._rows = scene, ArrayRows(scene)
        self._sets = float_sets(friction_sets(scene))
        self._radial: dict[AnnulusPiece, float | None] = {}
        self._found: dict[tuple[AnnulusPiece, float], PlaneMinimum | None] = {}

    def radial(self, pieces: Sequence[AnnulusPiece]) -> list[float | None]:
        """``-e . v`` of the scene in the middle of each quadrangle; None where it is not positive."""
        new = [piece for piece in pieces if piece not in self._radial]
        if new:
            places = np.array([_middle(piece) for piece in new])
            twists = minima_under(smooth_rule_of(self._scene), self._scene, places).twists
            rates = -(places * twists[:, :2]).sum(axis=1) / norms(places)
            self._radial |= {piece: rate if rate > 0 else None for piece, rate in zip(new, rates.tolist(), strict=True)}
        return [self._radial[piece] for piece in pieces]

    def on_plane(self, piece: AnnulusPiece, share: float) -> PlaneMinimum | None:
        """In the middle of a quadrangle, at a share of the scene's rate; None where D has no curvature that shows."""
        if (piece, share) not in self._found:
            rate = self.radial([piece])[0]
            self._found[piece, share] = None if rate is None else self._search(piece, share * rate)
        return self._found[piece, share]

    def _search(self, piece: AnnulusPiece, kappa: float) -> PlaneMinimum | None:
        """Newton's method; steps are halved while the gradient grows."""
        place = _middle(piece)
        e = np.array(place) / math.hypot(*place)
        loads = self._rows.loads(place)
        plane = np.array([[-e[1], e[0], 0.0], [0.0, 0.0, 1.0]])  # lateral velocity, and spin times length
        fixed, step = np.array([*(-kappa * e), 0.0]), SHORT * (self._rows.fastest or 1.0)
        enough = DONE * self._rows.limits(place).sum()
        z = np.zeros(2)
        pull, slope = self._derivatives(fixed, plane, loads)
        for _ in range(STEPS):
            if not _curves(slope):
                return None
            if max_norm(pull) <= enough:
                break
            move, before = -np.linalg.solve(slope, pull), np.abs(pull).max()
            pull, slope = self._derivatives(fixed + (z + move) @ plane, plane, loads)
            while max_norm(pull) > before and max_norm(move) > step:
                move /= 2
                pull, slope = self._derivatives(fixed + (z + move) @ plane, plane, loads)
            z = z + move
        if not _curves(slope):
            return None
        columns = np.linalg.inv(np.linalg.cholesky(slope)).T
        columns[1] /= self._rows.length
        return PlaneMinimum(kappa, float(z[0]), float(z[1]) / self._rows.length, *columns.ravel().tolist())

    def _derivatives(self, twist: Floats, plane: Floats, loads: Floats) -> tuple[Floats, Floats]:
        """Gradient and Hessian of D by ``(v, length omega)`` along the plane."""
        rows = self._rows.rows @ plane.T
        slips = self._rows.rows @ twist - self._rows.speeds
        r, s, along, across = slips[::2], slips[1::2], rows[::2], rows[1::2]
        f, g = (loads * entry for entry in self._sets.gradient(r, s))
        by_r, both, by_s = (loads * entry for entry in self._sets.hessian(r, s))
        mixed = along.T @ (both[:, None] * across)
        slope = along.T @ (by_r[:, None] * along) + mixed + mixed.T + across.T @ (by_s[:, None] * across)
        return along.T @ f + across.T @ g, slope


def _curves(slope: Floats) -> bool:
    """Whether a Hessian shows curvature in every direction, beyond rounding."""
    if not are_finite(slope):
        return False
    least, largest = np.linalg.eigvalsh(slope)
    return bool(least > SINGULAR * largest)


def _middle(piece: AnnulusPiece) -> tuple[float, float]:
    angle, radius = 2 * math.pi * float(piece.start + piece.width / 2), float(piece.inner + piece.outer) / 2
    return radius * math.cos(angle), radius * math.sin(angle)


# ---- twists at the corners of D under rule ``box`` -----------------------------------------------
#
# In floats: what balances a push.  No proof rests on them.
#
# ``D - G . xi`` is convex and linear in pieces, so that where it has a least value one is at a corner, a twist that
# satisfies three independent rows.  Which twists are corners depends neither on the loads nor on the push G.


MAX_WHEELS = 30  # 34,220 triples of rows
SATISFIED = 2.0**-30  # of the fastest wheel's speed: a smaller slip is rounding
LARGEST_SHARE = 0.999  # largest share of a limit that is proposed for a row that is satisfied


@dataclass(frozen=True)
class Proposal:
    """Friction forces that balance a push at one place of the body.

    Attributes:
        shares: of each row's limit; ``+-1`` where it slips (2n).
        satisfied: rows that are satisfied (2n).
        response: how these shares change with the force that is missing, zero elsewhere (2n, 3).
    """

    shares: Floats
    satisfied: Mask
    response: Floats


class BoxCorners(ArrayRows):
    """The rows of a centred scene and the corners of its D."""

    @cached_property
    def twists(self) -> Floats:
        """All corners, (m, 3), with ``length omega`` last."""
        able = np.flatnonzero(self.friction > 0)
        return regular_triples(self.rows[able], self.speeds[able])[1]

    @cached_property
    def _slips(self) -> Floats:
        return np.abs(self.twists @ self.rows.T - self.speeds)

    def least(self, place: Sequence[float], push: Floats) -> tuple[Floats, float]:
        """The corner at which ``D - push . xi`` is least, and that value."""
        values = self._slips @ self.limits(place) - self.twists @ push
        best = int(np.argmin(values))
        return self.twists[best], float(values[best])

    def dissipation(self, place: Sequence[float], twist: Floats) -> float:
        """D."""
        return float(np.abs(self.rows @ twist - self.speeds) @ self.limits(place))

    def proposal(self, place: Sequence[float], push: Floats, twist: Floats) -> Proposal | None:
        """Forces that balance a push while the body moves with a twist at which ``D - push . xi`` is least."""
        limits, slips = self.limits(place), self.rows @ twist - self.speeds
        satisfied = (np.abs(slips) <= SATISFIED * (self.fastest or 1.0)) & (self.friction > 0)
        if (limits[satisfied] <= 0).any():
            return None
        shares = np.where(satisfied | (self.friction <= 0), 0.0, np.sign(slips))
        missing = push - self.rows.T @ (limits * shares)
        columns = self.rows[satisfied] * limits[satisfied][:, None]
        square = columns.T @ columns
        if np.linalg.matrix_rank(square) < 3:
            return None
        response = np.zeros((len(limits), 3))
        response[satisfied] = columns @ np.linalg.inv(square)
        shares[satisfied] = _within(columns, missing, response[satisfied] @ missing)
        return Proposal(shares, satisfied, response) if max_norm(shares[satisfied]) < LARGEST_SHARE else None


def _within(columns: Floats, missing: Floats, shares: Floats) -> Floats:
    """Shares of least square, or where one is too large those whose largest is least, by a linear program."""
    if max_norm(shares) < LARGEST_SHARE or len(shares) == 3:
        return shares
    count = len(shares)
    ones = np.ones((count, 1))
    solution = solve_program(
        np.r_[np.zeros(count), 1.0],
        A_ub=np.block([[np.eye(count), -ones], [-np.eye(count), -ones]]),
        b_ub=np.zeros(2 * count),
        A_eq=np.column_stack([columns.T, np.zeros(3)]),
        b_eq=missing,
        bounds=[(None, None)] * count + [(0, None)],
    )
    return solution.x[:count] if solution.success else shares
