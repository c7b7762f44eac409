"""The minimizer of D where strips cut some friction ellipses, one after the other along a path: Newton steps.

With ``X = mu_R r`` and ``Y = mu_S s`` a contact is on one of four pieces
(:mod:`nonsmooth.symbolic.mechanics.friction_set`)::

    on the arc     force (X, Y)/sqrt(X^2 + Y^2)                    (1 - kappa^2) Y^2 <= kappa^2 X^2
    at a corner    force (sqrt(1 - kappa^2) sgn X, kappa sgn Y)    beyond that, X != 0
    it rolls       X = 0, force (f, kappa sgn Y)                   |f| <= sqrt(1 - kappa^2)
    it sticks      X = Y = 0, force (f, g)                         the same, |g| <= kappa

The force is continuous where arc and corner meet.  Contacts that roll, as omniwheels mostly do along their rims, or
stick keep ``N f`` and ``N g`` as unknowns beside the twist, so that each step is linear in them.  A contact at a corner
that comes to ``X = 0`` rolls, one that rolls and comes to ``Y = 0`` sticks, and one whose f or g is too large slips to
the side of it.  D is convex: where all forces balance and are those of their slips, the twist is a minimizer, and the
only one where D is strictly convex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats

STEPS = 30  # of Newton's method with all changes of what rolls; beside the last minimum three or four
STUCK = 1e-4  # of the fastest wheel's speed: where a contact slips less on its arc, the other method is left to it
ROLLS = 1e-9  # the same: an X or Y that is rounding of the other method
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
        self._limits = np.column_stack([self._corner, self._cut])
        self._sides = np.zeros_like(self._goals)  # of X and Y of each contact that is cut: 0 where it rolls or sticks
        self.last: Floats | None = None

    def start_from(self, twist: Floats) -> None:
        """Begin at a twist that another method found."""
        self.last = twist
        moves = self._pairs @ (twist * self._scale) - self._goals
        self._sides = np.where(np.abs(moves) <= ROLLS * self._speed, 0.0, np.sign(moves))

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not found."""
        twist, self.last = self.last, None
        if twist is None:
            return None
        unknowns, loaded, arcs = twist * self._scale, loads > 0, np.zeros(len(loads), bool)
        for _ in range(STEPS):
            slips = self._pairs @ unknowns - self._goals
            before, arcs = arcs, self._on_arcs(slips)
            if np.hypot(*slips[arcs & loaded].T).min(initial=self._speed) < STUCK * self._speed:
                return None
            found = self._step(loads, slips, arcs)
            if found is None:
                return None
            step, forces = found
            turned = self._first_turned(slips, step, loaded & (self._cut < 1) & ~arcs)
            if turned is not None:  # as far as there, where it begins to roll or stick
                share, contact, axis = turned
                unknowns, self._sides[contact, axis] = unknowns + share * step, 0.0
                continue
            unknowns = unknowns + step
            excess = np.abs(forces) - self._limits
            if excess.max() > 0:
                contact, axis = divmod(int(excess.argmax()), 2)
                self._sides[contact, axis] = np.sign(forces[contact, axis])
            elif np.abs(self._pairs @ step).max() <= SETTLED * self._speed and np.array_equal(arcs, before):
                self.last = unknowns / self._scale
                return self.last
        return None

    def _on_arcs(self, slips: Floats) -> Mask:
        """Contacts whose force lies on the arc; the others are at corners, roll or stick.  Sets sides of the first two.

        A contact that slips along its rim knows its Y by the slip alone.
        """
        rolls = (self._sides[:, 0] == 0) & (self._cut < 1)
        arcs = (self._corner * np.abs(slips[:, 1]) <= self._cut * np.abs(slips[:, 0])) & ~rolls
        self._sides[arcs, 0] = np.sign(slips[arcs, 0])
        self._sides[~rolls, 1] = np.sign(slips[~rolls, 1])
        return np.asarray(arcs)

    def _step(self, loads: Floats, slips: Floats, arcs: Mask) -> tuple[Floats, Floats] | None:
        """A step of the twist in scaled units, and forces of contacts that roll or stick (n, 2); None if singular."""
        held = (self._sides == 0) & ~arcs[:, None] & (loads > 0)[:, None] & (self._cut < 1)[:, None]
        forces = self._limits * self._sides
        sizes = np.where(arcs, np.hypot(*slips.T), 1.0)
        sizes[sizes == 0] = 1.0  # without load
        units = slips / sizes[:, None]
        forces[arcs] = units[arcs]
        turned = units[:, :1] * self._pairs[:, 1] - units[:, 1:] * self._pairs[:, 0]
        rows = self._pairs[held]
        matrix, right = np.zeros((3 + len(rows),) * 2), np.zeros(3 + len(rows))
        matrix[:3, :3] = (turned.T * np.where(arcs, loads / sizes, 0.0)) @ turned
        matrix[3:, :3], matrix[:3, 3:] = rows, rows.T
        right[:3] = -(forces * loads[:, None]).ravel() @ self._pairs.reshape(-1, 3)
        right[3:] = -slips[held]
        try:
            found = np.asarray(np.linalg.solve(matrix, right), np.float64)
        except np.linalg.LinAlgError:
            return None
        unknown = np.zeros_like(slips)
        unknown[held] = found[3:] / np.broadcast_to(loads[:, None], slips.shape)[held]
        return (found[:3], unknown) if np.isfinite(found).all() else None

    def _first_turned(self, slips: Floats, step: Floats, slipping: Mask) -> tuple[float, int, int] | None:
        """The share of a step at which a slip first leaves its side, of which contact, and along 0 or across 1.

        Those at a corner leave that of X, and those that roll that of Y.
        """
        change = self._pairs @ step
        left = ((slips + change) * self._sides < 0) & slipping[:, None]
        left[:, 1] &= self._sides[:, 0] == 0
        if not left.any():
            return None
        shares = np.where(left, np.clip(-slips / np.where(left, change, 1.0), 0.0, 1.0), np.inf)
        contact, axis = divmod(int(shares.argmin()), 2)
        return float(shares[contact, axis]), contact, axis
