"""Polynomials in one variable over the scene's field, those on an edge among them, and their real roots.

Coefficients are dense and ascending.  Roots are isolated exactly by Sturm chains: a chain counts distinct roots between
two points that are no roots themselves, whatever the multiplicities, so no square-free decomposition is needed; between
neighbouring roots one rational point shows the sign.  Bisection at rational points ends because roots are finitely
many; nothing is rounded.  Rational polynomials are handed to FLINT as primitive integer ones, which keeps long
coefficients as short as they can be.  Cost grows quickly with the degree over a field of many square roots: meant for
degrees up to about a dozen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import dropwhile, pairwise
from typing import Any, TypeAlias

from flint import fmpq, fmpq_poly, fmpz_poly

from nonsmooth.analysis.cells.region import Segment
from nonsmooth.symbolic.formulas.surfaces import factorize, switching_factors
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from nonsmooth.symbolic.numbers.square_roots import NestingError

Coefficients: TypeAlias = Sequence[Number]


def trimmed(coefficients: Coefficients) -> list[Number]:
    """Without leading zeros; empty for the zero polynomial."""
    rest = list(coefficients)
    while rest and not rest[-1]:
        rest.pop()
    return rest


def without_zeros(coefficients: Coefficients) -> list[Number]:
    """Without the root zero."""
    return list(dropwhile(lambda c: not c, coefficients))


def value(coefficients: Coefficients, t: Any) -> Any:
    """Horner's scheme."""
    total: Any = 0
    for c in reversed(coefficients):
        total = total * t + c
    return total


def derivative(coefficients: Coefficients) -> list[Number]:
    """First derivative."""
    return [k * c for k, c in enumerate(coefficients)][1:]


def difference(first: Coefficients, second: Coefficients) -> list[Number]:
    """``first - second``; not both are empty."""
    zero = (first or second)[0].field.zero
    count = max(len(first), len(second))
    padded = [[*curve, *[zero] * (count - len(curve))] for curve in (first, second)]
    return [a - b for a, b in zip(*padded, strict=True)]


def product(first: Coefficients, second: Coefficients) -> list[Number]:
    """``first * second``, neither empty."""
    total = [first[0].field.zero] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            total[i + j] = total[i + j] + a * b
    return total


def divided(dividend: Coefficients, divisor: Coefficients) -> tuple[list[Number], list[Number]]:
    """Quotient and remainder; the divisor's leading coefficient is not zero."""
    rest, inverse = trimmed(dividend), divisor[-1].inverse()
    quotient = [inverse.field.zero] * max(len(rest) - len(divisor) + 1, 0)
    while len(rest) >= len(divisor):
        factor, shift = rest[-1] * inverse, len(rest) - len(divisor)
        quotient[shift] = factor
        for k, c in enumerate(divisor[:-1]):
            rest[shift + k] = rest[shift + k] - factor * c
        rest = trimmed(rest[:-1])
    return quotient, rest


def scaled(coefficients: Coefficients) -> list[Number]:
    """Divided by the absolute leading coefficient: the same signs, shorter numbers."""
    inverse = abs(coefficients[-1].inverse())
    return [c * inverse for c in coefficients]


def greatest_divisor(first: Coefficients, second: Coefficients) -> list[Number]:
    """Greatest common divisor, up to a factor."""
    a, b = trimmed(first), trimmed(second)
    while b:
        rest = divided(a, b)[1]
        a, b = b, scaled(rest) if rest else rest
    return a


def dense(polynomial: Polynomial) -> list[Number]:
    """The coefficients of a polynomial in one variable; empty for zero."""
    zero, top = polynomial.field.zero, polynomial.degree if polynomial else -1
    return [polynomial.terms.get((k,), zero) for k in range(top + 1)]


def germ_sign(polynomial: Polynomial) -> int:
    """The sign of a polynomial in one variable at small positive places; 0 of zero."""
    return polynomial.terms[min(polynomial.terms)].sign() if polynomial else 0


def along_ray(polynomial: Polynomial, ray: Sequence[Any]) -> Polynomial:
    """A polynomial at the points ``s ray``."""
    s = Polynomial.variable(polynomial.field, ("s",), "s")
    return polynomial.composed([s * ray[0], s * ray[1]])


def between_rays(form: Polynomial, first: Sequence[Any], second: Sequence[Any]) -> list[Number]:
    """A form on ``first + t second``, ascending in t; empty where it is zero."""
    terms = in_generators(form.terms, [first, second])
    return trimmed([form.field(terms.get((form.degree - k, k), 0)) for k in range(form.degree + 1)])


def along_edge(polynomial: Polynomial, edge: Segment, degree: int | None = None) -> list[Number]:
    """A polynomial in (x, y) at the points ``g + t h``, t > 0, of an edge, times a power of w, which is positive there.

    Args:
        polynomial: the polynomial.
        edge: the generators g and h.
        degree: of the result, leading zeros included; that of the polynomial by default.
    """
    top = polynomial.degree if degree is None else degree
    ends = [tuple(map(evaluated, generator)) for generator in edge]
    terms = in_generators(polynomial.homogenized(top).terms, ends)
    return [polynomial.field(terms.get((top - k, k), 0)) for k in range(top + 1)]


class Sturm:
    """The Sturm chain of a nonzero polynomial."""

    def __init__(self, coefficients: Coefficients) -> None:
        self.coefficients = trimmed(coefficients)
        rationals = _rationals(self.coefficients)
        self._chain = _chain(self.coefficients) if rationals is None else _integer_chain(rationals)

    def sign_at(self, t: Fraction) -> int:
        """Sign of the polynomial."""
        return _sign_at(self._chain[0], t) if self.coefficients else 0

    def variations(self, t: Fraction | None) -> int:
        """Sign changes along the chain at t; None is plus infinity."""
        signs = [sign(part[len(part) - 1]) if t is None else _sign_at(part, t) for part in self._chain]
        nonzero = [s for s in signs if s]
        return sum(a != b for a, b in pairwise(nonzero))

    def count(self, low: Fraction, high: Fraction | None) -> int:
        """Distinct roots between two points that are no roots (None is plus infinity)."""
        return self.variations(low) - self.variations(high)


def _rationals(coefficients: Coefficients) -> list[fmpq] | None:
    """The coefficients as rational numbers; None where one is none."""
    candidates = [c.as_rational() for c in coefficients]
    rationals = [q for q in candidates if q is not None]
    return rationals if len(rationals) == len(candidates) else None


def _chain(coefficients: list[Number]) -> list[list[Number]]:
    """The polynomial, its derivative and the negative remainders, each up to a positive factor."""
    chain, following = [coefficients], derivative(coefficients)
    while following:
        chain.append(scaled(following))
        following = [-c for c in divided(chain[-2], chain[-1])[1]]
    return chain


def _integer_chain(coefficients: Sequence[fmpq]) -> list[fmpz_poly]:
    """The same of a rational polynomial, with coprime integers as coefficients."""
    first = fmpq_poly(coefficients)
    chain, following = [_primitive(first)], _primitive(first.derivative())
    while following:
        chain.append(following)
        following = _primitive(-(fmpq_poly(chain[-2]) % fmpq_poly(chain[-1])))
    return chain


def _primitive(polynomial: fmpq_poly) -> fmpz_poly:
    """A positive multiple with coprime integers as coefficients; zero of zero."""
    numerator = polynomial.numer()
    return numerator // numerator.content() if numerator else numerator


def _sign_at(polynomial: Coefficients | fmpz_poly, t: Fraction) -> int:
    """The sign of a polynomial at a rational point."""
    if isinstance(polynomial, fmpz_poly):
        return sign(polynomial(fmpq(t.numerator, t.denominator)))
    return int(value(polynomial, t).sign())


@dataclass(frozen=True)
class RealRoot:
    """The one root of a polynomial between two rational points, at which the polynomial does not vanish."""

    coefficients: tuple[Number, ...]
    low: Fraction
    high: Fraction

    @cached_property
    def sturm(self) -> Sturm:
        """The polynomial's chain."""
        return Sturm(self.coefficients)

    def halved(self) -> RealRoot:
        """The same root between closer bounds."""
        middle = _regular_point(self.sturm, self.low, self.high)
        first, here, last = (self.sturm.sign_at(t) for t in (self.low, middle, self.high))
        below = here != first if first != last else self.sturm.count(self.low, middle)  # a chain for even roots only
        low, high = (self.low, middle) if below else (middle, self.high)
        half = RealRoot(self.coefficients, low, high)
        vars(half).update(sturm=self.sturm, closest=self.closest)  # the same polynomial, the same root
        return half

    @cached_property
    def closest(self) -> list[RealRoot]:
        """The root between the closest bounds that were found yet, by whatever was asked of it; one entry."""
        return [self]

    def sign_of(self, other: Coefficients) -> int:
        """Sign of another polynomial at the root."""
        other = trimmed(other)
        if not other:
            return 0
        common = greatest_divisor(self.coefficients, other)
        if len(common) > 1 and Sturm(common).count(self.low, self.high):
            return 0
        chain, here = Sturm(other), min(self, self.closest[0], key=lambda root: root.high - root.low)
        while not (chain.sign_at(here.low) and chain.sign_at(here.high)) or chain.count(here.low, here.high):
            here = here.halved()
        self.closest[0] = here
        return chain.sign_at(here.low)

    def exact(self) -> Number | None:
        """The root as a field element where it is rational or quadratic over the field, by a factor at hand."""
        for factor in _factors(self.coefficients):
            if len(factor) in (2, 3) and (root := _in_radicals(factor, self.low, self.high)) is not None:
                return root
        return None


def positive_roots(coefficients: Coefficients) -> list[RealRoot]:
    """Distinct positive roots, ascending, with disjoint positive bounds.

    Raises:
        ValueError: for the zero polynomial.
    """
    reduced = without_zeros(trimmed(coefficients))  # the root 0 is not positive
    if not reduced:
        raise ValueError("required a nonzero polynomial")
    sturm, bound = Sturm(reduced), Fraction(1)
    at_infinity = sturm.variations(None)
    while sturm.variations(bound) != at_infinity or not sturm.sign_at(bound):
        bound *= 2
    roots: list[RealRoot] = []
    waiting = [(Fraction(0), bound)]
    while waiting:
        low, high = waiting.pop()
        count = sturm.count(low, high)
        if count == 1:
            roots.append(RealRoot(tuple(reduced), low, high))
        elif count:
            middle = _regular_point(sturm, low, high)
            waiting += [(middle, high), (low, middle)]
    while roots and not roots[0].low:
        roots[0] = roots[0].halved()
    return roots


def samples_between(roots: Sequence[RealRoot]) -> list[Fraction]:
    """One point between any two neighbours of zero, ascending roots and infinity."""
    return [root.low for root in roots[:1]] + [root.high for root in roots] or [Fraction(1)]


def separated(roots: Iterable[RealRoot], before_each: Callable[[], None] = lambda: None) -> list[RealRoot]:
    """Distinct roots of several polynomials, ascending, with disjoint bounds.

    Args:
        roots: of them.
        before_each: called before two roots are compared; it may end the work by an exception.
    """
    distinct: list[RealRoot] = []
    waiting = list(roots)
    while waiting:
        root = waiting.pop()
        clash = next((k for k, other in enumerate(distinct) if root.low < other.high and other.low < root.high), None)
        if clash is None:
            distinct.append(root)
            continue
        before_each()
        if not _same(root, distinct[clash]):
            waiting += [root.halved(), distinct.pop(clash).halved()]
    return sorted(distinct, key=lambda root: root.low)


def _same(first: RealRoot, second: RealRoot) -> bool:
    """Whether the second polynomial vanishes at the first root, and that lies between the second root's bounds."""
    one = first.coefficients[0].field.one
    inside = first.sign_of([-one * second.low, one]) > 0 > first.sign_of([-one * second.high, one])
    return inside and not first.sign_of(second.coefficients)


def _regular_point(sturm: Sturm, low: Fraction, high: Fraction) -> Fraction:
    """A point between that is no root; the middle if possible."""
    parts = 2
    while not sturm.sign_at(point := low + (high - low) / parts):
        parts += 1
    return point


def _factors(coefficients: Coefficients) -> list[list[Number]]:
    """Factors that hold all roots: irreducible over Q where the coefficients are rational, square-free otherwise."""
    rationals, field = _rationals(coefficients), coefficients[0].field
    if rationals is not None:
        return [[field(c) for c in factor.coeffs()] for factor, _ in fmpq_poly(rationals).factor()[1]]
    factors: list[list[Number]] = []
    rest = trimmed(coefficients)
    while len(rest) > 1:  # rest, rest/gcd(rest, rest'): square-free layers, the last ones of low degree
        common = greatest_divisor(rest, derivative(rest))
        factors.append(divided(rest, common)[0])
        rest = common
    return factors


def _in_radicals(factor: list[Number], low: Fraction, high: Fraction) -> Number | None:
    """The root between the bounds of a linear or quadratic polynomial, where the field holds its square root."""
    if len(factor) == 2:
        roots = [-factor[0] / factor[1]]
    else:
        c, b, a = factor
        discriminant = b * b - 4 * a * c
        if discriminant.sign() < 0:
            return None
        try:
            root = discriminant.sqrt()
        except NestingError:
            return None
        roots = [(-b + s * root) / (2 * a) for s in (1, -1)]
    return next((r for r in roots if low < r < high), None)


def complex_roots(polynomial: fmpq_poly) -> list[Any]:
    """Disjoint balls around all roots; those of real ones have the imaginary part zero exactly."""
    roots: Any = polynomial.complex_roots() if polynomial.degree() > 0 else []
    return [root for root, _ in roots]


# ---- tangents of curves at the origin of the plane -----------------------------------------------
#
# Tangents of curves at the origin of the plane: the real lines on which their forms of lowest degree vanish.


def lowest_form(polynomial: Polynomial) -> Polynomial:
    """The terms of lowest degree."""
    lowest = min((sum(e) for e in polynomial.terms), default=0)
    return polynomial.part(lowest)


def form_lines(form: Polynomial) -> list[Polynomial] | None:
    """The real lines on which a form in (x, y) vanishes; None where one has no name in the field."""
    factored = factorize(form)
    factors = [form] if factored is None else [factor for factor, _ in factored[1]]
    lines: list[Polynomial] = []
    for factor in factors:
        for line in switching_factors(factor)[1]:
            if line.degree == 1:
                lines.append(line)
            elif not _is_definite(line):
                return None
    if factored is None and form.degree > 1 and len(lines) < form.degree:
        return None  # factors of even multiplicity are not seen
    return lines


def _is_definite(form: Polynomial) -> bool:
    """Whether a form without the factors x and y has no real line."""
    zero, top = form.field.zero, form.degree
    along = trimmed([form.terms.get((k, top - k), zero) for k in range(top + 1)])
    if len(along) <= top or not along[0]:
        return False
    chain = Sturm(along)
    backwards = Sturm([c * (-1) ** k for k, c in enumerate(along)])
    return not any(c.count(Fraction(0), None) for c in (chain, backwards))
