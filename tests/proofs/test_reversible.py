"""Centres by a reflection that reverses time, and what shows nothing of them."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.reversible import show_reversible_of
from nonsmooth.proofs.kernel.search import NotShownError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from tests.thorough import few

Record = dict[str, Any]

CENTRES = {
    "conservative": ["y", "-x + x**2"],
    "of odd degree": ["y", "-x - 2*x**3 + x**4/2"],
    "not conservative": ["y", "-x - x*y + x**3*y"],
    "a relay": ["y - x**2/2", "-sign(x) + x*y**2/2"],
    "a relay, other axis": ["y + x*y/2", "-2*sign(x) - 3*x*y**2"],
    "sides of two degrees": ["y + y**3", "-relu(x) + relu(-x)/2 - x**2*Abs(x)"],
    "a pendulum on a spring": ["y", "-sin(x) - x"],
}
RUN_IN = ["-x*y - y*(x**2 + y**2)", "-y**2 + x*(x**2 + y**2)"]  # turns, and has the symmetry


@cache
def decided(name: str) -> StabilityResult:
    return decide_system(ns.System(["x", "y"], CENTRES[name], radius="1/2").system)


def shown(rhs: list[str]) -> bool:
    try:
        return bool(show_reversible_of(ns.System(["x", "y"], rhs, radius="1/2").system))
    except NotShownError:
        return False


@pytest.fixture(scope="module")
def spring() -> Record:
    """The certificate of ``x'' = -x + x^2``."""
    return certificate_of(decided("conservative"))


@pytest.mark.parametrize("name", CENTRES)
def test_centres_have_the_symmetry(name: str) -> None:
    assert shown(CENTRES[name])


@few(2)
@pytest.mark.parametrize("name", CENTRES)
def test_centres_are_stable(name: str) -> None:
    result = decided(name)
    assert result.verdict is Translation.STABLE
    certificate = certificate_of(result)
    assert not refusal(certificate, len(json.dumps(certificate)))


def test_the_reason_says_that_orbits_are_closed(spring: Record) -> None:
    result = decided("conservative")
    assert result.method is Method.SYMMETRY
    assert "orbits near it are closed" in result.reason
    assert "(x, -y)" in result.reason
    assert spring["statement"]["claims"] == [{"stability": "stable"}]


@pytest.mark.parametrize("name", ["a relay", "not conservative"])
def test_orbits_close_in_floats(name: str) -> None:
    """After a turn a solution is where it began, but for the errors of small steps."""
    fields = {
        "a relay": lambda x, y: (y - x * x / 2, -np.sign(x) + x * y * y / 2),
        "not conservative": lambda x, y: (y, -x - x * y + x**3 * y),
    }
    x, y, step, turned = 0.0, 0.2, 1e-4, 0.0
    while turned < 2 * np.pi:
        a, b = fields[name](x, y)
        a, b = fields[name](x + step / 2 * a, y + step / 2 * b)
        turned += step * abs(x * b - y * a) / (x * x + y * y)
        x, y = x + step * a, y + step * b
    assert np.hypot(x, y - 0.2) < 2e-3


@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "-x + x**2 - y**3"],  # damped
        ["y", "-x + x**2 + y**3"],
        ["y", "x + x**3"],  # a saddle does not turn
        ["y", "-x + x**2*sign(x - y)"],  # a line that the reflection does not keep
        ["y", "-sin(x + y) - x"],
    ],
)
def test_what_has_no_such_symmetry(rhs: list[str]) -> None:
    assert not shown(rhs)


def test_turning_alone_shows_nothing() -> None:
    """Some solutions run into the point, and are thrown out far away: no W is kept, and the point is unstable."""
    assert not shown(RUN_IN)
    assert decide_system(ns.System(["x", "y"], RUN_IN, radius="1/2").system).verdict is Translation.UNSTABLE
    x, y, step, farthest = 0.0, -0.01, 1e-3, 0.0
    for _ in range(200_000):
        square = x * x + y * y
        x, y = x + step * (-x * y - y * square), y + step * (-y * y + x * square)
        farthest = max(farthest, float(np.hypot(x, y)))
    assert farthest > 0.5


FORGED: list[tuple[str, Any]] = [
    ("rhs", [["y", "-x + x**2 + y**3"]]),
    ("rhs", [["y", "-x + x**2 - y**3/8"]]),
    ("rhs", [["y", "-x"], ["y", "-2*x"]]),
    ("rhs", [["y", "-sin(x + y) - x"]]),
    ("rhs", [["y", "-sqrt(Abs(x))"]]),
    ("at", ["1", "0"]),
    ("mirror", [["-1", "0"], ["0", "1"]]),
    ("mirror", [["1", "0"], ["0", "1"]]),
    ("mirror", [["0", "1"], ["1", "0"]]),
    ("factor", "0"),
    ("factor", "4"),
    ("factor", "-1/100"),
    ("function", "x**2 - y**2"),
    ("function", "x**2"),
    ("function", "1 + x**2 + y**2"),
    ("cells", {"within": None, "surfaces": [], "empty": []}),
    ("cells", {"within": "1/4", "surfaces": ["x - y**2"], "empty": []}),
    ("cells", {"within": "1/4", "surfaces": ["x - 1/8"], "empty": []}),
]


@pytest.mark.parametrize(("key", "value"), FORGED)
def test_forged_reflections_are_rejected(key: str, value: Any, spring: Record) -> None:
    forged = json.loads(json.dumps(spring))
    part = forged["statement"]["subject"] if key in {"rhs", "at"} else forged["evidence"][0]["hypotheses"]
    assert part[key] != value
    part[key] = value
    assert refusal(forged, 10**5)
