"""Energies with sines and cosines: pendulums that swing for ever, and what shows nothing of them."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.many_states.weak_functions import find_energy_on_circles
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method

Record = dict[str, Any]

PENDULUM = ["y", "-sin(x)"]
COUPLED = ["u", "v", "-sin(a) - sin(a - b)", "-sin(b) + sin(a - b)"]


def decided(rhs: list[str]) -> StabilityResult:
    return decide_system(ns.System(["x", "y"], rhs).system)


@cache
def swinging() -> StabilityResult:
    return decided(PENDULUM)


@pytest.fixture(scope="module")
def pendulum() -> Record:
    """Its certificate."""
    return certificate_of(swinging())


def test_a_pendulum_is_stable_by_its_energy(pendulum: Record) -> None:
    result = swinging()
    assert (result.verdict, result.method) == (Translation.STABLE, Method.CIRCLES)
    assert result.check()
    assert not refusal(pendulum, len(json.dumps(pendulum)))
    assert pendulum["statement"]["claims"] == [{"stability": "stable"}]


@pytest.mark.parametrize("rhs", [["y", "-sin(x) - sin(2*x)/4"], ["y", "-2*sin(x) - y**3*0"], ["2*y", "-sin(x)"]])
def test_other_potentials(rhs: list[str]) -> None:
    found = find_energy_on_circles(ns.System(["x", "y"], rhs).system)
    assert found is not None
    *_, is_kept = found
    assert is_kept


def test_coupled_pendulums() -> None:
    """V is kept along solutions of another integrator."""
    found = find_energy_on_circles(ns.System(list("abuv"), COUPLED).system)
    assert found is not None
    _, text, _, is_kept = found
    assert is_kept
    z = np.array([0.3, -0.2, 0.1, 0.4])

    def rate(z: Any) -> Any:
        a, b, u, v = z
        return np.array([u, v, -np.sin(a) - np.sin(a - b), -np.sin(b) + np.sin(a - b)])

    def energy(z: Any) -> float:
        names = {"sin": np.sin, "cos": np.cos, **dict(zip("abuv", z, strict=True))}
        return float(eval(text, {"__builtins__": {}}, names))  # noqa: S307 (the program's own words)

    first = energy(z)
    for _ in range(4000):
        k1 = rate(z)
        k2 = rate(z + 0.0025 * k1)
        k3 = rate(z + 0.0025 * k2)
        z = z + 0.005 / 6 * (k1 + 2 * k2 + 2 * k3 + rate(z + 0.005 * k3))
    assert energy(z) == pytest.approx(first, rel=1e-6)


@pytest.mark.parametrize("rhs", [["y", "sin(x)"], ["y", "-sin(x) + y/8"]])
def test_what_is_unstable_is_not_called_stable(rhs: list[str]) -> None:
    assert decided(rhs).verdict is Translation.UNSTABLE


@pytest.mark.parametrize("rhs", [["y", "-sin(x) - x"], ["y", "-sin(x/2)"], ["y", "-sin(x*y) - x**3"]])
def test_states_that_are_no_angles(rhs: list[str]) -> None:
    assert find_energy_on_circles(ns.System(["x", "y"], rhs).system) is None


FORGED: list[tuple[str, Any]] = [
    ("rhs", [["y", "-sin(x) - x"]]),
    ("rhs", [["y", "-sin(x/2)"]]),
    ("rhs", [["y", "-sin(x + y)"]]),
    ("rhs", [["y", "sin(x)"]]),
    ("rhs", [["y", "-sin(x)"], ["y", "-sin(x) + y"]]),
    ("rhs", [["y", "-sin(x) - sign(sin(x))"]]),
    ("at", ["1", "0"]),
    ("angles", []),
    ("angles", ["y"]),
    ("angles", ["x", "x"]),
    ("angles", ["x", "y"]),
    ("function", "y**2 + sin_x**2"),
    ("function", "y**2 + 2*sin_x**2 + cos_x**2"),
    ("function", "y**2 + x**2"),
]


@pytest.mark.parametrize(("key", "value"), FORGED)
def test_forged_energies_are_rejected(key: str, value: Any, pendulum: Record) -> None:
    forged = json.loads(json.dumps(pendulum))
    part = forged["statement"]["subject"] if key in {"rhs", "at"} else forged["evidence"][0]["hypotheses"]
    part[key] = value
    assert refusal(forged, 10**5)
