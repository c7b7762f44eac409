"""A toy option of ``check``: a field of its options, and what it adds to the result, in one file."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.checks.check import CheckOptions, CheckStudy
from nonsmooth.reports.checks.check_results import CheckResult
from nonsmooth.reports.output.study_options import option
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study_command import command


@dataclass(frozen=True, kw_only=True)
class AskedOptions(CheckOptions):
    outermost: bool = option(False, "Name the wheel farthest from the point.")


class AskedResult(CheckResult):
    def facts(self) -> Record:
        at = self.scene.check.equilibrium
        distances = {
            wheel.index: sum(float(p - c) ** 2 for p, c in zip(wheel.position, at, strict=True))
            for wheel in self.scene.wheels
        }
        return {**super().facts(), "outermost": max(distances, key=lambda index: distances[index])}


class AskedStudy(CheckStudy):
    options: ClassVar[type[Any]] = AskedOptions

    def run(self, scene: Any, options: CheckOptions) -> Result:
        found = super().run(scene, options)
        if not (isinstance(options, AskedOptions) and options.outermost and isinstance(found, CheckResult)):
            return found
        return AskedResult(**{entry.name: getattr(found, entry.name) for entry in fields(CheckResult)})


check = command(AskedStudy(), "check", "Check.\n\nExit status: 0 holds.")
