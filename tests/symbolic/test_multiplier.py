"""The effective track multiplier: derived with SymPy, and by a calculation that shares nothing with the derivation."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy

from nonsmooth.symbolic.files.scene_file import read_document
from nonsmooth.symbolic.files.vehicle_file import build_vehicle, load_vehicle
from nonsmooth.symbolic.vehicles.multiplier import (
    FORMULA,
    derive_multiplier,
    exact_friction_ratio,
    has_four_equal_wheels,
    weighted_slips_squared,
)

BASE, TRACK, ROLL, SIDE, SPEED = sympy.symbols("L W mu_R mu_S u", positive=True)
CLAIMED = 1 + (SIDE / ROLL) ** 2 * (BASE / TRACK) ** 2


def test_the_derivation_ends_in_the_formula() -> None:
    assert sympy.simplify(derive_multiplier() - CLAIMED) == 0
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
    ratio = exact_friction_ratio(vehicle, vehicle.measured.multiplier)
    assert ratio is not None
    assert 1 + (ratio * vehicle.wheel_base / vehicle.track) ** 2 == vehicle.measured.multiplier
    assert exact_friction_ratio(vehicle, vehicle.scene.field.rational(Fraction(1, 2))) is None


@pytest.mark.parametrize(
    ("change", "value"), [("centre_of_mass", [0.01, 0]), ("rows", 3)], ids=["centre of mass", "six wheels"]
)
def test_the_formula_is_about_four_equal_wheels(change: str, value: object) -> None:
    data, file, path = read_document("jackal")
    other = build_vehicle({**data, "vehicle": {**data["vehicle"], change: value}}, file, path)
    assert has_four_equal_wheels(load_vehicle("jackal"))
    assert not has_four_equal_wheels(other)
    assert exact_friction_ratio(other, other.scene.field.rational(2)) is None
