"""Contact states close to singular: the rim of the second wheel turned until it nearly points at the first.

With both rows of wheel i and the roll row of wheel j the determinant is ``d_j . J(p_j - p_i)``: zero where the rim line
of j passes through i, as with inward rims and wheels in line with the equilibrium.  Speeds grow like its inverse, and
float elimination loses as many digits as the determinant has zeros; the exact solution, rounded once, loses none.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from flint import arb_mat

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.references.reference_fields import ball
from nonsmooth.analysis.measurements.references.taylor import precision
from nonsmooth.analysis.measurements.rows import EPSILON, ResultRow, Rows, judged
from nonsmooth.symbolic.constraints import Row, roll_row, side_row
from nonsmooth.symbolic.contact_states import solve_rows
from nonsmooth.symbolic.scene import Scene, Wheel

CASE = "wheels nearly in line, twist"
DETERMINANTS = (3, 6, 9, 12, 14)  # minus powers of ten, relative to the distance of the wheels
ROUNDINGS = 4  # of an exact number rounded once, and its unit


def nearly_in_line(scene: Scene, power: int) -> Scene:
    """The first two wheels on different places, the rim of the second turned to a determinant of ``10**-power``."""
    first = scene.wheels[0]
    second = next(wheel for wheel in scene.wheels if wheel.position != first.position)
    return replace(scene, wheels=tuple(_turned(first, w, power) if w is second else w for w in scene.wheels))


def _turned(first: Wheel, wheel: Wheel, power: int) -> Wheel:
    """Its rim turned away from the line of both wheels by an angle of rational sine and cosine: no new square roots."""
    x, y = (a - b for a, b in zip(wheel.position, first.position, strict=True))
    t = Fraction(1, 2 * 10**power)
    cosine, sine = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    return replace(wheel, direction=(x * cosine - y * sine, x * sine + y * cosine), given_speed=wheel.speed)


def collinear_rows(scene: Scene) -> Rows:
    """The twist of the state of the two wheels, against elimination at 60 digits."""
    for power in DETERMINANTS:
        turned_scene = nearly_in_line(scene, power)
        first = turned_scene.wheels[0]
        second = next(wheel for wheel in turned_scene.wheels if wheel.position != first.position)
        yield _row(f"1e-{power}", (roll_row(first), side_row(first), roll_row(second)))


def _row(parameter: str, rows: tuple[Row, Row, Row]) -> ResultRow:
    state = solve_rows(rows)
    if state is None:
        raise ValueError("required independent rows, received dependent ones")
    truth, condition = _by_elimination(rows)
    found = np.array([float(entry) for entry in state.twist])
    largest = float(np.abs(truth).max()) or 1.0
    error = float(np.abs(found - truth).max()) / largest
    verdict = f"omega = {found[2]:.6g}"
    why = "exact and rounded once, whatever the condition"
    return judged(CASE, parameter, verdict, error, ROUNDINGS * EPSILON, condition=condition, why=why)


def _by_elimination(rows: tuple[Row, Row, Row]) -> tuple[Floats, float]:
    """Twist at 60 digits, and the condition of the rows of unit length."""
    with precision():
        lengths = [ball(row.wheel.grip_length) for row in rows]
        matrix = [[ball(a) / length for a in row.normal] for row, length in zip(rows, lengths, strict=True)]
        right = [[ball(row.rhs) / length] for row, length in zip(rows, lengths, strict=True)]
        solved = arb_mat(matrix).solve(arb_mat(right))
        twist = np.array([float(solved[k, 0].mid()) for k in range(3)])
        entries = np.array([[float(entry.mid()) for entry in row] for row in matrix])
    scale = np.abs(entries).max(axis=0)
    return twist, float(np.linalg.cond(entries / np.where(scale > 0, scale, 1.0)))


COLLINEAR = Case("contact states", array=collinear_rows)
