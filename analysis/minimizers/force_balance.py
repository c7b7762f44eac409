"""Friction forces that balance exactly and stay inside their limits: what makes a dual value a proof.

A solver's multipliers balance only to its tolerance.  The repair moves them by the least change, measured in units of
the room that each force has left (a force at its limit may turn but not grow), so that ``sum_k f_k a_k = 0`` to
rounding; then all are scaled down together by the largest excess over a limit.  The result is admissible, so that
``sum_k f_k b_k`` is a lower bound of D, whatever the solver did.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats
from nonsmooth.analysis.minimizers.dissipation import Functional, share_of_limit, usage

BALANCED = 1e-14  # relative imbalance that is rounding: nothing to repair
NEGLIGIBLE = 1e-40  # share of a limit that is zero: a force so small balances nothing
TURNING = 1e-2  # room of a force at its ellipse to turn: the forces of sticking wheels move first
PASSES = 3  # each pass repairs all but the rounding of the one before


def imbalance(model: ContactRows, forces: Floats) -> Floats:
    """Largest entry of ``sum_k f_k a_k`` relative to ``sum_k |f_k|`` times the column's largest entry.

    Force and moment are measured alike; forces (..., n, 2), result (...).
    """
    flat = forces.reshape(*forces.shape[:-2], len(model.rows))
    scale = np.abs(flat).sum(axis=-1)[..., None] * np.abs(model.rows).max(axis=0)
    total = np.abs(flat @ model.rows)
    return np.asarray(np.divide(total, scale, out=np.zeros_like(total), where=scale > 0).max(axis=-1))


def leaking_power(model: ContactRows, forces: Floats, twists: Floats) -> Floats:
    """Power of what is left unbalanced, ``|sum_k f_k a_k|``, in a motion as fast as the twist and the surfaces.

    The lower bound ``sum_k f_k b_k`` of D is off by no more; forces (m, n, 2), twists (m, 3), result (m,).
    """
    total = np.abs(forces.reshape(*forces.shape[:-2], len(model.rows)) @ model.rows)
    columns = np.abs(model.rows).max(axis=0)
    speeds = np.abs(model.targets).max(axis=-1, keepdims=True) / np.where(columns > 0, columns, 1.0)
    return np.asarray((total * (np.abs(twists) + speeds)).sum(axis=-1))


def balance_forces(functional: Functional, model: ContactRows, loads: Floats, forces: Floats) -> Floats:
    """Admissible, balanced forces (m, n, 2) next to the given ones, for loads (m, n)."""
    shares = share_of_limit(model, loads, forces)
    shares = np.where(np.isfinite(shares), shares, 0.0)
    limits, sets = model.limits(loads), functional.unit_sets(model)
    for _ in range(PASSES):
        for k in np.flatnonzero(imbalance(model, shares * limits) > BALANCED):
            along, across = shares[k].T
            shares[k] = _repaired(sets.room(along, across, TURNING), limits[k], model.rows, shares[k])
    shares = np.where(np.abs(shares) > NEGLIGIBLE, shares, 0.0)
    excess = usage(functional, model, loads, shares * limits).max(axis=-1)
    return np.asarray(shares * limits / np.maximum(1.0, excess)[:, None, None])


def _repaired(room: Floats, limits: Floats, rows: Floats, shares: Floats) -> Floats:
    """Shares (n, 2) moved by ``-room u`` with the smallest u that balances the forces."""
    sizes = np.abs(rows).max(axis=0)
    weighted = limits.reshape(-1, 1) * rows / np.where(sizes > 0, sizes, 1.0)
    movable = (room @ weighted.reshape(-1, 2, 3)).reshape(-1, 3)
    step, *_ = np.linalg.lstsq(movable.T, shares.reshape(-1) @ weighted)
    return np.asarray(shares - (room @ step.reshape(-1, 2, 1))[..., 0])
