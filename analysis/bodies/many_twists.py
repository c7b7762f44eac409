"""Twists that dissipate the least under many poses at once, in floats: ``D = sum_i N_i |w_i|``, slightly smoothed.

``w_i = W_i x - t_i`` is the slip of contact i, weighted by its friction, and ``x = (c', size theta')``.  The norms are
smoothed to ``rho_i = sqrt(|w_i|^2 + g^2)``, so that contacts may stick: the twist moves by the order of g.  Newton's
method on ``rho_i z_i = w_i`` with the forces ``z_i`` as unknowns of their own (Chan, Golub and Mulet 1999) settles in a
few steps from the twist of the step before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats

STEPS = 25  # of Newton's method at one g
SHARPER = 0.2  # from one g to the next
LOST = 1e3  # a step that is so many times as fast leads nowhere
SMOOTHING = 1e-6  # g, of the fastest wheel's speed times friction
SMOOTHING_OF_ROLLERS = 1e-4  # the same where D is linear in pieces, and its least value lies in corners
COARSE = 1e-2  # g up to which a twist that settled counts, where it does not with less
SETTLED = 1e-7  # step after which it ends, in the same unit
REGULAR = 1e-13  # multiple of the identity beside a Hessian, of its trace


class ManyTwists:
    """Minimizers, each from the one of the step before."""

    def __init__(self, speed: float, *, rollers: bool) -> None:
        """For contacts whose weighted targets are at most ``speed``, some of which may have rollers that turn."""
        self._unit = speed or 1.0
        self._smoothing = SMOOTHING_OF_ROLLERS if rollers else SMOOTHING

    def minimize(self, rows: Floats, targets: Floats, loads: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """``x`` of shape (m, d), and whether it settled.

        Args:
            rows: weighted, (m, k, 2, d).
            targets: weighted, (m, k, 2).
            loads: (m, k).
            start: (m, d).
        """
        flat = rows.reshape(len(rows), -1, rows.shape[-1])
        found, settled = self._settle(flat, targets, loads, start, self._smoothing)
        again = np.flatnonzero(~settled)
        if len(again):
            found[again], settled[again] = self._from_smooth(flat[again], targets[again], loads[again])
        return found, settled

    def _from_smooth(self, flat: Floats, targets: Floats, loads: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """From rest, with g large at first: there Newton's method settles from afar."""
        found, smoothing = np.zeros((len(flat), flat.shape[2])), 1.0
        known = np.zeros(len(flat), bool)
        while True:
            smoothing = max(smoothing, self._smoothing)
            nearer, settled = self._settle(flat, targets, loads, found, smoothing)
            found = np.where(settled[:, None], nearer, found)
            known |= settled & (smoothing <= COARSE)
            if smoothing <= self._smoothing:
                return found, known
            smoothing *= SHARPER

    def _settle(
        self, flat: Floats, targets: Floats, loads: Floats, start: Floats, smoothing: float
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Newton's method at one g."""
        found, settled = start.copy(), np.zeros(len(start), bool)
        at = np.arange(len(start))
        forces: Floats | None = None
        aims, weights = targets, loads
        for _ in range(STEPS):
            x = found[at]
            step, forces = self._step(flat, aims, weights, x, forces, smoothing)
            found[at] = x + step
            sizes = np.abs(step).max(axis=1)
            settled[at[sizes <= SETTLED * self._unit]] = True
            going = (sizes > SETTLED * self._unit) & (sizes < LOST * self._unit)
            if not going.any():
                break
            at, flat, aims, weights, forces = at[going], flat[going], aims[going], weights[going], forces[going]
        return found, settled & np.isfinite(found).all(axis=1)

    def _step(
        self, flat: Floats, targets: Floats, loads: Floats, x: Floats, forces: Floats | None, smoothing: float
    ) -> tuple[Floats, Floats]:
        """The Newton step (m, d), and the forces after it, kept in their unit discs (m, k, 2)."""
        slips = (flat @ x[..., None]).reshape(targets.shape) - targets
        sizes = np.sqrt(_inner(slips, slips) + (smoothing * self._unit) ** 2)
        units = slips / sizes[..., None]
        z = units if forces is None else forces
        pull = loads / sizes
        gradient = (flat.transpose(0, 2, 1) @ (loads[..., None] * units).reshape(len(x), -1, 1))[..., 0]
        # sum of N/rho W^T (1 - sym(z w^T)/rho) W
        whole = flat.reshape(*targets.shape, -1)
        first, second = whole[:, :, 0], whole[:, :, 1]
        along_w = units[..., :1] * first + units[..., 1:] * second
        along_z = (pull * z[..., 0])[..., None] * first + (pull * z[..., 1])[..., None] * second
        weighted = np.repeat(pull, 2, axis=1)[..., None] * flat
        mixed = along_z.transpose(0, 2, 1) @ along_w
        hessian = flat.transpose(0, 2, 1) @ weighted - (mixed + mixed.transpose(0, 2, 1)) / 2
        trace = np.trace(hessian, axis1=1, axis2=2)
        hessian += (REGULAR * np.abs(trace) + 1e-300)[:, None, None] * np.eye(x.shape[1])
        step = -np.linalg.solve(hessian, gradient[..., None])[..., 0]
        moved = (flat @ step[..., None]).reshape(targets.shape)
        z = units + (moved - z * _inner(units, moved)[..., None]) / sizes[..., None]
        z /= np.maximum(np.sqrt(_inner(z, z)), 1.0)[..., None]
        return np.asarray(step, float), z


def _inner(first: Floats, second: Floats) -> Floats:
    """Inner products over the last axis, of length two: several times as fast as a sum over so short an axis."""
    return np.asarray(first[..., 0] * second[..., 0] + first[..., 1] * second[..., 1])


def with_rollers(rows: Floats, targets: Floats, loads: Floats, cuts: Floats) -> tuple[Floats, Floats, Floats]:
    """The same as sums of norms where strips cut the ellipses: one more unknown ``t_i``, how fast rollers turn.

    The support function of the cut ellipse is ``min over t of |w - t e_2| + cut |t|``.

    Args:
        rows: weighted by the half-axes, (m, k, 2, 3).
        targets: weighted, (m, k, 2).
        loads: (m, k).
        cuts: (m, k), 1 where nothing is cut.

    Returns:
        rows (m, 2k, 2, 3 + k), targets (m, 2k, 2) and loads (m, 2k).
    """
    m, k = loads.shape
    wide = np.zeros((m, 2 * k, 2, 3 + k))
    wide[:, :k, :, :3] = rows
    which = np.arange(k)
    wide[:, which, 1, 3 + which] = -1.0
    wide[:, k + which, 1, 3 + which] = cuts
    return wide, np.concatenate([targets, np.zeros_like(targets)], axis=1), np.concatenate([loads, loads], axis=1)


def turning_rollers(rows: Floats, targets: Floats, cuts: Floats, x: Floats) -> Floats:
    """The ``t`` (m, k) that are least at twists x (m, 3)."""
    along, across = np.moveaxis((rows @ x[:, None, :, None])[..., 0] - targets, -1, 0)
    kept = np.abs(along) * cuts / np.sqrt(np.maximum(1 - cuts**2, 1e-12))
    return np.asarray(np.sign(across) * np.maximum(np.abs(across) - kept, 0.0))
