"""Newton's method on a sum of support functions of cut discs: the last steps of the interior point method.

As :mod:`nonsmooth.analysis.minimizers.newton_polish`, with four kinds of terms.  The force z of a wheel is ::

    inside    the wheel sticks, r = 0, and z is a multiplier
    side      the rollers turn and the rim does not slip: r_1 = 0, z_1 is a multiplier, z_2 = -+kappa
    arc       the rollers stand and the contact slips: z = -r/|r|
    corner    the rollers turn and the rim slips: z is a corner, and D is linear there

Which of them holds is read off the point ``z - c r``: the part of the border of the cut disc that is nearest to it
(c > 0; the fixed point of that projection is optimality).  As there, a wrong guess is harmless: a problem is accepted
only with multipliers that balance, keep inside the cut disc and leave no gap.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.newton_polish import (
    ACCEPTED_EXCESS,
    ACCEPTED_FLOOR,
    ACCEPTED_GAP,
    ACCEPTED_IMBALANCE,
    BALANCE_PASSES,
    STIFFNESS,
    Curvature,
    Norms,
)
from nonsmooth.analysis.minimizers.norm_scaling import TINY, norm
from nonsmooth.symbolic.friction_set import CutEllipse

NEWTON_STEPS = 10  # corners leave the Hessian singular until the right rims stop slipping
SETTLED = 1e-13  # relative to the unknowns: a step so small on unchanged parts is rounding, and no other is needed


class NearestBorder(NamedTuple):
    """Which part of the border is nearest to a point, shape (n, m) each; on none of them it is inside."""

    side: NDArray[np.bool_]
    arc: NDArray[np.bool_]
    corner: NDArray[np.bool_]

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Wheels that stick."""
        return ~(self.side | self.arc | self.corner)


def unit_sets(cuts: Floats) -> CutEllipse[Any]:
    """Discs of radius one that are cut."""
    return CutEllipse(1.0, 1.0, cuts)


def pieces(points: Floats, cuts: Floats) -> NearestBorder:
    """Where points (2, n, m) lie beside discs cut at cuts (n, 1): the normal cones of the border's parts."""
    x, y = np.abs(points)
    corner = unit_sets(cuts).corner
    side = (y > cuts) & (x < corner)
    beyond = (x >= corner) & (corner * y > cuts * x) & (y > cuts)
    arc = ~side & ~beyond & (norm(points) > 1)
    return NearestBorder(side, arc, beyond)


def polish_cut(
    weights: Floats,
    maps: Floats,
    targets: Floats,
    cuts: Floats,
    y: Floats,
    z: Floats,
    *,
    settled_floor: float = ACCEPTED_FLOOR,
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Finish ``min_y sum_i w_i h_i(E_i y - e_i)`` from an interior point; arguments as in ``polish``, cuts (n, 1).

    Where Newton's method settles, gaps up to ``settled_floor`` are accepted, relative to the value at y = 0.
    """
    norms, border = Norms(weights, maps, targets), np.array([unit_sets(cuts).corner, cuts])
    r = norms.residuals(y)
    stiffness = STIFFNESS * len(weights) / (norm(r).sum(axis=0) + TINY)
    part = pieces(z - stiffness * r, cuts)
    settled = np.zeros(weights.shape[1], bool)
    for _ in range(NEWTON_STEPS):
        force = _forces(part, r, z, border)
        fixed = np.where(part.inside, stiffness, np.where(part.side, stiffness, 0.0))
        scale = np.where(part.arc, 1 / (norm(r) + TINY), fixed)
        across = np.array([np.zeros_like(scale), np.where(part.side, 1.0, 0.0)])
        axis = np.where(part.arc, force, across)
        pushed = force - np.where(part.inside, stiffness * r, 0.0)
        pushed[0] -= np.where(part.side, stiffness * r[0], 0.0)
        curvature = Curvature(norms, scale, axis)
        step = curvature.solve(norms.imbalance(pushed))
        y = y + step
        r = norms.residuals(y)
        z = _forces(part, r, z, border)
        z = z - np.where(part.inside, stiffness * r, 0.0)
        z[0] -= np.where(part.side, stiffness * r[0], 0.0)
        before, part = part, pieces(z - stiffness * np.where(part.inside, 0.0, r), cuts)
        same = np.equal(before, part).all(axis=(0, 1))
        settled = same & (np.abs(step).max(axis=0) <= SETTLED * np.abs(y).max(axis=0))
        if settled.all():
            break
    z = _forces(part, r, z, border)
    for _ in range(BALANCE_PASSES):
        z = z - curvature.change(curvature.solve(norms.imbalance(z)))
    return y, z, _solved(norms, r, z, cuts, np.where(settled, settled_floor, ACCEPTED_FLOOR))


def _forces(part: NearestBorder, r: Floats, z: Floats, border: Floats) -> Floats:
    """The forces that the parts and the slips r give; where a multiplier is free, that of z.

    Args:
        part: where the forces lie on the border.
        r: slips, shape (2, n, m).
        z: multipliers, shape (2, n, m).
        border: the corner of each cut disc, shape (2, n, 1).
    """
    size = norm(r) + TINY
    bound = np.where(part.side, -np.sign(r[1]) * border[1], np.where(part.arc, -r[1] / size, z[1]))
    free = np.where(part.arc, -r[0] / size, z[0])
    return np.where(part.corner, -np.sign(r) * border, np.array([free, bound]))


def _solved(norms: Norms, r: Floats, z: Floats, cuts: Floats, floor: Floats) -> NDArray[np.bool_]:
    """Whether residuals and multipliers prove each other optimal, shape (m,), up to gaps ``floor`` of the start."""
    sizes = unit_sets(cuts).support(*r)
    gap = np.abs((sizes + r[0] * z[0] + r[1] * z[1]).sum(axis=0))
    small = gap <= ACCEPTED_GAP * sizes.sum(axis=0) + floor * norms.start
    small &= np.isfinite(gap)
    admissible = norm(z).max(axis=0) <= 1 + ACCEPTED_EXCESS
    admissible &= (np.abs(z[1]) <= cuts * (1 + ACCEPTED_EXCESS)).all(axis=0)
    balanced = np.abs(norms.imbalance(z)).max(axis=0) <= ACCEPTED_IMBALANCE * norms.weights.sum(axis=0)
    return np.asarray(small & admissible & balanced)
