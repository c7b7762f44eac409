"""The stability of a plain system in any number of states, and the audit of a V for it."""

from __future__ import annotations

from typing import Any, TypeAlias

from nonsmooth.proofs.many_states.audit import ManyStateAudit, audit_many
from nonsmooth.proofs.many_states.decision import ManyStateResult, decide_many
from nonsmooth.proofs.many_states.many_certificate import build_many_certificate
from nonsmooth.proofs.systems.fan_certificate import build_fan_certificate
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult, audit
from nonsmooth.proofs.systems.scalar_certificate import build_scalar_certificate
from nonsmooth.proofs.systems.scalar_stability import ScalarResult, decide_scalar
from nonsmooth.proofs.systems.system_certificate import (
    BY_FUNCTION,
    NoCertificateError,
    build_system_certificate,
    with_stated_function,
    without_numbers,
)
from nonsmooth.proofs.systems.system_stability import SystemResult, system_check
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem, require_stated

DecidedSystem: TypeAlias = SystemResult | ScalarResult | ManyStateResult


def decide_system(system: SwitchedSystem) -> DecidedSystem:
    """Decide the stability of the checked point.

    Raises:
        SceneError: for formulas that cannot be used.
    """
    if len(system.states) > len(PLANE):
        require_stated(system)
        return decide_many(system)
    return decide_scalar(system) if len(system.states) == 1 else system_check(system)


def audit_function(scene: Scene | SwitchedSystem, lyapunov: str) -> AuditResult | ManyStateAudit:
    """Decide whether somebody's V is a Lyapunov function of an array or a plain system.

    Raises:
        SceneError: for text that is no formula of the states, and for systems in one state.
    """
    if isinstance(scene, SwitchedSystem) and len(scene.states) > len(PLANE):
        require_stated(scene)
        return audit_many(scene, lyapunov)
    return audit(scene, lyapunov)


def certificate_of(result: DecidedSystem) -> dict[str, Any]:
    """The certificate of a verdict.

    Raises:
        NoCertificateError: for a verdict that has none, in one line.
    """
    if isinstance(result, ManyStateResult):
        return build_many_certificate(result)
    if isinstance(result, ScalarResult):
        return build_scalar_certificate(result)
    if result.method not in BY_FUNCTION:
        return build_fan_certificate(result)
    try:
        return build_system_certificate(result)
    except NoCertificateError as by_function:
        return _by_other_evidence(result, by_function)


def _by_other_evidence(result: SystemResult, by_function: NoCertificateError) -> dict[str, Any]:
    """The certificate of a verdict whose V has none: by the scene's own V, or by velocities at the equilibrium.

    Raises:
        NoCertificateError: where these do not show it either: what V lacks.
    """
    by_principle = with_stated_function(result)
    try:
        other = build_fan_certificate(result) if by_principle is None else build_system_certificate(by_principle)
    except NoCertificateError:
        raise by_function from None
    return without_numbers(other, result)
