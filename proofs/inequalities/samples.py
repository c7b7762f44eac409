"""Counterexamples among rational points: cheap, so they are looked for before a proof on a cell with curved sides.

Floats propose points of each triangle of the region, at distances from the origin that fall by powers of eight; the
first few at which a claim seems to fail are evaluated exactly, and only an exact failure counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.region import Triple
from nonsmooth.proofs.inequalities.cell_forms import CellClaim, triangles
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial

PARTS = 12  # of each side of a triangle
SCALES = (1, 8, 64, 512)  # factors of the first corner, the origin where the region holds it
CONFIRMED = 4  # points of each triangle that are evaluated exactly

Weights: TypeAlias = tuple[int, int, int]


def counterexample(claim: CellClaim) -> tuple[Any, Any] | None:
    """A point of the region inside all guards at which a claim fails; None where none was found."""
    for triangle in triangles(claim.region, holds_origin=claim.holds_origin):
        for weights in _suspects(claim, triangle):
            point = _point(triangle, weights)
            if _fails_at(claim, point):
                return point
    return None


@cache
def _grid() -> tuple[Weights, ...]:
    """Weights of the corners of a triangle, no point twice."""
    found: dict[tuple[Fraction, Fraction], Weights] = {}
    for scale in SCALES:
        for j in range(PARTS + 1):
            for k in range(PARTS + 1 - j):
                weights = ((PARTS - j - k) * scale, j, k)
                total = sum(weights)
                found.setdefault((Fraction(j, total), Fraction(k, total)), weights)
    return tuple(found.values())


def _suspects(claim: CellClaim, triangle: Sequence[Triple]) -> Iterator[Weights]:
    """The weights at which floats say that the claim fails, the clearest failures first."""
    weights = np.array(_grid(), dtype=float)
    x, y, w = (weights @ np.array([[float(v) for v in g] for g in triangle])).T
    inside = w > 0
    with np.errstate(all="ignore"):
        x, y = x / w, y / w
        for guard in claim.region.guards:
            inside &= _values(guard, x, y)[0] > 0
        values, sizes = _values(claim.polynomial, x, y)
        share = values / sizes
    fails = (share <= 0 if claim.strict else share < 0) & inside & np.isfinite(share)
    order = np.argsort(np.where(fails, share, np.inf), kind="stable")
    for k in order[: min(CONFIRMED, int(fails.sum()))]:
        yield _grid()[int(k)]


def _values(polynomial: Polynomial, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[Any, Any]:
    """Values, and the sums of the terms' sizes."""
    total, size = np.zeros_like(x), np.zeros_like(x)
    for (a, b), c in polynomial.terms.items():
        term = float(c) * x**a * y**b
        total += term
        size += np.abs(term)
    return total, size


def _point(triangle: Sequence[Triple], weights: Weights) -> tuple[Any, Any]:
    x, y, w = (sum(c * v for c, v in zip(column, weights, strict=True)) for column in zip(*triangle, strict=True))
    return x / w, y / w


def _fails_at(claim: CellClaim, point: tuple[Any, Any]) -> bool:
    """The exact test: strictly inside the guards, in the closed convex part, and the claim false."""
    if claim.except_origin and not any(point):
        return False
    if not claim.region.contains(point) or any(sign(guard(point)) <= 0 for guard in claim.region.guards):
        return False
    here = sign(claim.polynomial(point))
    return here < 0 or (here == 0 and claim.strict)
