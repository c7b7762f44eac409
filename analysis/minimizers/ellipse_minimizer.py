"""The minimizer of the ellipse functional ``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``.

The ellipses may be cut by strips (rule ``roller``).  All points go at once to
:mod:`nonsmooth.analysis.minimizers.sum_of_norms` or ``cut_norms``, in coordinates in which the rows' columns
are orthonormal and speeds of order 1, so that neither units nor the place of the origin matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats
from nonsmooth.analysis.minimizers.cut_norms import minimize_cut_norms
from nonsmooth.analysis.minimizers.cut_polish import polish_cut
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.optimal_face import row_frame

# Relative to the value at rest: the gap that rounding makes of the slips of wheels that stick.  A result with such a
# gap is verified by its forces before it is taken.
SLIP_ROUNDING = np.finfo(np.float64).eps


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
        scaled = _Scaled(model)
        unknowns, shares = minimize_cut_norms(normal, scaled.maps, scaled.targets, model.cuts)
        return scaled.certified(normal, unknowns, shares)


class _Scaled:
    """The problem in coordinates in which columns are orthonormal and speeds of order 1."""

    def __init__(self, model: ContactRows) -> None:
        self.model = model
        rows, self.to_twists = row_frame(model.rows)
        grip = model.friction / (float(model.friction.max()) or 1.0)
        self.speeds = np.abs(grip * model.targets).max(axis=-1, keepdims=True)
        self.speeds[self.speeds == 0] = 1.0
        self.maps = (grip[:, None] * rows).reshape(-1, 2, 3)
        targets = grip * model.targets / self.speeds
        self.targets = targets.reshape(*targets.shape[:-1], -1, 2)

    def certified(self, loads: Floats, unknowns: Floats, shares: Floats) -> Minima:
        """Twists and forces in the model's own units."""
        twists = self.speeds * (unknowns @ self.to_twists.T)
        return Minima.certified(Functional.ELLIPSE, self.model, loads, twists, shares * self.model.limits(loads))


class WarmInterior:
    """One minimizer after the other along a path: Newton steps from the last one, else the interior point method.

    Ten times as fast as :class:`EllipseInterior` for single points, with the same proof.
    """

    def __init__(self, model: ContactRows) -> None:
        self._scaled = _Scaled(model)
        self._last: tuple[Floats, Floats] | None = None

    def minimize(self, loads: Floats) -> Minima:
        """At loads (n,)."""
        scaled, cuts = self._scaled, self._scaled.model.cuts
        found = None if self._last is None else self._polished(loads, *self._last)
        if found is not None:
            minima = scaled.certified(loads[None], found[0][None], found[1][None])
            if minima.check()[0]:
                self._last = found
                return minima
        y, z = minimize_cut_norms(loads[None], scaled.maps, scaled.targets, cuts)
        self._last = y[0], z[0]
        return scaled.certified(loads[None], y, z)

    def _polished(self, loads: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats] | None:
        scaled = self._scaled
        targets, start = scaled.targets.T[..., None], (y[:, None], z.T[..., None])
        cuts = scaled.model.cuts[:, None]
        with np.errstate(all="ignore"):  # a step out of the range of floats is not accepted
            y, z, accepted = polish_cut(loads[:, None], scaled.maps, targets, cuts, *start, settled_floor=SLIP_ROUNDING)
        return (y[:, 0], z[..., 0].T) if accepted[0] else None
