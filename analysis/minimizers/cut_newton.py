"""The minimizer of D where strips cut some friction ellipses, one after the other along a path: Newton steps.

With ``X = mu_R r`` and ``Y = mu_S s`` a contact slips on one of three pieces (:mod:`nonsmooth.symbolic.friction_set`)::

    on the arc     force (X, Y)/sqrt(X^2 + Y^2)                    (1 - kappa^2) Y^2 <= kappa^2 X^2
    at a corner    force (sqrt(1 - kappa^2) sgn X, kappa sgn Y)    beyond that, X != 0
    it rolls       X = 0, force (f, kappa sgn Y)                   |f| <= sqrt(1 - kappa^2)

The force is continuous where arc and corner meet.  Contacts that roll, as omniwheels mostly do along their rims, keep
``N f`` as an unknown beside the twist, so that each step is linear in it.  A contact at a corner that comes to
``X = 0`` rolls, and one whose f is too large slips to the side of f.  D is convex: where all forces balance and are
those of their slips, the twist is a minimizer, and the only one where D is strictly convex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats

STEPS = 30  # of Newton's method with all changes of what rolls; beside the last minimum three or four
STUCK = 1e-4  # of the fastest wheel's speed: where a contact slips less, the other method is left to it
ROLLS = 1e-9  # the same: an X that is rounding of the other method
SETTLED = 1e-9  # change of a slip, the same; the error after it is its square over the slips

Mask = NDArray[np.bool_]


class CutNewton:
    """Minimizers of one set of contacts at loads near each other.

    Attributes:
        last: the last twist, None before the first and where none was found.
    """

    def __init__(self, model: ContactRows) -> None:
        """For cut ellipses of which D is strictly convex at all loads that are asked for."""
        model.require_ellipses()
        self._scale = np.abs(model.friction[:, None] * model.rows).max(axis=0)
        self._scale[self._scale == 0] = 1.0
        rows = model.friction[:, None] * model.rows / self._scale
        self._pairs, self._goals = rows.reshape(-1, 2, 3), (model.friction * model.targets).reshape(-1, 2)
        self._cut, self._corner = model.cuts, np.sqrt((1 - model.cuts) * (1 + model.cuts))
        self._speed = float(np.abs(self._goals).max()) or 1.0
        self._sides = np.zeros(len(model.cuts))  # of X of each contact: 0 where it rolls
        self.last: Floats | None = None

    def start_from(self, twist: Floats) -> None:
        """Begin at a twist that another method found."""
        self.last = twist
        moves = self._pairs[:, 0] @ (twist * self._scale) - self._goals[:, 0]
        self._sides = np.where((np.abs(moves) <= ROLLS * self._speed) & (self._cut < 1), 0.0, np.sign(moves))

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not found."""
        twist, self.last = self.last, None
        if twist is None:
            return None
        unknowns, loaded, arcs = twist * self._scale, loads > 0, np.zeros(len(loads), bool)
        for _ in range(STEPS):
            slips = self._pairs @ unknowns - self._goals
            sizes = np.where(loaded, np.hypot(*slips.T), self._speed)
            if not sizes.min() >= STUCK * self._speed:
                return None
            before, arcs = arcs, self._on_arcs(slips)
            found = self._step(loads, slips, sizes, arcs)
            if found is None:
                return None
            step, forces = found
            turned = self._first_turned(slips, step, loaded)
            if turned is not None:  # as far as there, where it begins to roll
                share, contact = turned
                unknowns, self._sides[contact] = unknowns + share * step, 0.0
                continue
            unknowns = unknowns + step
            excess = np.where(loaded, np.abs(forces) - self._corner, -1.0)
            if excess.max() > 0:
                contact = int(excess.argmax())
                self._sides[contact] = np.sign(forces[contact])
            elif np.abs(self._pairs @ step).max() <= SETTLED * self._speed and np.array_equal(arcs, before):
                self.last = unknowns / self._scale
                return self.last
        return None

    def _on_arcs(self, slips: Floats) -> Mask:
        """Contacts whose force lies on the arc; beside them are corners, and contacts that roll.  Sets sides there."""
        across, along = self._corner * np.abs(slips[:, 1]), self._cut * np.abs(slips[:, 0])
        arcs = (across <= along) & ((self._sides != 0) | (self._cut == 1))
        self._sides[arcs] = np.sign(slips[arcs, 0])
        return np.asarray(arcs)

    def _step(self, loads: Floats, slips: Floats, sizes: Floats, arcs: Mask) -> tuple[Floats, Floats] | None:
        """A step of the twist in scaled units, and f of contacts that roll (n,), zero of others; None if singular."""
        rolls = np.flatnonzero((self._sides == 0) & ~arcs & (loads > 0))
        forces = np.column_stack([self._corner * self._sides, self._cut * np.sign(slips[:, 1])])
        units = slips / sizes[:, None]
        forces[arcs] = units[arcs]
        turned = units[:, :1] * self._pairs[:, 1] - units[:, 1:] * self._pairs[:, 0]
        count = 3 + len(rolls)
        matrix, right = np.zeros((count, count)), np.zeros(count)
        matrix[:3, :3] = (turned.T * np.where(arcs, loads / sizes, 0.0)) @ turned
        matrix[3:, :3] = self._pairs[rolls, 0]
        matrix[:3, 3:] = self._pairs[rolls, 0].T
        right[:3] = -(forces * loads[:, None]).ravel() @ self._pairs.reshape(-1, 3)
        right[3:] = -slips[rolls, 0]
        try:
            found = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            return None
        pulls = np.zeros(len(loads))
        pulls[rolls] = found[3:] / loads[rolls]
        return (found[:3], pulls) if np.isfinite(found).all() else None

    def _first_turned(self, slips: Floats, step: Floats, loaded: Mask) -> tuple[float, int] | None:
        """The share of a step at which X of a contact at a corner or on its arc first leaves its side, and which."""
        change = self._pairs[:, 0] @ step
        after = slips[:, 0] + change
        left = np.flatnonzero(loaded & (self._cut < 1) & (self._sides != 0) & (after * self._sides < 0))
        if not len(left):
            return None
        shares = np.clip(-slips[left, 0] / change[left], 0.0, 1.0)
        first = int(shares.argmin())
        return float(shares[first]), int(left[first])
