"""Polynomials as functions of floats: coefficients, each rounded once, times powers of the states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.float_code import Numbers, compiled, listed, names, weighted
from nonsmooth.analysis.fields.switched_field import AffineVelocity, ScalarVelocity, Surface, Velocity
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial

Terms: TypeAlias = Sequence[tuple[float, tuple[int, ...]]]  # coefficients and exponents
MOST_FACTORS = 500  # of polynomials that are written out: longer text takes long to compile


class Polynomials:
    """Values of some polynomials at a state: coefficients, each rounded once, times powers of the states.

    Attributes:
        at: the values, in order, from the states one by one.
        velocity: the values as a field.

    Raises:
        RefusalError: for coefficients that floats do not hold.
    """

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        sums = [[(float(c), exponents) for exponents, c in p.terms.items()] for p in polynomials]
        terms = [term for polynomial in sums for term in polynomial]
        if not all(isfinite(c) for c, _ in terms):
            raise RefusalError("required coefficients within the range of floats, to follow paths: one is above 1e308")
        count = len(polynomials[0].variables)
        factors = sum(1 + sum(exponents) for _, exponents in terms)
        self.at = (_written_out if factors <= MOST_FACTORS else _in_arrays)(count, sums)
        self.velocity: Velocity = ScalarVelocity(self.at)
        if len(sums) == count and all(p.degree <= 1 for p in polynomials):
            self.velocity = AffineVelocity(self.at, *_affine(count, sums))
        self._constant = None if any(any(e) for _, e in terms) else np.array(self.at(*[0.0] * count))

    def __call__(self, x: Floats) -> Floats:
        """The values, in order."""
        return np.array(self.at(*x.tolist())) if self._constant is None else self._constant


def _affine(count: int, sums: Sequence[Terms]) -> tuple[Floats, Floats]:
    """A and b of polynomials of degree one."""
    matrix, offset = np.zeros((count, count)), np.zeros(count)
    for row, terms in enumerate(sums):
        for c, exponents in terms:
            if any(exponents):
                matrix[row, exponents.index(1)] = c
            else:
                offset[row] = c
    return matrix, offset


def _written_out(count: int, sums: Sequence[Terms]) -> Callable[..., Numbers]:
    """The values as a function of x0, x1, ...; powers are products, which may overflow."""
    x = names("x", count)
    products = (
        [(c, [x[k] for k, power in enumerate(e) for _ in range(power)]) for c, e in polynomial] for polynomial in sums
    )
    return compiled(", ".join(x), f"return {listed(map(weighted, products))}")


def _in_arrays(count: int, sums: Sequence[Terms]) -> Callable[..., Numbers]:
    """The same for polynomials of many terms: coefficients times monomials."""
    exponents = list(dict.fromkeys(e for terms in sums for _, e in terms))
    powers = np.array(exponents, dtype=float).reshape(-1, count)
    coefficients = np.zeros((len(sums), len(exponents)))
    for row, terms in zip(coefficients, sums, strict=True):
        for c, e in terms:
            row[exponents.index(e)] = c
    return lambda *x: tuple((coefficients @ np.multiply.reduce(np.array(x) ** powers, axis=1)).tolist())


def polynomial_surface(polynomial: Polynomial) -> Surface:
    """A switching function with its exact gradient."""
    at = Polynomials([polynomial]).at
    gradient = Polynomials([polynomial.derivative(name) for name in polynomial.variables])
    return Surface(str(polynomial), lambda x: at(*x.tolist())[0], gradient, flat=polynomial.degree <= 1)
