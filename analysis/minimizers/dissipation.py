"""The power dissipation functional of a wheel array (Murphey & Burdick, Definition 1), in its two readings.

With slips ``r_i`` along and ``s_i`` across the rim of wheel i, and normal forces ``N_i``:

- box: ``D(xi) = sum_i N_i (mu_R |r_i| + mu_S |s_i|)``, each direction limited on its own;
- ellipse: ``D(xi) = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``, the friction ellipse; where it is cut by a strip
  (rule ``roller``), the support function of :class:`nonsmooth.symbolic.mechanics.friction_set.FrictionSet`.

Both are convex in the twist.  Their subgradients are minus the friction forces ``f``, which lie in the box
``|f_R| <= mu_R N, |f_S| <= mu_S N`` or in the ellipse with these half-axes.  For balanced forces
(``sum_k f_k a_k = 0``) the power ``sum_k f_k b_k`` that the wheels put in is at most ``D(xi)`` for every twist:
equality makes the twist a minimizer and the forces its certificate.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.contact_rule import CellRule, LimitedForces, Rule
from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.symbolic.mechanics.friction_set import Box, CutEllipse
from nonsmooth.symbolic.numbers.plane_arrays import Floats

ROUNDING = 1e-14  # of D and of its gap, relative to the sum of the absolute terms they are made of


class Functional(StrEnum):
    """How the friction of one wheel is limited."""

    BOX = "box"
    ELLIPSE = "ellipse"

    def unit_sets(self, model: ContactRows) -> CutEllipse[Any]:
        """The friction sets of wheels in units of their half-axes: boxes, or the sets of the contacts."""
        return Box.units(np.ones_like(model.cuts)) if self is Functional.BOX else model.shape.units(model.cuts)


def functional_of(rule: Rule) -> Functional | None:
    """What the motion under a rule minimizes: that of boxes where it is constant in cells; None where nothing is."""
    if not isinstance(rule, LimitedForces):
        return None
    return Functional.BOX if isinstance(rule, CellRule) else Functional.ELLIPSE


def dissipation(functional: Functional, model: ContactRows, loads: ArrayLike, twists: ArrayLike) -> Floats:
    """``D`` for loads (..., n) and twists (..., 3), broadcast against each other; power."""
    weighted = np.moveaxis(model.limits(loads) * model.slips(twists), -1, 0)
    return np.asarray(functional.unit_sets(model).support(*weighted).sum(axis=-1))


def input_power(model: ContactRows, forces: ArrayLike) -> Floats:
    """``sum_k f_k b_k`` for forces (..., n, 2): the dual value of balanced forces; power."""
    flat = np.asarray(forces, float)
    flat = flat.reshape(*flat.shape[:-2], len(model.rows))
    return np.asarray((flat * model.targets).sum(axis=-1))


def usage(functional: Functional, model: ContactRows, loads: ArrayLike, forces: ArrayLike) -> Floats:
    """Share of its limit that each wheel's friction uses, shape (..., n); admissible iff at most 1.

    The gauge of the friction set.  A force without a limit (0/0) uses nothing, one beyond a zero limit infinity.
    """
    shares = np.moveaxis(share_of_limit(model, loads, forces), -1, 0)
    return np.asarray(functional.unit_sets(model).gauge(*shares))


def share_of_limit(model: ContactRows, loads: ArrayLike, forces: ArrayLike) -> Floats:
    """``(f_R/(mu_R N), f_S/(mu_S N))`` of each wheel, shape (..., n, 2); 0/0 is 0."""
    limits = model.limits(loads)
    forces = np.broadcast_to(np.asarray(forces, float), np.broadcast_shapes(np.shape(forces), limits.shape))
    unlimited = np.where(forces == 0, 0.0, np.copysign(np.inf, forces))
    return np.divide(forces, limits, out=unlimited, where=limits > 0)


def rounding_error(model: ContactRows, loads: Floats, twists: Floats) -> Floats:
    """Size of rounding errors in D and in its gap, for loads (..., n) and twists (..., 3)."""
    terms = np.abs(twists) @ np.abs(model.rows).T + np.abs(model.targets)
    paired = terms.reshape(*terms.shape[:-1], model.wheels, 2)
    return np.asarray(ROUNDING * (model.limits(loads) * paired).sum(axis=(-2, -1)))
