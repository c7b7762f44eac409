"""The command ``precision``: every study of an array, measured row by row; as text, JSON and CSV."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.analysis.measurements.measurement import Limits, Measurement
from nonsmooth.analysis.measurements.slopes import Slope, fitted_slopes
from nonsmooth.analysis.measurements.studies.derivation import DERIVATION
from nonsmooth.analysis.measurements.studies.masses import MASS
from nonsmooth.analysis.measurements.studies.minimizers import BOX_MINIMIZERS, ELLIPSE_MINIMIZERS
from nonsmooth.analysis.measurements.studies.trajectories import TRAJECTORIES
from nonsmooth.analysis.measurements.studies.upper_derivative import UPPER_DERIVATIVE
from nonsmooth.analysis.measurements.study import LeftOut, Plan, Row, Study
from nonsmooth.proofs.measurements.pruning import PRUNING
from nonsmooth.reports.progress import Report
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

SCHEMA = "nonsmooth-precision/1"
STUDIES = (TRAJECTORIES, UPPER_DERIVATIVE, BOX_MINIMIZERS, ELLIPSE_MINIMIZERS, DERIVATION, MASS, PRUNING)
COLUMNS = ("study", "method", "parameter", "setting", "error", "seconds", "outcome", "reference", "note")


@dataclass(frozen=True)
class Measured:
    """A study with the rows that were finished.

    Attributes:
        study: the study.
        plan: its plan for the scene; None where the scene does not allow it.
        rows: one for each finished trial.
        left_out: why there is no plan.
    """

    study: Study
    plan: Plan | None
    rows: tuple[Row, ...]
    left_out: str = ""

    @property
    def slopes(self) -> list[Slope]:
        """The slope of every method with a setting."""
        return [] if self.plan is None else fitted_slopes(self.study.name, self.plan, self.rows)


@dataclass(frozen=True)
class Precision:
    """All studies of a scene; ``complete`` is False where the work was interrupted."""

    scene: Scene
    limits: Limits
    studies: tuple[Measured, ...]
    complete: bool

    @property
    def rows(self) -> list[Row]:
        """The rows of all studies."""
        return [row for measured in self.studies for row in measured.rows]

    @property
    def head(self) -> str:
        """What was measured, and how."""
        return f"{one_line(self.scene.name)}: error against run time, best of {self.limits.runs} runs"

    def record(self) -> dict[str, Any]:
        """JSON with stable keys."""
        return {
            "schema": SCHEMA,
            "scene": self.scene.name,
            "rule": str(self.scene.contact.rule),
            "runs": self.limits.runs,
            "time_limit": self.limits.seconds,
            "complete": self.complete,
            "studies": [_study_record(measured) for measured in self.studies],
            "rows": [_row_record(row) for row in self.rows],
            "slopes": [_slope_record(slope) for measured in self.studies for slope in measured.slopes],
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """One row per line; other errors and counts of work as ``name=value`` pairs."""
        yield (*COLUMNS, "details", "work")
        for row in self.rows:
            entry = _row_record(row)
            yield (*(entry[name] for name in COLUMNS), _pairs(row.details), _pairs(row.work))

    def picture(self, suffix: str) -> bytes:
        """Error against run time, one panel for each study."""
        from nonsmooth.reports.figures.precision import precision_figure

        return precision_figure(self, suffix)

    def summary(self) -> str:
        """How many rows of how many studies."""
        return f"{len(self.rows)} rows of {len(self.studies)} studies"

    def view(self) -> RenderableType:
        """One table for each study, with the slopes of its methods, parted by empty lines."""
        views: list[RenderableType] = [Text(f"{self.head}, time limit {self.limits.seconds:g} s")]
        for measured in self.studies:
            views += [Text(), _study_view(measured)]
        return Group(*views, *([] if self.complete else [Text(), Text("interrupted: the rows above are finished")]))


def measure(scene: Scene, studies: Sequence[Study], limits: Limits, report: Report) -> Precision:
    """Measure studies one after the other; an interrupt keeps every finished row."""
    finished: list[Measured] = []
    for study in studies:
        measured, complete = _measured(scene, study, limits, report)
        finished += [measured] if complete or measured.rows else []
        if not complete:
            return Precision(scene, limits, tuple(finished), complete=False)
    return Precision(scene, limits, tuple(finished), complete=True)


def _measured(scene: Scene, study: Study, limits: Limits, report: Report) -> tuple[Measured, bool]:
    """One study, and whether it was not interrupted."""
    rows: list[Row] = []
    plan: Plan | None = None
    try:
        report(0, 0, study.name)
        plan = study.build(scene)
        measurement = Measurement(study, plan, limits)
        for trial in plan.trials:
            report(len(rows), len(plan.trials), f"{study.name}: {trial.name}")
            rows.append(measurement.measure(trial))
    except LeftOut as reason:
        return Measured(study, None, (), str(reason)), True
    except KeyboardInterrupt:
        return Measured(study, plan, tuple(rows)), False
    return Measured(study, plan, tuple(rows)), True


# ---- JSON and CSV --------------------------------------------------------------------------------


def _study_record(measured: Measured) -> dict[str, Any]:
    study, plan = measured.study, measured.plan
    entry: dict[str, Any] = {"study": study.name, "title": study.title, "quantity": study.quantity}
    if plan is None:
        return entry | {"reference": None, "left_out": measured.left_out}
    return entry | {"reference": plan.reference, "left_out": None, "note": plan.note}


def _row_record(row: Row) -> dict[str, Any]:
    entry = {name: getattr(row, name) for name in COLUMNS}
    return entry | {"outcome": row.outcome.value, "details": dict(row.details), "work": dict(row.work)}


def _slope_record(slope: Slope) -> dict[str, Any]:
    return {
        "study": slope.study,
        "method": slope.method,
        "parameter": slope.parameter,
        "slope": slope.value,
        "expected": slope.order.expected,
        "from": slope.first,
        "to": slope.last,
        "why": slope.order.why,
    }


def _pairs(named: Mapping[str, float]) -> str:
    return " ".join(f"{name.replace(' ', '_')}={value!r}" for name, value in named.items())


# ---- terminal ------------------------------------------------------------------------------------


def _study_view(measured: Measured) -> RenderableType:
    title = Text(measured.study.title, "bold")
    if measured.plan is None:
        return Group(title, Text(f"left out: {measured.left_out}"))
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("method", "setting", "error", "time [s]", ""):
        table.add_column(name, justify="left" if name in {"method", ""} else "right", overflow="fold")
    for row in measured.rows:
        table.add_row(*(Text(entry) for entry in row_texts(row)), Text(_remark(row)))
    lines = [Text(f"{measured.study.quantity}, against: {measured.plan.reference}")]
    lines += [Text(measured.plan.note)] if measured.plan.note else []
    return Group(title, *lines, table, *(Text(slope_text(slope)) for slope in measured.slopes))


def row_texts(row: Row) -> tuple[str, str, str, str]:
    """Method, setting, error and seconds of a row as a table shows them."""
    setting = "" if row.setting is None else f"{row.parameter} {number_text(row.setting)}"
    error = row.outcome.value if row.error is None else number_text(row.error)
    return row.method, setting, error, "" if row.seconds is None else number_text(row.seconds)


def number_text(value: float) -> str:
    """Two digits; counts and zero as they are."""
    if value == int(value) and abs(value) < 1e7:
        return str(int(value))
    return f"{value:.1e}"


def slope_text(slope: Slope) -> str:
    """What was seen and what was expected, in one line."""
    seen = "no slope fitted" if slope.value is None else f"slope {slope.value:.2f} in the {slope.parameter}"
    expected = "none expected" if slope.order.expected is None else f"expected {slope.order.expected:g}"
    return f"{slope.method}: {seen}, {expected}: {slope.order.why}"


def _remark(row: Row) -> str:
    """The note of a row, or its work."""
    return row.note or ", ".join(f"{count} {what}" for what, count in row.work.items())
