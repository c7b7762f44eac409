"""Starts of solutions as typed: formulas of scene files, rounded once to the floats in which solutions are followed."""

from __future__ import annotations

from fractions import Fraction

from flint import arb, ctx

from nonsmooth.symbolic.files.scene_values import WITH_UNIT, field_of, read_angle, read_exact, unit_named
from nonsmooth.symbolic.formulas.expression import Expression, ExpressionError
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.messages.scene_error import shown
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


def read_start_angle(text: str, unit: AngleUnit | None = AngleUnit.RADIAN) -> float:
    """An angle (radian): a number, a formula, one with pi such as ``pi/6``, or ``10 deg``.

    Args:
        text: as typed.
        unit: of a number that names none and holds no pi; None where only 0 needs none.

    Raises:
        ExpressionError: for anything else, and a number without a unit where none is known.
        OverflowError: for numbers beyond floats.
    """
    named = WITH_UNIT.fullmatch(text.strip())
    if named is None and unit is not AngleUnit.RADIAN and "pi" not in text and read_start_value(text):
        if unit is None:
            raise ExpressionError(f"required {_both_units(text.strip())}, received {shown(text)}")
        return read_start_angle(f"{text} deg")
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


def _both_units(number: str) -> str:
    """An angle with a unit, in either of them: numbers of the scene's file were taken for degrees."""
    return f"a unit, as {number}deg or {number}rad (angles of the scene's file are read in degrees untold)"


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
