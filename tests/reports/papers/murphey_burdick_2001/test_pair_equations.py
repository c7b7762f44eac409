"""Theorem 4's pair of wheels, for symbolic geometry, and what the paper displays of it.

Positions ``(x_i, y_i), (x_j, y_j)``, headings ``phi_i, phi_j`` and speeds ``u_i, u_j`` are symbols, headings by their
cosines and sines.  Both rows of wheel i and the roll row of wheel j give::

    omega = (u_j - u_i d_i.d_j)/Delta,   v = u_i d_i - omega J p_i,   Delta = d_j . J(p_j - p_i)

and for a side row the same with ``n_j`` for ``d_j`` and 0 for ``u_j``.
"""

from __future__ import annotations

import pytest
import sympy

from nonsmooth.reports.papers.murphey_burdick_2001.audit import (
    SymbolicRow,
    pair_rate,
    pair_twist,
    symbolic_row,
    twist_of,
)
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import (
    THEOREM_4_KINEMATICS,
    THEOREM_4_RATE,
    theta,
    uj,
    x2,
    y2,
)
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import RowKind, roll_row, side_row
from nonsmooth.symbolic.mechanics.contact_states import solve_rows
from nonsmooth.symbolic.mechanics.scene import Wheel


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
