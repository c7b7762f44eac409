"""Paths from many starts in one picture: each is a set of marked pieces, of which a page shows one at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.figures.cell_map import figure_bytes, require_drawable, view_square
from nonsmooth.reports.figures.labels import WIDE_TITLE, pose_labels, time_label, wrapped
from nonsmooth.reports.figures.path import ARRAY, PATH, fill_cells, marked_events
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def start_mark(number: int) -> str:
    """What is about the third start carries the mark ``start-3``."""
    return f"start-{number}"


def starts_figure(partition: Partition, paths: Sequence[Trajectory], suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    require_drawable(partition)
    return figure_bytes(lambda: build_figure(partition, paths), suffix)


def build_figure(partition: Partition, paths: Sequence[Trajectory]) -> Figure:
    """The picture as a Matplotlib figure: x, y and theta over time, and the paths over the cells."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=ARRAY, layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.1))
    curves = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    plane = figure.add_subplot(grid[:, 1])
    fill_cells(plane, partition)
    view_square(plane, partition)
    last = max(float(path.times[-1]) for path in paths)
    for number, path in enumerate(paths, 1):
        _draw_curves(curves, path, start_mark(number), last)
        _draw_path(plane, path, start_mark(number))
    _label(curves, partition)
    name = one_line(partition.scene.name)
    figure.suptitle(
        wrapped(f"{name}: rule {partition.rule}, {len(paths)} starts", WIDE_TITLE), fontsize="medium", parse_math=False
    )
    return figure


def _draw_curves(curves: list[Axes], path: Trajectory, mark: str, last: float) -> None:
    """x, y and theta of one path; where the body has come to rest it stays until the ``last`` time of all paths."""
    times = np.array([float(t) for t in path.times])
    states = path.array
    if times[-1] < last:
        times, states = np.append(times, last), np.vstack([states, states[-1:]])
    for k, axes in enumerate(curves):
        axes.plot(times, states[:, k], color=PATH, linewidth=1.6, gid=f"{mark}--{'xyt'[k]}")


def _draw_path(axes: Axes, path: Trajectory, mark: str) -> None:
    states = path.array
    axes.plot(states[:, 0], states[:, 1], color=PATH, linewidth=1.8, zorder=3, gid=f"{mark}--path")
    axes.plot(*states[0, :2], marker=">", color=PATH, markersize=8, zorder=4, gid=f"{mark}--start")
    marked_events(axes, path, mark)


def _label(curves: list[Axes], partition: Partition) -> None:
    units, home = partition.scene.units, (*(float(x) for x in partition.scene.check.equilibrium), 0.0)
    for k, axes in enumerate(curves):
        axes.axhline(home[k], color="0.6", linewidth=0.6, zorder=0)
        axes.set_ylabel(pose_labels(units)[k])
        axes.tick_params(labelbottom=k == 2)
    curves[2].set_xlabel(time_label("t", units))
