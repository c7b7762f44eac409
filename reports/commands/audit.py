"""``nonsmooth audit``: somebody else's Lyapunov function."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.console import write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText
from nonsmooth.reports.refusals import RefusedError, refusals_named

Lyapunov = Annotated[
    str | None,
    typer.Option(
        "--lyapunov",
        metavar="EXPR",
        help="V of the displacement from the checked point, in x and y or the states; replaces the scene's.",
    ),
]


def audit(
    scene: SceneText,
    lyapunov: Lyapunov = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Decide whether somebody's function is a Lyapunov function on the checked square.

    Exit status: 0 valid, 1 invalid, 2 bad input, 3 undecided.
    """
    from nonsmooth.proofs.system_audit import audit
    from nonsmooth.proofs.verified import verified
    from nonsmooth.symbolic.files.system_file import load_any

    loaded = load_any(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    function = loaded.check.named_lyapunov if lyapunov is None else lyapunov
    if function is None:
        raise RefusedError(f"{loaded.source}: required V as --lyapunov or as check.lyapunov, received neither")
    with refusals_named(loaded):
        result = verified(audit(loaded, function))
    if json:
        from nonsmooth.reports.system_views import audit_record

        write_json(audit_record(result))
    else:
        from nonsmooth.reports.system_views import audit_view

        write_views([audit_view(result)])
    return result.verdict.exit_status
