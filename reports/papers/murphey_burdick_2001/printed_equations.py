"""What the paper prints, coded as printed and derived from nothing: the claims an audit compares with.

Murphey & Burdick, "On the Stability and Design of Distributed Manipulation Control Systems" (2001).  Each function
returns a displayed formula in SymPy, in the paper's own symbols and with whatever slip it holds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy


def plane_symbols() -> tuple[sympy.Symbol, sympy.Symbol]:
    """``(x, y)``, real."""
    import sympy

    x, y = sympy.symbols("x y", real=True)
    return x, y


def equation_3() -> sympy.Matrix:
    """Eq. (3): ``(x', y', theta')`` of the four-wheel array for ``mu_S > mu_R``."""
    import sympy

    x, y = plane_symbols()
    half, sgn = sympy.sqrt(2) / 2, sympy.sign
    return sympy.Matrix(
        [
            -half * sgn(x) * (sgn(y**2 - x**2) + 1),
            half * sgn(y) * (sgn(y**2 - x**2) - 1),
            -half * sgn(x * y**3 - x**3 * y),
        ]
    )


def equation_4() -> sympy.Matrix:
    """Eq. (4): ``(x', y', theta')`` of the four-wheel array for ``mu_S < mu_R``."""
    import sympy

    x, y = plane_symbols()
    half, sgn = sympy.sqrt(2) / 2, sympy.sign
    return sympy.Matrix(
        [
            half * sgn(x) * (sgn(y**2 - x**2) - 1),
            -half * sgn(y) * (sgn(y**2 - x**2) + 1),
            half * sgn(x * y**3 - x**3 * y),
        ]
    )


def rate_of_section_3_2() -> sympy.Expr:
    """V' displayed in sec. 3.2 for ``V = x^2 + y^2`` along eq. (3)."""
    import sympy

    x, y = plane_symbols()
    sgn = sympy.sign
    return x * (-sgn(x) * (sgn(y**2 - x**2) + 1)) + y * (sgn(y) * (sgn(y**2 - x**2) - 1))


def theorem_4_symbols() -> tuple[sympy.Symbol, ...]:
    """``(x_1, y_1, x_2, y_2, theta, u_i, u_j)`` of Theorem 4's displays."""
    import sympy

    return tuple(sympy.symbols("x_1 y_1 x_2 y_2 theta u_i u_j", real=True))


def theorem_4_kinematics() -> sympy.Matrix:
    """``(x', y', theta')`` displayed in the proof of Theorem 4."""
    import sympy

    x1, y1, x2, y2, theta, ui, uj = theorem_4_symbols()
    projected = sympy.cos(theta) * x1 + sympy.sin(theta) * y1
    return sympy.Matrix(
        [
            (-(uj * y1) + ui * projected * y2) / (x2 * y1 - x1 * y2),
            (-(uj * x1) + ui * x2 * projected) / (-x2 * y1 + x1 * y2),
            (-uj + ui * (sympy.cos(theta) * x2 + sympy.sin(theta) * y2)) / (x2 * y1 - x1 * y2),
        ]
    )


def theorem_4_rate() -> sympy.Expr:
    """V' displayed in the proof of Theorem 4 for ``V = x^2 + y^2 + theta^2``.

    The display writes theta both for the angle inside cos and sin and for the body's orientation; the latter
    is ``theta_b`` here, so that the two can be told apart.
    """
    import sympy

    x1, y1, x2, y2, theta, ui, uj = theorem_4_symbols()
    x, y = plane_symbols()
    body = sympy.Symbol("theta_b", real=True)
    cos, sin = sympy.cos(theta), sympy.sin(theta)
    first = x2 * (cos * (body - y * x1) - y * sin * y1) + (x * cos * x1 + sin * (body + x * y1)) * y2
    return (ui * first - uj * (body - y * x1 + x * y1)) / (x2 * y1 - x1 * y2)
