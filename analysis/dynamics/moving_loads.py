"""Normal forces along a path: loads and their slope at one centre of mass, and where the loads end.

Loads are affine in c as long as the same wheels carry load, so an integrator needs one small table per set of loaded
wheels: the table of the last point is tried first (its loads must be >= 0, and the wheels it leaves out must be free),
then those met before; only where none fits does :mod:`nonsmooth.analysis.minimizers.float_loads` find the loaded set.
Trial states of an implicit step may lie beyond the last place where loads exist: there the last table is continued,
cut off at zero, and :meth:`MovingLoads.margin` is negative, so that no such state is ever kept.

Loads are those of a body in balance: acceleration does not shift them.  That is exact for friction that acts at the
height of the centre of mass.  A centre at height h shifts loads by up to ``mu h/L`` of the weight while the body
accelerates (L the size of the array), and not at all in steady motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.float_loads import loads_at

LIFTED = 1e-12  # share of the weight: a load above minus this one is not yet negative
DEPENDENT = 1e-12  # relative eigenvalue below which loaded wheels lie on one line (a centre on the border)


@dataclass(frozen=True, eq=False)
class _Piece:
    """One set of loaded wheels.

    Attributes:
        springs: compression of every spring as an affine form of (1, c), shape (n, 3), stiffness one.
        loaded: which wheels carry load, shape (n,).
    """

    springs: Floats
    loaded: NDArray[np.bool_]

    def holds(self, point: Floats) -> bool:
        """Whether at (1, c) the loaded springs are pressed and the others free."""
        pressed = self.springs @ point
        return bool((np.where(self.loaded, pressed, -pressed) >= -LIFTED).all())


class MovingLoads:
    """Loads of a model at one centre of mass after the other, total weight 1."""

    def __init__(self, model: ContactModel, start: Floats) -> None:
        """Prepare for a path.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where no loads exist at the start.
        """
        self.model = model
        first = loads_at(model, start[None])[0]
        self._sides = self._borders()
        self._pieces = [self._piece(first > 0)]

    def at(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and their slope with respect to the centre (n, 2); continued beyond the border."""
        piece = self._fitting(centre) if self.margin(centre) >= 0 else self._pieces[-1]
        loads = piece.springs @ np.array([1.0, *centre])
        carried = piece.loaded & (loads > 0)
        return np.where(carried, loads, 0.0), np.where(carried[:, None], piece.springs[:, 1:], 0.0)

    def continued(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and slopes (n, 2) with the table of the last point, wherever it leads."""
        piece = self._pieces[-1]
        loads = piece.springs[:, 0] + piece.springs[:, 1:] @ centre
        return np.where(piece.loaded, loads, 0.0), np.where(piece.loaded[:, None], piece.springs[:, 1:], 0.0)

    def validities(self, centres: Floats) -> Floats:
        """Negative where that table no longer holds, at centres (m, 2)."""
        if self.model.load_table is not None:
            return np.full(len(centres), np.inf)
        piece = self._pieces[-1]
        pressed = piece.springs[:, :1] + piece.springs[:, 1:] @ centres.T
        return np.asarray(np.where(piece.loaded[:, None], pressed, -pressed).min(axis=0)) + LIFTED

    def margin(self, centre: Floats) -> float:
        """How far the loads exist around a point: distance to the support's border, or the table's smallest load."""
        return float((self._sides @ np.array([1.0, *centre])).min())

    def margins(self, centres: Floats) -> Floats:
        """:meth:`margin` at centres (m, 2)."""
        return np.asarray((self._sides[:, :1] + self._sides[:, 1:] @ centres.T).min(axis=0))

    def _borders(self) -> Floats:
        """Affine forms (k, 3) of (1, c), all of them >= 0 where loads exist."""
        if self.model.load_table is not None:
            used = np.abs(self.model.load_table).max(axis=1) > 0
            return self.model.load_table[used]
        from scipy.spatial import ConvexHull

        sides = ConvexHull(self.model.positions).equations
        return -np.asarray(sides[:, [2, 0, 1]])

    def _fitting(self, centre: Floats) -> _Piece:
        """A piece that holds at a centre; it becomes the last one."""
        point = np.array([1.0, *centre])
        for k in reversed(range(len(self._pieces))):
            if self._pieces[k].holds(point):
                self._pieces.append(self._pieces.pop(k))
                return self._pieces[-1]
        self._pieces.append(self._piece(loads_at(self.model, centre[None])[0] > 0))
        return self._pieces[-1]

    def _piece(self, loaded: NDArray[np.bool_]) -> _Piece:
        """The given table, or springs ``m_i . (sum over loaded wheels of m_j m_j^T)^+ (1, c)``, ``m_i = (1, p_i)``."""
        if self.model.load_table is not None:
            return _Piece(self.model.load_table, np.ones(self.model.wheels, dtype=bool))
        middle = self.model.positions.mean(axis=0)
        size = float(np.hypot(*(self.model.positions - middle).T).max())
        to_middle = np.array([[1.0, 0.0, 0.0], [-middle[0] / size, 1 / size, 0.0], [-middle[1] / size, 0.0, 1 / size]])
        moments = np.column_stack([np.ones(self.model.wheels), (self.model.positions - middle) / size])
        inverse = np.linalg.pinv(moments[loaded].T @ moments[loaded], rcond=DEPENDENT, hermitian=True)
        return _Piece(moments @ inverse @ to_middle, loaded)
