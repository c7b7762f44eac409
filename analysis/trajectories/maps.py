"""Maps of where a body comes to rest: heading, arrival time and basin over many starts at once.

For cells with constant twist, under both kinematics; all starts are followed together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.batch_paths import DONE, BatchPaths, OnRow
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, float_points, following, grid_points, norms


@dataclass(frozen=True, repr=False)
class SettleMap(ShortRepr):
    """Ends of paths from m starts.

    Attributes:
        starts: (m, 2) positions.
        theta: heading at the end (radian), infinite where the body turns forever, not a number where nothing is known.
        arrival: time of arrival, infinite where an equilibrium is only approached or never reached.
        points: (m, 2) final positions.
        basin: number of the end in ``ends``.
        ends: reason and place of every kind of end that occurs.
        unique: whether no other solution branches off before the end; that theta may drift at rest is not counted.
    """

    starts: Floats
    theta: Floats
    arrival: Floats
    points: Floats
    basin: Indices
    ends: tuple[tuple[EndReason, str], ...]
    unique: Mask

    @property
    def settled(self) -> Mask:
        """Whether the heading has a limit where c comes to rest or approaches an equilibrium."""
        return self._ends_by(EndReason.REST, EndReason.APPROACH) & np.isfinite(self.theta)

    @property
    def arrived(self) -> Mask:
        """Whether c comes to rest in finite time (theta may turn on)."""
        return self._ends_by(EndReason.REST, EndReason.TURNING) & np.isfinite(self.arrival)

    def _ends_by(self, *reasons: EndReason) -> Mask:
        return np.array([reason in reasons for reason, _ in self.ends])[self.basin]

    @property
    def shares(self) -> tuple[float, ...]:
        """The share of the starts that has each kind of end."""
        return tuple(float(np.mean(self.basin == k)) for k in range(len(self.ends)))

    def seen_until(self, time: float) -> SettleMap:
        """What is known at a time: a start that arrives later is still on its way, to nowhere known.

        Ends that are never reached stay as they are.
        """
        late = np.isfinite(self.arrival) & (self.arrival > time)
        if not late.any():
            return self
        basin, ends = np.where(late, len(self.ends), self.basin), (*self.ends, (EndReason.TIME, ""))
        kept = np.unique(basin)
        return replace(
            self,
            theta=np.where(late, np.nan, self.theta),
            arrival=np.where(late, np.inf, self.arrival),
            points=np.where(late[:, None], np.nan, self.points),
            basin=np.searchsorted(kept, basin),
            ends=tuple(ends[k] for k in kept),
        )

    def record(self) -> dict[str, Any]:
        """JSON-ready; None for what is not finite."""
        return {
            "starts": self.starts.tolist(),
            "theta": _finite(self.theta),
            "arrival": _finite(self.arrival),
            "points": [_finite(point) for point in self.points],
            "basin": self.basin.tolist(),
            "ends": [{"reason": reason.value, "place": place} for reason, place in self.ends],
            "unique": self.unique.tolist(),
        }


def _finite(values: Floats) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]


def grid_starts(field: ConstantField, count: int) -> Floats:
    """``count x count`` starts, evenly over the bounding box of the domain, borders included; x runs first.

    Args:
        field: on its domain; shape of what is returned: (count^2, 2).
        count: starts in a row, and rows; two at least.

    Raises:
        ValueError: for fewer than two starts in a row.
    """
    if count < 2:
        raise ValueError(f"required at least two starts in a row, received {count}")
    corners = float_points(field.cells.points)
    return grid_points(*np.linspace(corners.min(axis=0), corners.max(axis=0), count).T)


def settle_map(field: ConstantField, starts: Floats, theta: float = 0.0, report: OnRow | None = None) -> SettleMap:
    """Follow every start to its end.

    Args:
        field: constant twists on polygons (exact numbers are rounded).
        starts: (m, 2) positions inside the domain.
        theta: initial heading of all.
        report: told from time to time how many of all starts have ended.

    Raises:
        ValueError: for a start outside the domain.
    """
    return settle_maps([(field, starts)], theta, report)[0]


def settle_maps(
    maps: Sequence[tuple[ConstantField, Floats]], theta: float = 0.0, report: OnRow | None = None
) -> list[SettleMap]:
    """Follow the starts of several fields to their ends, all together: see :func:`settle_map`."""
    fields = [field.floats() if field.exact else field for field, _ in maps]
    paths = BatchPaths(fields, [starts for _, starts in maps], theta)
    paths.run(report)
    last = np.cumsum([len(starts) for _, starts in maps])
    return [_map_of(paths, slice(end - len(starts), end)) for end, (_, starts) in zip(last, maps, strict=True)]


def _map_of(paths: BatchPaths, part: slice) -> SettleMap:
    """The paths of one field."""
    ends = paths.ends[part]
    kinds = dict.fromkeys(end for end in ends if end is not None)
    numbers = {end: k for k, end in enumerate(kinds)}
    basin = np.array([DONE if end is None else numbers[end] for end in ends], dtype=int)
    starts, theta, time = paths.starts[part], paths.theta[part], paths.time[part]
    return SettleMap(starts, theta, time, paths.points[part], basin, tuple(kinds), paths.unique[part])


# ---- at which equilibria the paths of a map end --------------------------------------------------


AT = 1e-6  # of the half side of the square: a path that ends within it of a place ends there
STAYS = (EndReason.REST, EndReason.TURNING, EndReason.APPROACH)


def places_reached(partition: Partition, places: Sequence[RestPlace], ends: SettleMap) -> Indices:
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
    within = AT * partition.scene.check.half_width
    for k, place in enumerate(places):
        at = stays & (_distance(ends.points, place.points) <= within)
        if place.place is EquilibriumPlace.CENTRE:
            # an orbit inside a cell with one twist is a circle about the point where that twist vanishes
            cell = next(cell for cell in partition.cells if cell.index == place.cells[0])
            at |= circles & (_distance(ends.points, place.points) <= _clearance(cell.polygon, place.points[0]) + within)
        reached[at & (reached < 0)] = k
    return reached


def _clearance(polygon: Polygon, point: Point) -> float:
    """Distance of a point inside a polygon from its border."""
    return min(float(side.slack(point)) / math.hypot(*map(float, side.normal)) for side in polygon.sides)


def _distance(points: Floats, corners: Sequence[Point]) -> Floats:
    """Distance of points (m, 2) to a point, a segment or a convex polygon, shape (m,); infinite where unknown."""
    shape = float_points(corners)
    nearest = np.full(len(points), np.inf)
    inside = np.full(len(points), len(shape) > 2)
    for start, end in zip(shape, following(shape), strict=True):
        along, away = end - start, points - start
        length = max(float(along @ along), np.finfo(float).tiny)
        foot = np.clip(away @ along / length, 0, 1)
        nearest = np.fmin(nearest, norms(away - foot[:, None] * along))
        inside &= along[0] * away[:, 1] - along[1] * away[:, 0] >= 0
    return np.where(inside, 0.0, nearest)
