"""Switched equations as a sign field: polynomials in floats, one field per pattern of signs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.smooth_field import Surface, Vector, Velocity
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.switched_equations import SwitchedEquations


def build_sign_field(equations: SwitchedEquations, start: Sequence[float]) -> SignField:
    """The field of a plain system, for a path from a start.

    The typical size of the states, which sets the slack of the surfaces, is the largest of the start's entries and
    the checked radius.

    Raises:
        SceneError: for formulas with too many switching surfaces, or that are no polynomials.
    """
    surfaces = equations.surfaces()

    @cache
    def flow(signs: Signs) -> Velocity:
        pieces = equations.velocity(dict(zip(surfaces, signs, strict=True)))
        value = _Polynomials(pieces)
        return lambda t, x: value(x)

    size = max(float(equations.radius), *(abs(float(value)) for value in start))
    return SignField(equations.states, tuple(_surface(surface) for surface in surfaces), flow, size)


def _surface(polynomial: Polynomial) -> Surface:
    """A switching function with its exact gradient."""
    value = _Polynomials([polynomial])
    gradient = _Polynomials([polynomial.derivative(name) for name in polynomial.variables])
    return Surface(str(polynomial), lambda x: float(value(x)[0]), gradient, flat=polynomial.degree <= 1)


class _Polynomials:
    """Values of some polynomials at a state: coefficients times monomials."""

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        exponents = list(dict.fromkeys(e for p in polynomials for e in p.terms))
        self._exponents = np.array(exponents, dtype=float).reshape(-1, len(polynomials[0].variables))
        self._coefficients = np.array(
            [[float(p.terms[e]) if e in p.terms else 0.0 for e in exponents] for p in polynomials]
        ).reshape(len(polynomials), -1)
        self._constant = None if self._exponents.any() else self._coefficients.sum(axis=1)

    def __call__(self, x: Vector) -> Vector:
        """The values, in order."""
        if self._constant is not None:
            return self._constant
        return np.asarray(self._coefficients @ np.prod(x**self._exponents, axis=1))
