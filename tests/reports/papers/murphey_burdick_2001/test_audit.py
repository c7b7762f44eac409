"""The paper, audited: each finding by an independent computation, and each refuted when the print is changed."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import prod

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.theorem4 import CellCheck, check_cells
from nonsmooth.reports.output.document import Inline, Math, Table
from nonsmooth.reports.papers.murphey_burdick_2001 import audit, sign_form
from nonsmooth.reports.papers.murphey_burdick_2001.audit import (
    RAYS,
    ClaimOutcome,
    CorrectedLaw,
    SymbolicRow,
    agrees,
    audit_equations_3_and_4,
    audit_feedback,
    audit_paper,
    audit_theorem_4_displays,
    audit_translation,
    corrected_law,
    lowest_terms,
    missing_factor,
    pair_rate,
    pair_twist,
    rate_is,
    ray_point,
    rests,
    sign_sets,
    symbolic_row,
    twist_of,
)
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import (
    EQUATION_3,
    EQUATION_4,
    MOST_FACTORS,
    THEOREM_4_KINEMATICS,
    THEOREM_4_RATE,
    Direction,
    SignForm,
    find_sign_form,
    is_paper_array,
    line_factors,
    partition_forms,
    sign_at,
    theta,
    uj,
    x2,
    y2,
)
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import RowKind, roll_row, side_row, solve_rows
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.hulls import hull_holds_zero
from tests.thorough import examples

SAMPLES = 4000
ROUNDING = 1e-9  # V' and V are of order 1 here; sums of a dozen floats


@pytest.fixture(scope="module")
def roll() -> CellCheck:
    """mu_S < mu_R: eq. (4)."""
    return check_cells(load_scene("four-wheel"))


@pytest.fixture(scope="module")
def side() -> CellCheck:
    """mu_S > mu_R: eq. (3)."""
    return check_cells(load_scene("four-wheel-side"))


@pytest.fixture(scope="module")
def laws(roll: CellCheck) -> list[CorrectedLaw]:
    assert isinstance(roll.feedback, FeedbackResult)
    return [corrected_law(data) for data in roll.feedback.cells]


def test_outcomes() -> None:
    outcomes = {finding.item: finding.outcome for finding in audit_paper()}
    assert outcomes == {
        1: ClaimOutcome.CONFIRMED,
        2: ClaimOutcome.CORRECTED,
        3: ClaimOutcome.STRENGTHENED,
        5: ClaimOutcome.CORRECTED,
        6: ClaimOutcome.CORRECTED,
        4: ClaimOutcome.REFUTED,
        7: ClaimOutcome.REFUTED,
        8: ClaimOutcome.CORRECTED,
        9: ClaimOutcome.REFUTED,
    }


def test_the_audit_belongs_to_the_paper_array_only(arrays: Arrays) -> None:
    assert [name for name in builtin_scenes() if is_paper_array(load_scene(name))] == ["four-wheel", "four-wheel-side"]
    assert is_paper_array(arrays.four_wheel())
    assert not is_paper_array(arrays.four_wheel(turn=(Fraction(3, 5), Fraction(4, 5))))


# ---- 1: equations (3) and (4) --------------------------------------------------------------------


def test_both_equations_agree_with_all_cells(roll: CellCheck, side: CellCheck) -> None:
    comparisons = [agrees(EQUATION_4, cell) for cell in roll.partition.cells]
    comparisons += [agrees(EQUATION_3, cell) for cell in side.partition.cells]
    assert len(comparisons) == 16
    assert all(comparisons)


def test_exchanged_equations_agree_with_no_cell(roll: CellCheck, side: CellCheck) -> None:
    assert not any(agrees(EQUATION_3, cell) for cell in roll.partition.cells)
    assert not any(agrees(EQUATION_4, cell) for cell in side.partition.cells)


def test_a_changed_print_is_refuted(roll: CellCheck, side: CellCheck, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = EQUATION_4.as_mutable()
    changed[2] = -changed[2]
    monkeypatch.setattr(audit, "EQUATION_4", changed)
    finding = audit_equations_3_and_4(roll, side)
    assert finding.outcome is ClaimOutcome.REFUTED
    assert "8" in finding.conclusion


# ---- 2: V' and V* --------------------------------------------------------------------------------


def test_the_displayed_rate_lacks_a_factor() -> None:
    assert missing_factor() == sympy.sqrt(2)


def test_a_rate_that_is_no_multiple_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = EQUATION_3.as_mutable()
    changed[0] = changed[0] * 2
    monkeypatch.setattr(audit, "EQUATION_3", changed)
    with pytest.raises(ValueError, match="constant quotient"):
        missing_factor()


def test_upper_derivatives_in_closed_form(roll: CellCheck, side: CellCheck) -> None:
    assert rate_is(side.partition, larger=False)
    assert rate_is(roll.partition, larger=True)
    assert not rate_is(side.partition, larger=True)
    assert not rate_is(roll.partition, larger=False)
    assert audit_translation(side, roll).outcome is ClaimOutcome.REFUTED  # exchanged


def test_what_jumps_on_axes_and_diagonals(side: CellCheck) -> None:
    for name in RAYS:
        x, y, diagonal = (len(signs) for signs in sign_sets(side.partition, ray_point(side.partition, name)))
        if "=" in name:
            assert (x, y, diagonal) == (1, 1, 2)
        else:
            assert (x, y, diagonal) == ((2, 1, 1) if name.startswith("y") else (1, 2, 1))


def test_axes_are_equilibria_of_equation_3_only(roll: CellCheck, side: CellCheck) -> None:
    assert [name for name in RAYS if rests(side.partition, ray_point(side.partition, name))] == [
        "x > 0", "y > 0", "x < 0", "y < 0",
    ]  # fmt: skip
    assert not any(rests(roll.partition, ray_point(roll.partition, name)) for name in RAYS)


# ---- 5: the feedback law -------------------------------------------------------------------------


def test_the_printed_sign_fails_where_g_is_negative(roll: CellCheck, laws: list[CorrectedLaw]) -> None:
    """``g = sgn(x y (y^2 - x^2))``, coded here once more."""
    failing = []
    for cell in roll.partition.cells:
        x, y = (float(value) for value in cell.polygon.centre)
        if x * y * (y * y - x * x) < 0:
            failing.append(cell.index)
    assert [law.data.cell.index for law in laws if law.lever.sign() < 0] == failing
    assert len(failing) == 4


def test_the_proved_rate_is_the_largest(roll: CellCheck, laws: list[CorrectedLaw]) -> None:
    kappa = roll.partition.scene.field.sqrt(2) / 2
    assert len(laws) == 8
    assert all(law.proves(kappa) for law in laws)
    assert not any(law.proves(kappa * Fraction(1001, 1000)) for law in laws)


@pytest.mark.parametrize("corrected", [True, False])
def test_the_rate_in_samples(laws: list[CorrectedLaw], corrected: bool) -> None:
    """``V' = 2 c . v + 2 theta omega`` by the control vector fields: the bound holds for the corrected law alone."""
    rng = np.random.default_rng(20)
    worst = -np.inf
    for law in laws:
        rays = np.array([[float(x) for x in ray] for ray in law.rays])
        fields = {k: np.array([float(x) for x in g]) for k, g in law.data.state.control_fields.items()}
        for _ in range(SAMPLES // len(laws)):
            c, theta = rng.random(len(rays)) @ rays, rng.normal()
            second = -theta * (law.lever.sign() if corrected else 1)
            first = abs(second) + np.hypot(*c)
            twist = fields[law.data.nearest.index] * first + fields[law.data.second.index] * second
            state = np.array([*c, theta])
            worst = max(worst, float(2 * state @ twist + np.sqrt(2) * state @ state))
    assert (worst <= ROUNDING) == corrected


def test_the_law_needs_rims_at_right_angles() -> None:
    skew = check_cells(load_scene("ring-5")).feedback
    assert isinstance(skew, FeedbackResult)
    with pytest.raises(ValueError, match=r"d_i \. d_j = 0"):
        corrected_law(skew.cells[0])


def test_an_unproved_bound_is_refuted(roll: CellCheck, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CorrectedLaw, "proves", lambda self, kappa: False)
    finding = audit_feedback(roll)
    assert finding.outcome is ClaimOutcome.REFUTED


# ---- 6: Theorem 4's displays ---------------------------------------------------------------------


def test_theorem_4_identities() -> None:
    twist = pair_twist()
    assert all(lowest_terms(entry) == 0 for entry in twist - THEOREM_4_KINEMATICS)
    assert lowest_terms(pair_rate(twist) / THEOREM_4_RATE) == 2


def test_a_changed_display_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = THEOREM_4_KINEMATICS.as_mutable()
    changed[0] = -changed[0]
    monkeypatch.setattr(audit, "THEOREM_4_KINEMATICS", changed)
    assert audit_theorem_4_displays().outcome is ClaimOutcome.REFUTED


# ---- items 4, 7, 8, 9: the functional ------------------------------------------------------------


def test_the_shares_of_the_paper_rule_are_one_minus_twice_the_ratio() -> None:
    """The rule's twists minimize D beyond the strips |x| <= mu or |y| <= mu: 1 - 2 mu_S/mu_R, for ratios up to 1/2."""
    (shown,) = (block for block in audit.audit_largest_weights().computed if isinstance(block, Table))
    for row in shown.rows:
        ratio, cells, share, rest = (entry[0] for entry in row)
        value = Fraction(plain_of(ratio))
        assert Fraction(plain_of(share)) == max(Fraction(0), 1 - 2 * value)
        assert Fraction(plain_of(rest)) == (2 * value**2 if value <= Fraction(1, 2) else 1)
        assert int(plain_of(cells)) == (1 if value >= 1 else 5 if value == Fraction(1, 2) else 13)


def test_the_counterexamples_are_shown_with_their_verdicts() -> None:
    finding = audit.audit_every_array()
    (shown,) = finding.computed
    assert isinstance(shown, Table)
    assert {plain_of(row[0][0]): plain_of(row[1][0]) for row in shown.rows} == {
        "off-center": "hypotheses not met", "outward": "fails", "saddle": "fails",
        "differential-drive": "fails",
    }  # fmt: skip
    assert "4 of these 4" in "".join(map(plain_of, finding.conclusion))


def test_the_counterexamples_are_ones() -> None:
    """Nothing holds the body at the point of one; from near the point of the others a path leaves the square."""
    scene = load_scene("off-center").recentred()
    zero = scene.field.zero
    assert not hull_holds_zero(t.velocity for t in filippov_twists(build_nearest_partition(scene), (zero, zero)))
    for name, start in (("outward", (1e-6, 2e-7, 0)), ("saddle", (0, 1e-6, 0))):
        field = array_field(build_nearest_partition(load_scene(name)), Kinematics.LEADING)
        assert simulate(field, start).end.reason is EndReason.OUTSIDE


def plain_of(inline: Inline) -> str:
    return inline.plain if isinstance(inline, Math) else inline if isinstance(inline, str) else inline.text


# ---- Sign forms: the paper's eqs. (3) and (4) as printed, and forms found again from what they say.

FIELD = NumberField()
RANDOM = examples(60)


def directions(*pairs: tuple[int, int]) -> list[Direction]:
    one = FIELD.zero + 1
    return [(one * a, one * b) for a, b in pairs]


def value_at(form: SignForm, point: Direction) -> Number:
    """The sum at a point, term by term."""
    zero = next(iter(form.factors[0].values())) * 0
    signs = [sign_at(factor, point) for factor in form.factors]
    return sum((number * prod(signs[k] for k in product) for number, product in form.terms), zero)


FOUR_LINES = directions((1, 0), (0, 1), (1, 1), (1, -1))
SECTORS = directions((3, 1), (1, 3), (-1, 3), (-3, 1), (-3, -1), (-1, -3), (1, -3), (3, -1))


@pytest.mark.parametrize(("name", "printed"), [("four-wheel-side", EQUATION_3), ("four-wheel", EQUATION_4)])
def test_the_four_wheel_array_gives_the_printed_equations(name: str, printed: sympy.Matrix) -> None:
    partition = build_partition(load_scene(name))
    centres = [cell.polygon.centre for cell in partition.cells]
    for (x, y), (form, expected) in itertools.product(centres, zip(partition_forms(partition), printed, strict=True)):
        assert form is not None
        value = expected.subs({sign_form.x: x.to_sympy(), sign_form.y: y.to_sympy()})
        assert sympy.expand(value_at(form, (x, y)).to_sympy() - value) == 0


def test_the_printed_form_is_kept() -> None:
    forms = partition_forms(build_partition(load_scene("four-wheel-side")))
    assert [form.plain for form in forms if form] == [
        "-sqrt(2)/2 sgn(x) (sgn(y^2 - x^2) + 1)",
        "sqrt(2)/2 sgn(y) (sgn(y^2 - x^2) - 1)",
        "-sqrt(2)/2 sgn(x y^3 - x^3 y)",
    ]
    assert forms[0] is not None
    assert (
        forms[0].latex
        == r"-\frac{\sqrt{2}}{2}\, \operatorname{sgn}(x)\, \left(\operatorname{sgn}(y^2 - x^2) + 1\right)"
    )


@pytest.mark.parametrize("name", ["ring-5", "ring-6", "rectangle", "spiral-30", "saddle", "elliptic"])
def test_a_form_has_the_value_of_every_cell(name: str) -> None:
    partition = build_partition(load_scene(name))
    forms = partition_forms(partition)
    assert any(forms)
    for cell, (k, form) in itertools.product(partition.cells, enumerate(forms)):
        if form is not None:
            x, y = cell.polygon.centre
            corner = next(v for v in cell.polygon.vertices if v[0] or v[1])
            for inner in ((x, y), ((x + corner[0]) / 2, (y + corner[1]) / 2)):
                assert value_at(form, inner) == cell.twists[0][k]


@RANDOM
@given(
    st.tuples(st.integers(-5, 5), st.integers(-5, 5)),
    st.tuples(st.integers(0, 7), st.integers(0, 7)),
)
def test_two_terms_are_found_again(numbers: tuple[int, int], products: tuple[int, int]) -> None:
    """Build the values of ``a sgn(p) + b sgn(q)`` literally; whatever form is found must have them."""
    factors = line_factors(FOUR_LINES)
    assert len(factors) == 3
    samples = []
    for x, y in SECTORS:
        signs = [sign_at(factor, (x, y)) for factor in factors]
        value = FIELD.zero
        for number, product in zip(numbers, products, strict=True):
            term = number
            for k in range(3):
                term *= signs[k] if product >> k & 1 else 1
            value = value + term
        samples.append(((x, y), value))
    form = find_sign_form(factors, samples)
    assert form is not None
    assert all(value_at(form, point) == value for point, value in samples)


def test_values_without_a_short_form_have_none() -> None:
    factors = line_factors(FOUR_LINES)
    values = [FIELD.zero + Fraction(k * k, 3) for k in range(8)]
    assert find_sign_form(factors, list(zip(SECTORS, values, strict=True))) is None
    many = line_factors(directions(*((k, 1) for k in range(1, MOST_FACTORS + 2))))
    assert find_sign_form(many, [((SECTORS[0]), FIELD.zero)]) is None


def test_mirrored_lines_are_one_factor() -> None:
    factors = line_factors(directions((1, 2), (1, -2), (0, 1)))
    assert [sorted(factor) for factor in factors] == [[(1, 0)], [(0, 2), (2, 0)]]
    assert str(factors[1][2, 0]) == "-4"


# ---- Theorem 4's pair of wheels, for symbolic geometry, and what the paper displays of it --------
#
# Positions ``(x_i, y_i), (x_j, y_j)``, headings ``phi_i, phi_j`` and speeds ``u_i, u_j`` are symbols, headings by
# their cosines and sines. Both rows of wheel i and the roll row of wheel j give::
#
#  omega = (u_j - u_i d_i.d_j)/Delta, v = u_i d_i - omega J p_i, Delta = d_j . J(p_j - p_i)
#
# and for a side row the same with ``n_j`` for ``d_j`` and 0 for ``u_j``.


def wheel_symbols(name: str) -> tuple[sympy.Symbol, ...]:
    """``(x, y, cos phi, sin phi, u)`` of a wheel."""
    return tuple(sympy.Symbol(f"{letter}_{name}", real=True) for letter in "xycsu")


def row_of(name: str, kind: RowKind) -> SymbolicRow:
    x, y, c, s, u = wheel_symbols(name)
    if kind is RowKind.ROLL:
        return symbolic_row((c, s), (x, y), u)
    return symbolic_row((-s, c), (x, y), sympy.Integer(0))


def pair_equations(third: RowKind) -> sympy.Matrix:
    return twist_of(row_of("i", RowKind.ROLL), row_of("i", RowKind.SIDE), row_of("j", third))


def closed_form(third: RowKind) -> sympy.Matrix:
    """``(v_x, v_y, omega)`` as stated at the top of this file."""
    xi, yi, ci, si, ui = wheel_symbols("i")
    xj, yj, cj, sj, uj = wheel_symbols("j")
    a, b, speed = (cj, sj, uj) if third is RowKind.ROLL else (-sj, cj, 0)
    lever = b * (xj - xi) - a * (yj - yi)
    omega = (speed - ui * (ci * a + si * b)) / lever
    return sympy.Matrix([ui * ci + omega * yi, ui * si - omega * xi, omega])


def equal(one: sympy.Matrix, other: sympy.Matrix) -> bool:
    """Whether twists are the same for every geometry: numerators vanish modulo ``cos^2 + sin^2 = 1``."""
    return all(vanishes(entry) for entry in one - other)


def vanishes(expression: sympy.Expr) -> bool:
    (_, _, ci, si, _), (_, _, cj, sj, _) = wheel_symbols("i"), wheel_symbols("j")
    circles = [si**2 + ci**2 - 1, sj**2 + cj**2 - 1]
    of_symbols = expression.subs({sympy.cos(theta): ci, sympy.sin(theta): si})
    numerator, _ = sympy.fraction(sympy.cancel(of_symbols))
    return bool(sympy.reduced(numerator, circles, si, sj, ci, cj, order="lex")[1] == 0)


@pytest.mark.parametrize("kind", RowKind)
def test_cofactors_reach_the_closed_form(kind: RowKind) -> None:
    assert equal(pair_equations(kind), closed_form(kind))


@pytest.mark.parametrize("kind", RowKind)
def test_the_closed_form_of_the_other_row_is_not_reached(kind: RowKind) -> None:
    other = RowKind.SIDE if kind is RowKind.ROLL else RowKind.ROLL
    assert not equal(pair_equations(kind), closed_form(other))


@pytest.mark.parametrize("kind", RowKind)
@pytest.mark.parametrize("name", ["off-center", "rectangle"])
def test_pair_equations_give_the_twists_of_contact_states(name: str, kind: RowKind) -> None:
    scene = load_scene(name)
    equations = pair_equations(kind)
    for i, j in ((0, 1), (1, 2), (3, 0)):
        first, second = scene.wheels[i], scene.wheels[j]
        third = roll_row(second) if kind is RowKind.ROLL else side_row(second)
        state = solve_rows((roll_row(first), side_row(first), third))
        assert state is not None
        values = {**wheel_values(first, "i"), **wheel_values(second, "j")}
        twist = equations.subs(values)
        assert all(sympy.simplify(a - b.to_sympy()) == 0 for a, b in zip(twist, state.twist, strict=True))


def wheel_values(wheel: Wheel, name: str) -> dict[sympy.Symbol, sympy.Expr]:
    numbers = (*wheel.position, *wheel.unit_direction, wheel.speed)
    return {symbol: n.to_sympy() for symbol, n in zip(wheel_symbols(name), numbers, strict=True)}


@pytest.fixture(scope="module")
def pair() -> sympy.Matrix:
    return pair_twist()


def test_theorem_4_displays_the_kinematics_of_the_pair(pair: sympy.Matrix) -> None:
    assert equal(pair, THEOREM_4_KINEMATICS)


def test_theorem_4_displays_half_of_the_rate(pair: sympy.Matrix) -> None:
    assert vanishes(pair_rate(pair) - 2 * THEOREM_4_RATE)


def test_theorem_4_is_wrong_for_plain_speeds_of_wheel_j(pair: sympy.Matrix) -> None:
    """Without the factor |p_2| in u_j the display differs: the identity is not vacuous."""
    plain = pair.subs(uj, uj * sympy.sqrt(x2**2 + y2**2))
    assert not equal(plain, THEOREM_4_KINEMATICS)
