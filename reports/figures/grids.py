"""Maps of starts on a grid: one pixel for each start, in the color of what becomes of it.

*Paths through cells*: heading theta_inf, time of arrival, and the kind and place of the end.  *A body with an outline*:
its destination, and the body there.  *A plain system*: how near a path has come to the checked point, with the
certified region of V.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.bodies.destinations import PathEnd
from nonsmooth.analysis.bodies.many_paths import BodyEnd
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.reports.figures.phase_portrait import draw_borders, draw_potential
from nonsmooth.reports.figures.style import (
    INK,
    PALETTE,
    TITLE,
    Floats,
    centre_labels,
    corners_of,
    draw_grid,
    grid_extent,
    grid_side,
    legend_below,
    length_label,
    new_figure,
    require_drawable,
    time_label,
    title_figure,
)
from nonsmooth.reports.figures.wheels import outline_of, placed
from nonsmooth.symbolic.number_text import percent_text
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.units import Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from matplotlib.patches import Patch

    from nonsmooth.reports.body_maps import BodyMapResult
    from nonsmooth.reports.maps import Basin, SettleMapResult
    from nonsmooth.reports.system_maps import SystemMap

LINE = 0.22  # inches for each line of the legend
COLORS = PALETTE[:-1]  # grey is for what is not told apart


def start_labels(units: Units) -> dict[str, str]:
    """Of the plane of starts: keywords of ``Axes.set``."""
    return {"xlabel": length_label("x at the start", units), "ylabel": length_label("y at the start", units)}


# ---- paths through cells -------------------------------------------------------------------------

SIZE = (12.6, 6.0)  # inches, without the legend
SCALE = 0.05  # height of a color scale, relative to its map
HEADING, TIME = "PuOr", "cividis"  # maps of colors that are safe for color-blind readers
OTHER_ENDS = "#F2F2F2"  # color of all ends beyond the palette
SHADE = 0.45  # opacity of the dark veil over starts with several solutions
NOTHING: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "0.6", "hatch": "///", "linewidth": 0.0}
NO_NUMBER = "no limit of theta, or no arrival"


def ends_figure(result: SettleMapResult) -> Figure:
    """Where each start ends, when, and at which heading.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    scene = result.partition.scene
    require_drawable(scene)
    entries = _ends_legend(result)
    figure = new_figure(SIZE[0], SIZE[1] + LINE * -(-len(entries) // 2))
    rows = figure.add_gridspec(2, 3, height_ratios=(1, SCALE))
    heading, arrival, ends = (figure.add_subplot(rows[0, k]) for k in range(3))
    _draw_heading(heading, figure.add_subplot(rows[1, 0]), result)
    _draw_arrival(arrival, figure.add_subplot(rows[1, 1]), result)
    draw_ends(ends, result)
    for axes in (heading, arrival):
        _draw_cell_borders(axes, result.partition)
        axes.set(**start_labels(scene.units), aspect="equal")
    for axes in (arrival, ends):
        axes.set_ylabel("")
        axes.tick_params(labelleft=False)
    title_figure(figure, f"{result.head}\n{result.summary()}")
    legend_below(figure, entries)
    return figure


def _draw_heading(axes: Axes, scale: Axes, result: SettleMapResult) -> None:
    from matplotlib.colors import CenteredNorm

    found, start = result.found, result.options.heading
    values = np.where(found.settled, found.theta, np.nan)
    turned = np.abs(values[found.settled] - start)
    norm = CenteredNorm(start, float(turned.max(initial=0.0)) or 1.0)
    axes.set_title(f"heading at rest (theta = {start:.6g} at the start)")
    _draw_numbers(axes, scale, found.starts, values, "theta_inf [rad]", cmap=HEADING, norm=norm)


def _draw_arrival(axes: Axes, scale: Axes, result: SettleMapResult) -> None:
    found, label = result.found, time_label("t", result.partition.scene.units)
    values = np.where(found.arrived, found.arrival, np.nan)
    latest = float(values[found.arrived].max(initial=0.0)) or 1.0
    axes.set_title("time of arrival")
    _draw_numbers(axes, scale, found.starts, values, label, cmap=TIME, vmin=0.0, vmax=latest)


def _draw_numbers(axes: Axes, scale: Axes, starts: Floats, values: Floats, label: str, **colors: Any) -> None:
    """One number per start, with its scale; a hatched ground shows where there is none."""
    from matplotlib.patches import Rectangle

    left, right, low, high = grid_extent(starts)
    axes.add_patch(Rectangle((left, low), right - left, high - low, zorder=0, **NOTHING))
    axes.set(xlim=(left, right), ylim=(low, high))
    if np.isnan(values).all():
        scale.set_axis_off()
        return
    image = draw_grid(axes, starts, np.ma.masked_invalid(values), zorder=1, **colors)
    axes.figure.colorbar(image, cax=scale, label=label, orientation="horizontal")


def draw_ends(axes: Axes, result: SettleMapResult) -> None:
    """Ends by color, over the cells; what is not unique is darker."""
    from matplotlib.colors import to_rgb, to_rgba

    found = result.found
    colors = np.zeros((len(found.ends), 3))
    for basin, color in _colored(result):
        colors[list(basin.kinds)] = to_rgb(color)
    axes.set_title("end")
    draw_grid(axes, found.starts, colors[found.basin])
    veil = np.zeros((len(found.starts), 4))
    veil[~found.unique] = to_rgba(INK, SHADE)
    draw_grid(axes, found.starts, veil)
    _draw_cell_borders(axes, result.partition)
    axes.set(**start_labels(result.partition.scene.units), aspect="equal")


def _colored(result: SettleMapResult) -> list[tuple[Basin, str]]:
    return [(basin, COLORS[k] if k < len(COLORS) else OTHER_ENDS) for k, basin in enumerate(result.basins)]


def _ends_legend(result: SettleMapResult) -> list[Patch]:
    """An entry for each color, and for what else occurs."""
    from matplotlib.patches import Patch

    found, colored = result.found, _colored(result)
    entries = [
        Patch(facecolor=color, label=f"{percent_text(basin.share)}: {basin.text}")
        for basin, color in colored[: len(COLORS)]
    ]
    if others := colored[len(COLORS) :]:
        label = f"{percent_text(sum(basin.share for basin, _ in others))}: {len(others)} other ends"
        entries.append(Patch(facecolor=OTHER_ENDS, edgecolor="0.6", label=label))
    if not found.unique.all():
        entries.append(Patch(facecolor=INK, alpha=SHADE, label="darker: several solutions, one of them is drawn"))
    if not (found.settled & found.arrived).all():
        entries.append(Patch(label=NO_NUMBER, **NOTHING))
    return entries


def _draw_cell_borders(axes: Axes, partition: Partition) -> None:
    for cell in partition.cells:
        corners = corners_of(cell.polygon.vertices)
        axes.fill(*corners.T, facecolor="none", edgecolor=INK, alpha=0.4, linewidth=0.5, zorder=2)


# ---- a body with an outline ----------------------------------------------------------------------

BODY_SIZE = (12.0, 6.0)  # inches, without the legend
OTHER_PLACES = "#BBBBBB"  # places of rest beyond the palette
TIPS = "#FFFFFF"  # under a hatch
MOVING = "#666666"
HATCH = "xxxx"
PIXEL = 0.9  # of the distance between starts: side of a hatched mark
NEAR = 1.3  # the destinations' view, in sizes of the body around them


def destinations_figure(shown: BodyMapResult) -> Figure:
    """Starts by where they end, and the body at each destination."""
    entries = _destinations_legend(shown.destinations)
    figure = new_figure(BODY_SIZE[0], BODY_SIZE[1] + LINE * -(-len(entries) // 2))
    figure.set_layout_engine("compressed")
    starts, ends = figure.subplots(1, 2)
    draw_destinations(starts, shown)
    _draw_bodies(ends, shown)
    _draw_contacts(starts, shown)
    _draw_contacts(ends, shown)
    starts.set(**start_labels(shown.scene.units))
    ends.set(**centre_labels(shown.scene.units))
    head = f"{shown.title}: {shown.head} at theta = {shown.options.heading:.6g}, sampled"
    title_figure(figure, f"{head}\n{shown.summary()}")
    legend_below(figure, entries)
    return figure


def _colors(found: list[PathEnd]) -> list[str]:
    """One for each destination."""
    colors = []
    for k, one in enumerate(found):
        if one.reason is BodyEnd.REST:
            colors.append(COLORS[k] if k < len(COLORS) else OTHER_PLACES)
        else:
            colors.append(TIPS if one.reason in {BodyEnd.TIPS, BodyEnd.LEAVES} else MOVING)
    return colors


def draw_destinations(axes: Axes, shown: BodyMapResult) -> None:
    """Starts by color; those that tip are hatched."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Rectangle

    points = shown.found.starts[:, :2]
    steps = np.ptp(points, axis=0) / (grid_side(points) - 1)
    table = np.array([to_rgb(color) for color in _colors(shown.destinations)])
    draw_grid(axes, points, table[shown.destination_of], zorder=0)
    fallen = shown.found.by(BodyEnd.TIPS) | shown.found.by(BodyEnd.LEAVES)
    for x, y in points[fallen] - PIXEL * steps / 2:
        axes.add_patch(Rectangle((x, y), *(PIXEL * steps), fill=False, hatch=HATCH, edgecolor=INK, linewidth=0.0))
    left, right, low, high = grid_extent(points)
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", title="where a start ends")


def _draw_bodies(axes: Axes, shown: BodyMapResult) -> None:
    """The outline at each destination: at the middle heading, and faintly at the outermost ones."""
    outline = outline_of(shown.scene)
    axes.set(aspect="equal", title="the body at its destinations")
    resting = [(one, color) for one, color in zip(shown.destinations, _colors(shown.destinations), strict=True)]
    resting = [(one, color) for one, color in resting if one.pose is not None][: len(COLORS)]
    if outline is None or not resting:
        return
    reach = float(np.hypot(*outline.T).max())
    for one, color in resting:
        x, y, theta = one.pose or (0.0, 0.0, 0.0)
        for heading in one.headings or ():
            axes.fill(*placed(outline, np.array([x, y, heading])).T, fill=False, edgecolor=color, alpha=0.5, zorder=2)
        axes.fill(*placed(outline, np.array([x, y, theta])).T, fill=False, edgecolor=color, linewidth=2.0, zorder=3)
        nose = np.array([x, y]) + 0.5 * reach * np.array([np.cos(theta), np.sin(theta)])
        arrow = axes.annotate("", xy=tuple(nose), xytext=(x, y), arrowprops={"arrowstyle": "-|>", "color": color})
        arrow.set_in_layout(False)
    centres = np.array([one.pose[:2] for one, _ in resting if one.pose is not None])
    low, high = centres.min(axis=0) - NEAR * reach, centres.max(axis=0) + NEAR * reach
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _draw_contacts(axes: Axes, shown: BodyMapResult) -> None:
    """Wheels as dots; the view stays."""
    limits = {"xlim": axes.get_xlim(), "ylim": axes.get_ylim()}
    places = corners_of(wheel.position for wheel in shown.scene.wheels)
    axes.plot(*places.T, linestyle="none", marker=".", markersize=3, color=INK, zorder=5)
    axes.set(**limits)


def _destinations_legend(found: list[PathEnd]) -> list[Patch]:
    """An entry for each color."""
    from matplotlib.patches import Patch

    entries, others = [], list[PathEnd]()
    for k, (one, color) in enumerate(zip(found, _colors(found), strict=True)):
        if one.reason is BodyEnd.REST and k >= len(COLORS):
            others.append(one)
            continue
        hatch = HATCH if color == TIPS else None
        entries.append(Patch(facecolor=color, edgecolor=INK, hatch=hatch, label=f"{100 * one.share:.3g} %: {one.text}"))
    if others:
        share = 100 * sum(one.share for one in others)
        entries.append(Patch(facecolor=OTHER_PLACES, label=f"{share:.3g} %: {len(others)} other places of rest"))
    return entries


# ---- a plain system ------------------------------------------------------------------------------

SYSTEM_SIZE = (7.4, 6.6)  # inches
NEAREST, FARTHEST = 1e-6, 10.0  # ratios of distances at the ends of the color scale
LOST = "0.85"


def ratios_figure(found: SystemMap) -> Figure:
    """Every start by how near it has come, with a scale."""
    figure = new_figure(*SYSTEM_SIZE)
    axes = figure.add_subplot()
    image = draw_ratios(axes, found)
    figure.colorbar(image, ax=axes, shrink=0.8, label="distance from the point: at the end by at the start")
    legend_below(figure, columns=3, fontsize="small")
    system, verdict = one_line(found.portrait.system.name), found.verdict
    title = f"{system}: {found.count} x {found.count} starts at t = {found.until:g}; proved: {verdict}"
    title_figure(figure, f"{title}\n{found.summary()}", TITLE)
    return figure


def draw_ratios(axes: Axes, found: SystemMap) -> AxesImage:
    """Every start as a square in the color of its ratio, with the borders of the cells and the region of V."""
    from matplotlib.colors import LogNorm

    ratios = np.where(np.isfinite(found.ends).all(axis=1), np.clip(found.ratios, NEAREST, FARTHEST), np.nan)
    axes.set_facecolor(LOST)
    image = draw_grid(axes, found.starts, ratios, cmap=TIME, norm=LogNorm(NEAREST, FARTHEST), zorder=0)
    draw_borders(axes, found.portrait)
    draw_potential(axes, found.portrait)
    axes.plot([0], [0], "o", color=INK, markersize=5, zorder=6)
    half = float(found.portrait.system.check.radius)
    x, y = found.portrait.system.states
    axes.set(xlim=(-half, half), ylim=(-half, half), xlabel=f"{x} at the start", ylabel=f"{y} at the start")
    axes.set_aspect("equal")
    return image
