"""``nonsmooth design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from nonsmooth.reports.console import write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText
from nonsmooth.reports.refusals import RefusedError

MEASUREMENTS = "precision,stress"  # sections of a report that take minutes


Free = Annotated[
    str,
    typer.Option(
        "--free", metavar="NAMES", help="What may change: headings,speeds,positions; or which wheels there are."
    ),
]
Require = Annotated[
    str, typer.Option("--require", metavar="NAMES", help="Answers that must be good: position,heading,pose.")
]
Maximize = Annotated[
    str,
    typer.Option(
        "--maximize",
        metavar="NAME",
        help="rate (at which bodies come home), gain or margin (of feedback), basin (whence they come home), or "
        "tolerance.",
    ),
]
Move = Annotated[
    str | None,
    typer.Option("--move", metavar="D", help="How far a wheel may move in x and y; a quarter of the square's side."),
]
Symmetry = Annotated[
    int | None,
    typer.Option("--symmetry", metavar="1|2|4", help="Turns that leave the array as it is; the most it has."),
]
Checks = Annotated[int, typer.Option("--checks", metavar="N", help="How many arrays are checked at most.")]
Seed = Annotated[int, typer.Option("--seed", metavar="S", help="Of the search, which is repeatable.")]
SceneFile = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Write the scene that was found: .toml.")
]
ReportFile = Annotated[
    str | None,
    typer.Option("--report", metavar="FILE", help="Write the derivation report of what was found: .html, .md, ..."),
]


def design(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    free: Free = "headings",
    require: Require = "position",
    maximize: Maximize = "rate",
    move: Move = None,
    symmetry: Symmetry = None,
    checks: Checks = 300,
    seed: Seed = 1,
    output: SceneFile = None,
    report: ReportFile = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Search for the headings, speeds and positions of the wheels that meet requirements and do best.

    Exit status: 0 found, 1 nothing found that meets the requirements, 2 bad input.
    """
    from nonsmooth.reports.derivation import REPORT_FORMATS
    from nonsmooth.reports.designs.named import find_named
    from nonsmooth.reports.designs.request import DesignError, read_freedom, read_wish
    from nonsmooth.reports.designs.toml_text import toml_text
    from nonsmooth.reports.designs.views import design_record, design_view
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.reports.progress import progress
    from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused, read_document

    scene_path = None if output is None else output_path(output, (".toml",))
    report_path = None if report is None else output_path(report, REPORT_FORMATS)
    with deep_nesting_refused(scene):
        document, label, path = read_document(scene, rule=rule, radius=radius, at=at)
        given = build_scene(document, label, path, allow_outside=allow_outside)
    try:
        wish = read_wish(given, require, maximize, checks, seed)
        freedom = read_freedom(given, free, move, symmetry)
    except DesignError as error:
        raise RefusedError(f"--{error}") from None
    with progress("checked") as told:
        found = find_named(document, path.parent, given, freedom, wish, told)
    if scene_path is not None and found.is_found:
        write_whole(scene_path, toml_text(found.document).encode())
    if report_path is not None and found.is_found:
        _write_report(found.document, path.parent, report_path, scene_path)
    if json:
        write_json(design_record(found, wish))
    else:
        write_views([design_view(found, wish)])
    return 0 if found.is_found else 1


def _write_report(document: dict[str, Any], folder: Path, path: Path, written: Path | None) -> None:
    """The derivation report of a scene that need not be on the disk, without what takes minutes.

    Its commands name the file that was written, or one of the scene's name in the reader's own folder.
    """
    from nonsmooth.reports.interface.report_result import derive_scene, named_parts
    from nonsmooth.reports.subject import Invocation
    from nonsmooth.symbolic.contact_set import standing
    from nonsmooth.symbolic.files.scene_file import build_scene

    name = str(document["name"])
    file = folder / f"{name}.toml"
    how = Invocation(str(written or file.name), (), ("--without", MEASUREMENTS, "-o", str(path)))
    scene = standing(build_scene(document, name, file))
    derive_scene(scene, named_parts(None, MEASUREMENTS), invocation=how).save(path)
