"""``nonsmooth stress``: stiff and extreme cases of a scene, each measured against exact or 60-digit arithmetic."""

from __future__ import annotations

from nonsmooth.reports.console import INTERRUPTED
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RowsFile, RuleOption, SceneText


def stress(
    scene: SceneText,
    output: RowsFile = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Stress a scene: extreme scales, ratios, gains and starts, with the error of every result.

    Exit status: 0 all rows ok, 1 not, 2 bad input, 130 interrupted (finished rows are kept).
    """
    from nonsmooth.analysis.measurements.harness import measure
    from nonsmooth.proofs.measurements import CASES
    from nonsmooth.reports.files import output_path
    from nonsmooth.reports.measurements import Stress, load_measured
    from nonsmooth.reports.progress import progress
    from nonsmooth.reports.result import FORMATS, show

    path = None if output is None else output_path(output, FORMATS)
    loaded = load_measured(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    with progress() as report:
        run = measure(loaded, CASES, report=report)
    show(Stress(run), path, json=json)
    if not run.complete:
        return INTERRUPTED
    return 0 if run.ok else 1
