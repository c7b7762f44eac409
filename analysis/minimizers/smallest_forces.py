"""Forces of contacts that stick, where balance leaves a choice: the largest of them as small as possible.

Two contacts: a parabola each along a line.  More: Lawson's algorithm (1961).  Minimize ``sum_k weight_k |f_k|^2``
subject to balance, multiply each weight by ``|f_k|``, and again: the largest force falls towards the least possible,
``sqrt(sum_k weight_k |f_k|^2)`` of weights that add up to one is a bound from below, and it ends where both are close.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats

STEPS = 100
CLOSE = 1.002  # ratio of the largest force to its least value
DEPENDENT = 1e-10  # singular value, relative to the largest, of a choice


def smallest_forces(maps: Floats, forces: Floats) -> Floats:
    """Forces (k, 2) with the same ``sum_k maps_k^T f_k`` as the given ones, for maps (k, 2, 3)."""
    flat = maps.reshape(-1, 3).T
    if len(forces) == 2:
        _, sizes, frame = np.linalg.svd(flat)
        choices = frame[int((sizes > DEPENDENT * sizes[0]).sum()) :]
        if len(choices) == 1:
            return _on_line(forces, choices[0].reshape(2, 2))
    return _lawson(flat, forces)


def _on_line(forces: Floats, way: Floats) -> Floats:
    """The best of ``forces + t way``: lowest point of one parabola, or where both meet."""
    bends, slopes, values = (way**2).sum(axis=1), (forces * way).sum(axis=1), (forces**2).sum(axis=1)
    lowest = [-slope / bend for slope, bend in zip(slopes, bends, strict=True) if bend > 0]
    meeting = np.roots([bends[0] - bends[1], 2 * (slopes[0] - slopes[1]), values[0] - values[1]])
    places = np.array([*lowest, *meeting[np.isreal(meeting)].real])
    largest = (bends * places[:, None] ** 2 + 2 * slopes * places[:, None] + values).max(axis=1)
    return np.asarray(forces + places[largest.argmin()] * way)


def _lawson(flat: Floats, forces: Floats) -> Floats:
    """For maps (3, 2k) side by side."""
    total = flat @ forces.ravel()
    weights, best = np.full(len(forces), 1 / len(forces)), forces
    for _ in range(STEPS):
        roots = np.repeat(1 / np.sqrt(np.maximum(weights, 1e-12)), 2)
        found = (roots * np.linalg.lstsq(flat * roots, total, rcond=1e-12)[0]).reshape(-1, 2)
        sizes = np.sqrt((found**2).sum(axis=1))
        if sizes.max() < np.sqrt((best**2).sum(axis=1)).max():
            best = found
        if sizes.max() <= CLOSE * np.sqrt(weights @ sizes**2):
            return best
        weights = weights * sizes
        weights /= weights.sum()
    return best
