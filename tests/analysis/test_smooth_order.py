"""DOP853 with events on a field that is not constant: the error of a path is proportional to the tolerance."""

from __future__ import annotations

from functools import partial

import mpmath
import numpy as np
import pytest

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import affine_surface
from nonsmooth.analysis.measurements.harness import log_slope
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.analysis.trajectories.steppers import StiffAware

DIGITS = 60
DECAY = 10  # A = N - 1/DECAY, the flower of Johansson and Rantzer
TURNS = (((0, 1), (-5, 0)), ((0, 5), (-1, 0)))  # N where |x| > |y| and elsewhere: N^2 = -5
START, UNTIL = (1.0, 0.25), 5.0
TOLERANCES = [10.0**-k for k in range(3, 12)]
WITHIN = 0.2


def flow(time: mpmath.mpf, x: mpmath.matrix, cell: int) -> mpmath.matrix:
    """``e^(A t) x = e^(-t/10) (cos(r t) + sin(r t)/r N) x`` with ``r = sqrt(5)``."""
    root = mpmath.sqrt(5)
    turned = mpmath.matrix(TURNS[cell]) * x
    return mpmath.exp(-time / DECAY) * (mpmath.cos(root * time) * x + mpmath.sin(root * time) / root * turned)


def time_to(line: int, x: mpmath.matrix, cell: int) -> mpmath.mpf:
    """First positive time at which ``x + line y = 0``: tan(r t) solves a linear equation."""
    root = mpmath.sqrt(5)
    turned = mpmath.matrix(TURNS[cell]) * x
    angle = mpmath.atan2(-(x[0] + line * x[1]) * root, turned[0] + line * turned[1]) % mpmath.pi
    return (angle if angle > mpmath.mpf(10) ** (-DIGITS // 2) else mpmath.pi) / root


def exact_end() -> mpmath.matrix:
    """The solution at the last time; each cell is left over whichever diagonal comes first."""
    x, left, cell = mpmath.matrix(START), mpmath.mpf(UNTIL), 0
    while True:
        time = min(time_to(line, x, cell) for line in (1, -1))
        if time > left:
            return flow(left, x, cell)
        x, left, cell = flow(time, x, cell), left - time, 1 - cell


def linear(matrix: np.ndarray, t: float, x: np.ndarray) -> np.ndarray:
    return np.asarray(matrix @ x)


def test_errors_are_proportional_to_the_tolerance() -> None:
    """Tolerances 1e-3 to 1e-11, 13 crossings, against closed forms to sixty digits."""
    matrices = [np.array(turn) - np.eye(2) / DECAY for turn in TURNS]
    surfaces = (affine_surface("x - y", (1, -1)), affine_surface("x + y", (1, 1)))
    field = SignField(("x", "y"), surfaces, lambda s: partial(linear, matrices[0 if s[0] * s[1] > 0 else 1]))
    with mpmath.workdps(DIGITS):
        end, errors = exact_end(), []
        for tolerance in TOLERANCES:
            path = follow_smooth(field, START, UNTIL, stepper=StiffAware(tolerance, tolerance, field.size))
            assert len(path.events) == 13
            errors.append(max(abs(float(exact - found)) for exact, found in zip(end, path.end.state, strict=True)))
    assert log_slope(TOLERANCES, errors) == pytest.approx(1, abs=WITHIN)
