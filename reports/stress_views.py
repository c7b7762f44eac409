"""Stress rows for people and programs: as a table, as JSON, as CSV and as a picture."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.measurements.cases.row import StressRow
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = "nonsmooth-stress/1"
KEYS = ("case", "parameter", "verdict", "error", "condition", "ok", "note")
LEGEND = (
    "error: relative, against exact or 60-digit arithmetic; condition: factor by which rounding of the input grows; "
    "a dash: nothing was computed, or no system is solved"
)
OK_COLOR, FAIL_COLOR, REFUSED_COLOR = "#0072B2", "#D55E00", "#999999"
NOTHING = 1e-20  # where an error of zero, and a row without error, are drawn
LARGEST = 10.0  # where larger errors, and those that are no numbers, are drawn
ROW_HEIGHT = 0.24  # inches


@dataclass(frozen=True)
class StressRun:
    """The rows of a scene; ``complete`` is False where the work was interrupted."""

    name: str
    rows: tuple[StressRow, ...]
    complete: bool

    @property
    def ok(self) -> bool:
        """Whether every case was tried and is as it should be."""
        return self.complete and all(row.ok for row in self.rows)

    def record(self) -> dict[str, Any]:
        """JSON with stable keys."""
        return {
            "schema": SCHEMA,
            "scene": self.name,
            "complete": self.complete,
            "ok": self.ok,
            "rows": [row.record() for row in self.rows],
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """The rows; empty where there is no number."""
        yield KEYS
        for row in self.rows:
            yield row.record().values()

    def picture(self, suffix: str) -> bytes:
        """Errors by case; ``suffix`` as for the cell map."""
        return figure_bytes(lambda: build_figure(self), suffix)

    def summary(self) -> str:
        """How many rows, and how many are not ok."""
        bad = sum(not row.ok for row in self.rows)
        end = "" if self.complete else "; interrupted, later cases are missing"
        return f"{one_line(self.name)}: {len(self.rows)} rows, {'all ok' if not bad else f'{bad} not ok'}{end}"

    def view(self) -> RenderableType:
        """The rows as a table, each case under its own heading; what is not ok is said again below."""
        table = header_table("parameter", "verdict", "error", "condition", "ok", widest="verdict")
        for k, row in enumerate(self.rows):
            if not k or self.rows[k - 1].case != row.case:
                if k:
                    table.add_section()
                table.add_row(Text(), Text(row.case, "bold"))
            mark = Text("ok", "green") if row.ok else Text("NOT OK", "bold red")
            numbers = (Text(_brief(value), no_wrap=True, justify="right") for value in (row.error, row.condition))
            table.add_row(Text(row.parameter), Text(row.verdict), *numbers, mark)
        bad = [row for row in self.rows if not row.ok]
        said = [Text(f"not ok: {row.case}, {row.parameter}: {row.verdict}; {row.note}", "red") for row in bad]
        return Group(table, *said, Text(self.summary(), "bold"), Text(LEGEND, "dim"))


def build_figure(run: StressRun) -> Figure:
    """One line of points for each case, on a logarithmic axis of the error."""
    from matplotlib.figure import Figure

    cases = list(dict.fromkeys(row.case for row in run.rows))
    figure = Figure(figsize=(8.4, 1.4 + ROW_HEIGHT * len(cases)), layout="constrained")
    axes = figure.subplots()
    silent = [row for row in run.rows if row.ok and row.error is None]
    kinds = (
        ("ok", "o", OK_COLOR, [row for row in run.rows if row.ok and row.error is not None]),
        ("refused, or ended without a number, as it should", "s", REFUSED_COLOR, silent),
        ("not ok", "X", FAIL_COLOR, [row for row in run.rows if not row.ok]),
    )
    for label, marker, color, own in kinds:
        xs, ys = [_drawn(row.error) for row in own], [cases.index(row.case) for row in own]
        if own:
            axes.plot(xs, ys, marker, color=color, label=label, markersize=5, alpha=0.7, clip_on=False)
    axes.set_xscale("log")
    axes.set_xlim(NOTHING, LARGEST)
    axes.set_yticks(range(len(cases)), cases)
    axes.set_ylim(len(cases) - 0.5, -0.5)
    axes.grid(axis="both", color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK)
    axes.set_xlabel("relative error against exact or 60-digit arithmetic (at the left border: none)")
    axes.set_title(run.summary(), parse_math=False)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    return figure


def _drawn(error: float | None) -> float:
    """Within the picture."""
    if error is None:
        return NOTHING
    return min(max(error, NOTHING), LARGEST) if math.isfinite(error) else LARGEST


def _brief(value: float | None) -> str:
    return "-" if value is None else "0" if not value else f"{value:.1e}"
