"""``nonsmooth audit``: somebody else's Lyapunov function."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.console import refusals_named, write_json, write_views
from nonsmooth.reports.options import At, Json, Radius, RuleOption, SceneText


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
    from nonsmooth.proofs.verified import verified
    from nonsmooth.symbolic.files.system_file import load_any

    loaded = load_any(scene, rule=rule, radius=radius, at=at)
    with refusals_named(loaded):
        result = verified(audit_function(loaded, lyapunov))
    if json:
        from nonsmooth.reports.system_views import audit_record

        write_json(audit_record(result))
    else:
        from nonsmooth.reports.system_views import audit_view

        write_views([audit_view(result)])
    return result.verdict.exit_status
