"""``nonsmooth audit``: somebody else's Lyapunov function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.reports.output.refusals import RefusedError, refusals_named
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.studies.result import Result
from nonsmooth.reports.studies.study import SceneStudy


@dataclass(frozen=True, kw_only=True)
class AuditOptions(Options):
    """What is audited."""

    lyapunov: str | None = option(
        None,
        "V of the displacement from the checked point, in x and y or the states; replaces the scene's.",
        metavar="EXPR",
    )


class Audit(SceneStudy[AuditOptions]):
    """Whether somebody's function is a Lyapunov function."""

    options = AuditOptions

    def run(self, scene: Any, options: AuditOptions) -> Result:
        """Decide it, and verify the evidence."""
        from nonsmooth.proofs.system_audit import audit
        from nonsmooth.reports.checks.system_results import AuditedFunction

        function = scene.check.named_lyapunov if options.lyapunov is None else options.lyapunov
        if function is None:
            raise RefusedError(f"{scene.source}: required V as --lyapunov or as check.lyapunov, received neither")
        with refusals_named(scene):
            return AuditedFunction(audit(scene, function))


AUDIT = Audit()
