"""A solution of a plain system as a picture: its states over time and, for two states, the path in the plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.trajectory import draw_curves, draw_path, explain
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, LEAST_HEIGHT, CURVE = 9.6, 5.6, 1.5  # inches: of the picture, at least, of one curve
SURFACE = "#D55E00"
MESH = 160  # points in a row at which a switching function is evaluated
MARGIN = 0.15  # of the larger side of the path's box, around it


def phase_plane_figure(
    system: SwitchedSystem, field: SignField, trajectory: Trajectory, suffix: str, title: str = ""
) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(system, field, trajectory, title), suffix)


def build_figure(system: SwitchedSystem, field: SignField, trajectory: Trajectory, title: str = "") -> Figure:
    """The picture as a Matplotlib figure; its title names the method unless one is given."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    states = system.stated_states
    planar = len(states) == 2
    figure = Figure(figsize=(WIDTH, max(LEAST_HEIGHT, CURVE * len(states))), layout="constrained")
    grid = figure.add_gridspec(len(states), 2 if planar else 1)
    curves = [figure.add_subplot(grid[row, 0]) for row in range(len(states))]
    draw_curves(curves, trajectory, states)
    others = []
    if planar:
        _draw_plane(figure.add_subplot(grid[:, 1]), system, field, trajectory)
        others = [Line2D([], [], color=SURFACE, linestyle="--", label="switching surface")]
    figure.suptitle(
        title or f"{one_line(system.name)}: method {trajectory.method}", fontsize="medium", parse_math=False
    )
    explain(figure, trajectory, others if field.surfaces else ())
    return figure


def _draw_plane(axes: Axes, system: SwitchedSystem, field: SignField, trajectory: Trajectory) -> None:
    """The path over the switching surfaces."""
    left, right, low, high = _view(trajectory, float(system.check.radius))
    xs, ys = np.linspace(left, right, MESH), np.linspace(low, high, MESH)
    for surface in field.surfaces:
        heights = np.array([[surface.value(np.array([x, y])) for x in xs] for y in ys])
        if not heights.min() < 0 < heights.max():
            continue
        axes.contour(xs, ys, heights, levels=[0.0], colors=SURFACE, linestyles="--", linewidths=1.2, zorder=1)
    draw_path(axes, trajectory)
    x, y = system.stated_states
    axes.set(xlim=(left, right), ylim=(low, high), xlabel=x, ylabel=y, aspect="equal")


def _view(trajectory: Trajectory, radius: float) -> tuple[float, float, float, float]:
    """A square around the path; of the given half-width about a path that stays where it is."""
    states = trajectory.array
    centre = (states.min(axis=0) + states.max(axis=0)) / 2
    half = float(np.ptp(states, axis=0).max()) * (0.5 + MARGIN) or radius
    x, y = (float(value) for value in centre)
    return x - half, x + half, y - half, y + half
