"""Bounds from below of rates that are not negative, so that it is known where they vanish.

A polynomial r is split into irreducible factors (python-flint).  A factor stays as it is if it is a switching surface
with a sign or has an even power; one that is positive is replaced by a number; any other one must be a sum of surfaces
with their signs, squares of linear forms and monomials that are seen to be nonnegative.  Where this fails, and for the
rates of mixtures on faces, powers of coordinates and surfaces are compared with r at points.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import prod
from typing import Any, TypeAlias

import numpy as np
from flint import Ordering, fmpq_mpoly_ctx

from nonsmooth.proofs.checker.cells import Face, SurfaceSigns
from nonsmooth.proofs.checker.polynomials import Polynomial, unit, variable
from nonsmooth.proofs.checker.tower import Number
from nonsmooth.proofs.kernel.search import NotShownError
from nonsmooth.proofs.kernel.written import formula_text, part_of, slopes
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import float_values

LEAST = 2.0**-10  # of a ratio to a power that is worth to be stated
POWERS = (2, 4, 6, 8)
TINY = 2.0**-40


@dataclass(frozen=True)
class Power:
    """A base with its exponent.

    Attributes:
        base: a polynomial on the face, or the number of a surface, with its sign there.
        exponent: even unless the base is a surface.
    """

    base: Polynomial | int
    exponent: int


Term: TypeAlias = tuple[Fraction, tuple[Power, ...]]


class Bounds:
    """The bounds at one place.

    Args:
        place: a face, or a part of a cell.
        signs: of surfaces there.
        states: their names.
        surfaces: their texts.
        points: some, of shape (m, d), in the coordinates of the place.
    """

    def __init__(
        self, place: Face, signs: SurfaceSigns, states: Sequence[str], surfaces: Sequence[str], points: Floats
    ) -> None:
        self.place, self.states, self.surfaces, self.points = place, states, surfaces, points
        listed = place.inclusion.surfaces
        restricted = {j: place.restricted(listed.signed(j, s)) for j, s in signs.items()}
        self.guards = {j: surface for j, surface in restricted.items() if surface.degree}
        self.signs = signs

    # ---- of a polynomial -----------------------------------------------------------------------

    def below(self, rate: Polynomial) -> list[Term] | None:
        """Terms of a bound of a polynomial by its factors; None where these do not tell, and of irrational numbers."""
        if not rate:
            return []
        if any(isinstance(coefficient, Number) for coefficient in rate.terms.values()):
            return None
        number, factors = factorized(rate)
        total: list[Term] = [(Fraction(1), ())]
        for factor, exponent in factors:
            values = float_values(factor.terms, self.points)
            turned = exponent % 2 == 1 and values.max(initial=0.0) <= TINY
            if exponent % 2 == 1 and not turned and values.min(initial=0.0) < -TINY:
                return None
            number = -number if turned else number
            bound = self._of_factor(-factor if turned else factor, exponent, -values if turned else values)
            if bound is None:
                return None
            total = [(a * b, (*u, *v)) for (a, u), (b, v) in product(total, bound)]
        return [(number * factor, powers) for factor, powers in total] if number > 0 else None

    def _of_factor(self, factor: Polynomial, exponent: int, values: Floats) -> list[Term] | None:
        for j, guard in self.guards.items():
            share = ratio(factor, guard)
            if share is not None and (share > 0 or exponent % 2 == 0):
                return [(share**exponent, (Power(j, exponent),))]
        if factor.at_origin > 0 and (least := values.min(initial=float(factor.at_origin))) > 0:
            return [(_rounded_down(least / 2) ** exponent, ())]
        if exponent % 2 == 0 and is_solvable(factor):
            return [(Fraction(1), (Power(factor, exponent),))]
        summed = self._summed(factor)
        if summed is None:
            if exponent % 2 == 0 and values.min(initial=0.0) < 0 < values.max(initial=0.0):
                raise NotShownError("zeros of a rate on a curve that cannot be solved for a variable")
            return None
        return [
            (c**exponent, tuple(Power(power.base, power.exponent * exponent) for power in term)) for c, term in summed
        ]

    def _summed(self, value: Polynomial) -> list[Term] | None:
        """A polynomial that is zero at the origin as a sum of terms that are not negative.

        Its linear part is one of surfaces through the origin: of planes, or where these do not do of a curved one too.
        """
        through = {j: surface for j, surface in self.guards.items() if any(slopes(surface)) and not surface.at_origin}
        planes = {j: surface for j, surface in through.items() if surface.degree == 1}
        curved = [planes | {j: surface} for j, surface in through.items() if j not in planes]
        for listed in [] if value.at_origin else [planes, *curved]:
            weights = _weights(part_of(value, 1), listed)
            rest = value
            for j, weight in ({} if weights is None else weights).items():
                rest -= listed[j].times(weight)
            monomials = list(self._monomials({e: c for e, c in rest.terms.items() if sum(e) > 2}))
            squares = squares_of(part_of(rest, 2))
            if weights is not None and squares is not None and None not in monomials:
                by_surfaces = [(weight, (Power(j, 1),)) for j, weight in weights.items()]
                return [*by_surfaces, *squares, *(term for term in monomials if term is not None)]
        return None

    def _monomials(self, terms: Mapping[tuple[int, ...], Fraction]) -> Iterator[Term | None]:
        """Each monomial whose sign is seen, by even powers and coordinates that are surfaces; None for any other."""
        for exponents, value in terms.items():
            powers, factor = [], value
            for k, exponent in enumerate(exponents):
                coordinate = variable(len(exponents), k)
                if exponent % 2 == 0:
                    powers += [Power(coordinate, exponent)] if exponent else []
                    continue
                shares = ((j, ratio(coordinate, guard)) for j, guard in self.guards.items())
                j, share = next(((j, share) for j, share in shares if share is not None), (0, Fraction(0)))
                powers.append(Power(j, exponent))
                factor *= share**exponent
            yield (factor, tuple(powers)) if factor > 0 else None

    # ---- of values -----------------------------------------------------------------------------

    def at_points(self, places: Floats, values: Floats) -> list[Term]:
        """Terms of a bound of values at points: powers of coordinates and surfaces that are below them."""
        terms: list[Term] = []
        size = self.place.dimension
        bases: list[tuple[Polynomial | int, Polynomial]] = list(self.guards.items())
        bases += [(variable(size, k), variable(size, k)) for k in range(size)]
        for name, base in bases:
            against = np.abs(float_values(base.terms, places))
            at = against > TINY
            for power in (1, *POWERS) if isinstance(name, int) else POWERS:
                least = float(np.min(values[at] / against[at] ** power, initial=1.0))
                if at.any() and least > LEAST:
                    terms.append((_rounded_down(least / 2), (Power(name, power),)))
                    break
        return [(factor / len(terms), powers) for factor, powers in terms]

    # ---- as certificates write them ------------------------------------------------------------

    def written(self, terms: Sequence[Term]) -> list[Any]:
        """Terms as lists of numbers, texts in the displacement, and exponents."""
        listing = []
        for factor, powers in terms:
            texts = [self._text(power.base) for power in powers]
            shares = (share**power.exponent for (_, share), power in zip(texts, powers, strict=True))
            listed = [[text, power.exponent] for (text, _), power in zip(texts, powers, strict=True)]
            listing.append([str(prod(shares, start=factor)), listed])
        return listing

    def _text(self, base: Polynomial | int) -> tuple[str, Fraction]:
        """A base as a formula, and by what number it was divided."""
        if isinstance(base, int):
            surface = self.surfaces[base]
            return surface if self.signs[base] > 0 else f"-({surface})", Fraction(1)
        radius = self.place.inclusion.domain.radius
        names = [self.states[self.place.coordinates.index(variable(base.count, k))] for k in range(base.count)]
        scaled = {e: c / radius ** sum(e) for e, c in base.terms.items()}
        leading = scaled[max(scaled)]
        return formula_text(Polynomial(base.count, {e: c / leading for e, c in scaled.items()}), names), leading


# ---- polynomials -----------------------------------------------------------------------------------


def factorized(value: Polynomial) -> tuple[Fraction, list[tuple[Polynomial, int]]]:
    """A number, and irreducible factors over the rationals with their exponents."""
    if not value.degree:
        return value.at_origin, []
    names = tuple(f"u{k}" for k in range(value.count))
    context = fmpq_mpoly_ctx.get(names, Ordering.lex)
    number, parts = context.from_dict({e: as_fmpq(c) for e, c in value.terms.items()}).factor()
    factors = []
    for part, exponent in parts:
        terms = {tuple(map(int, e)): as_fraction(c) for e, c in part.to_dict().items()}
        factors.append((Polynomial(value.count, terms), int(exponent)))
    return as_fraction(number), factors


def ratio(value: Polynomial, other: Polynomial) -> Fraction | None:
    """By what number a polynomial is a multiple of another one; None where it is none."""
    lead = max(other.terms)
    share = value.terms.get(lead, Fraction(0)) / other.terms[lead]
    return share if share and other.times(share) == value else None


def _weights(form: Polynomial, listed: Mapping[int, Polynomial]) -> dict[int, Fraction] | None:
    """Positive weights with which linear parts add up to a linear form; None where none are found."""
    from scipy.optimize import nnls

    if not form or not listed:
        return None if form else {}
    columns = np.array([list(map(float, slopes(surface))) for surface in listed.values()]).T
    multiples, _ = nnls(columns, np.array(list(map(float, slopes(form)))))
    weights = {j: Fraction(weight).limit_denominator(1000) for j, weight in zip(listed, multiples, strict=True)}
    rest = form
    for j, weight in weights.items():
        rest -= part_of(listed[j], 1).times(weight)
    return None if rest else {j: weight for j, weight in weights.items() if weight}


def is_solvable(value: Polynomial) -> bool:
    """Whether one variable occurs alone, and in one term only."""
    return any(value.slope(k) and sum(bool(e[k]) for e in value.terms) == 1 for k in range(value.count))


def squares_of(value: Polynomial) -> list[Term] | None:
    """A quadratic form as a sum of squares of linear forms, by Lagrange's reduction; None for an indefinite one."""
    squares: list[Term] = []
    while value:
        k = next((k for k in range(value.count) if value.terms.get(_square(value.count, k), 0) > 0), None)
        if k is None:
            return None
        pivot = value.terms[_square(value.count, k)]
        form = value.derivative(k).times(1 / (2 * pivot))
        squares.append((pivot, (Power(form, 2),)))
        value -= (form * form).times(pivot)
    return squares


def _square(count: int, k: int) -> tuple[int, ...]:
    return tuple(2 * e for e in unit(count, k))


def _rounded_down(value: float) -> Fraction:
    """A number with few digits that is positive and not larger."""
    exponent = int(np.floor(np.log2(value))) - 2
    return Fraction(int(value / 2.0**exponent)) * Fraction(2) ** exponent
