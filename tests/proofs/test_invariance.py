"""LaSalle's principle: in two states and many, and under arbitrary switching."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import InvariantMotion, decide_invariant_motion, resting_place
from nonsmooth.proofs.systems.domain import given_cells
from nonsmooth.proofs.systems.findings import KEPT, Method
from nonsmooth.symbolic.files.system_builder import parse_lyapunov
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.dissipative_systems import dissipative_systems
from tests.oracles.floats import value, velocity
from tests.plain import built
from tests.proofs.conftest import Load
from tests.thorough import few, keep, thorough

# ---- LaSalle's principle: against systems that are known to keep solutions, and against paths of random oscillators.

ENERGIES = {  # force: potential
    "x": "x**2/2",
    "sign(x)": "Abs(x)",
    "x**3": "x**4/4",
    "x + Abs(x)/2": "x**2/2 + x*Abs(x)/4",
    "x - 4*x**3": "x**2/2 - x**4",
}


def with_v(system: SwitchedSystem, lyapunov: str) -> SwitchedSystem:
    parsed = parse_lyapunov(lyapunov, system.states, "t", "lyapunov")
    return replace(system, check=replace(system.check, lyapunov=parsed, is_default=False))


def staying(system: SwitchedSystem, share: int = 1) -> InvariantMotion:
    """Of the scene's V, on a part of the checked square."""
    radius = system.check.radius / share
    return decide_invariant_motion(system, system.check.lyapunov, radius, given_cells(system, radius))


@pytest.mark.parametrize(
    ("friction", "potential", "known"),
    keep(8, [
        ("x + y**3", "x**2/2", InvariantMotion.NONE),
        ("sign(x) + y", "Abs(x)", InvariantMotion.NONE),
        ("sign(x) + sign(y)*y**2", "Abs(x)", InvariantMotion.NONE),
        ("x + sign(y)", "x**2/2", InvariantMotion.RESTS),  # Coulomb: a segment of rest
        ("x - 4*x**3 + y", "x**2/2 - x**4", InvariantMotion.RESTS),  # the pendulum's other equilibrium on the border
        ("x + relu(y - 1/8)", "x**2/2", InvariantMotion.CELLS),  # closed orbits below the dead zone
        ("x + y*(x**2 + y**2 - 1/16)**2", "x**2/2", InvariantMotion.ARC),  # a limit cycle on the circle where V' = 0
        ("x + y*(1 + sign(x**2 + y**2 - 1/16))", "x**2/2", InvariantMotion.CELLS),
        ("x + relu(y)**3", "x**2/2", InvariantMotion.NONE),  # a quarter without friction, which solutions cross
        ("x + relu(x)*y", "x**2/2", InvariantMotion.NONE),
    ]),
)  # fmt: skip
def test_what_stays(load: Load, friction: str, potential: str, known: InvariantMotion) -> None:
    assert staying(with_v(load("y", f"-({friction})"), f"y**2/2 + {potential}")) is known


BANG_BANG = "Abs(x + y*Abs(y)/3) + y**2/2"


def test_a_curve_of_switching_attracts(load: Load) -> None:
    """V bends on a curve, along which solutions of the double integrator switch once: known since Pontryagin."""
    system = with_v(load("y", "-sign(x + y*Abs(y)/3)"), BANG_BANG)
    assert staying(system) is InvariantMotion.NONE
    assert audit(system, BANG_BANG).proves is Translation.ASYMPTOTICALLY_STABLE
    for orbits in (load("y", "-x"), load("-sign(y)", "sign(x)")):
        potential = "x**2 + y**2" if orbits.rhs[0].text == "y" else "Abs(x) + Abs(y)"
        assert audit(orbits, potential).proves is Translation.STABLE


@thorough  # the audit: the test above; a certificate of it: bang_bang in checker/test_statements.py
def test_a_curve_of_switching_has_a_certificate(load: Load) -> None:
    result = decide_system(with_v(load("y", "-sign(x + y*Abs(y)/3)"), BANG_BANG))
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    claims = certificate_of(result)["statement"]["claims"]
    assert {"stability": "asymptotically stable"} in claims
    assert any("attracts" in claim for claim in claims)


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("y", "-sign(x) - y**3"),
        ("y", "-x**3 - y**3"),
        ("y", "-x*Abs(x) - y**3"),
        ("y", "-2*x - Abs(x) - y**3"),
    ],
)
def test_an_energy_is_found(load: Load, first: str, second: str) -> None:
    result = decide_system(load(first, second))
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    assert result.check()
    assert result.function is not None
    judged = audit(load(first, second), result.function.text)
    assert (judged.verdict, judged.proves) == (AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE)


def test_a_named_energy_decides_with_its_region(load: Load) -> None:
    system = with_v(load("y", "-sign(x) - y**3"), "y**2/2 + Abs(x)")
    result = decide_system(system)
    assert result.method is Method.INVARIANCE
    assert result.function is result.given
    assert str(result.reach.region) == "V < 1/8"  # y^2/2 at the border
    assert result.check()


def test_coulomb_friction_is_not_asymptotically_stable(load: Load) -> None:
    for second in ("-x - sign(y)", "-x - sign(y) - y**3", "-x/2 - sign(y)/100"):
        assert decide_system(load("y", second)).verdict is Translation.STABLE


@pytest.mark.usefixtures("without_reach")
@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize(
    ("force", "potential"), keep(1, [("sign(x) - 2*x", "Abs(x) - x**2"), ("x - 4*x**3", "x**2/2 - x**4")])
)
def test_shrinking_avoids_a_far_equilibrium(load: Load, force: str, potential: str) -> None:
    """Beside the point, that of x = 1/2 rests too."""
    system = with_v(load("y", f"-({force}) - y**3"), f"y**2/2 + {potential}")
    result = decide_system(system)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.function is not None
    assert result.function.domain.radius is not None
    assert result.function.domain.radius < system.check.radius
    assert result.check()


@pytest.mark.parametrize(
    ("first", "second", "rests"),
    [
        ("y", "-x - sign(y)", True),
        ("y", "-x**3 - y**3", False),
        ("-sign(x) + 2*sign(y)", "-2*sign(x) - sign(y)", False),
        ("1/4 - x", "-y", True),
        ("1 - 4*sign(x)*x", "-y", True),
        ("y - x**2", "-x", False),
        ("-sign(x - 1/4)", "-y", True),
        ("y + sign(x - 1/4)", "-y - 1", False),
    ],
)
def test_rests(load: Load, first: str, second: str, rests: bool) -> None:
    system = load(first, second)
    assert (resting_place(given_cells(system, system.check.radius)) is not None) is rests


FRICTIONS = (
    *("y", "y**3", "sign(y)", "relu(y)", "relu(y)**3", "relu(y - 1/8)", "relu(x)*y", "relu(x - 1/8)*y", "x**2*y"),
    *("y*Abs(y)", "sign(y)*Abs(x)", "y*(x - 1/4)**2", "relu(-x)*relu(y)", "y*(1 + sign(x - 1/4))"),
)
STEP, STEPS = 1 / 512, 16_384


def energy_lost(force: str, friction: str, potential: str, level: float) -> tuple[float, float]:
    """The share of the energy that a symplectic polygon loses from a start on a level, at least over several starts,
    and the least distance covered in its last quarter: nothing moves at a rest.
    """
    slope, energy = f"-({force}) - ({friction})", f"y**2/2 + {potential}"
    angles = np.linspace(0.2, 6.2, 7)
    x, y = 0.2 * np.cos(angles), 0.2 * np.sin(angles)
    for _ in range(80):
        high = value(energy, x=x, y=y) > level
        x, y = np.where(high, 0.9 * x, x), np.where(high, 0.9 * y, y)
    first = value(energy, x=x, y=y)
    covered = np.zeros_like(x)
    for step in range(STEPS):
        y = y + STEP * value(slope, x=x, y=y)
        x = x + STEP * y
        covered += np.abs(STEP * y) * (step > 3 * STEPS // 4)
    last = value(energy, x=x, y=y)
    at_rest = (covered < 1e-4) & (np.abs(x) > 0.01)
    return float(np.min(1 - last / first)), float(np.min(np.where(at_rest, 0.0, 1.0)))


@few(1)
@pytest.mark.parametrize("seed", range(24))
def test_random_oscillators_against_paths(load: Load, seed: int) -> None:
    rng = np.random.default_rng(seed)
    force = list(ENERGIES)[rng.integers(len(ENERGIES))]
    friction = FRICTIONS[rng.integers(len(FRICTIONS))]
    system = with_v(load("y", f"-({force}) - ({friction})"), f"y**2/2 + {ENERGIES[force]}")
    found = staying(system, 2)
    lost, moving = energy_lost(force, friction, ENERGIES[force], 2e-2)
    if found is InvariantMotion.NONE:
        assert lost > 1e-4
        assert moving
    if lost < 1e-6 or not moving:
        assert found is not InvariantMotion.NONE


KEPT_V = [
    ["y", "-x"],
    ["y", "-x - x**3"],
    ["y", "-x - sgn(y)*Max(Abs(y) - 1/4, 0)"],  # inside a dead zone
    ["y", "-sin(x)"],
    ["y*z", "-2*x*z", "x*y"],  # a body that turns
]
NOT_KEPT = [
    (["y", "-x - Max(y, 0)"], None),  # V falls on one side only
    (["y", "-x - y**3"], None),
    (["y", "-2*sign(x) - sign(y)"], "2*Abs(x) + y**2/2"),
    (["sign(y)", "-sign(x)"], "Abs(x) + Abs(y)"),  # kept, but it bends
]


@few(3)
@pytest.mark.parametrize("rhs", KEPT_V)
def test_a_v_that_solutions_keep_refutes_attraction(rhs: list[str]) -> None:
    result = decide_system(ns.System(list("xyz")[: len(rhs)], rhs).system)
    assert (result.verdict, result.deciding.refutes) == (Translation.STABLE, KEPT)


@few(2)
@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(("rhs", "lyapunov"), NOT_KEPT)
def test_another_v_does_not(rhs: list[str], lyapunov: str | None) -> None:
    result = decide_system(ns.System(["x", "y"], rhs, lyapunov=lyapunov).system)
    assert not any(finding.refutes == KEPT for finding in result.findings)


# ---- LaSalle's principle under arbitrary switching: counterexamples to asking the fields one by one, and signals
# that try to keep V.

Fields = list[list[str]]

SIGNAL_STEP, SIGNAL_STEPS, NEAR = 1 / 128, 1_800, 1e-6  # somewhat more than two turns
BESIDE_X, BESIDE_Y = (NEAR * np.array([offsets]).T for offsets in ((1, -1, 0, 0), (0, 0, 1, -1)))
DISC = "x**2 + y**2"
AGAINST = [[f"{turn}*y - x*(x - 2*y)**2", f"{-turn}*x - y*(x - 2*y)**2"] for turn in (1, -1)]


def system_of(fields: Fields, lyapunov: str | None = None) -> SwitchedSystem:
    check: dict[str, Any] = {} if lyapunov is None else {"lyapunov": lyapunov}
    return built(fields, radius="1/2", **check)


def staying_under(fields: Fields, lyapunov: str) -> InvariantMotion:
    return staying(system_of(fields, lyapunov))


@few(7)
@pytest.mark.parametrize(
    ("fields", "lyapunov", "found"),
    [
        ([["y", "-x - y**3"], ["y", "-x - 2*y**3"]], DISC, InvariantMotion.NONE),
        ([["y", "-x - y**3"], ["2*y", "-2*x - y"]], DISC, InvariantMotion.NONE),
        ([["y", "-x - relu(x)*y"], ["y", "-x - y"]], DISC, InvariantMotion.NONE),  # a half without friction is crossed
        ([["y", "-sign(x) - y**3"], ["y", "-sign(x) - y"]], "Abs(x) + y**2/2", InvariantMotion.NONE),
        ([["y", "-x - y"], ["y", "-x - y*Abs(y)"], ["2*y", "-2*x - y"]], DISC, InvariantMotion.NONE),
        # either attracts alone, and either turns out of the half in which it keeps V: together they keep it
        ([["y", "-x - relu(x)*y"], ["y", "-x - relu(-x)*y"]], DISC, InvariantMotion.CELLS),
        # either attracts alone; they turn in two senses, and rest together on y = 0
        ([["y", "-x - y"], ["-y", "x - y"]], DISC, InvariantMotion.RESTS),
        ([["y", "-x - y"], ["-2*y", "2*x - 3*y"], ["y", "-x - y**3"]], DISC, InvariantMotion.RESTS),
        # the same on x = 2 y, inside of cells: each field leaves that line, but they are opposed there
        (AGAINST, DISC, InvariantMotion.UNDECIDED),
        ([AGAINST[0], ["y - x*(x - 2*y)**2", "-x - 2*y*(x - 2*y)**2"]], DISC, InvariantMotion.NONE),
        ([["y", "-x"], ["y", "-x - y"]], DISC, InvariantMotion.CELLS),  # one keeps V for ever
        ([["y", "-x - y"], ["y", "-x - sign(y)"]], DISC, InvariantMotion.RESTS),
        ([["y", "-x - y*(x**2 + y**2 - 1/16)**2"], ["y", "-x - y"]], DISC, InvariantMotion.ARC),
    ],
)
def test_what_stays_under_switching(fields: Fields, lyapunov: str, found: InvariantMotion) -> None:
    assert staying_under(fields, lyapunov) is found


@pytest.mark.parametrize(("steps", "alone"), keep(1, [(SIGNAL_STEPS // 2, 1), (SIGNAL_STEPS, 2)]))
def test_each_attracts_where_both_do_not(steps: int, alone: int) -> None:
    """The counterexamples: each field alone is decided, and a signal that takes the better one loses nothing.

    The second field of a pair is a mirror image of the first, so that the first ones are enough.
    """
    pairs: list[Fields] = [
        [["y", "-x - relu(x)*y"], ["y", "-x - relu(-x)*y"]],
        [["y", "-x - y"], ["-y", "x - y"]],
    ]
    for fields in pairs:
        for field in fields[:alone]:
            assert staying_under([field], DISC) is InvariantMotion.NONE
        for field in fields:
            assert lost([field], DISC, steps) > 0.05
    assert lost(pairs[0], DISC, steps) < 1e-6
    starts = np.array([[0.3], [0.0]])  # on y = 0, halves of both rest
    velocities = [np.array(velocity(field, starts)) for field in pairs[1]]
    assert np.allclose(np.mean(velocities, axis=0), 0.0)


@pytest.mark.usefixtures("without_reach")
@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize("lyapunov", keep(1, ["y**2/2 + Abs(x)", None]), ids=["named", "searched"])
def test_the_check_takes_the_principle(lyapunov: str | None) -> None:
    result = decide_system(system_of([["y", "-sign(x) - y**3"], ["y", "-sign(x) - y"]], lyapunov))
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    assert result.check()
    assert {"stability": "asymptotically stable"} in certificate_of(result)["statement"]["claims"]


@few(1)
@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize("fields", [[["y", "-x - y"], ["-y", "x - y"]], [["y", "-x"], ["y", "-x - y"]]], ids=str)
def test_the_check_calls_no_kept_energy_attracting(fields: Fields) -> None:
    assert decide_system(system_of(fields)).verdict is Translation.STABLE


# ---- against signals ------------------------------------------------------------------------------

SWITCHED_FRICTIONS = (
    *("y", "y**3", "sign(y)", "relu(y)", "relu(y - 1/8)", "relu(x)*y", "relu(-x)*y", "x**2*y", "y*Abs(y)", "0"),
    *("relu(-x)*relu(y)", "2*y", "relu(x - 1/8)*y"),
)


def lost(fields: Fields, lyapunov: str, steps: int = SIGNAL_STEPS) -> float:
    """The least share of V that paths lose over several starts, to fields of largest V' and to such at random.

    What is lost is the integral of -V' along a polygon, with V' by differences: nothing where V is kept.
    """
    rng, formulas = np.random.default_rng(5), [text for field in fields for text in field]
    angles = np.linspace(0.2, 6.2, 5)
    x, y = np.tile(0.2 * np.cos(angles), 3), np.tile(0.2 * np.sin(angles), 3)
    greedy = np.arange(len(x)) < len(angles)
    every, start, total = np.arange(len(x)), value(lyapunov, x=x, y=y), np.zeros(len(x))
    for _ in range(steps):
        options = velocity(formulas, (x, y)).reshape(len(fields), 2, -1)
        right, left, above, below = value(lyapunov, x=x + BESIDE_X, y=y + BESIDE_Y)
        falls = np.maximum(((left - right) * options[:, 0] + (below - above) * options[:, 1]) / (2 * NEAR), 0.0)
        taken = np.where(greedy, np.argmin(falls, axis=0), rng.integers(len(fields), size=len(x)))
        total += SIGNAL_STEP * falls[taken, every]
        y = y + SIGNAL_STEP * options[taken, 1, every]
        x = x + SIGNAL_STEP * velocity(formulas[::2], (x, y))[taken, every]
    return float(np.min(total / start))


@few(1)
@pytest.mark.parametrize("seed", range(8))
def test_random_switched_oscillators_against_signals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frictions = rng.choice(SWITCHED_FRICTIONS, size=rng.integers(2, 4), replace=False)
    force, lyapunov = [("x", DISC), ("sign(x)", "Abs(x) + y**2/2")][rng.integers(2)]
    fields = [["y", f"-{force} - {friction}"] for friction in frictions]
    found = staying_under(fields, lyapunov)
    share = lost(fields, lyapunov)
    if found is InvariantMotion.NONE:
        assert share > 1e-4, fields
    if share < 1e-6:
        assert found is not InvariantMotion.NONE, fields


@pytest.mark.parametrize("count", keep(1, [14, 24]))
def test_rests_of_several_fields_against_their_hulls(count: int) -> None:
    """Random affine fields: 0 lies between those that act at a place that is said to rest, or beside it."""
    rng = np.random.default_rng(11)
    counts = {True: 0, False: 0}
    for _ in range(count):
        entries = rng.integers(-3, 4, size=(rng.integers(2, 4), 2, 3)) * np.array([1, 1, 2])
        entries[:, 0, 2] += 3 * rng.integers(0, 2)
        fields = [[f"{a}*x + {b}*y + {c} + sign(x)" for a, b, c in field] for field in entries.tolist()]
        system = system_of(fields)
        place = resting_place(given_cells(system, system.check.radius))
        counts[place is not None] += 1
        if place is None:
            continue
        x, y = map(float, place)
        sides = [np.sign(x)] if x else [-1.0, 1.0]
        affine = entries[:, :, :2] @ np.array([x, y]) + entries[:, :, 2]
        values = np.concatenate([affine + np.array([side, side]) for side in sides])
        angles = np.sort(np.arctan2(values[:, 1], values[:, 0]))
        assert np.diff(angles, append=angles[0] + 2 * np.pi).max() <= np.pi + 1e-9 or not np.all(np.any(values, axis=1))
    assert counts[True] >= 2
    assert counts[False] >= 2


# ---- LaSalle's principle in many states, beside observability of what slides, and paths ----------

ATTRACTS, STAYS = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE
SQUARES = "x**2 + y**2 + z**2"


@few(6)
@pytest.mark.parametrize(
    ("rhs", "lyapunov", "proves"),
    [
        (["y", "-x - y**3 - z", "y - z"], SQUARES, ATTRACTS),
        (["y", "-x - z", "y - z**3"], SQUARES, ATTRACTS),  # seen after two derivatives
        (["y", "-x**3 - y", "-z"], "x**4/2 + y**2 + z**2", ATTRACTS),
        (["y", "-x - sgn(y + z)", "-z - sgn(y + z)"], SQUARES, ATTRACTS),  # y - z does not jump
        (["y", "-x - sgn(y + z)", "-sgn(y + z)"], SQUARES, STAYS),  # slides and oscillates on y + z = 0
        (["y", "-x - sgn(y)", "-z"], SQUARES, STAYS),  # dry friction: a segment of rest
        (["y", "-x + z", "-y - sgn(z)"], SQUARES, STAYS),  # the relay holds z, and x and y oscillate
        (["y", "-x - y**3", "0"], SQUARES, STAYS),
        # on x = 0 one field may be taken alone, so that y or z stays; both together damp both
        (["-x", "-y*(1 + sgn(x))/2", "-z*(1 - sgn(x))/2"], SQUARES, STAYS),
        (["y", "-x", "-z"], SQUARES, STAYS),
        (["y", "-x - relu(y)", "-z"], SQUARES, ATTRACTS),  # V is kept in half the space, which is crossed
        # the pieces of V differ, though its gradient does not jump
        (["y", "-x - relu(x) - y**3", "-z"], "x**2 + relu(x)**2 + y**2 + z**2", ATTRACTS),
    ],
)
def test_what_a_function_proves(rhs: list[str], lyapunov: str, proves: Translation) -> None:
    audited = audit(built(rhs), lyapunov)
    assert (audited.verdict, audited.proves) == (AuditVerdict.VALID, proves)


def test_a_held_relay_keeps_its_oscillation() -> None:
    """The path that the principle must not overlook, and one that it decides."""
    oscillator = built(["y", "-x + z", "-y - sgn(z)"])
    end = simulate(system_field(oscillator, (0.3, 0.0, 0.0)), (0.3, 0.0, 0.0), 40.0).end.state
    assert np.hypot(end[0], end[1]) == pytest.approx(0.3, abs=1e-6)
    decaying = built(["y", "-x - sgn(y + z)", "-z - sgn(y + z)"])
    end = simulate(system_field(decaying, (0.3, 0.0, 0.0)), (0.3, 0.0, 0.0), 40.0).end.state
    assert np.linalg.norm(end) < 1e-3


@pytest.mark.usefixtures("without_reach")
def test_the_check_asks_the_named_v_after_its_searches() -> None:
    result = decide_system(built(["y", "-x**3 - y**3", "-z"], lyapunov="x**4/2 + y**2 + z**2"))
    assert (result.verdict, result.method) == (ATTRACTS, Method.INVARIANCE)
    assert result.function is result.given
    assert result.check()


@pytest.mark.usefixtures("without_reach")
@pytest.mark.usefixtures("strict_search")
def test_the_check_decides_by_the_principle() -> None:
    result = decide_system(built(["y", "-x - z", "y - z**5"]))
    assert (result.verdict, result.method) == (ATTRACTS, Method.INVARIANCE)
    assert result.check()
    stays = decide_system(built(["y", "-x + z", "-y - sgn(z)"]))
    assert stays.verdict is STAYS
    claimed = replace(result.deciding, function=stays.function)
    assert not replace(stays, findings=(*stays.findings, claimed)).check()
    assert not replace(stays, findings=(*stays.findings, result.deciding)).check()


@thorough  # the same systems by certificates: test_second_function.py
@pytest.mark.parametrize("count", keep(1, [8, 30]))
def test_random_dissipative_systems_against_observability(count: int) -> None:
    counts: Counter[tuple[bool, bool]] = Counter()
    for system in dissipative_systems(count):
        audited = audit(built(system.rhs, states=system.states), system.energy)
        if audited.proves is None:
            continue
        counts[audited.proves is ATTRACTS, system.attracts] += 1
        assert audited.proves is not ATTRACTS or system.attracts, system.rhs
    assert counts[True, True] >= count // 8
    assert counts[False, False] >= count // 8
    assert not counts[False, True]  # complete on these
