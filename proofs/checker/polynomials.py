"""Polynomials with rational coefficients in a fixed number of variables: sums, products, derivatives, substitution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from .work import BUDGET, longest, product_cost, require

MAX_DEGREE, MAX_TERMS = 40, 50_000

Exponents: TypeAlias = tuple[int, ...]


class Polynomial:
    """A sum of terms ``c x_1^e_1 ... x_n^e_n``.

    Attributes:
        count: n, the number of variables.
        terms: the coefficients that are not zero, by their exponents.

    Raises:
        RejectedError: for degrees and numbers of terms beyond the limits.
    """

    __slots__ = ("_bits", "count", "terms")

    def __init__(self, count: int, terms: Mapping[Exponents, Fraction]) -> None:
        BUDGET.spend(8 + len(terms))  # a polynomial costs some steps, however short it is
        self.count = count
        self.terms = {exponents: value for exponents, value in terms.items() if value}
        self._bits = 0
        require(len(self.terms) <= MAX_TERMS, f"polynomials of at most {MAX_TERMS} terms")
        require(self.degree <= MAX_DEGREE, f"polynomials of degree at most {MAX_DEGREE}")

    @property
    def bits(self) -> int:
        """The length of its longest coefficient."""
        if not self._bits:
            self._bits = longest(self.terms.values())
        return self._bits

    @property
    def degree(self) -> int:
        """The largest sum of exponents; 0 for the zero polynomial."""
        return max(map(sum, self.terms), default=0)

    @property
    def at_origin(self) -> Fraction:
        """Its value there."""
        return self.terms.get((0,) * self.count, Fraction(0))

    @property
    def is_form(self) -> bool:
        """Whether all terms have one degree."""
        return len(set(map(sum, self.terms))) <= 1

    def slope(self, k: int) -> Fraction:
        """The coefficient of the k-th variable alone."""
        return self.terms.get(unit(self.count, k), Fraction(0))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polynomial) and self.count == other.count and self.terms == other.terms

    def __hash__(self) -> int:
        return hash((self.count, frozenset(self.terms.items())))

    def __add__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend(1 + len(other.terms) * product_cost(self.bits, other.bits))
        total = dict(self.terms)
        for exponents, value in other.terms.items():
            total[exponents] = total.get(exponents, Fraction(0)) + value
        return Polynomial(self.count, total)

    def __neg__(self) -> Polynomial:
        return Polynomial(self.count, {exponents: -value for exponents, value in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend(1 + len(self.terms) * len(other.terms) * product_cost(self.bits, other.bits))
        total: dict[Exponents, Fraction] = {}
        for a, u in self.terms.items():
            for b, v in other.terms.items():
                key = tuple(map(int.__add__, a, b))
                total[key] = total.get(key, Fraction(0)) + u * v
        return Polynomial(self.count, total)

    def times(self, factor: Fraction | int) -> Polynomial:
        """A multiple by a number."""
        return self * constant(self.count, factor)

    def power(self, exponent: int) -> Polynomial:
        """A power with a whole exponent.

        Raises:
            RejectedError: for a degree beyond the limit, before anything is multiplied.
        """
        require(0 <= exponent <= MAX_DEGREE, f"exponents from 0 to {MAX_DEGREE}")
        value = constant(self.count, 1)
        for _ in range(exponent):
            value *= self
        return value

    def derivative(self, k: int) -> Polynomial:
        """By the k-th variable."""
        lowered = {(*e[:k], e[k] - 1, *e[k + 1 :]): c * e[k] for e, c in self.terms.items() if e[k]}
        return Polynomial(self.count, lowered)

    def on(self, coordinates: Sequence[Polynomial], count: int) -> Polynomial:
        """Itself where every variable is a polynomial in ``count`` other ones."""
        powers = [[constant(count, 1)] for _ in coordinates]
        total: dict[Exponents, Fraction] = {}
        for exponents, value in self.terms.items():
            part = constant(count, value)
            for own, form, exponent in zip(powers, coordinates, exponents, strict=True):
                while len(own) <= exponent:
                    own.append(own[-1] * form)
                if exponent:
                    part *= own[exponent]
            BUDGET.spend(len(part.terms) * product_cost(self.bits, part.bits))
            for key, added in part.terms.items():
                total[key] = total.get(key, Fraction(0)) + added
        return Polynomial(count, total)

    def divided(self, divisor: Polynomial) -> Polynomial | None:
        """The quotient by a polynomial that is not zero; None where a remainder is left."""
        lead = max(divisor.terms)
        quotient, rest = constant(self.count, 0), self
        while rest:
            top = max(rest.terms)
            step = tuple(map(int.__sub__, top, lead))
            if min(step) < 0:
                return None
            part = Polynomial(self.count, {step: rest.terms[top] / divisor.terms[lead]})
            quotient, rest = quotient + part, rest - part * divisor
        return quotient


def unit(count: int, k: int) -> Exponents:
    """The exponents of the k-th variable alone."""
    return tuple(int(i == k) for i in range(count))


def constant(count: int, value: Fraction | int) -> Polynomial:
    """A polynomial that is a number."""
    return Polynomial(count, {(0,) * count: Fraction(value)})


def variable(count: int, k: int, factor: Fraction | int = 1) -> Polynomial:
    """A multiple of the k-th variable."""
    return Polynomial(count, {unit(count, k): Fraction(factor)})


def lie_derivative(potential: Polynomial, field: Sequence[Polynomial]) -> Polynomial:
    """The derivative ``grad V . f`` of a function V along a field f."""
    total = constant(potential.count, 0)
    for k, part in enumerate(field):
        total += potential.derivative(k) * part
    return total
