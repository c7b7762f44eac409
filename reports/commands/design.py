"""``nonsmooth design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from nonsmooth.reports.console import RefusedError, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from nonsmooth.reports.designs.freedom import Freedom
    from nonsmooth.reports.designs.search import Wish
    from nonsmooth.symbolic.scene import Scene

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
Front = Annotated[
    str | None,
    typer.Option(
        "--front",
        metavar="FILE",
        help="Instead of one array the Pareto front of rate against tolerance: .svg, .png, .pdf, .csv or .json.",
    ),
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
    front: Front = None,
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
    from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused, read_document

    files = _Files.asked(output, report, front)
    with deep_nesting_refused(scene):
        document, label, path = read_document(scene, rule=rule, radius=radius, at=at)
        given = build_scene(document, label, path, allow_outside=allow_outside)
    try:
        wish = read_wish(given, require, "tolerance" if files.front else maximize, checks, seed)
        freedom = read_freedom(given, free, move, symmetry)
    except DesignError as error:
        raise RefusedError(f"--{error}") from None
    asked = _Asked(document, path.parent, given, freedom, wish)
    if files.front is not None:
        return _front(asked, files.front, json=json)
    return _best(asked, files, json=json)


class _Files(NamedTuple):
    """Files that were asked for, all of which can be written."""

    scene: Path | None
    report: Path | None
    front: Path | None

    @classmethod
    def asked(cls, scene: str | None, report: str | None, front: str | None) -> _Files:
        from nonsmooth.reports.derivation import REPORT_FORMATS
        from nonsmooth.reports.files import PICTURES, output_path

        if front is not None and (scene is not None or report is not None):
            raise RefusedError("--front: required without -o and --report, which are about one array")
        named = ((scene, (".toml",)), (report, REPORT_FORMATS), (front, (*PICTURES, ".csv", ".json")))
        return cls(*(None if text is None else output_path(text, kinds) for text, kinds in named))


class _Asked(NamedTuple):
    """What a search is about."""

    document: dict[str, Any]
    folder: Path
    scene: Scene
    freedom: Freedom
    wish: Wish


def _best(asked: _Asked, files: _Files, *, json: bool) -> int:
    """The best array: shown, and written where it meets what is required."""
    from nonsmooth.reports.designs.named import find_named
    from nonsmooth.reports.designs.toml_text import toml_text
    from nonsmooth.reports.designs.views import design_record, design_view
    from nonsmooth.reports.files import write_whole
    from nonsmooth.reports.progress import progress

    with progress("checked") as report:
        found = find_named(*asked, report)
    if files.scene is not None and found.is_found:
        write_whole(files.scene, toml_text(found.document).encode())
    if files.report is not None and found.is_found:
        _write_report(found.document, asked, files.report, files.scene)
    if json:
        write_json(design_record(found, asked.wish))
    else:
        write_views([design_view(found, asked.wish)])
    return 0 if found.is_found else 1


def _write_report(document: dict[str, Any], asked: _Asked, path: Path, written: Path | None) -> None:
    """The derivation report of a scene that need not be on the disk, without what takes minutes."""
    from nonsmooth.reports.interface.report_result import derive_scene, named_parts
    from nonsmooth.reports.subject import Invocation
    from nonsmooth.symbolic.contact_set import standing
    from nonsmooth.symbolic.files.scene_file import build_scene

    name = str(document["name"])
    file = asked.folder / f"{name}.toml"
    how = Invocation(str(written or file), (), ("--without", MEASUREMENTS, "-o", str(path)))
    scene = standing(build_scene(document, name, file))
    derive_scene(scene, named_parts(None, MEASUREMENTS), invocation=how).save(path)


def _front(asked: _Asked, path: Path, *, json: bool) -> int:
    """The front: shown, and written."""
    from nonsmooth.reports.console import json_text
    from nonsmooth.reports.designs.freedom import WHEELS
    from nonsmooth.reports.designs.front import find_front
    from nonsmooth.reports.designs.front_views import front_csv, front_record, front_view
    from nonsmooth.reports.figures.design_front import front_figure
    from nonsmooth.reports.files import write_whole
    from nonsmooth.reports.progress import progress

    if WHEELS in asked.freedom.kinds:
        raise RefusedError("--front: required headings, speeds or positions that are free, received wheels")
    with progress("checked") as report:
        found = find_front(*asked, report)
    record, suffix = front_record(found, asked.scene, asked.wish), path.suffix.lower()
    if suffix in (".csv", ".json"):
        write_whole(path, front_csv(found) if suffix == ".csv" else json_text(record).encode())
    else:
        write_whole(path, front_figure(found, asked.scene, suffix))
    if json:
        write_json(record)
    else:
        write_views([front_view(found, asked.scene)])
    return 0 if found.points else 1
