"""Known and random systems in two to six states: truth, source, and what is said here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import DecayKind, plane_cells
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.proofs.systems.ray_moves import decide_equilibrium
from nonsmooth.reports.interface.system import System
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.floats import runge_kutta, spread, value, velocity
from tests.oracles.solver_questions import Questions, ask, read, with_z3
from tests.plain import built
from tests.proofs.conftest import Load
from tests.proofs.plain_ties import Oracle, Tie, contradictions, holds_zero, random_tie
from tests.proofs.system_families import Known as KnownPlanar
from tests.proofs.system_families import families
from tests.thorough import few, keep, thorough

# ---- Known systems in families -------------------------------------------------------------------

SLOW = {"relay, viscous 1/4", "damping at one side only"}
FAMILIES = sorted(families(), key=lambda known: known.name in SLOW)  # `make test` keeps the first


def system_of(known: KnownPlanar) -> SwitchedSystem:
    document = {"system": {"states": ["x", "y"], "rhs": list(known.rhs)}, "check": dict(known.check)}
    return build_system(document, known.name, Path("known.toml"))


@few(1)
@pytest.mark.parametrize("known", FAMILIES, ids=lambda known: known.name)
def test_systems_in_families(known: KnownPlanar) -> None:
    system = system_of(known)
    result = decide_system(system)
    assert str(result.verdict) == known.truth
    assert result.check()
    function = result.function
    if isinstance(function, PlaneFunction) and not (function.grows or function.is_given):
        radius = function.domain.radius or system.check.radius
        document = {"equilibrium": known.check.get("equilibrium", [0, 0]), "radius": str(radius)}
        smaller = build_system(
            {"system": {"states": ["x", "y"], "rhs": list(known.rhs)}, "check": document}, "again", Path("again.toml")
        )
        assert audit(smaller, function.text).verdict is AuditVerdict.VALID


def test_there_are_enough_families() -> None:
    assert len({known.name for known in FAMILIES}) == len(FAMILIES) >= 60


# ---- Systems in three to six states whose stability is known: truth, source, and what is said here.

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
    return built(known.rhs, known.parameters, known.states.split(), **known.check)


@pytest.mark.usefixtures("without_reach")
@few(5)
@pytest.mark.parametrize(
    "known", [*KNOWN, *(pytest.param(known, marks=thorough) for known in FURTHER)], ids=lambda known: known.source[:40]
)
def test_known_systems(known: Known) -> None:
    result = decide_system(build(known))
    assert result.verdict is (known.said or known.truth)
    assert result.check()


# ---- Loops with a layer of rectifiers: verdicts agree with paths of the same loop in floats ------

DAMPED = np.array([-2.0, -1.5])


def random_layer(seed: int, units: int, *, biased: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights and biases of the units, and weights of their sum, as decimals of two digits."""
    rng = np.random.default_rng(seed)
    inner, outer = np.round(rng.normal(size=(units, 2)), 2), np.round(rng.normal(size=(1, units)), 2)
    return inner, np.round(rng.normal(size=units) / 2, 2) * biased, outer[0]


def loop(inner: np.ndarray, biases: np.ndarray, outer: np.ndarray) -> SwitchedSystem:
    """``x'' = -2 x - 3/2 x' + sum w_k (relu(a_k x + b_k x' + c_k) - relu(c_k))``, which rests at the origin."""
    units = zip(inner, biases, outer, strict=True)
    terms = [f"({w:.2f})*(relu(({a:.2f})*x + ({b:.2f})*v + ({c:.2f})) - relu({c:.2f}))" for (a, b), c, w in units]
    rhs = ["v", " + ".join(["-2*x - 3*v/2", *terms])]
    return build_system({"system": {"states": ["x", "v"], "rhs": rhs}}, "t", Path("t.toml"))


def largest_end(
    inner: np.ndarray, biases: np.ndarray, outer: np.ndarray, *, size: float = 1e-3, until: float = 40.0
) -> float:
    """Where paths from a small circle end, over its radius, by a solver that steps over the kinks."""

    def field(t: float, x: np.ndarray) -> np.ndarray:
        layer = outer @ (np.maximum(inner @ x + biases, 0) - np.maximum(biases, 0))
        return np.array([x[1], DAMPED @ x + layer])

    def gone(t: float, x: np.ndarray) -> float:
        return float(np.hypot(*x) - 50 * size)

    stop: Any = gone
    stop.terminal = True
    ends = []
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        start = size * np.array([np.cos(angle), np.sin(angle)])
        found = solve_ivp(field, (0, until), start, "DOP853", rtol=1e-9, atol=1e-13, events=stop)
        ends.append(np.hypot(*found.y[:, -1]) / size)
    return max(ends)


@pytest.mark.usefixtures("reach_at_large")
@pytest.mark.parametrize("units", keep(1, [4, 16, 8]))
@pytest.mark.parametrize("seed", range(6))
def test_verdicts_agree_with_paths(seed: int, units: int) -> None:
    layer = random_layer(100 * units + seed, units, biased=bool(seed % 2))
    result = decide_system(loop(*layer))
    assert result.check()
    last = largest_end(*layer)
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        assert last < 0.5
    elif result.verdict is Translation.UNSTABLE:
        assert last > 2
    else:
        pytest.fail(f"{result.verdict}: {result.reason}")


# ---- Plain systems tied at the equilibrium: no verdict contradicts what the formulas do there as numbers.

ZERO = ("0", "0")


@pytest.mark.parametrize(
    "seeds", keep(1, [range(5), range(5, 100), *(range(k, k + 250) for k in range(10_000, 15_000, 250))])
)
def test_equilibria_of_tied_systems(load: Load, seeds: range) -> None:
    for k in seeds:
        tie = random_tie(k)
        found = decide_equilibrium(plane_cells(load(*tie.rhs)))
        assert found is not Equilibrium.UNDECIDED
        assert (found is Equilibrium.HOLDS) == Oracle(tie).rests_at_origin(), tie


@pytest.mark.parametrize(
    "seeds", keep(1, [[1000], range(1001, 1012), *(range(k, k + 30) for k in range(10_000, 10_300, 30))])
)
def test_verdicts_on_tied_systems(load: Load, seeds: Sequence[int]) -> None:
    for seed in seeds:
        tie = random_tie(seed)
        result = decide_system(load(*tie.rhs))
        assert result.check()
        assert contradictions(result, Oracle(tie)) == [], tie


# ---- the oracle itself, where the answer is plain ----------------------------------------------------


def test_the_oracle_sees_narrow_cells_and_only_real_ones() -> None:
    between = Tie(ZERO, (("(1)", "(y - x**2)*(y - 2*x**2)", ("1", "0")),))
    assert Oracle(between).rests_at_origin()  # 1 outside, -1 between the parabolas
    isolated = Tie(ZERO, (("(1)", "x**3 - x**2 - y**2", ("1", "0")),))
    assert not Oracle(isolated).rests_at_origin()
    far = Tie(ZERO, (("(1)", "y + x**2 + 1", ("1", "0")),))
    assert not Oracle(far).rests_at_origin()


@thorough  # the small one: test_the_oracle_sees_narrow_cells_and_only_real_ones
def test_the_oracle_finds_equilibria_and_paths_that_leave() -> None:
    line = Oracle(Tie(ZERO, (("(-1)", "y", ("0", "1")),)))
    assert line.rests_at(Fraction(1, 64), Fraction(0))
    assert not line.rests_at(Fraction(1, 64), Fraction(1, 64))
    assert line.equilibria_nearby()
    saddle = Oracle(Tie(("x", "-y"), ()))
    assert spread(saddle.velocity, 1e-5, 6000, 2e-3, 0.2)[0] > 1e3
    assert spread(Oracle(Tie(("-x", "-2*y"), ())).velocity, 1e-2, 3000, 2e-3, 0.2)[0] < 1.01


@pytest.mark.parametrize(
    ("vectors", "expected"),
    [([(1, 0)], False), ([(1, 0), (-2, 0)], True), ([(1, 0), (-1, 1), (-1, -1)], True), ([(1, 0), (0, 1)], False)],
)
def test_hulls_of_the_oracle(vectors: list[tuple[int, int]], expected: bool) -> None:
    assert holds_zero([(Fraction(a), Fraction(b)) for a, b in vectors]) is expected


# ---- The audit of a V beside Z3 on inequalities that are built from the formulas anew; more of it in
# tests/benchmarks.

RELAY, SKEW = ["y", "-3*sign(x) - 2*sign(y)"], ["y", "-2*sign(x + y) + x/2"]
CHAIN = ["-sgn(x) + y/2", "-sgn(y) + z/2", "-sgn(z) - x/2"]
DRAG = ["y", "-sign(x) - y*Abs(y)"]


def decrease(states: Sequence[str], rhs: Sequence[str], potential: str) -> Decrease:
    audited = audit(ns.System(list(states), list(rhs)).system, potential)
    assert audited.function is not None
    return audited.function.decrease


@pytest.mark.parametrize(
    ("states", "rhs", "potential", "truth"),
    [
        ("xy", RELAY, "Abs(x) - x**2/6 + x*y/6 + 2*y**2/7", Decrease.STRICT),
        ("xy", RELAY, "Abs(x) + x**2/6 - x*y/2 + 2*y**2/7", Decrease.REFUTED),
        pytest.param("xy", SKEW, "Abs(x + y) + x**2 + x*y/2 + y**2/2", Decrease.STRICT, marks=thorough),
        pytest.param("xy", SKEW, "Abs(x + y) - x**2 + x*y/2 + y**2/2", Decrease.REFUTED, marks=thorough),
        ("xy", DRAG, "Abs(x) + y**2/2", Decrease.WEAK),
        ("xyz", CHAIN, "Abs(x) + Abs(y) - Abs(z)/4", Decrease.REFUTED),
        pytest.param("xyz", CHAIN, "Abs(x) + Abs(y) + Abs(z)", Decrease.STRICT, marks=thorough),
    ],
)
def test_the_audit_agrees_with_z3(states: str, rhs: list[str], potential: str, truth: Decrease) -> None:
    assert decrease(states, rhs, potential) is truth
    stated = read(states, rhs, [0] * len(states), "1/2", potential)
    strict = ask(with_z3, list(Questions(stated)), 20)
    assert strict.said == ("proved" if truth is Decrease.STRICT else "refuted"), strict
    weak = ask(with_z3, list(Questions(stated, rises=">")), 20)
    assert weak.said == ("refuted" if truth is Decrease.REFUTED else "proved"), weak


# ---- Random systems in three to six states against eigenvalues, sliding eigenvalues and simulations

NAMES = "abcdef"
Matrix = NDArray[Any]


def linear(row: Matrix, names: str = NAMES) -> str:
    return " + ".join(f"({int(c)})*{name}/4" for c, name in zip(row, names, strict=False) if c) or "0"


def random_matrix(rng: np.random.Generator, count: int) -> Matrix:
    matrix = rng.integers(-6, 7, (count, count)) - int(rng.integers(0, 12)) * np.eye(count, dtype=int)
    return np.asarray(matrix)


def largest_real_part(matrix: Matrix) -> float:
    with mpmath.workdps(30):
        values = mpmath.eig(mpmath.matrix(matrix.tolist()), left=False, right=False)
        return float(max(mpmath.re(value) for value in values))


@few(1)
@pytest.mark.parametrize("seed", range(30))
def test_linear_systems_against_eigenvalues(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(2):
        count = int(rng.integers(3, 7))
        matrix = random_matrix(rng, count)
        result = decide_system(built([linear(row) for row in matrix], states=NAMES))
        truth = largest_real_part(matrix)
        assert result.check()
        if abs(truth) > 1e-9:
            assert result.verdict is (ATTRACTS if truth < 0 else LEAVES)
            assert result.reach.everywhere is (truth < 0)
        else:
            assert result.verdict in (STAYS, LEAVES)


def relay(rng: np.random.Generator) -> tuple[int, list[str], float | None]:
    """``x' = A x - b sgn(c x)`` with the largest real part along its sliding surface, infinite where it repels."""
    count = int(rng.integers(3, 6))
    matrix, b, c = random_matrix(rng, count), rng.integers(-3, 4, count), rng.integers(-2, 3, count)
    rhs = [f"{linear(row)} - ({int(push)})*sgn({linear(c)})" for row, push in zip(matrix, b, strict=True)]
    push = float(b @ c) / 4
    if not push:
        return count, rhs, None
    if push < 0:
        return count, rhs, np.inf
    along = matrix / 4 - np.outer(b, c / 4 @ matrix / 4) / push
    basis = np.linalg.svd(c[None, :].astype(float))[2][1:]
    return count, rhs, float(np.linalg.eigvals(basis @ along @ basis.T).real.max())


@few(1)
@pytest.mark.parametrize("seed", [3, *(k for k in range(12) if k != 3)])
def test_relays_against_their_sliding_motion(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    decided = 0
    for _ in range(2):
        _, rhs, slide = relay(rng)
        result = decide_system(built(rhs, states=NAMES))
        assert result.check()
        if slide is None or abs(slide) < 1e-6 or result.verdict is Translation.UNDECIDED:
            continue
        decided += 1
        assert result.verdict is (ATTRACTS if slide < 0 else LEAVES)
        if result.reach.region is not None and result.function is not None and decided == 1:
            _follow_inside(rhs, result, rng)
    assert decided >= 1


def _follow_inside(rhs: list[str], result: StabilityResult, rng: np.random.Generator) -> None:
    """A start of the certified region stays in it and comes nearer, as fast as the rate says."""
    assert result.function is not None
    assert result.reach.region is not None
    names, text = list(result.scene.states), result.function.text
    count, level = len(names), float(result.reach.region.level)

    def value(x: Matrix) -> float:
        return potential(text, names, x)

    direction = rng.normal(size=count)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if value(middle * direction) < 0.9 * level else (low, middle)
    start = low * direction
    path = System(names, rhs).simulate(start.tolist(), 10.0).trajectory
    values = np.array([value(np.asarray(place)) for place in path.states])
    times = np.array([float(time) for time in path.times])
    assert values[-1] < values[0]
    if result.reach.rate is None:
        bound = np.full(len(times), values[0])
    elif result.reach.rate.decay is DecayKind.EXPONENTIAL:
        bound = values[0] * np.exp(-float(result.reach.rate.kappa) * times)
    else:
        bound = np.maximum(values[0] - float(result.reach.rate.kappa) * times, 0)
    assert (values <= bound + 1e-6 * values[0]).all()


@pytest.mark.usefixtures("reach_at_large")
@few(2)
@pytest.mark.parametrize("seed", range(20))
def test_crossed_relays_against_small_steps(seed: int) -> None:
    """Two or three relays: solutions slide along lines and at the point; small steps tell where they go."""
    rng = np.random.default_rng(500 + seed)
    count = int(rng.integers(2, 4))
    a, b = rng.integers(-3, 4, (3, 3)), rng.integers(-1, 2, (3, count)) + 3 * np.eye(3, dtype=int)[:, :count]
    c = np.eye(3, dtype=int)[:count] if seed % 2 else rng.integers(-1, 2, (count, 3)) + np.eye(3, dtype=int)[:count]
    rhs = [
        linear(4 * row) + "".join(f" - ({int(push)})*sgn({linear(4 * c[j])})" for j, push in enumerate(pushes) if push)
        for row, pushes in zip(a, b, strict=True)
    ]
    result = decide_system(built(rhs, states=NAMES))
    assert result.check()
    x = rng.normal(size=(16, 3))
    x *= 0.02 / np.linalg.norm(x, axis=1)[:, None]
    for _ in range(15_000):
        x = np.clip(x + 8e-5 * (x @ a.T - np.sign(x @ c.T) @ b.T), -1, 1)
    sizes = np.linalg.norm(x, axis=1)
    assert result.verdict is not ATTRACTS or sizes.max() < 0.3
    assert result.verdict is not LEAVES or sizes.max() > 0.002


def growth_of_cones(a: Matrix, b: Matrix, rng: np.random.Generator) -> tuple[float, float]:
    """The least and largest exponent of ``x' = A x + B |x|`` from random starts."""
    x = rng.normal(size=(40, len(a)))
    total, step, steps = np.zeros(40), 0.01, 3000

    def field(x: Matrix) -> Matrix:
        return np.asarray(x @ a.T + np.abs(x) @ b.T)

    for k in range(steps):
        x = runge_kutta(field, x, step)
        size = np.linalg.norm(x, axis=1)
        total += np.log(size) * (k > steps // 4)
        x /= size[:, None]
    rates = total / (step * steps * 3 / 4)
    return float(rates.min()), float(rates.max())


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_cones_against_exponents(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    count = int(rng.integers(3, 5))
    a = random_matrix(rng, count)
    b = rng.integers(-3, 4, (count, count)) * (rng.random((count, count)) < 0.3)
    rhs = [
        linear(row) + "".join(f" + ({int(c)})*Abs({NAMES[j]})/4" for j, c in enumerate(bent) if c)
        for row, bent in zip(a, b, strict=True)
    ]
    result = decide_system(built(rhs, states=NAMES))
    low, high = growth_of_cones(a / 4, b / 4, rng)
    assert result.check()
    if result.verdict is ATTRACTS:
        assert high < 0.01
    if result.verdict is LEAVES:
        assert high > -0.01
    if low > 0.05:
        assert result.verdict in (LEAVES, Translation.UNDECIDED)


@pytest.mark.usefixtures("reach_at_large")
@few(1)
@pytest.mark.parametrize("seed", range(24))
def test_sectors_against_frozen_and_switching_gains(seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    for _ in range(2):
        count = int(rng.integers(3, 6))
        a, b, c = random_matrix(rng, count), rng.integers(-3, 4, count), rng.integers(-2, 3, count)
        ends = [a, a + 4 * np.outer(b, c)]
        result = decide_system(built([[linear(row) for row in end] for end in ends], states=NAMES))
        assert result.check()
        gains = [largest_real_part(a + 4 * g * np.outer(b, c)) for g in np.linspace(0, 1, 6)]
        if result.verdict is ATTRACTS:
            assert max(gains) < 0
            x = rng.normal(size=count)
            first = np.linalg.norm(x)
            for _ in range(4000):
                x = x + 0.01 * (ends[int(rng.integers(0, 2))] / 4) @ x
            assert np.linalg.norm(x) < first
        if result.verdict is LEAVES:
            assert max(gains) > 0


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize("seed", range(2, 26))
def test_mutated_functions_are_refused_or_still_true(seed: int) -> None:
    rng = np.random.default_rng(400 + seed)
    count, rhs, _ = relay(rng)
    system = built(rhs, states=NAMES)
    result = decide_system(system)
    if result.verdict is not ATTRACTS or result.function is None:
        return
    names = list(NAMES[:count])
    first, second = rng.choice(names, 2)
    text = f"{result.function.text} + ({int(rng.integers(-8, 9))})*{first}*{second}/8"
    if audit(system, text).verdict is not AuditVerdict.VALID:
        return
    radius = float(system.check.radius)
    for x in rng.uniform(-radius, radius, (200, count)):
        assert potential(text, names, x) > 0
        assert potential_rate(text, rhs, names, x) < 1e-9


def potential(text: str, names: list[str], x: Matrix) -> float:
    return float(value(text, **dict(zip(names, x, strict=True))))


def potential_rate(text: str, rhs: list[str], names: list[str], x: Matrix) -> float:
    """V' at a point off the surfaces, by central differences."""
    field, step = velocity(rhs, x, names), 1e-7
    return (potential(text, names, x + step * field) - potential(text, names, x - step * field)) / (2 * step)
