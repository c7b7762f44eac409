"""Plain systems as they are read: surfaces, pieces, parameters, starts, and fields that are rewritten."""

from __future__ import annotations

import ast
import itertools
import math
import random
import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from flint import arb, ctx, fmpq
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.files.scene_values import read_start_angle, read_start_value
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.formulas.enclosed_functions import ONE_AT_ZERO, TERMS, WAVES, series
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import (
    PLANE,
    Enclosed,
    NoEnclosureError,
    SwitchedSystem,
    UnknownSign,
    enclose_numbers,
    signs_by_factors,
)
from tests.built_in import planar_systems
from tests.oracles.floats import value
from tests.plain import built
from tests.thorough import examples, few

# ---- Switched systems in any number of states: their surfaces, their pieces, and what is refused.


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


@pytest.mark.parametrize("spelling", ["abs(", "abs  ("])
def test_abs_is_read_as_the_name_that_certificates_know(load: Load, spelling: str) -> None:
    def texts(name: str) -> list[str]:
        formulas = [text.replace("Abs(", name) for text in ("y - Abs(y)*x", "-sqrt(Abs(x))*sgn(x) - y")]
        system = load(["x", "y"], formulas, f'[check]\nlyapunov = "{name}x) + {name}y)"')
        return [formula.text for formula in (*system.rhs, system.check.lyapunov)]

    assert texts(spelling) == texts("Abs(")
    assert not any(spelling in text for text in texts(spelling))


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


# ---- Fractions, sines of states and interval parameters: the rewritten field against the formula as it was written.

WRITTEN = [
    "-sin(x) - y",
    "sin(x + pi/3)*y - sin(pi/3)*y",
    "cos(2*x - y) - 1",
    "-sin(x)**2*sgn(y) + cos(x)*sin(y)",
    "x/(1 + x**2) - y",
    "-x/(x - 2) + sgn(x + y)/(3 - y)",
    "Max(x/(2 + y), y)/(1 + Abs(x))",
    "sgn(x/(y - 2)) - 3*relu(y/(1 + x**2))**2",
    "sin(x)/(1 + y**2) - 1/(2 + x) + 1/2",
    "tanh(2*x)*sgn(y) - y",
    "atan(x - y) - (1 + exp(-(2*x)**2 - y**2/3))*y",
    "tanh(x)**2/(3 + x) - tanh(x)*atan(y)",
]


def velocity(system: SwitchedSystem, x: np.ndarray) -> np.ndarray:
    """Of the float field at a point off all surfaces."""
    field = system_field(system)
    signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
    return np.asarray(field.flow(signs)(0.0, x))


@few(2)
@pytest.mark.parametrize("formula", WRITTEN)
def test_the_float_field_is_the_formula(formula: str) -> None:
    system = built(["y", formula])
    rng = np.random.default_rng(1)
    for x in rng.uniform(-1.5, 1.5, (40, 2)):
        expected = value(formula, x=x[0], y=x[1])
        assert velocity(system, x) == pytest.approx([x[1], expected], abs=1e-9)


@few(2)
@pytest.mark.parametrize("formula", [text for text in WRITTEN if any(kind in text for kind in WAVES)])
def test_right_hand_sides_enclose_the_formula(formula: str) -> None:
    system = built(["y", formula])
    assert system.others
    rng = np.random.default_rng(2)
    for x in rng.uniform(-3, 3, (40, 2)):
        expected = value(formula, x=x[0], y=x[1])
        scale = value(system.rewriting.scale.text, x=x[0], y=x[1]) if system.rewriting.scale else 1
        values = [value(member.rhs[1].text, x=x[0], y=x[1]) for member in system.members]
        assert min(values) - 1e-9 <= scale * expected <= max(values) + 1e-9


@examples(200)
@given(st.floats(-20, 20), st.sampled_from(WAVES), st.integers(0, 4))
def test_series_enclose_at_every_place(v: float, kind: str, order: int) -> None:
    """With their last term and without it; the function itself in balls."""
    v = -abs(v) if kind == "exp" else v
    terms = [Fraction(v) ** power * c for power, c in series(kind, TERMS[kind] + order)]
    low, high = sorted((sum(terms[:-1]), sum(terms)))
    with ctx.workprec(400):
        exact = getattr(arb(v), kind)()
        assert not exact < fmpq(low.numerator, low.denominator)
        assert not exact > fmpq(high.numerator, high.denominator)


@pytest.mark.parametrize("kind", WAVES)
def test_paths_take_functions_themselves_however_large_what_they_are_of(kind: str) -> None:
    system = built(["y", f"-x - {kind}(-(100*y)**2)" + (" + 1" if kind in ONE_AT_ZERO else "")])
    for y in (1e-3, 1.0, 20.0):
        expected = getattr(math, kind)(-((100 * y) ** 2)) - (kind in ONE_AT_ZERO)
        assert velocity(system, np.array([0.0, y]))[1] == pytest.approx(-expected, abs=1e-9)


def test_paths_of_numbers_beyond_floats_are_refused() -> None:
    with pytest.raises(RefusalError, match="coefficients within the range of floats"):
        velocity(built(["y", "-x - y*1e200*1e200"]), np.array([0.1, 0.1]))


def test_interval_parameters_stand_for_their_ends() -> None:
    system = built(["y", "-k*x - c*sgn(y)"], {"k": [1, "3/2"], "c": ["1/4", 2]})
    found = {member.rhs[1].text for member in system.members}
    assert len(found) == len(list(itertools.product(range(2), repeat=2)))
    assert not system.rewriting.written
    twice = built([["y", "-k*x - y"], ["y", "-3*x - y"]], {"k": [1, 2], "unused": [0, 1]})
    assert [member.rhs[1].text for member in twice.members] == ["-1*x - y", "-3*x - y", "-2*x - y"]
    assert twice.intervals == ("k",)


@pytest.mark.parametrize(
    ("written", "whole"),
    [
        ("-x**3.0", "-x**3"),
        ("-x**(n + 1)*y**(4/2)", "-x**(2 + 1)*y**2"),
        ("-x**(4 - 1)/(1 + y**2.)", "-x**3/(1 + y**2)"),
        ("-(x**2.0 + y)**(1.5*n)", "-(x**2 + y)**3"),
    ],
)
def test_whole_exponents_may_be_written_otherwise(written: str, whole: str) -> None:
    stated, plain = built(["y", written], {"n": 2}), built(["y", whole])
    x = np.array([0.7, -0.3])
    assert velocity(stated, x) == pytest.approx(velocity(plain, x), abs=1e-12)
    tree = ast.parse(stated.members[0].rhs[1].text)
    powers = [node.right for node in ast.walk(tree) if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)]
    assert powers
    assert all(isinstance(power, ast.Constant) and type(power.value) is int for power in powers)


def test_a_sine_must_vanish_at_the_checked_point() -> None:
    with pytest.raises(SceneError, match="zero at the checked point"):
        built(["y", "-sin(x)"], equilibrium=[1, 0])
    assert decide_system(built(["y", "-sin(x - 1) - y"], equilibrium=[1, 0])).verdict == "asymptotically stable"


# ---- Irrational numbers between rational ones: the stated field is a mixture of those that enclose it, by its
# values.

FORMULAS = [
    ["-sqrt(2)*x + y", "-x/sqrt(3) - sign(y)*sqrt(5)"],
    ["y*cos(pi/7) - x", "-Max(x, y)*sqrt(2)/3 - 10**9*sqrt(7)*y"],
    ["(sqrt(2) - 1)*(x + sqrt(3)*(y - x**2))", "-y - sign(x)/(1 + sqrt(2))"],
    ["-x + sqrt(2)*sin(x)", "-y", "-sqrt(3)/10**12*z"],
    [["-sqrt(2)*x", "-y"], ["-x", "-2*y"]],
]


def fields(system: SwitchedSystem, place: Sequence[sympy.Rational]) -> list[list[sympy.Expr]]:
    """The values of all right-hand sides to sixty digits, by SymPy."""
    at = dict(zip(map(sympy.Symbol, system.states), place, strict=True))
    sides = [[side.text for side in member.rhs] for member in system.members]
    return [[sympy.sympify(text, locals={"Max": sympy.Max}).subs(at).evalf(60) for text in side] for side in sides]


@few(2)
@pytest.mark.parametrize("rhs", FORMULAS, ids=str)
def test_the_stated_field_is_a_mixture(rhs: list[Any]) -> None:
    stated = built(rhs)
    enclosing = enclose_numbers(stated)
    assert enclosing.rewriting.encloses == (Enclosed.NUMBERS,)
    assert enclosing.only_encloses
    assert len(enclosing.members) > len(stated.members)
    assert enclose_numbers(enclosing) is enclosing
    source = random.Random(3)
    for _ in range(6):
        place = [sympy.Rational(source.randint(-99, 99), 100) for _ in stated.states]
        bounds = fields(enclosing, place)
        for own in fields(stated, place):
            away = [[a - b for a, b in zip(bound, own, strict=True)] for bound in bounds]
            sizes = [max(*map(abs, column), sympy.Rational(1, 10**40)) for column in zip(*away, strict=True)]
            rows = np.array([[float(d / size) for d, size in zip(row, sizes, strict=True)] for row in away])
            table = np.vstack([rows.T, np.ones(len(rows))])
            assert linprog(np.zeros(len(rows)), A_eq=table, b_eq=np.r_[np.zeros(len(own)), 1.0]).status == 0


def test_rational_systems_stay_as_they_are() -> None:
    stated = built(["-x + sqrt(4)*y", "-y/3 - sign(x)"])
    assert enclose_numbers(stated) is stated


@pytest.mark.parametrize(
    "rhs",
    [
        ["-sign(x - sqrt(2)*y)", "-y"],
        ["-Abs(x*sqrt(2))", "-y"],
        ["-(x*sqrt(2) + y)**2", "-y"],
        [" + ".join(f"sqrt({k})*x" for k in (2, 3, 5, 6, 7, 10)), "-y"],
    ],
)
def test_other_systems_are_refused(rhs: list[str]) -> None:
    with pytest.raises(NoEnclosureError, match="irrational numbers"):
        enclose_numbers(built(rhs))


@pytest.mark.parametrize(
    ("rhs", "verdict"),
    [
        (["x*(sqrt(2) - 141421356237/10**11)"], Translation.UNSTABLE),
        (["sqrt(2)*x - 141421356237/10**11*x"], Translation.UNSTABLE),  # of the bounds one attracts, one repels
        (["sqrt(2) - 141421356237/10**11 - x"], Translation.UNSTABLE),
    ],
)
def test_what_no_bounds_tell_is_certified_by_the_numbers(rhs: list[str], verdict: Translation) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is verdict
    assert {"stability": str(verdict)} in certificate_of(result)["statement"]["claims"]


@pytest.mark.parametrize(
    ("rhs", "function", "verdict"),
    [
        (["-sqrt(2)*x + y", "-y", "-z/sqrt(3)"], "x**2 + y**2 + z**2", AuditVerdict.VALID),
        (["-sqrt(2)*x + y", "-y", "-z/sqrt(3)"], "x**2 - y**2 + z**2", AuditVerdict.INVALID),
        (["-sqrt(2)*x", "y", "-z"], "x**2 + y**2 + z**2", AuditVerdict.UNDECIDED),  # true of all of them, not asked
        (["sqrt(2)*y", "-sqrt(2)*x", "-z"], "x**2 + y**2 + z**2", AuditVerdict.UNDECIDED),
    ],
)
def test_functions_are_judged_by_what_holds_of_all_bounds(rhs: list[str], function: str, verdict: AuditVerdict) -> None:
    found = audit(built(rhs), function)
    assert found.verdict is verdict


# ---- Named parameters of plain systems: complete formulas, and one line for what cannot be used.

STATES = 'states = ["x", "v"]\n'


def written(folder: Path, rhs: str, parameters: str, check: str = "") -> Path:
    file = folder / "my.toml"
    file.write_text(f"[system]\n{STATES}rhs = {rhs}\nparameters = {parameters}\n[check]\n{check}", encoding="utf-8")
    return file


def test_formulas_are_complete_and_mean_the_same(tmp_path: Path) -> None:
    rhs = '["v", "-k1*sign(x) - k*v*1e1"]'
    system = load_system(written(tmp_path, rhs, '{ k = 0.5, k1 = "sqrt(2)" }', 'lyapunov = "k1*Abs(x) + v**2/2"'))
    assert [side.text for side in system.rhs] == ["v", "-sqrt(2)*sign(x) - 0.5*v*1e1"]
    assert system.check.lyapunov.text == "sqrt(2)*Abs(x) + v**2/2"
    velocity = system.velocity(lambda surface: 1)
    assert float(velocity[1]([system.field(1), system.field(2)])) == pytest.approx(-(2**0.5) - 10)


def test_python_changes_some_of_them() -> None:
    system = ns.System(["x", "v"], ["v", "-k*x - c*v"], parameters={"k": 2, "c": 1})
    assert system.check().verdict == "asymptotically stable"
    assert system.with_(parameters={"c": -1}).check().verdict == "unstable"


# ---- Starts of solutions: formulas against mpmath, rounded once to the nearest float -------------

DIGITS = 80


@pytest.mark.parametrize("text", ["0.1", "-1e-3", "0", " 2.50 ", "1_000.25", ".5", "-7", "4503599627370497.5", "1e300"])
def test_decimals_are_the_floats_that_python_reads(text: str) -> None:
    assert read_start_value(text) == read_start_angle(text) == float(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1/3", lambda: mp.mpf(1) / 3),
        ("sqrt(2)/4", lambda: mp.sqrt(2) / 4),
        ("1 - sqrt(3)/2 + 10**-20", lambda: 1 - mp.sqrt(3) / 2 + mp.mpf(10) ** -20),
        ("cos(pi/5)", lambda: mp.cos(mp.pi / 5)),
    ],
)
def test_formulas_are_rounded_once(text: str, value: object) -> None:
    with mp.workdps(DIGITS):
        assert callable(value)
        expected = float(value())
    assert read_start_value(text) == read_start_angle(text) == expected


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi/6", lambda: mp.pi / 6),
        ("-2*pi/3", lambda: -2 * mp.pi / 3),
        ("pi", lambda: mp.pi),
        ("pi/4 + 0.1", lambda: mp.pi / 4 + mp.mpf(1) / 10),
        ("pi - 3.14159265358979323846264338327950288", lambda: mp.pi - mp.mpf("3.14159265358979323846264338327950288")),
        ("1e30*pi - pi", lambda: (mp.mpf(10) ** 30 - 1) * mp.pi),
    ],
)
def test_angles_with_pi_are_rounded_once(text: str, value: object) -> None:
    with mp.workdps(DIGITS):
        assert callable(value)
        expected = float(value())
    assert read_start_angle(text) == expected


def test_a_float_near_a_multiple_of_pi_stays_that_float() -> None:
    assert read_start_angle(repr(math.pi / 6 + 1e-13)) == math.pi / 6 + 1e-13


NUMBERS = "numbers such as 1/3 or sqrt(3)/2"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pi/6", f"{NUMBERS}, with pi only inside sin and cos or in an angle, received 'pi/6'"),
        ("", "a number or a formula such as \"sqrt(2)/2\", received ''"),
        ("x", "a formula of numbers"),
        ("1/0", "a finite number"),
        ("nan", "a finite number, received 'nan'"),
        ("__import__('os').getcwd()", "a formula of numbers"),
    ],
)
def test_what_is_no_start(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=f"^required {re.escape(words)}"):
        read_start_value(text)
