"""LaSalle's principle: against systems that are known to keep solutions, and against paths of random oscillators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.switched_cells import square_regions
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import scene_cells
from nonsmooth.proofs.systems.findings import KEPT, Method
from nonsmooth.proofs.systems.invariance import Staying, decide_staying, resting_place
from nonsmooth.symbolic.files.system_builder import parse_lyapunov
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.proofs.conftest import Load
from tests.thorough import few, keep, thorough

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


def staying(system: SwitchedSystem, share: int = 1) -> Staying:
    """Of the scene's V, on a part of the checked square."""
    radius = system.check.radius / share
    return decide_staying(system, system.check.lyapunov, radius, scene_cells(system, square_regions(radius)))


@pytest.mark.parametrize(
    ("friction", "potential", "known"),
    keep(8, [
        ("x + y**3", "x**2/2", Staying.NONE),
        ("sign(x) + y", "Abs(x)", Staying.NONE),
        ("sign(x) + sign(y)*y**2", "Abs(x)", Staying.NONE),
        ("x + sign(y)", "x**2/2", Staying.RESTS),  # Coulomb: a segment of rest
        ("x - 4*x**3 + y", "x**2/2 - x**4", Staying.RESTS),  # the pendulum's other equilibrium on the border
        ("x + relu(y - 1/8)", "x**2/2", Staying.CELLS),  # closed orbits below the dead zone
        ("x + y*(x**2 + y**2 - 1/16)**2", "x**2/2", Staying.ARC),  # a limit cycle on the circle where V' = 0
        ("x + y*(1 + sign(x**2 + y**2 - 1/16))", "x**2/2", Staying.CELLS),
        ("x + relu(y)**3", "x**2/2", Staying.NONE),  # a quarter without friction, which solutions cross
        ("x + relu(x)*y", "x**2/2", Staying.NONE),
    ]),
)  # fmt: skip
def test_what_stays(load: Load, friction: str, potential: str, known: Staying) -> None:
    assert staying(with_v(load("y", f"-({friction})"), f"y**2/2 + {potential}")) is known


BANG_BANG = "Abs(x + y*Abs(y)/3) + y**2/2"


def test_a_curve_of_switching_attracts(load: Load) -> None:
    """V bends on a curve, along which solutions of the double integrator switch once: known since Pontryagin."""
    system = with_v(load("y", "-sign(x + y*Abs(y)/3)"), BANG_BANG)
    assert staying(system) is Staying.NONE
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
    assert (resting_place(scene_cells(system, square_regions(system.check.radius))) is not None) is rests


FRICTIONS = (
    *("y", "y**3", "sign(y)", "relu(y)", "relu(y)**3", "relu(y - 1/8)", "relu(x)*y", "relu(x - 1/8)*y", "x**2*y"),
    *("y*Abs(y)", "sign(y)*Abs(x)", "y*(x - 1/4)**2", "relu(-x)*relu(y)", "y*(1 + sign(x - 1/4))"),
)
STEP, STEPS = 1 / 512, 16_384


def energy_lost(force: str, friction: str, potential: str, level: float) -> tuple[float, float]:
    """The share of the energy that a symplectic polygon loses from a start on a level, at least over several starts,
    and the least distance covered in its last quarter: nothing moves at a rest.
    """
    names = {"sign": np.sign, "Abs": np.abs, "relu": lambda a: np.maximum(a, 0.0)}
    slope = compile(f"-({force}) - ({friction})", "slope", "eval")
    energy = compile(f"y**2/2 + {potential}", "energy", "eval")
    angles = np.linspace(0.2, 6.2, 7)
    x, y = 0.2 * np.cos(angles), 0.2 * np.sin(angles)
    for _ in range(80):
        high = eval(energy, names, {"x": x, "y": y}) > level  # noqa: S307 - formulas of this file
        x, y = np.where(high, 0.9 * x, x), np.where(high, 0.9 * y, y)
    first = eval(energy, names, {"x": x, "y": y})  # noqa: S307
    covered = np.zeros_like(x)
    for step in range(STEPS):
        y = y + STEP * eval(slope, names, {"x": x, "y": y})  # noqa: S307
        x = x + STEP * y
        covered += np.abs(STEP * y) * (step > 3 * STEPS // 4)
    last = eval(energy, names, {"x": x, "y": y})  # noqa: S307
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
    if found is Staying.NONE:
        assert lost > 1e-4
        assert moving
    if lost < 1e-6 or not moving:
        assert found is not Staying.NONE


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
    assert not any(own.refutes == KEPT for own in result.findings)
