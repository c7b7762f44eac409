"""Sines and cosines of affine functions between affine functions: on a triangle, and at a point.

Let v be affine on the convex hull of some points, with values ``v_i`` there, and g the sine or cosine, ``|g''| <= 1``.
At a mixture of the points with weights ``t_i`` Taylor's formula at the mean value of v gives

    |g(v) - sum_i t_i g(v_i)| <= 1/2 sum_i t_i (v_i - v)^2 <= (max v_i - min v_i)^2 / 8,

the last because no distribution on an interval has a larger variance (Popoviciu 1935).
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil

from .work import BUDGET, require

BITS = 60  # after the point, of values
GUARD = 32  # further ones, of the terms of a series, beside two for each unit of the argument
LARGEST = 64  # argument


def wave_value(name: str, v: Fraction) -> int:
    """``sin v`` or ``cos v`` times ``2^60``, off by at most 2.

    The series is added in whole numbers of ``2^-(60 + g)``, with ``g = 32 + 2 k`` and k the first whole number from
    ``|v|`` on.  v is off by one of these, which moves the value by no more.  A term that is off by a is followed by one
    that is off by at most ``a v^2/((n + 1) (n + 2)) + 2``: all errors together are below ``exp(k) < 2^(2 k)`` times
    twice the number of terms, which is below 400, so below ``2^(2 k + 10)``; and from ``n > 2 |v|`` on all terms that
    are left are less than the last one.  That leaves ``2^-22`` beside what is cut off at the end.
    """
    require(abs(v) <= LARGEST, f"sines and cosines of at most {LARGEST}")
    BUDGET.spend(200 + v.numerator.bit_length() // 64)
    guard = GUARD + 2 * ceil(abs(v))
    one = 1 << (BITS + guard)
    x = v.numerator * one // v.denominator
    square = x * x
    n, term = (1, x) if name == "sin" else (0, one)
    total, least = term, 2 * abs(v)
    while abs(term) > 1 or n <= least:
        term = -((term * square >> 2 * (BITS + guard)) // ((n + 1) * (n + 2)))
        n += 2
        total += term
    return total >> guard


def interpolation_error(width: int, bottom: int) -> int:
    """A bound of the distance between a wave and what its values at some points mean, times ``2^60``, rounded up.

    Args:
        width: of the values v_i there, from the least to the largest, a numerator.
        bottom: its denominator.
    """
    return -(-(width**2 << BITS) // (8 * bottom**2)) + 3
