"""Attraction of every start by a V on the whole space, and when one is searched."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.proofs.checker.files import parse
from nonsmooth.proofs.checker.statements import refusal, show_evidence
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.kernel.cells import started, stated_cells
from nonsmooth.proofs.kernel.search import NotShownError, SampledProofs, stability_hypotheses
from nonsmooth.proofs.kernel.whole_space import logarithmic_functions
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from tests.oracles.floats import midpoint
from tests.plain import built, decided
from tests.thorough import but, few

# ---- Attraction of every start by a V on the whole space: against other points of rest, paths from afar, forged
# claims.

SIZE = 1 << 20  # of a file, for which there is enough work
FAR, WIDTH = 30.0, 1e-3
EVERYWHERE = {"attracts": "everywhere"}
GLOBAL = [
    ["-x**3 - y", "x - y**3"],
    ["-x*(1 + y**2)", "-y*(1 + x**2)"],
    ["-y - x*(x**2 + y**2)", "x - y*(x**2 + y**2)", "-z + x*y/2"],
    ["y - x**3 - sign(x)", "-x - y"],
    ["y", "-Max(-1, Min(1, x)) - y"],
    ["y", "-sign(x) - y"],
    ["-y - x**3", "2*x*Abs(x)"],
    ["y", "-x - y/(1 + Abs(y))"],
    ["-x + 3*x*y**3", "-y"],
    ["y - x/2 - Max(-1/2, Min(1/2, x - y/2))", "-x - y + Max(-1/4, Min(1/4, x/2 + y))"],
    ["y", "-x**3 - y + z", "-y - z**3"],
]
LONG = [
    ["-y - x**3", "2*x*Abs(x)"],
    ["y", "-sign(x) - y"],
    ["y - x/2 - Max(-1/2, Min(1/2, x - y/2))", "-x - y + Max(-1/4, Min(1/4, x/2 + y))"],
    ["y", "-x**3 - y + z", "-y - z**3"],
]


def rounded(formula: sp.Expr) -> sp.Expr:
    """A sign without a jump, on which an integrator would chatter."""
    return formula.replace(sp.sign, lambda x: x / sp.sqrt(x**2 + WIDTH**2))


@few(4)
@pytest.mark.parametrize("rhs", but(LONG, GLOBAL), ids="; ".join)
def test_every_start_arrives(rhs: list[str]) -> None:
    result = decided(rhs)
    assert result.reach.everywhere
    certificate = certificate_of(result)
    assert EVERYWHERE in certificate["statement"]["claims"]
    assert not refusal(certificate, SIZE)
    names = sp.symbols("x y z")[: len(rhs)]
    field = sp.lambdify([names], [rounded(sp.sympify(text)) for text in rhs])
    start = np.random.default_rng(0).normal(size=len(rhs))
    start *= FAR / np.linalg.norm(start)
    solved = solve_ivp(lambda _, place: field(place), (0, 60), start, "LSODA", max_step=0.05)
    assert np.linalg.norm(solved.y[:, -1]) < FAR / 60


@pytest.mark.parametrize(
    "rhs",
    [
        ["-x + x**3", "-y"],  # other points of rest
        ["-x + x**2*y", "-y"],  # solutions that go to infinity
        ["-x/(1 - x**3/10)", "-y"],  # a denominator that is not positive beyond
        ["-sin(x) - x/8", "-y"],  # enclosed on the square alone
        ["-x*(1 - relu(x - 3))", "-y"],  # rests at x = 4, beyond the square
    ],
    ids="; ".join,
)
def test_what_holds_on_the_square_need_not_hold_beyond(rhs: list[str]) -> None:
    assert not decided(rhs).reach.everywhere


def test_a_denominator_that_is_a_square_may_be_zero_elsewhere() -> None:
    """On the line ``x = 0`` the point has no velocity: what is said of the plane needs a number beside the square."""
    sides = [f"-(x - 1)/{below}" for below in ("x**2", "(1 + x**2)")]
    assert [decided([side, side.replace("x - 1", "y")], equilibrium=[1, 0]).reach.everywhere for side in sides] == [
        False,
        True,
    ]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("proper", "0"),
        ("proper", "-1"),
        ("proper", "1000"),
        ("growth", "1000"),
        ("proper", None),
        ("everywhere", False),
        ("function", "x**2"),
    ],
)
def test_forged_claims_are_rejected(key: str, value: object) -> None:
    certificate = certificate_of(decided(GLOBAL[0]))
    assert not refusal(certificate, SIZE)
    forged = deepcopy(certificate)
    entry = next(e for e in forged["evidence"] if "proper" in e["hypotheses"])
    entry["hypotheses"][key] = value
    assert refusal(forged, SIZE)


def test_a_square_is_not_the_space() -> None:
    """Cells of a square under a claim about the whole space."""
    certificate = certificate_of(decided(GLOBAL[0]))
    for entry in certificate["evidence"]:
        if "proper" in entry["hypotheses"]:
            entry["hypotheses"]["cells"]["within"] = "1/2"
    assert refusal(certificate, SIZE)


def test_samples_refute_beyond_the_cube() -> None:
    """``r r' = -r^2 + r^4/9`` is negative exactly where ``r < 3``: no sample of the unit cube refutes that V falls."""
    states = ["x", "y", "z"]
    square = "(x**2 + y**2 + z**2)"
    system = ns.System(states, [f"-{x} + {square}*{x}/9" for x in states]).system
    subject, _ = started(system)
    cells = stated_cells(system, None, ()).record
    hypotheses = stability_hypotheses(cells, square, ASYMPTOTICALLY_STABLE) | {"everywhere": True, "proper": "1/4"}
    with pytest.raises(NotShownError, match="a sample refutes"):
        SampledProofs().entry(subject, "lyapunov", hypotheses)


@pytest.mark.parametrize(("rhs", "rests"), [(["2 - x**2"], ["sqrt(2)"]), (["y", "2 - x**2 - y"], ["sqrt(2)", "0"])])
def test_irrational_points_attract_from_near(rhs: list[str], rests: list[str]) -> None:
    """Of them nothing is said about the whole space, of which no certificate in rational numbers can speak."""
    found = ns.System(["x", "y"][: len(rhs)], rhs, at=rests).check()
    assert (found.verdict, found.evidence.reach.everywhere) == ("asymptotically stable", False)


# ---- A V for the whole space is searched where that of the checked square says nothing about it.
#
# The truths are published: the sources stand beside the systems in :mod:`tests.proofs.literature`.

SEARCHED: dict[str, Any] = {
    "energy that falls weakly": ("y", "-x**3 - y"),
    "a quadratic form whose mixed terms cancel": ("-x - 3*x**2*y**3/2", "-y**3 + x**3*y**2/2"),
    "a cascade": ("-x + y**2", "-y"),
    "jet engine": ("-y - 3*x**2/2 - x**3/2", "3*x - y"),
    "Lorenz": ("10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3"),
    "arbitrary switching": [["-x + y**2", "-y"], ["-x - y**2", "-2*y"]],
}
LOCAL = {
    "a limit cycle": ("-y", "x - y + x**2*y"),
    "other places of rest": ("y", "-x + x**3 - y"),
    "all but a line": ("-x + x**2*y", "-y"),
}


def system(rhs: tuple[str, ...] | list[list[str]]) -> ns.System:
    first = rhs[0] if isinstance(rhs, list) else rhs
    return ns.System(["x", "y", "z"][: len(first)], rhs, radius="1/2")


@few(3)
@pytest.mark.parametrize("name", SEARCHED)
def test_every_start_arrives_by_a_searched_function(name: str) -> None:
    result = system(SEARCHED[name]).check()
    assert result.evidence.reach.everywhere
    _, claims = show_evidence(*parse(certificate_text(result.certificate()).encode()))
    assert {"attracts": "everywhere"} in claims


@pytest.mark.parametrize("name", LOCAL)
def test_not_every_start_is_said_to_arrive(name: str) -> None:
    result = system(LOCAL[name]).check()
    assert result.verdict == "asymptotically stable"
    assert not result.evidence.reach.everywhere


def test_a_sum_that_is_rounded_to_zero_is_not_proposed() -> None:
    """Beside a logarithm of some weight it was; a report of this system ended in an ExpressionError."""
    system = built(["y*z/3 - x", "-y - x*z", "1e6*x*y/3 - z"])
    assert all(str(function) for pair in logarithmic_functions(system) for function in pair)


def test_starts_far_away_arrive_in_floats() -> None:
    """Of the jet engine, by steps of Runge and Kutta that know nothing of V."""
    x = np.random.default_rng(0).uniform(-20, 20, (2, 200))

    def field(place: np.ndarray) -> np.ndarray:
        u, v = place
        return np.stack([-v - 3 * u**2 / 2 - u**3 / 2, 3 * u - v])

    for _ in range(8_000):
        step = 4e-3 / (1 + 0.05 * np.abs(x).max(axis=0) ** 2)
        x = midpoint(field, x, step)
    assert np.linalg.norm(x, axis=0).max() < 1e-2
