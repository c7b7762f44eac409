"""Three derivatives of a nonsmooth V along a Filippov inclusion, at one point and along a line on which V bends.

With the hull F of the velocities and the hull dV of the gradients of all pieces that hold the point (Clarke gradient):

- naive: all products ``g . f``;
- Shevitz and Paden (1994): the intersection of ``g . F`` over all g in dV, that is ``[min_f max_g, max_f min_g]``;
- Bacciotti and Ceragioli (1999): the common values ``g . f`` of those f that have one product with all of dV.

Each is an interval or empty, and contains the next.  The inner sets are attained at finitely many candidates:
velocities, mixtures of two velocities on a line ``(g - g') . f = 0``, and zero where F holds it (all those lines meet
there).  Along every solution ``V'`` lies in the last set at almost all times, for any continuous piecewise polynomial
V: it is semialgebraic, so the chain rule holds for all of dV (Davis, Drusvyatskiy, Kakade and Lee 2020, thm. 5.8).

On an edge between two pieces, with gradients g_A and g_B there, every quantity of this ladder is a quotient of
polynomials in one parameter t.  With ``m_fA = g_A . f``, ``a_f = m_fA - m_fB`` (both hulls are segments):

- a velocity f with ``a_f = 0`` has the value ``m_fA`` against all of dV; two velocities with ``a_f a_h < 0`` mix to the
  value ``(a_f m_hA - a_h m_fA)/(a_f - a_h)``: these values span the set of Bacciotti and Ceragioli;
- the maximum of Shevitz and Paden is the largest of them and of ``min(m_fA, m_fB)``; the set is empty iff all
  ``m_fA`` lie strictly on one side of all ``m_hB``.

So the sign of each maximum is a function of finitely many polynomials' signs: it is constant between their roots, which
are isolated exactly, and at a root the signs are certified there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cached_property, reduce
from itertools import combinations
from operator import or_
from typing import Any, NamedTuple

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Segment, on_edge
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.real_roots import (
    Coefficients,
    RealRoot,
    along_edge,
    difference,
    positive_roots,
    product,
    samples_between,
    separated,
    trimmed,
    value,
)
from nonsmooth.proofs.inequalities.subdivision import require_effort
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, dot, hull_holds_zero, minus
from nonsmooth.symbolic.numbers.polynomial import Polynomial


@dataclass(frozen=True)
class Interval:
    """The closed interval from ``low`` to ``high``."""

    low: Any
    high: Any


class Ladder(NamedTuple):
    """The three derivatives at a point; None is the empty set, whose maximum counts as minus infinity."""

    naive: Interval
    shevitz_paden: Interval | None
    bacciotti_ceragioli: Interval | None


def ladder_at(velocities: Sequence[Point], gradients: Sequence[Point]) -> Ladder:
    """The three derivatives from the vertices of F and dV."""
    products = [dot(g, f) for g in gradients for f in velocities]
    return Ladder(
        Interval(min(products), max(products)),
        _shevitz_paden(velocities, gradients),
        _bacciotti_ceragioli(velocities, gradients),
    )


def _shevitz_paden(velocities: Sequence[Point], gradients: Sequence[Point]) -> Interval | None:
    candidates = list(velocities)
    for g, h in combinations(gradients, 2):
        candidates += mixtures(velocities, minus(g, h))
    if hull_holds_zero(velocities):
        zero = velocities[0][0] - velocities[0][0]
        candidates.append((zero, zero))
    high = max(min(dot(g, f) for g in gradients) for f in candidates)
    low = min(max(dot(g, f) for g in gradients) for f in candidates)
    return Interval(low, high) if low <= high else None


def _bacciotti_ceragioli(velocities: Sequence[Point], gradients: Sequence[Point]) -> Interval | None:
    first = gradients[0]
    bends = [minus(g, first) for g in gradients[1:] if g != first]
    if not bends:
        values = [dot(first, f) for f in velocities]
    elif any(cross(bends[0], bend) for bend in bends[1:]):
        values = [velocities[0][0] - velocities[0][0]] if hull_holds_zero(velocities) else []
    else:
        values = [dot(first, f) for f in mixtures(velocities, bends[0])]
    return Interval(min(values), max(values)) if values else None


def mixtures(velocities: Sequence[Point], normal: Point) -> Iterator[Point]:
    """Velocities, and mixtures of two, that are at right angles to a vector: they span that part of the hull."""
    parts = [dot(normal, f) for f in velocities]
    for f, part in zip(velocities, parts, strict=True):
        if not part:
            yield f
    for (f, a), (g, b) in combinations(zip(velocities, parts, strict=True), 2):
        if sign(a) * sign(b) < 0:
            yield (a * g[0] - b * f[0]) / (a - b), (a * g[1] - b * f[1]) / (a - b)


OF_A_SIGN = 4  # coefficients of a cone that cost as much as one of a polynomial whose sign at a root is asked for
SHORT = 4  # coefficients up to which square roots in them make little difference


class SupremumSign(StrEnum):
    """What the largest value of a set-valued derivative does on a part of the plane."""

    EMPTY = "empty"
    NEGATIVE = "negative"
    NONPOSITIVE = "not positive"
    UNDECIDED = "undecided"
    POSITIVE = "positive"

    @property
    def rank(self) -> int:
        """Position from harmless to worst."""
        return list(SupremumSign).index(self)

    @classmethod
    def of_sign(cls, sign: int) -> SupremumSign:
        """Of a maximum with the given sign."""
        return (cls.NEGATIVE, cls.NONPOSITIVE, cls.POSITIVE)[sign + 1]


def worst(supremum_signs: Sequence[SupremumSign]) -> SupremumSign:
    """The worst of several; EMPTY for none."""
    return max(supremum_signs, key=lambda supremum_sign: supremum_sign.rank, default=SupremumSign.EMPTY)


class SupremumSigns(NamedTuple):
    """One sign for each of the three derivatives."""

    naive: SupremumSign
    shevitz_paden: SupremumSign
    bacciotti_ceragioli: SupremumSign


@dataclass(frozen=True)
class Kink:
    """An edge between two cells on which V bends.

    Attributes:
        first: a cell beside the edge.
        second: the cell on the other side.
        edge: generators of its ends; points of the edge are ``g + t h``, ``0 < t < oo``.
    """

    first: LyapunovCell
    second: LyapunovCell
    edge: Segment

    @cached_property
    def _table(self) -> tuple[tuple[Coefficients, Coefficients], ...]:
        """``(m_fA, m_fB)`` for each velocity, in t."""
        velocities = tuple(dict.fromkeys((*self.first.velocities, *self.second.velocities)))
        (a, b), (c, d) = self.first.gradient, self.second.gradient
        products = [(a * f + b * g, c * f + d * g) for f, g in velocities]
        degree = max(p.degree for pair in products for p in pair)
        return tuple((self.along(p, degree), self.along(q, degree)) for p, q in products)

    def along(self, polynomial: Polynomial, degree: int | None = None) -> Coefficients:
        """A polynomial on the edge, times a power of w that is positive there."""
        return tuple(along_edge(polynomial, self.edge, degree))

    @property
    def is_continuous(self) -> bool:
        """Whether the two pieces of V agree on the edge."""
        return not any(self.along(self.first.potential - self.second.potential))

    @property
    def bends(self) -> bool:
        """Whether the gradients differ on the edge."""
        (a, b), (c, d) = self.first.gradient, self.second.gradient
        return any(self.along(a - c)) or any(self.along(b - d))

    @cached_property
    def roots(self) -> list[RealRoot]:
        """Where a sign that matters may change, inside the edge.

        Raises:
            WorkLimitError: for too many of them.
        """
        curves = {tuple(trimmed(curve)) for curve in self._curves()}
        work = max(map(_work_of_sign, curves), default=0)
        require_effort(sum(len(curve) * _work_of_sign(curve) for curve in curves))  # of Sturm chains
        roots = (root for curve in curves if len(curve) > 1 for root in positive_roots(curve))
        return separated(roots, lambda: require_effort(work))

    def _curves(self) -> list[Coefficients]:
        table = self._table
        bends = [difference(a, b) for a, b in table]
        curves = [curve for pair in table for curve in pair] + bends
        curves += [difference(a, b) for a, _ in table for _, b in table]
        curves += [self._mixed(i, j) for i, j in combinations(range(len(table)), 2)]
        return curves

    def _mixed(self, i: int, j: int) -> Coefficients:
        """Numerator ``a_i m_jA - a_j m_iA``."""
        (p, q), (r, s) = self._table[i], self._table[j]
        return difference(product(difference(p, q), r), product(difference(r, s), p))

    def samples(self) -> list[Fraction]:
        """One point between any two neighbouring roots, and one before and after them."""
        return samples_between(self.roots)

    def point(self, t: Fraction) -> tuple[Any, Any]:
        """The point of the edge at a parameter."""
        return on_edge(self.edge, t)

    def supremum_signs(self) -> tuple[SupremumSigns, Fraction | RealRoot]:
        """The worst signs on the open edge, and where the last derivative is worst.

        Raises:
            WorkLimitError: for too many places at which signs are asked for.
        """
        places: list[Fraction | RealRoot] = [*self.samples(), *self.roots]
        supremum_signs = [self.signs_at(place) for place in places]
        order = [supremum_sign.bacciotti_ceragioli.rank for supremum_sign in supremum_signs]
        return SupremumSigns(*map(worst, zip(*supremum_signs, strict=True))), places[order.index(max(order))]

    def signs_at(self, place: Fraction | RealRoot) -> SupremumSigns:
        """The signs of the three maxima at a parameter."""

        def sign_of(curve: Coefficients) -> int:
            require_effort(_work_of_sign(curve))
            return place.sign_of(curve) if isinstance(place, RealRoot) else value(curve, place).sign()

        table = self._table
        signs = [(sign_of(a), sign_of(b)) for a, b in table]
        bends = [sign_of(difference(a, b)) for a, b in table]
        common = [a for (a, _), bend in zip(signs, bends, strict=True) if not bend]
        common += [
            sign_of(self._mixed(i, j)) * bends[i]
            for i, j in combinations(range(len(table)), 2)
            if bends[i] * bends[j] < 0
        ]
        apart = not common and all(bends[0] * sign_of(difference(a, b)) > 0 for a, _ in table for _, b in table)
        largest = max([*common, *(min(pair) for pair in signs)])
        return SupremumSigns(
            SupremumSign.of_sign(max(max(pair) for pair in signs)),
            SupremumSign.EMPTY if apart else SupremumSign.of_sign(largest),
            SupremumSign.of_sign(max(common)) if common else SupremumSign.EMPTY,
        )


def _work_of_sign(curve: Coefficients) -> int:
    """What the sign of a polynomial at a root costs, in coefficients of a cone: much more where it is irrational."""
    masks = reduce(or_, (mask for c in curve for mask in c.terms), 0)
    roots = masks.bit_count() + any(c.field.modulus is not None for c in curve)
    return OF_A_SIGN * len(curve) * (len(curve) << roots if roots and len(curve) > SHORT else 1)
