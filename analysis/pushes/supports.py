"""The block of the measured pushes: where it stands, and what its supports carry.

Three points carry a load that statics determines: ``sum N_i = 1, sum N_i p_i = c``.  Lengths are metres, in the block's
frame with its origin at a corner.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats

CENTRE_OF_MASS = (0.05, 0.05)
RHO = 0.05 * math.sqrt(2)  # radius of gyration by which the source weighs moments (metres)
SUPPORTS = {
    1: ((0.03, 0.03), (0.06333, 0.04333), (0.04333, 0.06333)),
    2: ((0.01, 0.01), (0.01, 0.13), (0.13, 0.01)),
    3: ((0.03, 0.03), (0.09, 0.03), (0.03, 0.09)),
    4: ((0.01, 0.01), (0.09, 0.03), (0.01, 0.13)),
}


def support_points(support_set: int) -> Floats:
    """The supports measured from the centre of mass, shape (3, 2).

    Raises:
        KeyError: for a set that is none of 1 to 4.
    """
    return np.array(SUPPORTS[support_set]) - np.array(CENTRE_OF_MASS)


def support_loads(points: Floats) -> Floats:
    """What three points carry of a weight of 1 above the origin, shape (3,).

    Raises:
        ValueError: where the origin lies outside their triangle, or they are collinear.
    """
    moments = np.vstack([np.ones(3), points.T])
    try:
        loads = np.linalg.solve(moments, [1.0, 0.0, 0.0])
    except np.linalg.LinAlgError:
        raise ValueError("required three points that are not collinear, received collinear ones") from None
    if loads.min() < 0:
        raise ValueError(f"required a centre of mass above the supports, received the loads {loads.tolist()}")
    return np.asarray(loads)
