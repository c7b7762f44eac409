"""``nonsmooth export``: an array for a physics engine, with what is predicted; a decided system for other programs."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.output.console import write
from nonsmooth.reports.output.refusals import RefusedError, bad_input, beyond_floats_named, refusals_named
from nonsmooth.reports.output.study_options import SceneOptions, SceneText
from nonsmooth.reports.studies.study_command import offered

if TYPE_CHECKING:
    from pathlib import Path

Output = Annotated[
    str | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Of an array .xml (MJCF; standard output without); of a system .smt2, .kyx, .py, .c.",
    ),
]
Place = Annotated[
    str | None,
    typer.Option("--from", metavar="X,Y", help="Centre of mass, such as 0,1/4; beside the checked point unless given."),
]


class ExportFrame(StrEnum):
    """In whose frame the file is written."""

    BODY = "body"
    WORLD = "world"


Frames = Annotated[
    ExportFrame,
    typer.Option(
        "--frame",
        help="body: the array rides on the body, any friction axis. world: the table stands, a free body lies on it, "
        "and its path is predicted (rule ellipse; friction axes at right angles).",
    ),
]


def export(
    scene: SceneText,
    output: Output = None,
    place: Place = None,
    frame: Frames = ExportFrame.BODY,
    rule: Annotated[str | None, offered(SceneOptions, "rule")] = None,
    allow_outside: Annotated[bool, offered(SceneOptions, "allow_outside")] = False,
) -> int:
    """Export an array to MuJoCo's MJCF, or a decided plain system to other provers and programs.

    MJCF: comments state the predicted twist and motion, and a bound on creep.  A plain system: the inequalities of its
    verdict for SMT solvers (.smt2) and KeYmaera X (.kyx), or its field and V as a program (.py, .c).

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.analysis.bodies.supports import StartTipsError
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports.checks.system_results import EXPORTS
    from nonsmooth.reports.output.files import output_path, write_whole
    from nonsmooth.reports.simulations.mjcf import export_scene, export_world
    from nonsmooth.symbolic.files.documents import deep_nesting_refused, read_document
    from nonsmooth.symbolic.files.scene_file import build_scene
    from nonsmooth.symbolic.files.vehicle_file import build_vehicle

    if output is not None and output.lower().endswith(tuple(EXPORTS)):
        if place is not None or rule is not None or allow_outside or frame is not ExportFrame.BODY:
            raise RefusedError(
                f"{output}: required no --from, --frame, --rule and --allow-outside, received one of them"
            )
        return _export_system(scene, output_path(output, EXPORTS))
    path = None if output is None else output_path(output, (".xml", *EXPORTS))
    with deep_nesting_refused(scene):
        data, label, file = read_document(scene, at=place)
        is_vehicle = "vehicle" in data
        if is_vehicle and place is not None:
            raise RefusedError(f"{label}: --from: required none for a vehicle, which states its centre of mass")
        if is_vehicle:
            loaded = build_vehicle(data, label, file).scene
        else:
            loaded = build_scene(data, label, file, allow_outside=allow_outside)
        loaded = loaded if rule is None else loaded.under(rule)
    stated = place is not None or is_vehicle
    with refusals_named(loaded), bad_input(loaded, StartTipsError, TrajectoryError), beyond_floats_named(loaded):
        start = loaded.check.equilibrium if stated else None
        exported = export_world(loaded, start) if frame is ExportFrame.WORLD else export_scene(loaded, start)
    if path is None:
        write(exported.text())
        return 0
    write_whole(path, exported.text().encode())
    write(f"{path}: {exported.summary}\n")
    return 0


def _export_system(scene: str, path: Path) -> int:
    """Decide a plain system, and write what others may prove again or run."""
    from nonsmooth.proofs.kernel.subject import NoCertificateError
    from nonsmooth.reports.checks.check import check_system
    from nonsmooth.symbolic.files.documents import deep_nesting_refused
    from nonsmooth.symbolic.files.scene_file import load_system

    with deep_nesting_refused(scene):
        system = load_system(scene)
    with refusals_named(system):
        result = check_system(system)
    try:
        result.write_to(path)
    except NoCertificateError as error:
        raise RefusedError(f"{system.origin}: {error}") from None
    write(f"{path}: {system.name}, {result.verdict}\n")
    return 0
