"""Cells with curved sides: whether they are empty, and what they are near the origin, decided exactly.

A cell is the closure of the part of a convex region in which all guards are positive.  Guards such as
``x**2*y - x**4 - y**2`` are positive nowhere, yet vanish at the origin, where no bound on coefficients shows that; and
``x**3 - x**2 - y**2`` is zero at the origin and negative everywhere near it.  So the plane is cut into columns, as in a
cylindrical algebraic decomposition (Collins 1975).

Let the curves be the distinct irreducible factors over Q of all guards and the sides of the region.  Between
neighbouring real zeros of their discriminants, of their leading coefficients in y, of the resultants of two of them,
and of those factors that do not hold y, the real roots y of the curves move continuously with x and never meet.  So
each open piece of the plane off the curves lies over such a column between neighbouring roots, and all guards have one
sign on it: the sign at one rational point.

*Emptiness.*  An open cell is a union of such pieces and of parts of curves, and if it is not empty it holds one of the
points.

*Germs.*  On a cone from ray a to ray b let ``c = s (a + t (b - a))`` with ``0 < t < 1`` and small ``s > 0``.  A guard
becomes ``s^m G(s, t)`` with ``G(0, t)`` not the zero polynomial (it is the guard's form of lowest degree).  Of the
columns of all G over the axis of s only the first one beside s = 0 counts: its pieces are what the cell is near the
origin (the local conic structure of semialgebraic sets: Bochnak, Coste and Roy 1998, sec. 9.3).

Over Q both are decided, emptiness within limits on the degrees and the lengths of coefficients.  With irrational
coefficients nothing is said of emptiness; of germs only the forms of lowest degree are looked at.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import lru_cache
from itertools import combinations, pairwise
from typing import Any, TypeAlias

from flint import Ordering, ctx, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region
from nonsmooth.proofs.inequalities.forms import directions, simplest
from nonsmooth.proofs.inequalities.real_roots import Sturm, along_ray, complex_roots, germ_sign, trimmed, value
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial

MOST_WORK = 400_000  # bits of the longest coefficient times (sum of squared degrees)^2: a second or two
FIRST_PRECISION = 64  # bits with which roots are enclosed; doubled until the enclosures are disjoint
SAMPLES = 16  # values of t at which forms with irrational coefficients are looked at

CONTEXT = fmpq_mpoly_ctx.get(("x", "y"), Ordering.lex)
CHART_NAMES = ("s", "t")

Bounds: TypeAlias = tuple[fmpq, fmpq]
Side: TypeAlias = tuple[fmpq, fmpq, fmpq]
Terms: TypeAlias = tuple[tuple[tuple[int, ...], fmpq], ...]


# ---- columns over Q ------------------------------------------------------------------------------


def factors(polynomials: Iterable[fmpq_mpoly]) -> list[fmpq_mpoly]:
    """The distinct irreducible factors that are no numbers."""
    by_text: dict[str, fmpq_mpoly] = {}
    for polynomial in polynomials:
        for factor, _ in polynomial.factor()[1]:
            by_text[str(factor)] = factor
    return list(by_text.values())


def critical_values(curves: Sequence[fmpq_mpoly]) -> Iterator[fmpq_poly]:
    """Polynomials in x between whose real zeros the roots y of the curves neither appear, nor vanish, nor meet."""
    upright = [curve for curve in curves if not curve.degrees()[1]]
    others = [curve for curve in curves if curve.degrees()[1]]
    yield from map(_in_x, upright)
    for curve in others:
        yield _in_x(_leading(curve))
        if curve.degrees()[1] > 1:
            yield _in_x(curve.discriminant("y"))
    for first, second in combinations(others, 2):
        yield _in_x(first.resultant(second, "y"))


def _leading(curve: fmpq_mpoly) -> fmpq_mpoly:
    """The coefficient of the highest power of y."""
    top = curve.degrees()[1]
    return CONTEXT.from_dict({(e[0], 0): c for e, c in curve.to_dict().items() if e[1] == top})


def _in_x(polynomial: fmpq_mpoly) -> fmpq_poly:
    """A polynomial without y, dense."""
    terms = {int(e[0]): c for e, c in polynomial.to_dict().items()}
    return fmpq_poly([terms.get(k, 0) for k in range(max(terms, default=-1) + 1)])


def column(curves: Iterable[fmpq_mpoly], x: fmpq) -> Iterator[fmpq]:
    """Rational values of y, one in each part between neighbouring roots of the curves at a value of x."""
    return samples(_in_y(curve, x) for curve in curves)


def _in_y(curve: fmpq_mpoly, x: fmpq) -> fmpq_poly:
    """``curve(x, y)`` at a value of x, dense in y."""
    terms: dict[int, fmpq] = {}
    for (power, degree), c in curve.to_dict().items():
        terms[int(degree)] = terms.get(int(degree), fmpq(0)) + c * x ** int(power)
    return fmpq_poly([terms.get(k, 0) for k in range(max(terms) + 1)])


def samples(polynomials: Iterable[fmpq_poly]) -> Iterator[fmpq]:
    """Rational numbers, one below, one above and one between all neighbouring real roots of some polynomials."""
    roots = _separated_roots([polynomial for polynomial in polynomials if polynomial.degree() > 0])
    if not roots:
        yield fmpq(0)
        return
    yield fmpq(roots[0][0].floor() - 1)
    for (_, low), (high, _) in pairwise(roots):
        yield _short_between(low, high)
    yield fmpq(roots[-1][1].ceil() + 1)


def _separated_roots(polynomials: Sequence[fmpq_poly]) -> list[Bounds]:
    """Disjoint bounds of the distinct real roots, ascending."""
    irreducible = {str(factor): factor for polynomial in polynomials for factor, _ in polynomial.factor()[1]}
    precision = FIRST_PRECISION
    while True:
        with ctx.workprec(precision):
            roots: Any = [root.real for part in irreducible.values() for root in complex_roots(part) if root.imag == 0]
            enclosures = sorted((root.lower().fmpq(), root.upper().fmpq()) for root in roots)
        if all(before[1] < after[0] for before, after in pairwise(enclosures)):
            return enclosures
        precision *= 2


def _short_between(low: fmpq, high: fmpq) -> fmpq:
    """A number with few digits in an open interval."""
    scale = fmpq(1)
    while True:
        inner = ((low * scale).floor() + 1) / scale
        if inner < high:
            return fmpq(inner)
        scale *= 2


def _rational(number: Any) -> fmpq | None:
    plain = simplest(evaluated(number))
    return fmpq(plain) if isinstance(plain, int | fmpq) else None


def _rational_terms(polynomial: Polynomial) -> Terms | None:
    terms = [(e, _rational(c)) for e, c in sorted(polynomial.terms.items())]
    rational = tuple((e, c) for e, c in terms if c is not None)
    return rational if len(rational) == len(terms) else None


# ---- emptiness -----------------------------------------------------------------------------------


def is_empty(region: Region) -> bool | None:
    """Whether no point strictly inside the convex part makes all guards positive; None where that is not decided."""
    sides = tuple(tuple(map(_rational, side)) for side in region.sides)
    guards = tuple(terms for terms in map(_rational_terms, region.guards) if terms is not None)
    if any(c is None for side in sides for c in side) or len(guards) < len(region.guards):
        return None
    return () in guards or _is_empty(sides, guards)


@lru_cache(maxsize=4096)
def _is_empty(sides: tuple[Side, ...], guards: tuple[Terms, ...]) -> bool | None:
    """The same for rational coefficients."""
    lines = [CONTEXT.from_dict({(1, 0): a, (0, 1): b, (0, 0): c}) for a, b, c in sides]
    polynomials = [CONTEXT.from_dict(dict(guard)) for guard in guards]
    curves = factors(polynomials)
    critical = sum(curve.total_degree() ** 2 for curve in curves)  # about as many critical values are there
    bits = max((c.height_bits() for guard in guards for _, c in guard), default=1)
    if bits * critical**2 > MOST_WORK:
        return None
    curves = factors([*curves, *lines])
    places = ((x, y) for x in samples(critical_values(curves)) for y in column(curves, x))
    return not any(all(polynomial(x, y) > 0 for polynomial in (*lines, *polynomials)) for x, y in places)


# ---- germs ---------------------------------------------------------------------------------------


class Extent(StrEnum):
    """How much of a cone near the origin belongs to an open cell."""

    WHOLE = "all of it"
    PART = "a part of it"
    NONE = "nothing of it"
    UNDECIDED = "undecided"


class ClosureMembership(StrEnum):
    """Whether points belong to the closure of an open cell."""

    YES = "they do"
    NO = "they do not"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Sector:
    """A cone of directions in which a convex region has points near the origin.

    Attributes:
        start: first ray, counterclockwise.
        end: last ray, less than a half turn on.
        extent: how much of the cone the open cell fills near the origin.
    """

    start: Point
    end: Point
    extent: Extent


def sectors(region: Region) -> Iterator[Sector]:
    """The cones of a region near the origin; none where the origin does not belong to its convex part."""
    zero = region.generators[0][2] - region.generators[0][2]
    if not Region(region.generators).contains((zero, zero)):
        return
    for a, b in directions(region):
        start, end = (a[0], a[1]), (b[0], b[1])
        yield Sector(start, end, extent(region.guards, start, end))


def closure_membership(region: Region) -> ClosureMembership:
    """Whether the origin belongs to the closure of the open cell."""
    extents = {sector.extent for sector in sectors(region)}
    if extents & {Extent.WHOLE, Extent.PART}:
        return ClosureMembership.YES
    return ClosureMembership.UNDECIDED if Extent.UNDECIDED in extents else ClosureMembership.NO


def ray_closure_membership(region: Region, ray: Point) -> ClosureMembership:
    """Whether the points of a ray near the origin belong to the closure of the open cell.

    Where a guard is positive on the ray it is positive around it, so the closed convex part decides; where it is
    negative the cell is somewhere else; where it is zero all along the ray nothing is said.
    """
    if not all(sign(a * ray[0] + b * ray[1]) >= 0 if not sign(c) else sign(c) > 0 for a, b, c in region.sides):
        return ClosureMembership.NO
    signs = {germ_sign(along_ray(guard, ray)) for guard in region.guards}
    if -1 in signs:
        return ClosureMembership.NO
    return ClosureMembership.UNDECIDED if 0 in signs else ClosureMembership.YES


def extent(guards: Sequence[Polynomial], start: Point, end: Point) -> Extent:
    """How much of the open cone near the origin has all guards positive."""
    relevant = [guard for guard in guards if not sign(guard.at_origin) > 0]
    if not relevant:
        return Extent.WHOLE
    charts = [_in_chart(guard, start, end) for guard in relevant]
    rational = [terms for terms in map(_rational_terms, charts) if terms is not None]
    if len(rational) < len(charts):
        return _extent_of_lowest_forms(charts)
    return _extent_over_rationals([CONTEXT.from_dict(dict(terms)) for terms in rational])


def _in_chart(guard: Polynomial, start: Point, end: Point) -> Polynomial:
    """``G(s, t)``: the guard at ``s (start + t (end - start))`` without its power of s."""
    s, t = Polynomial.coordinates(guard.field, CHART_NAMES)
    x, y = (s * (t * (b - a) + a) for a, b in zip(start, end, strict=True))
    inner = guard.composed([x, y])
    lowest = min((e[0] for e in inner.terms), default=0)
    return Polynomial(guard.field, CHART_NAMES, {(e[0] - lowest, e[1]): c for e, c in inner.terms.items()})


def _extent_over_rationals(charts: Sequence[fmpq_mpoly]) -> Extent:
    """By the pieces of the first column, with s for x and t for y."""
    t = CONTEXT.gen(1)
    curves = factors([*charts, t, 1 - t])
    s = _distance_below(critical_values(curves))
    filled = [all(chart(s, place) > 0 for chart in charts) for place in column(curves, s) if 0 < place < 1]
    if all(filled):
        return Extent.WHOLE
    return Extent.PART if any(filled) else Extent.NONE


def _distance_below(critical: Iterable[fmpq_poly]) -> fmpq:
    """A distance s > 0 such that no given polynomial vanishes in (0, s]: its lowest term outweighs the others."""
    s = fmpq(1)
    for polynomial in critical:
        while not _lowest_term_rules(polynomial, s):
            s /= 2
    return s


def _lowest_term_rules(polynomial: fmpq_poly, s: fmpq) -> bool:
    coefficients = [abs(c) for c in polynomial.coeffs()]
    lowest = next(k for k, c in enumerate(coefficients) if c)
    others = sum((c * s**k for k, c in enumerate(coefficients[lowest + 1 :], 1)), fmpq(0))
    return bool(coefficients[lowest] > others)


def _extent_of_lowest_forms(charts: Sequence[Polynomial]) -> Extent:
    """By ``G(0, t)``: one that is negative on the closed cone empties it, one that is positive bounds nothing."""
    lowest = [_lowest_form(chart) for chart in charts]
    signs = [_sign_on_unit_interval(form) for form in lowest]
    if -1 in signs:
        return Extent.NONE
    if all(s == 1 for s in signs):
        return Extent.WHOLE
    places = [Fraction(k, SAMPLES) for k in range(1, SAMPLES)]
    filled = any(all(sign(value(form, t)) > 0 for form in lowest) for t in places)
    emptied = any(any(sign(value(form, t)) < 0 for form in lowest) for t in places)
    return Extent.PART if filled and emptied else Extent.UNDECIDED


def _lowest_form(chart: Polynomial) -> list[Number]:
    """``G(0, t)``, ascending."""
    terms = {e[1]: c for e, c in chart.terms.items() if not e[0]}
    return trimmed([terms.get(k, chart.field.zero) for k in range(max(terms, default=-1) + 1)])


def _sign_on_unit_interval(form: Sequence[Number]) -> int:
    """The sign of a polynomial in t on all of [0, 1]; 0 where it has none."""
    chain = Sturm(form)
    ends = {chain.sign_at(Fraction(0)), chain.sign_at(Fraction(1))}
    if len(ends) > 1 or 0 in ends or chain.count(Fraction(0), Fraction(1)):
        return 0
    return ends.pop()
