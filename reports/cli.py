"""The command line: ``nonsmooth check | partition | derive | scenes``.

Exit status: 0 holds or done, 1 does not hold, 2 bad input (one line on standard error, nothing written), 3 undecided,
70 a fault of this program (with its traceback), 130 interrupted.  Each command imports what it needs itself, so that
``nonsmooth --help`` loads no mathematics and ``check`` no SymPy, Matplotlib or CVXPY.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import (
    PROGRAM,
    RefusedError,
    own_version,
    prepare_streams,
    run,
    write,
    write_json,
    write_views,
)

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.symbolic.scene import Scene

UNDECIDED = 3

app = typer.Typer(
    epilog="Example: nonsmooth check four-wheel",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class RuleName(StrEnum):
    """One contact rule."""

    NEAREST = "nearest"
    BOX = "box"
    ELLIPSE = "ellipse"


class RuleNames(StrEnum):
    """One contact rule, or all of them in turn."""

    NEAREST = "nearest"
    BOX = "box"
    ELLIPSE = "ellipse"
    ALL = "all"


_RULE = typer.Option("--rule", help="Contact rule; replaces the scene's.")
SceneText = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (TOML) or a built-in name.")]
Rule = Annotated[RuleName | None, _RULE]
Rules = Annotated[RuleNames | None, _RULE]
Radius = Annotated[
    str | None, typer.Option("--radius", metavar="R", help="Half-width of the checked square, such as 1/2.")
]
At = Annotated[str | None, typer.Option("--at", metavar="X,Y", help="The point to check, such as 0,1/4.")]
NoPrune = Annotated[bool, typer.Option("--no-prune", help="Leave nothing out; the verdicts are the same.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Picture = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Draw the cells: .svg, .png or .pdf.")
]
Report = Annotated[str | None, typer.Option("-o", "--output", metavar="FILE", help="Report: .md, .tex or .json.")]


@app.command(epilog="Example: nonsmooth check four-wheel --radius 1/4 --json")
def check(
    scene: SceneText,
    rule: Rules = None,
    radius: Radius = None,
    at: At = None,
    no_prune: NoPrune = False,
    json: Json = False,
) -> int:
    """Check Theorem 4 clause by clause; each verdict comes with a certificate or a witness."""
    from nonsmooth.proofs.theorem4 import check_theorem4
    from nonsmooth.reports.records import verified
    from nonsmooth.symbolic.scene_file import load_scene

    several = rule is RuleNames.ALL
    names = list(RuleName) if several else [rule]
    scenes = [load_scene(scene, rule=name, radius=radius, at=at) for name in names]
    results = []
    for loaded in scenes:
        with _refusals_named(loaded):
            results.append(verified(check_theorem4(loaded, prune=not no_prune)))
    if json:
        from nonsmooth.reports.records import check_record, checks_record

        write_json(checks_record(results) if several else check_record(results[0]))
    else:
        from nonsmooth.reports.terminal import check_view, legend

        write_views([*(check_view(result) for result in results), legend()])
    statuses = [result.verdict.exit_status for result in results]
    return next((status for status in (1, UNDECIDED) if status in statuses), 0)


@contextmanager
def _refusals_named(scene: Scene) -> Iterator[None]:
    """Name the scene in the refusal of a check."""
    from nonsmooth.analysis.partition import RefusalError

    try:
        yield
    except RefusalError as error:
        raise RefusedError(f"{scene.source or scene.name}: {error}") from None


@app.command(epilog="Example: nonsmooth partition four-wheel -o cells.svg")
def partition(
    scene: SceneText,
    output: Picture = None,
    rule: Rule = None,
    radius: Radius = None,
    at: At = None,
    compare: Annotated[bool, typer.Option("--compare", help="Compare the three contact rules instead.")] = False,
    json: Json = False,
) -> int:
    """List or draw the cells of the plane, each with its contact state and twist."""
    from nonsmooth.proofs.theorem4 import build_partition
    from nonsmooth.symbolic.scene_file import load_scene

    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    path = None
    if output is not None:
        from nonsmooth.reports.cell_map import FORMATS, cell_map
        from nonsmooth.reports.files import output_path, write_whole

        path = output_path(output, FORMATS)
    if compare:
        return _compare(loaded, path, json=json)
    with _refusals_named(loaded):
        cells = build_partition(loaded)
    if path is not None:
        write_whole(path, cell_map(cells, path.suffix.lower()))
    if json:
        from nonsmooth.reports.records import partition_record

        write_json(partition_record(cells))
    elif path is not None:
        write(f"{path}: {len(cells.cells)} cells\n")
    else:
        from nonsmooth.reports.terminal import partition_view

        write_views([partition_view(cells)])
    return 0


def _compare(scene: Scene, path: Path | None, *, json: bool) -> int:
    """The three contact rules side by side."""
    from nonsmooth.analysis.agreement import compare_rules
    from nonsmooth.reports.agreement_views import agreement_map, agreement_record, agreement_view
    from nonsmooth.reports.files import write_whole

    with _refusals_named(scene):
        agreement = compare_rules(scene)
    if path is not None:
        write_whole(path, agreement_map(agreement, path.suffix.lower()))
    if json:
        write_json(agreement_record(agreement))
    elif path is not None:
        write(f"{path}: rules nearest and box agree on a share of {agreement.shared.share}\n")
    else:
        write_views([agreement_view(agreement)])
    return 0


@app.command(epilog="Example: nonsmooth derive four-wheel -o report.tex")
def derive(
    scene: SceneText,
    output: Report = None,
    rule: Rule = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Write the derivation report; without -o, as Markdown to standard output."""
    from nonsmooth.reports.derivation import REPORT_FORMATS, derive_report, render_report
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.symbolic.scene_file import load_scene

    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    path = None if output is None else output_path(output, REPORT_FORMATS)
    given = {"--rule": rule, "--radius": radius, "--at": at, "-o": output}
    options = [part for name, value in given.items() if value is not None for part in (name, str(value))]
    with _refusals_named(loaded):
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


@app.command(epilog="Example: nonsmooth scenes")
def scenes(json: Json = False) -> int:
    """List the built-in scenes."""
    from nonsmooth.symbolic.scene_file import builtin_descriptions

    descriptions = builtin_descriptions()
    if json:
        from nonsmooth.reports.records import scenes_record

        write_json(scenes_record(descriptions))
    else:
        from nonsmooth.reports.terminal import scenes_view

        write_views([scenes_view(descriptions)])
    return 0


def _show_version(wanted: bool) -> None:
    if wanted:
        write(f"{PROGRAM} {own_version()}\n")
        raise typer.Exit(0)


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Stability of planar arrays of driven wheels, clause by clause, with exact certificates or witnesses."""


def main() -> None:
    """Entry point of the ``nonsmooth`` command."""
    prepare_streams()
    sys.exit(run(app, sys.argv[1:]))


if __name__ == "__main__":
    main()
