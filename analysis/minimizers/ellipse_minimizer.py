"""The minimizer of the ellipse functional ``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``.

The ellipses may be cut by strips (rule ``roller``).  All points go at once to
:mod:`nonsmooth.analysis.minimizers.sum_of_norms` or ``cut_norms``, in coordinates in which the rows' columns
are orthonormal and speeds of order 1, so that neither units nor the place of the origin matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.cut_norms import minimize_cut_norms
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.optimal_face import row_frame


@dataclass(frozen=True)
class EllipseInterior:
    """Interior point and Newton steps, vectorized over the points; twist, forces and gap to rounding.

    A thousand points of four wheels take about ten milliseconds; a single point one.
    """

    @property
    def functional(self) -> Functional:
        """The ellipse."""
        return Functional.ELLIPSE

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.choice.Minimizer`."""
        normal = model.checked_loads(loads)
        rows, to_twists = row_frame(model.rows)
        grip = model.friction / (float(model.friction.max()) or 1.0)
        speeds = np.abs(grip * model.targets).max(axis=-1, keepdims=True)
        speeds[speeds == 0] = 1.0
        maps = (grip[:, None] * rows).reshape(-1, 2, 3)
        targets = grip * model.targets / speeds
        targets = targets.reshape(*targets.shape[:-1], -1, 2)
        unknowns, shares = minimize_cut_norms(normal, maps, targets, model.cuts)
        twists = speeds * (unknowns @ to_twists.T)
        return Minima.certified(self.functional, model, normal, twists, shares * model.limits(normal))
