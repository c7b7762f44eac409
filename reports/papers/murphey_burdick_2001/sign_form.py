"""Piecewise constant functions on the sectors of lines through the origin, written with ``sgn`` of polynomials.

Murphey & Burdick print eqs. (3) and (4) in this form.  A line is a *factor* (``x``, ``y``, ``a x + b y``); two lines
that mirror each other in an axis are one factor (``b^2 y^2 - a^2 x^2``).  A function on the sectors is then sought as
one or two terms ``number * sgn(product of factors)``: every candidate's numbers follow from two sectors and are
tested exactly on all.  It fails, and says nothing, where two terms are too few (rings of many wheels).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from math import prod
from typing import Any, TypeAlias

from nonsmooth.symbolic.formulas import Formula, number_latex
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Terms, multiply_terms
from nonsmooth.symbolic.numbers.printing import number_summands

MOST_FACTORS = 6  # 2^6 products make 2016 pairs

FactorPolynomial: TypeAlias = Terms  # coefficient of x^i y^j by (i, j)
Direction: TypeAlias = tuple[Number, Number]
Product: TypeAlias = tuple[int, ...]  # numbers of the factors, ascending


@dataclass(frozen=True)
class Factor:
    """A polynomial that changes its sign on one line through the origin, or on two that mirror each other."""

    polynomial: FactorPolynomial

    def sign_at(self, x: Any, y: Any) -> int:
        """Its sign at a point."""
        total = sum(number * x**i * y**j for (i, j), number in self.polynomial.items())
        return int(total.sign())


@dataclass(frozen=True)
class SignForm:
    """``sum_k number_k sgn(product_k)``, of one or two terms or none (zero); ``sgn`` of the empty product is 1."""

    factors: tuple[Factor, ...]
    terms: tuple[tuple[Number, Product], ...]

    @property
    def latex(self) -> str:
        """As the paper prints it: ``c sgn(p) (sgn(q) + 1)`` where two terms share a product."""
        return self._written(latex=True)

    @property
    def plain(self) -> str:
        """The same in plain text."""
        return self._written(latex=False)

    def value_at(self, x: Any, y: Any) -> Number:
        """The sum at a point, exactly."""
        signs = [factor.sign_at(x, y) for factor in self.factors]
        zero = next(iter(self.factors[0].polynomial.values())) * 0
        return sum((number * prod(signs[k] for k in product) for number, product in self.terms), zero)

    def _written(self, *, latex: bool) -> str:
        if not self.terms:
            return "0"
        if len(self.terms) == 2:
            (first, common), (second, whole) = self.terms
            rest = tuple(k for k in whole if k not in common)
            if set(common) <= set(whole) and first in (second, -second):
                bracket = f"{self._sign(rest, latex)} {'+' if first == second else '-'} 1"
                bracket = rf"\left({bracket}\right)" if latex and common else f"({bracket})"
                return _joined(second, [*([self._sign(common, latex)] if common else []), bracket], latex)
        parts = [_joined(number, [self._sign(p, latex)] if p else [], latex) for number, p in self.terms if number]
        return " + ".join(parts).replace("+ -", "- ")

    def _sign(self, product: Product, latex: bool) -> str:
        polynomial = multiplied([self.factors[k].polynomial for k in product])
        ordered = sorted(polynomial.items(), key=lambda item: (item[0][0], item[0][1]))
        formula = Formula(tuple((number, _powers(i, j)) for (i, j), number in ordered))
        inner = formula.latex() if latex else formula.plain().replace("*", " ")
        return rf"\operatorname{{sgn}}({inner})" if latex else f"sgn({inner})"


def line_factors(lines: Sequence[Direction]) -> tuple[Factor, ...]:
    """The factors of lines through the origin, given by their directions, no two of them parallel."""
    left = list(lines)
    factors: list[Factor] = []
    while left:
        a, b = left.pop(0)
        mirrored = next((k for k, (c, d) in enumerate(left) if a * b and not a * d + b * c), None)
        if mirrored is None:
            factors.append(Factor(_line(a, b)))
        else:
            c, d = left.pop(mirrored)
            factors.append(Factor(_scaled(multiplied([_line(a, b), _line(c, d)]))))
    return tuple(sorted(factors, key=lambda f: (sum(next(iter(f.polynomial))), (0, 1) in f.polynomial)))


def find_sign_form(factors: tuple[Factor, ...], samples: Sequence[tuple[Direction, Number]]) -> SignForm | None:
    """The shortest form with the given values.

    Args:
        factors: of the lines that part the sectors.
        samples: an inner point of every sector with the value there.

    Returns:
        None where no two terms suffice.
    """
    if len(factors) > MOST_FACTORS:
        return None
    signs = [[factor.sign_at(*point) for factor in factors] for point, _ in samples]
    values = [value for _, value in samples]
    if not any(values):
        return SignForm(factors, ())
    products = [p for size in range(len(factors) + 1) for p in combinations(range(len(factors)), size)]
    columns = {product: [prod(row[k] for k in product) for row in signs] for product in products}
    for terms in _candidates(products, columns, values):
        if all(value == sum(n * columns[p][k] for n, p in terms) for k, value in enumerate(values)):
            return SignForm(factors, tuple(terms))
    return None


def _candidates(
    products: Sequence[Product], columns: dict[Product, list[int]], values: Sequence[Number]
) -> Iterator[list[tuple[Number, Product]]]:
    """One term, then two terms by total degree, with the numbers that the first sectors call for."""
    for product in products:
        yield [(values[0] * columns[product][0], product)]
    pairs = sorted(combinations(products, 2), key=lambda pair: (len(pair[0]) + len(pair[1]), pair))
    for first, second in pairs:
        one, two = columns[first], columns[second]
        equal = next((k for k in range(len(values)) if one[k] == two[k]), None)
        apart = next((k for k in range(len(values)) if one[k] != two[k]), None)
        if equal is None or apart is None:
            continue
        total, difference = values[equal] * one[equal], values[apart] * one[apart]
        yield [((total + difference) / 2, first), ((total - difference) / 2, second)]


def multiplied(polynomials: Iterable[FactorPolynomial]) -> FactorPolynomial:
    """The product of at least one polynomial, without terms that cancel."""
    return reduce(multiply_terms, polynomials)


def _line(a: Number, b: Number) -> FactorPolynomial:
    """``a y - b x`` on the line of direction (a, b), scaled so that its first coefficient is 1: y where it occurs."""
    if not a:
        return {(1, 0): b / b}
    return {(0, 1): a / a} if not b else _scaled({(0, 1): a, (1, 0): -b})


def _scaled(polynomial: FactorPolynomial) -> FactorPolynomial:
    """Divided by the coefficient of the highest power of y."""
    leading = polynomial[max(polynomial, key=lambda power: power[1])]
    return {power: number / leading for power, number in polynomial.items()}


def _powers(i: int, j: int) -> tuple[str, ...]:
    return tuple(name if power == 1 else f"{name}^{power}" for name, power in (("x", i), ("y", j)) if power)


def _joined(number: Number, factors: list[str], latex: bool) -> str:
    """``number factor factor``; a number that is a sum stands in parentheses."""
    written = number_latex(number) if latex else str(number)
    if not factors:
        return written
    if len(number_summands(number)) > 1:
        written = rf"\left({written}\right)" if latex else f"({written})"
    written = {"1": "", "-1": "-"}.get(written, written)
    space = r"\, " if latex else " "
    return written + (space if written not in {"", "-"} else "") + space.join(factors)
