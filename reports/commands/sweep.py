"""``nonsmooth sweep``: many scenes that differ in a few numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import broken_pipes_raised, write, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Fail, Json, Radius, RuleOption, SceneText, asks_for_failures
from nonsmooth.reports.refusals import RefusedError

if TYPE_CHECKING:
    from nonsmooth.reports.sweeps.base import Base
    from nonsmooth.reports.sweeps.sweep import Means, Sweep
    from nonsmooth.reports.sweeps.sweep_plan import SweepPlan

Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="KEY=VALUES",
        help="A number of the scene, such as mu_side or wheel.1.heading, and its values: start:stop:count or a,b,c; "
        "several give every combination.",
    ),
]
Random = Annotated[
    int | None,
    typer.Option("--random", metavar="N", help="N random scenes within ranges start:stop, instead of a grid."),
]
Seed = Annotated[int, typer.Option("--seed", metavar="S", help="Seed of --random: equal seeds give equal scenes.")]
Output = Annotated[
    str | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Table: .csv, .parquet (needs pyarrow) or .json; picture over one or two numbers: .svg, .png or .pdf.",
    ),
]
Borders = Annotated[
    bool,
    typer.Option("--borders", help="Find where answers change along the grid, within 1e-9; a picture always does."),
]
StoreFile = Annotated[
    str | None,
    typer.Option(
        "--store",
        metavar="FILE",
        help="Keep results in this file, and take from it what is known; several sweeps may share it.",
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", help="Processes that check; as many as there are processors unless given."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Check on the Dask cluster of this scheduler, such as tcp://host:8786 (needs nonsmooth[cluster]).",
    ),
]
Certify = Annotated[
    bool,
    typer.Option(
        "--certify",
        help="Prove what holds in whole cells of the grid, for every array between and within the tolerances.",
    ),
]
Yes = Annotated[bool, typer.Option("--yes", help="Run more than a million scenes.")]


def sweep(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    vary: Vary = None,
    random: Random = None,
    seed: Seed = 0,
    output: Output = None,
    borders: Borders = False,
    certify: Certify = False,
    fail: Fail = None,
    store: StoreFile = None,
    workers: WorkersOption = None,
    scheduler: Scheduler = None,
    yes: Yes = False,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Check many scenes that differ in a few numbers: a table, strips or a map of answers, and where they change.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.files import PICTURES
    from nonsmooth.reports.sweep_files import sweep_path
    from nonsmooth.reports.sweeps.base import base_of, with_wheels
    from nonsmooth.reports.sweeps.sweep import Means
    from nonsmooth.reports.sweeps.sweep_error import SweepError
    from nonsmooth.reports.sweeps.sweep_plan import read_plan
    from nonsmooth.reports.sweeps.workers import processors
    from nonsmooth.symbolic.files.scene_file import deep_nesting_refused, read_document

    failures = asks_for_failures(fail)
    path = None if output is None else sweep_path(output)
    draws_picture = path is not None and path.suffix.lower() in PICTURES
    try:
        with deep_nesting_refused(scene):
            base = base_of(*read_document(scene, rule=rule, radius=radius, at=at), allow_outside=allow_outside)
        values = _values(vary or [])
        base = with_wheels(base, values)
        plan = read_plan(values, base.document, base.file, draws=random, seed=seed)
        _require_picture(plan, draws_picture)
        means = Means(
            workers=workers if workers is not None else processors(),
            scheduler=scheduler,
            store=None if store is None else Path(store),
            failures=failures,
            borders=borders or (draws_picture and not certify),
            certify=certify,
            yes=yes,
        )
        _show(_run(base, plan, means), path, json=json)
    except SweepError as error:
        raise RefusedError(f"--{error}") from None
    return 0


def _values(vary: list[str]) -> dict[str, str]:
    """Key paths and values.

    Raises:
        RefusedError: for what is no pair of both, and for a path that is given twice.
    """
    found: dict[str, str] = {}
    for text in vary:
        name, sign, values = text.partition("=")
        if not sign or not name.strip() or not values.strip():
            raise RefusedError(f"--vary: required KEY=VALUES such as mu_side=0.05:1:40, received {text[:60]!r}")
        if name.strip() in found:
            raise RefusedError(f"--vary: required each number once, received {name.strip()[:60]!r} twice")
        found[name.strip()] = values.strip()
    return found


def _require_picture(plan: SweepPlan, draws_picture: bool) -> None:
    """Refuse a picture of what has none, before the work."""
    if draws_picture:
        from nonsmooth.reports.figures.sweep import require_picture

        require_picture(plan)


def _run(base: Base, plan: SweepPlan, means: Means) -> Sweep:
    from nonsmooth.reports.progress import progress
    from nonsmooth.reports.sweeps.sweep import run_sweep

    with progress("checked") as report, broken_pipes_raised():
        return run_sweep(base, plan, means, report)


def _show(found: Sweep, path: Path | None, *, json: bool) -> None:
    """Write the file that was asked for; then print JSON, or say what was written, or print the table."""
    from nonsmooth.reports.files import write_whole
    from nonsmooth.reports.sweep_files import sweep_bytes
    from nonsmooth.reports.sweeps.table import counted, sweep_record, sweep_view

    if path is not None:
        write_whole(path, sweep_bytes(found, path.suffix.lower()))
    if json:
        write_json(sweep_record(found))
    elif path is not None:
        write(f"{path}: {counted(found)}\n")
    else:
        write_views([sweep_view(found)])
