"""Proofs of periodic orbits and of centres, and what shows nothing of them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from flint import arb

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError
from nonsmooth.analysis.orbits.search import find_orbit
from nonsmooth.proofs.checker.statements import VERSION, refusal
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.centres import show_integral_of, show_reversible_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.orbits.ball_steps import Expansion, precision
from nonsmooth.proofs.orbits.orbit_proof import OrbitProof, prove_orbit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.piecewise_affine import DIGITS, Motion, arrival
from tests.thorough import few, keep, thorough

# ---- Proofs of periodic orbits, against closed forms at 40 digits and paths of random systems ----


def proved(rhs: Sequence[str], start: Sequence[float], until: float = 100.0) -> tuple[Orbit, OrbitProof]:
    system = ns.System(["x", "y"], rhs).system
    orbit = find_orbit(system_field(system, start), start, until)
    return orbit, prove_orbit(system, orbit)


def holds(ball: Any, value: Any) -> bool:
    """Whether a ball holds a number of 40 digits, up to the digits of that number."""
    text = mpmath.nstr(value, 35)
    return bool(arb(text, 1e-30).overlaps(ball))


def midpoint(ball: Any) -> float:
    return float(ball.mid())


def test_a_step_encloses_a_rotation() -> None:
    with precision():
        step = Expansion(lambda z: [z[1], -z[0]], [arb(1), arb(0)]).step(arb(1))
        x, y = step.at(step.span)
        assert x.overlaps(step.span.cos())
        assert y.overlaps(-step.span.sin())
        assert x.rad() < 1e-20


@thorough
def test_van_der_pol_is_proved() -> None:
    """Existence, period and attraction; digits as in the float test."""
    _, proof = proved(["y", "(1 - x**2)*y - x"], (0.5, 0.0), 60.0)
    assert proof.attracts is True
    assert proof.segment is not None
    assert proof.segment.into_itself
    assert holds(proof.period, mpmath.mpf("6.6632868593231301896996820305"))


@few(1)
@pytest.mark.parametrize("damping", ["1/10", "1/5"])
def test_a_repelling_orbit_is_proved_with_its_closed_form(damping: str) -> None:
    """Period 2 pi/w and multiplier exp(pi d/w), see the float test."""
    _, proof = proved(["y", f"-x + {damping}*y - {damping}*sign(y)"], (2.5, 0.0), 12.0)
    with mpmath.workdps(DIGITS):
        d = mpmath.mpf(1) / int(damping.removeprefix("1/"))
        w = mpmath.sqrt(1 - d * d / 4)
        period, multiplier = 2 * mpmath.pi / w, mpmath.exp(mpmath.pi * d / w)
    assert proof.attracts is False
    assert holds(proof.period, period)
    assert holds(proof.multiplier, multiplier)


def test_stick_slip_is_proved_with_its_closed_form() -> None:
    """As in the float test: the slip from (1, 1/2) is a linear focus; sticking lasts until x = 1 at speed 1/2."""
    system = load_system("stick-slip")
    proof = prove_orbit(system, find_orbit(system_field(system, (2.0, 0.0)), (2.0, 0.0), 100.0))
    with mpmath.workdps(DIGITS):
        third, half = mpmath.mpf(1) / 3, mpmath.mpf(1) / 2
        slip = Motion([[0, 1], [-1, third]], [0, 1 - third / 2])
        time, back = arrival(slip, mpmath.matrix([1, half]), (0, 1), half, 5)
        period = time + (1 - back[0]) * 2
    assert proof.attracts is True
    assert holds(proof.period, period)
    assert float(period) == pytest.approx(midpoint(proof.period), abs=1e-13)


@pytest.mark.parametrize(("below", "more"), keep(1, [("2 - x/4", 0), ("2 + Abs(y)", 4)]))
def test_a_denominator_slows_an_orbit_of_two_arcs(below: str, more: int) -> None:
    """The repelling orbit above, slower by a factor s: its period is the integral of s over the time of the other, and
    the multiplier does not see s.  Over both arcs x is 0 in the mean, and the integral of ``abs(y)`` is four times
    the largest x, from which half a turn about the focus at ``d`` comes to its opposite.
    """
    _, proof = proved([f"y/({below})", f"(-x + y/10 - sign(y)/10)/({below})"], (2.5, 0.0), 40.0)
    with mpmath.workdps(DIGITS):
        d = mpmath.mpf(1) / 10
        w = mpmath.sqrt(1 - d * d / 4)
        half = mpmath.exp(mpmath.pi * d / w / 2)
        largest = d * (half + 1) / (half - 1)
        assert proof.attracts is False
        assert holds(proof.period, 4 * mpmath.pi / w + more * largest)
        assert holds(proof.multiplier, half**2)


@thorough  # the test above has short orbits
@pytest.mark.parametrize(("below", "turn"), [("1", 2), ("1 + x**2", 3), ("3 + x + x**2", 7)])
def test_a_smooth_orbit_is_proved_with_its_closed_form(below: str, turn: int) -> None:
    """In polar coordinates r' = r (1 - r^2)/s, phi' = -1/s: the unit circle.  Its period is the integral of s over it,
    here a multiple of pi, and the multiplier exp(-4 pi) does not see s.
    """
    tops = ["y + x*(1 - x**2 - y**2)", "-x + y*(1 - x**2 - y**2)"]
    _, proof = proved([f"({top})/({below})" for top in tops], (0.9, 0.1), 60.0)
    assert proof.attracts is True
    with mpmath.workdps(DIGITS):
        assert holds(proof.period, turn * mpmath.pi)
        assert holds(proof.multiplier, mpmath.exp(-4 * mpmath.pi))


@thorough  # that slides: the built-in stick-slip; between quotients: test_a_denominator_slows_an_orbit_of_two_arcs
def test_an_orbit_that_slides_between_quotients_is_proved() -> None:
    """Friction that falls as one over the speed of slip: the field of the paths in floats keeps its denominator."""
    friction = "sign(y - 1/2)/(1 + Abs(y - 1/2)/3)"
    orbit, proof = proved(["y/(1 + x**2/9)", f"(-5/6 - x - {friction})/(1 + x**2/9)"], (2.0, 0.0))
    assert proof.attracts is True
    assert orbit.period == pytest.approx(midpoint(proof.period), rel=1e-9)


def test_a_denominator_that_is_not_positive_on_the_orbit_proves_nothing() -> None:
    """Forged: the program itself states no such system, its denominators are not zero at the checked point."""
    system = ns.System(["x", "y"], ["(y + x - x**3)/(1 + y**2)", "-x/(1 + y**2)"]).system
    orbit = find_orbit(system_field(system, (1.0, 0.1)), (1.0, 0.1), 60.0)
    denominators = (*system.rewriting.denominators, parse_piecewise("x + 1/2", ["x", "y"]))
    forged = replace(system, rewriting=replace(system.rewriting, denominators=denominators))
    proof = prove_orbit(forged, orbit)
    assert not proof.is_proved
    assert "surface" in proof.reason


def test_what_cannot_be_proved_is_left_open() -> None:
    _, neutral = proved(["sign(y)", "-sign(x)"], (0.5, 0.3), 20.0)
    assert not neutral.is_proved
    assert "one" in neutral.reason
    system = ns.System(["x", "y", "z"], ["y", "z", "-2*y - 2*z - sign(x)"]).system
    spatial = prove_orbit(system, find_orbit(system_field(system, (0.5, 0, 0)), (0.5, 0, 0), 100.0))
    assert not spatial.is_proved
    assert "two states" in spatial.reason


def random_system(seed: int) -> list[str]:
    """Two foci on either side of a line, one or both expanding, with a relay: many have an orbit."""
    rng = np.random.default_rng(seed)
    a, b = (int(v) for v in rng.integers(-3, 4, 2))
    c, d = (int(v) for v in rng.integers(1, 5, 2))
    return [
        f"y + {a}/20*x + {int(rng.integers(-2, 3))}/10*sign(x)",
        f"-x*{c}/2 + {b}/20*y - y*Abs(x)*{d}/40 + {int(rng.integers(-3, 4))}/10*sign(y)",
    ]


@few(1)
@pytest.mark.parametrize("seed", keep(8, range(60)))
def test_random_proofs_agree_with_paths(seed: int) -> None:
    """A start beside a proved orbit is nearer after a turn where it attracts, and farther where it repels; and the
    slope of the return map by two such starts lies by the enclosed one.
    """
    rhs = random_system(seed)
    try:
        orbit, proof = proved(rhs, (1.0, 0.3), 60.0)
    except OrbitError:
        return
    if not proof.is_proved:
        return
    assert holds(proof.period, mpmath.mpf(orbit.period)) or abs(midpoint(proof.period) - orbit.period) < 1e-9
    system = ns.System(["x", "y"], rhs)
    along = orbit.legs[0].motion(0.0, orbit.point)
    normal = np.array([-along[1], along[0]]) / math.hypot(*along)
    step, ends = 1e-5, []
    for sense in (1, -1):
        path = system.simulate((orbit.point + sense * step * normal).tolist(), 1.1 * orbit.period).trajectory
        low, high = 0.9 * orbit.period, 1.1 * orbit.period
        for _ in range(70):
            middle = (low + high) / 2
            beyond = along @ (np.array(path.at(middle)) - orbit.point) >= 0
            low, high = (low, middle) if beyond else (middle, high)
        ends.append(float(normal @ (np.array(path.at(high)) - orbit.point)))
    slope = (ends[0] - ends[1]) / (2 * step)
    assert (abs(slope) < 1) == proof.attracts
    assert slope == pytest.approx(midpoint(proof.multiplier), abs=1e-3)


# ---- Centres by a reflection that reverses time and by an integral of motion, and what shows nothing of them.

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


def certified(show: Callable[[SwitchedSystem], Entry], rhs: list[str]) -> Record:
    """A certificate by one theorem, which the checker accepts."""
    system = ns.System(["x", "y"], rhs, radius="1/2").system
    entry, claims = show(system)
    statement = {"subject": about(system), "claims": claims}
    record: Record = {"version": VERSION, "statement": statement, "evidence": [entry]}
    assert {"stability": "stable"} in claims
    assert not refusal(record, 10**5)
    return record


@pytest.fixture(scope="module")
def spring() -> Record:
    """A certificate by a reflection."""
    return certified(show_reversible_of, REVERSED["not conservative"])


@pytest.fixture(scope="module")
def axes() -> Record:
    """A certificate by an integral."""
    return certified(show_integral_of, KEPT["invariant axes"])


@pytest.mark.parametrize("name", REVERSED)
def test_reflections_are_found(name: str) -> None:
    assert shown(show_reversible_of, REVERSED[name])


@pytest.mark.parametrize("name", KEPT)
def test_integrating_factors_are_found(name: str) -> None:
    assert shown(show_integral_of, KEPT[name])


SHORT = [("irrational", "INTEGRAL"), ("a pendulum on a spring", "SYMMETRY")]
ENERGIES = {"conservative"}  # integrals that are polynomials: a V that is kept
CENTRES = [(name, "LYAPUNOV" if name in ENERGIES else "INTEGRAL") for name in KEPT]
CENTRES += [(name, "SYMMETRY") for name in REVERSED]


@pytest.mark.parametrize(("name", "method"), keep(2, [*SHORT, *(centre for centre in CENTRES if centre not in SHORT)]))
def test_centres_are_stable(name: str, method: str) -> None:
    result = decided({**REVERSED, **KEPT}[name])
    assert (result.verdict, result.method) == (Translation.STABLE, Method[method])
    assert ("keep V" if method == "LYAPUNOV" else "orbits near it are closed") in result.reason
    certificate = certificate_of(result)
    assert not refusal(certificate, len(json.dumps(certificate)))
    assert certificate["statement"]["claims"][0] == {"stability": "stable"}


def test_no_function_is_searched_of_centres_with_sines(monkeypatch: pytest.MonkeyPatch) -> None:
    """What they are between has none: three searches took half a minute before the reflection was tried."""
    monkeypatch.setattr("nonsmooth.proofs.systems.lyapunov_search.find_lyapunov", None)
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
    factors = [1 + a * x + b * y for a, b in (*lines, last)]
    terms = [c / line for c, line in zip(powers, factors, strict=True)]
    fields = [
        sympy.prod(factors) * sum(term * line.diff(state) for term, line in zip(terms, factors, strict=True)) * sign
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


@pytest.mark.parametrize(("key", "value"), [*FORGED, *(("mirror", value) for value in OF_A_REFLECTION)])
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
