"""The closed loop of imposed twists as a picture: x, y and theta over time, and the path."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.labels import WIDE_TITLE, centre_labels, pose_labels, time_label, wrapped
from nonsmooth.reports.figures.trajectory import SIZE, draw_curves, draw_path, explain
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def driven_loop_figure(scene: Scene, path: Trajectory, suffix: str) -> bytes:
    """The picture as the bytes of a file; poses are measured from the checked point."""
    return figure_bytes(lambda: build_driven_figure(scene, path), suffix)


def build_driven_figure(scene: Scene, path: Trajectory) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.1))
    curves = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    draw_curves(curves, path, pose_labels(scene.units), time_label("t", scene.units))
    plane = figure.add_subplot(grid[:, 1])
    draw_path(plane, path)
    plane.plot([0], [0], marker="+", color=INK, markersize=10)
    plane.set(aspect="equal", **centre_labels(scene.units))
    plane.margins(0.2)
    title = f"{one_line(scene.name)}: rule {scene.contact.rule}, certified law, measured from the checked point"
    figure.suptitle(wrapped(title, WIDE_TITLE), fontsize="medium", parse_math=False)
    explain(figure, path)
    return figure
