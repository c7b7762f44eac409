"""The stability of a plain system in one state or in two."""

from __future__ import annotations

from nonsmooth.proofs.systems.scalar_stability import ScalarResult, decide_scalar
from nonsmooth.proofs.systems.system_stability import SystemResult, system_check
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem, require_stated


def decide_system(system: SwitchedSystem) -> SystemResult | ScalarResult:
    """Decide the stability of the checked point.

    Raises:
        SceneError: for more than two states, and for formulas that cannot be used.
    """
    if len(system.states) > len(PLANE):
        require_stated(system)
    return decide_scalar(system) if len(system.states) == 1 else system_check(system)
