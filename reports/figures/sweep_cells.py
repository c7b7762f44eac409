"""A map of cells that are certified as a whole, or left white."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.reports.figures.answer_colors import COLORS
from nonsmooth.reports.figures.labels import WIDE_TITLE, wrapped
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.sweeps.certified import CertifiedCell
from nonsmooth.reports.sweeps.table import counted, sweep_title
from nonsmooth.symbolic.number_text import float_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.sweep import Sweep

MAP, STRIP = (7.5, 6.8), (8.0, 2.2)  # inches
MOST_NAMED = 64  # cells beyond which their radii are not written in them


def build_cells(sweep: Sweep, cells: Sequence[CertifiedCell]) -> Figure:
    """The picture as a Matplotlib figure: over two numbers a map, over one a strip."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    is_map = len(sweep.plan.axes) == 2
    figure = Figure(figsize=MAP if is_map else STRIP, layout="constrained")
    axes = figure.subplots()
    for cell in cells:
        _draw_cell(axes, cell, named=len(cells) <= MOST_NAMED)
    axes.autoscale_view(tight=True)
    axes.set_xlabel(sweep.plan.names[0])
    if is_map:
        axes.set_ylabel(sweep.plan.names[1])
    else:
        axes.set_yticks([])
    title = f"{sweep_title(sweep)}\n{counted(sweep).rpartition('; ')[2]}"
    figure.suptitle(wrapped(title, WIDE_TITLE), fontsize="medium", parse_math=False)
    known = Patch(facecolor=COLORS["holds"], label="certified for every array in the cell (radius where bodies end)")
    open_ = Patch(facecolor="white", edgecolor=INK, label="not certified")
    figure.legend(handles=[known, open_], loc="outside lower center", ncols=2, frameon=False)
    return figure


def _draw_cell(axes: Axes, cell: CertifiedCell, *, named: bool) -> None:
    """A rectangle; of one number as high as the strip."""
    from matplotlib.patches import Rectangle

    (left, right), (low, high) = [(a.number, b.number) for a, b in cell.sides] + [(0.0, 1.0)] * (2 - len(cell.sides))
    color = COLORS["holds"] if cell.verdict is Certainty.CERTIFIED else "white"
    axes.add_patch(Rectangle((left, low), right - left, high - low, facecolor=color, edgecolor="0.75", linewidth=0.5))
    if named and cell.ends_within is not None:
        text = float_text(float(cell.ends_within), 2)
        axes.text((left + right) / 2, (low + high) / 2, text, ha="center", va="center", fontsize="x-small")
