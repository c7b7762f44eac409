"""What acts near the point: fans, germs of guarded cells, leading terms."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import prod

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.cells.region import quadrants
from nonsmooth.proofs.checker.cells import Inclusion, read_system
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.inequalities.curved_regions import (
    ClosureMembership,
    Extent,
    closure_membership,
    extent,
    ray_closure_membership,
)
from nonsmooth.proofs.inequalities.real_roots import form_lines, lowest_form
from nonsmooth.proofs.kernel.cells import BeyondReachError, sharpened, stated_cells
from nonsmooth.proofs.kernel.fans import show_by_fan
from nonsmooth.proofs.kernel.first_terms import leading_direction, show_departure_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.systems.leading_terms import FusedFocus, TurnGrowth, decide_leading_terms
from nonsmooth.proofs.systems.ray_moves import build_tangent_fan, conic_germ, decide_equilibrium
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.proofs.theorem_searches import show_verdict
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem
from tests.oracles.mutants import Record, is_one_line
from tests.plain import refused
from tests.proofs.conftest import Load
from tests.proofs.switched_oracle import Judge, Switched, leaves, random_conewise, random_fan, random_relay, spread
from tests.thorough import but, few, keep, thorough

# ---- Evidence by what acts near the point: fans, linearizations, points that are no equilibria, beside floats.

ATTRACTS, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"
TURN = ["sign(y)", "-sign(x) - sign(y)/2"]

KNOWN = {
    "turns outward": (["sign(y)", "-sign(x) + sign(y)/2"], UNSTABLE, "instability"),
    "turns inward": (TURN, ATTRACTS, "lyapunov"),
    "turns inward, higher terms": (["sign(y) + 5*x**2", "-sign(x) - sign(y)/2 + 9*x"], ATTRACTS, "lyapunov"),
    "turns inward, curved": (["sign(y - x**2)", "-sign(x) - sign(y - x**2)/2"], ATTRACTS, "lyapunov"),
    "closed orbits": (["sign(y)", "-sign(x)"], STABLE, "lyapunov"),
    "equilibria on a line": (["0", "-sign(y)"], STABLE, "lyapunov"),
    "slides home where it repels": (
        ["sign(x)*(3*sign(y + Abs(x)) - 1)/2", "-1 - 2*sign(y + Abs(x))"], ATTRACTS, "lyapunov"
    ),
    "slides away": (["sign(x)", "-3*sign(y)"], UNSTABLE, "escape"),
    "no equilibrium": (["1 + sign(x)/2", "y"], UNSTABLE, "departure"),
    "no equilibrium beside a curve": (["-sign(x**3 - x**2 - y**2)", "-y"], UNSTABLE, "departure"),
    "saddle beside curves": (["x + relu(y)**2", "-y"], UNSTABLE, "instability"),
    "center and an unstable direction": (["y", "x**3", "z"], UNSTABLE, "instability"),
    "node beside curves": (["-x + relu(y)**2", "-2*y + Abs(x)*x"], ATTRACTS, "lyapunov"),
    "twisting outward": (["y", "-3*sign(x) + 2*sign(y)"], UNSTABLE, "instability"),
    "twisting inward": (["y", "-3*sign(x) - sign(y) + x"], ATTRACTS, "lyapunov"),
    "relay that is pushed": (["y", "-sign(x) + y"], UNSTABLE, "instability"),
    "forms of several degrees": (["-x**3 - sign(x)*y**2", "-y**3"], ATTRACTS, "lyapunov"),
    "enclosed sine": (["y", "-sin(x) + y/4"], UNSTABLE, "instability"),
}  # fmt: skip


def build(rhs: list[str]) -> SwitchedSystem:
    return ns.System(["x", "y", "z"][: len(rhs)], rhs, radius="1/2").system


def certificate(system: SwitchedSystem, verdict: str) -> Record:
    entry, claims = show_verdict(system, verdict)
    assert {"stability": verdict} in claims
    record = {"version": VERSION, "statement": {"subject": about(system), "claims": claims}, "evidence": [entry]}
    return json.loads(json.dumps(record))


LONG = ["turns inward, curved", "twisting outward", "slides home where it repels", "relay that is pushed"]


@few(8)
@pytest.mark.parametrize("name", but(LONG, KNOWN))
def test_known_verdicts_are_shown_to_the_checker(name: str) -> None:
    rhs, verdict, theorem = KNOWN[name]
    record = certificate(build(rhs), verdict)
    assert record["evidence"][0]["theorem"] == theorem
    assert refused(record) == ""


@few(1)
@pytest.mark.parametrize(
    "name", ["turns outward", "turns inward", "closed orbits", "slides away", "saddle beside curves"]
)
def test_no_other_verdict_is_shown(name: str) -> None:
    rhs, verdict, _ = KNOWN[name]
    for other in {ATTRACTS, STABLE, UNSTABLE} - {verdict} - ({STABLE} if verdict == ATTRACTS else set()):
        with pytest.raises(NotShownError):
            show_verdict(build(rhs), other)


def test_a_value_of_the_function_that_is_too_large_is_rejected() -> None:
    record = certificate(build(TURN), ATTRACTS)
    pieces = record["evidence"][0]["hypotheses"]["function"]
    for piece in pieces:
        changed = [[mark, "x" if text == piece[1] else text] for mark, text in pieces]
        forged = json.loads(json.dumps(record))
        forged["evidence"][0]["hypotheses"]["function"] = changed
        assert refused(forged)


def compare_with_formulas(count: int, first: int) -> list[str]:
    """The verdicts by formulas in floats on random fans, each shown, and no other one."""
    decided = []
    for seed in range(first, first + count):
        system = random_fan(seed)
        known = Judge(system).verdict()
        for verdict in (ATTRACTS, UNSTABLE) if known is not None else ():
            try:
                record = certificate(build(list(system.rhs)), verdict)
            except NotShownError:
                continue
            assert verdict == known, (seed, system.rhs)
            assert refused(record) == "", (seed, system.rhs)
            decided.append(verdict)
    return decided


def test_random_fans_against_formulas() -> None:
    assert set(compare_with_formulas(2, 0)) == {ATTRACTS, UNSTABLE}


@thorough  # the small one: test_random_fans_against_formulas
def test_many_random_fans_against_formulas() -> None:
    decided = compare_with_formulas(60, 1000)
    assert min(decided.count(ATTRACTS), decided.count(UNSTABLE)) > 10


@thorough  # the small one: test_random_fans_against_formulas
def test_random_fans_against_paths() -> None:
    """What attracts by a piecewise linear V attracts polygons with small steps."""
    attracted = 0
    for seed in range(2000, 2010):
        system = random_fan(seed, drift=False)
        try:
            show_by_fan(build(list(system.rhs)), ATTRACTS)
        except NotShownError:
            continue
        attracted += 1
        assert any(spread(system, steps=steps)[1] < 0.5 for steps in (4000, 64000)), (seed, system.rhs)
    assert attracted > 0


def test_patterns_without_points_are_those_of_a_fine_grid() -> None:
    system = build(["-sign(y - x**2) + sign(x - y**3)", "-sign(x**2 + y**2 - 2)"])
    search, subject = Search(), read_system(about(system))
    stated = stated_cells(system, system.check.radius)
    sharper = sharpened(stated, subject, search)
    line = np.linspace(-0.5, 0.5, 202)
    x, y = np.meshgrid(line, line)
    signs = np.stack([y - x**2, x - y**3, x**2 + y**2 - 2], axis=-1).reshape(-1, 3) > 0
    occurring = len(np.unique(signs, axis=0))
    assert len(Inclusion(subject, stated.record, [], search).cells) == 8
    assert len(Inclusion(subject, sharper.record, [], search).cells) == occurring == 4


def test_directions_lead() -> None:
    """All products are positive, where a point of the hull nearest to the origin says that there is a direction."""
    rng = np.random.default_rng(5)
    for _ in range(40):
        velocities = rng.normal(size=(4, 3)) + 1
        shares = rng.dirichlet(np.ones(4), 20_000)
        nearest = float(np.linalg.norm(shares @ velocities, axis=1).min())
        direction = leading_direction(velocities)
        assert direction is None or (velocities @ direction > 0).all()
        assert direction is not None or nearest < 0.2


def test_an_equilibrium_has_no_direction() -> None:
    with pytest.raises(NotShownError):
        show_departure_of(build(["-sign(x)", "1 - 2*sign(y)"]), UNSTABLE)


@pytest.mark.parametrize(
    ("rhs", "verdict"),
    [
        (["sign(y - sqrt(2)*x)", "-sign(x) + sign(y - sqrt(2)*x)/2"], UNSTABLE),
        (["-sign(x) + sqrt(Abs(y))", "-sign(y)"], ATTRACTS),
        (["-y", "sqrt(2)*x"], STABLE),
    ],
)
def test_other_systems_are_refused_in_one_line(rhs: list[str], verdict: str) -> None:
    with pytest.raises((NotShownError, BeyondReachError)) as error:
        show_verdict(build(rhs), verdict)
    assert is_one_line(str(error.value))


def test_irrational_numbers_are_shown_as_they_are() -> None:
    entry, claims = show_verdict(build(["sqrt(2)*sign(y)", "-sign(x) + sign(y)/2"]), UNSTABLE)
    assert (entry["theorem"], claims) == ("instability", [{"stability": UNSTABLE}])


# ---- Germs of guarded cells at the origin, against arcs on which the signs of the guards are plain arithmetic.

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, PLANE, name) for name in PLANE)
RAYS = [(1, 0), (0, 1), (-1, 0), (0, -1)]
WHOLE, PART, NONE = Extent.WHOLE, Extent.PART, Extent.NONE


def guard(text: str) -> Polynomial:
    return parse_piecewise(text, PLANE).polynomial(dict(zip(PLANE, (X, Y), strict=True)), lambda _: 1)


def in_quadrants(*texts: str) -> list[Extent]:
    guards = tuple(guard(text) for text in texts)
    rays = [(FIELD(x), FIELD(y)) for x, y in RAYS]
    return [extent(guards, a, b) for a, b in pairwise([*rays, rays[0]])]


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["x**3 - x**2 - y**2"], [NONE] * 4),  # zero at the origin, negative around it
        (["x**2 + y**2 - x**3"], [WHOLE] * 4),
        (["y + x**2 + 1"], [WHOLE] * 4),  # passes the origin far away
        (["-y - x**2 - 1"], [NONE] * 4),
        (["y - x**2"], [PART, PART, NONE, NONE]),
        (["x**2 - y"], [PART, PART, WHOLE, WHOLE]),
        (["y - x**2", "2*x**2 - y"], [PART, PART, NONE, NONE]),  # squeezed between tangent curves
        (["y - 2*x**2", "x**2 - y"], [NONE] * 4),  # an empty cell on one side
        (["y - x**2", "x**2 + x**4 - y"], [PART, PART, NONE, NONE]),
        (["y - x**2", "2*x**2 - y", "3*x**2 - y"], [PART, PART, NONE, NONE]),  # three tangent guards
        (["y - x**2", "x**3 - y"], [NONE] * 4),
        (["x**3 - y**2"], [PART, NONE, NONE, PART]),  # a cusp
        (["y**2 - x**3"], [PART, WHOLE, WHOLE, PART]),
        (["(y - x**2)*(y - 2*x**2)", "(y - x**2)*(3*x**2 - y)"], [PART, PART, NONE, NONE]),  # a common factor
        (["x**4 - x**2*y**2 + y**4"], [WHOLE] * 4),
        (["-x**4 + x**2*y**2 - y**4"], [NONE] * 4),
        (["y**2 + x**4 - 2*x**2*y"], [WHOLE] * 4),  # (y - x**2)**2: zero on a curve without area
        (["y - x**2/3", "x**2/3 - y + x**9"], [PART, NONE, NONE, NONE]),  # contact of high order
        (["x**2*y**2 - x**7 - y**7"], [PART, PART, WHOLE, PART]),
    ],
)
def test_known_germs(texts: list[str], expected: list[Extent]) -> None:
    assert in_quadrants(*texts) == expected


def test_irrational_guards_are_decided_by_their_lowest_forms_or_not_at_all() -> None:
    assert in_quadrants("sqrt(2) + y") == [WHOLE] * 4
    assert in_quadrants("-sqrt(2)*x**2 - y**2 + x**3") == [NONE] * 4
    assert set(in_quadrants("y - sqrt(2)*x**2")) == {Extent.UNDECIDED}


EXPONENTS = ((1, 1), (3, 2), (2, 1), (5, 2), (3, 1), (4, 1))
CURVES = [(a, p, q) for a in (Fraction(1), Fraction(2), Fraction(1, 3)) for p, q in EXPONENTS]
# between all factors a^(1/q) that occur: 1/3, 0.577, 1, 1.41, 2
FACTORS = [Fraction(1, 20), Fraction(1, 2), Fraction(3, 4), Fraction(6, 5), Fraction(3, 2), Fraction(20)]
ARCS = [(c, Fraction(r, 4)) for r in range(1, 20) for c in FACTORS]


@pytest.mark.parametrize("seed", range(60))
def test_random_germs_of_curves_that_are_powers(seed: int) -> None:
    """Guards are products of ``y^q - a x^p`` in the first quadrant; arcs ``y = c x^r`` pass between all of them."""
    rng = np.random.default_rng(seed)
    guards: list[Polynomial] = []
    factors: list[list[tuple[Fraction, int, int]]] = []
    signs = [int(rng.choice([-1, 1])) for _ in range(rng.integers(1, 4))]
    for side in signs:
        chosen = [CURVES[k] for k in rng.choice(len(CURVES), size=rng.integers(1, 4), replace=False)]
        factors.append(chosen)
        guards.append(prod((Y**q - X**p * a for a, p, q in chosen), start=Polynomial.constant(FIELD, PLANE, side)))
    x = Fraction(1, 2**400)  # a fourth power, so that the arcs have rational points
    root = Fraction(1, 2**100)
    filled = []
    for c, r in ARCS:
        y = c * root ** int(4 * r)
        values = [
            side * prod(y**q - a * x**p for a, p, q in curves) for side, curves in zip(signs, factors, strict=True)
        ]
        filled.append(all(value > 0 for value in values))
    expected = WHOLE if all(filled) else PART if any(filled) else NONE
    one, zero = FIELD.one, FIELD.zero
    assert extent(guards, (one, zero), (zero, one)) is expected
    region = quadrants(one)[0]
    guarded = type(region)(region.generators, tuple(guards))
    assert (closure_membership(guarded) is ClosureMembership.YES) is any(filled)


@pytest.mark.parametrize(
    ("texts", "ray", "expected"),
    [
        (["y + x**2 + 1"], (1, 0), ClosureMembership.YES),
        (["-y - x**2 - 1"], (1, 0), ClosureMembership.NO),
        (["y - x**2"], (1, 0), ClosureMembership.NO),
        (["x**2 - y"], (1, 0), ClosureMembership.YES),
        (["y - x**2"], (0, 1), ClosureMembership.YES),
        (["y - x**2"], (1, -1), ClosureMembership.NO),
        (
            ["y*(x - 1)"],
            (1, 0),
            ClosureMembership.UNDECIDED,
        ),  # a guard that vanishes along the ray is never met as a factor
    ],
)
def test_rays_beside_a_cell(texts: list[str], ray: tuple[int, int], expected: ClosureMembership) -> None:
    region = quadrants(FIELD.one)[0]
    guarded = type(region)(region.generators, tuple(guard(text) for text in texts))
    assert ray_closure_membership(guarded, (FIELD(ray[0]), FIELD(ray[1]))) is expected


# ---- verdicts that hang on it ----------------------------------------------------------------------


def test_a_surface_that_passes_the_equilibrium_adds_no_rest(load: Load) -> None:
    """Near the origin it is ``x' = y, y' = -x - y``, whose eigenvalues have real part -1/2."""
    scene = load("y", "((-x-y)+x)/2 + sign(y+x**2+1)*((-x-y)-x)/2")
    result = decide_system(scene)
    assert result.check()
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert PlanePoint(scene).rays == ()
    assert not result.reach.everywhere  # beyond the parabola the field is another


@pytest.mark.parametrize(
    ("guard_text", "first"),
    [
        ("x**3 - x**2 - y**2", 1),
        ("-(x**3 - x**2 - y**2)", -1),
        ("x**4 - x**2*y**2 + y**4", -1),
        ("x**4 + y**4 - x**5", -1),
        ("(x**2 + y**2)*(x - 1)", 1),
        ("(x - y)**2*(y + 1)", -1),
        ("x**2 + y**2 + 2*x*y - x**4*(y - 1)", -1),
    ],
)
def test_a_cell_whose_guard_vanishes_at_an_isolated_point_is_not_there(load: Load, guard_text: str, first: int) -> None:
    """Near the origin the field is (+-1, -y): there 0 is not in F."""
    scene = load(f"-sign({guard_text})", "-y")
    result = decide_system(scene)
    assert result.check()
    assert result.equilibrium is Equilibrium.FAILS
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.EQUILIBRIUM)
    near = conic_germ(plane_cells(scene))
    assert near is not None
    assert {cell.velocities[0][0].constant_value for cell in near} == {scene.field(first)}


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ("-sign(y - x**2)", "-1/2", Equilibrium.FAILS),
        ("-sign(y - x**2)", "0", Equilibrium.HOLDS),
        # only between the parabolas the velocity is (-1, 0), and only it makes 0 a mixture
        ("sign(y - x**2)*sign(y - 2*x**2)", "0", Equilibrium.HOLDS),
        ("sign(y - x**2)*sign(y - x**2 - 1)", "0", Equilibrium.HOLDS),
        ("sign(y - x**2)*sign(y - x**2)", "0", Equilibrium.FAILS),
        ("-sign(y**2 - x**3)", "y", Equilibrium.HOLDS),  # the cusp is narrow, but there
        ("-sign(y**2 - x**3) - 1/2*sign(y - 1) + 1", "y", Equilibrium.FAILS),
        ("1 - sign(y**2 + x**2 - x**5)", "1", Equilibrium.FAILS),
    ],
)
def test_equilibria_beside_curves(load: Load, first: str, second: str, expected: Equilibrium) -> None:
    scene = load(first, second)
    assert decide_equilibrium(plane_cells(scene)) is expected


@pytest.mark.parametrize("is_checked", keep(1, [False, True]))
def test_a_guard_of_a_potential_that_vanishes_at_the_point_refutes_nothing(load: Load, is_checked: bool) -> None:
    """V = x^2 + y^2 near the origin: the bracket is zero except where the quartic is negative, that is nowhere."""
    text = "x**2 + y**2 + (1 - sign(x**4 - x**2*y**2 + y**4))"
    scene = load("-x", "-y", lyapunov=f'"{text}"')
    result = decide_system(scene)
    assert result.verdict is not Translation.UNSTABLE
    assert result.given is not None
    assert result.given.witness is None
    assert not is_checked or result.check()  # which looks for a proof with this V for long


# ---- Leading terms of plain systems: against formulas, quadrature and integrators that share no code with them.

COUNT = 40
PATHS = 6


@few(1)
@pytest.mark.parametrize("generate", [random_relay, random_conewise])
@pytest.mark.parametrize("count", keep(1, [16, COUNT]))
def test_random_systems_against_formulas(load: Load, generate: Callable[[int], Switched], count: int) -> None:
    counts: Counter[tuple[str, str]] = Counter()
    for seed in range(1000, 1000 + count):
        system = generate(seed)
        found = decide_leading_terms(load(*system.rhs))
        verdict = Judge(system).verdict()
        counts[str(found and found.verdict), str(verdict)] += 1
        assert found is None or verdict is None or str(found.verdict) == verdict, (seed, system.rhs)
    assert min(counts[v, v] for v in ("asymptotically stable", "unstable")) >= count // 8
    assert sum(n for (found, _), n in counts.items() if found == "None") <= count // 10


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


def test_growth_of_a_stiff_focus_is_enclosed(load: Load) -> None:
    """Powers of the share along a chord cancelled: a million evaluations at each precision, and no sign."""
    found = decide_leading_terms(load("y", "-1e9*x - y"))
    assert found is not None
    assert isinstance(found.growth, TurnGrowth)
    assert float(found.growth.low) == pytest.approx(np.exp(-np.pi / np.sqrt(1e9 - 0.25)), rel=1e-6)
    assert found.growth.sign == -1


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
