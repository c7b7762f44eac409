"""Paths of the program's own simulator from very close to an equilibrium: they share the cells with the verdicts alone.

The fan of cones decides stability from leading terms, which hold at every scale.  So a few paths are followed from
starts very close to the equilibrium, and what matters is whether one of them comes to a fixed share of the checked
square: a fan whose distances diverge takes a start of 1e-12 there within few turns, one of the order ``eps^(1/2)`` per
cone does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.symbolic.numbers.plane import XY

STARTS = 4
CLOSE = 2.0**-40  # of the half side of the square: the distance of the starts
CLOSER = 2.0**-20  # of the half side: where paths begin that may leave
FAR = 1 / 16  # of the half side: nothing that starts so close to a stable point may come there
CROSSINGS = 8.0  # of the square, at the least speed: as long as a path is followed


@dataclass(frozen=True)
class NearPath:
    """One of them.

    Attributes:
        start: measured from the equilibrium.
        farthest: its largest distance from the equilibrium.
        last: its distance at the end.
    """

    start: XY
    farthest: float
    last: float


def paths_from(partition: Partition, starts: Sequence[XY]) -> Iterator[NearPath]:
    """Follow the open loop of a centred, complete partition; what follows it is loaded only here."""
    import numpy as np

    from nonsmooth.analysis.fields.constant_field import array_field
    from nonsmooth.analysis.fields.kinematics import Kinematics
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.analysis.trajectories.trajectory import simulate

    radius = partition.scene.check.half_width
    speeds = [math.hypot(float(t.vx), float(t.vy)) for cell in partition.cells for t in cell.twists if any(t.velocity)]
    if not speeds:
        return
    until = CROSSINGS * radius / min(speeds)
    field = array_field(partition, Kinematics.EXACT)
    for x, y in starts:
        try:
            path = simulate(field, (x, y, 0.0), until)
        except TrajectoryError:  # the simulator gives up: that says nothing about the verdict
            continue
        distances = np.hypot(path.array[:, 0], path.array[:, 1])
        yield NearPath((x, y), float(distances.max()), float(distances[-1]))


def starts_around(partition: Partition, distance: float, count: int = STARTS) -> list[XY]:
    """Starts evenly around the equilibrium, at a distance in units of the half side of the square."""
    radius = distance * partition.scene.check.half_width
    angles = [2 * math.pi * (k + 0.3) / count for k in range(count)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def starts_on_borders(partition: Partition) -> list[XY]:
    """Starts on the borders of the cells that meet at the equilibrium, close to it.

    A solution that leaves may do so along such a border only.
    """
    radius, starts = CLOSER * partition.scene.check.half_width, []
    for cell in partition.cells:
        corners = [(float(x), float(y)) for x, y in cell.polygon.vertices]
        if (0.0, 0.0) in corners:
            k = corners.index((0.0, 0.0))
            for x, y in (corners[k - 1], corners[(k + 1) % len(corners)]):
                scale = 2.0 ** math.floor(math.log2(radius / math.hypot(x, y)))  # a power of two rounds nothing
                starts.append((x * scale, y * scale))
    return list(dict.fromkeys(starts))
