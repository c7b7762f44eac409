"""Where the trajectories of a report begin: one usual start, and others turned about the checked point."""

from __future__ import annotations

import math
from typing import TypeAlias

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.symbolic.number_text import float_text, place_text
from nonsmooth.symbolic.scene import Scene

Start: TypeAlias = tuple[float, float, float]  # x, y, theta

STARTS = 24
# Off the axes and diagonals, so that symmetric arrays have no tie there, in half-widths of the square from the
# checked point: (0.2, 0.4) for the paper's array.
USUAL = (0.4, 0.8)


def starts(partition: Partition) -> list[Start]:
    """STARTS places on a circle about the checked point, the usual one first, counterclockwise, at heading 0."""
    radius = float(partition.scene.check.radius)
    x, y = (float(value) for value in partition.scene.check.equilibrium)
    places = []
    for k in range(STARTS):
        c, s = math.cos(2 * math.pi * k / STARTS), math.sin(2 * math.pi * k / STARTS)
        along, up = USUAL[0] * c - USUAL[1] * s, USUAL[0] * s + USUAL[1] * c
        places.append((_typed(x + radius * along), _typed(y + radius * up), 0.0))
    return places


def start_text(start: Start) -> str:
    """``(0.2, 0.4, 0)``."""
    return place_text(start)


def typed_start(start: Start, scene: Scene) -> str:
    """``x,y,theta`` for ``--from``, which takes world coordinates; a report measures from the checked point."""
    x, y = (centre + value for centre, value in zip(map(float, scene.check.equilibrium), start, strict=False))
    return ",".join(map(float_text, (x, y, start[2])))


def _typed(value: float) -> float:
    """The value as a command line would hold it."""
    return float(float_text(value))
