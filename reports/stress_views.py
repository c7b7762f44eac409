"""Stress rows for people and programs: as a table, as JSON, as CSV and as a picture."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from nonsmooth.analysis.extremes.row import StressRow
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.wheels import INK
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


def stress_record(name: str, rows: Sequence[StressRow], *, complete: bool) -> dict[str, Any]:
    """JSON with stable keys."""
    return {
        "schema": SCHEMA,
        "scene": name,
        "complete": complete,
        "ok": complete and all(row.ok for row in rows),
        "rows": [row.record() for row in rows],
    }


def stress_table(rows: Sequence[StressRow]) -> bytes:
    """The rows as CSV; empty where there is no number."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(KEYS)
    for row in rows:
        writer.writerow(["" if value is None else value for value in row.record().values()])
    return stream.getvalue().encode()


def stress_view(name: str, rows: Sequence[StressRow], *, complete: bool) -> RenderableType:
    """The rows as a table, each case under its own heading; what is not ok is said again below."""
    table = Table(box=box.ROUNDED, header_style="bold")
    for title in ("parameter", "verdict", "error", "condition", "ok"):
        table.add_column(Text(title), overflow="fold", ratio=1 if title == "verdict" else None)
    for k, row in enumerate(rows):
        if not k or rows[k - 1].case != row.case:
            if k:
                table.add_section()
            table.add_row(Text(), Text(row.case, "bold"))
        mark = Text("ok", "green") if row.ok else Text("NOT OK", "bold red")
        numbers = (Text(_brief(value), no_wrap=True, justify="right") for value in (row.error, row.condition))
        table.add_row(Text(row.parameter), Text(row.verdict), *numbers, mark)
    bad = [row for row in rows if not row.ok]
    said = [Text(f"not ok: {row.case}, {row.parameter}: {row.verdict}; {row.note}", "red") for row in bad]
    return Group(table, *said, Text(stress_summary(name, rows, complete=complete), "bold"), Text(LEGEND, "dim"))


def stress_summary(name: str, rows: Sequence[StressRow], *, complete: bool) -> str:
    """One line."""
    bad = sum(not row.ok for row in rows)
    end = "" if complete else "; interrupted, later cases are missing"
    return f"{one_line(name)}: {len(rows)} rows, {'all ok' if not bad else f'{bad} not ok'}{end}"


def stress_figure(name: str, rows: Sequence[StressRow], suffix: str) -> bytes:
    """Errors by case as the bytes of a picture; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(name, rows), suffix)


def build_figure(name: str, rows: Sequence[StressRow]) -> Figure:
    """One line of points for each case, on a logarithmic axis of the error."""
    from matplotlib.figure import Figure

    cases = list(dict.fromkeys(row.case for row in rows))
    figure = Figure(figsize=(8.4, 1.4 + ROW_HEIGHT * len(cases)), layout="constrained")
    axes = figure.subplots()
    kinds = (
        ("ok", "o", OK_COLOR, [row for row in rows if row.ok and row.error is not None]),
        ("refused, or ended without a number, as it should", "s", REFUSED_COLOR, _silent(rows)),
        ("not ok", "X", FAIL_COLOR, [row for row in rows if not row.ok]),
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
    axes.set_title(stress_summary(name, rows, complete=True), parse_math=False)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    return figure


def _drawn(error: float | None) -> float:
    """Within the picture."""
    if error is None:
        return NOTHING
    return min(max(error, NOTHING), LARGEST) if math.isfinite(error) else LARGEST


def _silent(rows: Sequence[StressRow]) -> list[StressRow]:
    return [row for row in rows if row.ok and row.error is None]


def _brief(value: float | None) -> str:
    return "-" if value is None else "0" if not value else f"{value:.1e}"
