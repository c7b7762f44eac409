"""Where many starts of an array or a plain system end, as a script or a notebook holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.reports.basins import MAX_GRID, GridRun
from nonsmooth.reports.interface.argument_error import ArgumentError
from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.interface.shown_result import ShownResult
from nonsmooth.reports.settle_maps import ShownMap, build_map

if TYPE_CHECKING:
    from nonsmooth.reports.body_maps import ShownBodyMap
    from nonsmooth.reports.plain_systems.starts_map import SystemMap
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, repr=False)
class MapResult(ShownResult):
    """Where, when and at which heading the bodies of a grid of starts end, or solutions of a system; sampled.

    Attributes:
        shown: the cells, the body or the system, what was mapped, and what was found.
    """

    shown: ShownMap | ShownBodyMap | SystemMap

    def __repr__(self) -> str:
        contradicted = [("contradiction", one.text) for one in getattr(self.shown, "contradictions", ())]
        return short_lines(f"{self.shown.title}: {self.shown.summary()} (sampled)", [*self.shown.shares, *contradicted])


def map_scene(scene: Scene, grid: int, heading: float, until: float | None, kinematics: str) -> MapResult:
    """Follow a grid of starts; see :meth:`nonsmooth.reports.interface.array.Array.map`.

    Raises:
        ArgumentError: for a grid, a heading or a last time that cannot be used.
        RefusalError: where the motion is not determined, or cells are so thin that floats lose their borders.
    """
    _require_grid(grid)
    if not math.isfinite(heading):
        raise ArgumentError(f"heading: required a finite number (radian), received {heading}")
    if until is not None:
        _require_until(until)
    run = GridRun(grid, heading, until, Kinematics(kinematics))
    if scene.body is not None:
        from nonsmooth.reports.body_maps import build_body_map

        return MapResult(build_body_map(scene, run))
    partition = build_partition(scene)
    try:
        return MapResult(ShownMap(partition, run, build_map(partition, run)))
    except TrajectoryError as error:
        place = str(error).removesuffix(": please report this")
        required = "required cells that floats tell apart, to follow paths"
        raise RefusalError(f"{required}, received thinner ones ({place})") from None


def map_system(system: SwitchedSystem, grid: int, until: float) -> MapResult:
    """Follow a grid of starts; see :meth:`nonsmooth.reports.interface.system.System.map`.

    Raises:
        ArgumentError: for a grid or a last time that cannot be used.
        SceneError: for another number of states than two, and for arbitrary switching.
    """
    from nonsmooth.reports.phase_portrait import PhasePortrait
    from nonsmooth.reports.plain_systems.starts_map import build_system_map

    _require_grid(grid)
    _require_until(until)
    return MapResult(build_system_map(PhasePortrait(system), grid, until))


def _require_grid(grid: int) -> None:
    if not 2 <= grid <= MAX_GRID:
        raise ArgumentError(f"grid: required 2 to {MAX_GRID} starts in a row, received {grid}")


def _require_until(until: float) -> None:
    if not 0 < until < math.inf:
        raise ArgumentError(f"until: required a positive number, received {until}")
