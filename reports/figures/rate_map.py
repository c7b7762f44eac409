"""The upper derivative V* over the cells as a heat map, V = |c - c*|^2.

On a cell ``V* = 2 c . v`` is linear in c, so contour bands drawn on its triangles are exact; between cells it jumps.
Where several motions tie, the largest of their derivatives is drawn.  Colors run from blue (V falls) through white
to orange (V grows), symmetric about zero, told apart also by color-blind readers.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.reports.document import cell_mark
from nonsmooth.reports.figures.cell_map import (
    LABEL,
    PICTURE,
    POINTS,
    require_drawable,
    room_at,
    view_square,
)
from nonsmooth.reports.figures.labels import wrapped
from nonsmooth.reports.figures.wheels import floats
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

BANDS = 10  # from zero to the largest absolute value
SPLIT = 20  # pieces of each side of a triangle where motions tie and V* is not linear
COLORS, ZERO = "PuOr_r", "#f7f7f7"  # Matplotlib's name, and its color in the middle
DARK = "#101418"  # text over the map's own colors, whatever the page's
PLATE = {"boxstyle": "round,pad=0.25", "facecolor": "#fcfcfc", "edgecolor": "none"}  # behind a number


def build_figure(partition: Partition) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    require_drawable(partition)
    figure = Figure(figsize=(PICTURE + 0.7, PICTURE - 0.2), layout="constrained")
    axes = figure.subplots()
    draw_scale(figure, axes, partition, draw_rates(axes, partition))
    return figure


def draw_scale(figure: Figure | SubFigure, axes: Axes, partition: Partition, levels: NDArray[np.float64]) -> None:
    """The scale of V* beside the axes; ``levels`` are the borders of its bands."""
    from matplotlib.cm import ScalarMappable

    ticks = levels[:: max(1, len(levels) // 8)]
    colors = ScalarMappable(symmetric(levels), COLORS)
    bar = figure.colorbar(colors, ax=axes, shrink=0.85, boundaries=levels, ticks=ticks, format="%.3g")
    unit = partition.scene.units
    bar.set_label(f"upper derivative V* [{unit.length or 'length'}²/{unit.time or 'time'}]")


def draw_rates(axes: Axes, partition: Partition) -> NDArray[np.float64]:
    """V* on every cell; returns the borders of its bands."""
    view_square(axes, partition)
    levels = _levels(partition)
    for cell in partition.cells:
        _draw_cell(axes, partition, cell, levels)
    axes.set_title(wrapped(f"{one_line(partition.scene.name)}: V* of V = |c - c*|^2"), parse_math=False)
    return levels


def _levels(partition: Partition) -> NDArray[np.float64]:
    """Borders of the bands of all cells."""
    rates = [_rates(partition, cell, np.array(cell_corners(cell))) for cell in partition.cells]
    return bands_of(np.concatenate(rates))


def bands_of(rates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Borders of bands: multiples of one step, zero among them, that cover all values."""
    step = float(np.abs(rates).max()) / BANDS or 1.0
    lowest, highest = (round(float(end) / step, 6) for end in (rates.min(), rates.max()))
    steps = np.arange(min(math.floor(lowest), 0), max(math.ceil(highest), 0) + 1)
    return np.asarray((steps if len(steps) > 1 else np.array([-1, 0, 1])) * step)


def cell_corners(cell: Cell) -> list[tuple[float, float]]:
    """The vertices as floats."""
    return [floats(vertex) for vertex in cell.polygon.vertices]


def _rates(partition: Partition, cell: Cell, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """``V* = max 2 (c - c*) . v`` at points (m, 2) of the closed cell, as seen from inside."""
    centre = np.array(floats(partition.scene.check.equilibrium))
    x, y = points.T
    rates = []
    for twist in cell.twists:
        vx, vy, omega = (float(value) for value in twist)
        rates.append(2 * ((x - centre[0]) * (vx - omega * y) + (y - centre[1]) * (vy + omega * x)))
    return np.asarray(np.max(rates, axis=0))


def _draw_cell(axes: Axes, partition: Partition, cell: Cell, levels: NDArray[np.float64]) -> None:
    """Bands of V* on a cell, its border, and its number where there is room."""
    from matplotlib.tri import Triangulation

    corners = np.array(cell_corners(cell))
    points, triangles = _triangles(corners, SPLIT if len(cell.twists) > 1 else 1)
    rates = np.clip(_rates(partition, cell, points), levels[0], levels[-1])
    if np.any(rates):
        triangulation = Triangulation(points[:, 0], points[:, 1], triangles)
        axes.tricontourf(triangulation, rates, levels=levels, cmap=COLORS, norm=symmetric(levels), zorder=1)
    else:
        axes.fill(*corners.T, facecolor=ZERO, edgecolor="none", zorder=1)
    axes.fill(*corners.T, facecolor="none", edgecolor="white", linewidth=1.5, zorder=3)
    (shape,) = axes.fill(*corners.T, facecolor="none", edgecolor="none", zorder=3.5)
    shape.set_gid(cell_mark(cell.index))
    x, y = corners.mean(axis=0).tolist()
    left, right = axes.get_xlim()
    if room_at((x, y), cell_corners(cell)) * POINTS / (right - left) >= LABEL:
        axes.text(x, y, str(cell.index), ha="center", va="center", color=DARK, bbox=PLATE, zorder=4)


def symmetric(levels: NDArray[np.float64]) -> Any:
    """Colors symmetric about zero: white is where V* vanishes."""
    from matplotlib.colors import Normalize

    largest = float(np.abs(levels).max())
    return Normalize(-largest, largest)


def _triangles(corners: NDArray[np.float64], split: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A fan of triangles over a convex polygon, each split into ``split^2``."""
    points: list[NDArray[np.float64]] = []
    triangles: list[tuple[int, int, int]] = []
    for second, third in pairwise(corners[1:]):
        index: dict[tuple[int, int], int] = {}
        for i in range(split + 1):
            for j in range(split + 1 - i):
                index[i, j] = len(points)
                points.append(corners[0] + (i * (second - corners[0]) + j * (third - corners[0])) / split)
        for (i, j), here in index.items():
            if i + j < split:
                triangles.append((here, index[i + 1, j], index[i, j + 1]))
            if i + j < split - 1:
                triangles.append((index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]))
    return np.array(points), np.array(triangles)
