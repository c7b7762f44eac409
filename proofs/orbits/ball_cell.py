"""A cell of a planar system in balls: its field and Jacobian, its guards and their derivatives along the field."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nonsmooth.proofs.orbits.ball_steps import ORDER, BallPolynomial, BallPolynomials, Box
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.switched_system import SwitchedSystem, signs_by_factors

Field = tuple[Polynomial, ...]


def along(field: Field, guard: Polynomial) -> Polynomial:
    """``f . grad g``: the derivative of a function along the solutions."""
    slopes = [guard.derivative(name) for name in guard.variables]
    total = slopes[0] * field[0]
    for slope, rate in zip(slopes[1:], field[1:], strict=True):
        total = total + slope * rate
    return total


class BallGuard:
    """A polynomial g with its first two derivatives along a field, and its gradient.

    Args:
        guard: g.
        field: f.
    """

    def __init__(self, guard: Polynomial, field: Field) -> None:
        first = along(field, guard)
        self.value, self.slope, self.bend = map(BallPolynomial, (guard, first, along(field, first)))
        self.gradient = [BallPolynomial(guard.derivative(name)) for name in guard.variables]


class BallCell:
    """The field on the cell where the switching functions have given signs.

    Args:
        system: planar.
        surfaces: its switching functions.
        signs: one for each.
        meter: counts the products of balls that the steps of a path take.
    """

    def __init__(
        self, system: SwitchedSystem, surfaces: Sequence[Polynomial], signs: Sequence[int], meter: WorkMeter
    ) -> None:
        self.signs = tuple(signs)
        self.field = system.velocity(signs_by_factors(dict(zip(surfaces, signs, strict=True))))
        self.guards = [BallGuard(s * side, self.field) for s, side in zip(surfaces, signs, strict=True)]
        slopes = [f.derivative(name) for f in self.field for name in f.variables]
        self._field, self._varied = BallPolynomials(self.field), BallPolynomials([*self.field, *slopes])
        self._meter = meter

    def spend_step(self) -> None:
        """Count the work of one step of a path: two series and two enclosures of their remainders.

        Raises:
            WorkLimitError: once there have been too many.
        """
        self._meter.spend(2 * ORDER * (self._field.cost + self._varied.cost))

    def rates(self, point: Sequence[Any]) -> list[Any]:
        """The field at a point."""
        return self._field(point)

    def varied_rates(self, state: Sequence[Any]) -> list[Any]:
        """Rates of the point and of the four entries of the derivative Phi by the start: ``Phi' = (df/dx) Phi``."""
        point, (p, q, r, s) = state[:2], state[2:]
        f, g, a, b, c, d = self._varied(point)
        return [f, g, a * p + b * r, a * q + b * s, c * p + d * r, c * q + d * s]


def dot(first: Sequence[Any], second: Sequence[Any]) -> Any:
    """Scalar product of two boxes in the plane."""
    return first[0] * second[0] + first[1] * second[1]


def applied(matrix: Sequence[Any], vector: Box) -> Box:
    """A matrix of four entries, row by row, times a vector."""
    return [matrix[0] * vector[0] + matrix[1] * vector[1], matrix[2] * vector[0] + matrix[3] * vector[1]]
