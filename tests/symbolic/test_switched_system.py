"""Switched systems in any number of states: their surfaces, their pieces, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import product
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.files.system_document import MAX_STATES
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem, UnknownSign, signs_by_factors
from tests.built_in import planar_systems


def sign_at(point: tuple[Fraction, Fraction], inner: Polynomial) -> int:
    return inner(point).sign()


def always(side: int, inner: Polynomial) -> int:
    return side


Load = Callable[..., SwitchedSystem]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def from_text(states: list[str], rhs: list[str], rest: str = "") -> SwitchedSystem:
        file = tmp_path / "my.toml"
        file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n{rest}")
        return load_system(file)

    return from_text


@pytest.mark.parametrize(
    ("rhs", "surfaces"),
    [
        (["sign(x - y)", "sign(2*y - 2*x)"], {"x - y"}),
        (["sign(y**2 - x**2)", "0"], {"x - y", "x + y"}),
        (["sign(x + Abs(y))", "1"], {"y", "x + y", "x - y"}),
        (["sign(x**2 + y**2 - 1)", "sign(x**3)"], {"x**2 + y**2 - 1", "x"}),
        (["Max(x, y**2)", "min(x, 2*y, 1)"], {"-y**2 + x", "x - 2*y", "x - 1", "y - 1/2"}),
        (["sign(x**2 + x*y + y**2)", "Abs(3)"], set()),
        (["x", "sign(y**2 - 2*x**2)"], {"x + sqrt(2)/2*y", "x - sqrt(2)/2*y"}),
    ],
)
def test_surfaces_are_irreducible_and_listed_once(load: Load, rhs: list[str], surfaces: set[str]) -> None:
    found = [str(surface) for surface in load(["x", "y"], rhs).surfaces()]
    assert set(found) == surfaces
    assert len(found) == len(surfaces)


@pytest.mark.parametrize("name", planar_systems())
def test_pieces_in_the_displacement_are_those_in_the_states(name: str) -> None:
    """For every pattern of signs, whatever point is checked."""
    system = load_system(name, at="1/3,-2/7")
    x, y = Fraction(3, 11), Fraction(5, 13)
    there = (x + Fraction(1, 3), y - Fraction(2, 7))
    displaced = system.displaced(PLANE)
    pairs = list(zip(system.surfaces(), system.surfaces(displaced), strict=True))
    for signs in product((-1, 1), repeat=len(pairs)):
        own, moved = ({pair[k]: sign for pair, sign in zip(pairs, signs, strict=True)} for k in (0, 1))
        expected = system.velocity(signs_by_factors(own))
        found = system.velocity(signs_by_factors(moved), displaced)
        assert [piece((x, y)) for piece in found] == [piece(there) for piece in expected]
    assert all(moved((x, y)) == own(there) for own, moved in pairs)


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("sgn(x)", lambda x, y: (x > 0) - (x < 0)),
        ("Max(x, y)", max),
        ("max(x, y, 1/3, -x)", lambda x, y: max(x, y, Fraction(1, 3), -x)),
        ("Min(x, y)", min),
        ("min(x, Max(y, 1/2)) - 2*Abs(y)", lambda x, y: min(x, max(y, Fraction(1, 2))) - 2 * abs(y)),
        ("Max(2, 3)*x + Min(x, x)", lambda x, y: 4 * x),
        ("Max(x, y)**2*Min(x**2, y)", lambda x, y: max(x, y) ** 2 * min(x**2, y)),
    ],
)
def test_pieces_are_the_values_that_python_has(load: Load, formula: str, value: Callable[..., Fraction]) -> None:
    system = load(["x", "y"], [formula, "0"])
    for x, y in product((Fraction(-7, 3), Fraction(-1, 5), Fraction(2, 7), Fraction(9, 4)), repeat=2):
        if x != y:
            rate = system.velocity(partial(sign_at, (x, y)))[0]
            assert rate((x, y)) == value(x, y)


def test_extremes_and_their_absolute_values_are_one_field(load: Load) -> None:
    written = load(["x", "y"], ["Max(x, y)", "Min(x, y)"])
    spelt = load(["x", "y"], ["(x + y + Abs(x - y))/2", "(x + y - Abs(x - y))/2"])
    assert [str(surface) for surface in written.surfaces()] == [str(surface) for surface in spelt.surfaces()]
    for side in (-1, 1):
        pairs = [system.velocity(partial(always, side)) for system in (written, spelt)]
        assert [str(rate) for rate in pairs[0]] == [str(rate) for rate in pairs[1]]


def test_an_open_sign_is_asked_for(load: Load) -> None:
    with pytest.raises(UnknownSign):
        load(["x"], ["sign(x)"]).velocity(signs_by_factors({}))


def test_what_is_checked_in_three_states(load: Load) -> None:
    system = load(["a", "b", "c"], ["-sign(a)", "-b", "1 - c"], '[check]\nequilibrium = [0, "1/2", 1]')
    assert list(map(str, system.check.equilibrium)) == ["0", "1/2", "1"]
    assert system.check.lyapunov.text == "a**2 + b**2 + c**2"
    with pytest.raises(SceneError, match=r"check\.equilibrium: required 3 numbers"):
        load(["a", "b", "c"], ["-sign(a)", "-b", "1 - c"], "[check]\nequilibrium = [0, 1]")


def test_formulas_are_tried_with_signs_that_occur_together(load: Load) -> None:
    system = load(["x"], ["1/(sign(x) - sign(-x))"])
    assert len(system.surfaces()) == 1


@pytest.mark.parametrize(
    ("states", "rhs", "named"),
    [
        ([], [], "1 to 8 different names"),
        (["x", "x"], ["1", "1"], """names such as ["x", "y"], received ['x', 'x']"""),
        (["x", "sign"], ["1", "1"], "1 to 8 different names"),
        (["x", "max"], ["1", "1"], "1 to 8 different names"),
        (["x", "lambda"], ["1", "1"], "; lambda means something else in formulas"),
        (["x", "θ"], ["1", "1"], "of letters a to z"),
        (["x"], ["sin(t) - x"], "system.rhs[1]: required a formula of x, numbers"),
        (["x"], ["sin(t) - x"], "received 'sin(t) - x'"),
        (
            ["x"],
            ["t*x"],
            "system.rhs[1]: required a formula of x, numbers, + - * / **, sign, Abs, Max, Min, relu, sat, sqrt",
        ),
        (["x"], ["Max(x)"], "system.rhs[1]: required Max(a, b, ...), received 'Max(x)'"),
        (["x"], ["-x + sat(x)"], "system.rhs[1]: required sat(a, low, high), received"),
        (
            ["x"],
            ["tan(x)"],
            "sqrt, sin, cos of numbers, sin and cos of polynomials in the states, sqrt of Abs of a state",
        ),
        (["x"], ["Max()"], "system.rhs[1]: required Max(a, b, ...)"),
        (["x"], ["Max(x, key=1)"], "system.rhs[1]: required Max(a, b, ...)"),
        (["x"], ["Max(*x)"], "system.rhs[1]: required Max(a, b, ...)"),
        (["x"], ["sgn(x, 1)"], "system.rhs[1]: required sgn(a)"),
        (["x"], ["sat(x, 1, -1)"], "system.rhs[1]: required sat(a, low, high) with low <= high"),
        (["x", "y"], ["y", "-Max(x, sat(y, 2, 1/2))"], "system.rhs[2]: required sat(a, low, high) with low <= high"),
        (["x"], ["Min(x, 1/x)"], "system.rhs[1]: required denominators that are not zero at the checked point"),
        ([f"x{k}" for k in range(MAX_STATES + 1)], ["1"] * (MAX_STATES + 1), "1 to 8 different names"),
        (["x", "y"], ["1"], "2 formulas"),
        (["x"], ["y"], "system.rhs[1]"),
        (["x"], ["__import__('os')"], "system.rhs[1]"),
    ],
)
def test_bad_files_are_refused(load: Load, states: list[str], rhs: list[str], named: str) -> None:
    with pytest.raises(SceneError, match=r"my\.toml") as caught:
        load(states, rhs)
    assert named in str(caught.value)


@pytest.mark.parametrize("guard", ["k*x > 0", "sin(x) > 0"])
def test_other_guards_are_refused_where_they_stand(guard: str) -> None:
    tables = [{"where": [guard], "rhs": ["-x"]}, {"rhs": ["-2*x"]}]
    document = {"system": {"states": ["x"], "parameters": {"k": [1, 2]}}, "region": tables}
    with pytest.raises(SceneError, match=r"region\[1\].where\[1\]: required a guard without interval"):
        build_system(document, "t", Path("t"))


def test_a_formula_may_take_several_lines() -> None:
    system = build_system({"system": {"states": ["x"], "rhs": ["-x\n - 2*x"]}}, "t", Path("t"))
    assert system.rhs[0].text == "-x  - 2*x"
    with pytest.raises(SceneError, match="required a formula"):
        build_system({"system": {"states": ["x"], "rhs": ["-x # slow\n - 2*x"]}}, "t", Path("t"))


def test_pieces_that_are_no_polynomials_are_refused(load: Load) -> None:
    with pytest.raises(SceneError, match=r"system.rhs\[1\]"):
        load(["x"], ["1/x"]).surfaces()


def test_too_many_surfaces_are_refused(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nonsmooth.symbolic.systems.switched_system.MAX_PATTERNS", 64)
    relays = " + ".join(f"sign(x - {k})*sign(y - {k})" for k in range(4))
    with pytest.raises(SceneError, match="fewer switching surfaces"):
        load(["x", "y"], [f"Abs({relays})", "0"]).surfaces()
    assert len(load(["x", "y"], [relays, "0"]).surfaces()) == 8  # each relay is a part of its own
