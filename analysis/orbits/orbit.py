"""A periodic orbit in floats: one turn of legs that closes, its period and its Floquet multipliers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.orbits.variation import monodromy
from nonsmooth.analysis.trajectories.legs import Leg
from nonsmooth.analysis.trajectories.result import Trajectory

# Of a multiplier's distance from the unit circle: nearer ones are not told apart, as multipliers err by some 1e-10.
NEUTRAL = 1e-6


@dataclass(frozen=True, eq=False)
class Orbit:
    """One turn of a periodic orbit.

    Attributes:
        field: whose solution it is.
        path: the turn, from a point inside a leg back to it.
        legs: its legs, in order; the first and the last are parts of one.
        gap: by how much the computed turn fails to close (largest entry).
    """

    field: SignField
    path: Trajectory
    legs: tuple[Leg, ...]
    gap: float

    @property
    def period(self) -> float:
        """Time of one turn."""
        return self.legs[-1].end

    @property
    def point(self) -> Vector:
        """Where the turn begins and ends: inside its longest leg."""
        return self.legs[0].first

    @property
    def slides(self) -> bool:
        """Whether it keeps to a switching surface for a while."""
        return any(leg.motion.face.keep for leg in self.legs)

    @cached_property
    def monodromy(self) -> Vector:
        """Derivative (n, n) of the state after one turn by the state before.

        Raises:
            OrbitError: where it does not exist.
        """
        return monodromy(self.field, self.legs)

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """The n - 1 Floquet multipliers beside the one along the orbit, which is 1; largest first.

        Raises:
            OrbitError: where the orbit has no derivative.
        """
        along = self.legs[0].motion(0.0, self.point)
        basis, _ = np.linalg.qr(np.column_stack([along, np.eye(len(along))]))
        across = (basis.T @ self.monodromy @ basis)[1:, 1:]
        values = np.linalg.eigvals(across).astype(complex)
        return np.asarray(values[np.argsort(-np.abs(values), kind="stable")])

    @property
    def stability(self) -> str:
        """``attracting``, ``repelling``, ``saddle`` or ``neutral``: by the multipliers as computed."""
        sizes = np.abs(self.multipliers)
        if (np.abs(sizes - 1) <= NEUTRAL).any():
            return "repelling" if (sizes > 1 + NEUTRAL).any() else "neutral"
        if (sizes < 1).all():
            return "attracting"
        return "repelling" if (sizes > 1).all() else "saddle"
