"""Solutions of polynomial differential equations, enclosed by balls: steps of Taylor series with a proved remainder.

For ``z' = F(z)`` let ``c_k(Z)`` be the Taylor coefficients of the solutions from a box Z.  A box B that holds
``sum_{k<p} c_k(Z) [0, h]^k + c_p(B) [0, h]^p`` holds all solutions from Z for ``0 <= t <= h``: it encloses them
(Corliss & Rihm 1996, "Validating an a priori enclosure using high-order Taylor series"; Moore 1966).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import accumulate
from typing import Any, TypeAlias

from flint import arb, arb_poly, arb_series, ctx

from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.symbolic.formulas.surfaces import quotient
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, UnknownSign, signs_by_factors

BITS = 160  # of balls
ORDER = 20  # of a step
ACCURACY = -80  # binary digits of the last terms of a step, relative to the state
LOOSEST = 2.0**-56  # the last terms, enclosed over all of a step, may be much larger than at its start
ENCLOSURES = 2  # attempts to enclose a step, before it is shortened
INFLATION = 2.0**-16  # by which a box is larger than the solutions from it, relative
SHORTENINGS = 60  # of a step, before enclosing it is given up

Ball: TypeAlias = Any  # arb
Box: TypeAlias = list[Any]  # of arb
Rates: TypeAlias = Callable[[Sequence[Any]], list[Any]]  # of balls or series


class UnprovedError(Exception):
    """Balls that do not show what has to be shown; the message says what."""


@contextmanager
def precision() -> Iterator[None]:
    """Working precision and length of series."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = BITS, ORDER + 1
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


@dataclass(frozen=True)
class EnclosedStep:
    """All solutions from a box over a time: coefficients of their Taylor series, the last over all of the step.

    Attributes:
        span: its length.
        series: for each entry ORDER + 1 coefficients.
        hull: a box that holds the solutions over the whole step.
    """

    span: Ball
    series: tuple[tuple[Ball, ...], ...]
    hull: Box

    @cached_property
    def _polynomials(self) -> list[Any]:
        return [arb_poly(list(entry)) for entry in self.series]

    def at(self, time: Ball) -> Box:
        """Box of the states at the times of a ball within the step."""
        return [polynomial(time) for polynomial in self._polynomials]


class Expansion:
    """The Taylor series of all solutions from a box, from which steps of any length are taken.

    Args:
        rates: of the differential equation.
        start: the box.
    """

    def __init__(self, rates: Rates, start: Box) -> None:
        self._rates, self._series = rates, expanded(rates, start)
        self._suitable = _suitable(self._series, start)

    def step(self, longest: Ball) -> EnclosedStep:
        """A step of a length that suits the order, at most the longest one.

        Raises:
            UnprovedError: where even a short one cannot be enclosed.
        """
        span = min(self._suitable, longest)
        for _ in range(SHORTENINGS):
            step = _enclosed(self._rates, self._series, span)
            if step is not None and all(abs(entry[ORDER]) * span**ORDER < LOOSEST for entry in step.series):
                return step
            span = (span * 3 / 4).mid()
        raise UnprovedError("no step of the path could be enclosed")


def expanded(rates: Rates, start: Box) -> list[tuple[Ball, ...]]:
    """Coefficients 0 ... ORDER of the Taylor series: each iteration makes one more right."""
    series: list[list[Ball]] = [[x] for x in start]
    for order in range(1, ORDER + 1):
        derivatives = rates([arb_series(entry, prec=order) for entry in series])
        for entry, rate in zip(series, derivatives, strict=True):
            entry.append(rate[order - 1] / order if isinstance(rate, arb_series) else rate * (order == 1))
    return [tuple(entry) for entry in series]


def _suitable(series: Sequence[Sequence[Ball]], start: Box) -> Ball:
    """Length at which the last terms are as small as wanted; infinite for a polynomial solution."""
    size = max([abs(x.mid()) for x in start] + [arb(1)], key=float)
    wanted, span = size * arb(2) ** ACCURACY, arb("inf")
    for entry in series:
        for k in (ORDER - 1, ORDER):
            last = abs(entry[k].mid())
            if last > 0:
                span = min(span, ((wanted / last).log() / k).exp().mid())
    return span


def _enclosed(rates: Rates, series: Sequence[Sequence[Ball]], span: Ball) -> EnclosedStep | None:
    """The step over a span, if a box is found that shows its remainder."""
    times = arb(0).union(span)
    main = [arb_poly(list(entry[:ORDER]))(times) for entry in series]
    # radii of balls have 30 bits, so that a box has to be larger by more than they resolve
    radii = [4 * abs(entry[ORDER]) * span**ORDER + x.rad() * INFLATION for entry, x in zip(series, main, strict=True)]
    for _ in range(ENCLOSURES):
        hull = [x + r * UNIT for x, r in zip(main, radii, strict=True)]
        last = [over[ORDER] for over in expanded(rates, hull)]
        rest = [c * times**ORDER for c in last]
        if not all(x.is_finite() for x in rest):
            return None
        if all(box.contains(x + r) for box, x, r in zip(hull, main, rest, strict=True)):
            ends = zip(series, last, strict=True)
            return EnclosedStep(span, tuple((*first[:ORDER], c) for first, c in ends), hull)
        radii = [2 * abs(r).upper() + x.rad() * INFLATION for r, x in zip(rest, main, strict=True)]
    return None


# ---- a cell of a planar system in balls ----------------------------------------------------------
#
# Its field and Jacobian, its guards and their derivatives along the field.
#
# A rational field is ``f = g/s`` with a polynomial g and one common denominator s, as the system holds it
# (:mod:`nonsmooth.symbolic.formulas.cleared_fractions`).  Where all denominators are positive, f and g have the same
# paths: along those of ``x' = g`` the time t of f passes at the rate ``t' = s``.  So g is followed, t is enclosed with
# it, and the denominators are further guards of the cell: whoever shows that a path stays in the cell has shown them
# positive. For the same reason g and s may be divided by any denominator that divides them all: s, a product of
# positive numbers, stays one.


BallFunction: TypeAlias = Callable[[Sequence[Any]], Any]  # of a point


class BallPolynomials:
    """Polynomials with balls for coefficients, to be evaluated at balls and at series: each monomial once for all."""

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        self._exponents = list(dict.fromkeys(e for polynomial in polynomials for e in polynomial.terms))
        places = {exponents: k for k, exponents in enumerate(self._exponents)}
        self._highest = [max(column, default=0) for column in zip(*self._exponents, strict=True)]
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
            factors = [
                of_variable[exponent] for of_variable, exponent in zip(powers, exponents, strict=True) if exponent
            ]
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
    polynomials = [*field, *scale]
    for factor in positive if scale else ():
        while factor.degree > 0:
            divided = [
                part for part in (quotient(polynomial, factor) for polynomial in polynomials) if part is not None
            ]
            if len(divided) < len(polynomials):
                break
            polynomials = divided
    return polynomials[: len(field)], polynomials[len(field) :]


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
        named = system.named()
        try:
            positive = [denominator.polynomial(named, sign_of) for denominator in system.rewriting.denominators]
            scale = [] if system.rewriting.scale is None else [system.rewriting.scale.polynomial(named, sign_of)]
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


def applied(matrix: Sequence[Any], vector: Box) -> Box:
    """A matrix of four entries, row by row, times a vector."""
    return [dot(matrix[:2], vector), dot(matrix[2:], vector)]
