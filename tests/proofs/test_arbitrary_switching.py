"""Arbitrary switching: the hull of several right-hand sides, against the worst switching by simulation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.full_turns import WorstTurn
from nonsmooth.proofs.systems.leading_terms import decide_leading_terms
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import few


def switching(*sides: tuple[str, str]) -> SwitchedSystem:
    document = {"system": {"states": ["x", "y"], "rhs": [list(side) for side in sides]}}
    return build_system(document, "arbitrary", Path("arbitrary.toml"))


def zelentsovsky(alpha: str) -> SwitchedSystem:
    """``x'' = -x' - (2 + u) x`` with any u between 0 and alpha: stable below about 6.985."""
    return switching(("y", "-2*x - y"), ("y", f"-(2 + {alpha})*x - y"))


def worst_factor(alpha: float) -> float:
    """Growth in a full turn where the field that grows most per angle is always chosen; by fine steps in the angle."""
    matrices = [np.array([[0.0, 1.0], [-2.0 - u, -1.0]]) for u in (0.0, alpha)]
    total, steps = 0.0, 20_000
    for angle in (np.arange(steps) + 0.5) * (2 * math.pi / steps):
        u = np.array([math.cos(angle), math.sin(angle)])
        rates = []
        for matrix in matrices:
            v = matrix @ u
            rates.append(float(u @ v) / abs(u[0] * v[1] - u[1] * v[0]))
        total += max(rates)
    return math.exp(total * 2 * math.pi / steps)


@few(1)
@pytest.mark.parametrize("alpha", ["3", "6"])
def test_certified_below_the_exact_limit(alpha: str) -> None:
    result = decide_system(zelentsovsky(alpha))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.everywhere
    assert result.check()


@few(2)
@pytest.mark.parametrize("alpha", ["3", "6.98", "6.99", "9"])
def test_the_worst_turn_against_fine_steps(alpha: str) -> None:
    found = decide_leading_terms(zelentsovsky(alpha))
    assert found is not None
    assert isinstance(found.growth, WorstTurn)
    measured = worst_factor(float(alpha))
    assert float(found.growth.turn.low) == pytest.approx(measured, rel=1e-6)
    assert float(found.growth.turn.high) == pytest.approx(measured, rel=1e-6)
    assert (found.verdict is Translation.UNSTABLE) == (measured > 1)


def test_three_fields_and_terms_of_higher_order() -> None:
    two = ("y", "-2*x - y + x**2"), ("y", "-5*x - y")
    for sides, expected in (((*two, ("y", "-4*x - y + y**3")), Translation.ASYMPTOTICALLY_STABLE),
                            ((*two, ("y", "-12*x - y")), Translation.UNSTABLE)):  # fmt: skip
        found = decide_leading_terms(switching(*sides))
        assert found is not None
        assert found.verdict is expected


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        ((("-x", "-y"), ("-2*x", "-y")), Translation.ASYMPTOTICALLY_STABLE),
        ((("-x", "-y"), ("x", "-y")), Translation.UNSTABLE),  # one of them alone
        ((("-sign(x)", "-sign(y)"), ("-2*sign(x)", "-sign(y)")), Translation.ASYMPTOTICALLY_STABLE),
    ],
)
def test_hulls(sides: tuple[tuple[str, str], ...], expected: Translation) -> None:
    assert decide_system(switching(*sides)).verdict is expected


def test_rest_by_mixtures_is_not_asymptotic() -> None:
    """0 lies between the two velocities everywhere."""
    assert decide_system(switching(("-1", "0"), ("1", "0"))).verdict is not Translation.ASYMPTOTICALLY_STABLE


def test_what_is_refused() -> None:
    with pytest.raises(SceneError, match=r"system\.rhs: required one right-hand side"):
        system_field(zelentsovsky("1"))
    with pytest.raises(SceneError, match=r"system\.rhs\[2\]: required 2 formulas"):
        switching(("x", "y"), ("x",))  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"system\.rhs\[1\]\[2\]: required a formula"):
        switching(("x", "z"), ("x", "y"))
