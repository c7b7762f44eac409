"""Which wheels of identical springs carry at a point, in floats: proposals that exact conditions then confirm.

With ``m_i = (1, p_i)`` the loads ``N_i = max(0, m_i . y)`` minimize ``|N|^2`` where y minimizes the convex function
``sum max(0, m_i . y)^2/2 - y . (1, c)``.  Newton steps with halving find it also where the loaded wheels lie on a line
and the body may tilt about it.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]

STEPS, HALVINGS = 100, 30
TILT = 2.0**-40  # of the Hessian of all wheels: keeps a step finite where the loaded ones do not fix the body
SETTLED = 2.0**-40  # of the balance, for a weight of one
LOADED = 2.0**-30  # of the weight


def loaded_wheels(positions: Floats, point: Floats) -> frozenset[int] | None:
    """The places of the wheels that carry a body at a point; None where no loads are found.

    Args:
        positions: ``p_i``, shape (n, 2).
        point: the centre of mass, shape (2,).
    """
    scale = float(np.abs(positions - point).max()) or 1.0
    moments = np.column_stack([np.ones(len(positions)), (positions - point) / scale])
    goal = np.array([1.0, 0.0, 0.0])
    y, floor = goal.copy(), TILT * moments.T @ moments
    for _ in range(STEPS):
        loads = np.maximum(moments @ y, 0.0)
        slope = moments.T @ loads - goal
        if np.abs(slope).max() < SETTLED:
            return frozenset(int(k) for k in np.flatnonzero(loads > LOADED))
        active = moments[loads > 0]
        step = np.linalg.solve(active.T @ active + floor, slope)
        y = _halved(moments, goal, y, step)
    return None


def _halved(moments: Floats, goal: Floats, y: Floats, step: Floats) -> Floats:
    """The first of the steps 1, 1/2, 1/4, ... back that lowers the function."""

    def value(at: Floats) -> float:
        return float((np.maximum(moments @ at, 0.0) ** 2).sum() / 2 - at @ goal)

    here = value(y)
    for halving in range(HALVINGS):
        trial = y - step / 2**halving
        if value(trial) < here:
            return np.asarray(trial)
    return np.asarray(y - step / 2**HALVINGS)
