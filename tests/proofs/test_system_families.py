"""Known systems in families: every third here, all of them in tests/benchmarks."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.proofs.system_families import Known, families
from tests.thorough import few

SLOW = {"relay, viscous 1/4", "damping at one side only"}
CHOSEN = [known for known in list(families())[::3] if known.name not in SLOW]


def system_of(known: Known) -> SwitchedSystem:
    document = {"system": {"states": ["x", "y"], "rhs": list(known.rhs)}, "check": dict(known.check)}
    return build_system(document, known.name, Path("known.toml"))


@few(1)
@pytest.mark.parametrize("known", CHOSEN, ids=lambda known: known.name)
def test_known_systems(known: Known) -> None:
    system = system_of(known)
    result = decide_system(system)
    assert str(result.verdict) == known.truth
    assert result.check()
    function = result.function
    if (
        isinstance(function, PlaneFunction)
        and function.formula is not None
        and not (function.grows or function.is_given)
    ):
        document = {"equilibrium": known.check.get("equilibrium", [0, 0]), "radius": str(function.domain.radius)}
        smaller = build_system(
            {"system": {"states": ["x", "y"], "rhs": list(known.rhs)}, "check": document}, "again", Path("again.toml")
        )
        assert audit(smaller, function.text).verdict is AuditVerdict.VALID


def test_there_are_enough_families() -> None:
    assert len(list(families())) >= 60
    assert len({known.name for known in families()}) == len(list(families()))
