"""The minimizer of a sum of norms where no contact sticks, one after the other along a path: plain Newton steps.

``D(xi) = sum_i N_i |w_i|``, ``w_i = (mu_R r_i, mu_S s_i)``, has the gradient ``sum_i N_i W_i^T e_i`` with
``e_i = w_i/|w_i|``, and the Hessian ``sum_i N_i/|w_i| W_i^T (1 - e_i e_i^T) W_i``.  D is convex: where the gradient
vanishes and the Hessian is positive definite, the twist is the only minimizer, and the friction forces are
``-N_i (mu_R e_i1, mu_S e_i2)``, on the border of their ellipses.  So nothing else has to be proved.  Where a contact
nearly sticks or the steps do not settle, another method is needed
(:class:`nonsmooth.analysis.minimizers.ellipse_minimizer.WarmInterior`).
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats

STEPS = 12  # a start beside the last minimum needs three or four
STUCK = 1e-4  # of the fastest wheel's speed: slips below are left to the other method
SETTLED = 1e-13  # change of a slip, of the fastest wheel's speed, after which one more step ends it
SINGULAR = 1e-10  # ratio of the extreme eigenvalues of the Hessian, columns scaled, below which it may be singular


class SmoothNewton:
    """Minimizers of one set of contacts at loads near each other."""

    def __init__(self, model: ContactModel) -> None:
        """For a model whose friction sets are whole ellipses.

        Raises:
            ValueError: where a strip cuts one.
        """
        if (model.cuts < 1).any():
            raise ValueError("required whole friction ellipses")
        weights = model.friction.reshape(-1, 2, 1)
        self._maps = weights * model.rows.reshape(-1, 2, 3)
        self._targets = (model.friction * model.targets).reshape(-1, 2)
        self._speed = float(np.abs(self._targets).max()) or 1.0
        self._scale = np.abs(self._maps).max(axis=(0, 1))  # of the columns: v and omega have different units
        self._last: Floats | None = None

    def start_from(self, twist: Floats) -> None:
        """Begin at a twist that another method found."""
        self._last = twist

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not proved to be the minimizer."""
        if self._last is None:
            return None
        twist, settled = self._last, False
        for _ in range(STEPS):
            slips = self._maps @ twist - self._targets
            lengths = np.hypot(slips[:, 0], slips[:, 1])
            if lengths[loads > 0].min() < STUCK * self._speed:
                return None
            lengths = np.where(loads > 0, lengths, 1.0)
            units = slips / lengths[:, None]
            gradient, hessian = self._derivatives(loads, lengths, units)
            try:
                step = np.linalg.solve(hessian, gradient)
            except np.linalg.LinAlgError:
                return None
            twist = twist - step
            if settled:
                self._last = twist if self._is_regular(hessian) else None
                return self._last
            settled = bool(np.abs(self._maps @ step).max() <= SETTLED * self._speed)
        return None

    def _derivatives(self, loads: Floats, lengths: Floats, units: Floats) -> tuple[Floats, Floats]:
        """Gradient (3,) and Hessian (3, 3)."""
        gradient = np.einsum("n,nij,ni->j", loads, self._maps, units)
        across = self._maps[:, 0] * -units[:, 1:] + self._maps[:, 1] * units[:, :1]
        return gradient, (across * (loads / lengths)[:, None]).T @ across

    def _is_regular(self, hessian: Floats) -> bool:
        eigenvalues = np.linalg.eigvalsh(hessian / np.outer(self._scale, self._scale))
        return bool(eigenvalues[0] > SINGULAR * eigenvalues[-1])
