"""Coefficients of numbers: rationals, or rational polynomials in the base; their quotients, size, and cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb, fmpq, fmpq_poly

Coefficient: TypeAlias = Any  # fmpq over Q, fmpq_poly reduced by the base modulus otherwise
Rational: TypeAlias = int | Fraction | fmpq
Terms: TypeAlias = dict[int, Coefficient]  # by the mask of the roots that they multiply

UNIT_BITS = 512  # products of longer rationals count more


def as_fmpq(value: Rational) -> fmpq:
    """Convert an int, Fraction or fmpq to fmpq."""
    if isinstance(value, fmpq):
        return value
    if not isinstance(value, int) and isinstance(value, Fraction):  # in this order: a Fraction is slow to tell
        return fmpq(value.numerator, value.denominator)
    return fmpq(value)


def as_fraction(value: fmpq) -> Fraction:
    """The same number."""
    return Fraction(int(value.p), int(value.q))


def rational_ball(value: Fraction) -> arb:
    """A ball around a rational number, at the working precision."""
    return arb(fmpq(value.numerator, value.denominator))


def fmpq_to_float(value: fmpq) -> float:
    """Correctly rounded float of a rational (infinite on overflow)."""
    try:
        return int(value.p) / int(value.q)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def exactly(ball: arb) -> Fraction:
    """The number that an exact ball is, such as an end or the middle of another."""
    return as_fraction(ball.fmpq())


def bits(mask: int) -> list[int]:
    """Indices of the set bits of a mask, ascending: bit i stands for the root ``sqrt(g_i)`` of a field."""
    return [i for i in range(mask.bit_length()) if mask >> i & 1]


def height(coefficient: Coefficient) -> int:
    """Bits of the longest integer of a rational, or of a rational polynomial."""
    if isinstance(coefficient, fmpq):
        return coefficient.height_bits()
    return max(coefficient.numer().height_bits(), int(coefficient.denom()).bit_length())


def product_units(a: Terms, b: Terms, base_degree: int) -> int:
    """What a product costs, in products of short rationals: by the number of its terms and the length of the first."""
    length = height(next(iter(a.values()))) + height(next(iter(b.values())))
    return len(a) * len(b) * base_degree * (1 + length // UNIT_BITS)


def base_inverse(coefficient: Coefficient, modulus: fmpq_poly | None) -> Coefficient:
    """``1/c`` in the base field, which is given by its minimal polynomial, or over the rationals where that is None."""
    if modulus is None:
        return 1 / coefficient
    divisor, cofactor, _ = coefficient.xgcd(modulus)
    return (cofactor * (1 / divisor.coeffs()[0])) % modulus


def rational_quotient(dividend: Terms, divisor: Terms) -> fmpq | None:
    """The quotient of two numbers where it is rational, term by term; None elsewhere, and for a divisor of zero."""
    if not divisor or (dividend and dividend.keys() != divisor.keys()):
        return None
    if not dividend:
        return fmpq(0)
    mask, c = next(iter(divisor.items()))
    top, bottom = (x if isinstance(x, fmpq) else x.coeffs()[-1] for x in (dividend[mask], c))
    quotient = top / bottom
    return quotient if all(dividend[m] == quotient * d for m, d in divisor.items()) else None


def is_rational(terms: Terms) -> bool:
    """Whether a sum over the rationals has one term, without a root."""
    return len(terms) == 1 and 0 in terms


def whole_multiples(numbers: Sequence[Terms], bits: int) -> list[int] | None:
    """Whole numbers in the same ratios, without a common factor; None where there are none of so few bits.

    There are for rational multiples of one product of roots, over the rationals as the base.
    """
    masks = {mask for terms in numbers for mask in terms}
    rationals = [c for terms in numbers for c in terms.values()]
    if len(masks) > 1 or any(not isinstance(c, fmpq) for c in rationals):
        return None
    mask = masks.pop() if masks else 0
    common = math.lcm(*(int(c.q) for c in rationals))
    wholes = [int(terms[mask].p) * (common // int(terms[mask].q)) if terms else 0 for terms in numbers]
    factor = math.gcd(*wholes) or 1
    return [whole // factor for whole in wholes] if max(map(abs, wholes)) < factor << bits else None
