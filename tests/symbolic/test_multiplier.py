"""The effective track multiplier: derived with SymPy, and by a calculation that shares nothing with the derivation."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy

from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.vehicle_file import build_vehicle, load_vehicle
from nonsmooth.symbolic.mechanics.vehicles import FORMULA

BASE, TRACK, ROLL, SIDE, SPEED = sympy.symbols("L W mu_R mu_S u", positive=True)
OMEGA = sympy.Symbol("omega")
CLAIMED = 1 + (SIDE / ROLL) ** 2 * (BASE / TRACK) ** 2


def weighted_slips_squared() -> list[sympy.Expr]:
    """``mu_R^2 r_i^2 + mu_S^2 s_i^2`` of four wheels at ``(+-L/2, +-W/2)``, left ones at the speed ``-u``."""
    squares = []
    for ahead in (1, -1):
        for left in (1, -1):
            x, y = ahead * BASE / 2, left * TRACK / 2
            along, across = -OMEGA * y + left * SPEED, OMEGA * x  # v(p) = omega J p, less u_i d_i with u_i = -left u
            squares.append((ROLL * along) ** 2 + (SIDE * across) ** 2)
    return squares


def test_the_derivation_ends_in_the_formula() -> None:
    """All weighted slips are alike, so D is the root of one quadratic, least where that is least."""
    square = sympy.expand(weighted_slips_squared()[0])
    (rate,) = sympy.solve(sympy.diff(square, OMEGA), OMEGA)
    assert sympy.simplify(2 * SPEED / (rate * TRACK) - CLAIMED) == 0
    written = FORMULA.replace("(mu_S/mu_R)", "(mu_S/mu_R)*1").replace("^2 (L", "**2*(L").replace("^2", "**2")
    assert sympy.simplify(sympy.parse_expr(written.replace("*1**2", "**2"), _names()) - CLAIMED) == 0


def _names() -> dict[str, sympy.Symbol]:
    return {"L": BASE, "W": TRACK, "mu_R": ROLL, "mu_S": SIDE}


def test_forces_balance_at_the_formulas_rate_and_nowhere_else() -> None:
    """Newton's own words: at the rate of the formula the moments of the friction ellipses cancel, symbolically."""
    omega = sympy.Symbol("omega", positive=True)
    forces, moment = sympy.zeros(2, 1), sympy.Integer(0)
    for ahead in (1, -1):
        for left in (1, -1):
            x, y = ahead * BASE / 2, left * TRACK / 2
            along, across = -omega * y + left * SPEED, omega * x
            size = sympy.sqrt((ROLL * along) ** 2 + (SIDE * across) ** 2)
            fx, fy = -(ROLL**2) * along / size, -(SIDE**2) * across / size
            forces += sympy.Matrix([fx, fy])
            moment += x * fy - y * fx
    assert sympy.simplify(forces) == sympy.zeros(2, 1)
    rates = sympy.solve(sympy.numer(sympy.together(sympy.simplify(moment))), omega)
    assert [sympy.simplify(2 * SPEED / (TRACK * rate) - CLAIMED) for rate in rates] == [0]


def test_all_weighted_slips_are_alike() -> None:
    first, *others = (sympy.expand(square) for square in weighted_slips_squared())
    assert others == [first] * 3


@pytest.mark.parametrize("name", ["jackal", "warthog"])
def test_the_ratio_is_the_inverse_of_the_formula(name: str) -> None:
    vehicle = load_vehicle(name)
    assert vehicle.track is not None
    assert vehicle.wheel_base is not None
    assert vehicle.measured is not None
    ratio = vehicle.friction_ratio(vehicle.measured)
    assert ratio is not None
    assert 1 + (ratio * vehicle.wheel_base / vehicle.track) ** 2 == vehicle.measured
    assert vehicle.friction_ratio(vehicle.scene.field.rational(Fraction(1, 2))) is None


@pytest.mark.parametrize(
    ("change", "value"), [("centre_of_mass", [0.01, 0]), ("rows", 3)], ids=["centre of mass", "six wheels"]
)
def test_the_formula_is_about_four_equal_wheels(change: str, value: object) -> None:
    data, file, path = read_document("jackal")
    other = build_vehicle({**data, "vehicle": {**data["vehicle"], change: value}}, file, path)
    assert load_vehicle("jackal").has_four_equal_wheels
    assert not other.has_four_equal_wheels
    assert other.friction_ratio(other.scene.field.rational(2)) is None
