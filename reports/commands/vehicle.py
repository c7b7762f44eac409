"""``nonsmooth vehicle``: how a vehicle on its own wheels moves, and the effective track of its turns."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from nonsmooth.reports.console import write
from nonsmooth.reports.options import Json, RuleOption, complete_vehicle
from nonsmooth.reports.refusals import RefusedError, refusals_named

YAML = ".yaml"

VehicleText = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A scene file with [vehicle] or a built-in name.", autocompletion=complete_vehicle
    ),
]
Output = Annotated[
    str | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Picture: .svg, .png or .pdf; .csv, .json; parameters of the vehicle's diff_drive_controller: .yaml.",
    ),
]
Spin = Annotated[
    float | None,
    typer.Option("--spin", metavar="RATE", help="Measured rate of turn at the scene's wheel speeds: gives mu_S/mu_R."),
]


def vehicle(
    scene: VehicleText,
    output: Output = None,
    rule: RuleOption = None,
    spin: Spin = None,
    json: Json = False,
) -> int:
    """Predict how a vehicle on its own wheels moves and turns: twist, slips, forces, effective track.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.reports.result import FORMATS, show
    from nonsmooth.reports.vehicles import VehicleResult
    from nonsmooth.symbolic.files.vehicle_file import load_vehicle

    path = None if output is None else output_path(output, (*FORMATS, YAML))
    if spin is not None and (spin == 0 or not math.isfinite(spin)):
        raise RefusedError(f"--spin: required a finite rate other than 0, received {spin}")
    report = VehicleResult(load_vehicle(scene, rule=rule), spin)
    with refusals_named(report.vehicle.scene):
        _ = report.own
    if path is None or path.suffix.lower() != YAML:
        show(report, path, json=json)
        return 0
    lines = report.controller_lines()
    if lines is None:
        required = "required a vehicle with a track whose sides run at different speeds"
        raise RefusedError(f"{report.vehicle.scene.origin}: {required}, received one without a multiplier")
    write_whole(path, lines.encode())
    write(f"{path}: parameters of diff_drive_controller\n")
    return 0
