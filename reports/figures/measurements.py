"""Errors of measurements on logarithmic axes: work-precision diagrams of studies, and lines of points for cases.

The error is drawn across.  A study has one panel each with the processor time upwards, a stress test one panel with a
line for each case.  Errors at or below a floor, exact zeros among them, stand as stars on a dotted line at the floor: a
logarithm has no place for them.  Results without an error stand open: at the time limit, above a method's last error,
or at the floor of a case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.measurements.harness import Measured
from nonsmooth.analysis.measurements.rows import ResultRow
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.measurements import MeasurementView, Precision, study_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#999999", "#222222")  # Okabe and Ito
MARKERS = "osD^vP<>X"
PANEL = (6.8, 3.6)  # inches, the legend beside it included
COLUMNS = 2
BELOW_ROUNDING = 1e-4  # of what counts as rounding: no errors are told apart below
NOTHING, LARGEST = 1e-20, 10.0  # where the error of a case is drawn that is zero, and one that is larger or no number
CASE_HEIGHT = 0.24  # inches

Points = list[tuple[float, float]]


@dataclass(frozen=True)
class Series:
    """Points of errors and heights: of one method, or of the cases that are ok; ``open`` are those without error."""

    label: str
    points: Points
    open: Points
    joined: bool = False


@dataclass(frozen=True)
class Panel:
    """One pair of axes; heights are processor times with a limit, or places of the cases that are named."""

    title: str
    quantity: str
    floor: float
    series: tuple[Series, ...]
    limit: float | None = None
    cases: tuple[str, ...] = ()

    @property
    def height(self) -> float:
        """Inches."""
        return 1.0 + CASE_HEIGHT * len(self.cases) if self.cases else PANEL[1]


def measurement_figure(view: MeasurementView, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(view), suffix)


def build_figure(view: MeasurementView) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    panels = _study_panels(view) if isinstance(view, Precision) else [_case_panel(view.run.rows)]
    columns = min(COLUMNS, max(1, len(panels)))
    rows = max(1, math.ceil(len(panels) / columns))
    height = max((panel.height for panel in panels), default=PANEL[1])
    figure = Figure(figsize=(PANEL[0] * columns, height * rows + 0.8), layout="constrained")
    figure.suptitle(view.head, fontsize="large", parse_math=False)
    for k, panel in enumerate(panels):
        _draw(figure.add_subplot(rows, columns, k + 1), panel)
    if not panels:
        figure.text(0.5, 0.5, "no rows with a setting to draw", ha="center")
    _explain(figure, timed=isinstance(view, Precision))
    return figure


# ---- what is drawn -------------------------------------------------------------------------------


def _study_panels(view: MeasurementView) -> list[Panel]:
    drawn = [measured for measured in view.run.measured if any(row.setting is not None for row in measured.rows)]
    return [_study_panel(measured, view.run.limits.seconds) for measured in drawn]


def _study_panel(measured: Measured[Any], limit: float) -> Panel:
    study, floor = study_of(measured), _floor(measured)
    largest = max((row.error for row in measured.rows if row.error), default=1.0)
    methods = dict.fromkeys(row.method for row in measured.rows)
    series = []
    for method in methods:
        own = [row for row in measured.rows if row.method == method]
        points = [(row.error, row.seconds) for row in own if row.error is not None and row.seconds]
        last = max(points[-1][0], floor) if points else max(largest, floor)
        series.append(Series(method, points, [(last, limit)] if len(points) < len(own) else [], joined=True))
    return Panel(study.title, study.quantity, floor, tuple(series), limit)


def _floor(measured: Measured[Any]) -> float:
    """Where zero is drawn: a decade below the smallest error that is told from it."""
    rounding = measured.plan.rounding if measured.plan is not None else 1.0
    told = [row.error for row in measured.rows if row.error and row.error > rounding * BELOW_ROUNDING]
    return max(10.0 ** (math.floor(math.log10(min(told, default=1.0))) - 1), rounding * BELOW_ROUNDING)


def _case_panel(rows: Sequence[ResultRow]) -> Panel:
    cases = tuple(dict.fromkeys(row.name for row in rows))
    series = []
    for label, ok in (("ok", True), ("not ok", False)):
        own = [(row.error, float(cases.index(row.name))) for row in rows if row.ok is ok]
        points = [(min(x, LARGEST) if math.isfinite(x) else LARGEST, y) for x, y in own if x is not None]
        series.append(Series(label, points, [(NOTHING, y) for x, y in own if x is None]))
    return Panel("", "relative error against exact or 60-digit arithmetic", NOTHING, tuple(series), cases=cases)


# ---- drawing -------------------------------------------------------------------------------------


def _draw(axes: Axes, panel: Panel) -> None:
    axes.set(xscale="log", xlabel=panel.quantity)
    axes.set_title(panel.title, fontsize="medium", loc="left")
    axes.grid(color="0.9", linewidth=0.6)
    for k, series in enumerate(panel.series):
        style = {"color": COLORS[k % len(COLORS)], "marker": MARKERS[k % len(MARKERS)]}
        _draw_series(axes, series, panel.floor, style)
    axes.axvline(panel.floor, color="0.5", linewidth=0.8, linestyle=":", zorder=1)
    if panel.limit is not None:
        axes.set(yscale="log", ylabel="processor time [s]")
        axes.axhline(panel.limit, color="0.5", linewidth=0.8, linestyle="--", zorder=1)
    else:
        axes.set_yticks(range(len(panel.cases)), panel.cases)
        axes.invert_yaxis()
    axes.margins(0.06)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small", borderaxespad=0)


def _draw_series(axes: Axes, series: Series, floor: float, style: dict[str, Any]) -> None:
    points = [(max(x, floor), y) for x, y in series.points]
    exact = [point for point in points if point[0] <= floor]
    line = {"linewidth": 1.2} if series.joined else {"linestyle": "none"}
    axes.plot(*_columns(points), markersize=5, label=series.label, **line, **style)
    if exact:
        axes.plot(*_columns(exact), marker="*", color=style["color"], markersize=11, linestyle="none")
    if series.open:
        if series.joined:
            stem = [points[-1] if points else series.open[0], series.open[0]]
            axes.plot(*_columns(stem), color=style["color"], linewidth=0.8, linestyle=":")
        axes.plot(*_columns(series.open), markersize=7, fillstyle="none", linestyle="none", **style)


def _columns(points: Points) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]


def _explain(figure: Figure, *, timed: bool) -> None:
    """What the marks mean that no panel explains."""
    from matplotlib.lines import Line2D

    zero = "error 0, or below what is told from 0"
    without = "out of time or failed" if timed else "no error to measure, such as a refusal"
    entries = [
        Line2D([], [], marker="*", color=INK, linestyle=":", markersize=10, label=zero),
        Line2D([], [], marker="o", color=INK, linestyle="none", fillstyle="none", label=without),
    ]
    if timed:
        entries.append(Line2D([], [], color="0.5", linestyle="--", label="time limit"))
    figure.legend(handles=entries, loc="outside lower center", ncols=len(entries), frameon=False)
