"""Governing equations: annihilators, control vector fields, both coordinates, and what is computed only when asked."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.formulas.expression import parse
from nonsmooth.symbolic.formulas.surfaces import LINE_BREAK, Formula, constant, number_latex
from nonsmooth.symbolic.mechanics.constraints import side_row
from nonsmooth.symbolic.mechanics.contact_states import regular_states, solve_rows
from nonsmooth.symbolic.mechanics.equations import (
    Coordinates,
    annihilator,
    control_matrix,
    derive_control_fields,
    governing_equations,
    stacked_constraints,
    wheel_constraints,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.thorough import examples, few

# ---- Governing equations: annihilators, control vector fields, and both coordinates. -------------

RADICAL = ("four-wheel", "rectangle", "off-center")  # SymPy decides sums of square roots by expanding
SEEDS = range(6)
ROUNDING = 1e-12  # relative, for floats of SymPy against floats of the field
RANDOM = examples(60)


def zero(expression: sympy.Expr) -> bool:
    return bool(sympy.expand(expression) == 0)


# ---- the annihilator and the control vector fields -----------------------------------------------


@few(1)
@pytest.mark.parametrize("name", RADICAL)
def test_sympy_matrices_annihilate(name: str) -> None:
    for state in regular_states(load_scene(name)):
        assert all(zero(entry) for entry in stacked_constraints(state) * annihilator(state))


@pytest.mark.parametrize("name", RADICAL)
def test_symbolic_inputs_satisfy_the_symbolic_constraints(name: str) -> None:
    for state in regular_states(load_scene(name))[::5]:
        matrix, inputs = control_matrix(state)
        twist = matrix * inputs if len(inputs) else sympy.zeros(3, 1)
        residual = stacked_constraints(state, symbolic_input=True) * sympy.Matrix([*twist, 1])
        assert all(zero(entry) for entry in residual)


@pytest.mark.parametrize("symbolic", [False, True])
def test_the_pose_rate_satisfies_the_constraints_at_the_centre_of_mass(symbolic: bool) -> None:
    """With arms ``p_i - c`` the rows annihilate ``(x', y', theta', 1)`` for every x and y."""
    for state in regular_states(load_scene("rectangle"))[::5]:
        rate = governing_equations(state, Coordinates.BODY, symbolic_inputs=symbolic).to_sympy()
        rows = stacked_constraints(state, symbolic_input=symbolic, body=True)
        assert all(zero(entry) for entry in rows * sympy.Matrix([*rate, 1]))


def test_body_constraints_depend_on_x_and_y_only() -> None:
    wheel = load_scene("off-center").wheels[0]
    assert wheel_constraints(wheel, body=True).free_symbols == set(sympy.symbols("x y", real=True))
    assert not wheel_constraints(wheel).free_symbols


def test_the_generic_derivation_returns_every_regular_triple() -> None:
    scene = load_scene("four-wheel")
    fields = derive_control_fields(scene)
    assert len(fields) == 40
    assert fields["R1 S1 R2"] == {state.name: state for state in regular_states(scene)}["R1 S1 R2"].control_fields


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_control_fields_agree_with_an_lu_solve(arrays: Arrays, seed: int) -> None:
    for state in regular_states(arrays.random(seed, 3))[::4]:
        rows = stacked_constraints(state, symbolic_input=True)
        solution = rows[:, :3].LUsolve(-rows[:, 3])
        matrix, inputs = control_matrix(state)
        derived = matrix * inputs if len(inputs) else sympy.zeros(3, 1)
        assert all(sympy.simplify(a - b) == 0 for a, b in zip(solution, derived, strict=True))


# ---- governing equations in both coordinates -----------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_body_equations_are_the_pose_rate(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 3)
    x, y = scene.check.equilibrium
    for state in regular_states(scene):
        equations = governing_equations(state, Coordinates.BODY)
        values = {"x": x, "y": y}
        expected = (*state.twist.pose_rate((x, y)), state.twist.omega)
        assert tuple(value_of(formula, values) for formula in equations.right) == expected


@pytest.mark.parametrize("seed", SEEDS)
def test_symbolic_inputs_at_the_speeds_give_the_twist(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 3)
    speeds = {f"u_{wheel.index}": wheel.speed for wheel in scene.wheels}
    for state in regular_states(scene):
        equations = governing_equations(state, symbolic_inputs=True)
        assert tuple(value_of(formula, speeds) for formula in equations.right) == tuple(state.twist)


def value_of(formula: Formula, values: dict[str, Number]) -> Number:
    """The formula's plain text, read back by the parser of scene files."""
    field = next(iter(values.values())).field
    assert isinstance(field, NumberField)
    return parse(formula.plain(), set(values)).value(field, values)


def test_four_wheel_equations_as_text() -> None:
    state = build_partition(load_scene("four-wheel")).cells[0].states[0]
    equations = governing_equations(state, Coordinates.BODY, symbolic_inputs=True)
    assert state.name == "R1 S1 R2"
    assert equations.plain() == (
        "x' = -sqrt(2)/2*u_1 + sqrt(2)/2*u_2 - sqrt(2)/2*u_2*y\n"
        "y' = -sqrt(2)/2*u_1 - sqrt(2)/2*u_2 + sqrt(2)/2*u_2*x\n"
        "theta' = sqrt(2)/2*u_2"
    )
    assert r"\dot{\theta} &= \frac{\sqrt{2}}{2} u_{2}" in equations.latex()


# ---- numbers and formulas as text ----------------------------------------------------------------

FIELD = NumberField(5)
ROOTS = [FIELD.one, FIELD.sqrt(2), FIELD.sqrt(6), FIELD.two_cos(1), FIELD.two_cos(1) * FIELD.sqrt(3)]
RATIONALS = st.fractions(min_value=-20, max_value=20, max_denominator=12)
NUMBERS = st.lists(RATIONALS, min_size=len(ROOTS), max_size=len(ROOTS)).map(
    lambda weights: sum((w * root for w, root in zip(weights, ROOTS, strict=True)), FIELD.zero)
)
MONOMIALS = st.sampled_from([(), ("x",), ("y",), ("u_1",), ("u_1", "x"), ("u_12", "y")])


@RANDOM
@given(st.lists(st.tuples(NUMBERS, MONOMIALS), max_size=4), NUMBERS, RATIONALS)
def test_plain_text_reads_back_to_the_same_number(terms: list[tuple[Number, Any]], a: Number, b: Fraction) -> None:
    values = {"x": a, "y": FIELD(b), "u_1": a + 1, "u_12": FIELD(2)}
    formula = Formula(tuple(terms))
    expected = FIELD.zero
    for coefficient, monomial in terms:
        expected = expected + math.prod((values[name] for name in monomial), start=coefficient)
    text = formula.plain()
    if len(text) <= 400:  # the parser's limit
        assert parse(text, set(values)).value(FIELD, values) == expected


@RANDOM
@given(NUMBERS)
def test_all_three_notations_agree_in_value(number: Number) -> None:
    value = float(constant(number).to_sympy())
    assert value == pytest.approx(float(number), rel=ROUNDING, abs=ROUNDING)
    latex = number_latex(number)
    assert latex.count("{") == latex.count("}")
    assert latex.count(r"\sqrt") == str(number).count("sqrt")
    assert latex.count(r"\cos") == str(number).count("cos")


def test_long_formulas_break_between_summands() -> None:
    number = sum((FIELD.sqrt(p) for p in (2, 3, 5, 7, 11, 13)), FIELD.zero)
    formula = Formula(((number * Fraction(123456789, 1000003), ()),))
    assert LINE_BREAK in formula.latex(LINE_BREAK)
    assert formula.latex(LINE_BREAK).replace(LINE_BREAK, "").replace(" ", "") == formula.latex().replace(" ", "")


def test_states_of_side_rows_have_no_inputs() -> None:
    scene: Scene = load_scene("off-center")
    state = solve_rows(tuple(side_row(wheel) for wheel in scene.wheels[:3]))  # type: ignore[arg-type]
    assert state is not None
    assert control_matrix(state)[0].shape == (3, 0)
    assert governing_equations(state, symbolic_inputs=True).plain() == "v_x = 0\nv_y = 0\nomega = 0"


PLAIN_FIELD = NumberField()
SQUARE_ROOTS = [PLAIN_FIELD.sqrt(n) for n in (2, 3, 5, 7)]
small = st.integers(-5, 5)


@st.composite
def numbers(draw: st.DrawFn) -> Number:
    total = PLAIN_FIELD.rational(draw(small))
    for root in SQUARE_ROOTS:
        total = total + root * Fraction(draw(small), draw(st.integers(1, 4)))
    return total


@examples(150)
@given(numbers(), numbers(), numbers())
def test_lazy_arithmetic_equals_exact_arithmetic(a: Number, b: Number, c: Number) -> None:
    x, y, z = Lazy.of(a), Lazy.of(b), Lazy.of(c)
    pairs = [(x + y * z, a + b * c), (x - y, a - b), (-x * 3 + 1, -a * 3 + 1), (2 - x, 2 - a)]
    if b:
        pairs.append((x / y + z, a / b + c))
        pairs.append((1 / y, 1 / b))
    for lazy, exact in pairs:
        assert lazy.sign() == exact.sign()
        assert lazy.exact() == exact
        assert float(lazy) == pytest.approx(float(exact), rel=1e-14, abs=1e-300)
        assert lazy == exact


def test_a_true_tie_is_decided_and_a_near_tie_is_no_tie() -> None:
    a, b, c, d = (Lazy.of(root) for root in SQUARE_ROOTS)
    total = (a + b) / (c + d)
    assert (total * (c + d) - a - b).sign() == 0
    tiny = PLAIN_FIELD.rational(Fraction(1, 10**300))
    assert (total * (c + d) - a - b + tiny).sign() == 1
    assert float(total * (c + d) - a - b + tiny) == pytest.approx(1e-300)
    assert ((total - total) == 0) is True


def test_balls_keep_their_precision() -> None:
    """Rounding to the machine's 53 bits anywhere would show here."""
    value = Lazy.of(SQUARE_ROOTS[0])
    for _ in range(20):
        value = -(value * Lazy.of(SQUARE_ROOTS[1])) / SQUARE_ROOTS[1] + 0
    assert value.ball.rel_accuracy_bits() > 200


def test_division_by_zero_is_refused() -> None:
    zero = Lazy.of(SQUARE_ROOTS[0]) - SQUARE_ROOTS[0]
    with pytest.raises(ZeroDivisionError):
        Lazy.of(SQUARE_ROOTS[1]) / zero
