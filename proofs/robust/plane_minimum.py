"""The least value of D on a plane ``e . v = -kappa``, in floats, for the scene itself: where a proof looks first.

Nothing rests on it but where boxes of twists lie.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.robust.annulus import AnnulusPiece
from nonsmooth.proofs.robust.array_rows import ArrayRows
from nonsmooth.proofs.robust.wheel_force import HAS_ROLLERS
from nonsmooth.symbolic.scene import Scene

Floats: TypeAlias = NDArray[np.float64]

STEPS = 30  # of Newton's method
SHORT = 2.0**-20  # of the fastest wheel's speed: step of differences
DONE = 2.0**-40  # of the sum of all friction: gradient that is small enough


@dataclass(frozen=True)
class PlaneMinimum:
    """Twists ``v = -kappa e + lateral J e``, ``omega = spin``, near the least value of D.

    Attributes:
        kappa: speed of the plane (length/time).
        lateral: ``J e . v``.
        spin: omega (1/time).
        columns: of T, rows by ``lateral`` and by ``spin``; in ``z`` with ``xi = xi^ + T z`` D curves by one.
    """

    kappa: float
    lateral: float
    spin: float
    columns: tuple[tuple[float, float], tuple[float, float]]


class PlaneMinima:
    """Guesses for a centred scene under a rule with friction sets, each found once."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._rows = scene, ArrayRows(scene)
        self._radial: dict[AnnulusPiece, float | None] = {}
        self._found: dict[tuple[AnnulusPiece, float], PlaneMinimum | None] = {}

    def radial(self, pieces: Sequence[AnnulusPiece]) -> list[float | None]:
        """``-e . v`` of the scene in the middle of each quadrangle; None where it is not positive."""
        new = [piece for piece in pieces if piece not in self._radial]
        if new:
            places = np.array([_middle(piece) for piece in new])
            twists = smooth_rule_of(self._scene).minima(self._scene, places).twists
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
        """Newton's method with differences of the gradient; steps are halved while the gradient grows."""
        place = _middle(piece)
        e = np.array(place) / math.hypot(*place)
        limits = self._rows.limits(place)
        plane = np.array([[-e[1], e[0], 0.0], [0.0, 0.0, 1.0]])  # lateral velocity, and spin times length
        fixed, step = np.array([*(-kappa * e), 0.0]), SHORT * (self._rows.fastest or 1.0)

        def gradient(z: Floats) -> Floats:
            return plane @ self._gradient(fixed + z @ plane, limits)

        z = np.zeros(2)
        pull = gradient(z)
        for _ in range(STEPS):
            slope = np.column_stack([(gradient(z + step * u) - gradient(z - step * u)) / (2 * step) for u in np.eye(2)])
            slope = (slope + slope.T) / 2
            if not np.isfinite(slope).all() or np.linalg.eigvalsh(slope)[0] <= 0:
                return None
            if np.abs(pull).max() <= DONE * limits.sum():
                break
            move = -np.linalg.solve(slope, pull)
            while np.abs(gradient(z + move)).max() > np.abs(pull).max() and np.abs(move).max() > step:
                move /= 2
            z = z + move
            pull = gradient(z)
        columns = np.linalg.inv(np.linalg.cholesky(slope)).T
        columns[1] /= self._rows.length
        (a, b), (c, d) = columns.tolist()
        return PlaneMinimum(kappa, float(z[0]), float(z[1]) / self._rows.length, ((a, b), (c, d)))

    def _gradient(self, twist: Floats, limits: Floats) -> Floats:
        """Of D by ``(v, length omega)``."""
        slips = self._rows.rows @ twist - self._rows.speeds
        r, s = slips[::2], slips[1::2]
        roll, side = limits[::2], limits[1::2]
        if HAS_ROLLERS[self._scene.contact.rule]:
            size = np.hypot(r, s)
            across = np.clip(roll * s / size, -side, side)
            forces = np.sign(r) * np.sqrt(roll**2 - across**2), across
        else:
            size = np.hypot(roll * r, side * s)
            forces = roll**2 * r / size, side**2 * s / size
        return np.asarray(self._rows.rows.T @ np.stack(forces, axis=1).ravel())


def _middle(piece: AnnulusPiece) -> tuple[float, float]:
    angle, radius = 2 * math.pi * float(piece.start + piece.width / 2), float(piece.inner + piece.outer) / 2
    return radius * math.cos(angle), radius * math.sin(angle)
