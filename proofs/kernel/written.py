"""Numbers and polynomials as the checker has them and as the program has them, and as formulas of a certificate.

The checker's irrational numbers (:class:`nonsmooth.proofs.checker.tower.Number`) are sums of products of generators.
Searches compute with those of the program in a tower of the same generators, in the same order: its arithmetic is that
of flint, and its zeros and signs are certain.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import acos, pi
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mat, fmpq_poly

from nonsmooth.proofs.checker import tower
from nonsmooth.proofs.checker.polynomials import Coefficient, Exponents, Polynomial, constant, variable
from nonsmooth.proofs.kernel.subject import number_in_names
from nonsmooth.proofs.sums_of_squares.ansatz import monomials_between
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction, bits
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import written_powers

KNOWN_FIELDS = 64  # towers that are kept
PRECISION = 64  # bits to which a generator of the base is told


def as_checked(terms: Mapping[Exponents, fmpq], count: int) -> Polynomial:
    """A polynomial of the checker in a number of variables, by its rational coefficients."""
    return Polynomial(count, {e: as_fraction(c) for e, c in terms.items()})


def terms_of(value: Polynomial) -> dict[Exponents, Any]:
    """The terms of a polynomial of the checker with numbers of flint, and irrational ones of the program."""
    return {e: exact(c) for e, c in value.terms.items()}


def exact(value: Coefficient) -> Any:
    """A number of the checker as the program computes with it."""
    if isinstance(value, tower.Number):
        return _in_twin(value, twin(value.field))
    return as_fmpq(value)


@lru_cache(maxsize=KNOWN_FIELDS)
def twin(field: tower.Field) -> NumberField:
    """The tower of the program with the generators of one of the checker's, in the same order."""
    number_field, roots = NumberField(), field.generators
    if roots and not _is_square_root(roots[0]):
        middle = sum(field.root(0, PRECISION)) / (2 << PRECISION)
        number_field, roots = NumberField(round(2 * pi / acos(middle / 2))), roots[1:]
    for generator in roots:
        radicand = -_in_twin(generator.lower[0], number_field)
        number_field.square_roots[radicand] = number_field.adjoin(radicand)
    return number_field


def _in_twin(value: tower.Number, field: NumberField) -> Number:
    """A sum of products of generators, of which the first is that of the base unless that is rational."""
    total, has_base = field.zero, field.modulus is not None
    for monomial, c in value.terms.items():
        product = field.rational(fmpq(c, value.bottom))
        for k in monomial:
            is_base = has_base and not k
            product *= field.two_cos(1) if is_base else field.square_roots[field.radicands[k - has_base]]
        total += product
    return total


def _is_square_root(generator: tower.Generator) -> bool:
    return generator.degree == 2 and not generator.lower[1].terms


def written_number(value: Any) -> Any:
    """A number of the program as evidence holds it: a rational as text, else a list of products of generators."""
    if not isinstance(value, Number) or value.as_rational() is not None:
        return str(value)
    field = value.field
    has_base, products = field.modulus is not None, []
    for mask, c in sorted(value.terms.items()):
        for power, share in enumerate(c.coeffs() if isinstance(c, fmpq_poly) else [c]):
            if share:
                products.append([str(share), *[0] * power, *(i + has_base for i in bits(mask))])
    return products


def coefficient_text(value: Coefficient) -> str:
    """A number of the checker in a formula: a fraction, or a sum of products of named generators in brackets."""
    return f"({number_in_names(exact(value))})" if isinstance(value, tower.Number) else str(value)


def formula_text(value: Polynomial, names: Sequence[str]) -> str:
    """A polynomial with rational coefficients as a formula, such as ``-3/4*x**2*y + 1``."""
    parts = []
    for exponents, c in sorted(value.terms.items(), reverse=True):
        powers = written_powers(names, exponents)
        number = [str(abs(c))] if abs(c) != 1 or not powers else []
        parts.append(f"{'-' if c < 0 else '+'} {'*'.join([*number, *powers])}")
    joined = " ".join(parts) or "+ 0"
    return joined[2:] if joined.startswith("+") else f"-{joined[2:]}"


def null_basis(matrix: fmpq_mat) -> fmpq_mat:
    """A basis of the null space, in columns."""
    reduced, rank = matrix.rref()
    count = matrix.ncols()
    pivots = [next(k for k in range(count) if reduced[i, k]) for i in range(rank)]
    free = [k for k in range(count) if k not in pivots]
    rows = [[fmpq(0)] * len(free) for _ in range(count)]
    for column, k in enumerate(free):
        rows[k][column] = fmpq(1)
        for i, pivot in enumerate(pivots):
            rows[pivot][column] = -reduced[i, k]
    return fmpq_mat(count, len(free), [value for row in rows for value in row])


def roundings(values: Floats, denominators: Sequence[int]) -> Iterator[list[Fraction]]:
    """Values over the largest, in ever longer fractions, each once."""
    earlier: list[list[Fraction]] = []
    for denominator in denominators:
        fractions = [Fraction(float(c)).limit_denominator(denominator) for c in values / np.abs(values).max()]
        if fractions not in earlier:
            earlier.append(fractions)
            yield fractions


# ---- polynomials with coefficients to be found -----------------------------------------------------


def formula_in_states(value: Polynomial, radius: Fraction, states: Sequence[str]) -> str:
    """A polynomial on the unit cube as a formula of the displacement in states."""
    count = value.count
    return formula_text(value.on([variable(count, k, 1 / radius) for k in range(count)], count), states)


def powers_between(count: int, least: int, most: int) -> list[Polynomial]:
    """Products of powers of variables, by their degrees."""
    return [Polynomial(count, {exponents: Fraction(1)}) for exponents in monomials_between(count, least, most)]


def slopes(value: Polynomial) -> list[Coefficient]:
    """The coefficients of the variables alone."""
    return [value.slope(k) for k in range(value.count)]


def rational_slopes(value: Polynomial) -> list[fmpq]:
    """The same of a polynomial with rational coefficients."""
    return list(map(as_fmpq, slopes(value)))


def hessian(terms: Mapping[Exponents, Any], count: int) -> Floats:
    """The second derivatives of a polynomial at the origin."""
    matrix = np.zeros((count, count))
    for exponents, value in terms.items():
        if sum(exponents) == 2:
            i, j = (k for k, e in enumerate(exponents) for _ in range(e))
            matrix[i, j] += float(value)
            matrix[j, i] += float(value)
    return matrix


def part_of(value: Polynomial, degree: int) -> Polynomial:
    """The terms of a degree."""
    return Polynomial(value.count, {e: c for e, c in value.terms.items() if sum(e) == degree})


def vanishing_columns(lists: Sequence[Sequence[Polynomial]]) -> fmpq_mat:
    """A basis of the coefficients with which lists of polynomials add up to zero, place by place, in columns."""
    places = sorted({(k, e) for polynomials in lists for k, value in enumerate(polynomials) for e in value.terms})
    table = [[exact(polynomials[k].terms.get(e, Fraction(0))) for polynomials in lists] for k, e in places]
    return null_basis(fmpq_mat(table or [[fmpq(0)] * len(lists)]))


def vanishing_combinations(columns: Sequence[Sequence[Polynomial]]) -> Iterator[list[Fraction]]:
    """The same, one after the other."""
    basis = vanishing_columns(columns)
    for j in range(basis.ncols()):
        yield [as_fraction(basis[i, j]) for i in range(len(columns))]


def combined(polynomials: Sequence[Polynomial], coefficients: Sequence[Fraction]) -> Polynomial:
    """The sum of polynomials with coefficients."""
    total = constant(polynomials[0].count, 0)
    for polynomial, c in zip(polynomials, coefficients, strict=True):
        total += polynomial.times(c)
    return total
