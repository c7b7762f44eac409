"""A rigid plate on springs that push and do not pull, pressed until its weight is carried: an oracle of loads."""

from __future__ import annotations

import numpy as np

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
