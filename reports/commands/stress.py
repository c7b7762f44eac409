"""``nonsmooth stress``: stiff and extreme cases of a scene, each measured against exact or 60-digit arithmetic."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import INTERRUPTED, json_text, write, write_json, write_views
from nonsmooth.reports.options import At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from rich.status import Status

    from nonsmooth.analysis.extremes.row import StressRow
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.system import SystemScene

Output = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Rows: .json or .csv; picture: .svg, .png or .pdf.")
]


def stress(
    scene: SceneText,
    output: Output = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Stress a scene: extreme scales, ratios, gains and starts, with the error of every result.

    Exit status: 0 all rows ok, 1 not, 2 bad input, 130 interrupted (finished rows are kept).
    """
    from nonsmooth.reports import stress_views as views
    from nonsmooth.reports.files import PICTURES, output_path, write_whole
    from nonsmooth.symbolic.files.system_file import load_any

    path = None if output is None else output_path(output, (".json", ".csv", *PICTURES))
    loaded = load_any(scene, rule=rule, radius=radius, at=at)
    rows, complete = _all_rows(loaded)
    record = views.stress_record(loaded.name, rows, complete=complete)
    if path is not None:
        write_whole(path, _output_bytes(path, loaded.name, rows, json_text(record)))
    if json:
        write_json(record)
    elif path is not None:
        write(f"{path}: {views.stress_summary(loaded.name, rows, complete=complete)}\n")
    else:
        write_views([views.stress_view(loaded.name, rows, complete=complete)])
    if not complete:
        return INTERRUPTED
    return 0 if record["ok"] else 1


def _all_rows(scene: Scene | SystemScene) -> tuple[list[StressRow], bool]:
    """Row after row; an interrupt keeps those that are finished. Whether all were."""
    from nonsmooth.proofs.extremes.stress import guarded, stress_cases

    rows: list[StressRow] = []
    with _progress() as status:
        try:
            for name, case in stress_cases(scene).items():
                for row in guarded(name, case):
                    rows.append(row)
                    if status is not None:
                        status.update(f"{len(rows)} rows; {name}: {row.case}, {row.parameter}")
        except KeyboardInterrupt:
            return rows, False
    return rows, True


@contextmanager
def _progress() -> Iterator[Status | None]:
    """A line on standard error that says what runs, on a terminal only."""
    from rich.console import Console

    console = Console(stderr=True, markup=False, highlight=False)
    if not console.is_terminal:
        yield None
        return
    with console.status("starting") as status:
        yield status


def _output_bytes(path: Path, name: str, rows: list[StressRow], record: str) -> bytes:
    from nonsmooth.reports.stress_views import stress_figure, stress_table

    match path.suffix.lower():
        case ".json":
            return record.encode()
        case ".csv":
            return stress_table(rows)
        case suffix:
            return stress_figure(name, rows, suffix)
