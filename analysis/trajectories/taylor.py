"""Taylor series of affine motions, ``x' = A x + b``: steps of two radians, and nothing but rounding errs.

With ``s = rho (t - t_0)`` and rho a bound on the eigenvalues of A, or one where all are zero, the coefficients of
``x = c_0 + c_1 s + c_2 s^2 + ...`` are::

    c_0 = x(t_0),   c_1 = (A x(t_0) + b)/rho,   c_k = A c_(k-1)/(k rho)

A step is as long as the last two of them are rounding beside the states (Jorba and Zou 2005, Exp. Math. 14); it has no
limit where the motion is a polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from nonsmooth.analysis.fields.float_code import Numbers, compiled, listed, names
from nonsmooth.analysis.fields.switched_field import AffineVelocity
from nonsmooth.analysis.trajectories.follow import DenseStep, PolynomialInterpolant
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.numbers.plane_arrays import Floats

DEGREE = 24
LEFT_OUT = 1e-17  # the last coefficients of a step, relative to the first
LONGEST = 2.0  # step, in units of 1/rho: a state that turns has one extremum at most within it
EASY = 0.5  # the same, from which on more than two states may have several
DRAWN, OF_A_POLYNOMIAL = 0.25, 4  # radians within which a path has a sample, and parts of a polynomial
WORK = 12  # evaluations of a field that cost as much as a step


class SeriesCode(NamedTuple):
    """Functions of single floats, one by one.

    Attributes:
        series: from A and b over rho, row by row, and the states where a step begins: the coefficients of each state,
            and the largest of the first two, of those before the last and of the last.
        value: from s and coefficients.
        sloped: the same with its derivative by s.
    """

    series: Callable[..., tuple[tuple[Numbers, ...], float, float, float]]
    value: Callable[..., Any]
    sloped: Callable[..., tuple[float, float]]


@cache
def series_code(count: int) -> SeriesCode:
    """The functions for so many states."""
    states, degrees = range(count), range(DEGREE + 1)
    a, b, c = [names(f"a{i}_", count) for i in states], names("b", count), [names(f"c{k}_", count) for k in degrees]
    lines = []
    for k in degrees[1:]:
        for i in states:
            products = " + ".join(f"{a[i][j]}*{c[k - 1][j]}" for j in states)
            lines.append(f"{c[k][i]} = {products} + {b[i]}" if k == 1 else f"{c[k][i]} = ({products})*{1 / k!r}")
    sizes = [", ".join(f"abs({own})" for k in chosen for own in c[k]) for chosen in ((0, 1), (DEGREE - 1,), (DEGREE,))]
    series = listed(f"({listed(own[i] for own in c)})" for i in states)
    lines.append(f"return ({series}), {', '.join(f'max({own}, 0.0)' for own in sizes)}")
    powers = names("c", DEGREE + 1)
    value = "".join(f"{own} + s*(" for own in powers[:-1]) + powers[-1] + ")" * DEGREE
    steps = [line for own in reversed(powers[:-1]) for line in ("d = d*s + v", f"v = v*s + {own}")]  # Horner's
    arguments = "s, " + listed(powers)
    return SeriesCode(
        compiled("".join(map(listed, (*a, b, c[0]))), *lines),
        compiled(arguments, f"return {value}"),
        compiled(arguments, f"v, d = {powers[-1]}, 0.0", *steps, "return v, d"),
    )


class TaylorSteps:
    """Steps of an affine motion; of other rates see :class:`nonsmooth.analysis.trajectories.steppers.Dop853`.

    Args:
        rate: ``A x + b``.
        t: time.
        y: state (n,).
        until: last time.

    Attributes:
        t, y, slope: where it is, and the rate there.
        step_size: length of the last step.
    """

    step_size: float

    def __init__(self, rate: AffineVelocity, t: float, y: Floats, until: float) -> None:
        self._rate, self._until = rate, until
        self.t, self.y, self.slope = t, y, rate(t, y)
        self._code = series_code(len(y))

    def step(self) -> DenseStep:
        """The next step.

        Raises:
            TrajectoryError: where floats do not hold it.
        """
        start, rho = self.t, self._rate.size
        states, *sizes = self._code.series(*self._rate.scaled, *self.y.tolist())
        end = min(start + _reach(*sizes) / rho, self._until) if rho else self._until
        if not end > start:
            raise TrajectoryError(f"the integrator stopped at t = {start:.6g}: floats do not hold its next step")
        between = PolynomialInterpolant(start, 1 / (rho or 1.0), states, self._code.value, self._code.sloped)
        last = between(end)
        slope = self._rate(end, last)
        easy = len(self.y) > 2 and (not rho or (end - start) * rho > EASY)
        ends, slopes = ((start, self.y), (end, last)), (self.slope, slope)
        step = DenseStep(*ends, lambda: between, slopes=slopes, parts=self._parts, easy=easy, work=WORK)
        self.step_size, self.t, self.y, self.slope = end - start, end, last, slope
        return step

    def _parts(self, length: float) -> int:
        """Parts of a stretch at whose ends a path has samples."""
        if self._rate.size:
            return max(math.ceil(self._rate.size * length / DRAWN), 1)
        return OF_A_POLYNOMIAL if any(self._rate.scaled[: len(self.y) ** 2]) else 1


def _reach(scale: float, before: float, last: float) -> float:
    """How far series go on, in their own variable, by the sizes of their coefficients."""
    scale, reach = LEFT_OUT * scale, LONGEST
    if last * reach**DEGREE > scale:
        reach = (scale / last) ** (1 / DEGREE)
    if before * reach ** (DEGREE - 1) > scale:
        reach = (scale / before) ** (1 / (DEGREE - 1))
    return reach
