"""``nonsmooth precision`` and ``nonsmooth stress``: errors, every one against an exact or 60-digit answer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.output.study_options import Options, complete_study, option
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.analysis.measurements.harness import Study


@dataclass(frozen=True, kw_only=True)
class PrecisionOptions(Options):
    """What is measured, and for how long."""

    study: list[str] | None = option(
        None,
        "This study only, such as derivation; may be given several times.",
        metavar="NAME",
        complete=complete_study,
    )
    runs: int = option(3, "Runs of which the shortest counts.", metavar="N")
    time_limit: float = option(5.0, "Seconds for one method at one setting.", metavar="S")


class PrecisionStudy(SceneStudy[PrecisionOptions]):
    """Studies of error against run time."""

    options = PrecisionOptions
    files = "Rows: .json or .csv; log-log figure: .svg, .png or .pdf."

    def refuse(self, asked: StudyRequest[PrecisionOptions], path: Path | None) -> None:
        """Refuse numbers that measure nothing, and studies that there are not."""
        runs, seconds = asked.options.runs, asked.options.time_limit
        if runs < 1:
            raise RefusedError(f"--runs: required at least 1, received {runs}")
        if not (math.isfinite(seconds) and seconds > 0):
            raise RefusedError(f"--time-limit: required a positive number of seconds, received {seconds}")
        _ = _studies(asked.options.study, asked.kind)

    def run(self, scene: Any, options: PrecisionOptions) -> Result:
        """Measure; finished rows are kept where somebody interrupts."""
        from nonsmooth.analysis.measurements.harness import Limits, measure
        from nonsmooth.reports.checks.measurements import Precision, measurable
        from nonsmooth.reports.output.progress import progress
        from nonsmooth.symbolic.mechanics.contact_set import standing

        measurable(scene)
        stands = standing(scene) if scene.kind is SceneKind.ARRAY else scene
        limits = Limits(options.runs, options.time_limit)
        with progress() as report:
            return Precision(measure(stands, _studies(options.study, scene.kind), limits, report))


def _studies(names: Sequence[str] | None, kind: SceneKind) -> tuple[Study, ...]:
    """The studies of these names, in the order of the list; all of them for none."""
    from nonsmooth.proofs.measurements import STUDIES, SYSTEM_STUDIES

    studies = STUDIES if kind is SceneKind.ARRAY else SYSTEM_STUDIES
    known = [study.name for study in studies]
    for name in names or ():
        if name not in known:
            raise RefusedError(f"--study: required one of {', '.join(known)}, received {name[:60]!r}")
    return tuple(study for study in studies if not names or study.name in names)


PRECISION = PrecisionStudy()


class StressStudy(SceneStudy[Options]):
    """Cases in which a careless method fails."""

    options = Options
    files = "Rows: .json or .csv; picture: .svg, .png or .pdf."

    def run(self, scene: Any, options: Options) -> Result:
        """Measure; finished rows are kept where somebody interrupts."""
        from nonsmooth.analysis.measurements.harness import measure
        from nonsmooth.proofs.measurements import CASES
        from nonsmooth.reports.checks.measurements import Stress, measurable
        from nonsmooth.reports.output.progress import progress

        with progress() as report:
            return Stress(measure(measurable(scene), CASES, report=report))


STRESS = StressStudy()
