"""Starts of solutions as typed: formulas of scene files, rounded once to the floats in which solutions are followed."""

from __future__ import annotations

from fractions import Fraction

from flint import arb, ctx

from nonsmooth.symbolic.expression import Expression, ExpressionError
from nonsmooth.symbolic.files.scene_values import WITH_UNIT, AngleUnit, field_of, read_angle, read_exact, unit_named
from nonsmooth.symbolic.numbers.coefficients import rational_ball

_PRECISION = 128  # bits of a sum with pi, beyond those that a large rational part needs


def read_start_value(text: str) -> float:
    """A number, or a formula such as ``sqrt(2)/4``.

    Raises:
        ExpressionError: for anything else.
        OverflowError: for numbers beyond floats.
    """
    number = read_exact(text.strip())
    return float(number) if isinstance(number, Fraction) else _value(number)


def read_start_angle(text: str) -> float:
    """An angle (radian): a number, a formula, one with pi such as ``pi/6``, or ``10 deg``; raises as above."""
    named = WITH_UNIT.fullmatch(text.strip())
    if named is not None and unit_named(named[2]) is AngleUnit.DEGREE:
        turn = read_angle(text).turn
        return _sum_with_pi(Fraction(0), turn) if turn else 0.0
    number = read_exact(text.strip() if named is None else named[1])
    if isinstance(number, Fraction):
        return float(number)
    try:
        constant, multiple = number.parts_in_pi()
    except ExpressionError:  # such as sqrt(2)
        return _value(number)
    return _sum_with_pi(constant, multiple) if multiple else float(constant)


def _value(number: Expression) -> float:
    """The float nearest to a formula; of measured angles as in a scene that holds this formula only."""
    return float(number.value(field_of(number.turns())))


def _sum_with_pi(constant: Fraction, multiple: Fraction) -> float:
    """``a + b pi``, which is never zero for b other than zero."""
    precision = _PRECISION + int(max(abs(constant), abs(multiple))).bit_length()
    while True:
        with ctx.workprec(precision):
            ball = rational_ball(constant)
            ball += rational_ball(multiple) * arb.pi()
        if ball.rel_accuracy_bits() >= _PRECISION // 2 + 1:
            return float(ball.mid())
        precision *= 2
