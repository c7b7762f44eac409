"""Somebody else's Lyapunov function, and published functions and regions, audited exactly."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.larger_region import find_larger_region
from nonsmooth.proofs.system_audit import AuditResult, AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import Refutation
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.conftest import Arrays
from tests.oracles.floats import value, velocity
from tests.plain import built
from tests.proofs.published_regions import (
    GUIDE,
    GUIDE_POTENTIAL,
    HYPERBOLA,
    NO_POLYNOMIAL,
    PUBLISHED,
    VAN_DER_POL,
    Published,
    area,
    exact_level,
    published_cells,
    system_of,
)
from tests.thorough import few, keep, thorough

# ---- Somebody else's Lyapunov function: valid, invalid with a witness that anyone can re-evaluate, or undecided.

DIFFERENCE = 1e-6  # step of the numerical gradients below (length)
DECREASING = [11, 13, 17, 19, 28, 29, 33, 43]  # random arrays on which the random V of the same seed never grows
BESIDE = 1e-9  # how far outside a cell a witness on its side may be rounded (length)


def audited(scene: Scene | SwitchedSystem, lyapunov: str) -> AuditResult:
    result = audit(scene, lyapunov)
    assert (result.witness is None) == (result.verdict is not AuditVerdict.INVALID)
    return result


def float_potential(text: str) -> Callable[[float, float], float]:
    """V in floats."""
    return lambda x, y: float(value(text, x=x, y=y))


def partition_of(scene: Scene) -> Partition:
    build = build_nearest_partition if scene.contact.rule == "nearest" else build_box_partition
    return build(scene.recentred())


def rates_at(scene: Scene, lyapunov: str, point: tuple[float, float]) -> list[float]:
    """``grad V . (v + omega J c)`` for the cells that hold a point.

    V is differentiated numerically a little inside each cell, so that kinks do no harm.
    """
    potential = float_potential(lyapunov)
    rates = []
    for cell in partition_of(scene).cells:
        vertices = np.array([[float(v) for v in p] for p in cell.polygon.vertices])
        sides = [(*(float(n) for n in side.normal), float(side.offset)) for side in cell.polygon.sides]
        if any(a * point[0] + b * point[1] > c + BESIDE for a, b, c in sides):
            continue
        inward = [*(vertices - point), vertices.mean(axis=0) - point]
        for (x, y), twist in product(np.array(point) + 1e-4 * np.array(inward), cell.twists):
            f = float(twist.vx) - float(twist.omega) * y
            g = float(twist.vy) + float(twist.omega) * x
            rates.append((potential(x + f * DIFFERENCE, y + g * DIFFERENCE) - potential(x, y)) / DIFFERENCE)
    return rates


def refutes(scene: Scene, lyapunov: str, witness: Refutation) -> None:
    """The witness, re-evaluated in floats from the array's own cells."""
    x, y = (float(v) for v in witness.point)
    if witness.meaning == "V is not positive":
        assert float_potential(lyapunov)(x, y) == pytest.approx(float(witness.value or 0), abs=1e-9)
        assert float(witness.value or 0) <= 0
        return
    assert witness.meaning == "the derivative of V is positive"
    assert witness.value is not None
    assert float(witness.value) > 0
    rates = rates_at(scene, lyapunov, (x, y))
    assert any(rate == pytest.approx(float(witness.value), rel=1e-2, abs=1e-2) for rate in rates)


# ---- arrays ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "lyapunov", "proves"),
    [
        ("four-wheel", "x**2 + y**2", Translation.ASYMPTOTICALLY_STABLE),
        ("four-wheel", "1.000001*x**2 + 0.999999*y**2 - 1.2e-7*x*y", Translation.ASYMPTOTICALLY_STABLE),
        ("four-wheel", "Abs(x) + Abs(y)", Translation.ASYMPTOTICALLY_STABLE),
        ("four-wheel", "(x**2 + y**2)**2", Translation.ASYMPTOTICALLY_STABLE),
        ("four-wheel-side", "x**2 + y**2", Translation.STABLE),
        ("four-wheel-side", "Abs(x) + Abs(y)", Translation.STABLE),
        ("ring-5", "x**2 + 1.1*y**2", Translation.ASYMPTOTICALLY_STABLE),
        ("grid-4x4", "x**2 + y**2", Translation.ASYMPTOTICALLY_STABLE),
        ("conveyor-3", "x**2 + y**2", Translation.STABLE),
    ],
)
def test_valid_on_arrays(name: str, lyapunov: str, proves: Translation) -> None:
    result = audited(load_scene(name), lyapunov)
    assert (result.verdict, result.proves) == (AuditVerdict.VALID, proves)
    assert result.verdict.exit_status == 0


@few(1)
@pytest.mark.parametrize(
    ("name", "lyapunov"),
    [
        ("saddle", "x**2 + y**2"),
        ("outward", "x**2 + y**2"),
        ("spiral-30", "x**2 + 2.5*y**2"),
        ("four-wheel-side", "x**2 + 2.5*y**2 + 0.1*x*y"),
        ("four-wheel", "x**2 - 1e-9*y**2"),
        ("four-wheel", "x**2 + 2*x*y + y**2"),
        ("four-wheel", "x**2 + y**2 + 30*x**3"),
        ("four-wheel", "x**2 + y**2 + 1.5*x**3"),
        ("off-center", "Abs(x) + Abs(y)"),
        ("conveyor-3", "Abs(x) + Abs(y)"),
    ],
)
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_invalid_on_arrays_with_a_witness(name: str, lyapunov: str, rule: str) -> None:
    scene = load_scene(name, rule=rule)
    result = audited(scene, lyapunov)
    if (name, rule) == ("four-wheel-side", "box"):  # there the body rests on the whole square, which is kind to any V
        assert (result.verdict, result.proves) == (AuditVerdict.VALID, Translation.STABLE)
        return
    assert result.verdict is AuditVerdict.INVALID
    assert result.verdict.exit_status == 1
    assert result.witness is not None
    assert all(isinstance(v, Number) for v in (*result.witness.point, result.witness.value))  # for JSON
    refutes(scene, lyapunov, result.witness)


@few(1)
@pytest.mark.parametrize("name", keep(9, builtin_scenes()))
@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_agrees_with_the_translation_clause(name: str, rule: str) -> None:
    """For V = |c|^2 the rotation drops out: the rates at the vertices decide, whatever the audit does."""
    scene = load_scene(name, rule=rule)
    result = audited(scene, "x**2 + y**2")
    worst = decide_translation(partition_of(scene)).worst
    expected = {1: AuditVerdict.INVALID}.get(worst.sign(), AuditVerdict.VALID)
    assert result.verdict is expected
    if worst.sign() < 0:
        assert result.proves is Translation.ASYMPTOTICALLY_STABLE


@few(1)
@pytest.mark.parametrize("seed", [*DECREASING, *range(11)])
def test_random_arrays_against_sampled_rates(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    rng = np.random.default_rng(seed)
    lyapunov = f"x**2 + {rng.integers(1, 5)}*y**2/2 + {rng.integers(-2, 3)}*x*y/4 + {rng.integers(-2, 3)}*x*y**2/8"
    result = audited(scene, lyapunov)
    assert result.verdict is not AuditVerdict.UNDECIDED
    assert (result.witness is None) == (seed in DECREASING)
    if result.witness is not None:
        refutes(scene, lyapunov, result.witness)
        return
    radius = float(scene.check.radius)
    for x, y in rng.uniform(-radius, radius, size=(60, 2)):
        assert max(rates_at(scene, lyapunov, (x, y))) < 1e-4
        assert float_potential(lyapunov)(x, y) > 0


def test_v_is_measured_from_the_equilibrium() -> None:
    scene = load_scene("four-wheel", at="1/8,0", radius="1/16")
    assert audited(scene, "x**2 + y**2").verdict is AuditVerdict.INVALID  # the array drifts away from there
    assert audited(load_scene("four-wheel"), "(x - 1/8)**2 + y**2").verdict is AuditVerdict.INVALID


def test_rotation_matters_unless_v_is_round() -> None:
    """The exact pose rate v + omega J c turns a point about the origin: only |c|^2 does not feel it."""
    scene = load_scene("conveyor-3")
    cell = partition_of(scene).cells[0]
    assert cell.twists[0].omega
    assert audited(scene, "x**2 + y**2").verdict is AuditVerdict.VALID
    assert audited(scene, "x**2 + 1.01*y**2").verdict is AuditVerdict.INVALID


def test_rule_ellipse_is_not_audited() -> None:
    result = audited(load_scene("four-wheel", rule="ellipse"), "x**2 + y**2")
    assert result.verdict is AuditVerdict.UNDECIDED
    assert result.verdict.exit_status == 3
    assert "ellipse" in result.reason


# ---- plain systems -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "lyapunov", "verdict", "proves"),
    [
        ("relay-oscillator", "Abs(x) + Abs(y)", AuditVerdict.VALID, Translation.STABLE),
        ("relay-oscillator", "x**2 + y**2", AuditVerdict.INVALID, None),
        ("relay-oscillator-damped", "Abs(x) + Abs(y)", AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
        ("relay-oscillator-damped", "Abs(x) + 0.999*Abs(y)", AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
        ("relay-oscillator-damped", "Abs(x) + 3*Abs(y)", AuditVerdict.INVALID, None),
        ("flower", "x**2 + y**2", AuditVerdict.INVALID, None),
        (
            "flower",
            "(x**2 + y**2)*3 + 2*Abs(x**2 - y**2)",
            AuditVerdict.VALID,
            Translation.ASYMPTOTICALLY_STABLE,
        ),
        ("eq-4", "(Abs(x) + Abs(y) + Abs(Abs(x) - Abs(y)))/2", AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
        ("eq-3", "x**2 + y**2", AuditVerdict.VALID, Translation.STABLE),
        ("line-of-equilibria", "x**2 + y**2", AuditVerdict.VALID, Translation.STABLE),
        ("escaping-slide", "x**2 + y**2", AuditVerdict.INVALID, None),
    ],
)
def test_plain_systems(name: str, lyapunov: str, verdict: AuditVerdict, proves: Translation | None) -> None:
    result = audited(load_system(name), lyapunov)
    assert (result.verdict, result.proves) == (verdict, proves)


@pytest.mark.parametrize("drift", ["0", "-x*y**2"])
@pytest.mark.parametrize("guard", ["(y - x**2)*(y + x**2)", "(y - x**2)*(y + 2*x**2)"])
def test_a_line_of_rest_between_curves_does_not_attract(drift: str, guard: str) -> None:
    """All points of ``y = 0`` rest, inside cells whose guards are negative or positive there."""
    system = built([drift, f"-y*(2 + sign({guard}))"])
    result = audited(system, "x**2 + y**2")
    assert (result.verdict, result.proves) == (AuditVerdict.VALID, Translation.STABLE)
    assert decide_system(system).verdict is Translation.STABLE


def test_a_rise_at_a_corner_of_the_cube_is_met() -> None:
    """``V' = -2 (x^2 + y^2 + z^2) (2999/1000 - x - y - z)`` is positive near (1, 1, 1) only, where samples miss it."""
    rhs = [f"-{name}*(2999/1000 - x - y - z)" for name in "xyz"]
    result = audited(built(rhs, radius="1"), "x**2 + y**2 + z**2")
    assert result.verdict is AuditVerdict.INVALID
    assert result.witness is not None
    assert sum(result.witness.point) > Fraction(2999, 1000)
    assert result.witness.value > 0


def test_states_name_the_variables_of_v(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text('[system]\nstates = ["a1", "b"]\nrhs = ["-a1", "-b"]\n', encoding="utf-8")
    scene = load_system(tmp_path / "my.toml")
    assert audited(scene, "a1**2 + b**2").verdict is AuditVerdict.VALID
    with pytest.raises(SceneError, match="lyapunov"):
        audit(scene, "x**2 + y**2")


# ---- text --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lyapunov",
    ["", "x**2 + z**2", "x**2/y", "exp(x)", "x**2 + theta**2", "__import__('os')", "1/0", "x**99", "cos(pi/7)*x**2"],
)
def test_refused_text(lyapunov: str) -> None:
    for scene in (load_scene("four-wheel"), load_system("eq-4")):
        with pytest.raises(SceneError, match=r"lyapunov: required .+, received"):
            audit(scene, lyapunov)


def test_angles_of_the_scene_are_allowed() -> None:
    assert audited(load_scene("ring-5"), "x**2 + 4*cos(pi/5)**2*y**2/3").verdict is not AuditVerdict.UNDECIDED
    assert audited(load_scene("four-wheel"), "x**2 + 2*cos(pi/12)*y**2").verdict is AuditVerdict.VALID


def test_squares_show_high_degrees_in_the_plane() -> None:
    """A function of degree ten along its gradient, times squares: V' has no sign on small parts beside the axes."""
    rhs = ["-30*x**11 - 30*x**6*y**2", "-40*x**2*y**3 - 12*x**7*y"]
    system = built(rhs)
    lyapunov = "3*x**10 + 10*y**4 + 6*x**5*y**2"
    found = audited(system, lyapunov)
    assert found.verdict is AuditVerdict.VALID
    assert found.proves is Translation.STABLE  # all points of the line x = 0 are equilibria
    assert audited(system, f"{lyapunov} - x**4").verdict is AuditVerdict.INVALID


# ---- Published Lyapunov functions and regions, audited exactly; the search for larger regions against paths.


@pytest.mark.parametrize("published", PUBLISHED, ids=lambda published: published.name)
def test_a_published_level_is_certified_and_the_largest_is_the_limit(published: Published) -> None:
    found = exact_level(system_of(published))
    assert found is not None
    assert found.level >= published.level
    assert float(found.level) <= published.limit + 1e-5
    assert found.point is not None
    if np.isfinite(published.limit):  # else the border of the square refutes larger levels
        assert found.level == pytest.approx(published.limit, rel=1e-3)
        assert found.refuted == pytest.approx(published.limit, rel=1e-3)
        x, y = map(float, found.point)
        slope = velocity(gradient(published.potential), (x, y)) @ velocity(published.rhs, (x, y))
        assert slope > -1e-9
    else:
        assert found.level == published.radius**2


def gradient(potential: str) -> tuple[str, str]:
    return {"x**2 + y**2": ("2*x", "2*y"), "3*x**2/2 - x*y + y**2": ("3*x - y", "2*y - x")}[potential]


@pytest.mark.parametrize("name", keep(1, [NO_POLYNOMIAL.name, VAN_DER_POL.name]))
def test_a_point_refutes_the_next_level(name: str) -> None:
    system = system_of(next(published for published in PUBLISHED if published.name == name))
    found, cells = exact_level(system), published_cells(system)
    assert found is not None
    assert found.refuted is not None
    assert found.point is not None
    here = [cell for cell in cells if cell.region.contains(found.point)]
    assert any(not cell.potential(found.point) > found.refuted for cell in here)
    rises = any(not rate(found.point) < 0 for cell in here for rate in cell.rates)
    assert rises or max(map(abs, found.point)) == found.radius


def test_the_v_of_the_guide_of_sostools_is_proved() -> None:
    system = ns.System(["x", "y", "z"], GUIDE, radius=2, lyapunov=GUIDE_POTENTIAL).system
    assert audit(system, GUIDE_POTENTIAL).proves is Translation.ASYMPTOTICALLY_STABLE
    result = decide_system(system)
    assert result.reach.region is not None
    assert Fraction(69, 10) < result.reach.region.level <= 4 * Fraction(17945, 10_000)
    assert result.check()


@thorough  # a region that is not there, and forged levels, are refused above and below
@pytest.mark.parametrize(("published", "degree", "least"), [(VAN_DER_POL, 2, 6.2), (HYPERBOLA, 4, 5.5)])
def test_a_larger_region_is_certified(published: Published, degree: int, least: float) -> None:
    """Paths from all over it come home."""
    system = system_of(published)
    region = find_larger_region(system, degree)
    assert region is not None
    level, text = region.region.level, region.formula.text
    assert area(text, float(level), published.radius) > least
    rng = np.random.default_rng(0)
    starts = [p for p in rng.uniform(-published.radius, published.radius, (60, 2)) if below(text, p, float(level))]
    assert len(starts) > 8
    for start in starts[:8]:
        path = ns.System(["x", "y"], list(published.rhs)).simulate(start.tolist(), 30.0).trajectory
        assert np.abs(path.at(30.0)).max() < 1e-2


def below(text: str, point: NDArray[np.float64], level: float) -> bool:
    return bool(value(text, x=point[0], y=point[1]) < level)


def test_no_region_where_nothing_comes_back() -> None:
    assert ns.System(["x", "y"], ["x", "-y"]).larger_region(2) is None


def test_a_region_is_found_in_a_line_of_python() -> None:
    """The disc of a contraction, whose level sets fill the square."""
    system = ns.System(["x", "y"], ["-x", "-y"])
    region = system.larger_region(2)
    assert region is not None
    assert repr(region).startswith(f"{region.region} on the square of half-width 1/2 about the point with V = ")


# ---- In one state: the verdicts, and V and V' at many places -------------------------------------

ON_A_LINE = [
    ("-x", "x**2", "valid"),
    ("-sign(x)", "Abs(x) + x/2", "valid"),
    ("-x + x**2", "x**2", "valid"),
    ("-relu(x)", "x**2", "valid"),
    ("-x/(1 + x**2)", "x**2 - x**3", "valid"),
    ("-sin(x)", "x**2", "valid"),
    ("-sign(x)*(1 + sign(x - 1/4))", "x**2", "valid"),
    ("-x + 4*x**2", "x**2", "invalid"),
    ("-x", "x**2*(x - 1/4)**2", "invalid"),
    ("2 - sign(x)", "Abs(x)", "invalid"),
    ("-x", "x**2 + 1", "invalid"),
    ("-x", "sqrt(2)*x**2", "undecided"),
]


@pytest.mark.parametrize(("rhs", "lyapunov", "verdict"), ON_A_LINE)
def test_audits_in_one_state(rhs: str, lyapunov: str, verdict: str) -> None:
    result = audit(ns.System(["x"], [rhs]).system, lyapunov)
    assert result.verdict == verdict
    places = np.linspace(-0.5, 0.5, 801)[1::2]  # none is zero
    step = 1e-6
    rates = (value(lyapunov, x=places + step) - value(lyapunov, x=places - step)) / (2 * step) * value(rhs, x=places)
    holds = bool((value(lyapunov, x=places) > 0).all() and rates.max() <= 1e-8) and value(lyapunov, x=0.0) == 0
    assert verdict == "undecided" or holds == (verdict == "valid")
