"""A rigid plate on springs that push and do not pull, pressed until its weight is carried: an oracle of loads."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from tests.oracles.floats import Floats

SETTLED = 1e-13  # of the balances


def pressed(moments: Floats, heights: Floats, stiffness: Floats, centre: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Loads of springs ``N_i = k_i (m_i . y - h_i)`` where that is positive, by Newton steps with halving.

    Args:
        moments: ``m_i = (1, p_i)``, shape (n, 3).
        heights: ``h_i``, shape (n,); how much lower than the others.
        stiffness: ``k_i``, shape (n,).
        centre: the centre of mass; the weight is one.
    """
    goal = np.array([1.0, *centre])
    y: Floats = np.asarray(np.linalg.lstsq(moments, heights + 1, rcond=None)[0], float)

    def rest(y: Floats) -> tuple[Floats, Floats]:
        loads: Floats = stiffness * np.maximum(moments @ y - heights, 0)
        return loads, np.asarray(moments.T @ loads - goal)

    for _ in range(300):
        loads, residual = rest(y)
        if np.abs(residual).max() < SETTLED:
            return loads
        active = loads > 0
        hessian = (moments[active].T * stiffness[active]) @ moments[active] + 1e-12 * np.eye(3)
        step, share = np.linalg.solve(hessian, residual), 1.0
        while share > 1e-6 and np.linalg.norm(rest(y - share * step)[1]) >= np.linalg.norm(residual):
            share /= 2
        y = y - share * step
    raise AssertionError("the springs do not settle")


def least_energy(places: Floats, stiffness: Floats, heights: Floats, centre: Floats) -> Floats:
    """``min sum (N_i - k_i e_i)^2/(2 k_i)`` over the loads that balance, by a general method that knows no springs."""
    moments = np.column_stack([np.ones(len(places)), places])
    found = minimize(
        lambda n: ((n - stiffness * heights) ** 2 / stiffness).sum() / 2,
        np.full(len(places), 1 / len(places)),
        jac=lambda n: n / stiffness - heights,
        bounds=[(0, None)] * len(places),
        constraints=[{"type": "eq", "fun": lambda n: n @ moments - [1.0, *centre], "jac": lambda n: moments.T}],
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 400},
    )
    return np.asarray(found.x)
