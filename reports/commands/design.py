"""``nonsmooth design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.console import RefusedError, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText


def design(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    free: Annotated[
        str, typer.Option("--free", metavar="NAMES", help="What may change: headings,speeds,positions.")
    ] = "headings",
    require: Annotated[
        str, typer.Option("--require", metavar="NAMES", help="Answers that must be good: position,heading,pose.")
    ] = "position",
    maximize: Annotated[
        str,
        typer.Option(
            "--maximize",
            metavar="NAME",
            help="rate (at which bodies come home), gain (of feedback), basin (whence they come home), or tolerance.",
        ),
    ] = "rate",
    move: Annotated[
        str | None,
        typer.Option(
            "--move", metavar="D", help="How far a wheel may move in x and y; a quarter of the square's side."
        ),
    ] = None,
    symmetry: Annotated[
        int | None,
        typer.Option("--symmetry", metavar="1|2|4", help="Turns that leave the array as it is; the most it has."),
    ] = None,
    checks: Annotated[int, typer.Option("--checks", metavar="N", help="How many arrays are checked at most.")] = 300,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Of the search, which is repeatable.")] = 1,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="Write the scene that was found: .toml.")
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Search for the headings, speeds and positions of the wheels that meet requirements and do best.

    Exit status: 0 found, 1 nothing found that meets the requirements, 2 bad input.
    """
    from nonsmooth.reports.designs.request import DesignError, read_freedom, read_wish
    from nonsmooth.reports.designs.search import find_named
    from nonsmooth.reports.designs.toml_text import toml_text
    from nonsmooth.reports.designs.views import design_record, design_view
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.reports.progress import progress
    from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused, read_document

    file = None if output is None else output_path(output, (".toml",))
    with deep_nesting_refused(scene):
        document, label, path = read_document(scene, rule=rule, radius=radius, at=at)
        given = build_scene(document, label, path, allow_outside=allow_outside)
    try:
        wish = read_wish(given, require, maximize, checks, seed)
        freedom = read_freedom(given, free, move, symmetry)
    except DesignError as error:
        raise RefusedError(f"--{error}") from None
    with progress("checked") as report:
        found = find_named(document, path.parent, given, freedom, wish, report)
    if file is not None and found.is_found:
        write_whole(file, toml_text(found.document).encode())
    if json:
        write_json(design_record(found, wish))
    else:
        write_views([design_view(found, wish)])
    return 0 if found.is_found else 1
