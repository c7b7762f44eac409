"""Plain switched systems: formulas, surfaces, cells, scene files, and the verdicts on the built-in ones."""

from __future__ import annotations

import warnings
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth.symbolic.files.scene_file
from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import (
    SignChangingRegion,
    TooManyCells,
    fields_by_signs,
    plane,
    sign_on,
    smooth_pieces,
    square_regions,
    system_cells,
    velocities_at,
)
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.findings import Method, PlaneFunction
from nonsmooth.proofs.systems.ray_moves import decide_constant_fan
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems
from nonsmooth.symbolic.files.scene_file import load_any, load_scene, load_system, system_descriptions
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.formulas.surfaces import switching_factors
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import hull_holds_zero
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem, scaled_system, with_rate_ratio
from tests.built_in import decided, planar_systems
from tests.oracles.floats import value, velocity
from tests.proofs.conftest import Load
from tests.thorough import few, keep, thorough


def float_field(scene: SwitchedSystem, x: float, y: float) -> tuple[float, float]:
    """The right-hand side in floats."""
    first, second = velocity([f.text for f in scene.rhs], (x, y), scene.states)
    return float(first), float(second)


# ---- formulas ----------------------------------------------------------------------------------


def smooth(text: str, sign: int) -> str:
    field = NumberField()
    values = {name: Polynomial.variable(field, PLANE, name) for name in PLANE}
    return str(parse_piecewise(text, PLANE).polynomial(values, lambda _: sign))


@pytest.mark.parametrize(
    ("text", "positive", "negative"),
    [
        ("sign(x)", "1", "-1"),
        ("Abs(x - y)", "x - y", "-x + y"),
        ("x*Abs(x)/2 - 0.1", "1/2*x**2 - 1/10", "-1/2*x**2 - 1/10"),
        ("-sqrt(2)/2*sign(x)*(sign(y**2 - x**2) + 1)", "-sqrt(2)", "0"),
        ("Abs(Abs(x) - y)", "x - y", "x + y"),
        ("sign(-2)*x + Abs(-1/2)", "-x + 1/2", "-x + 1/2"),
        ("sign(x - x)", "0", "0"),
        ("relu(x - y)", "x - y", "0"),
        ("sat(2*x, -1, y)", "y", "-1"),
        ("cos(pi/3)*x**3 + +y", "1/2*x**3 + y", "1/2*x**3 + y"),
        ("0.10000000000000000001*x", "10000000000000000001/100000000000000000000*x", None),
    ],
)
def test_smooth_pieces_of_formulas(text: str, positive: str, negative: str | None) -> None:
    assert smooth(text, 1) == positive
    assert negative is None or smooth(text, -1) == negative


@pytest.mark.parametrize(
    "text",
    ["", "x +", "z", "x.real", "x[0]", "relu()", "relu(x, y)", "sat(x, 1)", "sign", "sign()",
     "sign(x, y)", "sign(x=1)", "max(x)", "sqrt(x)",
     "sin(x)", "x**y", "x**-1", "x**1.5", "x**17", "2**x", "x if y else 1", "x < y", "x and y", "lambda: x", "'x'",
     "__import__('os')", "(x := 1)", "x; y", "f'{x}'", "[x]", "-" * 70 + "x", "(" * 300, "x" * 2001, True, None, []],
)  # fmt: skip
def test_refused_formulas(text: object) -> None:
    with warnings.catch_warnings(record=True) as advice:
        warnings.simplefilter("always")
        with pytest.raises(ExpressionError, match=r"(?s)^required .+, received"):
            parse_piecewise(text, PLANE)
    assert advice == []


@pytest.mark.parametrize("text", ["x/y", "x/(y - y)", "1/0*x", "(x**9)**9", "x**16*y", "x/sign(0*x)"])
def test_formulas_that_are_no_polynomials(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"^required .+, received"):
        smooth(text, 1)


FORMULAS = st.recursive(
    st.sampled_from(["x", "y", "2", "0.1", "1/3", "sqrt(2)"]),
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from("+-*"), part).map("({0[0]} {0[1]} {0[2]})".format),
        part.map("sign({})".format),
        part.map("Abs({})".format),
        part.map("-{}".format),
    ),
    max_leaves=6,
)


@pytest.mark.parametrize("number", keep(1, [90, 300]))
def test_random_text_is_refused_or_has_the_value_that_python_gives_it(number: int) -> None:
    field, read, refused = NumberField(), 0, 0
    point = {"x": Fraction(2, 3), "y": Fraction(-5, 7)}
    there = tuple(map(field, point.values()))
    names = {name: float(coordinate) for name, coordinate in point.items()}
    values = {name: Polynomial.variable(field, PLANE, name) for name in PLANE}

    @settings(max_examples=number)
    @given(st.text(alphabet="xy0129+-*/(). signAbsqrt", max_size=30) | FORMULAS)
    def sample(text: str) -> None:
        nonlocal read, refused
        try:
            polynomial = parse_piecewise(text, PLANE).polynomial(values, lambda surface: surface(there).sign())
        except ExpressionError:
            refused += 1
            return
        read += 1
        expected = value(text, **names)  # the parser has read it
        assert float(polynomial(there)) == pytest.approx(float(expected), rel=1e-9, abs=1e-9)

    sample()
    assert min(read, refused) > number // 6


# ---- surfaces ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "sign", "factors"),
    [
        ("x", 1, {"x"}),
        ("-3*x", -1, {"x"}),
        ("y**2 - x**2", -1, {"x + y", "x - y"}),
        ("x*y**3 - x**3*y", -1, {"x", "y", "x + y", "x - y"}),
        ("x**2 - 2*y**2", 1, {"x - sqrt(2)*y", "x + sqrt(2)*y"}),
        ("x**2 + x*y + y**2", 1, set()),
        ("-(x - y)**2*x", -1, {"x"}),
        ("sqrt(2)*(x**2 - y**2)", 1, {"x + y", "x - y"}),
        ("2*y + x*x", 1, {"x**2 + 2*y"}),
        ("(x - 1)*(x**2 + 1)*y", 1, {"x - 1", "x**2 + 1", "y"}),
    ],
)
def test_surfaces_are_split_into_curves(text: str, sign: int, factors: set[str]) -> None:
    field = NumberField()
    values = {name: Polynomial.variable(field, PLANE, name) for name in PLANE}
    split = switching_factors(parse_piecewise(text, PLANE).polynomial(values, lambda _: 1))
    assert split[0] == sign
    assert {str(factor) for factor in split[1]} == factors


@pytest.mark.parametrize("name", planar_systems())
def test_cells_hold_the_field_and_cover_the_plane(name: str) -> None:
    scene = load_system(name)
    cells = plane_cells(scene)
    rng = np.random.default_rng(3)
    for x, y in rng.normal(size=(60, 2)):
        point = (scene.field(Fraction(x)), scene.field(Fraction(y)))
        velocities = velocities_at(cells, point)
        assert len(velocities) == 1  # off the surfaces
        assert [float(v) for v in velocities[0]] == pytest.approx(float_field(scene, x, y), abs=1e-12)


def test_cells_beside_a_curve_are_guarded(load: Load) -> None:
    scene = load("-x + sign(x**2 + y**2 - 1)*y", "-y", radius="2")
    cells = system_cells(scene, square_regions(scene.check.radius))
    rng = np.random.default_rng(5)
    for x, y in rng.uniform(-2, 2, size=(60, 2)):
        point = (scene.field(Fraction(x)), scene.field(Fraction(y)))
        assert [float(v) for v in velocities_at(cells, point)[0]] == pytest.approx(float_field(scene, x, y), abs=1e-12)


def test_values_on_surfaces_are_ignored(load: Load) -> None:
    """The formula says (0, 5) on y = 0; the Filippov set holds the two sides only."""
    scene = load("0", "-sign(y) + 5*(1 - sign(y)**2)")
    zero, one = scene.field.zero, scene.field.one
    assert set(velocities_at(plane_cells(scene), (one, zero))) == {(zero, one), (zero, -one)}


@pytest.mark.parametrize(
    ("vectors", "expected"),
    [
        ([(0, 0)], True),
        ([(1, 2), (-2, -4)], True),
        ([(1, 2), (-2, -3)], False),
        ([(1, 0), (-1, 1), (-1, -1)], True),
        ([(1, 0), (-1, 1), (1, -1), (3, 1)], True),
        ([(1, 0), (0, 1), (1, 1)], False),
        ([], False),
    ],
)
def test_hulls_that_hold_zero(vectors: list[tuple[int, int]], expected: bool) -> None:
    field = NumberField()
    assert hull_holds_zero([(field(a), field(b)) for a, b in vectors]) is expected


# ---- scene files -------------------------------------------------------------------------------


def test_defaults_and_displacement(load: Load) -> None:
    scene = load("-x + 1", "-y")
    assert scene.name == "my"
    assert scene.check.lyapunov.text == "x**2 + y**2"
    assert [str(p) for p in scene.velocity(lambda _: 1)] == ["-x + 1", "-y"]
    moved = load("-x + 1", "-y", equilibrium="[1, 0]")
    assert [str(p) for p in moved.velocity(lambda _: 1, moved.displaced(PLANE))] == ["-x", "-y"]


def test_arrays_and_systems_are_told_apart(tmp_path: Path) -> None:
    assert isinstance(load_any("four-wheel", radius="1/3"), Scene)
    system = load_any("flower", radius="1/3", at="1,2")
    assert isinstance(system, SwitchedSystem)
    assert system.check.radius == Fraction(1, 3)
    assert system.check.equilibrium[1] == 2
    with pytest.raises(SceneError, match="an array of wheels"):
        load_scene("flower")
    with pytest.raises(SceneError, match="plain switched system"):
        load_system("four-wheel")
    with pytest.raises(SceneError, match=r"contact\.rule"):
        load_any("flower", rule="box")
    (tmp_path / "deep.toml").write_text("x = " + "[" * 5000, encoding="utf-8")
    with pytest.raises(SceneError, match="brackets"):
        load_any(tmp_path / "deep.toml")


def test_names_and_descriptions_of_built_in_systems() -> None:
    folder = Path(str(nonsmooth.symbolic.files.scene_file.__file__)).parents[1] / "scenes" / "systems"
    assert sorted(builtin_systems()) == sorted(path.stem for path in folder.glob("*.toml"))
    assert not set(builtin_systems()) & set(builtin_scenes())
    descriptions = system_descriptions()
    assert tuple(descriptions) == builtin_systems()
    assert all(10 < len(text) < 110 and "\n" not in text for text in descriptions.values())


# What Python cannot ask; other cases are rows of tests/golden/rows.toml.
MALFORMED = [
    ('[system]\nstates = ["x", "y"]', "system.rhs", "formulas, or [[region]] tables, received neither"),
    ('[system]\nrhs = ["x", "y"]', "system.states", "a value"),
    ('[system]\nstates = ["x", "y"]\nrhs = ["x", "y"]\nmodes = 2', "system.modes", "states, rhs"),
    ('system = 3', "system", "a table"),
    ('[system]\nstates = ["x", "y"]\nrhs = ["x", "y"]\n[friction]\nmu_roll = 1', "friction", "one of the keys"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "key", "words"), MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_systems(tmp_path: Path, text: str, key: str, words: str) -> None:
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_any(tmp_path / "my.toml")
    line = str(caught.value)
    assert line.isprintable()
    assert f"my.toml: {key}: required" in line
    assert words in line


def test_a_division_by_zero_on_some_cell_only(load: Load) -> None:
    scene = load("x/(1 + sign(x)*sign(y))", "y")
    with pytest.raises(SceneError, match=r"system\.rhs\[1\]: required a finite number"):
        decide_system(scene)


@thorough  # the small one: test_cells_hold_the_field_and_cover_the_plane
def test_too_many_surfaces(load: Load) -> None:
    lines = "*".join(f"(x - {k}*y - {k * k})" for k in range(1, 9))
    scene = load(f"sign({lines})*sign({lines.replace('-', '+')})", "-y", radius="100")
    with pytest.raises(SceneError, match="cells"):
        list(system_cells(scene, plane(scene) * 3))


# ---- verdicts ----------------------------------------------------------------------------------


def verdict(scene: SwitchedSystem) -> StabilityResult:
    result = decide_system(scene)
    assert result.check()
    return result


@pytest.mark.parametrize(
    ("name", "expected", "method"),
    [
        ("relay-oscillator", Translation.STABLE, Method.FAN),
        ("relay-oscillator-damped", Translation.ASYMPTOTICALLY_STABLE, Method.LYAPUNOV),
        ("flower", Translation.ASYMPTOTICALLY_STABLE, Method.LYAPUNOV),
        ("escaping-slide", Translation.UNSTABLE, Method.EQUILIBRIUM),
        ("line-of-equilibria", Translation.STABLE, Method.FAN),
        ("eq-3", Translation.STABLE, Method.FAN),
        ("eq-4", Translation.ASYMPTOTICALLY_STABLE, Method.LYAPUNOV),
    ],
)
def test_built_in_systems(name: str, expected: Translation, method: Method) -> None:
    result = decided(name)
    assert result.check()
    assert (result.verdict, result.method) == (expected, method)
    assert result.reach.everywhere == (expected is Translation.ASYMPTOTICALLY_STABLE)
    fails = name == "escaping-slide"
    assert result.equilibrium is (Equilibrium.FAILS if fails else Equilibrium.HOLDS)


@pytest.mark.usefixtures("without_reach")
@few(4)
@pytest.mark.parametrize(
    ("first", "second", "check", "expected", "words"),
    [
        ("-x", "-y", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
        ("y", "-x - y", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),  # V = |c|^2 does not: another is found
        ("y", "-x", {}, Translation.STABLE, "V' = 0"),
        ("x", "-y", {}, Translation.UNSTABLE, "runs outward along the ray through (1, 0)"),
        ("x - y", "x + y", {}, Translation.UNSTABLE, "grows along every solution"),
        ("x/10 - y*(2 + sign(x*y))", "x*(2 - sign(x*y)) + y/10", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
        ("-x/10 - y*(2 - sign(x*y))", "x*(2 + sign(x*y)) - y/10", {}, Translation.UNSTABLE, "grows along every"),
        ("y + x**3", "-x + y**3", {}, Translation.UNSTABLE, "grows along every"),
        ("y", "-x + x**2", {}, Translation.STABLE, "keep V, as V' = 0"),  # a centre
        ("-x**3", "-y**3", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
        ("-x + x**2", "-y", {"radius": "2"}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),  # on a smaller square
        ("-x + sign(x**2 + y)*y", "-y - sign(x**2 + y)*x", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
        ("-sign(x - 1)", "-sign(y - 2)", {"equilibrium": "[1, 2]"}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
        ("-sign(x - 1)", "-sign(y)", {}, Translation.UNSTABLE, "0 is not in F"),
        ("1", "-y", {}, Translation.UNSTABLE, "0 is not in F"),
        ("y - x*Abs(x)", "-x - y*Abs(y)", {}, Translation.ASYMPTOTICALLY_STABLE, "decreases"),
    ],
)
def test_verdicts(
    load: Load, first: str, second: str, check: dict[str, str], expected: Translation, words: str
) -> None:
    result = verdict(load(first, second, **check))
    assert result.verdict is expected
    assert words in result.reason


TRAPS = [
    ("0", "-sign(y)"),
    ("0", "-y"),
    ("0", "-y**3"),  # cubic
    ("0", "-sign(y)*y**2"),
    ("-x*y**2", "-sign(y)"),  # cubic in each cell
    ("-x**3*Abs(y)", "-y"),
    ("-sign(x)*y**2", "-sign(y)"),
    ("-x*Abs(x - y)", "-y*Abs(x - y)"),  # the diagonal rests
    ("-x*Abs(x - y)*Abs(x + 2*y)", "-y*Abs(x - y)*Abs(x + 2*y)"),
    ("-x**3*(sign(y) + 1)", "-y**3*(sign(y) + 1)"),  # the lower half-plane rests
    ("-Abs(y)*sign(x)", "0"),
    ("-x*(y - x**2)**2", "-y*(y - x**2)**2"),  # a curve rests
]  # fmt: skip


@pytest.mark.usefixtures("without_reach")
@few(2)
@pytest.mark.parametrize(("first", "second"), keep(6, TRAPS))
def test_negative_in_open_cells_only_is_not_asymptotic(load: Load, first: str, second: str) -> None:
    """V' < 0 inside (nearly) every cell, but not on closed ones: there are equilibria arbitrarily near."""
    for lyapunov in ("x**2 + y**2", "x**2 + 2*y**2", "Abs(x) + Abs(y)"):
        result = verdict(load(first, second, lyapunov=f'"{lyapunov}"'))
        assert result.verdict in (Translation.STABLE, Translation.UNDECIDED)


def test_the_flower_needs_a_piecewise_quadratic() -> None:
    result = decided("flower")
    assert isinstance(result.given, PlaneFunction)
    witness = result.given.witness
    assert witness is not None
    assert witness.value is not None
    assert witness.value.sign() > 0  # |x|^2 grows there
    x, y = (float(v) for v in witness.point)
    modes = [((-0.1, 1), (-5, -0.1)), ((-0.1, 5), (-1, -0.1))]  # |x| >= |y|, and the rest
    near = modes if abs(x) == abs(y) else [modes[abs(x) < abs(y)]]
    rates = [2 * (x * (a * x + b * y) + y * (c * x + d * y)) for (a, b), (c, d) in near]
    assert any(float(witness.value) == pytest.approx(rate) for rate in rates)
    assert isinstance(result.function, PlaneFunction)
    assert len({str(cell.potential) for cell in result.function.result.cells}) > 1


def simulated_distance(scene: SwitchedSystem, start: tuple[float, float], time: float, steps: int) -> float:
    """Distance from the origin at the end, by Euler's method (it chatters along sliding surfaces)."""
    x, y = start
    for _ in range(steps):
        f, g = float_field(scene, x, y)
        x, y = x + f * time / steps, y + g * time / steps
    return float(np.hypot(x, y))


@few(1)
@pytest.mark.parametrize("starts", keep(1, [2, 4]))
@pytest.mark.parametrize("name", ["relay-oscillator-damped", "flower", "eq-4"])
def test_asymptotically_stable_systems_contract(name: str, starts: int) -> None:
    scene = load_system(name)
    for angle in np.linspace(0.1, 6.2, starts):
        start = (0.5 * float(np.cos(angle)), 0.5 * float(np.sin(angle)))
        assert simulated_distance(scene, start, 30 if name == "flower" else 3, 6000) < 0.2


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize(("seed"), range(25))
def test_lyapunov_functions_never_contradict_the_complete_fan(load: Load, seed: int) -> None:
    """Two independent ways for constant fields: inequalities for V, and the moves of the fan."""
    rng = np.random.default_rng(seed)
    a, b, c, d = rng.integers(-3, 4, 4)
    p, q = rng.integers(0, 4, 2)
    first = f"-{p}*sign(x) + ({a})*sign(y) + ({c})*sign(x)*sign(x**2 - y**2)"
    second = f"-{q}*sign(y) + ({b})*sign(x) + ({d})*sign(y)*sign(x**2 - y**2)"
    texts = ["Abs(x) + Abs(y)", "x**2 + y**2", "2*Abs(x) + Abs(y - x/2)", "Abs(x) + Abs(y) + Abs(Abs(x) - Abs(y))"]
    for text in texts:
        point = PlanePoint(load(first, second, lyapunov=f'"{text}"'))
        fan = decide_constant_fan(plane_cells(point.system))
        assert fan is not None
        assert point.given is not None
        if point.given.decrease is Decrease.STRICT:
            assert fan.verdict is Translation.ASYMPTOTICALLY_STABLE
        if point.given.decrease is Decrease.WEAK:
            assert fan.verdict is not Translation.UNSTABLE
        if point.rays:
            assert fan.verdict is not Translation.ASYMPTOTICALLY_STABLE
    verdict(load(first, second))


@pytest.mark.parametrize("name", planar_systems())
def test_modes_by_sign_pattern(name: str) -> None:
    """Only patterns that occur are kept, and at random points each gives the field of the formulas."""
    scene = load_system(name)
    surfaces, modes = fields_by_signs(scene)
    expected = {"eq-3": 8, "eq-4": 8, "flower": 4, "escaping-slide": 2, "line-of-equilibria": 2, "stick-slip": 2}
    assert len(modes) == expected.get(name, 4)
    rng = np.random.default_rng(9)
    for x, y in rng.normal(size=(40, 2)):
        point = (scene.field(Fraction(x)), scene.field(Fraction(y)))
        f, g = modes[tuple(surface(point).sign() for surface in surfaces)]
        assert (float(f(point)), float(g(point))) == pytest.approx(float_field(scene, x, y), abs=1e-12)


def test_patterns_that_no_point_has_are_left_out(load: Load) -> None:
    surfaces, modes = fields_by_signs(load("-sign(x - 1)*sign(x + 1)", "-sign(y)*sign(x**2 + y**2 + 1)"))
    assert {str(surface) for surface in surfaces} >= {"x - 1", "x + 1", "y"}
    assert len(modes) == 6  # not x < -1 and x > 1


def pieces_in_depth(waiting: list[Region], evaluate: Any) -> list[tuple[Region, Any]]:
    """The slow literal definition: each region is cut until it is settled before the next one is looked at."""
    pieces = []
    waiting = waiting[::-1]
    while waiting:
        region = waiting.pop()
        try:
            pieces.append((region, evaluate(partial(sign_on, region))))
        except SignChangingRegion as unsettled:
            waiting += list(region.split(unsettled.surface))[::-1]
    return pieces


@pytest.mark.parametrize(
    "formulas",
    [
        ("-sign(x) - Abs(x - 2*y)", "-sign(y + x/3 - 1/4)*Abs(x - 1/2)"),
        ("-sign(x - y**2) + sign(y - x**3)", "-y*sign(x*y - 1/9) - sign(x + y**2)"),
        ("Max(x, y, -x - y)", "Min(x - y, 1/3)*sign(x**2 + y**2 - 1)"),
    ],
)
def test_cells_are_those_of_cutting_one_after_the_other(load: Load, formulas: tuple[str, str]) -> None:
    scene = load(*formulas)
    states = scene.displaced(PLANE)
    regions = square_regions(scene.check.radius)
    pieces = smooth_pieces(regions, lambda sign_of: scene.velocity(sign_of, states))
    assert pieces == pieces_in_depth(list(regions), lambda sign_of: scene.velocity(sign_of, states))


def test_too_many_cells_are_noticed_before_they_are_found(load: Load) -> None:
    scene = load("-" + " - ".join(f"sign(x*{k} - y**2)" for k in range(1, 30)), "-y")
    states = scene.displaced(PLANE)
    asked: list[Any] = []

    def evaluate(sign_of: Any) -> Any:
        asked.append(sign_of)
        return scene.velocity(sign_of, states)

    with pytest.raises(TooManyCells):
        smooth_pieces(square_regions(scene.check.radius), evaluate, 50)
    assert len(asked) <= 2 * 50


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize(("length", "speed", "rates"), [(1, -9, 0), (1, 9, 0), (1, 0, -6), (-9, 0, 0)])
def test_units_and_uneven_rates_do_not_hide_a_piecewise_quadratic_function(length: int, speed: int, rates: int) -> None:
    scene = scaled_system(load_system("flower"), Fraction(10) ** length, Fraction(10) ** speed)
    result = verdict(with_rate_ratio(scene, Fraction(10) ** rates))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
