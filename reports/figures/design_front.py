"""The Pareto front of a design: rate against the tolerances that are certified."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.reports.designs.front_views import front_headline
from nonsmooth.reports.designs.views import WHAT
from nonsmooth.reports.figures.answer_colors import COLORS
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.labels import WIDE_TITLE, wrapped
from nonsmooth.reports.figures.wheels import INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nonsmooth.reports.designs.front import Front
    from nonsmooth.symbolic.scene import Scene

SIZE = (7.0, 4.8)  # inches
FRONT, GIVEN = COLORS["holds"], COLORS["leaves"]


def front_figure(front: Front, scene: Scene, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_front(front, scene), suffix)


def build_front(front: Front, scene: Scene) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    axes.plot([p.rate for p in front.others], [p.tolerance for p in front.others], ".", color="0.7", label="beaten")
    xs, ys = [point.rate for point in front.points], [point.tolerance for point in front.points]
    axes.plot(xs, ys, "o-", color=FRONT, linewidth=1, drawstyle="steps-pre", label="front")
    for number, (x, y) in enumerate(zip(xs, ys, strict=True), 1):
        axes.annotate(str(number), (x, y), textcoords="offset points", xytext=(5, 5), color=INK, fontsize="small")
    if front.given is not None:
        axes.plot([front.given.rate], [front.given.tolerance], "s", color=GIVEN, label="the given array")
    axes.set(xlabel=WHAT["rate"], ylabel=WHAT["tolerance"])
    axes.legend(frameon=False)
    figure.suptitle(wrapped(front_headline(front, scene), WIDE_TITLE), fontsize="medium", parse_math=False)
    return figure
