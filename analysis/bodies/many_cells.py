"""Motions of many bodies at once under a rule with cells: the cell on the wheels of each that its place lies in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.bodies.many_contacts import Mask, Numbers
from nonsmooth.analysis.bodies.set_cells import CellsBySet, SetCells
from nonsmooth.analysis.contact_rule import CellRule
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.symbolic.scene import Scene


class _Table:
    """The cells on one set of wheels, all sides in a row."""

    def __init__(self, cells: SetCells) -> None:
        sides = [(line, sign) for cell in cells.cells for line, sign in cell.sides]
        origin = np.zeros(3)
        self._normals = np.array([sign * line.gradient(origin)[:2] for line, sign in sides])
        self._offsets = np.array([sign * line.value(origin) for line, sign in sides])
        counts = [len(cell.sides) for cell in cells.cells]
        self._starts: NDArray[np.int_] = np.cumsum([0, *counts[:-1]])
        self._twists = np.array([cell.twist for cell in cells.cells])

    def twists(self, centres: Floats) -> Floats:
        """The twist of the cell that holds each centre (m, 2), or is nearest to it; shape (m, 3)."""
        gaps = np.minimum.reduceat(centres @ self._normals.T + self._offsets, self._starts, axis=1)
        return np.asarray(self._twists[gaps.argmax(axis=1)])


class CellMotions:
    """The motions by cells; those of each set are built once.  Where motions tie the first is taken."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For an array with all its wheels."""
        self._sets, self._count = CellsBySet(scene, rule), len(scene.wheels)
        self._known: dict[bytes, _Table] = {}

    def of(self, near: Numbers, carrying: Mask, levers: Floats, poses: Floats, paths: Numbers) -> tuple[Floats, Mask]:
        """See :meth:`nonsmooth.analysis.bodies.many_rates.Motions.of`.

        Raises:
            RefusalError: where the motion on some wheels is not determined.
        """
        under = np.zeros((len(poses), self._count), bool)
        rows, columns = np.nonzero(carrying)
        under[rows, near[rows, columns]] = True
        sets, group = np.unique(np.packbits(under, axis=1), axis=0, return_inverse=True)
        twists = np.zeros((len(poses), 3))
        for k in range(len(sets)):
            own = np.flatnonzero(group.reshape(-1) == k)
            twists[own] = self._table(under[own[0]]).twists(poses[own, :2])
        rates = twists.copy()
        rates[:, 0] -= twists[:, 2] * poses[:, 1]
        rates[:, 1] += twists[:, 2] * poses[:, 0]
        return rates, np.ones(len(poses), bool)

    def _table(self, under: Mask) -> _Table:
        key = under.tobytes()
        if key not in self._known:
            self._known[key] = _Table(self._sets.of(frozenset(np.flatnonzero(under).tolist())))
        return self._known[key]
