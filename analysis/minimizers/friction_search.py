"""Friction forces under rule ``ellipse`` that hold a given motion, in floats: which speeds make it the minimizer.

A wheel that slips across, with sign s, carries any force ``(cos phi, s sin phi)`` on that half of its friction ellipse
(in units of its axes): the speed along the rim sets phi in (0, pi).  A wheel that does not slip carries any force
inside.  Where the ellipse is cut (rule ``roller``), ``sin phi`` stops at the cut: there rollers turn, and the rim does
not slip.  With columns ``N mu_R [d; d . J p]`` and ``N mu_S [n; n . J p]`` the forces must add up to zero: three
equations, many unknowns, curved.  Newton steps of least norm from many random starts at once find points of that
set.  Of those that keep a margin to all limits the one is taken whose fastest rim is slowest: a force almost along the
rim asks the rim to spin many times as fast as its wheel slips across.  The search may fail where the margins are small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STARTS = 256
STEPS = 15
LONGEST_STEP = 0.5  # radian, or parts of an axis
BALANCED = 1e-9  # residual, relative to the largest entries of columns: Newton ends at 1e-15 or does not converge
LEAST_MARGIN = 0.01  # parts of an axis: with less a wheel would have to spin a hundred times as fast as it slips
AMPLE_MARGIN = 0.15  # parts of an axis: of forces with as much, or with the most there is, slow rims are preferred
REGULARIZATION = 1e-12  # of the normal matrix, in units of the largest column, where columns do not span
SEED = 0


@dataclass(frozen=True, eq=False)
class RimDemand:
    """At which speeds the rims of wheels turn their forces: ``u = rolling - turning cot(phi)``.

    Attributes:
        rolling: ``a . xi``, the speed at which the rim does not slip along, (n,).
        turning: ``|b . xi|`` times the axes of the friction set across over along, (n,).
    """

    rolling: Floats
    turning: Floats

    def fastest(self, slips: NDArray[np.int_], cotangents: Floats) -> Floats:
        """The speed of the fastest rim, (m,), by the cotangents of phi (m, k) of the wheels that slip across."""
        speeds = np.tile(self.rolling, (len(cotangents), 1))
        speeds[:, slips] -= self.turning[slips] * cotangents
        return np.asarray(np.abs(speeds).max(axis=1))


@dataclass(frozen=True)
class FrictionForces:
    """Forces in units of the axes of each wheel's ellipse.

    Attributes:
        angles: phi of each wheel that slips across, in (0, pi).
        sticking: (along, across) of each wheel that does not.
    """

    angles: Floats
    sticking: Floats


def search_forces(
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
    balance = _AngleBalance(along, across, signs, cuts)
    angles, sticking = balance.starts(np.random.default_rng(SEED))
    for _ in range(STEPS):
        angles, sticking = balance.stepped(angles, sticking)
    pairs = np.stack(np.split(sticking, 2, axis=1), axis=-1)
    inside = ((angles > 0) & (angles < np.pi)).all(axis=1)
    inside &= np.abs(balance.force(angles, sticking)).max(axis=1) < BALANCED
    margin = np.minimum(balance.slipping_margin(np.sin(angles)), balance.sticking_margin(pairs))
    best = balance.slowest(np.where(inside, margin, -1), 1 / np.tan(angles), demand)
    return None if best is None else FrictionForces(angles[best], pairs[best])


def in_common_units(along: Floats, across: Floats) -> tuple[Floats, Floats]:
    """The columns of forces, divided by the largest entry of each kind: moments have another unit than forces."""
    size = np.maximum(np.abs(along).max(axis=0), np.abs(across).max(axis=0))
    unit = np.where(size, size, 1)
    return along / unit, across / unit


class ForceMargins:
    """How far forces are from their limits: by the cuts of the wheels that slip across, and of the others."""

    slips: NDArray[np.int_]  # places of the wheels that slip across
    cuts: Floats
    still_cuts: Floats
    turns: NDArray[np.bool_]  # of the wheels that slip, those whose rims grip; the force of another is all across

    def heights(self, sines: Floats) -> Floats:
        """``sin phi`` up to the cut, (m, k)."""
        return np.where(self.turns, np.minimum(sines, self.cuts), self.cuts)

    def slowest(self, margins: Floats, cotangents: Floats, demand: RimDemand) -> int | None:
        """Of forces with margins (m,) and cotangents of phi (m, k) those of the slowest rims; None without a margin.

        On the straight side of a cut ellipse (rollers turn) the rim does not slip.
        """
        ample = min(margins.max(), AMPLE_MARGIN)
        if ample < LEAST_MARGIN:
            return None
        heights = 1 / np.sqrt(1 + cotangents**2)
        fastest = demand.fastest(self.slips, np.where(heights < self.cuts, cotangents, 0))
        return int(np.argmin(np.where(margins >= ample, fastest, np.inf)))

    def slipping_margin(self, heights: Floats) -> Floats:
        """Least distance of slipping wheels' forces from the ends of their half circles, and from corners, (m,)."""
        parts = heights / self.cuts
        to_corner = np.where(self.cuts < 1, np.abs(parts - 1), 1)
        return np.minimum(parts.min(axis=1, initial=1), to_corner.min(axis=1, initial=1))

    def sticking_margin(self, pairs: Floats) -> Floats:
        """Least distance of sticking wheels' forces (m, l, 2) from their limits, (m,)."""
        to_cut = np.where(self.still_cuts < 1, 1 - np.abs(pairs[..., 1]) / self.still_cuts, 1)
        return np.minimum((1 - np.linalg.norm(pairs, axis=-1)).min(axis=1, initial=1), to_cut.min(axis=1, initial=1))


class _AngleBalance(ForceMargins):
    """The sum of all forces for many starts at once: angles (m, k) of slipping wheels, sticking (m, 2l) of others."""

    def __init__(self, along: Floats, across: Floats, signs: NDArray[np.int_], cuts: Floats) -> None:
        slips, still = np.flatnonzero(signs), np.flatnonzero(signs == 0)
        self.slips, self.cuts, self.still_cuts = slips, cuts[slips], cuts[still]
        self.turns = np.asarray(along[slips].any(axis=1))
        self.first, self.second = along[slips], across[slips] * signs[slips, None]
        self.fixed = np.concatenate([along[still], across[still]])

    def starts(self, rng: np.random.Generator) -> tuple[Floats, Floats]:
        """Random angles, and random points of the discs."""
        still = len(self.fixed) // 2
        angles = np.where(self.turns, rng.uniform(0, np.pi, (STARTS, len(self.first))), np.pi / 2)
        turns, lengths = rng.uniform(0, 2 * np.pi, (STARTS, still)), np.sqrt(rng.uniform(0, 1, (STARTS, still)))
        across = self.still_cuts * lengths * np.sin(turns)
        return angles, np.concatenate([lengths * np.cos(turns), across], axis=1)

    def force(self, angles: Floats, sticking: Floats) -> Floats:
        """What is left of the balance, (m, 3)."""
        heights = self.heights(np.sin(angles))
        return np.asarray(np.cos(angles) @ self.first + heights @ self.second + sticking @ self.fixed)

    def stepped(self, angles: Floats, sticking: Floats) -> tuple[Floats, Floats]:
        """A Newton step of least norm, shortened where it is long."""
        rising = np.where(self.turns & (np.sin(angles) < self.cuts), np.cos(angles), 0)
        turning = rising[..., None] * self.second - np.sin(angles)[..., None] * self.first
        columns = np.concatenate([turning, np.broadcast_to(self.fixed, (len(angles), *self.fixed.shape))], axis=1)
        normal = np.einsum("ska,skb->sab", columns, columns) + REGULARIZATION * np.eye(3)
        multipliers = np.linalg.solve(normal, self.force(angles, sticking)[..., None])[..., 0]
        step = -np.einsum("ska,sa->sk", columns, multipliers)
        step *= np.minimum(1, LONGEST_STEP / np.maximum(np.abs(step).max(axis=1, keepdims=True), LONGEST_STEP))
        return angles + step[:, : len(self.first)], sticking + step[:, len(self.first) :]
