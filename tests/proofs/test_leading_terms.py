"""Leading terms of plain systems: against formulas, quadrature and integrators that share no code with them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.tangents import form_lines, lowest_form
from nonsmooth.proofs.systems.full_turns import FusedFocus, TurnGrowth
from nonsmooth.proofs.systems.leading_terms import decide_leading_terms
from nonsmooth.proofs.systems.ray_moves import build_tangent_fan
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE
from tests.proofs.conftest import Load
from tests.proofs.switched_oracle import Judge, Switched, leaves, random_conewise, random_relay
from tests.thorough import few, keep

COUNT = 40
PATHS = 6


@few(1)
@pytest.mark.parametrize("generate", [random_relay, random_conewise])
@pytest.mark.parametrize("count", keep(1, [16, COUNT]))
def test_random_systems_against_formulas(load: Load, generate: Callable[[int], Switched], count: int) -> None:
    seen: Counter[tuple[str, str]] = Counter()
    for seed in range(1000, 1000 + count):
        system = generate(seed)
        found = decide_leading_terms(load(*system.rhs))
        known = Judge(system).verdict()
        seen[str(found and found.verdict), str(known)] += 1
        assert found is None or known is None or str(found.verdict) == known, (seed, system.rhs)
    assert min(seen[v, v] for v in ("asymptotically stable", "unstable")) >= count // 8
    assert sum(n for (found, _), n in seen.items() if found == "None") <= count // 10


@few(1)
@pytest.mark.parametrize("generate", [random_relay, random_conewise])
def test_random_systems_against_paths(load: Load, generate: Callable[[int], Switched]) -> None:
    for seed in range(2000, 2000 + PATHS):
        system = generate(seed)
        found = decide_leading_terms(load(*system.rhs))
        if found is not None and found.verdict is Translation.ASYMPTOTICALLY_STABLE:
            assert not leaves(system)


# ---- by hand -------------------------------------------------------------------------------------


def test_bounds_with_the_same_digits_are_said_once() -> None:
    assert str(TurnGrowth(1, "2", "2", 1)).endswith("by a factor of 2, rounded")
    assert str(TurnGrowth(1, "2", "3", 1)).endswith("by a factor between 2 and 3")


def test_the_reason_names_the_states(load: Load) -> None:
    found = decide_leading_terms(load("y", "-2*sign(x) - sign(y)"))
    assert found is not None
    assert found.reason(("p", "v")).endswith("with weights 2 and 1 of p and v")


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ("y", "-2*sign(x) - sign(y)", "asymptotically stable"),  # weights 2 and 1
        ("y", "-2*sign(x) + sign(y)", "unstable"),
        ("y", "-sign(x) - 2*sign(y)", None),  # rests on the x axis
        ("y", "-2*sign(x)", None),  # closed orbits
        ("-sign(x) + y", "-y", "asymptotically stable"),  # slides home slowly
        ("-sign(x) + y", "y", "unstable"),
        ("-sign(x) + y", "0", None),
        ("-sign(x)", "y**3 - y**2*sign(x)", "unstable"),  # the first term of the slide is cubic
        ("-sign(x)", "-y**3", "asymptotically stable"),
        ("x", "-y", "unstable"),
        ("x**3", "-y", None),  # of no one degree
        ("-x**3 - y**3", "x**3 - y**3", "asymptotically stable"),
        ("x**3", "y**3", "unstable"),
        ("y", "-x**3 - y**3", None),
        ("y", "-x - y*sign(y + x**2 + 1)", "asymptotically stable"),  # the parabola is far away
        ("-x + 4*y*(1 - sign(y*(y - x**2)))", "-y", None),  # a thin cell along the x axis
        ("-x*(1 - 4*(1 - sign(y**2 - x**3)))", "-y", None),  # a thin cell inside a cusp: along it solutions leave
        ("-y + x*sign(x + y)", "x + y*sign(x + y)", None),  # grows and falls by the same factor
        ("sign(y) - x", "-sign(x)*3/2 - y", None),  # gain one to leading order
    ],
)
def test_verdicts(load: Load, first: str, second: str, expected: str | None) -> None:
    found = decide_leading_terms(load(first, second))
    assert (None if found is None else str(found.verdict)) == expected


def test_growth_of_a_linear_focus_in_closed_form(load: Load) -> None:
    """x'' + x' + x = 0 turns once in 4 pi / sqrt(3) and falls by exp(-2 pi / sqrt(3))."""
    found = decide_leading_terms(load("y", "-x - y"))
    assert found is not None
    assert isinstance(found.growth, TurnGrowth)
    exact = np.exp(-2 * np.pi / np.sqrt(3))
    assert float(found.growth.low) == pytest.approx(exact, rel=1e-6)
    assert float(found.growth.high) == pytest.approx(exact, rel=1e-6)


def first_return(fields: Sequence[Callable[[float, np.ndarray], list[float]]], start: float) -> float:
    """The second crossing of x = 0 by an integrator, from (0, start)."""
    place = start
    for rate in fields:

        def crossing(_: float, state: np.ndarray) -> float:
            return float(state[0])

        crossing.terminal = True  # type: ignore[attr-defined]
        begin = np.array([0.0, place]) + 1e-11 * np.array(rate(0.0, np.array([0.0, place])))
        path = solve_ivp(rate, (0, 10), begin, events=crossing, rtol=1e-13, atol=1e-20, max_step=3e-3 * abs(place))
        place = float(path.y_events[0][0][1])
    return place


@few(1)
@pytest.mark.parametrize("seed", range(3))
def test_fused_focus_against_an_integrator(load: Load, seed: int) -> None:
    rng = np.random.default_rng(seed)
    sides = [
        (*rng.integers(1, 4, size=2).tolist(), *rng.integers(-3, 4, size=4).tolist()) for _ in range(2)
    ]  # a, c, b, d, q, e

    def mixed(right: str, left: str) -> str:
        return f"(({right})*(1 + sign(x)) + ({left})*(1 - sign(x)))/2"

    xs = [f"{a}*y + ({b})*x + ({q})*y**2" for a, _, b, _, q, _ in sides]
    ys = [f"{-s * c} + ({d})*y + ({e})*x" for s, (_, c, _, d, _, e) in zip((1, -1), sides, strict=True)]
    found = decide_leading_terms(load(mixed(*xs), mixed(*ys)))
    fields = [
        lambda _, z, side=side, s=s: [
            side[0] * z[1] + side[2] * z[0] + side[4] * z[1] ** 2,
            -s * side[1] + side[3] * z[1] + side[5] * z[0],
        ]
        for s, side in zip((1, -1), sides, strict=True)
    ]
    start = 1e-4
    measured = (first_return(fields, start) - start) / start**2
    assert found is not None
    assert isinstance(found.growth, FusedFocus)
    assert float(found.growth.coefficient) == pytest.approx(measured, abs=0.01)


# ---- parts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "lines"),
    [("x*y", {"x", "y"}), ("y**2 - 2*x**2", {"x - sqrt(2)/2*y", "x + sqrt(2)/2*y"}), ("x**2 + y**2", set()),
     ("(x - y)**2*x", {"x - y", "x"}), ("x**4 + y**4", set()), ("x**3 - 2*y**3", None)],
)  # fmt: skip
def test_lines_of_forms(text: str, lines: set[str] | None) -> None:
    field = NumberField()
    values = {name: Polynomial.variable(field, PLANE, name) for name in PLANE}
    form = parse_piecewise(text, PLANE).polynomial(values, lambda _: 1)
    found = form_lines(lowest_form(form))
    assert (None if found is None else {str(line) for line in found}) == lines


def test_cones_of_curves_are_those_of_their_tangents(load: Load) -> None:
    fan = build_tangent_fan(load("-sign(y - x - x**2)", "-y*sign(x - 5)"))
    assert fan is not None
    assert fan.degree == 0
    touched = [cone.start for cone, surfaces in zip(fan.cones, fan.surfaces, strict=True) if surfaces]
    assert all(x == y for x, y in touched)
    assert len(touched) == 2
