"""Plain switched systems and audited Lyapunov functions, as tables and as JSON records."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.inequalities.strata import Refutation
from nonsmooth.proofs.systems.derivatives import LyapunovResult, Supremum
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult
from nonsmooth.proofs.systems.system_stability import Domain, Method, SystemResult
from nonsmooth.proofs.systems.written_potential import potential_pieces
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.records import CHECK_SCHEMA
from nonsmooth.reports.terminal import notes_lines, two_columns, verdict_text
from nonsmooth.symbolic.number_text import short_text
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
        "lyapunov": _shown_record(result),
        "translation": {
            "verdict": str(result.verdict),
            "method": str(result.method),
            "everywhere": result.everywhere,
            "reason": result.reason,
        },
        "notes": list(angle_notes(scene.field)),
    }


def _shown_record(result: SystemResult) -> Record:
    """The V that proves the verdict, with the scene's V under ``tried`` where that is another; else the scene's V."""
    proving = result.proving
    if proving is None:
        return {**_given_record(result), "proves": False, "tried": None}
    shown = _given_record(result, proving)
    pieces = None
    if result.searched:
        parts = potential_pieces(proving.cells, result.scene.states)
        rays = [None if part.start is None else with_exact({"from": part.start, "to": part.end}) for part in parts]
        pieces = [{"V": str(part.potential), "cone": ray} for part, ray in zip(parts, rays, strict=True)]
    tried = _given_record(result) if proving is not result.lyapunov else None
    return {**shown, "V": _proving_text(result), "pieces": pieces, "proves": True, "tried": tried}


def _given_record(result: SystemResult, found: LyapunovResult | None = None) -> Record:
    """The scene's V where it was looked at, or the conditions on another one on its own domain."""
    domain = result.domain if found is not None and result.domain is not None else result.reported_domain
    return {
        "V": result.scene.check.lyapunov.text,
        "pieces": None,
        "domain": _domain_record(domain),
        **_lyapunov_record(result.lyapunov if found is None else found),
    }


def _domain_record(domain: Domain) -> Record:
    kind = "plane" if domain.radius is None else "square"
    return {"kind": kind, **with_exact({"radius": domain.radius}), "text": str(domain)}


def _proving_text(result: SystemResult) -> str:
    """V in the displacement from the equilibrium: the scene's formula, or the pieces of one that was searched."""
    if not result.searched or result.proving is None:
        return one_line(result.scene.check.lyapunov.text)
    return "; ".join(map(str, potential_pieces(result.proving.cells, result.scene.states)))


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
    """The verdict with the V that proves it, or else what the scene's V shows, and the ladder of derivatives."""
    scene, rows = result.scene, two_columns()
    rows.add_row("equilibrium", verdict_text(str(result.equilibrium)))
    proving = result.proving
    if proving is not result.lyapunov:
        place = f" (on {result.reported_domain})"
        rows.add_row(f"tried: V = {one_line(scene.check.lyapunov.text)}", Text(f"{result.lyapunov.reason}{place}"))
    for key, name in DERIVATIVES.items():
        rows.add_row(f"sup of V', {name}", Text(_supremum_text((proving or result.lyapunov).supremum(key))))
    rows.add_row("stability", verdict_text(str(result.verdict)))
    method = "" if result.method is Method.NONE else f" ({result.method})"
    rows.add_row("because", Text(f"{result.reason}{method}"))
    if proving is not None:
        rows.add_row("with", Text(f"V = {_proving_text(result)}"))
        rows.add_row("on", Text(str(result.domain)))
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
    value = "" if supremum.value is None else f" ({short_text(supremum.value)})"
    return f"{supremum.trend}{value}"


def _witness_record(witness: Refutation | None) -> Record | None:
    if witness is None:
        return None
    return {**with_exact({"point": witness.point, "value": witness.value}), "meaning": witness.meaning}


def _witness_text(witness: Refutation) -> str:
    place = ", ".join(short_text(x) for x in witness.point)
    value = "" if witness.value is None else f" (value {short_text(witness.value)})"
    return f"{witness.meaning} at ({place}){value}"
