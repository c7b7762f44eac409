"""Drawing on axes that the caller gives, or on those of a new figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.reports.figures import array as array_figures
from nonsmooth.reports.figures import cell_map, rate_map, wheels
from nonsmooth.reports.result import own_axes
from nonsmooth.symbolic.number_text import short_text
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.support_polygon import support_polygon

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.filippov_set import FilippovSet

SHOWN = ("array", "cells", "rates")


def plot_array(array: Array, ax: Axes | None, show: str) -> Axes:
    """Draw an array.

    Raises:
        ValueError: for something else than wheels, cells or rates.
    """
    if show not in SHOWN:
        raise ValueError(f"show: required one of {', '.join(SHOWN)}, received {show!r}")
    axes = own_axes(ax)
    if show == "array":
        array_figures.draw_array(axes, array.scene)
    elif show == "cells":
        cell_map.draw_cell_map(axes, array.partition)
    else:
        levels = rate_map.draw_rates(axes, array.partition)
        if ax is None:
            rate_map.draw_scale(axes.figure, axes, array.partition, levels)
    return axes


def plot_filippov_set(found: FilippovSet, ax: Axes | None) -> Axes:
    """Draw the velocities of a Filippov set, with their cells, and their convex hull."""
    axes = own_axes(ax)
    corners = [wheels.floats(velocity) for velocity in support_polygon(found.velocities) or found.velocities[:1]]
    axes.fill(*zip(*corners, strict=True), facecolor=cell_map.PALETTE[0], alpha=cell_map.TINT)
    axes.fill(*zip(*corners, strict=True), facecolor="none", edgecolor=cell_map.PALETTE[5], linewidth=2)
    cells: dict[tuple[float, float], list[str]] = {}
    for (cell, _), velocity in zip(found.members, found.velocities, strict=True):
        cells.setdefault(wheels.floats(velocity), []).append(str(cell))
    for tip, indices in cells.items():
        axes.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "->", "color": wheels.INK, "shrinkA": 0, "shrinkB": 0})
        label = f"cell{'s' if len(indices) > 1 else ''} {', '.join(indices)}"
        across, up = sign(tip[0]), sign(tip[1])
        beyond: dict[str, Any] = {"ha": ("center", "left", "right")[across], "va": ("center", "bottom", "top")[up]}
        axes.annotate(label, tip, (4 * across, 4 * up), textcoords="offset points", color=wheels.INK, **beyond)
    axes.plot([0], [0], marker="+", color=wheels.INK, markersize=11)
    x, y = (short_text(value) for value in found.point)
    axes.set(xlabel="x'", ylabel="y'", title=f"F({x}, {y})")
    axes.axis("equal")
    axes.margins(0.35)
    return axes
