"""Pose rates on given sets of wheels at given centres of mass, many at once, in floats.

Under a rule without cells ``(c', theta')`` depends on c and on the wheels that carry, whatever the heading is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.bodies.many_contacts import Mask, Numbers, RowsOfWheels, loads_of, widest_gaps
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.many_twists import Contacts, ManyTwists


@dataclass(frozen=True)
class SetMotions:
    """Motions of m bodies.

    Attributes:
        rates: ``(c', size theta')``, shape (m, 3).
        loads: of all wheels (m, n), total weight 1.
        known: where the body stands and the motion was found, (m,).
    """

    rates: Floats
    loads: Floats
    known: Mask


class LeastTwists:
    """The motions of least dissipation of many bodies, each on wheels of its own."""

    def __init__(self, model: ContactModel, size: float) -> None:
        """With a length that stands for the body's size.

        Raises:
            ValueError: for friction sets of another shape than ellipses, cut or whole.
        """
        model.require_ellipses()
        self._model, self._rows, self._cuts, self._size = model, RowsOfWheels(model), model.cuts, size
        speed = float(np.abs(model.friction * model.targets).max())
        self._twists = ManyTwists(speed, rollers=bool((model.cuts < 1).any()))

    def of(self, wheels: Numbers, carrying: Mask, levers: Floats, start: Floats) -> SetMotions:
        """The motions on some of the wheels (m, k), at ``p_i - c`` of shape (m, k, 2), with the loads of these wheels.

        Args:
            wheels: their numbers.
            carrying: which of them carry.
            levers: where they are.
            start: rates (m, 3) to start from.
        """
        loads, balanced = loads_of(self._model, wheels, carrying, levers)
        rows, targets = self._rows.at(wheels, levers, self._size)
        contacts = Contacts.of(rows, targets, loads, self._cuts[wheels])
        found, settled = self._twists.minimize(contacts, start)
        return SetMotions(np.where(settled[:, None], found, 0.0), loads, settled & balanced)


class MotionsOnSets:
    """Motions on any sets of wheels of one model."""

    def __init__(self, model: ContactModel, size: float) -> None:
        """With a length that stands for the body's size."""
        self._places, self._least = model.positions, LeastTwists(model, size)

    def at(self, carrying: Mask, centres: Floats, near: Floats | None = None) -> SetMotions:
        """The motions on wheels (m, n) with centres of mass (m, 2).

        Args:
            carrying: which wheels carry.
            centres: of mass.
            near: rates (m, 3) to start from; rest unless given.
        """
        rates, loads = np.zeros((len(centres), 3)), np.zeros(carrying.shape)
        start = rates if near is None else near
        levers = self._places - centres[:, None]
        stands = np.flatnonzero(widest_gaps(levers, carrying)[0] < np.pi)
        known = np.zeros(len(centres), bool)
        if len(stands):
            order = np.argsort(~carrying[stands], axis=1, kind="stable")[:, : int(carrying[stands].sum(axis=1).max())]
            under = np.take_along_axis(carrying[stands], order, axis=1)
            reaches = np.take_along_axis(levers[stands], order[..., None], axis=1)
            found = self._least.of(order, under, reaches, start[stands])
            rates[stands], known[stands], loads[stands[:, None], order] = found.rates, found.known, found.loads
        return SetMotions(rates, loads, known)
