"""Full dynamics as pictures: a path beside that of rule ellipse, and distances from every rule over mass."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.bodies.mass_study import MassStudy, massless_limit, rules_by_limit
from nonsmooth.analysis.contact_rule import smooth_rules
from nonsmooth.analysis.dynamics.newton_euler import DynamicPath
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.labels import WIDE_TITLE, centre_labels, length_label, pose_labels, time_label, wrapped
from nonsmooth.reports.figures.outline import outline_of, placed
from nonsmooth.reports.figures.wheels import INK, draw_axis, floats
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.units import Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (9.6, 5.6)  # inches
SMALL = (6.4, 5.0)  # inches
SAMPLES = 600  # times at which curves are drawn
BODY: dict[str, Any] = {"color": "#0072B2", "linewidth": 1.8, "label": "full dynamics"}
RULE: dict[str, Any] = {"color": "#D55E00", "linewidth": 1.4, "linestyle": "--", "label": "rule ellipse (mass 0)"}
MOST_OUTLINES = 20  # events at which the body is drawn
RIM = 0.07  # half the length of a drawn rim, as a share of the array
MARKS = (("#D55E00", "o"), ("#0072B2", "s"), ("#009E73", "^"), ("#CC79A7", "D"), ("#56B4E9", "v"), ("#E69F00", "P"))


def path_figure(scene: Scene, path: DynamicPath, suffix: str) -> bytes:
    """A body with mass, beside the rule that is the limit without mass where its path can be followed.

    ``suffix`` is that of the file, as for the cell map.
    """
    drawn = [(path.trajectory, BODY)]
    limit = next(rule for rule in smooth_rules() if rule.is_massless_limit)
    with suppress(TrajectoryError):
        drawn.append((limit.path(scene, path.trajectory.states[0], float(path.trajectory.end.t)), RULE))
    title = f"{one_line(scene.name)}: full dynamics, mass {path.body.mass:.6g}, inertia {path.body.inertia:.6g}"
    return figure_bytes(lambda: _build_path_figure(scene, title, drawn), suffix)


def rule_path_figure(scene: Scene, path: Trajectory, suffix: str) -> bytes:
    """A path under a rule without cells, alone."""
    style = {**RULE, "label": f"rule {scene.contact.rule}", "linestyle": "-"}
    title = f"{one_line(scene.name)}: rule {scene.contact.rule}, {path.kinematics} kinematics"
    return figure_bytes(lambda: _build_path_figure(scene, title, [(path, style)]), suffix)


def _build_path_figure(scene: Scene, title: str, drawn: Sequence[tuple[Trajectory, dict[str, Any]]]) -> Figure:
    """x, y and theta over time, and between the wheels the paths and the body of the first of them."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.1))
    curves = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    plane = figure.add_subplot(grid[:, 1])
    for axes, label in zip(curves, pose_labels(scene.units), strict=True):
        axes.axhline(0, color="0.8", linewidth=0.8, zorder=0)
        axes.set_ylabel(label)
        axes.margins(x=0.02, y=0.15)
        axes.sharex(curves[0])
        axes.tick_params(labelbottom=axes is curves[-1])
    curves[-1].set_xlabel(time_label("t", scene.units))
    for path, style in drawn:
        times = np.linspace(0.0, float(path.end.t), SAMPLES)
        states = path.sample(times)
        for k, axes in enumerate(curves):
            axes.plot(times, states[:, k], **style)
        plane.plot(states[:, 0], states[:, 1], **style, zorder=3)
    _draw_wheels(plane, contact_model(scene))
    first = drawn[0][0]
    plane.plot(*first.states[0][:2], marker=">", color=INK, markersize=7, linestyle="none", label="start", zorder=4)
    plane.set(aspect="equal", **centre_labels(scene.units))
    figure.suptitle(wrapped(title, WIDE_TITLE), fontsize="medium", parse_math=False)
    figure.legend(*plane.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    _draw_outlines(plane, scene, first)
    return figure


def _draw_wheels(axes: Axes, model: ContactModel) -> None:
    """Rims as thick lines, and the friction axes of wheels that have some."""
    half = RIM * float(np.ptp(model.positions, axis=0).max()) * model.rims
    for k, (start, end) in enumerate(zip(model.positions - half, model.positions + half, strict=True)):
        label = "rim of a wheel" if k == 0 else None
        axes.plot(*zip(start, end, strict=True), color="0.45", linewidth=4, solid_capstyle="butt", label=label)
    for k in np.flatnonzero(model.heads[:, 1]).tolist():
        draw_axis(axes, floats(model.positions[k]), floats(model.axes[k]), float(np.hypot(*half[k])))


def _draw_outlines(axes: Axes, scene: Scene, path: Trajectory) -> None:
    """The body where it starts, at its events, and where it ends."""
    outline = outline_of(scene)
    if outline is None:
        return
    poses = [path.states[0], *(event.state for event in path.events[:MOST_OUTLINES]), path.end.state]
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


def masses_figure(scene: Scene, study: MassStudy, suffix: str) -> bytes:
    """Distances over mass; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_masses_figure(one_line(scene.name), study, scene.units), suffix)


def build_masses_figure(name: str, study: MassStudy, units: Units) -> Figure:
    """The picture as a Matplotlib figure: one curve per rule, a line at the limit of those that do not fall to zero."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SMALL, layout="constrained")
    axes = figure.add_subplot()
    masses = [row.body.mass for row in study.rows]
    marks = dict(zip(rules_by_limit(), cycle(MARKS), strict=False))
    for rule, (color, marker) in marks.items():
        if rule not in study.skipped:
            distances = [row.distance(rule).position for row in study.rows]
            axes.plot(masses, distances, color=color, marker=marker, label=f"from rule {rule}")
    for limit in study.limits or ():
        axes.axhline(limit.position, color=marks[limit.rule][0], linewidth=1, linestyle=":")
    if study.limits is not None:
        nearest = study.rows[-1].distance(massless_limit()).position
        slope = [nearest * mass / masses[-1] for mass in masses]
        axes.plot(masses, slope, color="0.6", linewidth=1, linestyle="--", zorder=0, label="in proportion to mass")
    axes.set(
        xscale="log", yscale="log", xlabel=f"mass per weight, 1/g [{units.time or 'time'}²/{units.length or 'length'}]"
    )
    axes.set_ylabel(length_label("largest distance of the paths", units))
    axes.set_title(f"{name}: full dynamics and the contact rules", fontsize="medium", parse_math=False)
    axes.grid(color="0.92")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure
