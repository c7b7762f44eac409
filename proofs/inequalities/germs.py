"""What a cell with curved sides is near the origin: its germ, decided exactly.

A guard that vanishes at the origin says nothing of the points around it: ``x**3 - x**2 - y**2`` is zero there and
negative everywhere near it.  So a cell counts at the origin only if its *open* part, where every guard is positive,
has points at every small distance.

On a cone from ray a to ray b let ``c = s (a + t (b - a))`` with ``0 < t < 1`` and small ``s > 0``.  A guard becomes
``s^m G(s, t)`` with ``G(0, t)`` not the zero polynomial (it is the guard's form of lowest degree).  Let Q(s, t) be the
product of the distinct irreducible factors of all G that hold t.  Below every positive zero of its discriminant and of
``Q(s, 0)`` and ``Q(s, 1)`` the roots t of Q between 0 and 1 neither meet nor enter nor leave: the signs of the guards
at one such s, between neighbouring roots, are their signs near the origin (the local conic structure of semialgebraic
sets: Bochnak, Coste and Roy 1998, sec. 9.3).  Over Q this decides completely.  With irrational coefficients only the
forms of lowest degree are looked at, and what they leave open stays undecided.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import combinations, pairwise
from typing import Any

from flint import Ordering, arb, ctx, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region
from nonsmooth.proofs.inequalities.cell_forms import directions
from nonsmooth.proofs.inequalities.dense_polynomials import trimmed
from nonsmooth.proofs.inequalities.real_roots import Sturm
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial

SAMPLES = 16  # values of t at which forms with irrational coefficients are looked at
FIRST_PRECISION = 64  # bits with which roots are enclosed; doubled until the enclosures are disjoint

CHART = fmpq_mpoly_ctx.get(("s", "t"), Ordering.lex)
CHART_NAMES = ("s", "t")


class Extent(StrEnum):
    """How much of a cone near the origin belongs to an open cell."""

    WHOLE = "all of it"
    PART = "a part of it"
    NONE = "nothing of it"
    UNDECIDED = "undecided"


class Adherence(StrEnum):
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
    if not _convex_part_holds(region, (zero, zero)):
        return
    for a, b in directions(region):
        start, end = (a[0], a[1]), (b[0], b[1])
        yield Sector(start, end, extent(region.guards, start, end))


def adherence(region: Region) -> Adherence:
    """Whether the origin belongs to the closure of the open cell."""
    found = {sector.extent for sector in sectors(region)}
    if found & {Extent.WHOLE, Extent.PART}:
        return Adherence.YES
    return Adherence.UNDECIDED if Extent.UNDECIDED in found else Adherence.NO


def ray_adherence(region: Region, ray: Point) -> Adherence:
    """Whether the points of a ray near the origin belong to the closure of the open cell.

    Where a guard is positive on the ray it is positive around it, so the closed convex part decides; where it is
    negative the cell is somewhere else; where it is zero all along the ray nothing is said.
    """
    if not all(sign(a * ray[0] + b * ray[1]) >= 0 if not sign(c) else sign(c) > 0 for a, b, c in region.sides):
        return Adherence.NO
    signs = {_sign_along(guard, ray) for guard in region.guards}
    if -1 in signs:
        return Adherence.NO
    return Adherence.UNDECIDED if 0 in signs else Adherence.YES


def extent(guards: Sequence[Polynomial], start: Point, end: Point) -> Extent:
    """How much of the open cone near the origin has all guards positive."""
    asked = [guard for guard in guards if not _is_positive_constantly(guard)]
    if not asked:
        return Extent.WHOLE
    charts = [_in_chart(guard, start, end) for guard in asked]
    rational = [_rational_chart(chart) for chart in charts]
    known = [chart for chart in rational if chart is not None]
    if len(known) == len(charts):
        return _extent_over_rationals(known)
    return _extent_of_lowest_forms(charts)


def _convex_part_holds(region: Region, point: Point) -> bool:
    return all(sign(a * point[0] + b * point[1] + c) >= 0 for a, b, c in region.sides)


def _sign_along(guard: Polynomial, ray: Point) -> int:
    """Sign of a polynomial at the points ``s ray`` with small s > 0; 0 where it vanishes at all of them."""
    s = Polynomial.variable(guard.field, ("s",), "s")
    along = guard.composed([s * ray[0], s * ray[1]])
    return along.terms[min(along.terms)].sign() if along else 0


def _is_positive_constantly(guard: Polynomial) -> bool:
    """Whether a guard is positive at the origin, and so around it."""
    return sign(guard.terms.get((0, 0), guard.field.zero)) > 0


def _in_chart(guard: Polynomial, start: Point, end: Point) -> Polynomial:
    """``G(s, t)``: the guard at ``s (start + t (end - start))`` without its power of s."""
    s, t = (Polynomial.variable(guard.field, CHART_NAMES, name) for name in CHART_NAMES)
    x, y = (s * (t * (b - a) + a) for a, b in zip(start, end, strict=True))
    inner = guard.composed([x, y])
    lowest = min((e[0] for e in inner.terms), default=0)
    return Polynomial(guard.field, CHART_NAMES, {(e[0] - lowest, e[1]): c for e, c in inner.terms.items()})


# ---- rational coefficients: complete -------------------------------------------------------------


def _rational_chart(chart: Polynomial) -> fmpq_mpoly | None:
    terms = {e: c.as_rational() for e, c in chart.terms.items()}
    known = {e: c for e, c in terms.items() if c is not None}
    return CHART.from_dict(known) if len(known) == len(terms) else None


def _extent_over_rationals(charts: Sequence[fmpq_mpoly]) -> Extent:
    curves, critical = _curves_of(charts)
    s = _distance_below(critical)
    filled = [_all_positive(charts, s, t) for t in _between_roots(curves, s)]
    if all(filled):
        return Extent.WHOLE
    return Extent.PART if any(filled) else Extent.NONE


def _curves_of(charts: Sequence[fmpq_mpoly]) -> tuple[list[fmpq_mpoly], list[fmpq_poly]]:
    """The distinct factors that hold t, and polynomials in s below whose zeros nothing changes."""
    factors: dict[str, fmpq_mpoly] = {}
    critical: list[fmpq_poly] = []
    for chart in charts:
        for factor, _ in chart.factor()[1]:
            if factor.degrees()[1]:
                factors[str(factor)] = factor
            else:
                critical.append(_in_s(factor))
    curves = list(factors.values())
    for curve in curves:
        critical += [_in_s(curve.discriminant("t"))] if curve.degrees()[1] > 1 else []
        critical += [_in_s(curve.subs({"t": fmpq(end)})) for end in (0, 1)]
    # the discriminant of a product is that of its factors times squares of their resultants
    critical += [_in_s(first.resultant(second, "t")) for first, second in combinations(curves, 2)]
    return curves, [polynomial for polynomial in critical if polynomial.degree() >= 0]


def _in_s(polynomial: fmpq_mpoly) -> fmpq_poly:
    """A polynomial without t, dense."""
    terms = polynomial.to_dict()
    top = max((int(e[0]) for e in terms), default=-1)
    return fmpq_poly([terms.get((k, 0), 0) for k in range(top + 1)])


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


def _between_roots(curves: Iterable[fmpq_mpoly], s: fmpq) -> Iterator[fmpq]:
    """Rational values of t in (0, 1), one in each part between neighbouring roots of the curves at ``s``."""
    product = fmpq_poly([1])
    for curve in curves:
        product *= _at_distance(curve, s)
    bounds = [(fmpq(0), fmpq(0)), *_enclosed_roots(product), (fmpq(1), fmpq(1))]
    for (_, low), (high, _) in pairwise(bounds):
        yield (low + high) / 2


def _at_distance(curve: fmpq_mpoly, s: fmpq) -> fmpq_poly:
    """``curve(s, t)``, dense in t."""
    terms: dict[int, fmpq] = {}
    for (power, degree), c in curve.to_dict().items():
        terms[int(degree)] = terms.get(int(degree), fmpq(0)) + c * s ** int(power)
    return fmpq_poly([terms.get(k, 0) for k in range(max(terms) + 1)])


def _enclosed_roots(polynomial: fmpq_poly) -> list[tuple[fmpq, fmpq]]:
    """Disjoint bounds within (0, 1) of the roots of a square-free polynomial there, ascending."""
    inside = polynomial
    for end in (0, 1):
        linear = fmpq_poly([-end, 1])
        inside = inside // linear if not inside(end) else inside
    if inside.degree() < 1:
        return []
    precision = FIRST_PRECISION
    while True:
        with ctx.workprec(precision):
            roots: Any = inside.complex_roots()  # real ones have the imaginary part zero exactly
            enclosures = [_bounds(root.real) for root, _ in roots if root.imag == 0]
        kept = sorted((low, high) for low, high in enclosures if high > 0 and low < 1)
        walls = [(fmpq(0), fmpq(0)), *kept, (fmpq(1), fmpq(1))]
        if all(before[1] < after[0] for before, after in pairwise(walls)):
            return kept
        precision *= 2


def _bounds(root: arb) -> tuple[fmpq, fmpq]:
    """Rational bounds of an enclosed real root."""
    return root.lower().fmpq(), root.upper().fmpq()


def _all_positive(charts: Iterable[fmpq_mpoly], s: fmpq, t: fmpq) -> bool:
    return all(chart(s, t) > 0 for chart in charts)


# ---- irrational coefficients: the forms of lowest degree -----------------------------------------


def _extent_of_lowest_forms(charts: Sequence[Polynomial]) -> Extent:
    """By ``G(0, t)``: one that is negative on the closed cone empties it, one that is positive bounds nothing."""
    lowest = [_lowest_form(chart) for chart in charts]
    signs = [_sign_on_unit_interval(form) for form in lowest]
    if -1 in signs:
        return Extent.NONE
    if all(s == 1 for s in signs):
        return Extent.WHOLE
    samples = [Fraction(k, SAMPLES) for k in range(1, SAMPLES)]
    filled = any(all(sign(_value(form, t)) > 0 for form in lowest) for t in samples)
    emptied = any(any(sign(_value(form, t)) < 0 for form in lowest) for t in samples)
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


def _value(form: Sequence[Number], t: Fraction) -> Any:
    total: Any = form[0].field.zero
    for c in reversed(form):
        total = total * t + c
    return total
