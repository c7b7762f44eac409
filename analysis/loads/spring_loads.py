"""Loads of equal springs in floats, for many centres of mass or many bodies at once (total weight 1).

Loads solve ``min |N|^2`` subject to ``sum N_i = 1, sum N_i p_i = c, N >= 0``.  With ``m_i = (1, p_i)`` the optimality
conditions are ``N_i = max(0, m_i . y)`` and ``sum N_i m_i = (1, c)``: a piecewise linear equation in the three unknowns
y, the gradient of a convex function.  Newton's method on the loaded wheels ends after a few steps because there are
finitely many pieces; a step that overshoots is halved, and the Hessian of fewer than three loaded wheels, or of wheels
on one line, is made regular by a tiny multiple of the identity.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, max_norm, max_norms, row_products, squared_norms

MAX_STEPS = 60  # Newton steps; random arrays of 3 to 100 wheels need at most 15
MAX_HALVINGS = 40  # a step halved that often no longer changes a double
RESIDUAL = 1e-13  # of the balances, for columns of order one, in units of 1 + |y|: what rounding of y leaves
REGULAR = 1e-13  # multiple of the identity (the Hessian of all wheels): slows the steps by this share
ROUNDING = 1e-14  # relative: energies closer than this are equal in doubles
LOAD_ERROR = 1e-9  # of the weight and its moment: what balances
LOADED = 2.0**-30  # of the weight: what a wheel that is named as loaded carries at least


def spring_loads(moments: Floats, goals: Floats, start: Floats | None = None) -> tuple[Floats, Mask]:
    """Loads (m, n), and where they were found, (m,).

    Args:
        moments: ``m_i`` of order one, of one array (n, 3), or of one for every goal (m, n, 3); zero beside a body.
        goals: ``sum N_i m_i``, (m, 3).
        start: y (m, 3) where all wheels carry; found where it is not given.
    """
    y = _newton_step(moments, np.ones((len(goals), moments.shape[-2])), goals) if start is None else start.copy()
    values = _values(moments, y)
    waiting, solved, carried = np.arange(len(goals)), np.zeros(len(goals), bool), moments
    for _ in range(MAX_STEPS):
        at, aims, forces = y[waiting], goals[waiting], np.maximum(values[waiting], 0.0)
        gradient = _balance(carried, forces) - aims
        left = max_norms(gradient) > RESIDUAL * (1 + max_norms(at))
        solved[waiting[~left]] = True
        if not left.any():
            break
        waiting, at, aims, forces, carried = waiting[left], at[left], aims[left], forces[left], _taken(carried, left)
        step = _newton_step(carried, forces, -gradient[left])
        y[waiting], values[waiting], whole = _descended(carried, aims, at, forces, step)
        same = whole & ((values[waiting] > 0) == (forces > 0)).all(axis=1)
        solved[waiting[same]] = True  # the equation was linear between them
        waiting, carried = waiting[~same], _taken(carried, ~same)
        if not len(waiting):
            break
    loads = np.maximum(values, 0.0)
    missing = goals - _balance(moments, loads)  # the rounding of y, of which the loads need no part
    solved &= np.abs(missing).max(axis=1, initial=0.0) <= LOAD_ERROR * (1 + np.abs(goals).max(axis=1, initial=0.0))
    return np.maximum(loads + (loads > 0) * _values(moments, _newton_step(moments, loads, missing)), 0.0), solved


def loaded_wheels(positions: Floats, point: Floats) -> frozenset[int] | None:
    """The places of the wheels that carry a body at a point; None where no loads are found.

    Proposals that exact conditions then confirm.

    Args:
        positions: ``p_i``, shape (n, 2).
        point: the centre of mass, shape (2,).
    """
    levers = positions - point
    scale = max_norm(levers) or 1.0
    loads, solved = spring_loads(np.column_stack([np.ones(len(levers)), levers / scale]), np.array([[1.0, 0.0, 0.0]]))
    return frozenset(np.flatnonzero(loads[0] > LOADED).tolist()) if solved[0] else None


def _taken(moments: Floats, chosen: Mask) -> Floats:
    """Those of some goals."""
    return moments if moments.ndim == 2 else moments[chosen]


def _values(moments: Floats, y: Floats) -> Floats:
    """``m_i . y``, (m, n)."""
    return y @ moments.T if moments.ndim == 2 else (moments @ y[..., None])[..., 0]


def _balance(moments: Floats, loads: Floats) -> Floats:
    """``sum N_i m_i``, (m, 3)."""
    return loads @ moments if moments.ndim == 2 else (loads[:, None] @ moments)[:, 0]


def _newton_step(moments: Floats, forces: Floats, right: Floats) -> Floats:
    """Solve ``sum over loaded wheels of m_i m_i^T`` times x = right, for forces (m, n) and right sides (m, 3)."""
    loaded = (forces > 0).astype(float)
    if moments.ndim == 2:
        hessian = (loaded @ (moments[:, :, None] * moments[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3)
    else:
        hessian = (loaded[..., None] * moments).transpose(0, 2, 1) @ moments
    return np.asarray(np.linalg.solve(hessian + REGULAR * np.eye(3), right[..., None])[..., 0])


def _descended(moments: Floats, goals: Floats, y: Floats, forces: Floats, step: Floats) -> tuple[Floats, Floats, Mask]:
    """Y after steps that are halved until the convex function no longer rises, ``m_i . y``, and which are whole."""
    size = np.ones(len(y))
    before = _energy(goals, y, forces)
    highest = before + ROUNDING * np.abs(before)
    for _ in range(MAX_HALVINGS):
        there = y + size[:, None] * step
        values = _values(moments, there)
        rises = _energy(goals, there, np.maximum(values, 0.0)) > highest
        if not rises.any():
            break
        size[rises] /= 2
    return there, values, size == 1


def _energy(goals: Floats, y: Floats, forces: Floats) -> Floats:
    """``1/2 sum_i max(0, m_i . y)^2 - goal . y``."""
    return 0.5 * squared_norms(forces) - row_products(goals, y)
