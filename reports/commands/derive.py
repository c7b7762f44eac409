"""``nonsmooth derive``: the derivation report."""

from __future__ import annotations

import shlex

from nonsmooth.reports.console import PROGRAM, refusals_named, write
from nonsmooth.reports.options import At, Json, Radius, Report, RuleOption, SceneText


def derive(
    scene: SceneText,
    output: Report = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Write the derivation report; without -o, as Markdown to standard output."""
    from nonsmooth.reports.derivation import REPORT_FORMATS, derive_report, render_report
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.symbolic.files.scene_file import load_scene

    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    path = None if output is None else output_path(output, REPORT_FORMATS)
    given = {"--rule": rule, "--radius": radius, "--at": at, "-o": output}
    options = [part for name, value in given.items() if value is not None for part in (name, str(value))]
    with refusals_named(loaded):
        report = derive_report(loaded, shlex.join([PROGRAM, "derive", scene, *options]))
    if path is not None:
        write_whole(path, render_report(report, path.suffix.lower()).encode())
    if json:
        write(render_report(report, ".json"))
    elif path is not None:
        write(f"{path}: Theorem 4: {report.result.verdict}\n")
    else:
        write(render_report(report, ".md"))
    return 0
