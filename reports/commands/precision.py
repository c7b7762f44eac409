"""``nonsmooth precision``: error against run time, every error against an exact or 60-digit answer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import INTERRUPTED
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText, complete_study
from nonsmooth.reports.refusals import RefusedError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from nonsmooth.analysis.measurements.harness import Study


def precision(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="FILE", help="Rows: .json or .csv; log-log figure: .svg, .png or .pdf."),
    ] = None,
    study: Annotated[
        list[str] | None,
        typer.Option(
            "--study",
            metavar="NAME",
            help="This study only, such as derivation; may be given several times.",
            autocompletion=complete_study,
        ),
    ] = None,
    runs: Annotated[int, typer.Option("--runs", metavar="N", help="Runs of which the shortest counts.")] = 3,
    time_limit: Annotated[
        float, typer.Option("--time-limit", metavar="S", help="Seconds for one method at one setting.")
    ] = 5.0,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Measure methods against exact answers: error, time, and how one depends on the other.

    Exit status: 0 done, 2 bad input, 130 interrupted (finished rows are kept).
    """
    from nonsmooth.analysis.measurements.harness import Limits, measure
    from nonsmooth.proofs.measurements import STUDIES, SYSTEM_STUDIES
    from nonsmooth.reports.files import output_path
    from nonsmooth.reports.measurements import Precision, load_measured
    from nonsmooth.reports.progress import progress
    from nonsmooth.reports.result import FORMATS, show
    from nonsmooth.symbolic.contact_set import standing
    from nonsmooth.symbolic.scene import Scene

    if runs < 1:
        raise RefusedError(f"--runs: required at least 1, received {runs}")
    if not (math.isfinite(time_limit) and time_limit > 0):
        raise RefusedError(f"--time-limit: required a positive number of seconds, received {time_limit}")
    path = None if output is None else output_path(output, FORMATS)
    loaded = load_measured(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    if isinstance(loaded, Scene):
        studies, loaded = _studies(study, STUDIES), standing(loaded)
    else:
        studies = _studies(study, SYSTEM_STUDIES)
    with progress() as report:
        run = measure(loaded, studies, Limits(runs, time_limit), report)
    show(Precision(run), path, json=json)
    return 0 if run.complete else INTERRUPTED


def _studies(names: list[str] | None, studies: Sequence[Study]) -> tuple[Study, ...]:
    """The studies of these names, in the order of the list; all of them for none."""
    known = [study.name for study in studies]
    for name in names or ():
        if name not in known:
            raise RefusedError(f"--study: required one of {', '.join(known)}, received {name[:60]!r}")
    return tuple(study for study in studies if not names or study.name in names)
