"""Balls around exact numbers, and square roots that are exact where that is short work."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import arb, ctx

from nonsmooth.symbolic.numbers.coefficients import exactly
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.square_roots import NestingError

EXACT_ROOTS = 4  # square roots of a field up to which a lazy quotient is carried out; beyond it may take minutes
MOST_ROOTS = 256  # of a field in which an exact root is looked for: among thousands that takes seconds
MOST_BITS = 12_000  # of all coefficients of a number that is written down: some 3,600 digits
PRECISION = 256  # bits of a ball that stands for a number
DIGITS = 16  # binary ones of a short fraction


def enclosure(value: Number | Lazy) -> arb:
    """A ball that holds the number: at the working precision of a field element, as it is of a lazy quotient."""
    return value.ball if isinstance(value, Lazy) else value.ball()


def square_root(value: Number | Lazy) -> Number | arb:
    """Non-negative square root as a field element where that is short work, a ball otherwise.

    Raises:
        ValueError: if the value is negative.
    """
    if isinstance(value, Lazy):
        if len(value.field.radicands) > EXACT_ROOTS:
            value.sign()  # tightens the ball
            return _rooted(value.ball)
        value = value.exact()
    if value.size_bits <= MOST_BITS and len(value.field.radicands) <= MOST_ROOTS:
        try:
            return value.sqrt()
        except NestingError:
            pass
    return _rooted(value.accurate_ball(PRECISION))


def _rooted(ball: arb) -> arb:
    with ctx.workprec(PRECISION):
        return ball.sqrt()


def rational_below(ball: arb) -> Fraction:
    """The lower end of a ball."""
    return exactly(ball.lower())


def rational_above(ball: arb) -> Fraction:
    """The upper end of a ball."""
    return exactly(ball.upper())


def short_below(value: Fraction) -> Fraction:
    """A short fraction that is no larger than a positive one, and nearly as large."""
    unit = Fraction(2) ** (math.frexp(float(value))[1] - DIGITS)
    return unit * (value // unit)
