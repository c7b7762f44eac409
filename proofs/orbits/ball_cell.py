"""A cell of a planar system in balls: its field and Jacobian, its guards and their derivatives along the field.

A rational field is ``f = g/s`` with a polynomial g and one common denominator s, as the system holds it
(:mod:`nonsmooth.symbolic.formulas.cleared_fractions`).  Where all denominators are positive, f and g have the same
paths: along those of ``x' = g`` the time t of f passes at the rate ``t' = s``.  So g is followed, t is enclosed with
it, and the denominators are further guards of the cell: whoever shows that a path stays in the cell has shown them
positive. For the same reason g and s may be divided by any denominator that divides them all: s, a product of positive
numbers, stays one.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import accumulate
from typing import Any, TypeAlias

from flint import arb

from nonsmooth.proofs.orbits.ball_steps import ORDER, Box, UnprovedError
from nonsmooth.symbolic.formulas.surfaces import quotient
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, UnknownSign, signs_by_factors

BallFunction: TypeAlias = Callable[[Sequence[Any]], Any]  # of a point


class BallPolynomials:
    """Polynomials with balls for coefficients, to be evaluated at balls and at series: each monomial once for all."""

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        self._exponents = list(dict.fromkeys(e for polynomial in polynomials for e in polynomial.terms))
        places = {exponents: k for k, exponents in enumerate(self._exponents)}
        self._highest = [max(own, default=0) for own in zip(*self._exponents, strict=True)]
        self._rows = [[(c.ball(), places[e]) for e, c in polynomial.terms.items()] for polynomial in polynomials]

    @property
    def cost(self) -> int:
        """Products of one evaluation."""
        return len(self._exponents) + sum(map(len, self._rows))

    def __call__(self, point: Sequence[Any]) -> list[Any]:
        """The values."""
        powers = [list(accumulate([1, *[x] * n], operator.mul)) for x, n in zip(point, self._highest, strict=False)]
        monomials = []
        for exponents in self._exponents:
            factors = [own[exponent] for own, exponent in zip(powers, exponents, strict=True) if exponent]
            monomials.append(reduce(operator.mul, factors) if factors else 1)
        return [sum((monomials[k] * c for c, k in row), start=0) for row in self._rows]


def in_balls(polynomial: Polynomial) -> BallFunction:
    """One polynomial as a function of balls."""
    alone = BallPolynomials([polynomial])
    return lambda point: alone(point)[0]


def along(field: Sequence[Polynomial], guard: Polynomial) -> Polynomial:
    """``f . grad g``: the derivative of a function along the solutions."""
    return dot(field, [guard.derivative(name) for name in guard.variables])


def lowered(
    field: Sequence[Polynomial], scale: Sequence[Polynomial], positive: Sequence[Polynomial]
) -> tuple[list[Polynomial], list[Polynomial]]:
    """A field and its common denominator, if it has one, divided by positive functions as often as these divide all."""
    found = [*field, *scale]
    for factor in positive if scale else ():
        while factor.degree > 0:
            divided = [part for part in (quotient(own, factor) for own in found) if part is not None]
            if len(divided) < len(found):
                break
            found = divided
    return found[: len(field)], found[len(field) :]


@dataclass(frozen=True)
class EndFunction:
    """A function g of the state, with its slope along the field and its gradient; at an arrival it falls to zero."""

    value: BallFunction
    slope: BallFunction
    gradient: Sequence[BallFunction]


@dataclass(frozen=True)
class BallGuard(EndFunction):
    """A polynomial g of a cell, with the slope of its slope."""

    bend: BallFunction

    @classmethod
    def of(cls, guard: Polynomial, field: Sequence[Polynomial]) -> BallGuard:
        """Along a field."""
        first = along(field, guard)
        gradient = [in_balls(guard.derivative(name)) for name in guard.variables]
        return cls(in_balls(guard), in_balls(first), gradient, in_balls(along(field, first)))


class BallCell:
    """The field on the cell where the switching functions have given signs.

    Args:
        system: planar.
        surfaces: its switching functions.
        signs: one for each.
        meter: counts the products of balls that the steps of a path take.

    Raises:
        UnprovedError: for denominators that switch where the field does not.
    """

    def __init__(
        self, system: SwitchedSystem, surfaces: Sequence[Polynomial], signs: Sequence[int], meter: WorkMeter
    ) -> None:
        self.signs = tuple(signs)
        sign_of = signs_by_factors(dict(zip(surfaces, signs, strict=True)))
        named = dict(zip(system.states, system.coordinates(), strict=True))
        try:
            positive = [own.polynomial(named, sign_of) for own in system.denominators]
            scale = [] if system.scale is None else [system.scale.polynomial(named, sign_of)]
        except UnknownSign:
            raise UnprovedError("a denominator switches where the right-hand sides do not") from None
        self.field, scale = lowered(system.velocity(sign_of), scale, positive)
        self.scale = scale[0] if scale else None
        guards = [s * side for s, side in zip(surfaces, signs, strict=True)]
        self.guards = [BallGuard.of(guard, self.field) for guard in [*guards, *positive]]
        slopes = [f.derivative(name) for f in self.field for name in f.variables]
        self.rates, self._varied = BallPolynomials(self.field), BallPolynomials([*self.field, *slopes, *scale])
        self._meter = meter

    def spend_step(self) -> None:
        """Count the work of one step of a path: two series and two enclosures of their remainders.

        Raises:
            WorkLimitError: once there have been too many.
        """
        self._meter.spend(2 * ORDER * (self.rates.cost + self._varied.cost))

    def varied_rates(self, state: Sequence[Any]) -> list[Any]:
        """Rates of the point, of the four entries of the derivative Phi by the start, ``Phi' = (df/dx) Phi``, and of
        the time, one where the field is no quotient.
        """
        f, g, *jacobian = self._varied(state[:2])
        pace = jacobian.pop() if len(jacobian) > 4 else arb(1)
        p, q, r, s = state[2:6]
        (a, c), (b, d) = applied(jacobian, [p, r]), applied(jacobian, [q, s])
        return [f, g, a, b, c, d, pace]

    def paced(self, point: Sequence[Any]) -> tuple[list[Any], Any]:
        """The field in its own time, and its common denominator."""
        f, g, *others = self._varied(point)
        scale = others[4] if len(others) > 4 else arb(1)
        return [f / scale, g / scale], scale


def dot(first: Sequence[Any], second: Sequence[Any]) -> Any:
    """Scalar product of two vectors in the plane."""
    return first[0] * second[0] + first[1] * second[1]


def applied(matrix: Sequence[Any], vector: Box) -> Box:
    """A matrix of four entries, row by row, times a vector."""
    return [dot(matrix[:2], vector), dot(matrix[2:], vector)]
