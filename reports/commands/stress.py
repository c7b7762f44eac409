"""``nonsmooth stress``: stiff and extreme cases of a scene, each measured against exact or 60-digit arithmetic."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import INTERRUPTED
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from rich.status import Status

    from nonsmooth.analysis.extremes.row import StressRow
    from nonsmooth.reports.stress_views import StressRun
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem

Output = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Rows: .json or .csv; picture: .svg, .png or .pdf.")
]


def stress(
    scene: SceneText,
    output: Output = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Stress a scene: extreme scales, ratios, gains and starts, with the error of every result.

    Exit status: 0 all rows ok, 1 not, 2 bad input, 130 interrupted (finished rows are kept).
    """
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.reports.shown import show
    from nonsmooth.symbolic.files.system_file import load_any

    path = None if output is None else output_path(output, (".json", ".csv", *PICTURES))
    loaded = load_any(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    run = _run(loaded)
    show(run, path, json=json)
    if not run.complete:
        return INTERRUPTED
    return 0 if run.ok else 1


def _run(scene: Scene | SwitchedSystem) -> StressRun:
    """Row after row; an interrupt keeps those that are finished."""
    from nonsmooth.proofs.extremes.stress import guarded, stress_cases
    from nonsmooth.reports.stress_views import StressRun

    rows: list[StressRow] = []
    with _progress() as status:
        try:
            for name, case in stress_cases(scene).items():
                for row in guarded(name, case):
                    rows.append(row)
                    if status is not None:
                        status.update(f"{len(rows)} rows; {name}: {row.case}, {row.parameter}")
        except KeyboardInterrupt:
            return StressRun(scene.name, tuple(rows), complete=False)
    return StressRun(scene.name, tuple(rows), complete=True)


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
