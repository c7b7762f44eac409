"""``nonsmooth stress``: stiff and extreme cases of a scene, each measured against exact or 60-digit arithmetic."""

from __future__ import annotations

from typing import Any

from nonsmooth.reports.output.study_options import Options
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study import SceneStudy


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
