"""``nonsmooth vehicle``: how a vehicle on its own wheels moves, and the effective track of its turns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import RefusedError, refusals_named, write
from nonsmooth.reports.options import AllowOutside, Json, RuleOption, complete_vehicle

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.vehicles.motion import VehicleReport

YAML = ".yaml"

VehicleTexts = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[SCENE...]",
        help="Scene files with [vehicle] or built-in names; several are compared, none means all built-in ones that "
        "state what was measured.",
        autocompletion=complete_vehicle,
    ),
]
Output = Annotated[
    str | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Picture: .svg, .png or .pdf; .csv, .json; parameters of one vehicle's diff_drive_controller: .yaml.",
    ),
]
Spin = Annotated[
    float | None,
    typer.Option("--spin", metavar="RATE", help="Measured rate of turn at the scene's wheel speeds: gives mu_S/mu_R."),
]


def vehicle(
    scenes: VehicleTexts = None,
    output: Output = None,
    rule: RuleOption = None,
    spin: Spin = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Predict how a vehicle on its own wheels moves and turns: twist, slips, forces, effective track.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.reports.shown import show
    from nonsmooth.reports.vehicles.comparison import VehicleComparison
    from nonsmooth.reports.vehicles.motion import VehicleReport
    from nonsmooth.symbolic.files.vehicle_file import load_vehicle, measured_vehicles

    named = scenes or list(measured_vehicles())
    formats = (*PICTURES, ".csv", ".json", *([YAML] if len(named) == 1 else []))
    path = None if output is None else output_path(output, formats)
    _require_spin(spin, len(named))
    reports = [VehicleReport(load_vehicle(name, rule=rule, allow_outside=allow_outside), spin) for name in named]
    for report in reports:
        with refusals_named(report.vehicle.scene):
            _ = report.own
    if path is not None and path.suffix.lower() == YAML:
        return _write_parameters(reports[0], path)
    show(reports[0] if len(reports) == 1 else VehicleComparison(tuple(reports)), path, json=json)
    return 0


def _require_spin(spin: float | None, count: int) -> None:
    """Refuse a spin that is no turn, or of several vehicles.

    Raises:
        RefusedError: saying which.
    """
    if spin is None:
        return
    if count > 1:
        raise RefusedError(f"--spin: required one vehicle, received {count}")
    if not abs(spin) > 0 or spin in (float("inf"), float("-inf")):
        raise RefusedError(f"--spin: required a finite rate other than 0, received {spin}")


def _write_parameters(report: VehicleReport, path: Path) -> int:
    """The lines of the controller.

    Raises:
        RefusedError: for a vehicle without a track, or one that does not turn.
    """
    from nonsmooth.reports.files import write_whole
    from nonsmooth.reports.vehicles.controller import controller_lines

    lines = controller_lines(report.vehicle, report.own.multiplier)
    if lines is None:
        required = "required a vehicle with a track whose sides run at different speeds"
        raise RefusedError(f"{report.vehicle.scene.origin}: {required}, received one without a multiplier")
    write_whole(path, lines.encode())
    write(f"{path}: parameters of diff_drive_controller\n")
    return 0
