"""Polynomials: sums, products, derivatives, substitution, affine equations.

Coefficients are fractions, or irrational numbers of the subject (:class:`nonsmooth.proofs.checker.tower.Number`), whose
arithmetic and order with fractions is that of real numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import prod
from operator import add, sub
from typing import Any, TypeAlias

from .work import BUDGET, longest, product_cost, require

MAX_DEGREE, MAX_TERMS = 40, 50_000
TOO_LONG, TOO_HIGH = f"polynomials of at most {MAX_TERMS} terms", f"polynomials of degree at most {MAX_DEGREE}"
MAX_LINES = 8  # on which it is tried whether two polynomials have a common factor

Exponents: TypeAlias = tuple[int, ...]
Coefficient: TypeAlias = Any  # a Fraction or a Number
Coefficients: TypeAlias = dict[Exponents, Coefficient]


class Polynomial:
    """A sum of terms ``c x_1^e_1 ... x_n^e_n``.

    Attributes:
        count: n, the number of variables.
        terms: the coefficients that are not zero, by their exponents.

    Raises:
        RejectedError: for degrees and numbers of terms beyond the limits.
    """

    __slots__ = ("_bits", "count", "terms")

    def __init__(self, count: int, terms: Mapping[Exponents, Coefficient]) -> None:
        BUDGET.spend(8 + len(terms))  # a polynomial costs some steps, however short it is
        self.count = count
        self.terms = {exponents: value for exponents, value in terms.items() if value}
        self._bits = 0
        require(len(self.terms) <= MAX_TERMS, TOO_LONG)
        require(self.degree <= MAX_DEGREE, TOO_HIGH)

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
    def at_origin(self) -> Coefficient:
        """Its value there."""
        return self.terms.get((0,) * self.count, Fraction(0))

    @property
    def is_form(self) -> bool:
        """Whether all terms have one degree."""
        return len(set(map(sum, self.terms))) <= 1

    def slope(self, k: int) -> Coefficient:
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
            collect(total, exponents, value)
        return Polynomial(self.count, total)

    def __neg__(self) -> Polynomial:
        return Polynomial(self.count, {exponents: -value for exponents, value in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial) -> Polynomial:
        return Polynomial(self.count, products(self.terms, other))

    def times(self, factor: Coefficient) -> Polynomial:
        """A multiple by a number."""
        return Polynomial(self.count, products({(0,) * self.count: factor}, self))

    def power(self, exponent: int) -> Polynomial:
        """A power with a whole exponent.

        Raises:
            RejectedError: for a degree beyond the limit, before anything is multiplied.
        """
        require(0 <= exponent <= MAX_DEGREE, f"exponents from 0 to {MAX_DEGREE}")
        return prod([self] * exponent, start=constant(self.count, 1))

    def parts_at(self, direction: Sequence[Fraction]) -> dict[int, Coefficient]:
        """The terms of each degree, added at a vector."""
        BUDGET.spend(len(self.terms) * (1 + (self.degree * longest(direction)) ** 2 // 4096))
        by_degree: dict[int, Coefficient] = {}
        for exponents, coefficient in self.terms.items():
            term = coefficient * prod(x**exponent for x, exponent in zip(direction, exponents, strict=True))
            by_degree[sum(exponents)] = by_degree.get(sum(exponents), Fraction(0)) + term
        return by_degree

    def lowest_at(self, direction: Sequence[Fraction]) -> Coefficient:
        """The terms of lowest degree, added at a vector."""
        parts = self.parts_at(direction)
        return parts[min(parts)] if parts else Fraction(0)

    def derivative(self, k: int) -> Polynomial:
        """By the k-th variable."""
        lowered = {(*e[:k], e[k] - 1, *e[k + 1 :]): c * e[k] for e, c in self.terms.items() if e[k]}
        return Polynomial(self.count, lowered)

    def on(self, coordinates: Sequence[Polynomial], count: int) -> Polynomial:
        """Itself where every variable is a polynomial in ``count`` other ones."""
        powers = [[form] for form in coordinates]
        total: Coefficients = {}
        for exponents, value in self.terms.items():
            part: Coefficients = {(0,) * count: value}
            for form_powers, exponent in zip(powers, exponents, strict=True):
                while len(form_powers) < exponent:
                    form_powers.append(form_powers[-1] * form_powers[0])
                if exponent:
                    part = products(part, form_powers[exponent - 1])
            BUDGET.spend(len(part) * product_cost(self.bits, longest(part.values())))
            for key, added in part.items():
                collect(total, key, added)
        return Polynomial(count, total)

    def divided(self, divisor: Polynomial) -> Polynomial | None:
        """The quotient by a polynomial that is not zero; None where a remainder is left."""
        lead = max(divisor.terms)
        quotient, rest = constant(self.count, 0), self
        while rest:
            top = max(rest.terms)
            step = tuple(map(sub, top, lead))
            if min(step) < 0:
                return None
            part = Polynomial(self.count, {step: rest.terms[top] / divisor.terms[lead]})
            quotient, rest = quotient + part, rest - part * divisor
        return quotient


def collect(total: Coefficients, key: Exponents, value: Coefficient) -> None:
    """Add a number to the one with the same key, if there is one."""
    total[key] = total[key] + value if key in total else value


def products(terms: Coefficients, factor: Polynomial) -> Coefficients:
    """The terms of a product, some of which may be zero."""
    BUDGET.spend(1 + len(terms) * len(factor.terms) * product_cost(longest(terms.values()), factor.bits))
    total: Coefficients = {}
    for a, u in terms.items():
        for b, v in factor.terms.items():
            key = tuple(map(add, a, b))
            total[key] = total[key] + u * v if key in total else u * v
    return total


def unit(count: int, k: int) -> Exponents:
    """The exponents of the k-th variable alone."""
    return tuple(int(i == k) for i in range(count))


def constant(count: int, value: Coefficient) -> Polynomial:
    """A polynomial that is a number."""
    return Polynomial(count, {(0,) * count: Fraction(value) if type(value) is int else value})


def variable(count: int, k: int, factor: Fraction | int = 1) -> Polynomial:
    """A multiple of the k-th variable."""
    return Polynomial(count, {unit(count, k): Fraction(factor)})


def lie_derivative(potential: Polynomial, field: Sequence[Polynomial]) -> Polynomial:
    """The derivative ``grad V . f`` of a function V along a field f."""
    return sum((potential.derivative(k) * part for k, part in enumerate(field)), constant(potential.count, 0))


def are_coprime(a: Polynomial, b: Polynomial) -> bool:
    """Whether two polynomials are seen to have no common factor.

    Where a keeps its degree on a line, every factor of a keeps its own.  So it is enough that both have no common
    factor on one such line; a few lines are tried.
    """
    if a.degree == b.degree == 1:
        return a.times(1 / a.terms[max(a.terms)]) != b.times(1 / b.terms[max(b.terms)])
    for k in range(1, MAX_LINES):
        line = [Polynomial(1, {(0,): Fraction(1, i + k), (1,): Fraction(i * i + k)}) for i in range(a.count)]
        first, second = a.on(line, 1), b.on(line, 1)
        if first.degree < a.degree:
            continue
        while second:
            first, second = second, remainder(first, second)
        if not first.degree:
            return True
    return False


def remainder(value: Polynomial, divisor: Polynomial) -> Polynomial:
    """What a division of polynomials in one variable leaves."""
    while value and value.degree >= divisor.degree:
        ratio = value.terms[max(value.terms)] / divisor.terms[max(divisor.terms)]
        value -= divisor * Polynomial(1, {(value.degree - divisor.degree,): ratio})
    return value


def clear_column(rows: list[list[Any]], column: int, pivot: int, top: int) -> None:
    """A step of Gauss's elimination: the row of the pivot changes places with another and clears a column."""
    rows[top], rows[pivot] = rows[pivot], rows[top]
    rows[top] = [value / rows[top][column] for value in rows[top]]
    for i, row in enumerate(rows):
        if i != top and row[column]:
            rows[i] = [a - row[column] * b for a, b in zip(row, rows[top], strict=True)]


def solve(forms: Sequence[Polynomial], count: int) -> tuple[Polynomial, ...] | None:
    """The variables where affine forms vanish, as affine forms in the free ones, by Gauss's elimination."""
    rows = [[*(form.slope(k) for k in range(count)), form.at_origin] for form in forms]
    pivots: list[int] = []
    for column in range(count + 1):
        top = len(pivots)
        pivot_row = next((i for i in range(top, len(rows)) if rows[i][column]), None)
        if pivot_row is None:
            continue
        if column == count:
            return None
        clear_column(rows, column, pivot_row, top)
        pivots.append(column)
    free = [k for k in range(count) if k not in pivots]
    size = len(free)
    solution = []
    for k in range(count):
        if k in free:
            solution.append(variable(size, free.index(k)))
            continue
        row = rows[pivots.index(k)]
        terms = {unit(size, i): -row[other] for i, other in enumerate(free)}
        solution.append(Polynomial(size, {**terms, (0,) * size: -row[count]}))
    return tuple(solution)
