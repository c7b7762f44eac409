"""What the paper prints, coded as printed and derived from nothing: the claims an audit compares with.

Murphey & Burdick, "On the Stability and Design of Distributed Manipulation Control Systems" (2001).  Each display is
stated in SymPy, in the paper's own symbols and with whatever slip it holds.
"""

from __future__ import annotations

import sympy
from sympy import cos, sin, sqrt

x, y = sympy.symbols("x y", real=True)

# Eqs. (3) and (4): (x', y', theta') of the four-wheel array for mu_S > mu_R and for mu_S < mu_R.
sgn_x, sgn_y, sgn_squares = map(sympy.sign, (x, y, y**2 - x**2))
turn = sqrt(2) / 2 * sympy.sign(x * y**3 - x**3 * y)
EQUATION_3 = sympy.ImmutableMatrix(
    [-sqrt(2) / 2 * sgn_x * (sgn_squares + 1), sqrt(2) / 2 * sgn_y * (sgn_squares - 1), -turn]
)
EQUATION_4 = sympy.ImmutableMatrix(
    [sqrt(2) / 2 * sgn_x * (sgn_squares - 1), -sqrt(2) / 2 * sgn_y * (sgn_squares + 1), turn]
)

# V' displayed in sec. 3.2 for V = x^2 + y^2 along eq. (3).
RATE_OF_SECTION_3_2 = x * (-sgn_x * (sgn_squares + 1)) + y * (sgn_y * (sgn_squares - 1))

# The proof of Theorem 4 displays (x', y', theta') for a pair of wheels, and V' of V = x^2 + y^2 + theta^2.  The latter
# writes theta both for the angle inside cos and sin and for the orientation of the body, which is theta_b here.
x1, y1, x2, y2, theta, ui, uj = sympy.symbols("x_1 y_1 x_2 y_2 theta u_i u_j", real=True)
theta_b = sympy.Symbol("theta_b", real=True)
c, s = cos(theta), sin(theta)
THEOREM_4_KINEMATICS = sympy.ImmutableMatrix(
    [
        (-(uj * y1) + ui * (c * x1 + s * y1) * y2) / (x2 * y1 - x1 * y2),
        (-(uj * x1) + ui * x2 * (c * x1 + s * y1)) / (-x2 * y1 + x1 * y2),
        (-uj + ui * (c * x2 + s * y2)) / (x2 * y1 - x1 * y2),
    ]
)
THEOREM_4_RATE = (
    ui * (x2 * (c * (theta_b - y * x1) - y * s * y1) + (x * c * x1 + s * (theta_b + x * y1)) * y2)
    - uj * (theta_b - y * x1 + x * y1)
) / (x2 * y1 - x1 * y2)
