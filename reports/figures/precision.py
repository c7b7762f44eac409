"""Work-precision diagrams: one log-log panel for each study, error across and processor time upwards.

Errors at or below a floor, exact zeros among them, stand as stars on a dotted line at the floor: a logarithm has no
place for them.  Methods that ran out of time or failed stand as open marks at the time limit, above their last error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.measurements.study import Row
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.precision import Measured, Precision

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#999999", "#222222")  # Okabe and Ito
MARKERS = "osD^vP<>X"
PANEL = (6.8, 3.6)  # inches, the legend beside it included
COLUMNS = 2
BELOW_ROUNDING = 1e-4  # of what counts as rounding: no errors are told apart below


def precision_figure(precision: Precision, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(precision), suffix)


def build_figure(precision: Precision) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    drawn = [measured for measured in precision.studies if any(row.setting is not None for row in measured.rows)]
    columns = min(COLUMNS, max(1, len(drawn)))
    rows = max(1, math.ceil(len(drawn) / columns))
    figure = Figure(figsize=(PANEL[0] * columns, PANEL[1] * rows + 0.8), layout="constrained")
    figure.suptitle(precision.head, fontsize="large", parse_math=False)
    for k, measured in enumerate(drawn):
        _draw(figure.add_subplot(rows, columns, k + 1), measured, precision.limits.seconds)
    if not drawn:
        figure.text(0.5, 0.5, "no rows with a setting to draw", ha="center")
    _explain(figure)
    return figure


def _draw(axes: Axes, measured: Measured, limit: float) -> None:
    """One study."""
    floor = _floor(measured)
    axes.set(xscale="log", yscale="log", xlabel=measured.study.quantity, ylabel="processor time [s]")
    axes.set_title(measured.study.title, fontsize="medium", loc="left")
    axes.grid(color="0.9", linewidth=0.6)
    methods = list(dict.fromkeys(row.method for row in measured.rows))
    largest = max((row.error for row in measured.rows if row.error), default=1.0)
    for k, method in enumerate(methods):
        style: dict[str, Any] = {"color": COLORS[k % len(COLORS)], "marker": MARKERS[k % len(MARKERS)]}
        own = [row for row in measured.rows if row.method == method]
        _draw_method(axes, own, (floor, max(largest, floor), limit), style)
    axes.axvline(floor, color="0.5", linewidth=0.8, linestyle=":", zorder=1)
    axes.axhline(limit, color="0.5", linewidth=0.8, linestyle="--", zorder=1)
    axes.margins(0.06)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small", borderaxespad=0)


def _draw_method(axes: Axes, rows: Sequence[Row], frame: tuple[float, float, float], style: dict[str, Any]) -> None:
    """The settings of a method, joined in their order; what has no result stands open at the time limit."""
    floor, largest, limit = frame
    points = [(max(row.error, floor), row.seconds) for row in rows if row.error is not None and row.seconds]
    exact = [point for point in points if point[0] <= floor]
    axes.plot(*_columns(points), markersize=5, linewidth=1.2, label=rows[0].method, **style)
    if exact:
        axes.plot(*_columns(exact), marker="*", color=style["color"], markersize=11, linestyle="none")
    if len(points) < len(rows):
        last = points[-1] if points else (largest, limit)
        axes.plot([last[0]] * 2, [last[1], limit], color=style["color"], linewidth=0.8, linestyle=":")
        axes.plot([last[0]], [limit], markersize=7, fillstyle="none", linestyle="none", **style)


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _floor(measured: Measured) -> float:
    """Where zero is drawn: a decade below the smallest error that is told from it."""
    rounding = measured.plan.rounding if measured.plan is not None else 1.0
    told = [row.error for row in measured.rows if row.error and row.error > rounding * BELOW_ROUNDING]
    return max(10.0 ** (math.floor(math.log10(min(told, default=1.0))) - 1), rounding * BELOW_ROUNDING)


def _explain(figure: Figure) -> None:
    """What the marks mean that no panel explains."""
    from matplotlib.lines import Line2D

    entries = [
        Line2D(
            [], [], marker="*", color=INK, linestyle=":", markersize=10, label="error 0, or below what is told from 0"
        ),
        Line2D([], [], marker="o", color=INK, linestyle="none", fillstyle="none", label="out of time or failed"),
        Line2D([], [], color="0.5", linestyle="--", label="time limit"),
    ]
    figure.legend(handles=entries, loc="outside lower center", ncols=len(entries), frameon=False)
