"""Newton's method on a sum of norms whose vanishing terms are known: the last steps of the interior point method.

An interior point knows D to its gap g, but the minimizer only to the square root of g.  It does tell which norms
vanish (wheels that stick, |z| < 1) and which do not (wheels that slip, |z| = 1).  With that, ``sum |r_i|`` over
the slipping wheels is smooth and the sticking ones are equations ``r_i = 0`` with multipliers ``z_i``: a few
Newton steps (equations by an augmented Lagrangian) find minimizer and multipliers to rounding.  The guess is mended on
the way: a slip that turns round sticks, a force that exceeds its limit slips.  A wrong guess is harmless: a problem is
accepted only with multipliers that balance, keep ``|z_i| <= 1`` and leave no gap.

The 3 x 3 systems are solved in closed form for all problems at once; arrays have the shape (n, m) as in
:mod:`nonsmooth.analysis.minimizers.norm_scaling`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.norm_scaling import TINY, norm, residuals

NEWTON_STEPS = 6  # two or three to correct the guess, three from a relative error of 1e-2 to rounding
BALANCE_PASSES = 2  # the second one removes the rounding of the first
STIFFNESS = 1e4  # weight of a sticking wheel's equations, in units of a slipping wheel's curvature
SHIFT = 1e-13  # multiple of the identity, relative to the trace: keeps a singular Hessian (a face) solvable
ACCEPTED_GAP = 1e-13  # relative to the value: rounding of the sum
ACCEPTED_FLOOR = 2e-18  # relative to the value at y = 0: below lies the rounding of the slips themselves
ACCEPTED_EXCESS = 1e-15  # of |z| over 1: rounding of a unit vector
ACCEPTED_IMBALANCE = 4e-15  # relative to the sum of the weights: rounding of the sum
_ROW, _COLUMN = np.triu_indices(3)


def polish(
    weights: Floats, maps: Floats, targets: Floats, y: Floats, z: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Finish ``min_y sum_i w_i |E_i y - e_i|`` from an interior point.

    Args:
        weights: ``w``, shape (n, m).
        maps: ``E_i``, shape (n, 2, 3).
        targets: ``e_i``, shape (2, n, m), or (2, n, 1) for all problems alike.
        y: unknowns, shape (3, m).
        z: multipliers, shape (2, n, m).

    Returns:
        Unknowns, multipliers, and whether a problem's result is accepted, shape (m,).
    """
    norms = Norms(weights, maps, targets)
    r = norms.residuals(y)
    stuck = _sticking(weights, norm(r), z)
    stiffness = STIFFNESS * len(weights) / norm(r).sum(axis=0)
    for _ in range(NEWTON_STEPS):
        scale = np.where(stuck, stiffness, 1 / (norm(r) + TINY))
        multipliers = np.where(stuck, z, 0.0) - r * scale
        curvature = Curvature(norms, scale, np.where(stuck, 0.0, multipliers))
        y = y + curvature.solve(norms.imbalance(multipliers))
        before, r = r, norms.residuals(y)
        z = np.where(stuck, z - stiffness * r, z)
        turned = before[0] * r[0] + before[1] * r[1] < 0
        stuck = np.where(stuck, norm(z) < 1, turned)
    z = np.where(stuck, z, -r / (norm(r) + TINY))
    for _ in range(BALANCE_PASSES):
        z = z - curvature.change(curvature.solve(norms.imbalance(z)))
    return y, z, norms.solved(r, z)


class Norms:
    """The problems: weights (n, m), maps (n, 2, 3), targets (2, n, m) or (2, n, 1); products of rows (6, 3n)."""

    def __init__(self, weights: Floats, maps: Floats, targets: Floats) -> None:
        self.weights, self.maps, self.targets = weights, maps, targets
        self.columns = maps.transpose(2, 1, 0).reshape(3, -1)
        self.start = (weights * norm(targets)).sum(axis=0)
        first, second = maps[:, 0], maps[:, 1]
        both = _products(first, second)
        self.products = np.concatenate([_products(first, first), _products(second, second), -2 * both]).T

    def residuals(self, y: Floats) -> Floats:
        """``w_i (E_i y - e_i)``, shape (2, n, m)."""
        return residuals(self.weights, y, self.maps, self.targets)

    def imbalance(self, z: Floats) -> Floats:
        """``sum_i w_i E_i^T z_i``, shape (3, m)."""
        return np.asarray(self.columns @ (self.weights * z).reshape(-1, z.shape[-1]))

    def solved(self, r: Floats, z: Floats) -> NDArray[np.bool_]:
        """Whether residuals and multipliers prove each other optimal, shape (m,)."""
        gap = np.abs((norm(r) + r[0] * z[0] + r[1] * z[1]).sum(axis=0))
        small = gap <= ACCEPTED_GAP * norm(r).sum(axis=0) + ACCEPTED_FLOOR * self.start
        small &= np.isfinite(gap)  # a step out of the range of floats: infinity is no larger than infinity
        admissible = norm(z).max(axis=0) <= 1 + ACCEPTED_EXCESS
        balanced = np.abs(self.imbalance(z)).max(axis=0) <= ACCEPTED_IMBALANCE * self.weights.sum(axis=0)
        return np.asarray(small & admissible & balanced)


class Curvature:
    """Second derivatives ``sum_i w_i^2 E_i^T S_i E_i`` with ``S_i = scale_i (1 - axis_i axis_i^T)``."""

    def __init__(self, norms: Norms, scale: Floats, axis: Floats) -> None:
        self.norms, self.scale, self.axis = norms, scale, axis
        bend = np.square(norms.weights) * scale
        squares = [bend * (1 - np.square(axis[0])), bend * (1 - np.square(axis[1])), bend * axis[0] * axis[1]]
        self.matrix = norms.products @ np.concatenate(squares)

    def change(self, dy: Floats) -> Floats:
        """``S_i w_i E_i dy``: fall of the multipliers along a step, shape (2, n, m)."""
        r = self.norms.weights * (self.norms.maps.transpose(1, 0, 2) @ dy)
        along = self.axis[0] * r[0] + self.axis[1] * r[1]
        return np.asarray(self.scale * (r - self.axis * along))

    def solve(self, right: Floats) -> Floats:
        """Solve the m systems for right sides (3, m) by LDL^T in closed form."""
        xx, xy, xz, yy, yz, zz = self.matrix
        shift = SHIFT * (xx + yy + zz) + TINY
        d0 = xx + shift
        l10, l20 = xy / d0, xz / d0
        d1 = yy + shift - l10 * xy
        rest = yz - l10 * xz
        l21 = rest / d1
        d2 = zz + shift - l20 * xz - l21 * rest
        x0, x1, x2 = right
        x1 = x1 - l10 * x0
        x2 = (x2 - l20 * x0 - l21 * x1) / d2
        x1 = x1 / d1 - l21 * x2
        return np.array([x0 / d0 - l10 * x1 - l20 * x2, x1, x2])


def _sticking(weights: Floats, sizes: Floats, z: Floats) -> NDArray[np.bool_]:
    """Which norms vanish at the optimum: slip below its multiplier's (squared) distance from the limit."""
    slips = np.divide(sizes, weights, out=np.zeros_like(sizes), where=weights > 0)
    return np.asarray(slips < slips.max(axis=0) * np.square(1 - norm(z)))


def _products(first: Floats, second: Floats) -> Floats:
    """Upper triangles of the symmetric parts of ``first_i second_i^T``, shape (n, 6)."""
    outer = np.einsum("ni,nj->nij", first, second)
    return np.asarray(((outer + outer.transpose(0, 2, 1)) / 2)[:, _ROW, _COLUMN])
