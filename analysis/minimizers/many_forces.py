"""Friction forces under rule ``ellipse`` that hold a given motion of many wheels, in floats.

As :mod:`nonsmooth.analysis.minimizers.friction_search`, by Newton steps of least norm from random starts.  The random
forces of many wheels all add up to nearly the same, far from zero, and steps in angles would leave the half circles.
So the unknown of a wheel that slips is z with ``cos phi = tanh z``, ``sin phi = sech z``, that of another wheel q in
the plane with the force ``q / sqrt(1 + |q|^2)``: no step leaves the half circle or the disc.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.minimizers.friction_search import (
    BALANCED,
    REGULARIZATION,
    SEED,
    STEPS,
    Floats,
    ForceMargins,
    FrictionForces,
    RimDemand,
    in_common_units,
)

MANY = 34  # wheels; of so many or fewer the search in angles finds forces
STARTS = 256
FEWEST_STARTS = 16
UNKNOWNS = 8_192  # of all starts together: of many wheels most starts lead to forces with a margin
LONGEST_STEP = 0.5  # of z and q
FARTHEST_START = 2.0  # of z: there a wheel spins four times as fast as it slips


def search_many_forces(
    along: Floats, across: Floats, signs: NDArray[np.int_], cuts: Floats, demand: RimDemand
) -> FrictionForces | None:
    """Forces that add up to zero, with slow rims; None where no start leads to any with a margin.

    Args:
        along: columns of forces along the rims, (n, 3).
        across: columns of forces across, (n, 3).
        signs: sign of each wheel's slip across.
        cuts: share of the half-axes across at which the ellipses are cut, (n,); 1 where they are not.
        demand: the speeds of the rims by their forces.
    """
    along, across = in_common_units(along, across)
    balance = _PlaneBalance(along, across, signs, cuts)
    z, q = balance.starts(np.random.default_rng(SEED))
    for _ in range(STEPS):
        z, q = balance.stepped(z, q)
    sticking = _in_disc(q)
    balanced = np.abs(balance.force(z, sticking)).max(axis=1) < BALANCED
    margin = np.minimum(balance.slipping_margin(1 / np.cosh(z)), balance.sticking_margin(sticking))
    best = balance.slowest(np.where(balanced, margin, -1), np.sinh(z), demand)
    return None if best is None else FrictionForces(2 * np.arctan(np.exp(-z[best])), sticking[best])


def _in_disc(q: Floats) -> Floats:
    """Points of the plane (..., 2), drawn into the open unit disc."""
    return np.asarray(q / np.sqrt(1 + (q**2).sum(axis=-1, keepdims=True)))


class _PlaneBalance(ForceMargins):
    """The sum of all forces for many starts at once: z (m, k) of slipping wheels, q (m, l, 2) of the others."""

    def __init__(self, along: Floats, across: Floats, signs: NDArray[np.int_], cuts: Floats) -> None:
        slips, still = np.flatnonzero(signs), np.flatnonzero(signs == 0)
        self.slips, self.cuts, self.still_cuts = slips, cuts[slips], cuts[still]
        self.turns = np.asarray(along[slips].any(axis=1))
        self.first, self.second = along[slips], across[slips] * signs[slips, None]
        self.fixed = np.stack([along[still], across[still]], axis=1)

    def starts(self, rng: np.random.Generator) -> tuple[Floats, Floats]:
        """Random angles, and random points of the discs."""
        still = len(self.fixed)
        count = int(np.clip(UNKNOWNS // (len(self.first) + 2 * still), FEWEST_STARTS, STARTS))
        z = np.where(self.turns, np.arctanh(np.cos(rng.uniform(0, np.pi, (count, len(self.first))))), 0)
        turns, lengths = rng.uniform(0, 2 * np.pi, (count, still)), np.sqrt(rng.uniform(0, 1, (count, still)))
        sticking = np.stack([lengths * np.cos(turns), lengths * np.sin(turns)], axis=-1)
        return z.clip(-FARTHEST_START, FARTHEST_START), sticking / np.sqrt(1 - lengths**2)[..., None]

    def force(self, z: Floats, sticking: Floats) -> Floats:
        """What is left of the balance, (m, 3)."""
        slipping = np.tanh(z) @ self.first + self.heights(1 / np.cosh(z)) @ self.second
        return np.asarray(slipping + sticking.reshape(len(z), -1) @ self.fixed.reshape(-1, 3))

    def stepped(self, z: Floats, q: Floats) -> tuple[Floats, Floats]:
        """A Newton step of least norm, shortened where it is long."""
        sticking = _in_disc(q)
        columns = np.concatenate([self._turning(z), self._moving(q, sticking)], axis=1)
        normal = columns.transpose(0, 2, 1) @ columns + REGULARIZATION * np.eye(3)
        step = -(columns @ np.linalg.solve(normal, self.force(z, sticking)[..., None]))[..., 0]
        step *= np.minimum(1, LONGEST_STEP / np.maximum(np.abs(step).max(axis=1, keepdims=True), LONGEST_STEP))
        return z + step[:, : len(self.first)], q + step[:, len(self.first) :].reshape(q.shape)

    def _turning(self, z: Floats) -> Floats:
        """Derivative of the force by each z, (m, k, 3)."""
        across = 1 / np.cosh(z)[..., None]
        rising = np.where(self.turns & (1 / np.cosh(z) < self.cuts), np.tanh(z), 0)[..., None]
        return np.asarray(across * (across * self.first - rising * self.second))

    def _moving(self, q: Floats, sticking: Floats) -> Floats:
        """Derivative of the force by each coordinate of q, (m, 2l, 3)."""
        size = np.sqrt(1 + (q**2).sum(axis=-1))[..., None, None]
        slopes = (np.eye(2) - sticking[..., :, None] * sticking[..., None, :]) / size
        return np.asarray((slopes @ self.fixed).reshape(len(q), -1, 3))
