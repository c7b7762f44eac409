"""The minimizer of the ellipse functional ``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``.

The ellipses may be cut by strips (rule ``roller``).  All points go at once to
:mod:`nonsmooth.analysis.minimizers.sum_of_supports`, in coordinates in which the rows' columns are orthonormal and
speeds of order 1, so that neither units nor the place of the origin matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, Floats
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.optimal_face import row_frame
from nonsmooth.analysis.minimizers.proved import resists_every_motion
from nonsmooth.analysis.minimizers.sum_of_supports import (
    SETTLED,
    SupportSums,
    by_smoothing,
    finished,
    sensitivity,
    tracked,
)
from nonsmooth.symbolic.friction_set import UnitDiscs

# Relative to the value at rest: the gap that rounding makes of the slips of wheels that stick.  A result with such a
# gap is verified by its forces before it is taken.
SLIP_ROUNDING = np.finfo(np.float64).eps
WARM_PASSES = 10  # of the method of multipliers from the last minimizer


@dataclass(frozen=True)
class EllipseMinimizer:
    """All points at once in NumPy; twist, forces and gap to rounding.

    A thousand points of four wheels take some fifteen milliseconds; a single point two.
    """

    @property
    def functional(self) -> Functional:
        """The ellipse."""
        return Functional.ELLIPSE

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.choice.Minimizer`."""
        normal = model.checked_loads(loads)
        scaled = _Scaled(model)
        return scaled.certified(normal, *by_smoothing(normal, scaled.maps, scaled.targets, scaled.sets))


class _Scaled:
    """The problem in coordinates in which columns are orthonormal and speeds of order 1."""

    def __init__(self, model: ContactRows) -> None:
        self.model, self.sets = model, UnitDiscs(model.cuts)
        rows, self.to_twists = row_frame(model.rows)
        grip = model.friction / (float(model.friction.max()) or 1.0)
        self.speeds = np.abs(grip * model.targets).max(axis=-1, keepdims=True)
        self.speeds[self.speeds == 0] = 1.0
        self.maps = (grip[:, None] * rows).reshape(-1, 2, 3)
        targets = grip * model.targets / self.speeds
        self.targets = targets.reshape(*targets.shape[:-1], -1, 2)

    def certified(self, loads: Floats, unknowns: Floats, shares: Floats) -> Minima:
        """Twists and forces in the model's own units; the wheels push the body against their slip."""
        twists = self.speeds * (unknowns @ self.to_twists.T)
        return Minima.certified(Functional.ELLIPSE, self.model, loads, twists, -shares * self.model.limits(loads))


# ---- along a path --------------------------------------------------------------------------------

DRAG = 1e-6  # of the friction of the whole weight


def needs_drag(model: ContactRows) -> bool:
    """Whether D is linear in pieces somewhere: a friction set has corners."""
    return bool((model.cuts < 1).any())


class PathMinimizer:
    """The motion of least dissipation at one load after the other along a path, each with its proof.

    Steps from the last minimizer take a tenth of a millisecond, multipliers from it a millisecond or more, and where
    neither proves its result it is found from nothing.

    Where friction sets have corners (rule ``roller``) D is linear in pieces, as under rule ``box``: at some loads its
    minimizers are a whole face, and beyond them the twist is another one.  Solutions slide along such places
    (Filippov), which no integrator of smooth fields can follow.  So a little drag is added, ``sum_k epsilon
    sqrt(x_k^2 + g^2)`` over the entries x of ``(v_x, v_y, L omega)``: smooth, strictly convex, least at rest.  The
    twist then passes from one to the other while the slope of D along the face changes by the drag's.  It moves a twist
    that does not jump by the order of epsilon.  The result is proved as ever: as the minimizer of D plus drag, whose
    value is within ``epsilon (|x|_1 + 3 g)`` of the least D.
    """

    def __init__(self, model: ContactModel) -> None:
        self._model, self._resisted = model, dict[bytes, bool]()
        self._drag = DRAG if needs_drag(model) else 0.0
        self._scaled = scaled = _Scaled(_dragged(model) if self._drag else model)
        columns = scaled.targets.T[..., None]
        self._sums = SupportSums(np.ones((scaled.model.wheels, 1)), scaled.maps, columns, scaled.sets)
        self._last: tuple[Floats, Floats] | None = None

    def twist(self, loads: Floats) -> Floats | None:
        """The twist (3,) at loads (n,); None where it is not proved to be the motion."""
        if not self._resists(loads):
            return None
        if self._drag:
            loads = np.concatenate([loads, np.full(3, self._drag * loads.sum())])
        found = None
        if self._last is not None:
            found = self._from(*self._last, loads)
        if found is None:
            found = self._from_nothing(loads)
        if found is None:
            return None
        self._last = found
        return np.asarray(self._scaled.speeds[0] * (self._scaled.to_twists @ found[0][:, 0]))

    def slopes(self, loads: Floats, changes: Floats) -> Floats | None:
        """How fast the twist at loads (n,) changes, (3, k), with loads that change along the columns of (n, k).

        None where drag acts, which makes them as rough as differences, and where the twist is not known.
        """
        if self._drag or self.twist(loads) is None or self._last is None:
            return None
        rates = sensitivity(self._sums.weighted(loads[:, None]), *self._last, changes / loads.sum())
        return np.asarray(self._scaled.speeds[0] * (self._scaled.to_twists @ rates))

    def _resists(self, loads: Floats) -> bool:
        """Whether the loaded wheels leave no motion free."""
        loaded = (loads > 0).tobytes()
        if loaded not in self._resisted:
            self._resisted[loaded] = bool(resists_every_motion(self._model, loads[None])[0])
        return self._resisted[loaded]

    @np.errstate(all="ignore")  # a step out of the range of floats is not accepted
    def _from(self, y: Floats, forces: Floats, loads: Floats) -> tuple[Floats, Floats] | None:
        """Unknowns and forces from the last ones."""
        sums = self._sums.weighted(loads[:, None])
        near = tracked(sums, y, forces)
        if near is not None:
            return near
        found = finished(sums, y, forces, 0.0, WARM_PASSES)
        # Where hardly anything slips the gap is that of rounding; the next step says how near the twist is.
        carried = (found.lacks <= SLIP_ROUNDING * sums.start) & (found.steps <= SETTLED)
        return (
            (found.y, found.forces)
            if (found.proved | carried)[0] and self._is_proved(found.y, found.forces, loads)
            else None
        )

    def _from_nothing(self, loads: Floats) -> tuple[Floats, Floats] | None:
        scaled = self._scaled
        unknowns, shares = by_smoothing(loads[None], scaled.maps, scaled.targets, scaled.sets)
        y, forces = unknowns.T, shares.transpose(2, 1, 0)
        return (y, forces) if self._is_proved(y, forces, loads) else None

    def _is_proved(self, y: Floats, forces: Floats, loads: Floats) -> bool:
        return bool(self._scaled.certified(loads[None], y.T, forces.transpose(2, 1, 0)).check()[0])


def _dragged(model: ContactModel) -> ContactRows:
    """The rows with three contacts more: along x, along y and around, each with a slip g across that never vanishes."""
    size = float(np.hypot(*(model.positions - model.positions.mean(axis=0)).T).max())
    speed = float(np.abs(model.targets).max()) or 1.0
    rows = np.zeros((6, 3))
    rows[[0, 2, 4], [0, 1, 2]] = 1.0, 1.0, size
    return ContactRows(
        np.concatenate([model.rows, rows]),
        np.concatenate([model.targets, np.tile([0.0, speed], 3)]),
        np.concatenate([model.friction, np.full(6, model.friction.max())]),
        cuts=np.concatenate([model.cuts, np.ones(3)]),
    )
