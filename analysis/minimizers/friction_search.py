"""Friction forces under rule ``ellipse`` that hold a given motion, in floats: which speeds make it the minimizer.

A wheel that slips across, with sign s, carries any force ``(cos phi, s sin phi)`` on that half of its friction ellipse
(in units of its axes): the speed along the rim sets phi in (0, pi).  A wheel that does not slip carries any force
inside.  Where the ellipse is cut (rule ``roller``), ``sin phi`` stops at the cut: there rollers turn, and the rim does
not slip.  With columns ``N mu_R [d; d . J p]`` and ``N mu_S [n; n . J p]`` the forces must add up to zero: three
equations, many unknowns, curved.  Newton steps of least norm from many random starts at once find points of that
set.  Of those that keep a margin to all limits the one is taken whose fastest rim is slowest: a force almost along the
rim asks the rim to spin many times as fast as its wheel slips across.  The search may fail where the margins are small.

The unknowns are phi and the forces inside themselves (:class:`_Angles`).  The random forces of many wheels all add up
to nearly the same, far from zero, and such steps would leave the half circles.  So of many wheels they are z with
``cos phi = tanh z``, ``sin phi = sech z``, and q in the plane with the force ``q / sqrt(1 + |q|^2)``: no step leaves
the half circle or the disc (:class:`_Plane`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, max_norms

STARTS = 256
STEPS = 15
LONGEST_STEP = 0.5  # of an unknown: radian, or parts of an axis
BALANCED = 1e-9  # residual, relative to the largest entries of columns: Newton ends at 1e-15 or does not converge
LEAST_MARGIN = 0.01  # parts of an axis: with less a wheel would have to spin a hundred times as fast as it slips
AMPLE_MARGIN = 0.15  # parts of an axis: of forces with as much, or with the most there is, slow rims are preferred
REGULARIZATION = 1e-12  # of the normal matrix, in units of the largest column, where columns do not span
SEED = 0

# Of many wheels.
MANY = 34  # wheels; of so many or fewer the search in angles finds forces
FEWEST_STARTS = 16
UNKNOWNS = 8_192  # of all starts together: of many wheels most starts lead to forces with a margin
FARTHEST_START = 2.0  # of z: there a wheel spins four times as fast as it slips


@dataclass(frozen=True, eq=False)
class RimDemand:
    """At which speeds the rims of wheels turn their forces: ``u = rolling - turning cot(phi)``.

    Attributes:
        rolling: ``a . xi``, the speed at which the rim does not slip along, (n,).
        turning: ``|b . xi|`` times the axes of the friction set across over along, (n,).
    """

    rolling: Floats
    turning: Floats

    def fastest(self, slips: Indices, cotangents: Floats) -> Floats:
        """The speed of the fastest rim, (m,), by the cotangents of phi (m, k) of the wheels that slip across."""
        speeds = np.tile(self.rolling, (len(cotangents), 1))
        speeds[:, slips] -= self.turning[slips] * cotangents
        return max_norms(speeds)


class FrictionForces(NamedTuple):
    """Forces in units of the axes of each wheel's ellipse.

    Attributes:
        angles: phi of each wheel that slips across, in (0, pi).
        sticking: (along, across) of each wheel that does not.
    """

    angles: Floats
    sticking: Floats


def search_forces(
    along: Floats, across: Floats, signs: Indices, cuts: Floats, demand: RimDemand
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
    balance = (_Angles if len(signs) <= MANY else _Plane)(along, across, signs, cuts)
    unknowns = balance.starts(np.random.default_rng(SEED))
    for _ in range(STEPS):
        unknowns = balance.stepped(unknowns)
    forces = balance.forces(unknowns)
    balanced = max_norms(balance.total(forces)) < BALANCED
    margin = np.minimum(balance.slipping_margin(forces.sines), balance.sticking_margin(forces.sticking))
    inside = balanced & ((forces.angles > 0) & (forces.angles < np.pi)).all(axis=1)
    best = balance.slowest(np.where(inside, margin, -1), forces, demand)
    return None if best is None else FrictionForces(forces.angles[best], forces.sticking[best])


def in_common_units(along: Floats, across: Floats) -> tuple[Floats, Floats]:
    """The columns of forces, divided by the largest entry of each kind: moments have another unit than forces."""
    size = np.maximum(np.abs(along).max(axis=0), np.abs(across).max(axis=0))
    unit = np.where(size, size, 1)
    return along / unit, across / unit


class _Forces(NamedTuple):
    """Of m starts: phi (m, k) of the wheels that slip across, its cosine and sine, and the other forces (m, l, 2)."""

    angles: Floats
    cosines: Floats
    sines: Floats
    sticking: Floats


class _Balance(ABC):
    """The sum of all forces for many starts at once; unknowns are (m, k + 2l), those of wheels that slip first."""

    def __init__(self, along: Floats, across: Floats, signs: Indices, cuts: Floats) -> None:
        slips, still = np.flatnonzero(signs), np.flatnonzero(signs == 0)
        self.slips, self.cuts, self.still_cuts = slips, cuts[slips], cuts[still]
        self.turns = np.asarray(along[slips].any(axis=1))  # whose rims grip; the force of another is all across
        self.first, self.second = along[slips], across[slips] * signs[slips, None]
        self.fixed = np.stack([along[still], across[still]], axis=1)

    @abstractmethod
    def starts(self, rng: np.random.Generator) -> Floats:
        """Random unknowns."""

    @abstractmethod
    def forces(self, unknowns: Floats) -> _Forces:
        """What they mean."""

    @abstractmethod
    def slopes(self, unknowns: Floats, forces: _Forces) -> Floats:
        """The derivative of the total by each unknown, (m, k + 2l, 3)."""

    def total(self, forces: _Forces) -> Floats:
        """What is left of the balance, (m, 3)."""
        slipping = forces.cosines @ self.first + self._heights(forces.sines) @ self.second
        return slipping + forces.sticking.reshape(len(slipping), -1) @ self.fixed.reshape(-1, 3)

    def stepped(self, unknowns: Floats) -> Floats:
        """A Newton step of least norm, shortened where it is long."""
        forces = self.forces(unknowns)
        columns = self.slopes(unknowns, forces)
        normal = columns.transpose(0, 2, 1) @ columns + REGULARIZATION * np.eye(3)
        step = -(columns @ np.linalg.solve(normal, self.total(forces)[..., None]))[..., 0]
        step *= np.minimum(1, LONGEST_STEP / np.maximum(np.abs(step).max(axis=1, keepdims=True), LONGEST_STEP))
        return unknowns + step

    def slowest(self, margins: Floats, forces: _Forces, demand: RimDemand) -> int | None:
        """Of forces with margins (m,) those of the slowest rims; None without a margin.

        On the straight side of a cut ellipse (rollers turn) the rim does not slip.
        """
        ample = min(margins.max(), AMPLE_MARGIN)
        if ample < LEAST_MARGIN:
            return None
        cotangents = np.where(forces.sines < self.cuts, forces.cosines / forces.sines, 0)
        fastest = demand.fastest(self.slips, cotangents)
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

    def _heights(self, sines: Floats) -> Floats:
        """``sin phi`` up to the cut, (m, k)."""
        return np.where(self.turns, np.minimum(sines, self.cuts), self.cuts)

    def _turning(self, forces: _Forces) -> Floats:
        """The derivative of the total by each phi, (m, k, 3)."""
        rising = np.where(self.turns & (forces.sines < self.cuts), forces.cosines, 0)
        return rising[..., None] * self.second - forces.sines[..., None] * self.first

    def _drawn(self, rng: np.random.Generator, count: int) -> tuple[Floats, Floats, Floats]:
        """Random angles (m, k), and random points of discs by their angles and lengths, (m, l)."""
        shape = (count, len(self.fixed))
        angles = rng.uniform(0, np.pi, (count, len(self.first)))
        turns = rng.uniform(0, 2 * np.pi, shape)
        return angles, turns, np.sqrt(rng.uniform(0, 1, shape))

    def _split(self, unknowns: Floats) -> tuple[Floats, Floats]:
        """Those of wheels that slip (m, k), and of the others (m, l, 2)."""
        slipping, others = np.split(unknowns, [len(self.first)], axis=1)
        return slipping, others.reshape(len(unknowns), -1, 2)


class _Angles(_Balance):
    """By phi, and the forces inside."""

    def starts(self, rng: np.random.Generator) -> Floats:
        angles, turns, lengths = self._drawn(rng, STARTS)
        sticking = np.stack([lengths * np.cos(turns), self.still_cuts * lengths * np.sin(turns)], axis=-1)
        return np.concatenate([np.where(self.turns, angles, np.pi / 2), sticking.reshape(STARTS, -1)], axis=1)

    def forces(self, unknowns: Floats) -> _Forces:
        angles, sticking = self._split(unknowns)
        return _Forces(angles, np.cos(angles), np.sin(angles), sticking)

    def slopes(self, unknowns: Floats, forces: _Forces) -> Floats:
        fixed = self.fixed.reshape(-1, 3)
        return np.concatenate([self._turning(forces), np.broadcast_to(fixed, (len(unknowns), *fixed.shape))], axis=1)


class _Plane(_Balance):
    """By z and q."""

    def starts(self, rng: np.random.Generator) -> Floats:
        count = int(np.clip(UNKNOWNS // (len(self.first) + 2 * len(self.fixed)), FEWEST_STARTS, STARTS))
        angles, turns, lengths = self._drawn(rng, count)
        z = np.where(self.turns, np.arctanh(np.cos(angles)), 0).clip(-FARTHEST_START, FARTHEST_START)
        q = np.stack([lengths * np.cos(turns), lengths * np.sin(turns)], axis=-1) / np.sqrt(1 - lengths**2)[..., None]
        return np.concatenate([z, q.reshape(count, -1)], axis=1)

    def forces(self, unknowns: Floats) -> _Forces:
        z, q = self._split(unknowns)
        sticking = q / np.sqrt(1 + (q**2).sum(axis=-1, keepdims=True))
        return _Forces(2 * np.arctan(np.exp(-z)), np.tanh(z), 1 / np.cosh(z), sticking)

    def slopes(self, unknowns: Floats, forces: _Forces) -> Floats:
        _, q = self._split(unknowns)
        turning = -forces.sines[..., None] * self._turning(forces)  # d phi = -sin phi dz
        size = np.sqrt(1 + (q**2).sum(axis=-1))[..., None, None]
        discs = (np.eye(2) - forces.sticking[..., :, None] * forces.sticking[..., None, :]) / size
        return np.concatenate([turning, (discs @ self.fixed).reshape(len(q), -1, 3)], axis=1)
