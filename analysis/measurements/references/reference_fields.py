"""Switched fields in which nothing is rounded, and where their paths end: the one reference for all paths.

A field that is constant on polygons is followed over exact numbers, any other by Taylor series at 60 digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, fmpq

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.cells.switched_cells import fields_by_signs
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.measurements.references.taylor import (
    Form,
    Reached,
    ReferencePiece,
    Series,
    Velocity,
    follow_series,
    precision,
)
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.switched_system import SwitchedSystem


def ball(number: Any) -> Any:
    """An exact number as a ball: at the working precision, or of 256 bits (77 digits) where it is evaluated late."""
    if isinstance(number, Lazy):
        return number.ball
    return number.ball() if isinstance(number, Number) else number


@dataclass(frozen=True, eq=False)
class ReferenceField:
    """A switched field to measure paths by.

    Attributes:
        pieces: the field for Taylor series.
        exact: the same field over exact numbers; None where it is not constant on polygons.
    """

    pieces: tuple[ReferencePiece, ...]
    exact: ConstantField | None = None

    def reached(self, start: Sequence[float], until: float) -> Reached:
        """Time and state that a path has to reach: exact where the field allows it, else at 60 digits.

        Raises:
            ValueError: for a start on a surface where only the reference at 60 digits is at hand.
        """
        if self.exact is None:
            return follow_series(self.pieces, start, until)
        end = simulate(self.exact, (*start, 0)[:3], until).end
        return Reached(min(float(end.t), until), end.state[: len(start)])


def array_reference(partition: Partition, kinematics: Kinematics) -> ReferenceField:
    """Cells with the pose rates of their (first) twists."""
    exact = array_field(partition, kinematics, exact=True) if kinematics is Kinematics.LEADING else None
    with precision():
        rates = [_pose_rate(cell.twists[0], kinematics) for cell in partition.cells]
        return ReferenceField(_with_sides(partition, rates), exact)


def gradient_reference(partition: Partition, gain: float, weight: Fraction = Fraction(1)) -> ReferenceField:
    """The closed loop ``u = -k (c, w theta) . g``, linear on every cell.

    Kinematics are of leading order at the checked point, as
    :func:`nonsmooth.analysis.fields.cellwise_field.feedback_field` has them.
    """
    x, y = partition.scene.check.equilibrium
    with precision():
        centre = (ball(x), ball(y))
        laws = [
            _gradient(list(cell.states[0].control_fields.values()), gain, weight, centre) for cell in partition.cells
        ]
        return ReferenceField(_with_sides(partition, laws))


def system_reference(scene: SwitchedSystem) -> ReferenceField:
    """The modes of a plain system, each bounded by every surface."""
    surfaces, modes = fields_by_signs(scene)
    pieces = []
    with precision():
        forms = [polynomial_form(surface) for surface in surfaces]
        for signs, velocity in modes.items():
            sides = tuple(_signed(surface, sign) for surface, sign in zip(forms, signs, strict=True))
            pieces.append(ReferencePiece(sides, _both(*map(polynomial_form, velocity))))
    return ReferenceField(tuple(pieces), constant_system(scene, exact=True))


def _with_sides(partition: Partition, velocities: Sequence[Velocity]) -> tuple[ReferencePiece, ...]:
    cells = zip(partition.cells, velocities, strict=True)
    return tuple(ReferencePiece(tuple(_side(side) for side in cell.polygon.sides), v) for cell, v in cells)


def _side(side: HalfPlane) -> Form:
    a, b, c = ball(side.normal[0]), ball(side.normal[1]), ball(side.offset)
    return lambda x: x[0] * -a - x[1] * b + c


def _pose_rate(twist: Any, kinematics: Kinematics) -> Velocity:
    vx, vy, omega = (ball(entry) for entry in twist)
    turn = omega if kinematics is Kinematics.EXACT else 0
    return lambda x: [x[1] * -turn + vx, x[0] * turn + vy, x[2] * 0 + omega]


def _gradient(fields: Sequence[Triple], gain: float, weight: Fraction, centre: tuple[Any, Any]) -> Velocity:
    balls = [[ball(entry) for entry in field] for field in fields]
    w = arb(fmpq(weight.numerator, weight.denominator))
    x_of, y_of = centre
    moved = [(g[0] - g[2] * y_of, g[1] + g[2] * x_of, g[2]) for g in balls]  # velocities at the checked point

    def velocity(x: Sequence[Series]) -> list[Series]:
        inputs = [(x[0] * g[0] + x[1] * g[1] + x[2] * (w * g[2])) * -gain for g in balls]
        return [sum((u * m[k] for u, m in zip(inputs, moved, strict=True)), x[0] * 0) for k in range(3)]

    return velocity


def polynomial_form(polynomial: Polynomial) -> Form:
    """A polynomial as a function of series."""
    terms = [(exponents, ball(coefficient)) for exponents, coefficient in polynomial.terms.items()]

    def value(x: Sequence[Series]) -> Series:
        total = x[0] * 0
        for exponents, coefficient in terms:
            term = x[0] * 0 + coefficient
            for variable, exponent in zip(x, exponents, strict=True):
                for _ in range(exponent):
                    term = term * variable
            total = total + term
        return total

    return value


def _signed(form: Form, sign: int) -> Form:
    return form if sign > 0 else lambda x: -form(x)


def _both(first: Form, second: Form) -> Velocity:
    return lambda x: [first(x), second(x)]
