"""Starts of a plain system by how near they have come to the checked point, with the certified region of V."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.reports.figures.labels import wrapped
from nonsmooth.reports.figures.phase_portrait import draw_borders, draw_potential
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

    from nonsmooth.reports.system_maps import SystemMap

Floats: TypeAlias = NDArray[np.float64]

SIZE = (7.4, 6.6)  # inches
NEAREST, FARTHEST = 1e-6, 10.0  # ratios of distances at the ends of the color scale
COLORS = "cividis"  # safe for color-blind readers; dark is near
LOST = "0.85"


def build_figure(found: SystemMap) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    image = draw_map(axes, found)
    figure.colorbar(image, ax=axes, shrink=0.8, label="distance from the point: at the end by at the start")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small", frameon=False)
    system, verdict = one_line(found.portrait.system.name), found.verdict
    title = f"{system}: {found.count} x {found.count} starts at t = {found.until:g}; proved: {verdict}"
    figure.suptitle(wrapped(f"{title}\n{found.summary()}"), fontsize="medium", parse_math=False)
    return figure


def draw_map(axes: Axes, found: SystemMap) -> AxesImage:
    """Every start as a square in the color of its ratio, with the borders of the cells and the region of V."""
    image = _draw_ratios(axes, found)
    draw_borders(axes, found.portrait)
    draw_potential(axes, found.portrait)
    axes.plot([0], [0], "o", color=INK, markersize=5, zorder=6)
    half = float(found.portrait.system.check.radius)
    x, y = found.portrait.system.states
    axes.set(xlim=(-half, half), ylim=(-half, half), xlabel=f"{x} at the start", ylabel=f"{y} at the start")
    axes.set_aspect("equal")
    return image


def _draw_ratios(axes: Axes, found: SystemMap) -> AxesImage:
    from matplotlib.colors import LogNorm

    half, shape = float(found.portrait.system.check.radius), (found.count, found.count)
    ratios: Floats = np.where(np.isfinite(found.ends).all(axis=1), np.clip(found.ratios, NEAREST, FARTHEST), np.nan)
    wide = half * (1 + 1 / (found.count - 1))  # squares are centred at the starts
    axes.set_facecolor(LOST)
    return axes.imshow(
        ratios.reshape(shape),
        origin="lower",
        extent=(-wide, wide, -wide, wide),
        cmap=COLORS,
        norm=LogNorm(NEAREST, FARTHEST),
        interpolation="nearest",
        zorder=0,
    )
