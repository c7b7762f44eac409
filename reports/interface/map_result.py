"""Where many starts of an array end, as a script or a notebook holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.basins import MAX_GRID, GridRun
from nonsmooth.reports.interface.argument_error import ArgumentError
from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.interface.shown_result import ShownResult
from nonsmooth.reports.settle_maps import ShownMap, build_map

if TYPE_CHECKING:
    from nonsmooth.reports.body_maps import ShownBodyMap
    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class MapResult(ShownResult):
    """Where, when and at which heading the bodies of a grid of starts end; shares are sampled.

    Attributes:
        shown: the cells or the body, what was mapped, and what was found.
    """

    shown: ShownMap | ShownBodyMap

    def __repr__(self) -> str:
        return short_lines(f"{self.shown.title}: {self.shown.summary()} (sampled)", self.shown.shares)


def map_scene(scene: Scene, grid: int, heading: float, until: float | None, kinematics: str) -> MapResult:
    """Follow a grid of starts; see :meth:`nonsmooth.reports.interface.array.Array.map`.

    Raises:
        ArgumentError: for a grid, a heading or a last time that cannot be used.
        RefusalError: where the motion is not determined.
    """
    if not 2 <= grid <= MAX_GRID:
        raise ArgumentError(f"grid: required 2 to {MAX_GRID} starts in a row, received {grid}")
    if not math.isfinite(heading):
        raise ArgumentError(f"heading: required a finite number (radian), received {heading}")
    if until is not None and not 0 < until < math.inf:
        raise ArgumentError(f"until: required a positive number, received {until}")
    run = GridRun(grid, heading, until, Kinematics(kinematics))
    if scene.body is not None:
        from nonsmooth.reports.body_maps import build_body_map

        return MapResult(build_body_map(scene, run))
    partition = build_partition(scene)
    return MapResult(ShownMap(partition, run, build_map(partition, run)))
