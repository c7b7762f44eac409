"""Systems by parts, and cells between curves that are empty or thin."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.switched_cells import square_regions
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.curved_regions import is_empty
from nonsmooth.proofs.kernel_strategies import decide_by_symmetry
from nonsmooth.proofs.parts import Parts, cascade, slides
from nonsmooth.proofs.system_certificates import by_parts, certificate_of
from nonsmooth.proofs.system_decision import (
    StabilityResult,
    checked_point,
    decide_by_cascade,
    decide_by_sliding,
    decide_system,
)
from nonsmooth.proofs.systems.findings import CheckedPoint, Finding, Method, Reach
from nonsmooth.proofs.systems.system_stability import PlanePoint, decide_by_stated_function
from nonsmooth.reports.exchange.obligations import obligations_of
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem
from tests.certificates.inclusion import contradiction
from tests.oracles.floats import value
from tests.plain import built
from tests.thorough import but, few, keep

# ---- Cascades, and surfaces on which solutions slide: systems that are decided by some of their states.

Decide: TypeAlias = Callable[[CheckedPoint], Finding | None]

ATTRACTS, RESTS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE

# What is driven rests, and what drives it dies out exponentially or in finite time: a curve of equilibria attracts.
CARRIED = {
    "a rectified oscillation is added up": ["Abs(y)", "z", "-y - z"],
    "a relay is added up": ["y", "z", "-sign(z + sign(y)) - z"],
    "an enclosed function is added up": ["y", "z", "-y - tanh(z)"],
    "rates that die out": ["x*z", "y*z", "-z"],
    "dry friction, pushed": ["y", "-x - sign(y) + z", "-2*sign(z)"],
    "a spring of second degree, pushed": ["y", "-x*Abs(x) + z", "-z"],
}

SUPER_TWISTING = ["y - 3/2*sqrt(Abs(x))*sign(x)", "-11/10*sign(x)"]

# No polynomial V is known for these; what the states do one after the other is by hand.
CASCADES = {
    "a cube drives a cube": (["-x**3", "-y**3 + x"], None, ATTRACTS),
    "elsewhere": (["-(x - 1)**3", "-(y + 2)**3 + x - 1"], [1, -2], ATTRACTS),
    "rotation drives": (["y", "-x", "-z**3 + x*z + x*y"], None, RESTS),
    "a sine of what drives": (["-x**3", "-y**3 + sin(x)"], None, ATTRACTS),
    **{name: (rhs, None, RESTS) for name, rhs in CARRIED.items()},
    "super-twisting drives a cube": ([*SUPER_TWISTING, "-z**3 + sqrt(Abs(x))"], None, ATTRACTS),
    "super-twisting drives what leaves": ([*SUPER_TWISTING, "z + sqrt(Abs(x))"], None, LEAVES),
    "roots of unlike orders": (["-sqrt(Abs(x))*sign(x)", "-Abs(y)**(2/3)*sign(y) + Abs(x)**(1/4)"], None, ATTRACTS),
    "roots elsewhere": (["-sqrt(Abs(x))*sign(x)", "2 - y + Abs(x)**(1/3) - sign(y - 2)"], [0, 2], ATTRACTS),
    "stable ones drive what leaves": (["y", "-x", "z**3 + x"], None, LEAVES),
    "sliding modes on what an observer says": ([*SUPER_TWISTING, "-z - sign(z + y)"], None, ATTRACTS),
    "and on roots of it": ([*SUPER_TWISTING, "-z - sign(z + sqrt(Abs(x))*sign(x) - Abs(y))"], None, ATTRACTS),
    "and on what is saturated": (["-(x - 2)**3", "1 - y - sign(y - 1 - sat(x - 2, -1, 3))"], [2, 1], ATTRACTS),
    "a relay that is pushed away": (["-x**3", "y**3 + sign(y + x)"], None, LEAVES),
    "two relays beside a cube": (
        ["-x**3", "-2*sign(y + x) - sign(z - x)", "sign(y + x) - sign(z - x)"],
        None,
        ATTRACTS,
    ),
    "a relay drives a relay, elsewhere": (["-(x - 1)**3", "1 - x - 2*sign(y + x - 1)"], [1, 0], ATTRACTS),
    "what rests by itself drives what leaves": (
        ["-sqrt(Abs(x))*sign(x)", "Abs(x)**(1/3)", "z**3 + y"],
        None,
        LEAVES,
    ),
}
SLIDES = {
    "zero dynamics of third degree": (["y", "z", "-sign(x**3 + y + z)"], None, ATTRACTS),
    "drifts along the plane": (["y", "z", "-x - 2*y - 2*z - sign(z)/2"], None, LEAVES),
    "unstable zero dynamics": (["y", "z", "w", "-sign(-x + 3*y + 3*z + w) + x*y"], None, LEAVES),
    "slides, then a cascade": (["-sign(x)", "-y**3 + x", "-z**5 + y*z + x"], None, ATTRACTS),
    "elsewhere": (["y - 1", "z + 2", "-sign((x - 3)**3 + y + z + 1)"], [3, 1, -2], ATTRACTS),
}


def system(rhs: list[str], at: list[int] | None = None) -> SwitchedSystem:
    return ns.System(list("xyzw")[: len(rhs)], rhs, at=at).system


@pytest.mark.parametrize("name", but(["a spring of second degree, pushed", "a relay is added up"], CASCADES))
def test_states_that_drive_others(name: str) -> None:
    require_shown(decide_by_cascade, CASCADES[name], Method.CASCADE)


@pytest.mark.parametrize("names", ["xy", "pq", "ba", "zu", "vw", "kl", "st", "qa"])
def test_blocks_of_one_size_stand_in_the_order_of_the_states(names: str) -> None:
    """A set of texts has another order in another process, and so had reasons and certificates."""
    blocks = cascade(ns.System(list(names), [f"-{name}" for name in names]).system)
    assert [block.system.stated_states for block in blocks] == [(name,) for name in names]


def test_motion_along_a_surface_is_told_without_the_zeros_of_the_state_that_it_gives() -> None:
    """They stood there as ``y' = -y**3 + 0``."""
    rhs = ["-sign(x)", "-y**3 + x", "x - z**5 + y*z - x"]
    (surface,) = slides(ns.System(list("xyz"), rhs).system)
    assert surface.words == "x = 0 and slide there, where y' = -y**3, z' = -z**5 + y*z"


@few(3)
@pytest.mark.parametrize("name", SLIDES)
def test_surfaces_on_which_solutions_slide(name: str) -> None:
    require_shown(decide_by_sliding, SLIDES[name], Method.SLIDING)


def require_shown(decide: Decide, case: tuple[list[str], list[int] | None, Translation], method: Method) -> None:
    """One of the two theorems decides by itself, with a certificate."""
    rhs, at, truth = case
    point = checked_point(system(rhs, at))
    found = decide(point)
    assert found is not None
    assert (found.verdict, found.theorem) == (truth, method)
    assert {"stability": str(truth)} in certificate_of(decided_by(point, found))["statement"]["claims"]


def test_a_part_is_carried_by_its_function_though_its_orbits_are_known_to_close() -> None:
    spring = PlanePoint(built(["y", "-x*Abs(x)"], lyapunov="y**2/2 + x**2*Abs(x)/3"))
    weak, closed = decide_by_stated_function(spring), decide_by_symmetry(spring)
    assert weak is not None
    assert closed is not None
    findings = weak, closed
    rests = StabilityResult(spring.system, spring.equilibrium, findings, None, Reach())
    drives = decide_system(built(["-z"], states="z"))
    whole = read_subject({"states": list("xyz"), "rhs": [["y", "-x*Abs(x) + z", "-z"]], "at": ["0"] * 3})
    draft = by_parts(Parts((drives, rests), carried=frozenset([1])), whole)
    assert draft.statements == [{"stability": "stable"}]


@few(1)
@pytest.mark.parametrize("name", CARRIED)
def test_what_is_carried_stays_near_and_does_not_come(name: str) -> None:
    """Paths stay near, and end beside the point: one state after the other takes a step; relays cost a square root."""
    place = 0.01 * np.random.default_rng(5).uniform(-1, 1, (3, 200))
    at, size, step = dict(zip("xyz", place, strict=True)), np.abs(place).max(axis=0), 1e-3
    for _ in range(20_000):
        for state, text in reversed(list(zip("xyz", CARRIED[name], strict=True))):
            at[state] = at[state] + step * value(text, **at)
        place = np.stack(list(at.values()))
        assert np.all(np.abs(place).max(axis=0) < 3 * np.sqrt(size))
    assert np.median(np.abs(place).max(axis=0) / size) > 0.05


@pytest.mark.usefixtures("without_reach")
def test_both_decide_where_nothing_else_does() -> None:
    rhs, at, truth = CASCADES["rotation drives"]
    result = decide_system(system(rhs, at))
    assert (result.verdict, result.method) == (truth, Method.CASCADE)
    assert (sliding().verdict, sliding().method) == (ATTRACTS, Method.SLIDING)


@cache
def sliding() -> StabilityResult:
    """A system that slides and then comes home in third degree, whose reach is not asked."""
    return decide_system(system(SLIDES["zero dynamics of third degree"][0]))


@pytest.mark.usefixtures("without_reach")
def test_what_parts_ask_is_exported() -> None:
    certificate = certificate_of(sliding())
    names = [obligation.name for obligation in obligations_of(certificate, "relay")]
    assert names
    assert all(name.startswith("1 sliding: part 1: ") for name in names)


# What is driven only rests; jumps with what drives it; is driven on the way to a surface that it comes to.
NOTHING = [
    (["-x**3", "x"], decide_by_cascade),
    ([*SUPER_TWISTING, "-z - 2*sign(z + sign(y))"], decide_by_cascade),
    (["-x", "-y + 10**31*(x + 1 - 1.0000000000000000000000000000010)*sign(x + 1 - 1.0)"], decide_by_cascade),
    (["-x**3", "2*y*sign(x)**2 - y"], decide_by_cascade),
    (["y", "-x - y"], decide_by_cascade),
    (["-x**3", "x**2*sign(y)**2"], decide_by_cascade),
    (["y", "-x + z", "-z**3"], decide_by_cascade),
    (["-x**3", "-sign(y + x) - sign(y - x)"], decide_by_cascade),  # both signs of the sum of forms that meet
    (["-x**3", "-sign(y**3 + x)"], decide_by_cascade),
    (["-x**3", "-sign(y) - sign(y + sat(x, -1, 1))"], decide_by_cascade),
    (["-x**3", "-sign(y + Max(x, y)/2)"], decide_by_cascade),
    ([*SUPER_TWISTING, "-sign(z + sat(sign(y), -1, 1))"], decide_by_cascade),
    (["y", "sign(x + y)"], decide_by_sliding),
    (["2*x*sign(y)**2 - x", "-sign(y)"], decide_by_sliding),
    (["x", "-sign(x + y**3)"], decide_by_sliding),
]


@pytest.mark.parametrize(("rhs", "decide"), NOTHING)
def test_nothing_is_said(rhs: list[str], decide: Decide) -> None:
    assert decide(checked_point(system(rhs))) is None


@pytest.mark.parametrize("seed", range(40))
def test_random_systems_are_not_contradicted(seed: int) -> None:
    """By solutions of the inclusion that are followed in floats, of whatever one of the two theorems says."""
    source = random.Random(seed)
    require_true(random_relay(source), decide_by_sliding)
    require_true(random_cascade(source), decide_by_cascade)


@few(6)
@pytest.mark.parametrize("seed", range(40))
def test_what_rests_beside_others_is_not_contradicted(seed: int) -> None:
    require_true(random_carried(random.Random(seed)), decide_by_cascade)


def require_true(rhs: list[str], decide: Decide) -> None:
    """What a theorem says of a system, if anything."""
    point = checked_point(system(rhs))
    found = decide(point)
    if found is not None:
        certificate = certificate_of(decided_by(point, found))
        assert not contradiction(certificate["statement"]), rhs


def decided_by(point: CheckedPoint, found: Finding) -> StabilityResult:
    return StabilityResult(point.system, point.equilibrium, (found,), None, Reach())


def random_relay(source: random.Random) -> list[str]:
    """A relay that pushes to a surface, in three states, with nonlinear terms."""
    c, a = (source.choice([-2, -1, 1, 2]) for _ in range(2))
    first, second = (source.choice(["y", "-x", "x", "-y", "-x**3", "x*y", "z"]) for _ in range(2))
    push, curve = source.choice(["x", "-z", "y**2", "x*z"]), source.choice(["0", "x**2", "y**3"])
    return [f"{first} + {c}*z", f"{second} - {source.choice([1, 2])}*y", f"{push} - 2*sign({a}*x + y + 3*z + {curve})"]


def random_cascade(source: random.Random) -> list[str]:
    """Three states, each driven by those before, with nonlinear terms."""
    root = "-sign({})*sqrt(Abs({}))"
    falls = [source.choice(["-{}**3", "-sign({})", "-{}", "-{}*Abs({})", "{}", root]) for _ in range(3)]
    drives = [
        "0",
        source.choice(["x", "x**2", "y*x", "Abs(x)", "sqrt(Abs(x))", "-2*sign(y + x)", "-2*sign(y + sat(x, -1, 1))"]),
        source.choice(["y", "x*z", "z**2*x", "sat(y, -1, 1)", "sign(z - 2*y + x)", "-2*sign(z + Max(x, -1)*y)"]),
    ]
    pairs = zip("xyz", zip(falls, drives, strict=True), strict=True)
    return [f"{fall.format(name, name)} + {drive}" for name, (fall, drive) in pairs]


def random_carried(source: random.Random) -> list[str]:
    """Two states that only rest, or that fall, where a third one pushes them, which falls slowly or fast."""
    rests = [
        ("y", "-x"),
        ("y", "-x**3"),
        ("0", "0"),
        ("y", "-x*Abs(x)"),
        ("-sign(x)", "0"),
        ("y", "-sign(x)"),
        ("y", "0"),
    ]
    pushes = [
        source.choice(["z", "x*z", "Abs(z)", "z**2", "y*Abs(z)", "sat(z + x, -1, 1) - sat(x, -1, 1)"]) for _ in "xy"
    ]
    sides = [f"{rest} + {push}" for rest, push in zip(source.choice(rests), pushes, strict=True)]
    return [*sides, source.choice(["-z", "-sign(z)", "-z**3", "-z*Abs(z)", "z"])]


# ---- Empty and thin cells between curves, against cells that are empty or hold a point because of how they are made.

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, PLANE, name) for name in PLANE)
SQUARE = square_regions(FIELD(1))  # quadrant by quadrant, from the first one on
SEVERAL = pytest.mark.parametrize("count", keep(1, [6, 12]))  # random cells of each kind


def guard(text: str) -> Polynomial:
    return parse_piecewise(text, PLANE).polynomial(dict(zip(PLANE, (X, Y), strict=True)), lambda _: 1)


def emptied(*texts: str) -> list[bool | None]:
    """For each quadrant of the square."""
    guards = tuple(map(guard, texts))
    return [is_empty(replace(quadrant, guards=guards)) for quadrant in SQUARE]


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["x**2*y - x**4 - y**2", "y"], [True] * 4),  # touches zero at the origin alone: x^4 - 4 x^4 < 0
        (["-(y - x**2)*(y - 2*x**2)"], [False, False, True, True]),  # between tangent parabolas
        (["y - x**2", "x**2 - y"], [True] * 4),
        (["y - x**2", "x**2*(1 + 1/10**9) - y"], [False, False, True, True]),
        (["y - 2*x**2", "x**2 - y"], [True] * 4),  # tangent parabolas the other way round
        (["x**3 - x**2 - y**2"], [True] * 4),  # an isolated point, and a curve far away
        (["-(y - x**2)**2"], [True] * 4),  # zero along a curve without area
        (["1/10**12 - (x - 1/3)**2 - (y + 1/4)**2"], [True, True, True, False]),  # a tiny oval
        (["1/10 - x**2 - y**2", "x**2 + 2*y**2 - 3/10"], [True] * 4),  # nested ovals: 2/10 at most
        (["1/10 - x**2 - y**2", "x**2 + 4*y**2 - 3/10"], [False] * 4),
        (["y**2 - x**3", "x**3 - 2*y**2"], [True] * 4),  # cusps
        (["2*y**2 - x**3", "x**3 - y**2"], [False, True, True, False]),
    ],
)
def test_known_cells(texts: list[str], expected: list[bool]) -> None:
    assert emptied(*texts) == expected


def random_polynomial(rng: np.random.Generator, degree: int) -> Polynomial:
    exponents = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    values = rng.integers(-5, 6, len(exponents))
    return Polynomial(FIELD, PLANE, {e: FIELD(int(v)) for e, v in zip(exponents, values, strict=True) if v})


@SEVERAL
def test_random_cells_that_are_empty(count: int) -> None:
    """``p > 0`` and ``-p (1 + q^2) > r^2`` exclude each other."""
    rng = np.random.default_rng(1)
    for _ in range(count):
        p, q, r = (random_polynomial(rng, degree) for degree in (3, 1, 2))
        guards = (p, -p * (q * q + 1) - r * r)
        assert all(is_empty(replace(quadrant, guards=guards)) for quadrant in SQUARE)


@SEVERAL
def test_random_cells_that_hold_a_small_disc(count: int) -> None:
    """Each guard, of degree four, is positive at a known point; a disc about it is the only place of the first one."""
    rng = np.random.default_rng(2)
    for _ in range(count):
        x, y = (Fraction(int(k), 97) for k in rng.integers(1, 96, 2))
        near = guard(f"1/10**{rng.integers(2, 10)} - (x - {x})**2 - (y - {y})**2")
        p = random_polynomial(rng, 4)
        here = p((FIELD(x), FIELD(y)))
        p = p if here.sign() > 0 else -p
        if here:
            assert [is_empty(replace(quadrant, guards=(near, p))) for quadrant in SQUARE] == [False, True, True, True]


@SEVERAL
def test_random_cells_in_which_no_sample_lies_if_they_are_empty(count: int) -> None:
    """Points at all scales from 1 down to 10^-6, evaluated in floats with a margin for rounding."""
    rng = np.random.default_rng(3)
    radius, angle = 10 ** rng.uniform(-6, 0, 20_000), rng.uniform(0, np.pi / 2, 20_000)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    seen = 0
    for _ in range(2 * count):
        a, b, c = (Fraction(int(k), 4) for k in rng.integers(-6, 7, 3))
        texts = f"(y - {a}*x**2)*(y - {b}*x**2 - {c}*x**3)", f"{c}*x*y**2 - x**4 - {abs(a)}*y**3 + x**2*y"
        inside = np.ones_like(x, dtype=bool)
        for text in texts:
            terms = [(float(v), i, j) for (i, j), v in guard(text).terms.items()]
            value = sum(v * x**i * y**j for v, i, j in terms)
            size = sum(abs(v) * x**i * y**j for v, i, j in terms)
            inside &= value > 1e-12 * size
        seen += bool(inside.any())
        assert not (inside.any() and emptied(*texts)[0])
    assert seen > count / 2


def test_irrational_and_huge_guards_are_left_open() -> None:
    assert emptied("y - sqrt(2)*x**2") == [None] * 4
    assert emptied("(x + y + 1/7)**15*y - x**16*2 - 1/3") == [None] * 4


SCENE = """[system]
states = ["x", "y"]
{regions}[[region]]
rhs = {rhs}
"""
EMPTY = '["x**2*y - x**4 - y**2 > 0", "y > 0"]', '"(y - x**2)**2*(1 + y**2) + x**2*y**4 < 0"'


@few(2)
@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("where", EMPTY, ids=["by products", "by squares"])
@pytest.mark.parametrize("rhs", ['["-x", "-y"]', '["-x + y", "-x - y**3"]', '["-sign(x) + y", "-2*sign(y) - x"]'])
def test_a_region_without_points_changes_nothing(tmp_path: Path, where: str, rhs: str) -> None:
    """By definition: fields on a set without area are ignored; these led straight out, and took over a minute."""
    verdicts = []
    for regions in ("", f'[[region]]\nwhere = {where}\nrhs = ["1", "x"]\n'):
        file = tmp_path / "scene.toml"
        file.write_text(SCENE.format(regions=regions, rhs=rhs))
        result = decide_system(load_system(str(file)))
        verdicts.append((result.verdict, result.equilibrium))
    assert verdicts[0] == verdicts[1]
