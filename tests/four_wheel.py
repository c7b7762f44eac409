"""The paper's array in numbers: four wheels at the corners of a square, and two orders of the friction coefficients."""

from __future__ import annotations

from fractions import Fraction

CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
ROLL = (1, Fraction(1, 2))  # (mu_R, mu_S) with mu_S < mu_R: the third row is a roll row, eq. (4)
SIDE = (Fraction(1, 2), 1)  # mu_S > mu_R: the third row is a side row, eq. (3)
