"""``nonsmooth vehicle``: how a vehicle on its own wheels moves, and the effective track of its turns."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nonsmooth.reports.output.refusals import RefusedError, refusals_named
from nonsmooth.reports.output.study_options import Options, VehicleText, option
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest


@dataclass(frozen=True, kw_only=True)
class VehicleOptions(Options):
    """What was measured."""

    spin: float | None = option(
        None, "Measured rate of turn at the scene's wheel speeds, in radian per time: gives mu_S/mu_R.", metavar="RATE"
    )


class VehicleStudy(SceneStudy[VehicleOptions]):
    """The motion of a vehicle."""

    argument = VehicleText
    options = VehicleOptions
    changes = ("rule",)
    files = "Picture: .svg, .png or .pdf; .csv, .json; parameters of the vehicle's diff_drive_controller: .yaml."

    def endings(self, options: VehicleOptions) -> Collection[str]:
        """Parameters of a controller too."""
        from nonsmooth.reports.checks.vehicles import VehicleResult

        return VehicleResult.formats

    def load(self, scene: str, options: VehicleOptions, **changes: Any) -> Any:
        """The vehicle that is named."""
        from nonsmooth.symbolic.files.vehicle_file import load_vehicle

        return load_vehicle(scene, **changes)

    def refuse(self, asked: StudyRequest[VehicleOptions], path: Path | None) -> None:
        """Refuse a rate that is none."""
        spin = asked.options.spin
        if spin is not None and (spin == 0 or not math.isfinite(spin)):
            raise RefusedError(f"--spin: required a finite rate other than 0, received {spin}")

    def run(self, scene: Any, options: VehicleOptions) -> Result:
        """Predict it."""
        from nonsmooth.reports.checks.vehicles import VehicleResult

        result = VehicleResult(scene, options.spin)
        with refusals_named(scene.scene):
            _ = result.own
        return result


VEHICLE = VehicleStudy()
