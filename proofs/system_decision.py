"""The stability of a plain system in any number of states, and the audit of a V for it."""

from __future__ import annotations

from typing import TypeAlias

from nonsmooth.proofs.many_states.audit import ManyStateAudit, audit_many
from nonsmooth.proofs.many_states.decision import ManyStateResult, decide_many
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult, audit
from nonsmooth.proofs.systems.scalar_stability import ScalarResult, decide_scalar
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
