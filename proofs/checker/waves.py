"""Sines, cosines, tanh and atan of affine functions between affine functions: on a triangle, and at a point.

Let v be affine on the convex hull of some points, with values ``v_i`` there, and g one of these functions: all have
``|g''| <= 1`` (of tanh it is ``2 |s - s^3|`` with ``s = tanh v``, of atan ``2 |v|/(1 + v^2)^2``).  At a mixture of the
points with weights ``t_i`` Taylor's formula at the mean value of v gives

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
KINDS = ("sin", "cos", "tanh", "atan")


def wave_value(name: str, v: Fraction) -> int:
    """A function of v times ``2^60``, off by at most 2.

    Raises:
        RejectedError: for an argument above 64.
    """
    require(abs(v) <= LARGEST, f"sines and cosines of at most {LARGEST}")
    BUDGET.spend(200 + v.numerator.bit_length() // 64)
    if name in ("sin", "cos"):
        return _sine_or_cosine(name, v)
    value = (_tanh if name == "tanh" else _atan)(abs(v))
    return value if v > 0 else -value


def _sine_or_cosine(name: str, v: Fraction) -> int:
    """The series of one of them, at a point.

    It is added in whole numbers of ``2^-(60 + g)``, with ``g = 32 + 2 k`` and k the first whole number from
    ``|v|`` on.  v is off by one of these, which moves the value by no more.  A term that is off by a is followed by one
    that is off by at most ``a v^2/((n + 1) (n + 2)) + 2``: all errors together are below ``exp(k) < 2^(2 k)`` times
    twice the number of terms, which is below 400, so below ``2^(2 k + 10)``; and from ``n > 2 |v|`` on all terms that
    are left are less than the last one.  That leaves ``2^-22`` beside what is cut off at the end.
    """
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


def _tanh(v: Fraction) -> int:
    """``1 - 2/(exp(2 v) + 1)`` for v from 0 on.

    The series of ``exp(2 v)`` is added in whole numbers of ``2^-(60 + g)``, with ``g = 32 + 4 k`` and k the first whole
    number from v on.  2 v is off by one of these, which moves the sum by at most ``exp(2 k)``.  A term that is off by a
    is followed by one that is off by at most ``2 a v/(n + 1) + 2``, and from ``n > 4 v`` on all terms that are left are
    less than the last one.  There are less than 800, so all errors together are below ``2^11 exp(2 k) < 2^(3 k + 11)``.
    They move the quotient by no more.
    """
    guard = GUARD + 4 * ceil(v)
    one = 1 << (BITS + guard)
    x = 2 * v.numerator * one // v.denominator
    n, term, total, least = 0, one, one, 4 * v
    while term > 1 or n <= least:
        n += 1
        term = (term * x >> (BITS + guard)) // n
        total += term
    return ((total - one) << BITS) // (total + one)


def _atan(v: Fraction) -> int:
    """Of v from 0 on; above 1 it is ``pi/2 - atan(1/v)``, with ``pi = 4 atan 1``."""
    total = _short_atan(v) if v <= 1 else 2 * _short_atan(Fraction(1)) - _short_atan(1 / v)
    return total >> GUARD


def _short_atan(v: Fraction) -> int:
    """Euler's series ``sum_n (2 y)^n n!/(3 5 ... (2 n + 1)) y/v`` with ``y = v^2/(1 + v^2) <= 1/2``, for v up to 1.

    It is added in whole numbers of ``2^-(60 + 32)``.  y is off by one of these, and each term by three more than half
    of what the one before it is, so by less than six.  There are less than 100, and all that are left are less than the
    last one, so that the sum is off by less than ``2^10``.
    """
    one = 1 << (BITS + GUARD)
    y, first = v * v / (1 + v * v), v / (1 + v * v)
    n, term = 0, first.numerator * one // first.denominator
    factor, total = y.numerator * one // y.denominator, term
    while term > 1:
        n += 1
        term = (term * factor >> (BITS + GUARD)) * 2 * n // (2 * n + 1)
        total += term
    return total


def interpolation_error(width: int, bottom: int) -> int:
    """A bound of the distance between a wave and what its values at some points mean, times ``2^60``, rounded up.

    Args:
        width: of the values v_i there, from the least to the largest, a numerator.
        bottom: its denominator.
    """
    return -(-(width**2 << BITS) // (8 * bottom**2)) + 3
