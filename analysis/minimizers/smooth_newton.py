"""The minimizer of a sum of norms, one after the other along a path: plain Newton steps.

``D(xi) = sum_i N_i |w_i|``, ``w_i = (mu_R r_i, mu_S s_i)``, has the gradient ``sum_i N_i W_i^T e_i`` with
``e_i = w_i/|w_i|``, and the Hessian ``sum_i N_i/|w_i| W_i^T (1 - e_i e_i^T) W_i``.  That is smooth but for contacts
that stick or nearly do.  These keep their forces f as unknowns beside the twist::

    a contact sticks      w_k = 0,      |f_k| <= 1
    it slips              w_k = s f_k,  |f_k| = 1,    s >= 0

with ``sum over the others of N_i W_i^T e_i + sum_k N_k W_k^T f_k = 0``.  These equations are regular where s vanishes
(of several contacts that stick at once the forces may leave a choice; any admissible one serves).  D is convex: a
solution is a minimizer, and friction forces are ``-N_i (mu_R e_i1, mu_S e_i2)``.  It is the only one where the Hessian
of the others is positive definite along the motions that leave the ``w_k`` (or their directions) as they are.  So
nothing else has to be proved.  Where the steps do not settle, another method is needed
(:class:`nonsmooth.analysis.minimizers.ellipse_minimizer.WarmMinimizer`).

Which contacts stick is a *regime*.  In it the unknowns follow the loads analytically, ``J unknowns' = -sum_i N_i' W_i^T
e_i`` with J the Jacobian of Newton's method, also beyond the place where a force or a slip forbids it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.regime import NOBODY, Regime, changed
from nonsmooth.analysis.minimizers.smallest_forces import smallest_forces
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs

STEPS = 15  # a start beside the last minimum needs three or four
NEAR = 0.01  # of the fastest wheel's speed: contacts that slip less keep their forces
STUCK = 1e-4  # the same: where another contact slips less, the other method is left to it
RESTS = 1e-9  # the same: a slip that is rounding of the other method
SETTLED = 1e-9  # change of a slip and of a force; the error after it is its square over the slips
RESIDUAL = 1e-13  # slip of contacts that stick, of the fastest wheel's speed
SINGULAR = 1e-10  # ratio of the extreme eigenvalues of a Hessian, columns scaled, below which it may be singular
LOST = 1e6  # a slip that is so many times as fast leads nowhere
CHANGES = 6  # of contacts that stick for contacts that slip, before the other method is asked

DISC = UnitDiscs(np.ones(1))  # the friction set of every contact, in units of its half-axes


class SmoothNewton:
    """Minimizers of one set of contacts at loads near each other."""

    def __init__(self, model: ContactModel) -> None:
        """For a model whose friction sets are whole ellipses.

        Raises:
            ValueError: where a strip cuts one, or one has another shape.
        """
        if not model.has_whole_ellipses:
            raise ValueError("required whole friction ellipses")
        self._rows = model.friction[:, None] * model.rows
        self._targets = model.friction * model.targets
        self._pairs, self._goals = self._rows.reshape(-1, 2, 3), self._targets.reshape(-1, 2)
        self._first, self._second = self._rows[::2], self._rows[1::2]
        self._speed = float(np.abs(self._targets).max()) or 1.0
        self._scale = np.abs(self._rows).max(axis=0)  # of the columns: v and omega have different units
        self._scale[self._scale == 0] = 1.0
        self.last: tuple[Regime, Floats] | None = None

    def start_from(self, twist: Floats) -> None:
        """Begin at a twist that another method found."""
        self.last = NOBODY, twist

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not proved to be the minimizer."""
        if self.last is None:
            return None
        regime, unknowns = self._tracked(*self.last, loads)
        self.last = None
        for _ in range(CHANGES):
            found = self.settled(regime, unknowns, loads)
            if found is None:
                return None
            wrong = regime.lacks(found) < 0
            if not wrong.any():
                self.last = regime, found
                return found[:3]
            regime, unknowns = self._pinned(*changed(regime, found, wrong))
        return None

    def _tracked(self, regime: Regime, unknowns: Floats, loads: Floats) -> tuple[Regime, Floats]:
        """With forces of all loaded contacts that nearly stick."""
        moves = (self._rows @ unknowns[:3] - self._targets).reshape(-1, 2)
        sizes = DISC.support(*moves.T)
        contacts = np.flatnonzero((sizes < NEAR * self._speed) & (loads != 0))
        if np.array_equal(contacts, regime.contacts):
            return regime, unknowns
        sizes = np.maximum(sizes, np.finfo(float).tiny)
        forces, slips, sticks = moves / sizes[:, None], sizes.copy(), sizes <= RESTS * self._speed
        _, forces[regime.contacts], slips[regime.contacts] = regime.parts(unknowns)
        sticks[regime.contacts] = regime.sticks
        after = Regime(contacts, sticks[contacts], np.zeros(len(contacts), bool))
        return self._pinned(after, after.whole(unknowns[:3], forces[contacts], slips[contacts]))

    def _pinned(self, regime: Regime, unknowns: Floats) -> tuple[Regime, Floats]:
        """Look for contacts that slip but could stick together with those that do."""
        stuck = regime.contacts[regime.sticks]
        if not len(stuck) or regime.sticks.all():
            return replace(regime, pinned=np.zeros_like(regime.sticks)), unknowns
        twist, forces, slips = regime.parts(unknowns)
        forces, pinned = forces.copy(), np.zeros_like(regime.sticks)
        held = self._pairs[stuck].reshape(-1, 3)
        _, sizes, frame = np.linalg.svd(held / self._scale)
        way = frame[2] / self._scale  # the motion that those which stick leave
        for k in regime.slipping if (sizes > SINGULAR).sum() == 2 else ():
            contact = regime.contacts[k]
            rows = np.concatenate([held, self._pairs[contact]])
            goals = np.concatenate([self._goals[stuck].ravel(), self._goals[contact]])
            together = np.linalg.lstsq(rows, goals, rcond=SINGULAR)[0]
            pinned[k] = np.abs(rows @ together - goals).max() <= RESIDUAL * self._speed
            if pinned[k]:
                along = self._pairs[contact] @ way
                forces[k] = along / np.hypot(*along) * (1.0 if forces[k] @ along >= 0 else -1.0)
        return replace(regime, pinned=pinned), regime.whole(twist, forces, slips)

    # ---- along a regime --------------------------------------------------------------------------

    def slope(self, regime: Regime, unknowns: Floats, loads: Floats, change: Floats) -> Floats:
        """How fast the unknowns change while loads (n,) do; not a number where they cannot be continued."""
        system = self._system(regime, unknowns, loads)
        if system is None:
            return np.full(len(unknowns), np.nan)
        matrix, _, units = system
        right = np.zeros(len(unknowns))
        right[:3] = -((units * change[:, None]).ravel() @ self._rows)
        step = _solved(matrix, right, regime)
        return np.full(len(unknowns), np.nan) if step is None else step

    def is_near_rest(self, regime: Regime, unknowns: Floats, loads: Floats) -> bool:
        """Whether another contact nearly sticks by now."""
        moves = (self._rows @ unknowns[:3] - self._targets).reshape(-1, 2)
        near = (DISC.support(*moves.T) < NEAR * self._speed) & (loads != 0)
        near[regime.contacts] = False
        return bool(near.any())

    def settled(self, regime: Regime, unknowns: Floats, loads: Floats) -> Floats | None:
        """The unknowns at loads (n,), by Newton's method; None where it is not proved that no other twist is as good.

        Signs of forces and slips are not looked at.
        """
        for _ in range(STEPS):
            system = self._system(regime, unknowns, loads)
            step = None if system is None else _solved(system[0], system[1], regime)
            if system is None or step is None:
                return None
            unknowns = unknowns - step
            small = np.abs(self._rows @ step[:3]).max() <= SETTLED * self._speed
            if small and np.abs(step[3 : regime.end]).max(initial=0.0) <= SETTLED:
                return self._proved(regime, unknowns, loads, system[0][:3, :3])
        return None

    def _system(self, regime: Regime, unknowns: Floats, loads: Floats) -> tuple[Floats, Floats, Floats] | None:
        """Jacobian and residuals of balance (3), slips (2t) and lengths of forces; and the units e_i or forces (n, 2).

        None where a contact that the regime does not know nearly sticks.
        """
        slips = (self._rows @ unknowns[:3] - self._targets).reshape(-1, 2)
        known, others = len(regime.contacts) > 0, loads
        if known:
            others = loads.copy()
            others[regime.contacts] = 0.0
        sizes = DISC.support(*slips.T)
        sizes[others == 0] = self._speed  # nothing is divided by a slip that does not count
        listed = sizes.tolist()
        if not STUCK * self._speed <= min(listed) <= max(listed) < LOST * self._speed or listed[0] != listed[0]:
            return None
        units = slips / sizes[:, None]
        turned = units[:, :1] * self._second - units[:, 1:] * self._first
        hessian = (turned.T * (others / sizes)) @ turned
        if known:
            _, forces, moves = regime.parts(unknowns)
            units[regime.contacts] = forces
        gradient = (units * loads[:, None]).ravel() @ self._rows
        if not known:
            return hessian, gradient, units
        pairs, end = self._pairs[regime.contacts], regime.end
        matrix, right = np.zeros((len(unknowns),) * 2), np.zeros(len(unknowns))
        matrix[:3, :3], matrix[3:end, :3] = hessian, pairs.reshape(-1, 3)
        matrix[:3, 3:end] = (loads[regime.contacts, None, None] * pairs).reshape(-1, 3).T
        right[:3] = gradient
        right[3:end] = (slips[regime.contacts] - moves[:, None] * forces).ravel()
        for row, k in enumerate(regime.slipping.tolist(), start=end):
            first = 3 + 2 * k
            if regime.pinned[k]:
                matrix[first : first + 2, :3], right[first : first + 2] = 0.0, 0.0
                matrix[first, first] = matrix[first + 1, first + 1] = matrix[row, row] = 1.0
                matrix[row, :3] = -forces[k] @ pairs[k]
                right[row] = moves[k] - forces[k] @ slips[regime.contacts[k]]
                continue
            matrix[first, first] = matrix[first + 1, first + 1] = -moves[k]
            matrix[first : first + 2, row], matrix[row, first : first + 2] = -forces[k], forces[k]
            right[row] = (forces[k] @ forces[k] - 1) / 2
        return matrix, right, units

    # ---- what a solution is ------------------------------------------------------------------------

    def _proved(self, regime: Regime, unknowns: Floats, loads: Floats, hessian: Floats) -> Floats | None:
        """The unknowns, where no other twist is as good; forces that leave a choice become small."""
        twist, forces, slips = regime.parts(unknowns)
        pairs, sticks = self._pairs[regime.contacts], regime.sticks
        turned = forces[:, :1] * pairs[:, 1] - forces[:, 1:] * pairs[:, 0]
        held = np.concatenate([pairs[sticks].reshape(-1, 3), turned[~sticks]]) / self._scale
        scaled = hessian / np.outer(self._scale, self._scale)
        if len(held):
            _, sizes, frame = np.linalg.svd(held)
            free = frame[int((sizes > SINGULAR).sum()) :]
            scaled = free @ scaled @ free.T if len(free) else np.eye(1)
        eigenvalues = np.linalg.eigvalsh(scaled)
        if not eigenvalues[0] > SINGULAR * eigenvalues[-1]:
            return None
        stuck = regime.contacts[sticks]
        if np.abs(self._pairs[stuck] @ twist - self._goals[stuck]).max(initial=0.0) > RESIDUAL * self._speed:
            return None
        if len(stuck) > 1:
            forces = forces.copy()
            forces[sticks] = smallest_forces(loads[stuck, None, None] * pairs[sticks], forces[sticks])
        return regime.whole(twist, forces, slips)


def _solved(matrix: Floats, right: Floats, regime: Regime) -> Floats | None:
    """The solution of a linear system; the shortest one where contacts that stick repeat each other."""
    try:
        if regime.repeats:
            return np.asarray(np.linalg.lstsq(matrix, right, rcond=SINGULAR)[0])
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return None
