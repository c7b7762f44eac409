"""Where the contact rules agree: exact shares of area with the same motion.

Rules ``nearest`` and ``box`` both give polygons with constant twists, so the share of the square on which they agree
is a sum of areas of intersections, exact like the cells.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from nonsmooth.analysis.partition import Cell, Partition
from nonsmooth.analysis.polygon import Polygon
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.lazy import Lazy
from nonsmooth.symbolic.number_field import Number


@dataclass(frozen=True)
class SharedArea:
    """Area on which two partitions of one square prescribe the same set of twists.

    Attributes:
        area: the common area.
        share: divided by the square's area.
        shared_twists: twists that own common area.
    """

    area: Number | Lazy
    share: Number | Lazy
    shared_twists: tuple[Twist, ...]


def intersect(first: Polygon, second: Polygon) -> Polygon | None:
    """Intersection of two convex polygons; None when it has no area."""
    common = first
    for side in second.sides:
        clipped = common.clipped(side)
        if clipped is None:
            return None
        common = clipped
    return common


def shared_area(first: Partition, second: Partition) -> SharedArea:
    """Exact area of agreement of two partitions of the same square."""
    by_motion: dict[frozenset[Twist], list[Cell]] = defaultdict(list)
    for cell in second.cells:
        by_motion[frozenset(cell.twists)].append(cell)
    total: Number | Lazy = first.scene.field.zero
    twists: dict[Twist, None] = {}
    for cell in first.cells:
        for other in by_motion.get(frozenset(cell.twists), []):
            common = intersect(cell.polygon, other.polygon)
            if common is not None:
                total = total + common.area
                twists.update(dict.fromkeys(cell.twists))
    return SharedArea(total, total / first.domain.area, tuple(twists))
