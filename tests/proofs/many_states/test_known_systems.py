"""Systems in three to six states whose stability is known: truth, source, and what is said here."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import few, thorough

ATTRACTS, STAYS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE
OPEN = Translation.UNDECIDED


class Known(NamedTuple):
    """A system, whether its equilibrium attracts, stays or leaves, and who says so."""

    states: str
    rhs: list[Any]
    truth: Translation
    source: str
    check: Mapping[str, Any] = MappingProxyType({})
    parameters: Mapping[str, Any] = MappingProxyType({})
    said: Translation | None = None  # where that is less than the truth


CHUA = ["a*(y - x - m1*x - (m0 - m1)*sat(x, -1, 1))", "x - y + z", "-b*y - g*z"]
MAY = ["x*(1 - x - y/2 - c*z)", "y*(1 - y - z/2 - c*x)", "z*(1 - z - x/2 - c*y)"]

KNOWN = [
    Known("x y z", ["10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3"], ATTRACTS, "Lorenz 1963, rho < 1"),
    Known("x y z", ["10*(y - x)", "2*x - y - x*z", "x*y - 8*z/3"], LEAVES, "Lorenz 1963, rho > 1"),
    Known("x y z", ["y*z/3 - x", "-y - x*z", "2*x*y/3 - z"], ATTRACTS, "Euler's equations, damped: Khalil 2002"),
    Known("x y z", ["y*z/3", "-x*z", "2*x*y/3"], STAYS, "Euler's equations: energy and momentum are kept"),
    Known("a b c d", ["-a + b**3 - 3*c*d", "-a - b**3", "a*d - c", "a*c - d**3"], ATTRACTS, "Prajna et al. 2002"),
    Known(
        "x y z",
        CHUA,
        ATTRACTS,
        "hidden attractor of Chua's circuit, zero stable: Leonov, Kuznetsov, Vagaitsev 2011",
        parameters={"a": "8.4562", "b": "12.0732", "g": "0.0052", "m0": "-0.1768", "m1": "-1.1468"},
    ),
    Known(
        "x y z",
        CHUA,
        LEAVES,
        "double scroll: Chua, Komuro, Matsumoto 1986",
        parameters={"a": 9, "b": "100/7", "g": 0, "m0": "-8/7", "m1": "-5/7"},
    ),
    Known("a b c d", ["b", "c", "d", "-2*sgn(a + 3*b + 3*c + d)"], ATTRACTS, "sliding control: Utkin 1992"),
    Known("a b c d", ["b", "c", "d", "2*sgn(a + 3*b + 3*c + d)"], LEAVES, "the same with the wrong sign"),
    Known("x y z", ["y", "z", "-sgn(x)"], LEAVES, "relay of relative degree 3: Anosov 1959"),
    Known("x y z", ["y", "z", "-x - 3*y - 3*z - sgn(x)"], LEAVES, "1/(s + 1)^3 under a relay: Tsypkin"),
    Known(
        "x y z", MAY, ATTRACTS, "May and Leonard 1975, sum below 2", {"equilibrium": ["2/5"] * 3}, parameters={"c": 1}
    ),
    Known("x y z", MAY, LEAVES, "May and Leonard 1975, sum above 2", {"equilibrium": ["2/7"] * 3}, parameters={"c": 2}),
    Known(
        "x y z",
        [["-x + y", "-2*y + 3*z", "-z"], ["-2*x - 5*y + z", "-y", "-3*z"]],
        ATTRACTS,
        "triangular under arbitrary switching: Liberzon 2003",
    ),
    Known("x y z", ["y", "z", "-2*x - 3*y - z"], ATTRACTS, "Routh 1877, 3 > 2"),
    Known("x y z", ["y", "z", "-4*x - 3*y - z"], LEAVES, "Routh 1877, 3 < 4"),
    Known("x y z", ["y", "z", "-3*x - 3*y - z"], STAYS, "Routh 1877, 3 = 3"),
    Known("a b c d", ["b", "-a + c", "d", "-c"], LEAVES, "two equal oscillators in a row: resonance"),
    Known(
        "a b c d",
        ["b", "-2*a + c - sgn(b)", "d", "a - 2*c - sgn(d)"],
        STAYS,
        "dry friction, rests all over a square: Leine and van de Wouw 2008",
        {"lyapunov": "a**2 + c**2 - a*c + b**2/2 + d**2/2"},
    ),
    Known("x y z", ["-sgn(x) + y", "-2*sgn(y) + z", "-3*sgn(z)"], ATTRACTS, "a cascade of relays"),
    Known(
        "a b c d e",
        [
            "-a + sat(b, -1, 1)/2",
            "-b + sat(c, -1, 1)/2",
            "-c + sat(d, -1, 1)/2",
            "-d + sat(e, -1, 1)/2",
            "-e - sat(a, -1, 1)/2",
        ],
        ATTRACTS,
        "a ring of saturated neurons with gain below 1: Hopfield 1984",
    ),
    Known("x y z", ["-x + relu(y)", "-y + relu(z)", "-z - relu(x)"], ATTRACTS, "a negative loop of rectifiers"),
    Known("x y z", ["-x + 2*relu(y)", "-y + 2*relu(z)", "-z + 2*relu(x)"], LEAVES, "a positive loop of gain 8"),
    Known("a b c d", ["b", "-2*a + c - b", "d", "a - 2*c"], ATTRACTS, "two masses, one damper: Kelvin and Tait"),
    Known("x y z", ["1 - sgn(x)/2", "-y", "-z"], LEAVES, "0 is no mixture of the velocities"),
]
# Of kinds that stand above or, as rings of relays do, in test_attacks.py.
FURTHER = [
    Known(
        "x y z",
        ["-x**3 - x*z**2", "-y - x**2*y", "-z - 3*z/(z**2 + 1) + 3*x**2*z"],
        ATTRACTS,
        "SOSTOOLS user's guide, sec. 4.2",
    ),
    Known("x y z", ["y", "z", "-x - 2*y - z - 2*sgn(x + y + z)"], ATTRACTS, "sliding control: Utkin 1992"),
    Known(
        "a b c d",
        ["-sgn(a) + b/2", "-sgn(b) + c/2", "-sgn(c) + d/2", "-sgn(d) - a/2"],
        ATTRACTS,
        "a ring of relays: the sum of absolute values falls",
    ),
    Known(
        "a b c d e f",
        ["-sgn(a) + b/2", "-sgn(b) + c/2", "-sgn(c) + d/2", "-sgn(d) + e/2", "-sgn(e) + f/2", "-sgn(f) - a/2"],
        ATTRACTS,
        "a ring of six relays",
    ),
]


def build(known: Known) -> SwitchedSystem:
    system: dict[str, Any] = {"states": known.states.split(), "rhs": known.rhs}
    if known.parameters:
        system["parameters"] = dict(known.parameters)
    return build_system({"system": system, "check": dict(known.check)}, "t", Path("t.toml"))


@few(5)
@pytest.mark.parametrize(
    "known", [*KNOWN, *(pytest.param(known, marks=thorough) for known in FURTHER)], ids=lambda known: known.source[:40]
)
def test_known_systems(known: Known) -> None:
    result = decide_system(build(known))
    assert result.verdict is (known.said or known.truth)
    assert result.check()
