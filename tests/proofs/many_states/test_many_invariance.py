"""LaSalle's principle in many states, beside observability of what slides, and paths."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.findings import Method
from tests.dissipative_systems import dissipative_systems
from tests.plain import built
from tests.thorough import few, keep, thorough

ATTRACTS, STAYS = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE
SQUARES = "x**2 + y**2 + z**2"


@few(6)
@pytest.mark.parametrize(
    ("rhs", "lyapunov", "proves"),
    [
        (["y", "-x - y**3 - z", "y - z"], SQUARES, ATTRACTS),
        (["y", "-x - z", "y - z**3"], SQUARES, ATTRACTS),  # seen after two derivatives
        (["y", "-x**3 - y", "-z"], "x**4/2 + y**2 + z**2", ATTRACTS),
        (["y", "-x - sgn(y + z)", "-z - sgn(y + z)"], SQUARES, ATTRACTS),  # y - z does not jump
        (["y", "-x - sgn(y + z)", "-sgn(y + z)"], SQUARES, STAYS),  # slides and oscillates on y + z = 0
        (["y", "-x - sgn(y)", "-z"], SQUARES, STAYS),  # dry friction: a segment of rest
        (["y", "-x + z", "-y - sgn(z)"], SQUARES, STAYS),  # the relay holds z, and x and y oscillate
        (["y", "-x - y**3", "0"], SQUARES, STAYS),
        # on x = 0 one field may be taken alone, so that y or z stays; both together damp both
        (["-x", "-y*(1 + sgn(x))/2", "-z*(1 - sgn(x))/2"], SQUARES, STAYS),
        (["y", "-x", "-z"], SQUARES, STAYS),
        (["y", "-x - relu(y)", "-z"], SQUARES, ATTRACTS),  # V is kept in half the space, which is crossed
        # the pieces of V differ, though its gradient does not jump
        (["y", "-x - relu(x) - y**3", "-z"], "x**2 + relu(x)**2 + y**2 + z**2", ATTRACTS),
    ],
)
def test_what_a_function_proves(rhs: list[str], lyapunov: str, proves: Translation) -> None:
    audited = audit(built(rhs), lyapunov)
    assert (audited.verdict, audited.proves) == (AuditVerdict.VALID, proves)


def test_a_held_relay_keeps_its_oscillation() -> None:
    """The path that the principle must not overlook, and one that it decides."""
    kept = built(["y", "-x + z", "-y - sgn(z)"])
    end = simulate(system_field(kept, (0.3, 0.0, 0.0)), (0.3, 0.0, 0.0), 40.0).end.state
    assert np.hypot(end[0], end[1]) == pytest.approx(0.3, abs=1e-6)
    left = built(["y", "-x - sgn(y + z)", "-z - sgn(y + z)"])
    end = simulate(system_field(left, (0.3, 0.0, 0.0)), (0.3, 0.0, 0.0), 40.0).end.state
    assert np.linalg.norm(end) < 1e-3


def test_the_check_asks_the_named_v_after_its_searches() -> None:
    result = decide_system(built(["y", "-x**3 - y**3", "-z"], lyapunov="x**4/2 + y**2 + z**2"))
    assert (result.verdict, result.method) == (ATTRACTS, Method.INVARIANCE)
    assert result.function is result.given
    assert result.check()


@pytest.mark.usefixtures("strict_search")
def test_the_check_decides_by_the_principle() -> None:
    result = decide_system(built(["y", "-x - z", "y - z**5"]))
    assert (result.verdict, result.method) == (ATTRACTS, Method.INVARIANCE)
    assert result.check()
    stays = decide_system(built(["y", "-x + z", "-y - sgn(z)"]))
    assert stays.verdict is STAYS
    claimed = replace(result.deciding, function=stays.function)
    assert not replace(stays, findings=(*stays.findings, claimed)).check()
    assert not replace(stays, findings=(*stays.findings, result.deciding)).check()


@thorough  # the same systems by certificates: test_second_function.py
@pytest.mark.parametrize("count", keep(1, [8, 30]))
def test_random_dissipative_systems_against_observability(count: int) -> None:
    known: Counter[tuple[bool, bool]] = Counter()
    for system in dissipative_systems(count):
        audited = audit(built(system.rhs, states=system.states), system.energy)
        if audited.proves is None:
            continue
        known[audited.proves is ATTRACTS, system.attracts] += 1
        assert audited.proves is not ATTRACTS or system.attracts, system.rhs
    assert known[True, True] >= count // 8
    assert known[False, False] >= count // 8
    assert not known[False, True]  # complete on these
