"""The phase portrait of a plain system as a picture.

Field lines over the checked square, nullclines, borders told apart by form, equilibrium, level sets of the V that
proves stability and the largest one that is certified to be a region of attraction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.fields.cell_values import inside, polynomial_values, rate_values
from nonsmooth.proofs.systems.border_motion import BorderKind
from nonsmooth.reports.figures.style import INK, Floats, legend_below, new_figure, title_figure
from nonsmooth.reports.phase_samples import sampled_potential, sampled_rates
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.phase_portrait import PhasePortrait

SIZE = 6.4  # inches
MESH = 161  # points in a row; odd, so that the middle is one
LEVELS = 6  # of V
FIELD, NULLCLINES, REGION, CURVE = "#999999", ("#E69F00", "#56B4E9"), "#0072B2", "#D55E00"
BORDERS: dict[BorderKind, dict[str, Any]] = {
    BorderKind.SLIDING: {"color": INK, "linewidth": 2.6},
    BorderKind.REPELLING: {"color": INK, "linewidth": 1.4, "linestyle": (0, (5, 3))},
    BorderKind.CROSSING: {"color": CURVE, "linewidth": 1.0},
    BorderKind.TOUCHED: {"color": CURVE, "linewidth": 1.0, "linestyle": (0, (1, 1))},
    BorderKind.UNDECIDED: {"color": FIELD, "linewidth": 1.4, "linestyle": (0, (1, 3))},
}


def portrait_figure(portrait: PhasePortrait) -> Figure:
    """The portrait with a legend."""
    figure = new_figure(SIZE, SIZE * 1.12)
    draw_portrait(figure.add_subplot(), portrait)
    legend_below(figure, columns=3, fontsize="small")
    title_figure(figure, f"{one_line(portrait.system.name)}: {portrait.stability.verdict}")
    return figure


def draw_portrait(axes: Axes, portrait: PhasePortrait) -> None:
    """Everything on given axes, in the displacement from the checked point."""
    half = float(portrait.system.check.radius)
    line = np.linspace(-half, half, MESH)
    xs, ys = np.meshgrid(line, line)
    rates = sampled_rates(portrait.cells, portrait.fields, xs, ys)
    axes.streamplot(line, line, *rates, color=FIELD, linewidth=0.6, density=1.3, arrowsize=0.7, zorder=1)
    _draw_nullclines(axes, portrait, xs, ys)
    _draw_curves(axes, portrait, xs, ys)
    draw_borders(axes, portrait)
    draw_potential(axes, portrait)
    axes.plot([0], [0], "o", color=INK, markersize=5, zorder=6)
    x, y = portrait.system.states
    axes.set(xlim=(-half, half), ylim=(-half, half), xlabel=x, ylabel=y, aspect="equal")


def _draw_nullclines(axes: Axes, portrait: PhasePortrait, xs: Floats, ys: Floats) -> None:
    """Where one rate vanishes inside a cell."""
    for k, (name, color) in enumerate(zip(portrait.system.states, NULLCLINES, strict=True)):
        drawn = False
        for cell, field in zip(portrait.cells, portrait.fields, strict=True):
            values = np.where(inside(cell, xs, ys), rate_values(field, xs, ys)[k], np.nan)
            known = values[~np.isnan(values)]
            if known.size and known.min() < 0 < known.max():
                axes.contour(xs, ys, values, levels=[0.0], colors=color, linewidths=1.4, zorder=2)
                drawn = True
        if drawn:
            axes.plot([], [], color=color, linewidth=1.4, label=f"{name}' = 0")


def _draw_curves(axes: Axes, portrait: PhasePortrait, xs: Floats, ys: Floats) -> None:
    """Switching curves, each once."""
    for guard in dict.fromkeys(guard for cell in portrait.cells for guard in cell.region.guards):
        values = polynomial_values(guard, xs, ys)
        if values.min() < 0 < values.max():
            axes.contour(xs, ys, values, levels=[0.0], colors=CURVE, linestyles="--", linewidths=1.0, zorder=3)


def draw_borders(axes: Axes, portrait: PhasePortrait) -> None:
    """Straight borders, their kinds told apart by form."""
    named: set[BorderKind] = set()
    for part in portrait.borders:
        ends = [[float(end[k]) for end in (part.start, part.end)] for k in (0, 1)]
        label = "" if part.kind in named else f"border: {part.kind}"
        axes.plot(*ends, **BORDERS[part.kind], zorder=4, label=label or "_")
        named.add(part.kind)


def draw_potential(axes: Axes, portrait: PhasePortrait) -> None:
    """Level sets of the V that proves the verdict, over the square on which it is proved."""
    function, region = portrait.stability.function, portrait.stability.reach.region
    if function is None:
        return
    half = float(function.domain.radius or portrait.system.check.radius)
    line = np.linspace(-half, half, MESH)
    xs, ys = np.meshgrid(line, line)
    potential = sampled_potential(function.result.cells, xs, ys)
    axes.contour(xs, ys, potential, levels=LEVELS, colors=REGION, linewidths=0.5, alpha=0.6, zorder=2)
    if region is not None and region.falls:
        axes.contour(xs, ys, potential, levels=[float(region.level)], colors=REGION, linewidths=2.0, zorder=5)
        axes.plot([], [], color=REGION, linewidth=2.0, label="certified region")
