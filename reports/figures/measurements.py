"""Errors of measurements across a logarithmic axis: work-precision diagrams of studies, and a line for each case.

Errors at or below a floor, exact zeros among them, stand as stars on a dotted line at the floor: a logarithm has no
place for them.  Results without an error stand open: those of a study at its time limit, above the method's last error,
those of a case at the floor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.measurements.harness import Measured, ResultRow, Run
from nonsmooth.reports.figures.style import LINES, legend_below, line_entry, mark_entry, new_figure
from nonsmooth.symbolic.numbers.plane import XY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "osD^vP<>X"
PANEL = (6.8, 3.6)  # inches, the legend beside it included
COLUMNS = 2
BELOW_ROUNDING = 1e-4  # of what counts as rounding: no errors are told apart below
NOTHING, LARGEST = 1e-20, 10.0  # where the error of a case is drawn that is zero, and one that is larger or no number
CASE_HEIGHT = 0.24  # inches

Points = list[XY]


def measurements_figure(head: str, run: Run, *, of_studies: bool) -> Figure:
    """The picture as a Matplotlib figure: one panel for each study, or one for all cases."""
    studies = [measured for measured in run.measured if any(row.setting is not None for row in measured.rows)]
    cases = list(dict.fromkeys(row.name for row in run.rows))
    panels = max(1, len(studies)) if of_studies else 1
    columns, rows = min(COLUMNS, panels), math.ceil(panels / COLUMNS)
    height = PANEL[1] if of_studies else 1.0 + CASE_HEIGHT * len(cases)
    figure = new_figure(PANEL[0] * columns, height * rows + 0.8)
    figure.suptitle(head, fontsize="large", parse_math=False)
    if not of_studies:
        draw_cases(figure.add_subplot(), run.rows)
    elif not studies:
        figure.text(0.5, 0.5, "no rows with a setting to draw", ha="center")
    else:
        for k, measured in enumerate(studies):
            _draw_study(figure.add_subplot(rows, columns, k + 1), measured, run.limits.seconds)
    _explain(figure, of_studies)
    return figure


def _draw_study(axes: Axes, measured: Measured, limit: float) -> None:
    """Error and processor time; the settings of a method are joined in their order."""
    study, floor = measured.study, _floor(measured)
    axes.set(xlabel=study.quantity, ylabel="processor time [s]", yscale="log")
    axes.set_title(study.title, fontsize="medium", loc="left")
    largest = max((row.error for row in measured.rows if row.error), default=1.0)
    for k, method in enumerate(dict.fromkeys(row.method for row in measured.rows)):
        own = [row for row in measured.rows if row.method == method]
        points = [(max(row.error, floor), row.seconds) for row in own if row.error is not None and row.seconds]
        without = []
        if len(points) < len(own):
            x, y = points[-1] if points else (max(largest, floor), limit)
            without = [(x, limit)]
            axes.plot([x, x], [y, limit], color=LINES[k % len(LINES)], linewidth=0.8, linestyle=":")
        _draw_series(axes, k, method, points, without, floor, "-")
    axes.axhline(limit, color="0.5", linewidth=0.8, linestyle="--", zorder=1)
    _finish(axes, floor)


def draw_cases(axes: Axes, rows: Sequence[ResultRow]) -> None:
    """Error and case."""
    cases = list(dict.fromkeys(row.name for row in rows))
    axes.set(xlabel="relative error against exact or 60-digit arithmetic")
    axes.set_yticks(range(len(cases)), cases)
    for k, (label, ok) in enumerate((("ok", True), ("not ok", False))):
        own = [(row.error, float(cases.index(row.name))) for row in rows if row.ok is ok]
        points = [(max(min(x, LARGEST), NOTHING) if math.isfinite(x) else LARGEST, y) for x, y in own if x is not None]
        _draw_series(axes, k, label, points, [(NOTHING, y) for x, y in own if x is None], NOTHING, "none")
    axes.invert_yaxis()
    _finish(axes, NOTHING)


def _draw_series(axes: Axes, k: int, label: str, points: Points, without: Points, floor: float, linestyle: str) -> None:
    """Points of the k-th color and marker, stars on those at the floor, and open marks for results without an error."""
    color, marker = LINES[k % len(LINES)], MARKERS[k % len(MARKERS)]
    style: dict[str, Any] = {"color": color, "marker": marker}
    axes.plot(*_columns(points), markersize=5, linewidth=1.2, linestyle=linestyle, label=label, **style)
    zero = [point for point in points if point[0] <= floor]
    if zero:
        axes.plot(*_columns(zero), marker="*", color=color, markersize=11, linestyle="none")
    if without:
        axes.plot(*_columns(without), markersize=7, fillstyle="none", linestyle="none", **style)


def _columns(points: Points) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _finish(axes: Axes, floor: float) -> None:
    axes.set_xscale("log")
    axes.grid(color="0.9", linewidth=0.6)
    axes.axvline(floor, color="0.5", linewidth=0.8, linestyle=":", zorder=1)
    axes.margins(0.06)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small", borderaxespad=0)


def _floor(measured: Measured) -> float:
    """Where zero is drawn: a decade below the smallest error that is told from it."""
    rounding = measured.plan.rounding if measured.plan is not None else 1.0
    told = [row.error for row in measured.rows if row.error and row.error > rounding * BELOW_ROUNDING]
    return max(10.0 ** (math.floor(math.log10(min(told, default=1.0))) - 1), rounding * BELOW_ROUNDING)


def _explain(figure: Figure, of_studies: bool) -> None:
    """What the marks mean that no panel explains."""
    zero = "error 0, or below what is told from 0"
    without = "out of time or failed" if of_studies else "without an error, such as a refusal"
    entries = [
        mark_entry("*", zero, linestyle=":", markersize=10),
        mark_entry("o", without, fillstyle="none"),
    ]
    if of_studies:
        entries.append(line_entry("time limit", color="0.5", linestyle="--"))
    legend_below(figure, entries, len(entries))
