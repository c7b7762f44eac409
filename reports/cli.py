"""The command line: ``nonsmooth check | partition | derive | simulate | verify | audit | scenes``.

Exit status: 0 holds, done or valid, 1 does not hold, 2 bad input (one line on standard error, nothing written),
3 undecided, 70 a fault of this program (with its traceback), 130 interrupted.  Each command imports what it needs
itself: ``nonsmooth --help`` loads no mathematics, ``check`` no SymPy or Matplotlib, and CVXPY only to search for V.
"""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import Law, Method, RuleOrAll
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
from nonsmooth.symbolic.rule import Rule

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.analysis.partitions.partition import Partition
    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.system import SystemScene

BAD_INPUT, UNDECIDED = 2, 3

app = typer.Typer(
    epilog="Example: nonsmooth check four-wheel",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


PICTURES = (".svg", ".png", ".pdf")

_RULE = typer.Option("--rule", help="Contact rule; replaces the scene's.")
SceneText = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (TOML) or a built-in name.")]
RuleOption = Annotated[Rule | None, _RULE]
RulesOption = Annotated[RuleOrAll | None, _RULE]
Radius = Annotated[
    str | None, typer.Option("--radius", metavar="R", help="Half-width of the checked square, such as 1/2.")
]
At = Annotated[str | None, typer.Option("--at", metavar="X,Y", help="The point to check, such as 0,1/4.")]
NoPrune = Annotated[bool, typer.Option("--no-prune", help="Leave nothing out; the verdicts are the same.")]
CertificateFile = Annotated[
    str | None, typer.Option("--certificate", metavar="FILE", help="Write a certificate that anyone can verify: .json.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Picture = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Draw the cells: .svg, .png or .pdf.")
]
Report = Annotated[str | None, typer.Option("-o", "--output", metavar="FILE", help="Report: .md, .tex or .json.")]


@app.command(epilog="Example: nonsmooth check four-wheel --radius 1/4 --json")
def check(
    scene: SceneText,
    rule: RulesOption = None,
    radius: Radius = None,
    at: At = None,
    no_prune: NoPrune = False,
    certificate: CertificateFile = None,
    json: Json = False,
) -> int:
    """Check Theorem 4 clause by clause, or the stability of a plain switched system."""
    from nonsmooth.proofs.theorem4 import check_theorem4
    from nonsmooth.reports.records import verified
    from nonsmooth.symbolic.files.system_file import load_any
    from nonsmooth.symbolic.scene import Scene

    several = rule is RuleOrAll.ALL
    scenes = []
    for name in [None] if rule is None else rule.rules:
        loaded = load_any(scene, rule=name, radius=radius, at=at)
        if not isinstance(loaded, Scene):
            return _check_system(loaded, certificate, json=json)
        scenes.append(loaded)
    results = []
    for loaded in scenes:
        with _refusals_named(loaded):
            results.append(verified(check_theorem4(loaded, prune=not no_prune)))
    if certificate is not None:
        _write_certificate(results, certificate)
    if json:
        from nonsmooth.reports.records import check_record, checks_record

        write_json(checks_record(results) if several else check_record(results[0]))
    else:
        from nonsmooth.reports.terminal import check_view, legend

        write_views([*(check_view(result) for result in results), legend()])
    statuses = [result.verdict.exit_status for result in results]
    return next((status for status in (1, UNDECIDED) if status in statuses), 0)


def _check_system(scene: SystemScene, certificate: str | None, *, json: bool) -> int:
    """Stability of a plain switched system: 0 stable, 1 unstable or no equilibrium, 3 undecided."""
    from nonsmooth.proofs.systems.system_stability import system_check
    from nonsmooth.proofs.verdicts import Translation

    if certificate is not None:
        raise RefusedError(f"{scene.source or scene.name}: required an array of wheels for a certificate")
    result = system_check(scene)
    if not result.check():
        raise RuntimeError("required evidence that verifies, received evidence that does not: please report this")
    if json:
        from nonsmooth.reports.system_views import system_record

        write_json(system_record(result))
    else:
        from nonsmooth.reports.system_views import system_view

        write_views([system_view(result)])
    return {Translation.UNSTABLE: 1, Translation.UNDECIDED: UNDECIDED}.get(result.verdict, 0)


def _write_certificate(results: list[CellCheck | EllipseCheck], target: str) -> None:
    """One certificate for one check."""
    from nonsmooth.proofs.certificate import CertificateError, build_certificate, certificate_text
    from nonsmooth.reports.files import output_path, write_whole

    if len(results) > 1:
        raise RefusedError("--certificate: required one contact rule, received all")
    path = output_path(target, (".json",))
    try:
        text = certificate_text(build_certificate(results[0]))
    except CertificateError as error:
        raise RefusedError(f"{results[0].scene.source or results[0].scene.name}: {error}") from None
    write_whole(path, text.encode())


@contextmanager
def _refusals_named(scene: Scene | SystemScene) -> Iterator[None]:
    """Name the scene in the refusal of a check."""
    from nonsmooth.analysis.partitions.partition import RefusalError

    try:
        yield
    except RefusalError as error:
        raise RefusedError(f"{scene.source or scene.name}: {error}") from None


@app.command(epilog="Example: nonsmooth partition four-wheel -o cells.svg")
def partition(
    scene: SceneText,
    output: Picture = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    compare: Annotated[bool, typer.Option("--compare", help="Compare the three contact rules instead.")] = False,
    json: Json = False,
) -> int:
    """List or draw the cells of the plane, each with its contact state and twist."""
    from nonsmooth.analysis.partitions.contact_partition import build_partition
    from nonsmooth.symbolic.files.scene_file import load_scene

    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    path = None
    if output is not None:
        from nonsmooth.reports.figures.cell_map import FORMATS, cell_map
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
    from nonsmooth.analysis.partitions.agreement import compare_rules
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


@app.command(epilog="Example: nonsmooth simulate four-wheel --from 0.2,0.4,0 --until 2 -o path.svg")
def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    start: Annotated[str, typer.Option("--from", metavar="X,Y,THETA", help="Start, such as 0.2,0.4,0.")],
    until: Annotated[float, typer.Option("--until", metavar="T", help="Last time.")] = 2.0,
    kinematics: Annotated[Kinematics, typer.Option("--kinematics", help="Exact pose or leading order.")] = (
        Kinematics.EXACT
    ),
    method: Annotated[Method, typer.Option("--method", help="Events, or the paper's hysteresis.")] = (Method.EVENTS),
    width: Annotated[float, typer.Option("--width", help="Width of the hysteresis.")] = 1e-3,
    feedback: Annotated[bool, typer.Option("--feedback", help="Close the loop (rule nearest).")] = False,
    law: Annotated[Law, typer.Option("--law", help="Feedback law, with --feedback.")] = Law.CORRECTED,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help=".csv, .json, .svg, .png or .pdf")
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Follow a Filippov solution event by event; say where it is not unique."""
    from nonsmooth.analysis.partitions.contact_partition import build_partition
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.symbolic.files.scene_file import load_scene

    run = views.Run(
        _start(start),
        _positive("--until", until),
        kinematics,
        method,
        law if feedback else None,
        _positive("--width", width),
    )
    path = None if output is None else output_path(output, (".csv", ".json", *PICTURES))
    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    with _refusals_named(loaded):
        partition = build_partition(loaded)
    try:
        trajectory = views.follow(partition, run)
    except ValueError as error:
        raise RefusedError(f"{loaded.source or loaded.name}: {error}") from None
    record = views.trajectory_record(partition, run, trajectory)
    if path is not None:
        write_whole(path, _trajectory_bytes(path, partition, trajectory, record))
    if json:
        write_json(record)
    elif path is not None:
        write(f"{path}: {len(trajectory.events)} events, {trajectory.end.reason}\n")
    else:
        write_views([views.trajectory_view(partition, trajectory)])
    return 0


def _start(text: str) -> tuple[float, float, float]:
    """Three finite numbers from ``x,y,theta``."""
    parts = text.split(",")
    try:
        x, y, theta = (float(part) for part in parts)
    except ValueError:
        x = y = theta = math.nan
    if not all(math.isfinite(value) for value in (x, y, theta)):
        raise RefusedError(f"--from: required three numbers x,y,theta, received {text[:60]!r}")
    return x, y, theta


def _positive(option: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise RefusedError(f"{option}: required a positive number, received {value}")
    return value


def _trajectory_bytes(path: Path, partition: Partition, trajectory: Trajectory, record: dict[str, Any]) -> bytes:
    from nonsmooth.reports.console import json_text
    from nonsmooth.reports.simulate import trajectory_table

    match path.suffix.lower():
        case ".csv":
            return trajectory_table(trajectory)
        case ".json":
            return json_text(record).encode()
        case suffix:
            from nonsmooth.reports.figures.trajectory import trajectory_figure

            return trajectory_figure(partition, trajectory, suffix)


@app.command(epilog="Example: nonsmooth verify four-wheel.json")
def verify(file: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A file written by check.")]) -> int:
    """Re-check a certificate with the stand-alone checker, which trusts nothing else of this program."""
    from nonsmooth.proofs.checker import check_file

    status, message = check_file(file)
    if status == BAD_INPUT:
        raise RefusedError(message)
    write(f"{message}\n")
    return status


@app.command(epilog='Example: nonsmooth audit four-wheel --lyapunov "x**2 + 3*y**2"')
def audit(
    scene: SceneText,
    lyapunov: Annotated[str, typer.Option("--lyapunov", metavar="EXPR", help="V in x and y; Abs and sign allowed.")],
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Decide whether somebody's function is a Lyapunov function on the checked square."""
    from nonsmooth.proofs.systems.lyapunov_audit import audit as audit_function
    from nonsmooth.symbolic.files.system_file import load_any

    loaded = load_any(scene, rule=rule, radius=radius, at=at)
    with _refusals_named(loaded):
        result = audit_function(loaded, lyapunov)
    if not result.check():
        raise RuntimeError("required evidence that verifies, received evidence that does not: please report this")
    if json:
        from nonsmooth.reports.system_views import audit_record

        write_json(audit_record(result))
    else:
        from nonsmooth.reports.system_views import audit_view

        write_views([audit_view(result)])
    return result.verdict.exit_status


@app.command(epilog="Example: nonsmooth scenes")
def scenes(json: Json = False) -> int:
    """List the built-in scenes."""
    from nonsmooth.symbolic.files.scene_file import builtin_descriptions
    from nonsmooth.symbolic.files.system_file import system_descriptions

    descriptions = {**builtin_descriptions(), **system_descriptions()}
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
