"""A picture of the array: every wheel with its rim and surface speed, and the square that is checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nonsmooth.reports.figures.cell_map import LABEL, LEGEND_ROW, PALETTE, PICTURE, TINT, figure_bytes
from nonsmooth.reports.figures.labels import length_label, wrapped
from nonsmooth.reports.figures.wheels import AXIS_COLOR, INK, RIM_SHARE, draw_wheel, floats
from nonsmooth.symbolic.free_rollers import askew_wheels
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LARGEST_RIM = 0.035  # half of a rim's length, of the width of the view
SLOWEST, FASTEST = 1.4, 2.6  # where the arrowheads of the slowest and fastest wheels lie, in half-lengths of the rim
MOST_NAMES = 60  # wheels up to which each has its number


def array_figure(scene: Scene, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(scene), suffix)


def build_figure(scene: Scene) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PICTURE, PICTURE + 2 * LEGEND_ROW), layout="constrained")
    draw_array(figure.subplots(), scene)
    _explain(figure, bool(askew_wheels(scene)))
    return figure


def draw_array(axes: Axes, scene: Scene) -> None:
    """Every wheel, and the checked square, on axes of equal scale."""
    places = np.array([floats(wheel.position) for wheel in scene.wheels])
    centre, radius = np.array(floats(scene.check.equilibrium)), float(scene.check.radius)
    rim = _rim(places, np.concatenate([places, [centre - radius, centre + radius]]))
    _set_view(axes, np.concatenate([places - 3 * rim, places + 3 * rim, [centre - radius, centre + radius]]))
    _draw_square(axes, centre, radius)
    largest = max(abs(float(wheel.speed)) for wheel in scene.wheels) or 1.0
    for wheel in scene.wheels:
        tip = SLOWEST + (FASTEST - SLOWEST) * abs(float(wheel.speed)) / largest
        draw_wheel(axes, wheel, rim, tip=tip, named=len(scene.wheels) <= MOST_NAMES)
    axes.set(xlabel=length_label("x", scene.units), ylabel=length_label("y", scene.units))
    axes.set_title(wrapped(f"{one_line(scene.name)}: {len(scene.wheels)} wheels"), parse_math=False)


def _rim(places: NDArray[np.float64], shown: NDArray[np.float64]) -> float:
    """Half of a rim's length: small beside the view and beside the distance of neighbours."""
    width = float(np.ptp(shown, axis=0).max())
    apart = np.hypot(*(places[:, None] - places[None, :]).transpose(2, 0, 1))
    nearest = apart[apart > 0].min(initial=width)
    return min(LARGEST_RIM * width, float(nearest) * RIM_SHARE)


def _set_view(axes: Axes, shown: NDArray[np.float64]) -> None:
    low, high = shown.min(axis=0), shown.max(axis=0)
    middle, half = (low + high) / 2, 0.53 * float((high - low).max())
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")


def _draw_square(axes: Axes, centre: NDArray[np.float64], radius: float) -> None:
    (x, y), r = centre, radius
    corners = ([x - r, x + r, x + r, x - r], [y - r, y - r, y + r, y + r])
    axes.fill(*corners, facecolor=PALETTE[0], alpha=TINT / 2, edgecolor="none", zorder=1)
    axes.fill(*corners, facecolor="none", edgecolor=INK, linestyle="--", linewidth=0.8, zorder=1)
    axes.plot([x], [y], marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)


def _explain(figure: Figure, askew: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries = [
        Line2D([], [], color=INK, linewidth=5, label="wheel: rim and number"),
        Line2D(
            [], [], linestyle="none", color=INK, marker=r"$\rightarrow$", markersize=9, label="surface speed (size)"
        ),
        *[Line2D([], [], color=AXIS_COLOR, linewidth=1.2, label="friction axis")] * askew,
        Patch(facecolor=PALETTE[0], alpha=TINT / 2, edgecolor=INK, linestyle="--", label="checked square"),
        Line2D([], [], linestyle="none", color=INK, marker="+", markersize=9, label="checked point"),
    ]
    figure.legend(handles=entries, loc="outside lower center", ncols=2, frameon=False, fontsize=LABEL - 1)
