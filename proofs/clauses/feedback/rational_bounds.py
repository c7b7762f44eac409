"""Rational bounds that floats or balls propose and exact arithmetic confirms: rates, levels, speeds of a law.

Every printed number of the clause is one of these: few digits, on the safe side, and true by an exact predicate.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from flint import arb

from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.lazy import FEW_ROOTS, Lazy
from nonsmooth.symbolic.numbers.number import Number

DIGITS = 4  # significant ones of what is printed
BELOW = 1 - Fraction(1, 10 ** (DIGITS - 1))  # next try where rounding made a proposal too large
MUCH_BELOW = Fraction(9, 10)  # of proposals that more than rounding may have spoilt
TRIES = 40


def confirmed(
    proposal: Fraction, holds: Callable[[Fraction], bool], factor: Fraction = BELOW, tries: int = TRIES
) -> Fraction | None:
    """The first of a proposal and its multiples by a factor, its square, ... that is confirmed; None after some."""
    for _ in range(tries):
        if holds(proposal):
            return proposal
        proposal *= factor
    return None


def rounded_down(value: float) -> Fraction:
    """A rational of few digits, not above the value."""
    mantissa, exponent = f"{value:.{DIGITS - 1}e}".split("e")
    digits = Fraction(mantissa) - Fraction(1, 10 ** (DIGITS - 1))
    return digits * Fraction(10) ** int(exponent)


def rounded_up(value: float) -> Fraction:
    """A rational of few digits, not below the value."""
    return -rounded_down(-value)


def ball_of(value: Any) -> arb:
    """An enclosure of a number of any kind."""
    if isinstance(value, Fraction):
        return rational_ball(value)
    if isinstance(value, Lazy):
        return value.ball
    return value.ball() if isinstance(value, Number) else arb(value)


def late(value: Any) -> Any:
    """The number, evaluated late over many square roots: products of four would be long."""
    many = isinstance(value, Number) and len(value.field.radicands) > FEW_ROOTS
    return Lazy.of(value) if many else value
