"""At which equilibria the paths of a map end: sampled ends beside the exact equilibria of the same cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.trajectories.maps import SettleMap
from nonsmooth.analysis.trajectories.result import EndReason

AT = 1e-6  # of the half side of the square: a path that ends within it of a place ends there
STAYS = (EndReason.REST, EndReason.TURNING, EndReason.APPROACH)


def places_reached(partition: Partition, places: Sequence[RestPlace], ends: SettleMap) -> NDArray[np.int_]:
    """For every start the number of the place where its path ends, shape (m,); -1 for none.

    Args:
        partition: the cells.
        places: their equilibria.
        ends: where paths of the same cells end, in the same coordinates.
    """
    reached = np.full(len(ends.starts), -1)
    reasons = [reason for reason, _ in ends.ends]
    stays = np.array([reason in STAYS for reason in reasons])[ends.basin]
    circles = np.array([reason is EndReason.CIRCLES for reason in reasons])[ends.basin]
    within = AT * float(partition.scene.check.radius)
    for k, place in enumerate(places):
        at = stays & (_distance(ends.points, place.points) <= within)
        if place.place is EquilibriumPlace.CENTRE:
            # an orbit inside a cell with one twist is a circle about the point where that twist vanishes
            cell = next(cell for cell in partition.cells if cell.index == place.cells[0])
            at |= circles & (_distance(ends.points, cell.polygon.vertices) == 0)
        reached[at & (reached < 0)] = k
    return reached


def _distance(points: Floats, corners: Sequence[Point]) -> Floats:
    """Distance of points (m, 2) to a point, a segment or a convex polygon, shape (m,); infinite where unknown."""
    shape = np.array([[float(x), float(y)] for x, y in corners])
    nearest = np.full(len(points), np.inf)
    inside = np.full(len(points), len(shape) > 2)
    for start, end in zip(shape, np.roll(shape, -1, axis=0), strict=True):
        along, away = end - start, points - start
        length = max(float(along @ along), np.finfo(float).tiny)
        foot = np.clip(away @ along / length, 0, 1)
        nearest = np.fmin(nearest, np.hypot(*(away - foot[:, None] * along).T))
        inside &= along[0] * away[:, 1] - along[1] * away[:, 0] >= 0
    return np.where(inside, 0.0, nearest)
