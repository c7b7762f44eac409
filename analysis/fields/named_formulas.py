"""Formulas that name sines, norms and the like, in floats; and the fields that divide by norms.

A name stands for a function of a polynomial in the states (:class:`.Rewriting`), and formulas are polynomials in the
states and in the names.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from math import isfinite, nan, sqrt

import numpy as np

from nonsmooth.analysis.fields.float_code import Numbers
from nonsmooth.analysis.fields.float_polynomials import Polynomials
from nonsmooth.analysis.fields.norm_zeros import HeldVelocity, NormField, NormVelocity, NormZero, norm_zero
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import NoVelocityError, Velocity
from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, signs_by_factors

AT_POINT = 2.0**-38  # of the checked radius: as near to the point a path is at it


def formula_values(
    system: SwitchedSystem, formulas: Sequence[PiecewiseExpression], sign_of: SignOf, states: Sequence[Polynomial]
) -> Callable[..., Numbers]:
    """The values of formulas that are polynomials in the states and in the values of norms, sines and the like."""
    waves = system.rewriting.names
    rates = Polynomials(_named_polynomials(system, formulas, sign_of, states)).at
    if not waves:
        return rates
    nearest = AT_POINT * system.check.half_width
    values = _values_of_names(system, sign_of, states, partial(_inverse_of, nearest=nearest))
    return lambda *x: rates(*x, *values(*x))


def _named_polynomials(
    system: SwitchedSystem, formulas: Sequence[PiecewiseExpression], sign_of: SignOf, states: Sequence[Polynomial]
) -> list[Polynomial]:
    """Formulas as polynomials in the states and in the names of norms, sines and the like."""
    waves = system.rewriting.names
    if not waves:
        return [formula.polynomial(system.named(states), sign_of) for formula in formulas]
    variables = (*system.states, *(wave.name for wave in waves))
    beside = (0,) * len(waves)

    def extended(polynomial: Polynomial) -> Polynomial:
        return Polynomial(polynomial.field, variables, {(*e, *beside): c for e, c in polynomial.terms.items()})

    def sign_of_states(surface: Polynomial) -> int:  # what switches holds no sines
        return sign_of(
            Polynomial(surface.field, system.states, {e[: len(states)]: c for e, c in surface.terms.items()})
        )

    values = dict(zip(system.states, map(extended, states), strict=True))
    values |= {wave.name: Polynomial.variable(system.field, variables, wave.name) for wave in waves}
    return [formula.polynomial(values, sign_of_states) for formula in formulas]


def _values_of_names(
    system: SwitchedSystem, sign_of: SignOf, states: Sequence[Polynomial], inverse_of: Callable[[float], float]
) -> Callable[..., Numbers]:
    """What the names of norms, sines and the like are at a state; of what is over a norm a function of that."""
    waves = system.rewriting.names
    inner = Polynomials([system.argument_of(wave, states, sign_of) for wave in waves]).at
    functions = [_root if wave.kind in (NORM, INVERSE) else getattr(math, wave.kind) for wave in waves]
    # Of a norm that is zero on a line or more the square, multiplied out, is a small difference of large numbers.
    sizes = _zeros_of_norms(system, states)
    near = [(k, sizes[wave.argument].size) for k, wave in enumerate(waves) if wave.argument in sizes]
    over = [k for k, wave in enumerate(waves) if wave.kind == INVERSE]

    def values(*x: float) -> Numbers:
        found = [function(v) if isfinite(v) else nan for function, v in zip(functions, inner(*x), strict=True)]
        for k, size in near:
            found[k] = size(*x)
        for k in over:
            found[k] = inverse_of(found[k])
        return tuple(found)

    return values


def _root(square: float) -> float:
    """The root of a sum of squares, which is multiplied out: rounded it may be below zero."""
    return sqrt(max(square, 0.0))


def _inverse_of(size: float, nearest: float) -> float:
    """One over a norm that is larger than the least one that counts.

    Raises:
        NoVelocityError: elsewhere.
    """
    if size <= nearest:
        raise NoVelocityError("the field has no value where a root of a sum of squares in a denominator is zero")
    return 1 / size


def _zeros_of_norms(system: SwitchedSystem, states: Sequence[Polynomial]) -> dict[str, NormZero]:
    """The places where norms are zero that the stated field divides by, by what stands under the root."""
    arguments = [wave.argument for wave in system.rewriting.names if wave.kind == INVERSE]
    if not arguments:
        return {}
    squares = {wave.argument: system.argument_of(wave, states) for wave in system.rewriting.names}
    return {argument: norm_zero(squares[argument], f"sqrt({argument})") for argument in arguments}


def with_zeros_of_norms(
    system: SwitchedSystem, field: SignField, surfaces: Sequence[Polynomial], states: Sequence[Polynomial]
) -> SignField:
    """A field with the zeros of norms that it divides by; as it is where there are none, and with other fractions."""
    sets = _zeros_of_norms(system, states)
    if not sets or system.rewriting.scale is not None:
        return field
    nearest, count = AT_POINT * system.check.half_width, len(states)
    places = {kind: _places_of(system, kind) for kind in (NORM, INVERSE)}

    def flow(signs: Signs, held: tuple[int, ...], width: float) -> Velocity:
        sign_of = signs_by_factors(dict(zip(surfaces, signs, strict=True)))
        rates = _named_polynomials(system, system.rewriting.named_rhs, sign_of, states)
        values = _values_of_names(system, sign_of, states, lambda size: 1 / max(size, width, nearest))
        if not held:
            norms = (
                {k: sets[argument] for argument, k in places[kind].items() if argument in sets}
                for kind in (NORM, INVERSE)
            )
            return NormVelocity(Polynomials(rates).at, values, *norms)
        chosen = [list(sets)[k] for k in held]
        inverses = [count + places[INVERSE][argument] for argument in chosen]
        return _keeping_to([sets[argument] for argument in chosen], rates, values, inverses)

    @cache
    def keeping(held: tuple[int, ...], width: float) -> SignField:
        return replace(field, flow=cache(partial(flow, held=held, width=width)))

    zeros = tuple(sets.values())
    return NormField(field.states, field.surfaces, field.flow, field.size, zeros=zeros, keeping=keeping)


def _keeping_to(
    zeros: Sequence[NormZero], rates: Sequence[Polynomial], values: Callable[..., Numbers], inverses: Sequence[int]
) -> Velocity:
    """The motion that keeps to zeros of norms s.

    What stands over s is ``sum_k m_k b_k`` with the b_k of which s is the norm: it vanishes there, so its derivatives
    by the states are ``sum_k m_k grad b_k``, and times a displacement what stands with the unit vector of that.

    Args:
        zeros: of the norms.
        rates: polynomials in the states and in names, affine in the names of all 1/s together.
        values: of the names at a state.
        inverses: the numbers of the names of 1/s among all variables.

    Raises:
        NoVelocityError: for products of unit vectors.
    """
    if any(sum(exponents[k] for k in inverses) > 1 for rate in rates for exponents in rate.terms):
        raise NoVelocityError("products of unit vectors leave open what follows where their norms are zero")
    count, variables = len(rates), rates[0].variables
    alone = Polynomials([_without(rate, inverses) for rate in rates]).at
    over = [[rate.derivative(variables[k]) for rate in rates] for k in inverses]
    slopes = Polynomials(
        [part.derivative(name) for derivatives in over for part in derivatives for name in variables[:count]]
    ).at

    def slopes_at(x: Floats) -> Floats:
        coordinates = x.tolist()
        return np.array(slopes(*coordinates, *values(*coordinates))).reshape(len(zeros), count, count)

    return HeldVelocity(zeros, lambda x: np.array(alone(*x.tolist(), *values(*x.tolist()))), slopes_at)


def _without(rate: Polynomial, places: Sequence[int]) -> Polynomial:
    """The terms without some of the variables."""
    terms = {e: c for e, c in rate.terms.items() if not any(e[k] for k in places)}
    return Polynomial(rate.field, rate.variables, terms)


def _places_of(system: SwitchedSystem, kind: str) -> dict[str, int]:
    """The numbers of the names of a kind, by what these are of."""
    return {wave.argument: k for k, wave in enumerate(system.rewriting.names) if wave.kind == kind}
