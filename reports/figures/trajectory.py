"""A trajectory as a picture: x, y and theta over time, and the path over the cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.trajectories.result import Event, EventKind, Trajectory
from nonsmooth.reports.figures.cell_map import TINT, figure_bytes, motion_colors, require_drawable
from nonsmooth.reports.figures.labels import WIDE_TITLE, centre_labels, pose_labels, time_label, wrapped
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

SIZE = (8.0, 4.6)  # inches
TALL = (8.0, 7.0)  # with the speeds of a closed loop
PATH = "#0072B2"
LINES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222", "#999999")  # Okabe and Ito
MOST_NAMED = 8  # wheels up to which the lines of their speeds are told apart
MARKERS = {  # a form for every kind, so that color is not needed to tell them apart
    EventKind.CROSS: "|",
    EventKind.SLIDE: "s",
    EventKind.LEAVE: "^",
    EventKind.ENTER: "<",
    EventKind.TIPS: "X",
    EventKind.REST: "o",
    EventKind.NONUNIQUE: "D",
    EventKind.LIMIT: "v",
    EventKind.FREE: "P",
}
SAMPLES = 400  # times at which the curves are drawn
SMALL = 0.2  # of the half-width of the square: a path that keeps to less is drawn enlarged
MARGIN = 1.3  # half-width of the enlarged view in units of the path's extent
MOST_MARKS = 60  # events that are marked, evenly among all: accumulating switches would cover the curve


@dataclass(frozen=True, eq=False)
class SpeedCurves:
    """The speeds of the wheels in a closed loop.

    Attributes:
        times: shape (m,).
        speeds: shape (m, n); nan where a law gives a wheel none.
        limits: the largest speeds, by the number of the wheel.
    """

    times: NDArray[np.float64]
    speeds: NDArray[np.float64]
    limits: Mapping[int, float]


def trajectory_figure(
    partition: Partition, trajectory: Trajectory, suffix: str, law: str = "", speeds: SpeedCurves | None = None
) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map, ``law`` names that of a closed loop."""
    require_drawable(partition)
    return figure_bytes(lambda: build_figure(partition, trajectory, law, speeds), suffix)


def build_figure(
    partition: Partition, trajectory: Trajectory, law: str = "", speeds: SpeedCurves | None = None
) -> Figure:
    """The picture as a Matplotlib figure: the pose over time, the path, and under both the speeds of a closed loop."""
    from matplotlib.figure import Figure

    rows = 3 if speeds is None else 5
    figure = Figure(figsize=SIZE if speeds is None else TALL, layout="constrained")
    grid = figure.add_gridspec(rows, 2, width_ratios=(1, 1.1))
    curves = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    units = partition.scene.units
    if speeds is not None:
        _draw_speeds(figure.add_subplot(grid[3:, :]), speeds, partition)
    home = (*(float(x) for x in partition.scene.check.equilibrium), 0.0)
    draw_curves(curves, trajectory, pose_labels(units), time_label("t", units), home)
    _draw_path(figure.add_subplot(grid[:3, 1]), partition, trajectory)
    name = one_line(partition.scene.name)
    title = f"{name}: rule {partition.rule}, {trajectory.kinematics} kinematics, method {trajectory.method}"
    title = f"{title}\n{law}" if law else title
    figure.suptitle(wrapped(title, WIDE_TITLE), fontsize="medium", parse_math=False)
    explain(figure, trajectory)
    return figure


def _draw_speeds(axes: Axes, curves: SpeedCurves, partition: Partition) -> None:
    """The speeds over time, a line for each wheel that acts at some time, and dashed lines at their limits."""
    units, numbers = partition.scene.units, [wheel.index for wheel in partition.scene.wheels]
    acting = [k for k in range(curves.speeds.shape[1]) if np.isfinite(curves.speeds[:, k]).any()]
    axes.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    for place, k in enumerate(acting):
        color = LINES[place % len(LINES)]
        axes.plot(curves.times, curves.speeds[:, k], color=color, linewidth=1.4, label=f"u_{numbers[k]}")
        axes.plot(curves.times, curves.speeds[:, k], ".", color=color, markersize=1.5)
    shown = curves.speeds[:, acting]
    largest = float(np.nanmax(np.abs(shown), initial=0.0))
    for limit in sorted({curves.limits[numbers[k]] for k in acting if numbers[k] in curves.limits}):
        if limit <= 1.2 * largest:
            for side in (-limit, limit):
                axes.axhline(side, color=INK, linewidth=0.9, linestyle="--")
    axes.set(xlabel=time_label("t", units), ylabel=f"speeds u_i [{units.speed or 'speed'}]")
    axes.margins(x=0.02, y=0.12)
    if 0 < len(acting) <= MOST_NAMED:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")


def draw_curves(
    curves: Sequence[Axes],
    trajectory: Trajectory,
    labels: Sequence[str],
    time: str = "t [time]",
    home: Sequence[float] = (),
) -> None:
    """The states over time, one under the other, with the events marked, and lines at ``home`` (zero unless given)."""
    times, states = _dense(trajectory)
    for k, axes in enumerate(curves):
        axes.axhline(home[k] if home else 0, color="0.8", linewidth=0.8, zorder=0)
        axes.plot(times, states[:, k], color=PATH, linewidth=1.6)
        for event in marked(trajectory.events):
            place = [float(event.t)], [float(event.state[k])]
            axes.plot(*place, marker=MARKERS[event.kind], color=INK, markersize=5, fillstyle="none", linestyle="none")
        axes.set_ylabel(labels[k])
        axes.margins(x=0.02, y=0.15)
        if axes is not curves[-1]:
            axes.tick_params(labelbottom=False)
            axes.sharex(curves[-1])
    curves[-1].set_xlabel(time)


def marked(events: Sequence[Event]) -> Sequence[Event]:
    """The events that are marked: all where they are few, else evenly many of them, the first and last among them."""
    if len(events) <= MOST_MARKS:
        return events
    return [events[round(k * (len(events) - 1) / (MOST_MARKS - 1))] for k in range(MOST_MARKS)]


def dense_times(trajectory: Trajectory) -> NDArray[np.float64]:
    """Times close enough together that curves look round."""
    return _dense(trajectory)[0]


def _dense(trajectory: Trajectory) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times and states close enough together that arcs look round; the samples themselves where there are no pieces."""
    times = np.array([float(t) for t in trajectory.times])
    if not trajectory.pieces:
        return times, trajectory.array
    finer = np.unique(np.concatenate([times, np.linspace(times[0], times[-1], SAMPLES)]))
    return finer, trajectory.sample(finer.tolist())


def _draw_path(axes: Axes, partition: Partition, trajectory: Trajectory) -> None:
    draw_cells(axes, partition)
    draw_path(axes, trajectory)
    axes.set(aspect="equal", **centre_labels(partition.scene.units))
    _enlarge(axes, partition, trajectory)


def _enlarge(axes: Axes, partition: Partition, trajectory: Trajectory) -> None:
    """Show the surroundings of a path that would be a dot in the square; the axes' numbers tell."""
    centre = np.array([float(x) for x in partition.scene.check.equilibrium])
    extent = float(np.abs(trajectory.array[:, :2] - centre).max())
    if 0 < extent < SMALL * float(partition.scene.check.radius):
        half = MARGIN * extent
        axes.set(xlim=(centre[0] - half, centre[0] + half), ylim=(centre[1] - half, centre[1] + half))


def draw_cells(axes: Axes, partition: Partition) -> None:
    """The cells in light colors, one color per motion, as ground for a path."""
    for cell, color in zip(partition.cells, motion_colors(partition), strict=True):
        xs, ys = zip(*((float(x), float(y)) for x, y in cell.polygon.vertices), strict=True)
        axes.fill(xs, ys, facecolor=color, alpha=TINT / 2, edgecolor="none", zorder=1)
        axes.fill(xs, ys, facecolor="none", edgecolor="white", linewidth=1.2, zorder=2)


def draw_path(axes: Axes, trajectory: Trajectory) -> None:
    """The path in the plane of the first two states, with the events marked."""
    _, path = _dense(trajectory)
    axes.plot(path[:, 0], path[:, 1], color=PATH, linewidth=1.8, zorder=3)
    axes.plot(*path[0, :2], marker=">", color=PATH, markersize=8, zorder=4)
    marked_events(axes, trajectory)


def marked_events(axes: Axes, trajectory: Trajectory, mark: str | None = None) -> None:
    """The events at their places, each kind with its form; their pieces carry the mark, if there is one."""
    for number, event in enumerate(marked(trajectory.events), 1):
        place = [[float(event.state[0])], [float(event.state[1])]]
        gid = None if mark is None else f"{mark}--event-{number}"
        axes.plot(*place, marker=MARKERS[event.kind], color=INK, markersize=6, fillstyle="none", zorder=4, gid=gid)


def explain(figure: Figure, trajectory: Trajectory, others: Sequence[Line2D] = ()) -> None:
    """The legend of what occurs."""
    from matplotlib.lines import Line2D

    kinds = dict.fromkeys(event.kind for event in trajectory.events)
    entries = [*others, Line2D([], [], marker=">", color=PATH, linestyle="none", label="start")]
    for kind in kinds:
        marker = MARKERS[kind]
        entries.append(Line2D([], [], label=str(kind), marker=marker, color=INK, fillstyle="none", linestyle="none"))
    figure.legend(handles=entries, loc="outside lower center", ncols=len(entries), frameon=False)
