"""The sampled field of a rule without cells: streamlines of the centre of mass over the upper derivative V*.

Colors run as in the map of rates over cells, from violet (V falls) to orange (V grows), white where V* vanishes; dots
cover where the body rests, and what is not determined stays blank.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.sampled_field import SampledField
from nonsmooth.reports.figures.cell_map import MARGIN, PICTURE, RIM
from nonsmooth.reports.figures.labels import centre_labels, wrapped
from nonsmooth.reports.figures.rate_map import COLORS, bands_of, symmetric
from nonsmooth.reports.figures.wheels import INK, draw_wheel, floats, wheels_in_view
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure

TINT = 0.7  # opacity of the bands, so that lines stay visible on them
DENSITY = 1.1  # of streamlines
DOT = 2.0  # points: where the body rests


def build_figure(field: SampledField) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PICTURE + 0.7, PICTURE - 0.2), layout="constrained")
    axes = figure.subplots()
    bands = draw_field(axes, field)
    if bands is not None:
        unit = field.scene.units
        bar = figure.colorbar(bands, ax=axes, shrink=0.85, format="%.3g")
        bar.set_label(f"upper derivative V*, sampled [{unit.length or 'length'}²/{unit.time or 'time'}]")
    return figure


def draw_field(axes: Axes, field: SampledField) -> QuadContourSet | None:
    """Bands of V* with streamlines, the wheels in view and the checked point; returns the bands, if any."""
    scene = field.scene
    centre, radius = floats(scene.check.equilibrium), float(scene.check.radius)
    room = radius * (1 + 2 * MARGIN)
    axes.set(xlim=(centre[0] - room, centre[0] + room), ylim=(centre[1] - room, centre[1] + room), aspect="equal")
    axes.set(**centre_labels(scene.units))
    bands = _draw_bands(axes, field)
    _draw_streamlines(axes, field)
    resting = field.points[field.rests]
    if len(resting):
        axes.plot(*resting.T, linestyle="none", marker="o", markersize=DOT, color=INK, zorder=3)
    for wheel in wheels_in_view(axes, scene.wheels):
        draw_wheel(axes, wheel, 2 * RIM * room)
    axes.plot(*centre, marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)
    title = f"{one_line(scene.name)}: rule {scene.contact.rule}, field sampled at {field.count} x {field.count} points"
    axes.set_title(wrapped(title), parse_math=False)
    return bands


def _draw_bands(axes: Axes, field: SampledField) -> QuadContourSet | None:
    """V* in colors symmetric about zero; nothing where the body rests everywhere."""
    rates = field.upper_derivative
    largest = float(np.nanmax(np.abs(rates), initial=0.0))
    if not largest:
        return None
    x, y = (_square(field, column) for column in field.points.T)
    levels = bands_of(rates[field.is_determined])
    found = np.ma.masked_invalid(np.clip(_square(field, rates), levels[0], levels[-1]))
    return axes.contourf(x, y, found, levels=levels, cmap=COLORS, norm=symmetric(levels), alpha=TINT, zorder=1)


def _draw_streamlines(axes: Axes, field: SampledField) -> None:
    """Where the body moves; lines stop where it rests."""
    moving = field.is_determined & ~field.rests
    if not moving.any():
        return
    shown = np.where(moving[:, None], field.velocities, np.nan)
    x, y = (_square(field, column) for column in field.points.T)
    u, v = (np.ma.masked_invalid(_square(field, column)) for column in shown.T)
    axes.streamplot(x[0], y[:, 0], u, v, color=INK, density=DENSITY, linewidth=0.8, arrowsize=0.8, zorder=2)


def _square(field: SampledField, values: Floats) -> Floats:
    return values.reshape(field.count, field.count)
