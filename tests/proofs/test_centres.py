"""Centres by a reflection that reverses time and by an integral of motion, and what shows nothing of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.centres import show_integral_of, show_reversible_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import few, keep

Record = dict[str, Any]

REVERSED = {
    "not conservative": ["y", "-x - x*y + x**3*y"],
    "a relay": ["y - x**2/2", "-sign(x) + x*y**2/2"],
    "a relay, other axis": ["y + x*y/2", "-2*sign(x) - 3*x*y**2"],
    "a pendulum on a spring": ["y", "-sin(x) - x"],
    "degenerate": ["y", "-x**3 + 2*x*y"],
}
KEPT = {
    "conservative": ["y", "-x + x**2"],
    "irrational": ["y", "-sqrt(2)*x + x**2"],
    "sides of two degrees": ["y + y**3", "-relu(x) + relu(-x)**3/2 - relu(x)*x**2"],
    "invariant axes": ["-y - x*y", "2*x + 2*x*y"],  # 1 + x and 1 + y; no reflection
    "an exponential": ["y", "-x**5 - 3*y**2"],
    "powers": ["6*(x + 1)*(x + 2*y)", "-3*(7*x + 2*y)*(y + 1)"],
}
RUN_IN = ["-x*y - y*(x**2 + y**2)", "-y**2 + x*(x**2 + y**2)"]  # turns, and has the symmetry


def decided(rhs: list[str]) -> StabilityResult:
    return decide_system(ns.System(["x", "y"], rhs, radius="1/2").system)


def shown(show: Callable[[SwitchedSystem], Entry], rhs: list[str]) -> bool:
    try:
        return bool(show(ns.System(["x", "y"], rhs, radius="1/2").system))
    except NotShownError:
        return False


@few(1)
@pytest.mark.parametrize("rhs", [["y", "-x + (1 + sign(x - 1/4))*y"], ["y", "-x + y*sat(x, -1/4, 1/2)"]])
def test_switching_beside_the_point_does_not_count(rhs: list[str]) -> None:
    """On a smaller square it is one smooth field; a surface outside of it is no line through the point."""
    result = decided(rhs)
    assert result.verdict is Translation.STABLE
    assert {"stability": "stable"} in certificate_of(result)["statement"]["claims"]


@pytest.fixture(scope="module")
def spring() -> Record:
    """A certificate by a reflection."""
    return certificate_of(decided(REVERSED["not conservative"]))


@pytest.fixture(scope="module")
def axes() -> Record:
    """A certificate by an integral."""
    return certificate_of(decided(KEPT["invariant axes"]))


@pytest.mark.parametrize("name", REVERSED)
def test_reflections_are_found(name: str) -> None:
    assert shown(show_reversible_of, REVERSED[name])


@pytest.mark.parametrize("name", KEPT)
def test_integrating_factors_are_found(name: str) -> None:
    assert shown(show_integral_of, KEPT[name])


SHORT = [("irrational", "INTEGRAL"), ("a pendulum on a spring", "SYMMETRY")]
CENTRES = [*((own, "INTEGRAL") for own in KEPT), *((own, "SYMMETRY") for own in REVERSED)]


@pytest.mark.parametrize(("name", "method"), keep(2, [*SHORT, *(own for own in CENTRES if own not in SHORT)]))
def test_centres_are_stable(name: str, method: str) -> None:
    result = decided({**REVERSED, **KEPT}[name])
    assert (result.verdict, result.method) == (Translation.STABLE, Method[method])
    assert "orbits near it are closed" in result.reason
    certificate = certificate_of(result)
    assert not refusal(certificate, len(json.dumps(certificate)))
    assert certificate["statement"]["claims"] == [{"stability": "stable"}]


def test_no_function_is_searched_of_centres_with_sines(monkeypatch: pytest.MonkeyPatch) -> None:
    """What they are between has none: three searches took half a minute before the reflection was tried."""
    monkeypatch.setattr("nonsmooth.proofs.systems.search.search_lyapunov", None)
    assert decided(["sin(y)", "-sin(x) + sin(x)*cos(y)*x/2"]).method is Method.SYMMETRY
    assert decided(["y", "-sin(x)"]).method is Method.CIRCLES


def test_the_reason_names_the_reflection() -> None:
    assert "(x, -y)" in decided(REVERSED["a pendulum on a spring"]).reason


def test_prey_and_predators_have_an_integrating_factor() -> None:
    """``x' = x (a - b y), y' = y (c x - d)``, which no reflection reverses (Lotka 1920, Volterra 1926)."""
    system = ns.System(["x", "y"], ["x*(2 - y)", "3*y*(x - 1)"], at=("1", "2"))
    (fact, *_) = decide_system(system.system).findings[-1].facts
    assert fact.words == "(1/2*y + 1)**-1 * (x + 1)**-1"


@pytest.mark.parametrize(
    ("powers", "lines"),
    [((1, 2, 3), ((1, 2), (-2, 1))), ((2, 1, 5), ((3, -1), (1, 1))), ((1, 4, 1), ((-1, 0), (1, -3)))],
)
def test_products_of_powers_of_three_lines_are_kept(powers: Any, lines: Any) -> None:
    """``H = prod l_i^c_i`` with ``sum c_i grad l_i = 0`` at the point, as the origin of a quadratic field."""
    x, y = sympy.symbols("x y")
    last = [-sympy.Rational(powers[0] * a + powers[1] * b, powers[2]) for a, b in zip(*lines, strict=True)]
    own = [1 + a * x + b * y for a, b in (*lines, last)]
    terms = [c / line for c, line in zip(powers, own, strict=True)]
    fields = [
        sympy.prod(own) * sum(term * line.diff(state) for term, line in zip(terms, own, strict=True)) * sign
        for state, sign in ((y, -1), (x, 1))
    ]
    rhs = [str(sympy.expand(sympy.cancel(field))) for field in fields]
    assert shown(show_integral_of, rhs)
    assert not shown(show_integral_of, [rhs[0], f"{rhs[1]} - y**3/10"])


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
def test_what_has_neither(rhs: list[str]) -> None:
    assert not shown(show_reversible_of, rhs)
    assert not shown(show_integral_of, rhs)


def test_turning_alone_shows_nothing() -> None:
    """Some solutions run into the point, and are thrown out far away: terms of least weight do not turn."""
    assert not shown(show_reversible_of, RUN_IN)
    assert decided(RUN_IN).verdict is Translation.UNSTABLE
    x, y, step, farthest = 0.0, -0.01, 1e-3, 0.0
    for _ in range(200_000):
        square = x * x + y * y
        x, y = x + step * (-x * y - y * square), y + step * (-y * y + x * square)
        farthest = max(farthest, float(np.hypot(x, y)))
    assert farthest > 0.5


CELLS = {"within": "1/4", "surfaces": [], "empty": []}
FORGED: list[tuple[str, Any]] = [
    ("rhs", [["y", "-x - x*y + y**3"]]),
    ("rhs", [["y", "-x - x*y - y**3/8"]]),
    ("rhs", [["y", "-x"], ["y", "-2*x"]]),
    ("rhs", [["y", "-sin(x + y) - x"]]),
    ("rhs", [["y", "-sqrt(Abs(x))"]]),
    ("at", ["1", "0"]),
    ("cells", {**CELLS, "within": None}),
    ("cells", {**CELLS, "surfaces": ["x - y**2"]}),
    ("cells", {**CELLS, "surfaces": ["x - 1/8"]}),
    ("cells", {**CELLS, "surfaces": ["x"]}),
    ("sense", 1),
    ("weights", {"": ["2", "1"]}),
    ("weights", {}),
]
OF_A_REFLECTION = [[["1", "0"], ["0", "-1"]], [["1", "0"], ["0", "1"]], [["0", "1"], ["1", "0"]]]
OF_AN_INTEGRAL: list[tuple[str, Any]] = [
    ("rhs", [["-y - x*y", "2*x + 2*x*y - y**3/8"]]),
    ("rhs", [["-y - x*y", "2*sin(x) + 2*x*y"]]),
    ("exponent", "x"),
    ("exponent", "Abs(x)"),
    ("factors", [["1 + x", "-1"]]),
    ("factors", [["1 + x", "-1"], ["1 + y", "1"]]),
    ("factors", [["x", "-1"], ["y", "-1"]]),
]


@pytest.mark.parametrize(("key", "value"), [*FORGED, *(("mirror", own) for own in OF_A_REFLECTION)])
def test_forged_reflections_are_rejected(key: str, value: Any, spring: Record) -> None:
    assert_rejected(spring, key, value)


@pytest.mark.parametrize(("key", "value"), [*FORGED[2:5], *FORGED[6:10], ("sense", -1), *FORGED[11:], *OF_AN_INTEGRAL])
def test_forged_integrals_are_rejected(key: str, value: Any, axes: Record) -> None:
    assert_rejected(axes, key, value)


def assert_rejected(good: Record, key: str, value: Any) -> None:
    forged = json.loads(json.dumps(good))
    part = forged["statement"]["subject"] if key in {"rhs", "at"} else forged["evidence"][0]["hypotheses"]
    assert part[key] != value
    part[key] = value
    assert refusal(forged, 10**5)
