"""Theorem 4's pair of wheels, for symbolic geometry, and what the paper displays of it."""

from __future__ import annotations

import pytest
import sympy

from nonsmooth.reports.papers.murphey_burdick_2001.pair_equations import PairEquations, closed_form, pair_equations
from nonsmooth.reports.papers.murphey_burdick_2001.printed_equations import (
    theorem_4_kinematics,
    theorem_4_rate,
    theorem_4_symbols,
)
from nonsmooth.symbolic.constraints import RowKind, roll_row, side_row
from nonsmooth.symbolic.contact_states import solve_rows
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.scene import Wheel


@pytest.mark.parametrize("kind", RowKind)
def test_cofactors_reach_the_closed_form(kind: RowKind) -> None:
    assert pair_equations(kind).equals(closed_form(kind))


@pytest.mark.parametrize("kind", RowKind)
def test_the_closed_form_of_the_other_row_is_not_reached(kind: RowKind) -> None:
    other = RowKind.SIDE if kind is RowKind.ROLL else RowKind.ROLL
    assert not pair_equations(kind).equals(closed_form(other))


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
        twist = equations.twist.subs(values)
        assert all(sympy.simplify(a - b.to_sympy()) == 0 for a, b in zip(twist, state.twist, strict=True))


def wheel_values(wheel: Wheel, name: str) -> dict[sympy.Symbol, sympy.Expr]:
    numbers = (*wheel.position, *wheel.unit_direction, wheel.speed)
    return {
        sympy.Symbol(f"{letter}_{name}", real=True): n.to_sympy() for letter, n in zip("xycsu", numbers, strict=True)
    }


@pytest.fixture(scope="module")
def pair() -> PairEquations:
    return pair_equations()


def test_theorem_4_displays_the_kinematics_of_the_pair(pair: PairEquations) -> None:
    assert all(sympy.simplify(a - b) == 0 for a, b in zip(pair.paper_form(), theorem_4_kinematics(), strict=True))


def test_theorem_4_displays_half_of_the_rate(pair: PairEquations) -> None:
    assert sympy.simplify(pair.paper_rate() - 2 * theorem_4_rate()) == 0


def test_theorem_4_is_wrong_for_plain_speeds_of_wheel_j(pair: PairEquations) -> None:
    """Without the factor |p_2| in u_j the display differs: the identity is not vacuous."""
    x2, y2, uj = (theorem_4_symbols()[k] for k in (2, 3, 6))
    plain = pair.paper_form().subs(uj, uj * sympy.sqrt(x2**2 + y2**2))
    assert any(sympy.simplify(a - b) != 0 for a, b in zip(plain, theorem_4_kinematics(), strict=True))
