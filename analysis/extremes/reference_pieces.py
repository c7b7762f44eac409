"""The same switched fields for the reference of :mod:`nonsmooth.analysis.extremes.taylor`: nothing is rounded first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nonsmooth.analysis.extremes.taylor import ReferencePiece, Series, precision
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.switched_cells import fields_by_signs
from nonsmooth.analysis.partitions.partition import Cell, Partition
from nonsmooth.analysis.partitions.polygon import HalfPlane
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


def partition_pieces(partition: Partition, kinematics: Kinematics) -> tuple[ReferencePiece, ...]:
    """Cells with the pose rates of their (first) twists."""
    with precision():
        return tuple(ReferencePiece(_sides(cell), _pose_rate(cell.twists[0], kinematics)) for cell in partition.cells)


def gradient_pieces(partition: Partition, gain: float) -> tuple[ReferencePiece, ...]:
    """The closed loop ``u = -k (c, theta) . g`` with leading-order kinematics: linear on every cell."""
    with precision():
        return tuple(
            ReferencePiece(_sides(cell), _gradient(list(cell.states[0].control_fields.values()), gain))
            for cell in partition.cells
        )


def system_pieces(scene: SwitchedSystem) -> tuple[ReferencePiece, ...]:
    """The modes of a plain system, each bounded by every surface."""
    surfaces, modes = fields_by_signs(scene)
    with precision():
        forms = [polynomial_form(surface) for surface in surfaces]
        return tuple(
            ReferencePiece(
                tuple(_signed(form, sign) for form, sign in zip(forms, signs, strict=True)),
                _both(*(polynomial_form(component) for component in velocity)),
            )
            for signs, velocity in modes.items()
        )


def _sides(cell: Cell) -> tuple[Callable[[Sequence[Series]], Series], ...]:
    return tuple(_side(side) for side in cell.polygon.sides)


def _side(side: HalfPlane) -> Callable[[Sequence[Series]], Series]:
    a, b, c = ball(side.normal[0]), ball(side.normal[1]), ball(side.offset)
    return lambda x: x[0] * -a - x[1] * b + c


def _pose_rate(twist: Any, kinematics: Kinematics) -> Callable[[Sequence[Series]], list[Series]]:
    vx, vy, omega = (ball(entry) for entry in twist)
    turn = omega if kinematics is Kinematics.EXACT else 0
    return lambda x: [x[1] * -turn + vx, x[0] * turn + vy, x[2] * 0 + omega]


def _gradient(fields: Sequence[Triple], gain: float) -> Callable[[Sequence[Series]], list[Series]]:
    balls = [[ball(entry) for entry in field] for field in fields]

    def velocity(x: Sequence[Series]) -> list[Series]:
        inputs = [(x[0] * g[0] + x[1] * g[1] + x[2] * g[2]) * -gain for g in balls]
        return [sum((u * g[k] for u, g in zip(inputs, balls, strict=True)), x[0] * 0) for k in range(3)]

    return velocity


def polynomial_form(polynomial: Polynomial) -> Callable[[Sequence[Series]], Series]:
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


def _signed(form: Callable[[Sequence[Series]], Series], sign: int) -> Callable[[Sequence[Series]], Series]:
    return form if sign > 0 else lambda x: -form(x)


def _both(
    first: Callable[[Sequence[Series]], Series], second: Callable[[Sequence[Series]], Series]
) -> Callable[[Sequence[Series]], list[Series]]:
    return lambda x: [first(x), second(x)]
