"""Rational directions of length one beside given angles: what a measured angle stands for.

The direction is ``(1 - h^2, 2 h)/(1 + h^2)`` with a rational h close to the tangent of half the angle.  It has length
one exactly, and angles that are mirrored at an axis or a diagonal, or turned by a right angle, have directions that
are so exactly: a symmetric array stays symmetric.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from random import Random

from flint import arb, ctx, fmpq

from nonsmooth.symbolic.numbers.coefficients import exactly

CLOSENESS = Fraction(1, 10**15)  # radians between an angle and its direction
_PRECISION = 128  # bits of the half tangent's ball: its radius is far below the closeness

Direction = tuple[Fraction, Fraction]


@cache
def rational_direction(turn: Fraction) -> Direction:
    """A rational direction of length one within :data:`CLOSENESS` of the angle ``pi * turn``."""
    return _direction(turn, _half_tangent)


@cache
def direction_beside(turn: Fraction) -> Direction:
    """A rational direction of length one about a millionth away from it, the same for the same angle.

    Mirrored and turned angles have mirrored and turned directions here too; else no relation is to be expected.
    """
    return _direction(turn, _half_tangent_beside)


def _direction(turn: Fraction, half: Callable[[Fraction], Fraction]) -> Direction:
    """The direction of an angle by a half tangent of every angle between zero and half a right angle."""
    quarters, rest = divmod(turn % 2, Fraction(1, 2))
    cosine, sine = _in_quadrant(rest, half)
    for _ in range(int(quarters)):
        cosine, sine = -sine, cosine
    return cosine, sine


def _in_quadrant(turn: Fraction, half: Callable[[Fraction], Fraction]) -> Direction:
    """The direction of an angle between zero and a right angle; beyond the diagonal that of its mirror image."""
    if turn > Fraction(1, 4):
        cosine, sine = _in_quadrant(Fraction(1, 2) - turn, half)
        return sine, cosine
    tangent = half(turn)
    size = 1 + tangent * tangent
    return (1 - tangent * tangent) / size, 2 * tangent / size


def _half_tangent(turn: Fraction) -> Fraction:
    """The simplest rational h with ``|2 atan(h) - pi turn|`` below the closeness, for 0 <= turn <= 1/4.

    ``2 atan`` has a slope of at most two, so a distance of half the closeness from the tangent is enough; a quarter
    leaves room for the radius of the tangent's ball.
    """
    if not turn:
        return Fraction(0)
    with ctx.workprec(_PRECISION):
        sine, cosine = arb.sin_cos_pi_fmpq(fmpq(turn.numerator, 2 * turn.denominator))
        middle = exactly((sine / cosine).mid())
    return simplest_between(middle - CLOSENESS / 4, middle + CLOSENESS / 4)


def _half_tangent_beside(turn: Fraction) -> Fraction:
    """The half tangent and up to a millionth more."""
    return _half_tangent(turn) + Fraction(Random(str(turn)).getrandbits(60), 1 << 80)


def simplest_between(low: Fraction, high: Fraction) -> Fraction:
    """The fraction of the smallest denominator in a closed interval of positive numbers (continued fractions)."""
    a, b, c, d = low.numerator, low.denominator, high.numerator, high.denominator  # from a/b to c/d
    before, last = (0, 1), (1, 0)  # convergents as numerator and denominator
    while True:
        whole = -(-a // b)
        if whole * d <= c:
            return Fraction(whole * last[0] + before[0], whole * last[1] + before[1])
        below = whole - 1
        before, last = last, (below * last[0] + before[0], below * last[1] + before[1])
        a, b, c, d = d, c - below * d, b, a - below * b
