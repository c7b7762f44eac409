"""A map of ends as a picture: heading theta_inf, time of arrival, and the kind and place of the end of every start."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.reports.figures.cell_map import PALETTE, require_drawable
from nonsmooth.reports.figures.labels import WIDE_TITLE, length_label, time_label, wrapped
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.symbolic.number_text import percent_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    from nonsmooth.reports.maps import Basin, SettleMapResult

SIZE = (12.6, 6.0)  # inches, without the legend
SCALE = 0.05  # height of a color scale, relative to its map
LINE = 0.22  # inches for each line of the legend
HEADING, TIME = "PuOr", "cividis"  # maps of colors that are safe for color-blind readers
COLORS = PALETTE[:-1]  # grey is the veil's
OTHERS = "#F2F2F2"  # color of all ends beyond the palette
SHADE = 0.45  # opacity of the dark veil over starts with several solutions
NOTHING: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "0.6", "hatch": "///", "linewidth": 0.0}
NO_NUMBER = "no limit of theta, or no arrival"


def build_figure(result: SettleMapResult) -> Figure:
    """The picture as a Matplotlib figure.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    from matplotlib.figure import Figure

    partition, units = result.partition, result.partition.scene.units
    require_drawable(partition)
    entries = _legend(result)
    lines = -(-len(entries) // 2)
    figure = Figure(figsize=(SIZE[0], SIZE[1] + LINE * lines), layout="constrained")
    rows = figure.add_gridspec(2, 3, height_ratios=(1, SCALE))
    heading, arrival, ends = (figure.add_subplot(rows[0, k]) for k in range(3))
    _draw_heading(heading, figure.add_subplot(rows[1, 0]), result)
    _draw_arrival(arrival, figure.add_subplot(rows[1, 1]), result)
    draw_ends(ends, result)
    for axes in (heading, arrival):
        _draw_cells(axes, partition)
        axes.set(xlabel=length_label("x at the start", units), aspect="equal")
    arrival.tick_params(labelleft=False)
    ends.tick_params(labelleft=False)
    ends.set_ylabel("")
    heading.set_ylabel(length_label("y at the start", units))
    figure.suptitle(wrapped(f"{result.head}\n{result.summary()}", WIDE_TITLE), fontsize="medium", parse_math=False)
    figure.legend(handles=entries, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _draw_heading(axes: Axes, scale: Axes, result: SettleMapResult) -> None:
    from matplotlib.colors import CenteredNorm

    found, start = result.found, result.options.heading
    values = np.where(found.settled, found.theta, np.nan)
    turned = np.abs(values[found.settled] - start)
    norm = CenteredNorm(start, float(turned.max(initial=0.0)) or 1.0)
    axes.set_title(f"heading at rest (theta = {start:.6g} at the start)")
    _draw_numbers(axes, scale, result, values, "theta_inf [rad]", cmap=HEADING, norm=norm)


def _draw_arrival(axes: Axes, scale: Axes, result: SettleMapResult) -> None:
    found, label = result.found, time_label("t", result.partition.scene.units)
    values = np.where(found.arrived, found.arrival, np.nan)
    latest = float(values[found.arrived].max(initial=0.0)) or 1.0
    axes.set_title("time of arrival")
    _draw_numbers(axes, scale, result, values, label, cmap=TIME, vmin=0.0, vmax=latest)


def _draw_numbers(
    axes: Axes, scale: Axes, result: SettleMapResult, values: NDArray[np.float64], label: str, **colors: Any
) -> None:
    """One number per start, with its scale; a hatched ground shows where there is none."""
    from matplotlib.patches import Rectangle

    left, right, low, high = extent = _extent(result)
    axes.add_patch(Rectangle((left, low), right - left, high - low, zorder=0, **NOTHING))
    axes.set(xlim=(left, right), ylim=(low, high))
    if np.isnan(values).all():
        scale.set_axis_off()
        return
    shown = np.ma.masked_invalid(values.reshape(_grid(result)))
    image = axes.imshow(shown, origin="lower", extent=extent, interpolation="nearest", zorder=1, **colors)
    axes.figure.colorbar(image, cax=scale, label=label, orientation="horizontal")


def draw_ends(axes: Axes, result: SettleMapResult) -> None:
    """Ends by color, over the cells; what is not unique is darker."""
    from matplotlib.colors import to_rgb, to_rgba

    found, grid, extent = result.found, _grid(result), _extent(result)
    colors = np.zeros((len(found.ends), 3))
    for basin, color in _colored(result):
        colors[list(basin.kinds)] = to_rgb(color)
    axes.set_title("end")
    axes.imshow(colors[found.basin].reshape(*grid, 3), origin="lower", extent=extent, interpolation="nearest")
    veil = np.zeros((*grid, 4))
    veil[~found.unique.reshape(grid)] = to_rgba(INK, SHADE)
    axes.imshow(veil, origin="lower", extent=extent, interpolation="nearest")
    _draw_cells(axes, result.partition)
    units = result.partition.scene.units
    axes.set(xlabel=length_label("x at the start", units), ylabel=length_label("y at the start", units), aspect="equal")


def _colored(result: SettleMapResult) -> list[tuple[Basin, str]]:
    return [(basin, COLORS[k] if k < len(COLORS) else OTHERS) for k, basin in enumerate(result.basins)]


def _grid(result: SettleMapResult) -> tuple[int, int]:
    """Starts in a column and in a row."""
    count = math.isqrt(len(result.found.starts))
    return count, count


def _legend(result: SettleMapResult) -> list[Patch]:
    """An entry for each color, and for what else occurs."""
    from matplotlib.patches import Patch

    found, colored = result.found, _colored(result)
    entries = [
        Patch(facecolor=color, label=f"{percent_text(basin.share)}: {basin.text}")
        for basin, color in colored[: len(COLORS)]
    ]
    if others := colored[len(COLORS) :]:
        label = f"{percent_text(sum(basin.share for basin, _ in others))}: {len(others)} other ends"
        entries.append(Patch(facecolor=OTHERS, edgecolor="0.6", label=label))
    if not found.unique.all():
        entries.append(Patch(facecolor=INK, alpha=SHADE, label="darker: several solutions, one of them is drawn"))
    if not (found.settled & found.arrived).all():
        entries.append(Patch(label=NO_NUMBER, **NOTHING))
    return entries


def _draw_cells(axes: Axes, partition: Partition) -> None:
    for cell in partition.cells:
        xs, ys = zip(*((float(x), float(y)) for x, y in cell.polygon.vertices), strict=True)
        axes.fill(xs, ys, facecolor="none", edgecolor=INK, alpha=0.4, linewidth=0.5, zorder=2)


def _extent(result: SettleMapResult) -> tuple[float, float, float, float]:
    """Border of the picture: half a step beyond the outermost starts."""
    starts, (count, _) = result.found.starts, _grid(result)
    (left, low), (right, high) = starts.min(axis=0), starts.max(axis=0)
    dx, dy = (right - left) / (count - 1) / 2, (high - low) / (count - 1) / 2
    return float(left - dx), float(right + dx), float(low - dy), float(high + dy)
