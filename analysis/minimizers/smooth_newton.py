"""The minimizer of D, one after the other along a path: plain Newton steps on a sum of norms, cut or not.

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

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, are_finite, max_norm, norms, squared_norms

# ---- regimes of friction -------------------------------------------------------------------------
#
# Which contacts stick or nearly do, and the unknowns that Newton's method has for them.


@dataclass(frozen=True, eq=False)
class Regime:
    """Which contacts stick or nearly do; the unknowns are (twist, forces, slips) in a row.

    Attributes:
        contacts: that nearly stick, (t,), ascending.
        sticks: which of them do, (t,).
        pinned: which slip in a direction that those which stick leave no choice, (t,): all could stick at once, as
            wheels on a line that run along it.  Their forces are constant.
    """

    contacts: Indices
    sticks: Mask
    pinned: Mask

    @cached_property
    def end(self) -> int:
        """Where the forces end and the slips begin."""
        return 3 + 2 * len(self.contacts)

    @cached_property
    def slipping(self) -> Indices:
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


def changed(regime: Regime, unknowns: Floats, wrong: Mask) -> tuple[Regime, Floats]:
    """The regime and unknowns in which the wrong contacts (t,) slip instead of stick, and the other way round."""
    twist, forces, slips = regime.parts(unknowns)
    lengths = np.sqrt(squared_norms(forces))
    released = wrong & regime.sticks
    forces = np.where(released[:, None], forces / np.maximum(lengths, 1e-300)[:, None], forces)
    after = replace(regime, sticks=regime.sticks ^ wrong)
    return after, after.whole(twist, forces, np.where(wrong, 0.0, slips))


# ---- forces of contacts that stick ---------------------------------------------------------------
#
# Where balance leaves a choice: the largest of them as small as possible.
#
# Lawson's algorithm (1961): minimize ``sum_k weight_k |f_k|^2`` subject to balance, multiply each weight by ``|f_k|``,
# and again: the largest force falls towards the least possible, ``sqrt(sum_k weight_k |f_k|^2)`` of weights that add up
# to one is a bound from below, and it ends where both are close.


MOST_WEIGHTS = 100
CLOSE = 1.002  # ratio of the largest force to its least value


def smallest_forces(maps: Floats, forces: Floats) -> Floats:
    """Forces (k, 2) with the same ``sum_k maps_k^T f_k`` as the given ones, for maps (k, 2, 3)."""
    flat = maps.reshape(-1, 3).T
    total = flat @ forces.ravel()
    weights, best = np.full(len(forces), 1 / len(forces)), forces
    for _ in range(MOST_WEIGHTS):
        roots = np.repeat(1 / np.sqrt(np.maximum(weights, 1e-12)), 2)
        found = (roots * np.linalg.lstsq(flat * roots, total, rcond=1e-12)[0]).reshape(-1, 2)
        sizes = np.sqrt(squared_norms(found))
        if sizes.max() < np.sqrt(squared_norms(best)).max():
            best = found
        if sizes.max() <= CLOSE * np.sqrt(weights @ sizes**2):
            return best
        weights = weights * sizes
        weights /= weights.sum()
    return best


# ---- the minimizer -------------------------------------------------------------------------------


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
        self._speed = max_norm(self._targets) or 1.0
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

    def _slips(self, twist: Floats) -> Floats:
        """Weighted slips (n, 2) of all contacts."""
        return (self._rows @ twist - self._targets).reshape(-1, 2)

    def _tracked(self, regime: Regime, unknowns: Floats, loads: Floats) -> tuple[Regime, Floats]:
        """With forces of all loaded contacts that nearly stick."""
        moves = self._slips(unknowns[:3])
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
            pinned[k] = max_norm(rows @ together - goals) <= RESIDUAL * self._speed
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
        moves = self._slips(unknowns[:3])
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
            small = max_norm(self._rows @ step[:3]) <= SETTLED * self._speed
            if small and np.abs(step[3 : regime.end]).max(initial=0.0) <= SETTLED:
                return self._proved(regime, unknowns, loads, system[0][:3, :3])
        return None

    def _system(self, regime: Regime, unknowns: Floats, loads: Floats) -> tuple[Floats, Floats, Floats] | None:
        """Jacobian and residuals of balance (3), slips (2t) and lengths of forces; and the units e_i or forces (n, 2).

        None where a contact that the regime does not know nearly sticks.
        """
        slips = self._slips(unknowns[:3])
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


# ---- the minimizer of D where strips cut some friction ellipses ----------------------------------
#
# One after the other along a path: Newton steps.
#
# With ``X = mu_R r`` and ``Y = mu_S s`` a contact is on one of four pieces
# (:mod:`nonsmooth.symbolic.mechanics.friction_set`)::
#
#     on the arc     force (X, Y)/sqrt(X^2 + Y^2)                    (1 - kappa^2) Y^2 <= kappa^2 X^2
#     at a corner    force (sqrt(1 - kappa^2) sgn X, kappa sgn Y)    beyond that, X != 0
#     it rolls       X = 0, force (f, kappa sgn Y)                   |f| <= sqrt(1 - kappa^2)
#     it sticks      X = Y = 0, force (f, g)                         the same, |g| <= kappa
#
# The force is continuous where arc and corner meet.  Contacts that roll, as omniwheels mostly do along their rims, or
# stick keep ``N f`` and ``N g`` as unknowns beside the twist, so that each step is linear in them.  A contact at a
# corner that comes to ``X = 0`` rolls, one that rolls and comes to ``Y = 0`` sticks, and one whose f or g is too large
# slips to the side of it.  D is convex: where all forces balance and are those of their slips, the twist is a
# minimizer, and the only one where D is strictly convex.


CUT_STEPS = 30  # of Newton's method with all changes of what rolls; beside the last minimum three or four
HELD = 1e-13  # of the load, and of the largest speed: what is left where contacts hold one motion together
ROLLS = 1e-9  # the same: an X or Y that is rounding of the other method


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
        self._speed = max_norm(self._goals) or 1.0
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
        move = math.inf
        for _ in range(CUT_STEPS):
            slips = self._pairs @ unknowns - self._goals
            before, arcs = arcs, self._on_arcs(slips)
            if norms(slips[arcs & loaded]).min(initial=self._speed) < STUCK * self._speed:
                return None
            found = self._step(loads, slips, arcs)
            if found is None:
                return None
            step, forces, lack = found
            turned = self._first_turned(slips, step, loaded & (self._cut < 1) & ~arcs)
            if turned is not None:  # as far as there, where it begins to roll or stick
                share, contact, axis = turned
                unknowns, self._sides[contact, axis], move = unknowns + share * step, 0.0, math.inf
                continue
            unknowns = unknowns + step
            excess = np.abs(forces) - self._limits
            if excess.max() > 0:
                contact, axis = divmod(int(excess.argmax()), 2)
                self._sides[contact, axis], move = np.sign(forces[contact, axis]), math.inf
                continue
            last, move = move, max_norm(self._pairs @ step)
            # where drag alone bends D, rounding of the forces keeps steps from becoming smaller
            is_rounding = move >= last and lack <= HELD * loads.sum()
            if (move <= SETTLED * self._speed or is_rounding) and np.array_equal(arcs, before):
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

    def _step(self, loads: Floats, slips: Floats, arcs: Mask) -> tuple[Floats, Floats, float] | None:
        """A step of the twist in scaled units, and forces of contacts that roll or stick (n, 2); None if singular.

        With them what all forces lack before the step to balance each other.
        Contacts that hold one motion together, such as wheels with their rims on one line, take equal shares of their
        limits: the least of all forces that balance.
        """
        held = (self._sides == 0) & ~arcs[:, None] & (loads > 0)[:, None] & (self._cut < 1)[:, None]
        forces = self._limits * self._sides
        sizes = np.where(arcs, norms(slips), 1.0)
        sizes[sizes == 0] = 1.0  # without load
        units = slips / sizes[:, None]
        forces[arcs] = units[arcs]
        turned = units[:, :1] * self._pairs[:, 1] - units[:, 1:] * self._pairs[:, 0]
        rows = self._pairs[held]
        matrix, right = np.zeros((3 + len(rows),) * 2), np.zeros(3 + len(rows))
        matrix[:3, :3] = (turned.T * np.where(arcs, loads / sizes, 0.0)) @ turned
        limits = (loads[:, None] * self._limits)[held]
        matrix[3:, :3], matrix[:3, 3:] = rows, rows.T * limits
        right[:3] = -(forces * loads[:, None]).ravel() @ self._pairs.reshape(-1, 3)
        right[3:] = -slips[held]
        try:
            found = np.asarray(np.linalg.solve(matrix, right), np.float64)
        except np.linalg.LinAlgError:
            found = np.asarray(np.linalg.lstsq(matrix, right)[0], np.float64)
            if (np.abs(matrix @ found - right) > HELD * np.repeat([loads.sum(), self._speed], [3, len(rows)])).any():
                return None
        unknown = np.zeros_like(slips)
        unknown[held] = found[3:] * self._limits[held]
        return (found[:3], unknown, max_norm(matrix[:3, :3] @ found[:3])) if are_finite(found) else None

    def _first_turned(self, slips: Floats, step: Floats, slipping: Mask) -> tuple[float, int, int] | None:
        """The share of a step at which a slip first leaves its side, of which contact, and along 0 or across 1.

        Those at a corner leave that of X, and those that roll that of Y.  One that is off its side already, and stays
        as it is, leaves it at once.
        """
        change = self._pairs @ step
        left = ((slips + change) * self._sides < 0) & slipping[:, None]
        left[:, 1] &= self._sides[:, 0] == 0
        if not left.any():
            return None
        shares = np.where(left, np.clip(-slips / np.where(change == 0, np.inf, change), 0.0, 1.0), np.inf)
        contact, axis = divmod(int(shares.argmin()), 2)
        return float(shares[contact, axis]), contact, axis
