"""Measurements as the commands ``precision`` and ``stress`` show them: JSON, CSV, a picture, and tables."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import Group, RenderableType
from rich.table import Table as TerminalTable
from rich.text import Text

from nonsmooth.analysis.measurements.harness import FittedSlope, Measured, ResultRow, Run
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import LINES, legend_below, line_entry, mark_entry, new_figure
from nonsmooth.reports.output.console import INTERRUPTED
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.terminal import header_table
from nonsmooth.reports.studies.result import DataTable, Result
from nonsmooth.symbolic.mechanics.scene import Scene, require_known_loads
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_text import measured_text
from nonsmooth.symbolic.numbers.plane import XY
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_plane, require_single

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LEGEND = (
    "error: relative, against exact or 60-digit arithmetic; condition: factor by which rounding of the input grows; "
    "a dash: nothing was computed, or no system is solved"
)


def measurable(scene: Scene | SwitchedSystem) -> Scene | SwitchedSystem:
    """An array, or a plain system in two states.

    Raises:
        SceneError: for what nothing can be measured of.
    """
    if scene.kind is SceneKind.SYSTEM:
        require_plane(scene)
        require_single(scene)
    else:
        require_known_loads(scene, "to measure errors")
    return scene


@dataclass(frozen=True, repr=False)
class MeasurementResult(Result):
    """A run of measurements: what both commands share."""

    run: Run
    keys: ClassVar[Mapping[str, str]]  # key of a row in JSON and CSV: attribute of a ResultRow

    @property
    @abstractmethod
    def head(self) -> str:
        """What was measured, in one line."""

    def row_records(self) -> list[Record]:
        """The rows; numbers that are none become null."""
        rows = self.run.rows
        return [{key: _plain(getattr(row, attribute)) for key, attribute in self.keys.items()} for row in rows]

    def table(self) -> DataTable:
        """The rows; named numbers as ``name=value`` pairs."""
        lines = []
        for entry in self.row_records():
            lines.append([_pairs(value) if isinstance(value, dict) else value for value in entry.values()])
        return DataTable(tuple(self.keys), lines)

    def blocks(self) -> Sequence[Block]:
        """The rows."""
        names, lines = self.table()
        rows = [["" if value is None else str(value) for value in line] for line in lines]
        return [*sentences(self.head), table(names, rows)]

    def draw(self, ax: Axes) -> None:
        """The errors of all rows, one line for each name."""
        rows = self.run.rows
        cases = list(dict.fromkeys(row.name for row in rows))
        ax.set(xlabel="relative error against exact or 60-digit arithmetic")
        ax.set_yticks(range(len(cases)), cases)
        for k, (label, ok) in enumerate((("ok", True), ("not ok", False))):
            series = [(row.error, float(cases.index(row.name))) for row in rows if row.ok is ok]
            points = [
                (max(min(x, LARGEST), NOTHING) if math.isfinite(x) else LARGEST, y) for x, y in series if x is not None
            ]
            _draw_series(ax, k, label, points, [(NOTHING, y) for x, y in series if x is None], NOTHING, "none")
        ax.invert_yaxis()
        _finish(ax, NOTHING)

    def figure(self) -> Figure:
        """The errors: a panel for each study, or one for all cases."""
        run, of_studies = self.run, isinstance(self, Precision)
        studies = [measured for measured in run.measured if any(row.setting is not None for row in measured.rows)]
        cases = list(dict.fromkeys(row.name for row in run.rows))
        panels = max(1, len(studies)) if of_studies else 1
        columns, rows = min(COLUMNS, panels), math.ceil(panels / COLUMNS)
        height = PANEL[1] if of_studies else 1.0 + CASE_HEIGHT * len(cases)
        figure = new_figure(PANEL[0] * columns, height * rows + 0.8)
        figure.suptitle(self.head, fontsize="large", parse_math=False)
        if not of_studies:
            self.draw(figure.add_subplot())
        elif not studies:
            figure.text(0.5, 0.5, "no rows with a setting to draw", ha="center")
        else:
            for k, measured in enumerate(studies):
                _draw_study(figure.add_subplot(rows, columns, k + 1), measured, run.limits.seconds)
        _explain(figure, of_studies)
        return figure


def _plain(value: Any) -> Any:
    """A value for JSON."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return dict(value) if isinstance(value, Mapping) else value


def _pairs(named: Mapping[str, float]) -> str:
    return " ".join(f"{name.replace(' ', '_')}={value!r}" for name, value in named.items())


def rows_table(
    header: Sequence[str],
    rows: Iterable[ResultRow],
    heading: Callable[[ResultRow], str],
    entries: Callable[[ResultRow], Iterable[Text]],
) -> TerminalTable:
    """Rows with equal headings beneath a line with their heading, which stands in the second and widest column."""
    shown = header_table(*header, widest=header[1])
    groups: dict[str, list[ResultRow]] = {}
    for row in rows:
        groups.setdefault(heading(row), []).append(row)
    for name, group in groups.items():
        if shown.row_count:
            shown.add_section()
        shown.add_row(Text(), Text(name, "bold"))
        for row in group:
            shown.add_row(*entries(row))
    return shown


def _right(text: str) -> Text:
    return Text(text, no_wrap=True, justify="right")


# ---- precision -----------------------------------------------------------------------------------


class Precision(MeasurementResult):
    """Studies of error against run time."""

    keys: ClassVar[Mapping[str, str]] = {
        "study": "name",
        **{key: key for key in ("method", "parameter", "setting", "error", "seconds")},
        **{key: key for key in ("outcome", "reference", "note", "details", "work")},
    }

    @property
    def exit_status(self) -> int:
        """0, or 130 where somebody interrupted."""
        return 0 if self.run.complete else INTERRUPTED

    @property
    def head(self) -> str:
        """What was measured, and how."""
        runs = self.run.limits.runs
        best = f"best of {runs} {'run' if runs == 1 else 'runs'}"
        return f"{one_line(self.run.scene.name)}: error against run time, {best}"

    def facts(self) -> Record:
        """JSON with stable keys."""
        run = self.run
        return {
            "schema": "nonsmooth-precision/1",
            "scene": run.scene.name,
            "rule": str(run.scene.contact.rule) if run.scene.kind is SceneKind.ARRAY else None,
            "runs": run.limits.runs,
            "time_limit": run.limits.seconds,
            "complete": run.complete,
            "studies": [_study_record(measured) for measured in run.measured],
            "rows": self.row_records(),
            "slopes": [record for measured in run.measured for record in _slope_records(measured)],
        }

    def summary(self) -> str:
        """How many rows of how many studies."""
        studies = len(self.run.measured)
        return f"{len(self.run.rows)} rows of {studies} {'study' if studies == 1 else 'studies'}"

    def views(self) -> Sequence[RenderableType]:
        """One table for each study, with the slopes of its methods."""
        head = Text(f"{self.head}, time limit {self.run.limits.seconds:g} s")
        left = [] if self.run.complete else [Text("interrupted: the rows above are finished")]
        return [head, *map(_study_view, self.run.measured), *left]


def _study_record(measured: Measured) -> Record:
    study, plan = measured.study, measured.plan
    entry: Record = {"study": study.name, "title": study.title, "quantity": study.quantity}
    if plan is None:
        return entry | {"reference": None, "left_out": measured.left_out}
    return entry | {"reference": plan.reference, "left_out": None, "note": plan.note}


def _slope_records(measured: Measured) -> Iterator[Record]:
    for slope in measured.slopes:
        entry = {"study": measured.of.name, "method": slope.method, "parameter": slope.parameter, "slope": slope.value}
        yield entry | {"expected": slope.order.expected, "from": slope.first, "to": slope.last, "why": slope.order.why}


def _study_view(measured: Measured) -> RenderableType:
    study, plan, title = measured.study, measured.plan, Text(measured.study.title, "bold")
    if plan is None:
        return Group(title, Text(f"left out: {measured.left_out}"))
    header = ("setting", "method", "error", "time [s]")
    table = rows_table(header, measured.rows, lambda row: row.method, _study_entries)
    lines = [f"{study.quantity}, against: {plan.reference}", *([plan.note] if plan.note else [])]
    return Group(title, *map(Text, lines), table, *(Text(_slope_text(slope)) for slope in measured.slopes))


def _study_entries(row: ResultRow) -> tuple[Text, ...]:
    said = row.note or ", ".join(f"{count} {what}" for what, count in row.work.items())
    return Text(setting_text(row)), Text(said), _right(error_text(row)), _right(measured_text(row.seconds))


def setting_text(row: ResultRow) -> str:
    """The setting of a method; empty for a method without one."""
    return "" if row.setting is None else f"{row.parameter} {measured_text(row.setting)}"


def error_text(row: ResultRow) -> str:
    """The error, or why there is none."""
    return row.outcome if row.error is None else measured_text(row.error)


def _slope_text(slope: FittedSlope) -> str:
    seen = "no slope fitted" if slope.value is None else f"slope {slope.value:.2f} in the {slope.parameter}"
    expected = "none expected" if slope.order.expected is None else f"expected {slope.order.expected:g}"
    return f"{slope.method}: {seen}, {expected}: {slope.order.why}"


# ---- stress --------------------------------------------------------------------------------------


class Stress(MeasurementResult):
    """Stiff and extreme cases."""

    keys: ClassVar[Mapping[str, str]] = {
        "case": "name",
        "parameter": "parameter",
        "verdict": "outcome",
        **{key: key for key in ("error", "condition", "ok", "note")},
    }

    @property
    def exit_status(self) -> int:
        """0 where all rows are ok, 1 where one is not, 130 where somebody interrupted."""
        if not self.run.complete:
            return INTERRUPTED
        return 0 if self.run.ok else 1

    @property
    def head(self) -> str:
        """The rows in one line."""
        return self.summary()

    def facts(self) -> Record:
        """JSON with stable keys."""
        return {
            "schema": "nonsmooth-stress/1",
            "scene": self.run.scene.name,
            "complete": self.run.complete,
            "ok": self.run.ok,
            "rows": self.row_records(),
        }

    def summary(self) -> str:
        """How many rows, and how many are not ok."""
        bad = sum(not row.ok for row in self.run.rows)
        end = "" if self.run.complete else "; interrupted, later cases are missing"
        counts = f"{len(self.run.rows)} rows, {'all ok' if not bad else f'{bad} not ok'}"
        return f"{one_line(self.run.scene.name)}: {counts}{end}"

    def views(self) -> Sequence[RenderableType]:
        """The rows as a table, each case under its own heading; what is not ok is said again below."""
        header = ("parameter", "verdict", "error", "condition", "ok")
        table = rows_table(header, self.run.rows, lambda row: row.name, _case_entries)
        bad = [row for row in self.run.rows if not row.ok]
        said = [Text(f"not ok: {row.name}, {row.parameter}: {row.outcome}; {row.note}", "red") for row in bad]
        return [Group(table, *said, Text(self.summary(), "bold"), Text(LEGEND, "dim"))]


def _case_entries(row: ResultRow) -> tuple[Text, ...]:
    mark = Text("ok", "green") if row.ok else Text("NOT OK", "bold red")
    numbers = (_right("-" if x is None else f"{x:.1e}" if x else "0") for x in (row.error, row.condition))
    return Text(row.parameter or ""), Text(row.outcome), *numbers, mark


# ---- the pictures --------------------------------------------------------------------------------
#
# Errors of measurements across a logarithmic axis: work-precision diagrams of studies, and a line for each case.
#
# Errors at or below a floor, exact zeros among them, stand as stars on a dotted line at the floor: a logarithm has no
# place for them. Results without an error stand open: those of a study at its time limit, above the method's last
# error, those of a case at the floor.


MARKERS = "osD^vP<>X"
PANEL = (6.8, 3.6)  # inches, the legend beside it included
COLUMNS = 2
BELOW_ROUNDING = 1e-4  # of what counts as rounding: no errors are told apart below
NOTHING, LARGEST = 1e-20, 10.0  # where the error of a case is drawn that is zero, and one that is larger or no number
CASE_HEIGHT = 0.24  # inches

Points = list[XY]


def _draw_study(axes: Axes, measured: Measured, limit: float) -> None:
    """Error and processor time; the settings of a method are joined in their order."""
    study, floor = measured.study, _floor(measured)
    axes.set(xlabel=study.quantity, ylabel="processor time [s]", yscale="log")
    axes.set_title(study.title, fontsize="medium", loc="left")
    largest = max((row.error for row in measured.rows if row.error), default=1.0)
    for k, method in enumerate(dict.fromkeys(row.method for row in measured.rows)):
        rows = [row for row in measured.rows if row.method == method]
        points = [(max(row.error, floor), row.seconds) for row in rows if row.error is not None and row.seconds]
        without = []
        if len(points) < len(rows):
            x, y = points[-1] if points else (max(largest, floor), limit)
            without = [(x, limit)]
            axes.plot([x, x], [y, limit], color=LINES[k % len(LINES)], linewidth=0.8, linestyle=":")
        _draw_series(axes, k, method, points, without, floor, "-")
    axes.axhline(limit, color="0.5", linewidth=0.8, linestyle="--", zorder=1)
    _finish(axes, floor)


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
