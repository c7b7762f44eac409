"""Forces of contacts that stick, where balance leaves a choice: the largest of them as small as possible.

Lawson's algorithm (1961): minimize ``sum_k weight_k |f_k|^2`` subject to balance, multiply each weight by ``|f_k|``,
and again.  The largest force falls towards the least possible; ``sqrt(sum_k weight_k |f_k|^2)`` of weights that add up
to one is a bound from below.  It ends as soon as it is known whether all forces can be at most one.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats

STEPS = 60


def smallest_forces(maps: Floats, forces: Floats) -> Floats:
    """Forces (k, 2) with the same ``sum_k maps_k^T f_k`` as the given ones, for maps (k, 2, 3)."""
    flat = maps.reshape(-1, 3).T
    total = flat @ forces.ravel()
    weights, best = np.full(len(forces), 1 / len(forces)), forces
    for _ in range(STEPS):
        roots = np.repeat(1 / np.sqrt(np.maximum(weights, 1e-12)), 2)
        found = (roots * np.linalg.lstsq(flat * roots, total, rcond=1e-12)[0]).reshape(-1, 2)
        sizes = np.sqrt((found**2).sum(axis=1))
        if sizes.max() < np.sqrt((best**2).sum(axis=1)).max():
            best = found
        if sizes.max() <= 1 or weights @ sizes**2 > 1:
            return best
        weights = weights * sizes
        weights /= weights.sum()
    return best
