"""A sampled map of a body with an outline: starts by where they end, and the body at its destinations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.bodies.destinations import PathEnd
from nonsmooth.analysis.bodies.many_paths import BodyEnd
from nonsmooth.reports.figures.cell_map import PALETTE
from nonsmooth.reports.figures.labels import WIDE_TITLE, centre_labels, length_label, wrapped
from nonsmooth.reports.figures.outline import outline_of, placed
from nonsmooth.reports.figures.wheels import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    from nonsmooth.reports.body_maps import BodyMapResult

SIZE = (12.0, 6.0)  # inches, without the legend
LINE = 0.22  # inches for each line of the legend
COLORS = PALETTE[:-1]
OTHERS = "#BBBBBB"  # places of rest beyond the palette
TIPS = "#FFFFFF"  # under a hatch
MOVING = "#666666"
HATCH = "xxxx"
CELL = 0.9  # of the distance between starts: side of a hatched mark
NEAR = 1.3  # the destinations' view, in sizes of the body around them


def build_figure(shown: BodyMapResult) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    entries = _legend(shown.destinations)
    figure = Figure(figsize=(SIZE[0], SIZE[1] + LINE * -(-len(entries) // 2)), layout="compressed")
    starts, ends = figure.subplots(1, 2)
    draw_starts(starts, shown)
    _draw_bodies(ends, shown)
    _draw_wheels(starts, shown)
    _draw_wheels(ends, shown)
    units = shown.scene.units
    starts.set(xlabel=length_label("x at the start", units), ylabel=length_label("y at the start", units))
    ends.set(**centre_labels(units))
    head = f"{shown.title}: {shown.head} at theta = {shown.options.heading:.6g}, sampled"
    figure.suptitle(wrapped(f"{head}\n{shown.summary()}", WIDE_TITLE), fontsize="medium", parse_math=False)
    figure.legend(handles=entries, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _colors(found: list[PathEnd]) -> list[str]:
    """One for each destination."""
    colors = []
    for k, one in enumerate(found):
        if one.reason is BodyEnd.REST:
            colors.append(COLORS[k] if k < len(COLORS) else OTHERS)
        else:
            colors.append(TIPS if one.reason in {BodyEnd.TIPS, BodyEnd.LEAVES} else MOVING)
    return colors


def draw_starts(axes: Axes, shown: BodyMapResult) -> None:
    """Starts by color; those that tip are hatched."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Rectangle

    points = shown.found.starts[:, :2]
    count = math.isqrt(len(points))
    steps = (points.max(axis=0) - points.min(axis=0)) / (count - 1)
    (left, low), (right, high) = points.min(axis=0) - steps / 2, points.max(axis=0) + steps / 2
    table = np.array([to_rgb(color) for color in _colors(shown.destinations)])
    image = table[shown.destination_of].reshape(count, count, 3)
    extent = (float(left), float(right), float(low), float(high))
    axes.imshow(image, origin="lower", extent=extent, interpolation="nearest", zorder=0)
    fallen = shown.found.by(BodyEnd.TIPS) | shown.found.by(BodyEnd.LEAVES)
    for x, y in points[fallen] - CELL * steps / 2:
        axes.add_patch(Rectangle((x, y), *(CELL * steps), fill=False, hatch=HATCH, edgecolor=INK, linewidth=0.0))
    axes.set(xlim=extent[:2], ylim=extent[2:], aspect="equal", title="where a start ends")


def _draw_bodies(axes: Axes, shown: BodyMapResult) -> None:
    """The outline at each destination: at the middle heading, and faintly at the outermost ones."""
    outline = outline_of(shown.scene)
    axes.set(aspect="equal", title="the body at its destinations")
    resting = [(one, color) for one, color in zip(shown.destinations, _colors(shown.destinations), strict=True)]
    resting = [(one, color) for one, color in resting if one.pose is not None][: len(COLORS)]
    if outline is None or not resting:
        return
    reach = float(np.hypot(*outline.T).max())
    for one, color in resting:
        x, y, theta = one.pose or (0.0, 0.0, 0.0)
        for heading in one.headings or ():
            axes.fill(*placed(outline, np.array([x, y, heading])).T, fill=False, edgecolor=color, alpha=0.5, zorder=2)
        axes.fill(*placed(outline, np.array([x, y, theta])).T, fill=False, edgecolor=color, linewidth=2.0, zorder=3)
        nose = np.array([x, y]) + 0.5 * reach * np.array([np.cos(theta), np.sin(theta)])
        arrow = axes.annotate("", xy=tuple(nose), xytext=(x, y), arrowprops={"arrowstyle": "-|>", "color": color})
        arrow.set_in_layout(False)
    centres = np.array([one.pose[:2] for one, _ in resting if one.pose is not None])
    low, high = centres.min(axis=0) - NEAR * reach, centres.max(axis=0) + NEAR * reach
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _draw_wheels(axes: Axes, shown: BodyMapResult) -> None:
    """Contacts as dots; the view stays."""
    limits = axes.get_xlim(), axes.get_ylim()
    places = np.array([[float(x) for x in wheel.position] for wheel in shown.scene.wheels])
    axes.plot(*places.T, linestyle="none", marker=".", markersize=3, color=INK, zorder=5)
    axes.set(xlim=limits[0], ylim=limits[1])


def _legend(found: list[PathEnd]) -> list[Patch]:
    """An entry for each color."""
    from matplotlib.patches import Patch

    entries, others = [], list[PathEnd]()
    for k, (one, color) in enumerate(zip(found, _colors(found), strict=True)):
        if one.reason is BodyEnd.REST and k >= len(COLORS):
            others.append(one)
            continue
        hatch = HATCH if color == TIPS else None
        entries.append(Patch(facecolor=color, edgecolor=INK, hatch=hatch, label=f"{100 * one.share:.3g} %: {one.text}"))
    if others:
        share = 100 * sum(one.share for one in others)
        entries.append(Patch(facecolor=OTHERS, label=f"{share:.3g} %: {len(others)} other places of rest"))
    return entries
