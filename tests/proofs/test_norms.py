"""Roots of sums of squares: their bounds, formulas that are affine in them, verdicts, and paths in floats."""

from __future__ import annotations

import ast
from fractions import Fraction
from random import Random
from types import CodeType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.symbolic.formulas.norms import RATIONAL, affine_in_norms, named_norms
from nonsmooth.symbolic.formulas.trees import float_value, formula_tree, written
from nonsmooth.symbolic.formulas.unit_vectors import UnitEntry, with_unit_entries
from tests.plain import decided_with_certificate, stated
from tests.thorough import but, few, keep

ATTRACTS, LEAVES = "asymptotically stable", "unstable"
ATTRACTS_AND_NOT_SCALED = {
    "y - 2*x/sqrt(x**2 + y**2) + z; -x - 2*y/sqrt(x**2 + y**2); -z + x": 1.0,  # the norm is zero on a line
    "y; -y - 2*(x + y)/sqrt((x + y)**2)": 1.0,
    "-x + y; x - 2*y/sqrt(y**2 + 9*z**2); x - 6*z/sqrt(y**2 + 9*z**2)": 1 / 64,
    "-x/sqrt(x**2) + y; -y": 1.0,
    "-x + y; x - 2*y/sqrt(y**2/3 + 2*z**2); x - 2*z/sqrt(y**2/3 + 2*z**2)": 1 / 64,
}
N, OBLIQUE = "sqrt(x**2 + y**2)", "sqrt((x + y)**2 + 4*(x - 2*y)**2)"

DECIDED = {
    f"y - x/{N}; -x - y/{N}": ATTRACTS,
    f"x + 2*y - 2*x/{N}; -x/2 + y - 2*y/{N}": ATTRACTS,  # unit control of an unstable plant (Gutman 1979)
    f"(-x + 20*y)/{N}; (-y - 20*x)/{N}": ATTRACTS,
    "-10*x/sqrt((10*x)**2 + y**2); -y/sqrt((10*x)**2 + y**2)": ATTRACTS,  # a normalized gradient (Cortes 2006)
    f"y - x*{N}; -x - y*{N}": ATTRACTS,
    f"(x - y)/{OBLIQUE}; (x + y)/{OBLIQUE}": LEAVES,
    f"y + x*{N}; -x + y*{N}": LEAVES,
    f"-2*x/({N} + 1/10) + x; -2*y/({N} + 1/10) + y": ATTRACTS,  # within a boundary layer
    "y; -x/sqrt(1 + x**2) - y": ATTRACTS,
    "y; 1 - sqrt((x + 1)**2 + y**2) - y": ATTRACTS,
    "x/4 + y - 2*x/S; z - 2*y/S; x - 2*z/S".replace("S", "sqrt(x**2 + y**2 + z**2)"): ATTRACTS,
    "-x/sqrt(x**2 + 1)": ATTRACTS,
    "y - x/sqrt(x**2 + z**2/3 + 2); -x - y; -z": ATTRACTS,  # a norm that is irrational at the point, in three states
    f"x/{N}; y/{N}; -z": LEAVES,  # four planes meet in a line
    "-2*x**3/sqrt(x**6)": ATTRACTS,
    f"sqrt(2)*y*{N} - x; -sqrt(3)*y": ATTRACTS,
    f"y - x*Abs(x)/{N}; -x - y/{N}": ATTRACTS,
}


def rational(drawn: Random) -> Fraction:
    return Fraction(drawn.randint(-999, 999), drawn.choice((1, 7, 1000)))


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize(
    "square",
    [
        "x**2 + y**2",
        "4*x**2 + 2*y**2/9",
        "x**2 + (x - 3*y)**2 + 5*z**2",
        "(x*y)**2 + Abs(z)**4 + 2*(x*x) + y**2",
        "x**2 + y**2 + 9/4",
        "(x + 1)**2 + (y - 3/4)**2",
        "(3*x + 3)**2 + 16 + z**2",
        "4*(x - y/3)**2",
        "x*x + 3*y*y",
        "(x + 3/2)**2",
    ],
)
def test_a_norm_is_between_its_bounds(square: str, order: int) -> None:
    """In exact numbers, by the definition of a root; at the point both are what the norm is."""
    origin = dict.fromkeys("xyz", Fraction(0))
    _, (norm,) = named_norms([[f"sqrt({square})"]], origin, set("xyz"))
    ends = [_without_root(bound) for bound in norm.bounds(set("xyz"), order)]
    assert {RATIONAL.value(end, origin) ** 2 for end in ends} == {norm.square}
    drawn, widths = Random(order), list[float]()
    for _ in range(100):
        place = {name: rational(drawn) for name in "xyz"}
        exact = RATIONAL.value(formula_tree(square), place)
        lower, upper = (RATIONAL.value(end, place) for end in (ends[0], ends[-1]))
        assert lower <= 0 or lower**2 <= exact
        assert upper >= 0
        assert upper**2 >= exact
        widths.append(float(upper - lower) / float(exact) ** 0.5 if exact else 0.0)
    if not norm.square:
        assert max(widths) < {0: 1.25, 1: 0.4, 2: 0.1}[order]


def _without_root(tree: ast.expr) -> ast.expr:
    """With the root of a square of the tests, whose roots are rational, as a number."""
    text = written(tree)
    for square, root in (("9/4", "3/2"), ("25/16", "5/4"), ("25", "5")):
        text = text.replace(f"sqrt({square})", f"({root})")
    assert "sqrt" not in text
    return formula_tree(text)


@pytest.mark.parametrize(
    "square",
    [
        "x**2 + y**2",
        "x**2 + 9*(y - z)**2",
        "x**2 + y**2/4 + (x - z)**2",
        "x**2/3 + 2*y**2",
        "x**2 + 7*y**2/1000000000 + 3*z**2",
    ],
)
def test_entries_of_unit_vectors_are_between_their_bounds(square: str) -> None:
    point = dict.fromkeys("wxyz", Fraction(0))
    lists, norms = named_norms([[f"-3*x/sqrt({square})"]], point, set("wxyz"))
    ((formula,),), entries = with_unit_entries(lists, norms, set("wxyz"))
    assert formula == f"-3*{entries[0].name}"
    drawn = Random(square)
    for _ in range(100):
        place = {name: rational(drawn) for name in "wxyz"}
        exact = RATIONAL.value(formula_tree(square), place)
        for entry in entries:
            top = RATIONAL.value(formula_tree(entry.base), place) ** 2
            side = RATIONAL.value(formula_tree(f"sign({entry.base})"), place)
            lower, upper = (side * RATIONAL.value(bound, place) for bound in entry.bounds(set("wxyz")))
            is_tied = any(exact_of(entry, place) == exact_of(other, place) for other in entries if other is not entry)
            if top and not is_tied:
                assert 0 <= lower <= upper
                assert lower**2 * exact <= top <= upper**2 * exact


def exact_of(entry: UnitEntry, place: dict[str, Fraction]) -> Fraction:
    value: Fraction = entry.weight * RATIONAL.value(formula_tree(entry.base), place) ** 2
    return value


# In the plane; norms in three states: test_states_may_be_named_as_norms_are.
@pytest.mark.parametrize(
    "text", but([text for text in ATTRACTS_AND_NOT_SCALED if "z" in text], ATTRACTS_AND_NOT_SCALED)
)
def test_unit_control_falls_as_fast_as_is_said(text: str) -> None:
    """The derivative of V along the stated field at places of the domain, in floats."""
    radius = ATTRACTS_AND_NOT_SCALED[text]
    result = decided_with_certificate(stated(text, radius=str(Fraction(radius))), ATTRACTS)
    certificate = result.certificate()
    (rate,) = (claim["rate"] for claim in certificate["statement"]["claims"] if "rate" in claim)
    names, noise = "xyz"[: text.count(";") + 1], np.random.default_rng(0)
    field = compile(f"[{text.replace(';', ',')}]", "field", "eval")
    value = compile(rate["function"], "V", "eval")
    functions = {"sqrt": np.sqrt, "Abs": np.abs, "Max": np.maximum, "Min": np.minimum, "sign": np.sign}

    def at(code: CodeType, place: np.ndarray) -> np.ndarray:
        return np.array(eval(code, functions, dict(zip(names, place, strict=True))))  # noqa: S307

    half, step = float(Fraction(rate["within"])), 1e-7
    places = noise.uniform(-half, half, (len(names), 2_000))
    speeds = at(field, places)
    falls = (at(value, places + step * speeds) - at(value, places)) / step
    assert (falls <= -float(Fraction(rate["kappa"])) * at(value, places) + 1e-5).all()


def test_formulas_become_affine_and_keep_their_values() -> None:
    drawn = Random(1)
    point = dict.fromkeys("xy", Fraction(0))

    def formula(depth: int) -> str:
        if not depth:
            return drawn.choice(["x", "y", "2", "sqrt(x**2 + y**2)", "sqrt(1 + (x - y)**2)", "(x**2 + y**2)**(3/2)"])
        first, second = formula(depth - 1), formula(drawn.randrange(depth))
        kinds = [
            f"({first} + {second})",
            f"({first} - {second})",
            f"{first}*{second}",
            f"-({first})/3",
            f"({first})**2",
        ]
        return drawn.choice(kinds)

    for _ in range(200):
        text = formula(3)
        ((named,),), norms = named_norms([[text]], point, set("xy"))
        affine = str(affine_in_norms(named, norms))
        place = {name: drawn.uniform(-1, 1) for name in "xy"}
        size = {norm.name: float_value(formula_tree(f"sqrt({norm.argument})"), place, "") for norm in norms}
        ends = [
            float_value(formula_tree(affine), place | dict.fromkeys(size, number), "") for number in (0.0, 1.0, 2.0)
        ]
        value = float_value(formula_tree(affine), place | size, affine)
        assert value == pytest.approx(float_value(formula_tree(text), place, text), rel=1e-9, abs=1e-9)
        if len(norms) == 1:
            assert ends[1] - ends[0] == pytest.approx(ends[2] - ends[1], rel=1e-9, abs=1e-9)


@pytest.mark.usefixtures("reach_at_large")
@pytest.mark.parametrize("text", keep(6, DECIDED))
def test_it_is_decided_with_a_certificate(text: str) -> None:
    decided_with_certificate(stated(text), DECIDED[text])


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize("name", ["unit_1_norm_1", "inverse_norm_1"])
def test_states_may_be_named_as_norms_are(name: str) -> None:
    system = ns.System(["x", "y", name], [f"-2*x/{N} + {name}", f"-2*y/{N}", f"-{name} - x"])
    assert system.check().verdict == ATTRACTS


@pytest.mark.usefixtures("without_reach")
def test_norms_stand_in_tables_of_regions() -> None:
    near, beyond = {"where": ["x > 0"], "rhs": [f"y - x/{N}", f"-x - y/{N}"]}, {"rhs": [f"y - x/(1 + {N})", "-x - y"]}
    scene = ns.System.of_document({"system": {"states": ["x", "y"]}, "region": [near, beyond]})
    assert scene.check().verdict == ATTRACTS
    beyond["rhs"][1] = "-x - sqrt(x)"
    with pytest.raises(ns.SceneError, match=r"region\[2\].rhs\[2\]"):
        ns.System.of_document({"system": {"states": ["x", "y"]}, "region": [near, beyond]})


def test_a_norm_that_cancels_leaves_an_exact_field() -> None:
    result = stated(f"-x/{N}; -y/{N}").check()
    assert {"attracts": "everywhere"} in result.certificate()["statement"]["claims"]
    assert len(result.certificate()["statement"]["subject"]["rhs"]) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("y - x/sqrt(x**2 + y); -x", "or of a sum of squares"),
        (f"y - sign(1 - {N})*x; -y", r"system.rhs\[1\]: required roots such as .* received 'y - sign\(1 - sqrt"),
        ("-y/sqrt(x**2); -y", "not zero at the checked point"),  # zero on an axis
        (f"-x/{N}**3; -y/{N}**3", "proved bounded beside the point"),
        ("sqrt(x**2 + 1)*sqrt(x**2 + 2)*sqrt(x**2 + 3)*sqrt(y**2 + 4); -y", "at most 3 different roots"),
        ("-z/sqrt(x**2 + y**2); -y/sqrt(x**2 + y**2); -z", "not zero at the checked point"),
        ("-x/(z + sqrt(x**2 + y**2)); -y; -z", "not zero at the checked point"),
        ("-x*sqrt(sin(x)**2 + y**2); -y", "without functions such as sin, received"),
    ],
)
def test_other_roots_and_other_places_are_refused(text: str, said: str) -> None:
    with pytest.raises(ns.SceneError, match=said):
        stated(text).check()


@pytest.mark.parametrize("place", [(0, 0), (1, -2)])
def test_a_path_comes_to_the_point_when_its_distance_says(place: tuple[int, int]) -> None:
    """``abs(x)' = -1`` whatever the field turns by."""
    x, y = (f"({name} - {coordinate})" for name, coordinate in zip("xy", place, strict=True))
    size = f"sqrt({x}**2 + {y}**2)"
    rhs = [f"3*{y} - {x}/{size}", f"-3*{x} - {y}/{size}"]
    start = (place[0] + 0.3, place[1] + 0.4)
    end = ns.System(["x", "y"], rhs, at=place).simulate(start=start, until=2).facts()["end"]
    assert end["state"] == pytest.approx(place, abs=1e-9)
    assert end["t"] == pytest.approx(0.5, abs=1e-8)
    assert "denominator" in end["note"]


def test_paths_are_those_of_the_stated_field() -> None:
    text = f"y - x*{N} + sin(x)*{N}; -x/(1 + {N}) - y"
    end = stated(text).simulate(start=(0.8, -0.5), until=3).facts()["end"]

    def field(t: float, state: np.ndarray) -> list[float]:
        x, y = state
        size = np.hypot(x, y)
        return [y - x * size + np.sin(x) * size, -x / (1 + size) - y]

    other = solve_ivp(field, (0, 3), (0.8, -0.5), rtol=1e-11, atol=1e-12).y[:, -1]
    assert end["state"] == pytest.approx(other, abs=1e-8)


def test_where_a_solution_rests_is_asked_of_the_field_and_not_of_its_bounds() -> None:
    """Away from the point the bounds differ: between these a field is zero that is none of the system."""
    record = stated("sqrt((x + 3/5)**2 + (y + 4/5)**2) - 1 - 1/1000; -y").check().facts()
    assert record["equilibrium"]["verdict"] == "fails"
    rests = stated("sqrt((x + 3/5)**2 + (y + 4/5)**2) - 1; -y").check().facts()
    assert rests["equilibrium"]["verdict"] == "holds"


@pytest.mark.usefixtures("without_reach")
def test_certificates_name_the_scene_that_they_are_about() -> None:
    text = f"y - x/{N}; -x - y/{N}"
    certificate = stated(text).check().certificate()
    assert certificate["notes"]["stated"] == [[formula.strip() for formula in text.split(";")]]
    assert "roots of sums of squares" in certificate["notes"]["right-hand sides"]


@pytest.mark.parametrize("seed", keep(8, [3, 4, 10, 5, 9, 7, 2, 6, 1, 8, 11, 0]))  # the slow ones last
def test_random_fields_do_what_is_said(seed: int) -> None:
    """Paths in floats from near the point beside the verdict."""
    drawn, noise = Random(seed), np.random.default_rng(seed)
    size = drawn.choice([N, "sqrt(2*x**2 + y**2)", OBLIQUE])

    def part(name: str) -> str:
        a, b = (drawn.randint(-3, 3) for _ in range(2))
        factor = drawn.choice([f"/{size}", "", f"*{size}", f"/({size} + 1)"])
        return f"({a}*x + ({b})*y){factor} - {drawn.randint(0, 2)}*{name}/{size}"

    texts = [part("x"), part("y")]
    verdict = ns.System(["x", "y"], texts).check().verdict
    code = compile(f"[{', '.join(texts)}]", "field", "eval")

    def field(t: float, state: np.ndarray) -> list[float]:
        return eval(code, {"sqrt": np.sqrt}, dict(zip("xy", state.tolist(), strict=True)))  # noqa: S307

    def near(t: float, state: np.ndarray) -> float:
        return float(np.hypot(*state) - 1e-5)

    def far(t: float, state: np.ndarray) -> float:
        return float(np.hypot(*state) - 3e-2)

    near.terminal = far.terminal = True  # type: ignore[attr-defined]
    ends = []
    for angle in noise.uniform(0, 2 * np.pi, 6):
        start = (1e-3 * np.cos(angle), 1e-3 * np.sin(angle))
        other = solve_ivp(field, (0, 5), start, method="LSODA", events=(near, far), rtol=1e-6, atol=1e-9)
        ends.append(np.hypot(*other.y[:, -1]))
    if verdict in (ATTRACTS, "stable"):
        assert max(ends) < 3e-2
    if verdict == LEAVES:
        assert max(ends) > 1e-5
