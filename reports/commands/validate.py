"""``nonsmooth validate``: predictions beside what others measured, shipped or published."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.console import RefusedError
from nonsmooth.reports.options import Json, RowsFile

Only = Annotated[
    str | None,
    typer.Option("--only", metavar="NAME,...", help="Of vehicles, pushes and claims; all three unless given."),
]


def validate(only: Only = None, output: RowsFile = None, json: Json = False) -> int:
    """Validate predictions against vehicles, 400 measured pushes and published claims; nothing is fitted to them.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.evidence.claim import ClaimKind
    from nonsmooth.reports.evidence.pack import gather
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.reports.progress import steps
    from nonsmooth.reports.shown import show

    path = None if output is None else output_path(output, (".json", ".csv", *PICTURES))
    names = [kind.value for kind in ClaimKind] if only is None else [name.strip() for name in only.split(",")]
    unknown = next((name for name in names if name not in list(ClaimKind)), None)
    if unknown is not None:
        raise RefusedError(f"--only: required names among {', '.join(ClaimKind)}, received {unknown[:60]!r}")
    with steps("evidence"):
        found = gather([ClaimKind(name) for name in names])
    show(found, path, json=json)
    return 0
