"""Points that are stable because a polynomial is kept: textbook systems, certificates, and points that are not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import sympy

import nonsmooth as ns
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.many_states.first_integrals import find_kept_function
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import contradiction
from tests.thorough import but, few

STATES = ("x", "y", "u", "v")
RIGID = ["y*u", "-2*x*u", "x*y"]
KEPT: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "rigid body about its long axis": (RIGID, "100"),
    "rigid body about its short axis": (RIGID, "001"),
    "Henon and Heiles": (["u", "v", "-x - 2*x*y", "-y - x**2 + y**2"], "0000"),
    "three species": (["x*(y - u)", "y*(u - x)", "u*(x - y)"], "111"),
    "linear": (["y", "-x", "v", "-2*u"], "0000"),
}


def system(rhs: Sequence[str], at: Sequence[str]) -> SwitchedSystem:
    return ns.System(list(STATES[: len(rhs)]), list(rhs), at=tuple(at)).system


@few(2)
@pytest.mark.parametrize("name", but(["Henon and Heiles"], KEPT))
def test_points_are_stable_and_certified(name: str) -> None:
    result = decide_system(system(*KEPT[name]))
    assert result.verdict is Translation.STABLE
    assert "not asymptotically" in result.reason
    certificate = certificate_of(result)
    assert {"stability": "stable"} in certificate["statement"]["claims"]
    assert not contradiction(certificate["statement"], 0.25)


def test_what_is_kept_is_an_integral() -> None:
    rhs, at = KEPT["three species"]
    found = find_kept_function(system(rhs, at))
    assert found is not None
    x, y, u = states = sympy.symbols("x y u")
    potential = sympy.sympify(found.formula.text).subs(dict(zip(states, (x - 1, y - 1, u - 1), strict=True)))
    rate = sum(potential.diff(own) * sympy.sympify(field) for own, field in zip(states, rhs, strict=True))
    assert sympy.expand(rate) == 0
    hessian = np.array(sympy.hessian(potential, states).subs(dict.fromkeys(states, 1)), dtype=float)
    assert np.linalg.eigvalsh(hessian).min() > 0


@pytest.mark.parametrize(
    ("rhs", "at"),
    [
        (RIGID, "010"),  # the middle axis
        (["u", "v", "-x - 2*x*y", "-y - x**2 + y**2 - v**3"], "0000"),  # damped
        (["u", "v", "-x", "y"], "0000"),  # an integral of both signs
        (["-x", "-y", "-u"], "000"),
    ],
)
def test_nothing_is_found_of_others(rhs: Sequence[str], at: str) -> None:
    assert find_kept_function(system(rhs, at)) is None
