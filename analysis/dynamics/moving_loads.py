"""Normal forces along a path: loads and their slope at one centre of mass, and where the loads end.

Loads are affine in c as long as the same wheels carry load, so an integrator needs one small table per set of loaded
wheels: that of the last point serves while its loads are >= 0 and the springs that it leaves out are free; where it
does not, :mod:`nonsmooth.analysis.minimizers.float_loads` finds the loaded set.  Trial states of an implicit step may
lie beyond the last place where loads exist: there the last table is continued, cut off at zero, and
:meth:`MovingLoads.margin` is negative, so that no such state is ever kept.

Loads are those of a body at rest with its centre of mass at c.  Acceleration shifts them as if it were elsewhere
(:class:`nonsmooth.analysis.dynamics.newton_euler.NewtonEuler`).
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.float_loads import affine_loads, hull_sides, loads_at

LIFTED = 1e-12  # share of the weight: a load above minus this one is not yet negative


class MovingLoads:
    """Loads of a model at one centre of mass after the other, total weight 1.

    Attributes:
        model: the contacts.
    """

    def __init__(self, model: ContactModel, start: Floats) -> None:
        """Prepare for a path.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where no loads exist at the start.
        """
        self.model = model
        self._table, self._valid = self._tables(start)
        self._sides = self._borders()

    def at(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and their slope with respect to the centre (n, 2); continued beyond the border."""
        if self.margin(centre) >= 0 and self.validities(centre[None])[0] < 0:
            with suppress(LoadError):  # of a centre over the line through two wheels, where the last table serves
                self._table, self._valid = self._tables(centre)
        loads = self._table @ np.array([1.0, *centre])
        return np.maximum(loads, 0.0), np.where(loads[:, None] > 0, self._table[:, 1:], 0.0)

    def continued(self, centre: Floats) -> tuple[Floats, Floats]:
        """Loads (n,) and slopes (n, 2) with the table of the last point, wherever it leads."""
        return self._table[:, 0] + self._table[:, 1:] @ centre, self._table[:, 1:]

    def validities(self, centres: Floats) -> Floats:
        """Negative where that table no longer holds, at centres (m, 2)."""
        return _least(self._valid, centres) + LIFTED

    def margins(self, centres: Floats) -> Floats:
        """How far the loads exist around centres (m, 2): distance to the support's border, or the least table load."""
        return _least(self._sides, centres)

    def margin(self, centre: Floats) -> float:
        """:meth:`margins` at one centre."""
        return float((self._sides @ np.array([1.0, *centre])).min())

    def _tables(self, centre: Floats) -> tuple[Floats, Floats]:
        """Affine forms of (1, c) around a point: of the loads (n, 3), and those that are >= 0 while they hold."""
        loaded = loads_at(self.model, centre[None])[0] > 0
        if self.model.load_table is not None:
            return self.model.load_table, np.array([[np.inf, 0.0, 0.0]])
        forms = affine_loads(self.model, np.flatnonzero(loaded))
        return np.where(loaded[:, None], forms, 0.0), np.where(loaded[:, None], forms, -forms)

    def _borders(self) -> Floats:
        """Affine forms (k, 3) of (1, c), all of them >= 0 where loads exist."""
        if self.model.load_table is not None:
            return self.model.load_table[self.model.load_table.any(axis=1)]
        return -hull_sides(self.model.positions)[:, [2, 0, 1]]


def _least(forms: Floats, centres: Floats) -> Floats:
    """The least of affine forms (k, 3) of (1, c) at centres (m, 2)."""
    return np.asarray((forms[:, :1] + forms[:, 1:] @ centres.T).min(axis=0))
