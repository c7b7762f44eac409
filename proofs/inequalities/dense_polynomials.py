"""Polynomials in one variable as dense coefficients, ascending, over the scene's field; those on an edge among them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import dropwhile
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.region import Segment
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators

Coefficients: TypeAlias = Sequence[Number]


def trimmed(coefficients: Coefficients) -> list[Number]:
    """Without leading zeros; empty for the zero polynomial."""
    kept = list(coefficients)
    while kept and not kept[-1]:
        kept.pop()
    return kept


def without_zeros(coefficients: Coefficients) -> list[Number]:
    """Without the root zero."""
    return list(dropwhile(lambda c: not c, coefficients))


def value(coefficients: Coefficients, t: Any) -> Any:
    """Horner's scheme."""
    total: Any = 0
    for c in reversed(coefficients):
        total = total * t + c
    return total


def derivative(coefficients: Coefficients) -> list[Number]:
    """First derivative."""
    return [k * c for k, c in enumerate(coefficients)][1:]


def difference(first: Coefficients, second: Coefficients) -> list[Number]:
    """``first - second``; not both are empty."""
    zero = (first or second)[0].field.zero
    count = max(len(first), len(second))
    padded = [[*curve, *[zero] * (count - len(curve))] for curve in (first, second)]
    return [a - b for a, b in zip(*padded, strict=True)]


def product(first: Coefficients, second: Coefficients) -> list[Number]:
    """``first * second``, neither empty."""
    total = [first[0].field.zero] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            total[i + j] = total[i + j] + a * b
    return total


def divided(dividend: Coefficients, divisor: Coefficients) -> tuple[list[Number], list[Number]]:
    """Quotient and remainder; the divisor's leading coefficient is not zero."""
    rest, inverse = trimmed(dividend), divisor[-1].inverse()
    quotient = [inverse.field.zero] * max(len(rest) - len(divisor) + 1, 0)
    while len(rest) >= len(divisor):
        factor, shift = rest[-1] * inverse, len(rest) - len(divisor)
        quotient[shift] = factor
        for k, c in enumerate(divisor[:-1]):
            rest[shift + k] = rest[shift + k] - factor * c
        rest = trimmed(rest[:-1])
    return quotient, rest


def scaled(coefficients: Coefficients) -> list[Number]:
    """Divided by the absolute leading coefficient: the same signs, shorter numbers."""
    inverse = abs(coefficients[-1].inverse())
    return [c * inverse for c in coefficients]


def greatest_divisor(first: Coefficients, second: Coefficients) -> list[Number]:
    """Greatest common divisor, up to a factor."""
    a, b = trimmed(first), trimmed(second)
    while b:
        rest = divided(a, b)[1]
        a, b = b, scaled(rest) if rest else rest
    return a


def along_edge(polynomial: Polynomial, edge: Segment, degree: int | None = None) -> list[Number]:
    """A polynomial in (x, y) at the points ``g + t h``, t > 0, of an edge, times a power of w, which is positive there.

    Args:
        polynomial: the polynomial.
        edge: the generators g and h.
        degree: of the result, leading zeros included; that of the polynomial by default.
    """
    top = polynomial.degree if degree is None else degree
    ends = [tuple(map(evaluated, generator)) for generator in edge]
    terms = in_generators(polynomial.homogenized(top).terms, ends)
    return [polynomial.field(terms.get((top - k, k), 0)) for k in range(top + 1)]
