"""Regimes of friction: which contacts stick or nearly do, and the unknowns that Newton's method has for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats


@dataclass(frozen=True, eq=False)
class Regime:
    """Which contacts stick or nearly do; the unknowns are (twist, forces, slips) in a row.

    Attributes:
        contacts: that nearly stick, (t,), ascending.
        sticks: which of them do, (t,).
        pinned: which slip in a direction that those which stick leave no choice, (t,): all could stick at once, as
            wheels on a line that run along it.  Their forces are constant.
    """

    contacts: NDArray[np.int_]
    sticks: NDArray[np.bool_]
    pinned: NDArray[np.bool_]

    @cached_property
    def end(self) -> int:
        """Where the forces end and the slips begin."""
        return 3 + 2 * len(self.contacts)

    @cached_property
    def slipping(self) -> NDArray[np.int_]:
        """Places of contacts that slip, among those of the regime."""
        return np.flatnonzero(~self.sticks)

    @cached_property
    def repeats(self) -> bool:
        """Whether several contacts stick, so that their equations may repeat each other."""
        return int(self.sticks.sum()) > 1

    def parts(self, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """Twists (..., 3), forces (..., t, 2) and slips of contacts (..., t), zero of those that stick."""
        forces = unknowns[..., 3 : self.end].reshape(*unknowns.shape[:-1], -1, 2)
        slips = np.zeros(forces.shape[:-1])
        slips[..., self.slipping] = unknowns[..., self.end :]
        return unknowns[..., :3], forces, slips

    def whole(self, twist: Floats, forces: Floats, slips: Floats) -> Floats:
        """The inverse of :meth:`parts`, of one solution."""
        return np.concatenate([twist, forces.ravel(), slips[self.slipping]])

    def lacks(self, unknowns: Floats) -> Floats:
        """``1 - |f|^2`` of contacts that stick, s of those that slip: negative where there is no such friction."""
        _, forces, slips = self.parts(unknowns)
        return np.where(self.sticks, 1 - (forces**2).sum(axis=-1), slips)


NOBODY = Regime(np.zeros(0, int), np.zeros(0, bool), np.zeros(0, bool))


def changed(regime: Regime, unknowns: Floats, wrong: NDArray[np.bool_]) -> tuple[Regime, Floats]:
    """The regime and unknowns in which the wrong contacts (t,) slip instead of stick, and the other way round."""
    twist, forces, slips = regime.parts(unknowns)
    lengths = np.sqrt((forces**2).sum(axis=1))
    released = wrong & regime.sticks
    forces = np.where(released[:, None], forces / np.maximum(lengths, 1e-300)[:, None], forces)
    after = replace(regime, sticks=regime.sticks ^ wrong)
    return after, after.whole(twist, forces, np.where(wrong, 0.0, slips))
