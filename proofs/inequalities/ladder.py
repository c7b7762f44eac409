"""Three derivatives of a nonsmooth V along a Filippov inclusion at one point, exactly.

With the hull F of the velocities and the hull dV of the gradients of all pieces that hold the point (Clarke gradient):

- naive: all products ``g . f``;
- Shevitz and Paden (1994): the intersection of ``g . F`` over all g in dV, that is ``[min_f max_g, max_f min_g]``;
- Bacciotti and Ceragioli (1999): the common values ``g . f`` of those f that have one product with all of dV.

Each is an interval or empty, and contains the next.  The inner sets are attained at finitely many candidates:
velocities, mixtures of two velocities on a line ``(g - g') . f = 0``, and zero where F holds it (all those lines meet
there).  Along every solution ``V'`` lies in the last set at almost all times, for any continuous piecewise polynomial
V: it is semialgebraic, so the chain rule holds for all of dV (Davis, Drusvyatskiy, Kakade and Lee 2020, thm. 5.8).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot, hull_holds_zero, minus


@dataclass(frozen=True)
class Interval:
    """The closed interval from ``low`` to ``high``."""

    low: Any
    high: Any

    def __str__(self) -> str:
        return f"{{{self.low}}}" if not self.high - self.low else f"[{self.low}, {self.high}]"


@dataclass(frozen=True)
class Ladder:
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
