"""Second-order cones of a sum of norms: iterates inside them, and their Nesterov-Todd scaling.

Each norm owns a primal cone ``(t, r), |r| <= t`` and a dual cone ``(1, z), |z| <= 1``, r and z in the plane.
In a frame (t, along, across) turned towards the scaling direction, the scaling matrix is
``eta [[cosh, sinh, 0], [sinh, cosh, 0], [0, 0, 1]]``: it maps the dual vector, and its inverse the primal
vector, to one and the same "point".  With ``c2 = sqrt(cosh^2 + sinh^2)``, ``sh = sinh/c2`` and ``ch = cosh/c2``,
scaled vectors are written in the orthonormal basis ``a = (sh, ch, 0), b = (ch, -sh, 0), q = (0, 0, 1)``: the
dual's first entry is 1 for ever, so dual steps have no b.

The last axes of all arrays are (n, m): n norms of m problems.  Where primal and dual are treated alike they
share an array, with an axis "side": 0 for (t, r), 1 for (1, z).

References: Nesterov, Todd (1997), Math. Oper. Res. 22; Andersen, Roos, Terlaky (2003), Math. Program. 95.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats

TINY = 1e-300  # keeps 0/0 at 0


class Iterate(NamedTuple):
    """Strictly feasible iterates of m problems; the last axis of every array numbers them.

    Attributes:
        number: of each problem, shape (m,).
        weights: of the norms, shape (n, m).
        y: unknowns, shape (3, m).
        vectors: r and z, shape (2, side, n, m); ``r_i = w_i (E_i y - e_i)``.
        sizes: ``|r_i|`` and ``|z_i|``, shape (side, n, m).
        slacks: ``t_i - |r_i|`` and ``1 - |z_i|``, positive, shape (side, n, m); variables of their own.
    """

    number: NDArray[np.int_]
    weights: Floats
    y: Floats
    vectors: Floats
    sizes: Floats
    slacks: Floats

    def take(self, chosen: NDArray[np.bool_]) -> Iterate:
        """Only the chosen problems."""
        number, *others = self
        return Iterate(number[chosen], *(array[..., chosen] for array in others))

    @property
    def z(self) -> Floats:
        """Multipliers, shape (2, n, m)."""
        return self.vectors[:, 1]

    def gaps(self) -> Floats:
        """``t_i + r_i . z_i``, shape (n, m): the duality gap is their sum.

        Sums of positive terms: where ``r . z < 0``, ``|r||z| + r . z = (r x z)^2/(|r||z| - r . z)``.
        """
        r, z = self.vectors[:, 0], self.vectors[:, 1]
        inner = r[0] * z[0] + r[1] * z[1]
        turn = r[0] * z[1] - r[1] * z[0]
        reach = self.sizes[0] * self.sizes[1] + np.abs(inner)
        opening = np.where(inner < 0, np.square(turn) / (reach + TINY), reach)
        return np.asarray(self.slacks[0] + self.slacks[1] * self.sizes[0] + opening)


def residuals(weights: Floats, y: Floats, maps: Floats, targets: Floats) -> Floats:
    """``w_i (E_i y - e_i)``, shape (2, n, m), for targets (2, n, m) or (2, n, 1)."""
    return weights * (maps.transpose(1, 0, 2) @ y - targets)


def norm(vectors: Floats) -> Floats:
    """Length of vectors (2, ...)."""
    return np.asarray(np.sqrt(np.square(vectors[0]) + np.square(vectors[1])))


class Scaling(NamedTuple):
    """Nesterov-Todd scaling of every cone, in the notation of the module.

    Attributes:
        cos, sin: direction of the frame's "along".
        sh, ch: entries of the basis a and b.
        scale: what divides r and multiplies z for their entries a and q, shape (2, n, m).
        lift: the same for entry b of (t, r).
        tilt: ``1 - 2 sh ch``, which vanishes towards the boundary.
    """

    cos: Floats
    sin: Floats
    sh: Floats
    ch: Floats
    scale: Floats
    lift: Floats
    tilt: Floats

    def in_frame(self, vectors: Floats) -> Floats:
        """(along, across) of vectors (2, side, n, m)."""
        turned = np.empty_like(vectors)
        turned[0] = self.cos * vectors[0] + self.sin * vectors[1]
        turned[1] = self.cos * vectors[1] - self.sin * vectors[0]
        return turned


def nesterov_todd(state: Iterate, roots: Floats, gaps: Floats) -> Scaling:
    """The scaling at an iterate with given square roots of the determinants (side, n, m)."""
    unit = state.vectors / roots
    axis = unit[:, 0] - unit[:, 1]
    size = norm(axis)
    cos, sin = axis / (size + TINY)
    sinh = size / np.sqrt(2 + 2 * gaps / (roots[0] * roots[1]))
    cosh = np.sqrt(1 + np.square(sinh))
    c2 = np.sqrt(np.square(cosh) + np.square(sinh))
    eta = np.sqrt(roots[0] / roots[1])
    tilt = 1 / np.square(c2 * (cosh + sinh))
    return Scaling(cos + (size == 0), sin, sinh / c2, cosh / c2, np.array([eta * c2, eta]), eta / c2, tilt)
