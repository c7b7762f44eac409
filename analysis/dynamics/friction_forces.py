"""Friction of all wheels as one force and one torque on the body, with derivatives: the friction ellipse, regularized.

With slips ``r = d . v(p) - u`` and ``s = n . v(p)`` the associated law of the friction ellipse is minus the gradient of
the dissipation, ``f = -N (mu_R^2 r, mu_S^2 s)/sqrt(mu_R^2 r^2 + mu_S^2 s^2)``: among all forces of the ellipse the one
that takes the most power from the slip.  At r = s = 0 every force of the ellipse is allowed (stick).  An integrator
needs a function, so the root becomes ``sqrt(mu_R^2 r^2 + mu_S^2 s^2 + (mu e)^2)`` with ``mu = max(mu_R, mu_S)`` and a
creep speed e: the force stays inside the ellipse, reaches 99 % of its limit at a slip of ``7 e`` along the axis of more
friction, and a wheel that should stick creeps at a speed of order e.  The law is then the gradient of a smooth convex
function, so friction never gives power to the slip and its derivative with respect to velocity is symmetric and at
most zero.

Velocities are those of the centre of mass, ``(w, omega)`` with ``w = c' = v + omega J c``; the point of the body over
wheel i moves with ``w + omega J (p_i - c)``.  So rows depend on c (their moment arm) and never on theta.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.plane_arrays import turned


class Wrench(NamedTuple):
    """Friction on the body at one state, in units of its weight.

    Attributes:
        total: force and torque about the centre of mass ``(F_x, F_y, tau)``, shape (3,).
        by_centre: derivative with respect to c, shape (3, 2), loads included.
        by_velocity: derivative with respect to ``(w, omega)``, shape (3, 3), symmetric, at most zero.
    """

    total: Floats
    by_centre: Floats
    by_velocity: Floats


class EllipseFriction:
    """The regularized friction ellipse of an array.

    Attributes:
        model: the contacts.
        creep: the speed e (length/time), above zero.
    """

    def __init__(self, model: ContactModel, creep: float) -> None:
        self.model, self.creep = model, creep
        self._frames = np.ascontiguousarray(model.rows[:, :2])  # d_1, n_1, d_2, n_2, ...
        self._turned = turned(self._frames)
        self._squares = model.friction.reshape(-1, 2) ** 2
        self._rounding = self._squares.max(axis=1) * creep**2
        self._rounding[self._rounding == 0] = 1.0  # a wheel without friction: its force is zero in any case

    def rows(self, centre: Floats) -> Floats:
        """Rows ``(e, e . J(p_i - c))`` for e = d_i, n_i, acting on ``(w, omega)``; shape (2n, 3)."""
        offsets = self.model.positions - centre  # first, so that an array far from the origin loses no digits
        arms = -(self._turned.reshape(-1, 2, 2) @ offsets[..., None]).reshape(-1)
        return np.column_stack([self._frames, arms])

    def forces(self, centre: Floats, velocity: Floats, loads: Floats) -> Floats:
        """Forces along and across every rim, shape (n, 2)."""
        slips = self.rows(centre) @ velocity - self.model.targets
        pull, size = self._pull(slips)
        return -loads[:, None] * pull / size[:, None]

    def wrench(self, centre: Floats, velocity: Floats, loads: Floats, slope: Floats) -> Wrench:
        """Total friction and its derivatives; ``slope`` is the derivative of the loads (n, 2) with respect to c."""
        rows = self.rows(centre)
        pull, size = self._pull(rows @ velocity - self.model.targets)
        share = -pull / size[:, None]  # force per load
        forces = (loads[:, None] * share).reshape(-1)
        total = rows.T @ forces
        pairs = rows.reshape(-1, 2, 3)
        weight = loads / size
        bent = np.einsum("ni,nij->nj", share, pairs)
        by_velocity = np.einsum("n,nj,nk->jk", weight, bent, bent)
        by_velocity -= np.einsum("n,ni,nij,nik->jk", weight, self._squares, pairs, pairs)
        # a slip changes with c as its row's moment arm does, by omega J e
        shift = velocity[2] * self._turned.reshape(-1, 2, 2)
        by_slip = np.einsum("n,nj,ni->nji", weight, bent, share)
        by_slip -= np.einsum("n,nij,ni->nji", weight, pairs, self._squares)
        by_centre = np.einsum("nji,nik->jk", by_slip, shift) + bent.T @ slope
        by_centre[2] += self._turned.T @ forces
        return Wrench(total, by_centre, by_velocity)

    def _pull(self, slips: Floats) -> tuple[Floats, Floats]:
        """``(mu_R^2 r, mu_S^2 s)``, shape (n, 2), and the regularized root, shape (n,)."""
        pairs = slips.reshape(-1, 2)
        pull = self._squares * pairs
        return pull, np.sqrt((pull * pairs).sum(axis=1) + self._rounding)
