"""The effective track multiplier of an in-place turn of four equal wheels, derived with SymPy.

Wheels at ``(+-L/2, +-W/2)`` that head forward, left ones at the speed ``-u``, right ones at ``u``.  The vehicle turns
about its middle at the rate omega.  By its symmetries all four weighted slips have the same size, so under rule
``ellipse`` the dissipation is a constant times the root of one quadratic in omega, least where that is least.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.vehicles.vehicle import Vehicle

if TYPE_CHECKING:
    import sympy

FORMULA = "1 + (mu_S/mu_R)^2 (L/W)^2"  # what derive_multiplier returns, as people write it


def derive_multiplier() -> sympy.Expr:
    """``2 u/(omega W)`` at the omega that minimizes the dissipation of rule ``ellipse``, in L, W, mu_R, mu_S.

    Raises:
        ArithmeticError: where the weighted slips are not alike, which would refute the derivation.
    """
    import sympy

    track, omega, speed = sympy.Symbol("W", positive=True), sympy.Symbol("omega"), sympy.Symbol("u", positive=True)
    squares = {sympy.expand(square) for square in weighted_slips_squared()}
    if len(squares) != 1:
        raise ArithmeticError(f"required one size of all weighted slips, received {len(squares)}")
    (rate,) = sympy.solve(sympy.diff(squares.pop(), omega), omega)
    return sympy.simplify(2 * speed / (rate * track))


def weighted_slips_squared() -> list[sympy.Expr]:
    """``mu_R^2 r_i^2 + mu_S^2 s_i^2`` of the four wheels, in omega, u, L, W, mu_R and mu_S."""
    import sympy

    base, track, speed, roll, side = sympy.symbols("L W u mu_R mu_S", positive=True)
    omega = sympy.Symbol("omega")
    squares = []
    for ahead in (1, -1):
        for left in (1, -1):
            x, y = ahead * base / 2, left * track / 2
            along, across = -omega * y + left * speed, omega * x  # v(p) = omega J p, less u_i d_i with u_i = -left u
            squares.append((roll * along) ** 2 + (side * across) ** 2)
    return squares


def has_four_equal_wheels(vehicle: Vehicle) -> bool:
    """Whether the formula is about this vehicle: four wheels of one friction, centre of mass in their middle."""
    if vehicle.track is None or vehicle.wheel_base is None or any(vehicle.centre_of_mass):
        return False
    x, y = vehicle.wheel_base / 2, vehicle.track / 2
    wheels = vehicle.scene.wheels
    places = {wheel.position for wheel in wheels}
    heads = all(wheel.axis is None and not wheel.direction[1] for wheel in wheels)
    alike = len({wheel.friction for wheel in wheels}) == 1 and vehicle.scene.contact.loads is None
    return heads and alike and len(wheels) == 4 and places == {(x, y), (x, -y), (-x, y), (-x, -y)}


def exact_friction_ratio(vehicle: Vehicle, multiplier: Number) -> Number | None:
    """``mu_S/mu_R = sqrt(m - 1) W/L``, the inverse of the formula; None for other vehicles, and for m < 1."""
    if not has_four_equal_wheels(vehicle) or vehicle.track is None or vehicle.wheel_base is None:
        return None
    excess = multiplier - 1
    return None if excess.sign() < 0 else excess.sqrt() * vehicle.track / vehicle.wheel_base
