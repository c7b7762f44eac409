"""A V that is a quotient: where no polynomial serves, and what the checker refuses of one."""

from __future__ import annotations

import copy
from functools import cache
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.quotients import find_quotient
from nonsmooth.proofs.kernel_strategies import decide_by_quotient
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import checked_point
from nonsmooth.proofs.systems.findings import Known
from tests.thorough import keep, thorough

TURN = "-x**4 + 2*x**2*y**2 + y**4", "x**4 + 2*x**2*y**2 - y**4"  # gradient of V, times |x|^4/2, over x and y
NO_POLYNOMIAL = [  # Ahmadi and El Khadir 2018: no polynomial V at all
    f"-2*y*({TURN[0]}) - 2*x*(x**2 + y**2)*({TURN[1]})",
    f"2*x*({TURN[1]}) - 2*y*(x**2 + y**2)*({TURN[0]})",
]
GROWING = [
    f"-2*y*({TURN[0]}) + 2*x*(x**2 + y**2)*({TURN[1]})",
    f"2*x*({TURN[1]}) + 2*y*(x**2 + y**2)*({TURN[0]})",
]
V = "(x**4 + y**4)/(x**2 + y**2)"


@cache
def decided(rhs: tuple[str, ...], lyapunov: str | None = None) -> Any:
    return ns.System(["x", "y", "z"][: len(rhs)], list(rhs), lyapunov=lyapunov).check()


@cache
def certificate() -> dict[str, Any]:
    found: dict[str, Any] = decided(tuple(NO_POLYNOMIAL), V).certificate()
    return found


def refused(changed: dict[str, Any]) -> str:
    own = copy.deepcopy(certificate())
    own["evidence"][0]["hypotheses"].update(changed)
    return refusal(own, len(certificate_text(own)))


@pytest.mark.parametrize("stated", keep(1, [V, None]))
def test_no_polynomial_serves(stated: str | None) -> None:
    """The stated quotient is taken, and the same is found without it; all starts come to the point."""
    result = decided(tuple(NO_POLYNOMIAL), stated)
    assert result.verdict == "asymptotically stable"
    assert result.evidence.reach.everywhere
    claims = result.certificate()["statement"]["claims"]
    assert claims == [{"stability": "asymptotically stable"}, {"attracts": "everywhere"}]


def test_a_quotient_is_found() -> None:
    found = decide_by_quotient(checked_point(ns.System(["x", "y"], NO_POLYNOMIAL).system), Known())
    assert found is not None
    assert found.verdict is Translation.ASYMPTOTICALLY_STABLE


def test_floats_come_nearer() -> None:
    """By steps of Runge and Kutta of the literal formulas, in a time in which the field has the size of x."""

    def field(place: np.ndarray) -> np.ndarray:
        x, y = place
        first, second = -(x**4) + 2 * x**2 * y**2 + y**4, x**4 + 2 * x**2 * y**2 - y**4
        square = x**2 + y**2
        own = [-2 * y * first - 2 * x * square * second, 2 * x * second - 2 * y * square * first]
        return np.stack(own) / square**2

    x = np.random.default_rng(0).uniform(-1, 1, (2, 50))
    start = np.linalg.norm(x, axis=0)
    for _ in range(4_000):
        a = field(x)
        b = field(x + 0.005 * a)
        x = x + 0.01 * b
    assert (np.linalg.norm(x, axis=0) < 0.9 * start).mean() > 0.8


@thorough  # forged ones: test_false_quotients_are_refused
def test_a_stated_quotient_that_grows_shows_nothing() -> None:
    result = decided(tuple(GROWING), V)
    assert result.verdict != "asymptotically stable"
    assert "tried: V = (x**4 + y**4)/(x**2 + y**2)" in str(result.facts()) + str(result)


@pytest.mark.parametrize(
    "changed",
    [
        {"denominator": "x**2 - y**2"},
        {"denominator": "-(x**2 + y**2)", "function": "-(x**4 + y**4)"},
        {"denominator": "x**2"},
        {"denominator": "x**4 + y**4"},  # V = 1
        {"denominator": "(x**2 + y**2)**3"},  # V is not bounded at the point
        {"denominator": "x**2 + y**2 + x**4"},  # neither a form nor positive at the point
        {"denominator": "Abs(x) + Abs(y)"},
        {"denominator": None},
        {"rate": {"kind": "exponential", "kappa": "1/1000000"}},
        {"second": {"functions": ["x"], "zeros": {}}},
    ],
)
def test_false_quotients_are_refused(changed: dict[str, Any]) -> None:
    assert refused(changed)


def test_a_mesh_beside_a_quotient_is_refused() -> None:
    """Its level set is that of the quotient, not of the numerator."""
    own = copy.deepcopy(certificate())
    entry = own["evidence"][0]
    corners = ["-1 -1 0", "1 -1 0", "0 1 0"]
    mesh = {"unit": "1/8", "corners": corners, "triangles": ["0 1 2"]}
    entry["hypotheses"] = {"local": entry["hypotheses"], "surfaces": [], "mesh": mesh, "below": 1}
    entry["theorem"] = "basin"
    assert "denominator" in refusal(own, len(certificate_text(own)))


@pytest.mark.parametrize(
    "text", ["1/x", "x**3/(x + y)", "x**4/(x**2 + y**3)", "x**2/(y**2 - 1)", "(x**2 + y**2)/(1 + Abs(x))", "x**2/(1/y)"]
)
def test_other_divisions_are_refused_in_one_line(text: str) -> None:
    with pytest.raises(ns.SceneError, match=r"check\.lyapunov"):
        ns.System(["x", "y"], ["-x", "-y"], lyapunov=text)


def test_simplex_steps_that_go_round_in_circles_come_to_an_end() -> None:
    rhs = ["-3*x/(1 + x**2) - z*x**2/2", "-3*y + x/(2*(1 + y**2)) + y*x**2", "-2*z + 2*z**2"]
    assert find_quotient(ns.System(["x", "y", "z"], rhs).system, everywhere=True) is None
