"""Centre manifolds and polynomials that are kept: published reductions, verdicts against paths, certificates."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
import sympy
import sympy as sp
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel_strategies import decide_by_center_manifold
from nonsmooth.proofs.many_states.center_manifold import Leading, Reduction, show_by_center_manifold, split_at
from nonsmooth.proofs.many_states.weak_functions import find_kept_function
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, checked_point, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import contradiction
from tests.thorough import but, few, keep

# ---- Centre manifolds: published reductions and quantities, verdicts against integrated paths, certificates.

STATES = ("x", "y", "z", "w")
NEAR, FAR, UNTIL = 0.06, 0.15, 100_000.0


def decided(rhs: Sequence[str]) -> StabilityResult:
    return decided_once(tuple(rhs))


@cache
def decided_once(rhs: tuple[str, ...]) -> StabilityResult:
    return decide_system(ns.System(list(STATES[: len(rhs)]), list(rhs)).system)


def leading(rhs: Sequence[str]) -> Leading:
    names = sp.symbols(STATES[: len(rhs)])
    polynomials = [sp.Poly(sp.sympify(text), *names) for text in rhs]
    field = [
        Polynomial(len(rhs), {e: Fraction(int(c.p), int(c.q)) for e, c in polynomial.terms()})
        for polynomial in polynomials
    ]
    split = split_at(field)
    assert split is not None
    reduced = Reduction(split, field)
    found = reduced.line() if split.size == 1 else reduced.circle()
    assert found is not None
    return found


# ---- the reduced field ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_carrs_example(seed: int) -> None:
    """``x' = x y + a x^3 + b x y^2, y' = -y + c x^2 + d x^2 y`` reduces to ``(a + c) x^3 + ...`` (Carr 1981, 1.3)."""
    a, b, c, d = map(int, np.random.default_rng(seed).integers(-4, 5, size=4))
    if a + c == 0:  # then the fifth order decides, as below
        c += 1
    found = leading([f"x*y + {a}*x**3 + {b}*x*y**2", f"-y + {c}*x**2 + {d}*x**2*y"])
    assert found.factor == a + c
    assert found.weight == 4


def test_carrs_example_to_the_fifth_order() -> None:
    found = leading(["x*y - 2*x**3 + 3*x*y**2", "-y + 2*x**2 + 5*x**2*y"])
    assert found.factor == 2 * 5 + 3 * 4
    assert found.weight == 6


@pytest.mark.parametrize("seed", range(4))
def test_the_first_quantity_of_a_planar_focus(seed: int) -> None:
    """``x' = -w y + f, y' = w x + g`` has ``r' = l r^3 + ...`` (Guckenheimer and Holmes 1983, (3.4.11))."""
    x, y = sp.symbols("x y")
    source = np.random.default_rng(seed)
    powers = [(i, j) for i in range(4) for j in range(4) if 2 <= i + j <= 3]
    f, g = (sp.Integer(0) + sum(int(source.integers(-3, 4)) * x**i * y**j for i, j in powers) for _ in range(2))
    w = int(source.integers(1, 4))

    def at(value: sp.Expr, *by: sp.Symbol) -> sp.Expr:
        return sp.diff(value, *by).subs({x: 0, y: 0})

    cubic = at(f, x, x, x) + at(f, x, y, y) + at(g, x, x, y) + at(g, y, y, y)
    mixed = at(f, x, y) * (at(f, x, x) + at(f, y, y)) - at(g, x, y) * (at(g, x, x) + at(g, y, y))
    mixed += -at(f, x, x) * at(g, x, x) + at(f, y, y) * at(g, y, y)
    published = cubic / 16 + mixed / (16 * sp.Integer(w))
    found = leading([str(-w * y + f), str(w * x + g)])
    assert found.factor == Fraction(str(2 * published))  # W = r^2 + ... has W' = 2 l W^2 + ...


@pytest.mark.parametrize("power", range(1, 5))
def test_the_next_quantities_of_a_planar_focus(power: int) -> None:
    """``x'' = -x - x^2k x'`` has ``(r^2)' = -2 r^(2k+2) cos^2k sin^2 + ...``, whose mean counts in all coordinates."""
    mean = Fraction(int(sp.binomial(2 * power, power)), 4**power * (2 * power + 2))
    assert leading(["y", f"-x - x**{2 * power}*y"]).factor == -2 * mean
    x, y = "(x + x**2)", "(y - x**2)"  # what x and y are in other coordinates; times 1 + 2 x, fields are polynomials
    bent = leading([y, f"(-{x} - {x}**{2 * power}*{y})*(1 + 2*x) + 2*x*{y}"])
    assert bent.factor == -2 * mean


# ---- verdicts ------------------------------------------------------------------------------------

REPELS = [
    ["x*z", "-y", "-z + x**2"],
    ["x*y", "-y + x**2"],
    ["x**2", "-y"],
    ["x**3", "-y + x*y"],
    ["x*y + x**2*y", "-y + x**4 + x*y"],
    ["x**2 - y*z", "-y + x*z", "-3*z + y + x**2"],
    ["-y + x*z", "x + y*z", "-z + x**2 + y**2"],
    ["x + y - 3*x**2 + 2*x*y + 4*y**2 + x**3", "-2*x - y - x**2 - 3*x*y - 4*y**2 - 2*y**3"],  # near the point alone
]
LORENZ = ["10*(y - x)", "x*(1 - z) - y", "x*y - 8/3*z"]  # where the origin branches
ATTRACTS = [
    ["y", "-x - x**4*y + x**2"],
    ["2*y - x - x**3", "x - 2*y"],  # subspaces that are no axes
    ["-y + x*z", "x + y*z", "-z - 2*x**2 - y**2 + x**3"],
    ["-x + y**2", "-y**3"],
    ["-x*y + z*x**2", "-y + x**4", "-2*z - y + x**3"],
    LORENZ,
]


def ends(rhs: Sequence[str], start: Sequence[float], until: float = UNTIL) -> float:
    """How far a solution is in the end, or when it is far, over its distance at the start."""
    names = sp.symbols(STATES[: len(rhs)])
    field = sp.lambdify([names], [sp.sympify(text) for text in rhs])

    def far(_: float, place: np.ndarray) -> float:
        return float(np.hypot.reduce(place) - FAR)

    far.terminal = True  # type: ignore[attr-defined]
    solved = solve_ivp(lambda _, place: field(place), (0, until), start, "LSODA", rtol=1e-9, atol=1e-12, events=far)
    return float(np.linalg.norm(solved.y[:, -1]) / np.linalg.norm(start))


@few(3)
@pytest.mark.parametrize("rhs", REPELS, ids="; ".join)
def test_points_that_repel_in_the_centre_manifold(rhs: list[str]) -> None:
    assert verdict_beside(rhs) is Translation.UNSTABLE
    start = [NEAR, *[0.0] * (len(rhs) - 1)]
    assert ends(rhs, start) * NEAR >= 0.99 * FAR


@few(3)
@pytest.mark.parametrize("rhs", keep(5, REPELS), ids="; ".join)
def test_points_that_repel(rhs: list[str]) -> None:
    result = decided(rhs)
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.CENTER)
    assert result.check()


def verdict_beside(rhs: Sequence[str]) -> Translation | None:
    """What the centre manifold alone says."""
    point = checked_point(ns.System(list(STATES[: len(rhs)]), list(rhs)).system)
    found = decide_by_center_manifold(point)
    return None if found is None else found.verdict


@pytest.mark.parametrize("rhs", keep(4, ATTRACTS), ids="; ".join)
def test_points_that_attract_in_the_centre_manifold(rhs: list[str]) -> None:
    assert verdict_beside(rhs) is Translation.ASYMPTOTICALLY_STABLE


@pytest.mark.parametrize("rhs", keep(1, ATTRACTS[1:]), ids="; ".join)
def test_points_that_attract(rhs: list[str]) -> None:
    """Of Lorenz's system an energy is found before."""
    result, method = decided(rhs), Method.INVARIANCE if rhs == LORENZ else Method.CENTER
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, method)
    assert result.check()
    assert ends(rhs, [FAR / 2] * len(rhs), 4000.0) < 0.95


@pytest.mark.parametrize("rhs", keep(1, [["-x*y", "-y + x**2"], ATTRACTS[0], ATTRACTS[3]]), ids="; ".join)
def test_a_level_is_named_where_v_falls_in_the_states_themselves(rhs: list[str]) -> None:
    assert decided(rhs).reach.near is not None


@pytest.mark.parametrize(
    "rhs",
    [
        ["x*y", "-y"],  # a line of rest
        ["-y + y*z", "x - x*z", "-z"],  # circles
        ["y + x**2", "-x**2"],  # a double eigenvalue
        ["y", "-x**3", "-z"],  # another one
    ],
    ids="; ".join,
)
def test_nothing_is_said_of_others(rhs: list[str]) -> None:
    assert verdict_beside(rhs) is None


@pytest.mark.parametrize("rhs", [REPELS[0], ATTRACTS[1]], ids="; ".join)
def test_certificates_obey_their_inclusion(rhs: list[str]) -> None:
    certificate = certificate_of(decided(rhs))
    assert not contradiction(certificate["statement"])


BENT = {  # manifolds y = x^2 + ... beside u' = a u^m, m > 4
    "-x*y**2; -y + x**2": Translation.ASYMPTOTICALLY_STABLE,
    "x*y**2; -y + x**2": Translation.UNSTABLE,
    "-x**7; -y + x**2": Translation.ASYMPTOTICALLY_STABLE,
    "-x*y**2 + x**5; -y + x**2 + x**3": Translation.UNSTABLE,
    "-x*y**2; -y + z + x**2; -z + x**3": Translation.ASYMPTOTICALLY_STABLE,
}


@few(1)
@pytest.mark.parametrize("rhs", but([list(BENT)[-1]], BENT))  # the semidefinite programs of three states take 15 s
def test_manifolds_that_bend_beside_slow_fields(rhs: str) -> None:
    """V' is of lowest weight along the manifold: no squares of the states show that it falls there."""
    result, fields = decided(rhs.split("; ")), rhs.split("; ")
    assert (result.verdict, result.method) == (BENT[rhs], Method.CENTER)
    certificate = certificate_of(result)
    assert "coordinates" in certificate["evidence"][0]["hypotheses"]["cells"]
    assert not contradiction(certificate["statement"])
    starts = [[side * 0.1, *[0.01] * (len(fields) - 1)] for side in (1, -1)]
    far = max(ends(fields, start) for start in starts)
    assert far < 0.95 if result.verdict is Translation.ASYMPTOTICALLY_STABLE else far > 1.4


def test_no_patterns_are_searched_where_fields_differ_near_the_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """It took minutes beside four curves of degree 6, with nothing that could be found."""
    monkeypatch.setattr("nonsmooth.proofs.many_states.center_manifold.sharpened", None)
    system = ns.System(list("xy"), ["-x + sign(x**6 + y**5 - 2*x*y/7 + x**2*y)", "-2*y"]).system
    assert show_by_center_manifold(system) is None


def test_fields_of_high_degree_are_cut_before_they_are_multiplied() -> None:
    """With the denominator the field has degree 7, and the manifold is asked up to that degree, too."""
    system = ns.System(["x", "y"], ["y", "-x**3 - 3*y/(1 + x**4)"]).system
    assert show_by_center_manifold(system) is not None


# ---- Points that are stable because a polynomial is kept: textbook systems, certificates, and points that are not.

CONSERVED_STATES = ("x", "y", "u", "v")
RIGID = ["y*u", "-2*x*u", "x*y"]
KEPT: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "rigid body about its long axis": (RIGID, "100"),
    "rigid body about its short axis": (RIGID, "001"),
    "Henon and Heiles": (["u", "v", "-x - 2*x*y", "-y - x**2 + y**2"], "0000"),
    "cubic springs": (["u", "v", "-x**3 - (x - y)**3", "-y**3 - (y - x)**3"], "0000"),
    "three species": (["x*(y - u)", "y*(u - x)", "u*(x - y)"], "111"),
    "linear": (["y", "-x", "v", "-2*u"], "0000"),
}


def system(rhs: Sequence[str], at: Sequence[str]) -> SwitchedSystem:
    return ns.System(list(CONSERVED_STATES[: len(rhs)]), list(rhs), at=tuple(at)).system


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
    integral = find_kept_function(system(rhs, at))
    assert integral is not None
    x, y, u = states = sympy.symbols("x y u")
    potential = sympy.sympify(integral.formula.text).subs(dict(zip(states, (x - 1, y - 1, u - 1), strict=True)))
    rate = sum(potential.diff(state) * sympy.sympify(field) for state, field in zip(states, rhs, strict=True))
    assert sympy.expand(rate) == 0
    hessian = np.array(sympy.hessian(potential, states).subs(dict.fromkeys(states, 1)), dtype=float)
    assert np.linalg.eigvalsh(hessian).min() > 0


def test_the_energy_of_springs_without_a_linear_part_is_kept() -> None:
    integral = find_kept_function(system(*KEPT["cubic springs"]))
    assert integral is not None
    x, y, u, v = sympy.symbols("x y u v")
    energy = u**2 / 2 + v**2 / 2 + (x**4 + y**4 + (x - y) ** 4) / 4
    assert sympy.simplify(sympy.sympify(integral.formula.text) / energy).is_constant()


@few(3)
@pytest.mark.parametrize(
    ("rhs", "at"),
    [
        (RIGID, "010"),  # the middle axis
        (["u", "v", "-x**3 + (x - y)**3", "-y**3 - (x - y)**3"], "0000"),  # a spring that pushes apart
        (["u", "v", "-x - 2*x*y", "-y - x**2 + y**2 - v**3"], "0000"),  # damped
        (["u", "v", "-x", "y"], "0000"),  # an integral of both signs
        (["-x", "-y", "-u"], "000"),
    ],
)
def test_nothing_is_found_of_others(rhs: Sequence[str], at: str) -> None:
    assert find_kept_function(system(rhs, at)) is None
