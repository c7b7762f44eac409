"""Plain switched systems and audited Lyapunov functions, as tables and as JSON records."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.inequalities.strata import Refutation
from nonsmooth.proofs.systems.derivatives import LyapunovResult, Supremum
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.records import CHECK_SCHEMA
from nonsmooth.reports.terminal import brief, notes_lines, two_columns, verdict_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene_error import one_line

AUDIT_SCHEMA = "nonsmooth-audit/1"
DERIVATIVES = {
    "naive": "naive",
    "shevitz_paden": "Shevitz-Paden",
    "bacciotti_ceragioli": "Bacciotti-Ceragioli",
}


def system_record(result: SystemResult) -> Record:
    """The verdict on a plain system; points are measured from the equilibrium."""
    scene = result.scene
    return {
        "schema": CHECK_SCHEMA,
        "scene": scene.name,
        "states": list(scene.states),
        **with_exact({"radius": scene.check.radius}),
        "equilibrium": {"verdict": str(result.equilibrium), **with_exact({"at": scene.check.equilibrium})},
        "lyapunov": {"V": scene.check.lyapunov.text, **_lyapunov_record(result.lyapunov)},
        "translation": {
            "verdict": str(result.verdict),
            "method": str(result.method),
            "everywhere": result.everywhere,
            "reason": result.reason,
        },
        "notes": list(angle_notes(scene.field)),
    }


def audit_record(result: AuditResult) -> Record:
    """The verdict on somebody's Lyapunov function."""
    derivatives = {} if result.result is None else _lyapunov_record(result.result)
    return {
        "schema": AUDIT_SCHEMA,
        "scene": result.scene.name,
        "V": result.lyapunov,
        **derivatives,
        "verdict": str(result.verdict),
        "proves": None if result.proves is None else str(result.proves),
        "reason": result.reason,
        "witness": _witness_record(result.witness),
    }


def system_view(result: SystemResult) -> RenderableType:
    """The verdict with the ladder of derivatives."""
    scene, rows = result.scene, two_columns()
    rows.add_row("equilibrium", verdict_text(str(result.equilibrium)))
    for key, name in DERIVATIVES.items():
        rows.add_row(f"sup of V', {name}", Text(_supremum_text(result.lyapunov.supremum(key))))
    rows.add_row(f"V = {one_line(scene.check.lyapunov.text)}", Text(str(result.lyapunov.reason)))
    rows.add_row("stability", verdict_text(str(result.verdict)))
    rows.add_row("because", Text(f"{result.reason} ({result.method})"))
    head = f"{one_line(scene.name)}: plain switched system in {', '.join(scene.states)}"
    return Group(Text(head), rows, *notes_lines(scene.field))


def audit_view(result: AuditResult) -> RenderableType:
    """The verdict on V in words."""
    rows = two_columns()
    rows.add_row(f"V = {one_line(result.lyapunov)}", verdict_text(str(result.verdict)))
    if result.result is not None:
        for key, name in DERIVATIVES.items():
            rows.add_row(f"sup of V', {name}", Text(_supremum_text(result.result.supremum(key))))
    rows.add_row("because", Text(result.reason))
    if result.proves is not None:
        rows.add_row("shows", Text(f"the equilibrium is {result.proves}"))
    if result.witness is not None:
        rows.add_row("witness", Text(_witness_text(result.witness)))
    return Group(Text(f"{one_line(result.scene.name)}: audit of a Lyapunov function"), rows)


def _lyapunov_record(result: LyapunovResult) -> Record:
    derivatives: dict[str, Any] = {key: _supremum_record(result.supremum(key)) for key in DERIVATIVES}
    return {
        **derivatives,
        "verdict": result.verdict.name.lower(),
        "reason": result.reason,
        "witness": _witness_record(result.witness),
    }


def _supremum_record(supremum: Supremum) -> Record:
    return {"sign": str(supremum.trend), **with_exact({"value": supremum.value, "point": supremum.point})}


def _supremum_text(supremum: Supremum) -> str:
    value = "" if supremum.value is None else f" ({brief(supremum.value)})"
    return f"{supremum.trend}{value}"


def _witness_record(witness: Refutation | None) -> Record | None:
    if witness is None:
        return None
    return {**with_exact({"point": witness.point, "value": witness.value}), "meaning": witness.meaning}


def _witness_text(witness: Refutation) -> str:
    place = ", ".join(brief(x) for x in witness.point)
    value = "" if witness.value is None else f" (value {brief(witness.value)})"
    return f"{witness.meaning} at ({place}){value}"
