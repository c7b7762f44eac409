"""Paths as pictures: the states over time, beside them the path in the plane, and below the speeds of a closed loop.

What lies under the path is its ground: the cells of a contact rule, the wheels and the body, or the switching surfaces
of a plain system.  Paths from many starts are one picture of marked pieces, of which a page shows one at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.trajectories.result import Event, EventKind, Trajectory
from nonsmooth.reports.figures.cells import fill_cells, view_square
from nonsmooth.reports.figures.style import (
    INK,
    LINES,
    PALETTE,
    TINT,
    TO_SHOW,
    centre_labels,
    drawn,
    legend_below,
    line_entry,
    mark_entry,
    new_figure,
    pose_labels,
    require_drawable,
    time_label,
    title_axes,
    title_figure,
)
from nonsmooth.reports.figures.wheels import draw_axis, draw_names, outline_of, placed
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.plane import in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norm, spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from nonsmooth.analysis.fields.sign_field import SignField
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

WIDE, ARRAY = 9.6, (8.0, 4.6)  # inches: width of a plain system's picture; size of an array's
LEAST_HEIGHT, CURVE = 5.6, 1.5  # inches: of a plain system's picture at least, of one of its curves
PLANE = 230.0  # points that the plane of an array's path is wide
TALL = 7.0  # inches: height with the speeds of a closed loop
PATH = "#0072B2"
IN_A_ROW = 5  # entries of the legend
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
MOST_MARKS = 60  # events that are marked, evenly among all: accumulating switches would cover the curve
SURFACE: dict[str, Any] = {"color": "#D55E00", "linestyle": "--"}
BESIDE: dict[str, Any] = {"color": "#D55E00", "linewidth": 1.4, "linestyle": "--"}
BODY: dict[str, dict[str, Any]] = {
    "body at the start": {"color": INK, "linewidth": 1.4, "linestyle": "--"},
    "body at the end": {"color": INK, "linewidth": 1.4},
}
CELL: dict[str, Any] = {"color": PALETTE[0], "alpha": TINT / 2, "linewidth": 9}
RIM: dict[str, Any] = {"color": "0.45", "linewidth": 4, "solid_capstyle": "butt"}

Ground = Callable[["Axes"], None]


@dataclass(frozen=True, eq=False)
class SpeedCurves:
    """The speeds of the wheels in a closed loop.

    Attributes:
        times: shape (m,).
        speeds: shape (m, n); nan where a law gives a wheel none.
        wheels: the numbers of the wheels (n).
        limits: the largest speeds, by the number of the wheel.
        labels: of the axes, time and speed.
    """

    times: Floats
    speeds: Floats
    wheels: Sequence[int]
    limits: Mapping[int, float]
    labels: tuple[str, str]


@dataclass(frozen=True, eq=False)
class PathPicture:
    """What a picture of a path shows.

    Attributes:
        trajectory: the path.
        title: over the picture.
        labels: of the states.
        time: label of the time.
        ground: draws what lies under the path in the plane of the first two states, and its labels and limits; None
            where there is no plane.
        home: values of the states at the checked point, zero unless given.
        speeds: of a closed loop.
        beside: another path to compare with, and its name.
        explained: names and styles of lines of the ground.
    """

    trajectory: Trajectory
    title: str
    labels: Sequence[str]
    time: str = "t [time]"
    ground: Ground | None = None
    home: Sequence[float] = ()
    speeds: SpeedCurves | None = None
    beside: tuple[Trajectory, str] | None = None
    explained: Mapping[str, dict[str, Any]] = field(default_factory=dict)


def trajectory_figure(partition: Partition, trajectory: Trajectory, suffix: str, law: str = "") -> bytes:
    """The picture of a path over cells as the bytes of a file.

    Args:
        partition: the cells.
        trajectory: the path.
        suffix: of the file, one of PICTURES.
        law: the name of that of a closed loop.
    """
    return drawn(path_figure, cells_picture(partition, trajectory, law))(suffix)


def cells_picture(
    partition: Partition, trajectory: Trajectory, law: str = "", speeds: SpeedCurves | None = None
) -> PathPicture:
    """A path of an array over its cells.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    scene = partition.scene
    require_drawable(scene)
    said = f"rule {partition.rule}, {trajectory.kinematics} kinematics, method {trajectory.method}"
    title = f"{one_line(scene.name)}: {said}" + (f"\n{law}" if law else "")
    picture = array_picture(scene, trajectory, title, lambda axes: draw_cells(axes, partition, trajectory), speeds)
    return replace(picture, explained={"cell (a color for each motion)": CELL})


def wheels_picture(
    scene: Scene, trajectory: Trajectory, title: str, beside: tuple[Trajectory, str] | None = None
) -> PathPicture:
    """A path of an array between its wheels, with the outline of the body; another path beside it."""
    picture = array_picture(scene, trajectory, title, lambda axes: draw_wheels(axes, scene, trajectory))
    return replace(picture, beside=beside, explained={"rim of a wheel": RIM} | (BODY if scene.body is not None else {}))


def centre_picture(scene: Scene, trajectory: Trajectory, law: str) -> PathPicture:
    """A path of a closed loop about the checked point."""
    title = f"{one_line(scene.name)}: rule {scene.contact.rule}, {law}"

    def ground(axes: Axes) -> None:
        axes.set(aspect="equal", **centre_labels(scene.units))
        axes.margins(0.2)

    return array_picture(scene, trajectory, title, ground)


def system_picture(system: SwitchedSystem, switching: SignField, trajectory: Trajectory, title: str) -> PathPicture:
    """A solution of a plain system, of two states over the switching surfaces."""
    states = system.stated_states
    if len(states) != 2:
        return PathPicture(trajectory, title, states)
    explained = {"switching surface": SURFACE} if switching.surfaces else {}

    def ground(axes: Axes) -> None:
        draw_surfaces(axes, system, switching, trajectory)

    return PathPicture(trajectory, title, states, ground=ground, explained=explained)


def array_picture(
    scene: Scene, trajectory: Trajectory, title: str, ground: Ground, speeds: SpeedCurves | None = None
) -> PathPicture:
    """A path of an array over any ground, in the units of the scene."""
    home = (*scene.check.place, 0.0)
    labels, time = pose_labels(scene.units), time_label("t", scene.units)
    return PathPicture(trajectory, title, labels, time, ground, home, speeds)


# ---- the picture ---------------------------------------------------------------------------------


def path_figure(picture: PathPicture) -> Figure:
    """The states over time, the path in the plane, and under both the speeds of a closed loop."""
    states, has_plane = len(picture.labels), picture.ground is not None
    size = ARRAY if picture.home else (WIDE, max(LEAST_HEIGHT, CURVE * states))
    figure = new_figure(size[0], size[1] if picture.speeds is None else TALL)
    rows = states if picture.speeds is None else states + 2
    shares = {"width_ratios": (1, 1.1)} if picture.home else {}
    grid = figure.add_gridspec(rows, 2 if has_plane else 1, **shares)
    curves = [figure.add_subplot(grid[row, 0]) for row in range(states)]
    if picture.speeds is not None:
        _draw_speeds(figure.add_subplot(grid[states:, :]), picture.speeds)
    _draw_curves(curves, picture)
    if has_plane:
        draw_plane(figure.add_subplot(grid[:states, 1]), picture)
    title_figure(figure, picture.title)
    entries = _entries(picture, curves=True)
    legend_below(figure, entries, min(len(entries), IN_A_ROW))
    return figure


def draw_plane(axes: Axes, picture: PathPicture) -> None:
    """The path in the plane of the first two states over its ground; of one state over time."""
    if picture.ground is None:
        times, states = picture.trajectory.dense(SAMPLES)
        axes.plot(times, states[:, 0])
        axes.set(xlabel="t", ylabel=picture.labels[0])
        return
    if picture.beside is not None:
        axes.plot(*picture.beside[0].dense(SAMPLES)[1][:, :2].T, **BESIDE, zorder=3)
    _draw_path(axes, picture.trajectory, picture.trajectory.dense(SAMPLES)[1])
    picture.ground(axes)
    if picture.home:
        axes.plot(*picture.home[:2], marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)


def _draw_path(axes: Axes, path: Trajectory, states: Floats, mark: str | None = None) -> None:
    """The path with its start and its events; its pieces carry the mark, if there is one."""

    def named(piece: str) -> str | None:
        return None if mark is None else f"{mark}--{piece}"

    axes.plot(states[:, 0], states[:, 1], color=PATH, linewidth=1.8, zorder=3, gid=named("path"))
    axes.plot(*states[0, :2], marker=">", color=PATH, markersize=8, zorder=4, gid=named("start"))
    for number, event in enumerate(marked(path.events), 1):
        place = [[float(event.state[0])], [float(event.state[1])]]
        style: dict[str, Any] = {"marker": MARKERS[event.kind], "color": INK, "markersize": 6, "fillstyle": "none"}
        axes.plot(*place, **style, zorder=4, gid=named(f"event-{number}"))


def _draw_curves(curves: Sequence[Axes], picture: PathPicture) -> None:
    """The states over time, one under the other, with the events marked, and lines at the checked point."""
    times, states = picture.trajectory.dense(SAMPLES)
    shown = TO_SHOW if picture.home else np.ones(len(curves))
    spans = np.ptp(states * shown, axis=0)
    for k, axes in enumerate(curves):
        if picture.beside is not None:
            others, values = picture.beside[0].dense(SAMPLES)
            axes.plot(others, values[:, k] * shown[k], **BESIDE)
        axes.plot(times, states[:, k] * shown[k], color=PATH, linewidth=1.6)
        for event in marked(picture.trajectory.events):
            place = [float(event.t)], [float(event.state[k]) * shown[k]]
            axes.plot(*place, marker=MARKERS[event.kind], color=INK, markersize=5, fillstyle="none", linestyle="none")
        axes.set_ylabel(picture.labels[k])
        axes.margins(x=0.02, y=0.15)
        if spans[k] < ROUNDING * spans.max():  # rounding of a constant: a straight line
            axes.set_ylim(*(states[0, k] * shown[k] + spans.max() * np.array([-0.5, 0.5])))
        _draw_home(axes, picture.home[k] if picture.home else 0.0)
        if axes is not curves[-1]:
            axes.tick_params(labelbottom=False)
            axes.sharex(curves[-1])
    curves[-1].set_xlabel(picture.time)


def _draw_home(axes: Axes, home: float) -> None:
    """A line at the checked point, where it lies in the view: no axis is stretched to hold it."""
    low, high = axes.get_ylim()
    if low <= home <= high:
        axes.axhline(home, color="0.6", linewidth=0.8, zorder=0)


def _draw_speeds(axes: Axes, curves: SpeedCurves) -> None:
    """The speeds over time, a line for each wheel that acts at some time, and dashed lines at their limits."""
    acting = [k for k in range(curves.speeds.shape[1]) if np.isfinite(curves.speeds[:, k]).any()]
    for place, k in enumerate(acting):
        color = LINES[place % len(LINES)]
        axes.plot(curves.times, curves.speeds[:, k], color=color, linewidth=1.4, label=f"u_{curves.wheels[k]}")
        axes.plot(curves.times, curves.speeds[:, k], ".", color=color, markersize=1.5)
    shown = curves.speeds[:, acting]
    largest = float(np.nanmax(np.abs(shown), initial=0.0))
    limited = {curves.limits[curves.wheels[k]] for k in acting if curves.wheels[k] in curves.limits}
    for limit in sorted(limited):
        if limit <= 1.2 * largest:
            for side in (-limit, limit):
                axes.axhline(side, color=INK, linewidth=0.9, linestyle="--")
    axes.set(xlabel=curves.labels[0], ylabel=curves.labels[1])
    axes.margins(x=0.02, y=0.12)
    _draw_home(axes, 0.0)
    if 0 < len(acting) <= MOST_NAMED:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")


def label_plane(axes: Axes, picture: PathPicture) -> None:
    """A title and a legend for a path that is drawn alone."""
    title_axes(axes, picture.title)
    axes.legend(handles=_entries(picture, curves=False), fontsize="x-small", framealpha=0.8)


def _entries(picture: PathPicture, *, curves: bool) -> list[Line2D]:
    """What the lines and marks of a path are, with those of the curves over time or without."""
    entries = [line_entry("path" if picture.beside is None else picture.trajectory.method, color=PATH, linewidth=1.8)]
    if picture.home:
        entries += [line_entry("at the checked point", color="0.6", linewidth=0.8)] * curves
        entries += [mark_entry("+", "checked point", markersize=9)] * (picture.ground is not None)
    entries += [line_entry(name, **style) for name, style in picture.explained.items()]
    if picture.beside is not None:
        entries.append(line_entry(picture.beside[1], **BESIDE))
    if picture.ground is not None:
        entries.append(mark_entry(">", "start", color=PATH))
    for kind in dict.fromkeys(event.kind for event in picture.trajectory.events):
        entries.append(mark_entry(MARKERS[kind], str(kind), fillstyle="none"))
    return entries


def marked(events: Sequence[Event]) -> Sequence[Event]:
    """The events that are marked: all where they are few, else evenly many of them, the first and last among them."""
    if len(events) <= MOST_MARKS:
        return events
    return [events[round(k * (len(events) - 1) / (MOST_MARKS - 1))] for k in range(MOST_MARKS)]


# ---- grounds -------------------------------------------------------------------------------------

ROUNDING = 1e-9  # of the largest change of a state along the path: changes of others that are no more
SMALL = 0.2  # of the half-width of the square: a path that keeps to less is drawn enlarged
ENLARGED = 1.3  # half-width of the enlarged view in units of the path's extent
RIM_LENGTH = 0.07  # half of a drawn rim's, as a share of the array
MOST_OUTLINES = 20  # events at which the body is drawn
MESH = 160  # points in a row at which a switching function is evaluated
MARGIN = 0.15  # of the larger side of the path's box, around it


def draw_cells(axes: Axes, partition: Partition, trajectory: Trajectory) -> None:
    """The cells under a path, enlarged where it would be a dot in the square: the axes' numbers tell."""
    fill_cells(axes, partition)
    axes.set(aspect="equal", **centre_labels(partition.scene.units))
    centre = np.array(partition.scene.check.place)
    extent = max_norm(trajectory.array[:, :2] - centre)
    if 0 < extent < SMALL * partition.scene.check.half_width:
        half = ENLARGED * extent
        axes.set(xlim=(centre[0] - half, centre[0] + half), ylim=(centre[1] - half, centre[1] + half))


def draw_wheels(axes: Axes, scene: Scene, trajectory: Trajectory) -> None:
    """The rims of the wheels, and the body where it starts, at its events, and where it ends."""
    _draw_rims(axes, contact_model(scene))
    axes.set(aspect="equal", **centre_labels(scene.units))
    outline = outline_of(scene)
    if outline is None:
        draw_names(axes, scene, PLANE, ())
        return
    events = [event.state for event in trajectory.events[:MOST_OUTLINES]]
    poses = [trajectory.states[0], *events, trajectory.end.state]
    ends = [placed(outline, np.array(pose, float)) for pose in (poses[0], poses[-1])]
    draw_names(axes, scene, PLANE, ends)
    for k, pose in enumerate(poses):
        is_end = k in (0, len(poses) - 1)
        axes.fill(
            *placed(outline, np.array(pose, float)).T,
            fill=False,
            edgecolor=INK,
            linewidth=1.4 if is_end else 0.8,
            alpha=1.0 if is_end else 0.3,
            linestyle="-" if k else "--",
        )


def _draw_rims(axes: Axes, model: ContactModel) -> None:
    """Rims as thick lines, and the friction axes of wheels that have some."""
    half = RIM_LENGTH * spread(model.positions) * model.rims
    for start, end in zip(model.positions - half, model.positions + half, strict=True):
        axes.plot(*zip(start, end, strict=True), **RIM)
    for k in np.flatnonzero(model.heads[:, 1]).tolist():
        draw_axis(axes, in_floats(model.positions[k]), in_floats(model.axes[k]), norm(half[k]))


def draw_surfaces(axes: Axes, system: SwitchedSystem, switching: SignField, trajectory: Trajectory) -> None:
    """The switching surfaces of a plain system in two states, in a square around the path."""
    left, right, low, high = _view(trajectory, system.check.half_width)
    xs, ys = np.linspace(left, right, MESH), np.linspace(low, high, MESH)
    for surface in switching.surfaces:
        heights = np.array([[surface.value(np.array([x, y])) for x in xs] for y in ys])
        if not heights.min() < 0 < heights.max():
            continue
        lines = {"colors": SURFACE["color"], "linestyles": SURFACE["linestyle"], "linewidths": 1.2}
        axes.contour(xs, ys, heights, levels=[0.0], zorder=1, **lines)
    x, y = system.stated_states
    axes.set(xlim=(left, right), ylim=(low, high), xlabel=x, ylabel=y, aspect="equal")


def _view(trajectory: Trajectory, radius: float) -> tuple[float, float, float, float]:
    """A square around the path; of the given half-width about a path that stays where it is."""
    states = trajectory.array
    centre = (states.min(axis=0) + states.max(axis=0)) / 2
    half = spread(states) * (0.5 + MARGIN) or radius
    x, y = in_floats(centre)
    return x - half, x + half, y - half, y + half


# ---- many starts ---------------------------------------------------------------------------------


def start_mark(number: int) -> str:
    """What is about the third start carries the mark ``start-3``."""
    return f"start-{number}"


def starts_figure(partition: Partition, paths: Sequence[Trajectory]) -> Figure:
    """Paths from many starts: x, y and theta over time, and the paths over the cells."""
    require_drawable(partition.scene)
    figure = new_figure(*ARRAY)
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.1))
    curves = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    plane = figure.add_subplot(grid[:, 1])
    fill_cells(plane, partition)
    view_square(plane, partition.scene)
    last = max(float(path.times[-1]) for path in paths)
    for number, path in enumerate(paths, 1):
        _draw_curves_of(curves, path, start_mark(number), last)
        _draw_path(plane, path, path.array, start_mark(number))
    _label(curves, partition)
    name = one_line(partition.scene.name)
    title_figure(figure, f"{name}: rule {partition.rule}, {len(paths)} starts")
    return figure


def _draw_curves_of(curves: list[Axes], path: Trajectory, mark: str, last: float) -> None:
    """x, y and theta of one path; where the body has come to rest it stays until the ``last`` time of all paths."""
    times, states = path.t, path.array
    if times[-1] < last:
        times, states = np.append(times, last), np.vstack([states, states[-1:]])
    for k, axes in enumerate(curves):
        axes.plot(times, states[:, k] * TO_SHOW[k], color=PATH, linewidth=1.6, gid=f"{mark}--{'xyt'[k]}")


def _label(curves: list[Axes], partition: Partition) -> None:
    units, home = partition.scene.units, (*partition.scene.check.place, 0.0)
    for k, axes in enumerate(curves):
        _draw_home(axes, home[k])
        axes.set_ylabel(pose_labels(units)[k])
        axes.tick_params(labelbottom=k == 2)
    curves[2].set_xlabel(time_label("t", units))
