"""The least value of D on a plane ``e . v = -kappa``, in floats, for the scene itself: where a proof looks first.

Nothing rests on it but where boxes of twists lie.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import friction_sets, smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.robust.annulus import AnnulusPiece
from nonsmooth.proofs.robust.array_rows import ArrayRows
from nonsmooth.symbolic.mechanics.friction_set import float_sets
from nonsmooth.symbolic.mechanics.scene import Scene

Floats: TypeAlias = NDArray[np.float64]

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
            rates = -(places * twists[:, :2]).sum(axis=1) / np.hypot(*places.T)
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
            if np.abs(pull).max() <= enough:
                break
            move, before = -np.linalg.solve(slope, pull), np.abs(pull).max()
            pull, slope = self._derivatives(fixed + (z + move) @ plane, plane, loads)
            while np.abs(pull).max() > before and np.abs(move).max() > step:
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
    if not np.isfinite(slope).all():
        return False
    least, largest = np.linalg.eigvalsh(slope)
    return bool(least > SINGULAR * largest)


def _middle(piece: AnnulusPiece) -> tuple[float, float]:
    angle, radius = 2 * math.pi * float(piece.start + piece.width / 2), float(piece.inner + piece.outer) / 2
    return radius * math.cos(angle), radius * math.sin(angle)
