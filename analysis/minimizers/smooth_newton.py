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
(:class:`nonsmooth.analysis.minimizers.ellipse_minimizer.WarmInterior`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.smallest_forces import smallest_forces

STEPS = 15  # a start beside the last minimum needs three or four
NEAR = 0.01  # of the fastest wheel's speed: contacts that slip less keep their forces
STUCK = 1e-4  # the same: where another contact slips less, the other method is left to it
RESTS = 1e-9  # the same: a slip that is rounding of the other method
SETTLED = 1e-9  # change of a slip and of a force; the error after it is its square over the slips
RESIDUAL = 1e-13  # slip of contacts that stick, of the fastest wheel's speed
SINGULAR = 1e-10  # ratio of the extreme eigenvalues of a Hessian, columns scaled, below which it may be singular
SLOWEST = 1 / 16  # of the way from the last loads to the next
LOST = 1e6  # a slip that is so many times as fast leads nowhere
CHANGES = 6  # of contacts that stick for contacts that slip, before the other method is asked


@dataclass(frozen=True, eq=False)
class _Solution:
    """A twist, and the contacts (t,) that nearly stick: forces (t, 2), slips s (t,), and which stick (t,)."""

    twist: Floats
    contacts: NDArray[np.int_]
    forces: Floats
    slips: Floats
    sticks: NDArray[np.bool_]

    @property
    def lacks(self) -> Floats:
        """``1 - |f|^2`` of contacts that stick, s of those that slip: negative where there is no such friction."""
        return np.where(self.sticks, 1 - (self.forces**2).sum(axis=1), self.slips)


class SmoothNewton:
    """Minimizers of one set of contacts at loads near each other."""

    def __init__(self, model: ContactModel) -> None:
        """For a model whose friction sets are whole ellipses.

        Raises:
            ValueError: where a strip cuts one.
        """
        if (model.cuts < 1).any():
            raise ValueError("required whole friction ellipses")
        self._rows = model.friction[:, None] * model.rows
        self._targets = model.friction * model.targets
        self._pairs = self._rows.reshape(-1, 2, 3)
        self._first, self._second = self._rows[::2], self._rows[1::2]
        self._speed = float(np.abs(self._targets).max()) or 1.0
        self._scale = np.abs(self._rows).max(axis=0)  # of the columns: v and omega have different units
        self._scale[self._scale == 0] = 1.0
        self._last: _Solution | None = None
        self._last_loads = np.zeros(model.wheels)

    @property
    def is_ready(self) -> bool:
        """Whether the last minimum is known."""
        return self._last is not None

    @property
    def validity(self) -> float:
        """Of the last twist: negative where it continues a regime beyond its end, then it is no minimizer."""
        return -np.inf if self._last is None else float(self._last.lacks.min(initial=np.inf))

    def start_from(self, twist: Floats, loads: Floats) -> None:
        """Begin at a twist that another method found."""
        self._last_loads = loads
        nobody = np.zeros(0, int)
        self._last = _Solution(twist, nobody, np.zeros((0, 2)), np.zeros(0), np.zeros(0, bool))

    def minimize(self, loads: Floats) -> Floats | None:
        """The twist at loads (n,); None where it is not proved to be the minimizer."""
        if self._last is None:
            return None
        start = self._tracked(self._last, loads)
        self._last = None
        for _ in range(CHANGES):
            found = self._settled(start, loads, proof=True)
            if found is None:
                return None
            wrong = found.lacks < 0
            if not wrong.any():
                self._last, self._last_loads = found, loads
                return found.twist
            start = _changed(found, wrong)
        return None

    def continued(self, loads: Floats, *, proof: bool) -> Floats | None:
        """The twist with the same contacts sticking as before, even where a force or a slip forbids it.

        The loads of unloaded contacts are zero; others may be negative.  None, and nothing changed, where it is lost,
        or where no proof is found that no other twist would be as good and one is asked for.
        """
        assert self._last is not None
        now, done, pace = self._last, 0.0, 1.0
        while done < 1:
            pace = min(pace, 1 - done)
            here = loads + (1 - done - pace) * (self._last_loads - loads)
            found = self._settled(self._tracked(now, here), here, proof=proof)
            if found is not None:
                now, done = found, done + pace
            elif pace > SLOWEST:
                pace /= 2
            else:
                return None
        self._last, self._last_loads = now, loads
        return now.twist

    def _tracked(self, last: _Solution, loads: Floats) -> _Solution:
        """The last solution with forces of all loaded contacts that nearly stick."""
        slips = (self._rows @ last.twist - self._targets).reshape(-1, 2)
        sizes = np.sqrt(slips[:, 0] ** 2 + slips[:, 1] ** 2)
        near = (sizes < NEAR * self._speed) & (loads != 0)
        kept = last.contacts
        if len(kept):
            near[kept] |= (last.sticks | (last.slips < 0)) & (loads[kept] != 0)
        contacts = np.flatnonzero(near)
        if np.array_equal(contacts, kept):
            return last
        sizes[sizes == 0] = np.finfo(float).tiny
        forces, along, sticks = slips / sizes[:, None], sizes.copy(), sizes <= RESTS * self._speed
        forces[kept], along[kept], sticks[kept] = last.forces, last.slips, last.sticks
        return _Solution(last.twist, contacts, forces[contacts], along[contacts], sticks[contacts])

    # ---- Newton's method -------------------------------------------------------------------------

    def _settled(self, start: _Solution, loads: Floats, *, proof: bool) -> _Solution | None:
        """The solution with these contacts sticking and slipping; signs are not looked at."""
        others, now = loads.copy(), start
        others[start.contacts] = 0.0
        pulls = loads[start.contacts]
        for _ in range(STEPS):
            derivatives = self._derivatives(now.twist, others)
            if derivatives is None:
                return None
            gradient, hessian = derivatives
            step = _solved(*self._system(now, pulls, gradient, hessian), redundant=int(now.sticks.sum()) > 1)
            if step is None:
                return None
            now = _moved(now, step)
            small = np.abs(self._rows @ step[:3]).max() <= SETTLED * self._speed
            if small and np.abs(step[3 : 3 + 2 * len(pulls)]).max(initial=0.0) <= SETTLED:
                return self._proved(now, pulls, hessian) if proof or now.sticks.sum() > 1 else now
        return None

    def _derivatives(self, twist: Floats, loads: Floats) -> tuple[Floats, Floats] | None:
        """Gradient (3,) and Hessian (3, 3) of the contacts with loads; None where one of them nearly sticks."""
        slips = (self._rows @ twist - self._targets).reshape(-1, 2)
        along, across = slips[:, 0], slips[:, 1]
        sizes = np.sqrt(along * along + across * across)
        sizes[loads == 0] = self._speed
        if not STUCK * self._speed <= sizes.min() < LOST * self._speed:  # nan too
            return None
        along, across, pull = along / sizes, across / sizes, loads / sizes
        gradient = (loads * along) @ self._first + (loads * across) @ self._second
        turned = along[:, None] * self._second - across[:, None] * self._first
        return gradient, (pull[:, None] * turned).T @ turned

    def _system(self, now: _Solution, pulls: Floats, gradient: Floats, hessian: Floats) -> tuple[Floats, Floats]:
        """Jacobian and residuals of balance (3), slips (2t) and lengths of forces in (twist, forces, slips)."""
        if not len(pulls):
            return hessian, gradient
        rows, targets = self._pairs[now.contacts], self._targets.reshape(-1, 2)[now.contacts]
        flat, end = rows.reshape(-1, 3), 3 + 2 * len(pulls)
        slipping = np.flatnonzero(~now.sticks)
        matrix, right = np.zeros((end + len(slipping),) * 2), np.zeros(end + len(slipping))
        matrix[:3, :3], matrix[3:end, :3] = hessian, flat
        matrix[:3, 3:end] = (pulls[:, None, None] * rows).reshape(-1, 3).T
        right[:3] = gradient + matrix[:3, 3:end] @ now.forces.ravel()
        moves = np.where(now.sticks, 0.0, now.slips)[:, None] * now.forces
        right[3:end] = (rows @ now.twist - targets - moves).ravel()
        for row, k in enumerate(slipping, start=end):
            place, force = slice(3 + 2 * k, 5 + 2 * k), now.forces[k]
            matrix[3 + 2 * k, 3 + 2 * k] = matrix[4 + 2 * k, 4 + 2 * k] = -now.slips[k]
            matrix[place, row], matrix[row, place] = -force, force
            right[row] = (force @ force - 1) / 2
        return matrix, right

    # ---- what a solution is ------------------------------------------------------------------------

    def _proved(self, found: _Solution, pulls: Floats, hessian: Floats) -> _Solution | None:
        """The solution, where no other twist is as good; forces that leave a choice become small."""
        rows, sticks = self._pairs[found.contacts], found.sticks
        turned = found.forces[:, :1] * rows[:, 1] - found.forces[:, 1:] * rows[:, 0]
        held = np.concatenate([rows[sticks].reshape(-1, 3), turned[~sticks]]) / self._scale
        scaled = hessian / np.outer(self._scale, self._scale)
        if len(held):
            _, sizes, frame = np.linalg.svd(held)
            free = frame[int((sizes > SINGULAR).sum()) :]
            scaled = free @ scaled @ free.T if len(free) else np.eye(1)
        eigenvalues = np.linalg.eigvalsh(scaled)
        if not eigenvalues[0] > SINGULAR * eigenvalues[-1]:
            return None
        if sticks.sum() < 2 or (found.lacks[sticks] >= 0).all():
            return found if self._rest_of(found, sticks) else None
        forces = found.forces.copy()
        forces[sticks] = smallest_forces((pulls[:, None, None] * rows)[sticks], forces[sticks])
        return replace(found, forces=forces) if self._rest_of(found, sticks) else None

    def _rest_of(self, found: _Solution, sticks: NDArray[np.bool_]) -> bool:
        """Whether contacts that stick do."""
        stuck = found.contacts[sticks]
        slips = self._pairs[stuck] @ found.twist - self._targets.reshape(-1, 2)[stuck]
        return bool(np.abs(slips).max(initial=0.0) <= RESIDUAL * self._speed)


def _changed(found: _Solution, wrong: NDArray[np.bool_]) -> _Solution:
    """Contacts that cannot stick slip, and the other way round."""
    lengths = np.sqrt((found.forces**2).sum(axis=1))
    released = wrong & found.sticks
    forces = np.where(released[:, None], found.forces / np.maximum(lengths, 1e-300)[:, None], found.forces)
    return replace(found, forces=forces, slips=np.where(wrong, 0.0, found.slips), sticks=found.sticks ^ wrong)


def _moved(now: _Solution, step: Floats) -> _Solution:
    """After a Newton step."""
    if not len(now.contacts):
        return replace(now, twist=now.twist - step)
    end = 3 + 2 * len(now.contacts)
    slips = now.slips.copy()
    slips[~now.sticks] -= step[end:]
    return replace(now, twist=now.twist - step[:3], forces=now.forces - step[3:end].reshape(-1, 2), slips=slips)


def _solved(matrix: Floats, right: Floats, *, redundant: bool) -> Floats | None:
    """The Newton step; the shortest one where equations repeat each other."""
    try:
        if redundant:
            return np.asarray(np.linalg.lstsq(matrix, right, rcond=SINGULAR)[0])
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return None
