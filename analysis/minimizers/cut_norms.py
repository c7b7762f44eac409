"""``min_y sum_i w_i h_i(E_i y - e_i)`` with the support functions of cut discs, for many problems at once.

The disc ``|z| <= 1`` cut by the strip ``|z_2| <= kappa`` has the support function ::

    h(x, y) = min over t of |(x, y - t)| + kappa |t|

so each term is two norms with an unknown t of its own (the speed of a roller), and the interior point method of
:mod:`nonsmooth.analysis.minimizers.sum_of_norms` solves it.  The columns of these unknowns touch two norms each and
are orthogonal to one another: they are taken out first, and Gram-Schmidt for the three common unknowns stays as it is.
The multiplier of the first norm is the force, of the second the share of the bearing's friction that is used.

Reference: Rockafellar (1970), *Convex Analysis*, theorem 16.4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.cut_polish import polish_cut
from nonsmooth.analysis.minimizers.norm_cones import Cones
from nonsmooth.analysis.minimizers.norm_scaling import TINY, Iterate, residuals
from nonsmooth.analysis.minimizers.sum_of_norms import LeastSquares, ProblemBatch, minimize_norms, solve_blocks


def minimize_cut_norms(weights: Floats, maps: Floats, targets: Floats, cuts: Floats) -> tuple[Floats, Floats]:
    """As :func:`nonsmooth.analysis.minimizers.sum_of_norms.minimize_norms`, with discs cut at kappa, shape (n,).

    Returns:
        Minimizers y, shape (m, 3), and multipliers z, shape (m, n, 2), with ``|z_i| <= 1``, ``|z_i2| <= kappa_i`` and
        ``sum_i w_i E_i^T z_i = 0``.
    """
    if (cuts == 1).all():
        return minimize_norms(weights, maps, targets)
    y, z = solve_blocks(lambda w, e: _CutBlock(w, maps, e, cuts), weights, targets)
    return y[:, :3], z[:, : len(cuts)]


class _CutBlock(ProblemBatch):
    """Problems with 2n norms: those of the contacts, then those of the bearings; unknowns y, then t of each wheel."""

    def __init__(self, weights: Floats, maps: Floats, targets: Floats, cuts: Floats) -> None:
        self.wheels, self.cuts = len(cuts), cuts
        both = np.concatenate([weights, weights * cuts], axis=1)
        zeros = np.zeros_like(targets)
        super().__init__(both, np.concatenate([maps, np.zeros_like(maps)]), np.concatenate([targets, zeros], axis=1))
        turning = np.zeros((self.wheels, len(weights)))
        self.y = np.concatenate([self.y, turning])
        self.state = self.state._replace(y=np.concatenate([self.state.y, turning]))

    def _fit(self, cones: Cones) -> _PrivateFit:
        return _PrivateFit(cones, cones.scaled_columns(self.maps))

    def _residuals(self, state: Iterate, y: Floats) -> Floats:
        r = residuals(state.weights, y[:3], self.maps, self._targets_of(state.number))
        r[1, : self.wheels] -= state.weights[: self.wheels] * y[3:]
        r[0, self.wheels :] = state.weights[self.wheels :] * y[3:]
        return r

    def _finish(self, weights: Floats, index: NDArray[np.int_]) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        n = self.wheels
        targets = self._targets_of(index)[:, :n]
        start = self.y[:3, index], self.z[:, :n, index]
        y, forces, accepted = polish_cut(weights[:n], self.maps[:n], targets, self.cuts[:, None], *start)
        z = np.concatenate([forces, np.zeros_like(forces)], axis=1)
        return np.concatenate([y, self.y[3:, index]]), z, accepted


class _PrivateFit:
    """Least squares for three common unknowns and one for each wheel, whose columns are taken out first.

    Args:
        cones: the scaled cones, contacts before bearings.
        columns: of the common unknowns, shape (3, 4n, m); changed in place.
    """

    def __init__(self, cones: Cones, columns: Floats) -> None:
        a, q = cones.state.weights / cones.scaling.scale
        cos, sin = cones.scaling.cos, cones.scaling.sin
        wheels = len(a) // 2
        contact, bearing = slice(wheels), slice(wheels, None)
        first = np.stack([-a[contact] * sin[contact], a[bearing] * cos[bearing]])
        second = np.stack([-q[contact] * cos[contact], -q[bearing] * sin[bearing]])
        self.own = np.stack([first, second])  # (a and q, contact and bearing, n, m)
        self.scale = 1 / (np.square(self.own).sum(axis=(0, 1)) + TINY)
        self.common = self._remove(columns) + self._remove(columns)
        self.rest = LeastSquares(columns)

    def _remove(self, vectors: Floats) -> Floats:
        """Subtract from vectors (..., 4n, m), in place, their projections on the private columns; the coefficients."""
        parts = vectors.reshape(*vectors.shape[:-2], *self.own.shape)
        coefficients = (parts * self.own).sum(axis=(-4, -3)) * self.scale
        parts -= coefficients[..., None, None, :, :] * self.own
        return np.asarray(coefficients)

    def split(self, vector: Floats) -> tuple[Floats, Floats]:
        """Coefficients on all columns, the three common ones first, and the remainder orthogonal to them."""
        vector = np.ascontiguousarray(vector)
        private = self._remove(vector)
        common, vector = self.rest.split(vector)
        private += self._remove(vector)
        return np.concatenate([common, private]), vector

    def solution(self, coefficients: Floats) -> Floats:
        """The unknowns, shape (3 + n, m)."""
        y = self.rest.solution(coefficients[:3])
        return np.concatenate([y, coefficients[3:] - np.einsum("jm,jnm->nm", y, self.common)])
