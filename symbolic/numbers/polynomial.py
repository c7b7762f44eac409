"""Polynomials in a few named variables over the scene's number field: the smooth pieces of switched systems.

Sparse, exact and immutable.  A polynomial of degree d becomes a form (homogeneous, one more variable ``w`` that
stands for 1) by :meth:`Polynomial.homogenized`; then a polygon, an unbounded cone and a half-plane are all cones of
generators ``(x, y, w)`` with ``w >= 0``, and :func:`in_generators` writes the form in those generators.  Points and
generators may hold lazy quotients (:mod:`nonsmooth.symbolic.numbers.lazy`); coefficients are always field elements.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import comb
from operator import add
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.symbolic.numbers.coefficients import as_fmpq, fmpq_to_float
from nonsmooth.symbolic.numbers.exact_real import ExactRing
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Exponents: TypeAlias = tuple[int, ...]
Terms: TypeAlias = dict[Exponents, Any]  # nonzero coefficients of any ordered ring

BEYOND_FLOATS = np.errstate(over="ignore", invalid="ignore")  # values that no float holds are told by what they are


def add_terms(first: Mapping[Exponents, Any], second: Mapping[Exponents, Any]) -> Terms:
    """Sum, without zero coefficients."""
    total = dict(first)
    for exponents, coefficient in second.items():
        value = total[exponents] + coefficient if exponents in total else coefficient
        if value:
            total[exponents] = value
        else:
            total.pop(exponents, None)
    return total


def multiply_terms(first: Mapping[Exponents, Any], second: Mapping[Exponents, Any]) -> Terms:
    """Product, without zero coefficients."""
    total: Terms = {}
    for a, c in first.items():
        for b, d in second.items():
            exponents = tuple(map(add, a, b))
            total[exponents] = total[exponents] + c * d if exponents in total else c * d
    return {exponents: c for exponents, c in total.items() if c}


def in_generators(terms: Mapping[Exponents, Any], generators: Sequence[Sequence[Any]]) -> Terms:
    """The form at ``sum_i lambda_i generators[i]``, as terms in ``lambda`` (monomial coefficients)."""
    count = len(generators)
    units = [tuple(int(i == k) for i in range(count)) for k in range(count)]
    rows = [{unit: g[k] for unit, g in zip(units, generators, strict=True) if g[k]} for k in range(len(generators[0]))]
    powers: list[list[Terms]] = [[{(0,) * count: 1}, row] for row in rows]
    total: Terms = {}
    for exponents, coefficient in terms.items():
        product: Terms = {(0,) * count: coefficient}
        for row, row_powers, power in zip(rows, powers, exponents, strict=True):
            while len(row_powers) <= power:
                row_powers.append(multiply_terms(row_powers[-1], row))
            product = multiply_terms(product, row_powers[power]) if power else product
        total = add_terms(total, product)
    return total


def with_mixture(terms: Mapping[Exponents, Any], kept: int, replaced: int, alpha: Any, beta: Any) -> Terms:
    """The form on a part of a cone in which ``m = alpha g_kept + beta g_replaced`` takes the place of ``g_replaced``:
    ``lambda_replaced = beta mu``, ``lambda_kept = mu_kept + alpha mu``.
    """
    total: Terms = {}
    powers_of_alpha, powers_of_beta = _powers(alpha, terms, kept), _powers(beta, terms, replaced)
    for exponents, c in terms.items():
        scaled = c * powers_of_beta[exponents[replaced]] if exponents[replaced] else c
        for k in range(exponents[kept] + 1):
            key, value = exponents, scaled
            if k:
                target = list(exponents)
                target[kept] -= k
                target[replaced] += k
                key, value = tuple(target), scaled * (powers_of_alpha[k] * comb(exponents[kept], k))
            total[key] = total[key] + value if key in total else value
    return {e: c for e, c in total.items() if c}


def _powers(base: Any, terms: Mapping[Exponents, Any], index: int) -> list[Any]:
    powers = [1 + 0 * base]
    for _ in range(max((e[index] for e in terms), default=0)):
        powers.append(powers[-1] * base)
    return powers


@BEYOND_FLOATS
def written_powers(names: Sequence[str], exponents: Exponents) -> list[str]:
    """The powers in a monomial, such as ``x**2`` and ``y``."""
    return [name if k == 1 else f"{name}**{k}" for name, k in zip(names, exponents, strict=True) if k]


def float_values(terms: Mapping[Exponents, Any], points: Floats) -> Floats:
    """A polynomial at points of shape (m, n), in floats."""
    return sum(_float_terms(terms, points), np.zeros(len(points)))


@BEYOND_FLOATS
def float_slopes(parts: Sequence[Polynomial]) -> Floats:
    """The gradients of polynomials at the origin, in floats: a row for each."""
    units = np.eye(len(parts[0].variables), dtype=int).tolist()
    return np.array([[float(part.terms.get(tuple(unit), 0)) for unit in units] for part in parts])


def float_values_and_sizes(terms: Mapping[Exponents, Any], points: Floats) -> tuple[Floats, Floats]:
    """The same, and the sums of the absolute values of the terms, by which rounding is told."""
    listed = list(_float_terms(terms, points))
    return sum(listed, np.zeros(len(points))), sum(map(np.abs, listed), np.zeros(len(points)))


def _float_terms(terms: Mapping[Exponents, Any], points: Floats) -> Iterator[Floats]:
    for exponents, coefficient in terms.items():
        exact = as_fmpq(coefficient) if isinstance(coefficient, Fraction) else coefficient
        size = fmpq_to_float(exact) if isinstance(exact, fmpq) else float(exact)
        term = np.full(len(points), size)
        for k, exponent in enumerate(exponents):
            if exponent:
                term *= points[:, k] ** exponent
        yield term


@dataclass(frozen=True)
class Polynomial(ExactRing):
    """``sum_e terms[e] * prod_k variables[k]**e[k]``.

    Attributes:
        field: the number field of the coefficients.
        variables: names, in the order of the exponents.
        terms: nonzero coefficients by exponents.
    """

    field: NumberField
    variables: tuple[str, ...]
    terms: Mapping[Exponents, Number]

    @classmethod
    def constant(cls, field: NumberField, variables: Sequence[str], value: Number | int | Fraction) -> Polynomial:
        """A constant."""
        number = field(value)
        return cls(field, tuple(variables), {(0,) * len(variables): number} if number else {})

    @classmethod
    def variable(cls, field: NumberField, variables: Sequence[str], name: str) -> Polynomial:
        """One of the variables."""
        return cls(field, tuple(variables), {tuple(int(v == name) for v in variables): field.one})

    @classmethod
    def coordinates(cls, field: NumberField, variables: Sequence[str]) -> tuple[Polynomial, ...]:
        """All of the variables."""
        return tuple(cls.variable(field, variables, name) for name in variables)

    def _operand(self, value: Any) -> Polynomial | None:
        if isinstance(value, Polynomial):
            if value.variables != self.variables:
                raise ValueError(f"required polynomials in {self.variables}, received {value.variables}")
            return value
        if isinstance(value, (Number, int, Fraction)):  # a tuple: the union would be made at every call
            return Polynomial.constant(self.field, self.variables, value)
        return None

    def _with(self, terms: Terms) -> Polynomial:
        return Polynomial(self.field, self.variables, terms)

    def __add__(self, value: Any) -> Polynomial:
        other = self._operand(value)
        return NotImplemented if other is None else self._with(add_terms(self.terms, other.terms))

    def __neg__(self) -> Polynomial:
        return self._with({e: -c for e, c in self.terms.items()})

    def __mul__(self, value: Any) -> Polynomial:
        other = self._operand(value)
        return NotImplemented if other is None else self._with(multiply_terms(self.terms, other.terms))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __hash__(self) -> int:
        return hash((self.variables, frozenset(self.terms.items())))

    def __call__(self, point: Sequence[Any]) -> Any:
        """Value at a point (in the order of the variables)."""
        powers: list[list[Any]] = [[1, coordinate] for coordinate in point]
        total: Any = self.field.zero
        for exponents, coefficient in self.terms.items():
            term: Any = coefficient
            for coordinate_powers, exponent in zip(powers, exponents, strict=True):
                while len(coordinate_powers) <= exponent:
                    coordinate_powers.append(coordinate_powers[-1] * coordinate_powers[1])
                term = term * coordinate_powers[exponent] if exponent else term
            total = total + term
        return total

    @cached_property
    def degree(self) -> int:
        """Total degree; 0 for the zero polynomial."""
        return max((sum(e) for e in self.terms), default=0)

    @cached_property
    def is_homogeneous(self) -> bool:
        """Whether all terms have the same total degree."""
        return len({sum(e) for e in self.terms}) <= 1

    def part(self, degree: int) -> Polynomial:
        """The terms of one total degree."""
        return replace(self, terms={e: c for e, c in self.terms.items() if sum(e) == degree})

    @property
    def at_origin(self) -> Number:
        """Its value there."""
        return self.terms.get((0,) * len(self.variables), self.field.zero)

    def slope(self, k: int) -> Number:
        """The coefficient of the k-th variable alone."""
        return self.terms.get(tuple(int(i == k) for i in range(len(self.variables))), self.field.zero)

    @property
    def constant_value(self) -> Number | None:
        """The value of a constant polynomial; None for any other."""
        return None if self.degree else self.at_origin

    def derivative(self, name: str) -> Polynomial:
        """Partial derivative."""
        k = self.variables.index(name)
        return self._with({(*e[:k], e[k] - 1, *e[k + 1 :]): c * e[k] for e, c in self.terms.items() if e[k]})

    def homogenized(self, degree: int | None = None) -> Polynomial:
        """The form of the given degree (by default the polynomial's own) that equals it at ``w = 1``."""
        top = self.degree if degree is None else degree
        return Polynomial(self.field, (*self.variables, "w"), {(*e, top - sum(e)): c for e, c in self.terms.items()})

    def composed(self, values: Sequence[Polynomial]) -> Polynomial:
        """The polynomial with each variable replaced by a polynomial (all in the same new variables)."""
        return Polynomial.constant(self.field, values[0].variables, 0) + self(values)

    def __str__(self) -> str:
        order = sorted(self.terms, key=lambda e: (-sum(e), tuple(-k for k in e)))
        text = " + ".join(self._term_text(e) for e in order) or "0"
        return text.replace("+ -", "- ")

    def _term_text(self, exponents: Exponents) -> str:
        powers = written_powers(self.variables, exponents)
        coefficient = self.terms[exponents]
        number = str(coefficient)
        if powers and number in ("1", "-1"):
            return number[:-1] + "*".join(powers)
        if powers and coefficient.as_rational() is None and len(coefficient.terms) > 1:
            number = f"({number})"
        return "*".join([number, *powers])
