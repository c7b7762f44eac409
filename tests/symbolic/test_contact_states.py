"""Contact states and governing equations: annihilators, control vector fields, closed forms, both coordinates."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.formulas.expression import parse
from nonsmooth.symbolic.formulas.surfaces import LINE_BREAK, Formula, constant, number_latex
from nonsmooth.symbolic.mechanics.contact_states import (
    ContactCensus,
    Row,
    RowKind,
    Twist,
    constraint_matrix,
    independent,
    possible_triples,
    regular_states,
    scene_rows,
    side_row,
    solve_rows,
    take_census,
    wheel_rows,
)
from nonsmooth.symbolic.mechanics.equations import (
    Coordinates,
    annihilator,
    governing_equations,
    stacked_constraints,
    wheel_constraints,
)
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Contact, Friction, Scene, Wheel
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.oracles.nearest_states import nearest_states
from tests.thorough import examples, few

# ---- Contact states: annihilators, control vector fields, and the closed forms of regular arrays.

RINGS = range(3, 13)
SEEDS = range(8)
# Twists are of order 1 to 10 and come from 3 x 3 systems that are far from singular.
ROUNDING = 1e-12
# numpy.linalg.matrix_rank on rows of length about 1: true ranks are separated from rounding by orders of magnitude.
RANK_TOLERANCE = 1e-10


def float_row(row: Row) -> list[float]:
    """The row as the paper writes it, with unit rim directions: normal and right-hand side."""
    (dx, dy), (px, py) = ([float(x) for x in v] for v in (row.wheel.unit_direction, row.wheel.position))
    if row.kind is RowKind.ROLL:
        return [dx, dy, -dx * py + dy * px, float(row.wheel.speed)]
    return [-dy, dx, dy * py + dx * px, 0.0]


# ---- the annihilator, by its defining identity ---------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_a_twist_satisfies_its_three_rows_exactly(arrays: Arrays, seed: int) -> None:
    for state in regular_states(arrays.random(seed, 4)):
        assert all(not row.residual(state.twist) for row in state.rows)
        assert len(independent([row.normal for row in state.rows])) == 3


@pytest.mark.parametrize("turned", [0, 1, 4], ids=("rational", "mixed", "irrational"))
@pytest.mark.parametrize("speed", [0, Fraction(2, 3)])
def test_all_triples_are_those_solved_one_by_one(turned: int, speed: Fraction) -> None:
    """Also where some normals are rational, and are computed with as such, and others are not; in the field's numbers.

    The first wheels are turned by a sixth of pi.
    """
    field = NumberField()
    rim = (field.sqrt(3), field.one)
    positions = [(field(x), field(y)) for x, y in ((1, 1), (-1, 1), (-1, -1), (2, -1))]
    wheels = [
        Wheel(k, place, rim if k <= turned else (field(1), field(k - 2)), field(speed), Friction(field(1), field(2)))
        for k, place in enumerate(positions, 1)
    ]
    check = CheckedSquare((field.zero, field.zero), field.one)
    states = regular_states(Scene("four", field, tuple(wheels), Contact("nearest"), check))
    assert len(states) > 40
    for state in states:
        alone = solve_rows((state.rows[0], state.rows[1], state.rows[2]))
        assert alone is not None
        assert (state.twist, state.control_fields) == (alone.twist, alone.control_fields)
        entries = [*state.twist, *(entry for own in state.control_fields.values() for entry in own)]
        assert {type(entry) for entry in entries} == {Number}


@pytest.mark.parametrize("seed", SEEDS)
def test_omega_annihilates_the_twist_of_its_wheel(arrays: Arrays, seed: int) -> None:
    """``Omega_i (xi, 1) = 0`` for the wheel whose two rows are held, eq. (2)."""
    scene = arrays.random(seed, 3)
    for state in nearest_states(scene, scene.check.equilibrium):
        for row in constraint_matrix(state.rows[0].wheel):
            assert not sum(entry * x for entry, x in zip(row, (*state.twist, 1), strict=True))


@pytest.mark.parametrize("seed", SEEDS)
def test_twists_agree_with_a_float_solve(arrays: Arrays, seed: int) -> None:
    for state in regular_states(arrays.random(seed, 4)):
        rows = np.array([float_row(row) for row in state.rows])
        twist = [float(x) for x in state.twist]
        residual = rows[:, :3] @ twist - rows[:, 3]
        assert np.abs(residual).max() < ROUNDING * (1 + np.abs(twist).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_singular_triples_are_those_of_deficient_rank(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 4)
    rows = scene_rows(scene)
    for triple in combinations(rows, 3):
        rank = np.linalg.matrix_rank([float_row(row)[:3] for row in triple], tol=RANK_TOLERANCE)
        state = solve_rows(triple)
        assert (state is None) == (rank < 3) == (len(independent([row.normal for row in triple])) < 3)
    regular = [state for triple in combinations(rows, 3) if (state := solve_rows(triple)) is not None]
    assert regular_states(scene) == regular


@pytest.mark.parametrize("seed", SEEDS)
def test_control_fields_superpose_to_the_twist(arrays: Arrays, seed: int) -> None:
    """``xi = sum_w g_w u_w`` with the scene's speeds, and side rows carry no input (Definition 2, eq. 6)."""
    for state in regular_states(arrays.random(seed, 4)):
        speeds = {row.wheel.index: row.wheel.speed for row in state.rows if row.kind is RowKind.ROLL}
        assert state.control_fields.keys() == speeds.keys()
        zero = state.twist.omega.field.zero
        for axis in range(3):
            total = sum((g[axis] * speeds[w] for w, g in state.control_fields.items()), zero)
            assert total == state.twist[axis]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_control_field_answers_one_unit_input(arrays: Arrays, seed: int) -> None:
    """g_w moves wheel w's contact by 1 along its rim and meets every other row at rest."""
    for state in regular_states(arrays.random(seed, 3)):
        for index, g in state.control_fields.items():
            for row in state.rows:
                product = sum(a * x for a, x in zip(row.normal, g, strict=True))
                driven = row.kind is RowKind.ROLL and row.wheel.index == index
                assert product == (row.wheel.length if driven else 0)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_control_fields_have_the_rank_of_the_rolling_rows(arrays: Arrays, seed: int) -> None:
    ranks = set()
    for state in regular_states(arrays.random(seed, 4)):
        fields = np.array([[float(x) for x in g] for g in state.control_fields.values()])
        expected = np.linalg.matrix_rank(fields, tol=RANK_TOLERANCE) if len(fields) else 0
        assert (
            len(independent(list(state.control_fields.values())))
            == expected
            == sum(row.kind is RowKind.ROLL for row in state.rows)
        )
        ranks.add(len(independent(list(state.control_fields.values()))))
    assert len(ranks) > 1


@pytest.mark.parametrize("seed", SEEDS)
def test_pose_rate_moves_the_body_point_at_the_centre_of_mass(arrays: Arrays, seed: int) -> None:
    """``c' = v + omega J c``, so at a wheel's position the pose rate is the velocity of its contact."""
    scene = arrays.random(seed, 4)
    for state in regular_states(scene)[:10]:
        for wheel in scene.wheels:
            x, y = state.twist.pose_rate(wheel.position)
            a, b = wheel.direction
            roll, side = wheel_rows(wheel)
            assert roll.residual(state.twist) == a * x + b * y - wheel.length * wheel.speed
            assert side.residual(state.twist) == a * y - b * x


# ---- census --------------------------------------------------------------------------------------


def test_census_of_the_four_wheel_array(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    census = take_census(scene)
    assert census == ContactCensus(possible=56, singular=16, distinct_twists=13)
    assert census.regular == 40
    partition = build_nearest_partition(scene)
    assert len(partition.cells) == len(partition.states) == 8


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_census_agrees_with_a_float_count(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    rows = [float_row(row) for row in scene_rows(scene)]
    systems = np.array(list(combinations(rows, 3)))
    regular = systems[np.linalg.matrix_rank(systems[:, :, :3], tol=RANK_TOLERANCE) == 3]
    twists = np.linalg.solve(regular[:, :, :3], regular[:, :, 3:])[:, :, 0]
    distinct, left = 0, twists
    while len(left):
        distinct += 1
        left = left[np.abs(left - left[0]).max(axis=1) > RANK_TOLERANCE]
    possible = math.comb(len(rows), 3)
    assert possible == possible_triples(len(scene.wheels))
    assert take_census(scene) == ContactCensus(possible, possible - len(twists), distinct)


# ---- eqs. (3) and (4) as printed -----------------------------------------------------------------


def printed_equation(number: int, x: Number, y: Number, root: Number) -> Twist:
    """Eqs. (3), mu_S > mu_R, and (4), mu_S < mu_R, off their switching lines."""
    s, sign = (y * y - x * x).sign(), 1 if number == 3 else -1
    turn = (x * y * y * y - x * x * x * y).sign()
    return Twist(-root / 2 * x.sign() * (1 + sign * s), -root / 2 * y.sign() * (1 - sign * s), -sign * root / 2 * turn)


@pytest.mark.parametrize(("name", "number"), [("four-wheel-side", 3), ("four-wheel", 4)])
def test_cells_reproduce_the_printed_equations(arrays: Arrays, name: str, number: int) -> None:
    partition = build_nearest_partition(load_scene(name, radius="2"))
    root, rng = partition.scene.field.sqrt(2), np.random.default_rng(0)
    assert len(partition.cells) == 8
    for cell in partition.cells:
        for _ in range(5):
            point = arrays.interior_point(cell.polygon, rng)
            assert cell.twists == (printed_equation(number, *point, root),)


# ---- regular rings -------------------------------------------------------------------------------


def ring_state(field: NumberField, n: int, a: int, sense: int) -> dict[str, Twist]:
    """Closed forms for nearest wheel a (angle ``2 pi a/n``) and second wheel a + sense, ``delta = 2 pi/n``."""
    half = Fraction(1, n)  # delta/2 as a multiple of pi
    cos, sin = field.cos_pi(half), field.sin_pi(half)
    roll = (2 * a + sense) * half
    side = 2 * a * half - sense * (Fraction(1, 2) - half)
    return {
        "roll": Twist(-field.cos_pi(roll) / cos, -field.sin_pi(roll) / cos, sense * sin / cos),
        "side": Twist(-field.cos_pi(side) / sin, -field.sin_pi(side) / sin, -sense * cos / sin),
    }


def neighbours(partition: Partition, n: int) -> list[tuple[int, int, Twist]]:
    """(nearest wheel, +1 or -1 for its second wheel, twist) for every cell."""
    found = []
    for cell in partition.cells:
        nearest, second = cell.wheels
        step = (second - nearest) % n
        assert step in (1, n - 1)
        (twist,) = cell.twists
        found.append((nearest - 1, 1 if step == 1 else -1, twist))
    return found


@few(4)
@pytest.mark.parametrize("third", ["roll", "side"])
@pytest.mark.parametrize("n", RINGS)
def test_rings_have_the_closed_form_twists(arrays: Arrays, n: int, third: str) -> None:
    scene = arrays.ring(n, ROLL if third == "roll" else SIDE)
    cells = neighbours(build_nearest_partition(scene), n)
    assert len(cells) == 2 * n
    assert len({(a, sense) for a, sense, _ in cells}) == 2 * n
    for a, sense, twist in cells:
        assert twist == ring_state(scene.field, n, a, sense)[third]


@pytest.mark.parametrize("n", RINGS)
def test_the_exact_closed_forms_are_the_floating_ones(n: int, arrays: Arrays) -> None:
    """Guards the test above against a slip in the field's own cosines."""
    field = arrays.ring(n).field
    delta = 2 * math.pi / n
    for a in range(n):
        for sense in (1, -1):
            exact = ring_state(field, n, a, sense)
            angle = a * delta + sense * delta / 2
            roll = [-math.cos(angle), -math.sin(angle), sense * math.sin(delta / 2)]
            assert [float(x) for x in exact["roll"]] == pytest.approx(
                [x / math.cos(delta / 2) for x in roll], abs=ROUNDING
            )
            angle = a * delta - sense * (math.pi / 2 - delta / 2)
            side = [-math.cos(angle), -math.sin(angle), -sense * math.cos(delta / 2)]
            assert [float(x) for x in exact["side"]] == pytest.approx(
                [x / math.sin(delta / 2) for x in side], abs=ROUNDING
            )


# ---- Governing equations: annihilators, control vector fields, and both coordinates --------------

RADICAL = ("four-wheel", "rectangle", "off-center")  # SymPy decides sums of square roots by expanding
FEW_SEEDS = range(6)

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
        twist = governing_equations(state, symbolic_inputs=True).to_sympy()
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


@few(1)
@pytest.mark.parametrize("seed", FEW_SEEDS)
def test_control_fields_agree_with_an_lu_solve(arrays: Arrays, seed: int) -> None:
    for state in regular_states(arrays.random(seed, 3))[::4]:
        rows = stacked_constraints(state, symbolic_input=True)
        solution = rows[:, :3].LUsolve(-rows[:, 3])
        derived = governing_equations(state, symbolic_inputs=True).to_sympy()
        assert all(sympy.simplify(a - b) == 0 for a, b in zip(solution, derived, strict=True))


# ---- governing equations in both coordinates -----------------------------------------------------


@pytest.mark.parametrize("seed", FEW_SEEDS)
def test_body_equations_are_the_pose_rate(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 3)
    x, y = scene.check.equilibrium
    for state in regular_states(scene):
        equations = governing_equations(state, Coordinates.BODY)
        values = {"x": x, "y": y}
        expected = (*state.twist.pose_rate((x, y)), state.twist.omega)
        assert tuple(value_of(formula, values) for formula in equations.right) == expected


@pytest.mark.parametrize("seed", FEW_SEEDS)
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
    assert not state.control_fields
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
