"""The picture of a vehicle: its wheels with slips and forces, and the instant centres over the commanded curvature."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.reports.figures.style import (
    INK,
    LINES,
    Floats,
    legend_below,
    length_label,
    new_figure,
    wrapped,
)
from nonsmooth.reports.figures.wheels import draw_wheel
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.plane import in_floats
from nonsmooth.symbolic.numbers.plane_arrays import float_points, turned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.analysis.bodies.vehicles import CurvedMotion, VehicleMotion

RIM = 0.05  # half of a rim's length, of the width of the view
REACH = 0.22  # length of the largest arrow, of the width of the view
ROUNDING = 1e-9  # slips beside the largest speed, and forces beside the weight, that are no more than rounding


def vehicle_figure(motion: VehicleMotion, turns: Sequence[CurvedMotion]) -> Figure:
    """Wheels with slips and forces; beside them the instant centres, where there are turns."""
    figure = new_figure(10 if turns else 5.5, 5.5)
    panels = figure.subplots(1, 2 if turns else 1, squeeze=False)[0]
    draw_vehicle(panels[0], motion)
    legend_below(figure, panels[0].get_legend_handles_labels()[0], 4, fontsize="small")
    if turns:
        _draw_turns(panels[1], turns)
    return figure


def draw_vehicle(axes: Axes, motion: VehicleMotion) -> None:
    """Wheels with slips and forces, the centre of mass and the instant centre."""
    scene = motion.vehicle.scene
    places = float_points(wheel.position for wheel in scene.wheels)
    half = 0.75 * float(np.ptp(places, axis=0).max())
    x, y = (places.min(axis=0) + places.max(axis=0)) / 2
    for wheel in scene.wheels:
        draw_wheel(axes, wheel, 2 * half * RIM, named=len(scene.wheels) <= 12)
    along = float_points(wheel.unit_grip for wheel in scene.wheels)
    frames = np.stack([along, turned(along)], axis=1)
    fastest = max(abs(float(wheel.speed)) for wheel in scene.wheels)
    _draw_arrows(axes, places, frames, motion.slips, fastest, 2 * half * REACH, LINES[1], "slip over the ground")
    _draw_arrows(axes, places, frames, motion.forces, 1.0, 2 * half * REACH, LINES[0], "friction force")
    centre = in_floats(motion.vehicle.centre_of_mass)
    axes.plot(*centre, marker="+", color=INK, markersize=11, linestyle="none", label="centre of mass")
    if motion.icr is not None:
        axes.plot(*motion.icr, "o", color=LINES[2], fillstyle="none", label="instant centre")
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), aspect="equal")
    axes.set(xlabel=length_label("x (forward)", scene.units), ylabel=length_label("y (left)", scene.units))
    axes.set_title(wrapped(f"{one_line(scene.name)}, rule {motion.rule.name}"), parse_math=False, fontsize="medium")


def _draw_arrows(
    axes: Axes, places: Floats, frames: Floats, parts: Floats | None, scale: float, reach: float, color: str, label: str
) -> None:
    """Vectors (n, 2) given along and across the friction axes, the longest as long as ``reach``.

    None are drawn where all are rounding beside the scale.
    """
    if parts is None or np.abs(parts).max() <= ROUNDING * scale:
        return
    vectors = (parts[:, :, None] * frames).sum(axis=1)
    vectors *= reach / np.hypot(*vectors.T).max()
    axes.quiver(
        *places.T, *vectors.T, angles="xy", scale_units="xy", scale=1, color=color, width=0.006, label=label, zorder=4
    )


def _draw_turns(axes: Axes, turns: Sequence[CurvedMotion]) -> None:
    """Instant centres over the share of turning: 0 straight on, 1 in place."""
    share = [2 / np.pi * np.arctan2(turn.right - turn.left, turn.right + turn.left) for turn in turns]
    reach = 4 * max(abs(turn.left_centre or 0) for turn in turns)
    own = [turn.icr[1] if turn.icr is not None and abs(turn.icr[1]) <= reach else None for turn in turns]
    treads = {"left tread": [turn.left_centre for turn in turns], "right tread": [turn.right_centre for turn in turns]}
    for color, (label, centres) in zip(LINES, (treads | {"vehicle": own}).items(), strict=False):
        points = [(x, y) for x, y in zip(share, centres, strict=True) if y is not None]
        if points:
            axes.plot(*zip(*points, strict=True), marker=".", color=color, label=label)
    axes.set(xlabel="commanded turn: 0 straight on, 1 in place", ylabel="y of the instant centre", xlim=(0, 1.02))
    axes.set_title("instant centres of rotation, sampled", fontsize="medium")
    axes.grid(color="0.9", linewidth=0.6)
    if axes.lines:
        axes.legend(frameon=False, fontsize="small")
