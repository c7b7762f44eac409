"""Arrays of rule ``box`` with a checked point at which exact coincidences meet: a corner of their own cells.

There twists tie, slopes of D vanish, loads are at the border of zero, or frictions balance.  The corners come from the
workbench; the verdicts about them are compared with paths that do not use the cells.
"""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.symbolic.mechanics.scene import Contact
from nonsmooth.symbolic.numbers.lazy import Lazy
from tests.conftest import WheelData
from tests.oracles.nearest_paths import Wheel
from tests.oracles.tied_arrays import SPEEDS, Pair, circle_point, rotated

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from tests.conftest import Arrays

FRICTIONS: list[Pair] = [
    (Fraction(1), Fraction(1, 2)),
    (Fraction(1), Fraction(1, 5)),
    (Fraction(1), Fraction(1, 10)),
    (Fraction(1), Fraction(1)),
    (Fraction(1, 2), Fraction(1)),
]
TURNS: list[Pair] = [(Fraction(1), Fraction(0)), (Fraction(3, 5), Fraction(4, 5)), (Fraction(4, 5), Fraction(3, 5))]
AXES: list[Pair] = [(Fraction(a), Fraction(b)) for a, b in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def box_wheels(rng: random.Random) -> list[Wheel]:
    """Four wheels: opposite pairs on a circle with rims turned alike, or the corners of a square with any rims."""
    roll, side = rng.choice(FRICTIONS)
    on_circle = rng.random() < 0.7
    if on_circle:
        half = [circle_point(rng), circle_point(rng)]
        points = [*half, *((-x, -y) for x, y in half)]
    else:
        points = [(Fraction(a), Fraction(b)) for a in (1, -1) for b in (1, -1)]
    turn = rng.choice([TURNS[0], *TURNS, circle_point(rng)])
    wheels = []
    for x, y in points:
        direction = rotated((-x, -y), turn) if on_circle else rng.choice([circle_point(rng), *AXES])
        speed = rng.choice([Fraction(1), Fraction(1), Fraction(1), rng.choice(SPEEDS)])
        wheels.append(Wheel((x, y), direction, speed, roll, side))
    return wheels


def box_scene(arrays: Arrays, wheels: list[Wheel], at: Pair, radius: Fraction) -> Scene:
    """The scene of rule ``box``, seen from the checked point."""
    data = [WheelData(w.position, w.direction, w.speed, (w.roll, w.side)) for w in wheels]
    scene = arrays.scene(data, radius=radius, at=at)
    return replace(scene, contact=Contact("box")).recentred()


def tied_box(arrays: Arrays, seed: int) -> tuple[list[Wheel], Pair, Partition]:
    """Wheels, a checked point at a rational corner of their cells (or the origin), and the cells about it."""
    rng = random.Random(seed)
    while True:
        wheels = box_wheels(rng)
        size = rng.choice((Fraction(1, 4), Fraction(3, 5)))
        if len({wheel.position for wheel in wheels}) < len(wheels):
            continue
        try:
            whole = build_box_partition(box_scene(arrays, wheels, (Fraction(0), Fraction(0)), size))
            at = rng.choice(_rational_corners(whole, size))
            partition = build_box_partition(box_scene(arrays, wheels, at, size / 16))
        except RefusalError:  # the square leaves the support polygon
            continue
        return wheels, at, partition


def _rational_corners(partition: Partition, size: Fraction) -> list[Pair]:
    found: list[Pair] = [(Fraction(0), Fraction(0))]
    for point in partition.complex.points:
        values = [None if isinstance(x, Lazy) else x.as_rational() for x in point]
        if None not in values:
            x, y = (Fraction(str(value)) for value in values)
            if max(abs(x), abs(y)) < size:
                found.append((x, y))
    return found
