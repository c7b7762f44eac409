"""The minimizer of the ellipse functional ``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``.

The ellipses may be cut by strips (rule ``roller``).  All points go at once to
:mod:`nonsmooth.analysis.minimizers.sum_of_supports`, in coordinates in which the rows' columns are orthonormal and
speeds of order 1, so that neither units nor the place of the origin matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.fields.contact_model import ContactRows, contacts_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minima, balance_forces, row_frame
from nonsmooth.analysis.minimizers.sum_of_supports import SETTLED, SupportSums, by_smoothing, finished
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats

# Relative to the value at rest: the gap that rounding makes of the slips of wheels that stick.  A result with such a
# gap is verified by its forces before it is taken.
SLIP_ROUNDING = np.finfo(np.float64).eps
WARM_PASSES = 10  # of the method of multipliers from the last minimizer
COLD_PASSES = 1000  # the same from nothing: what is not found by then is not found


@dataclass(frozen=True)
class EllipseMinimizer:
    """All points at once in NumPy; twist, forces and gap to rounding.

    A thousand points of four wheels take some three milliseconds; a single point half a one.
    """

    functional: ClassVar = Functional.ELLIPSE

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.minimum.Minimizer`."""
        normal = model.checked_loads(loads)
        scaled = _Scaled(model)
        return scaled.certified(normal, *by_smoothing(normal, scaled.maps, scaled.targets, scaled.sets))


def minima_under(rule: SmoothRule, scene: Scene, points: Floats) -> Minima:
    """The twists at points (m, 2), shape (m, 3), each with the friction forces that prove it.

    Args:
        rule: with the friction sets to take, whatever rule the scene names.
        scene: the array.
        points: of the centre of mass.
    """
    model = contacts_under(rule, scene)
    return EllipseMinimizer().minimize(model, loads_at(model, points))


class _Scaled:
    """The problem in coordinates in which columns are orthonormal and speeds of order 1."""

    def __init__(self, model: ContactRows) -> None:
        self.model, self.sets = model, model.shape.searched(model.cuts)
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

    def proved(self, loads: Floats, unknowns: Floats, shares: Floats) -> Floats | None:
        """The twist (3,) at loads (n,), where forces (1, n, 2) prove that none is better."""
        twists, forces = self.speeds * (unknowns @ self.to_twists.T), -shares * self.model.limits(loads[None])
        balanced = balance_forces(Functional.ELLIPSE, self.model, loads[None], forces)
        found = Minima(Functional.ELLIPSE, self.model, loads[None], twists, balanced)
        return np.asarray(twists[0]) if found.check()[0] else None


class WarmMinimizer:
    """One minimizer after the other along a path: multipliers from the last one, else from nothing.

    Several times as fast as :class:`EllipseMinimizer` for single points.  Each twist is proved by balanced forces that
    are admissible (:meth:`nonsmooth.analysis.minimizers.minimum.Minima.check`); other twists that are as good are not
    looked for.

    Attributes:
        cold: minimizers so far that were found from nothing, which takes some hundred times as long.
    """

    def __init__(self, model: ContactRows) -> None:
        self._scaled = _Scaled(model)
        self._last: tuple[Floats, Floats] | None = None
        self.cold = 0

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not proved to be a minimizer."""
        scaled = self._scaled
        if self._last is not None:
            twist = self._continued(loads, *self._last)
            if twist is not None:
                return twist
        self.cold += 1
        y, forces = by_smoothing(loads[None], scaled.maps, scaled.targets, scaled.sets, COLD_PASSES)
        self._last = y.T, forces.transpose(2, 1, 0)
        return scaled.proved(loads, y, forces)

    @property
    def nearest(self) -> Floats:
        """The last twist, proved or not, after :meth:`minimize`."""
        if self._last is None:
            raise ValueError("required a minimizer that was asked, received none")
        return np.asarray((self._scaled.speeds * (self._last[0].T @ self._scaled.to_twists.T))[0])

    def _continued(self, loads: Floats, y: Floats, forces: Floats) -> Floats | None:
        scaled = self._scaled
        with np.errstate(all="ignore"):  # a step out of the range of floats is not accepted
            sums = SupportSums(loads[:, None], scaled.maps, scaled.targets.T[..., None], scaled.sets)
            found = finished(sums, y, forces, 0.0, WARM_PASSES)
        # Where hardly anything slips the gap is that of rounding; the next step says how near the twist is.
        carried = (found.lacks <= SLIP_ROUNDING * sums.start) & (found.steps <= SETTLED)
        if not (found.proved | carried)[0]:
            return None
        self._last = found.y, found.forces
        return scaled.proved(loads, found.y.T, found.forces.transpose(2, 1, 0))
