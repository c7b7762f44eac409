"""Points at which an inequality fails: floats look for them, rational arithmetic decides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.symbolic.numbers.polynomial import Exponents

POINTS = 1_500
HALVINGS = 10  # of the distance from the point
FINE = 1 << 10  # denominator of a point, in parts of its distance
TRIES = 6

Point = tuple[fmpq, ...]


def refuting_point(condition: Condition, *, strictly: bool) -> Point | None:
    """A point inside the guards at which p is negative (or zero, unless ``strictly``); None where none is found.

    Args:
        condition: without parameters.
        strictly: whether zero refutes nothing.
    """
    rng = np.random.default_rng(0)
    cloud = rng.uniform(-1, 1, (POINTS, condition.variables))
    axes = np.eye(condition.variables)
    cloud = np.vstack([axes, -axes, cloud])
    halved = 0.5 ** rng.integers(0, HALVINGS, len(cloud))
    points = cloud * halved[:, None]
    inside = np.ones(len(points), dtype=bool)
    for guard in condition.guards:
        inside &= values_at(guard, points) > 0
    points, halved = points[inside], halved[inside]
    if not len(points):
        return None
    order = min(map(sum, condition.constant), default=0)
    value = values_at(condition.constant, points) / halved**order
    for k in np.argsort(value)[:TRIES]:
        step = FINE * round(1 / float(halved[k]))
        point = tuple(fmpq(round(float(x) * step), step) for x in points[k])
        found = exact_value(condition.constant, point)
        fails = found < 0 or (not found and not strictly and any(point))
        if fails and all(exact_value(guard, point) > 0 for guard in condition.guards):
            return point
    return None


def values_at(terms: Mapping[Exponents, fmpq], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """A polynomial at many points, in floats."""
    total = np.zeros(len(points))
    for exponents, value in terms.items():
        product = np.full(len(points), float(value))
        for k, exponent in enumerate(exponents):
            if exponent:
                product *= points[:, k] ** exponent
        total += product
    return total


def exact_value(terms: Mapping[Exponents, fmpq], point: Sequence[fmpq]) -> fmpq:
    """A polynomial at a rational point."""
    total = fmpq(0)
    for exponents, value in terms.items():
        product = value
        for x, exponent in zip(point, exponents, strict=True):
            if exponent:
                product *= x**exponent
        total += product
    return total


def as_fractions(point: Sequence[fmpq]) -> tuple[Fraction, ...]:
    """The same numbers."""
    return tuple(Fraction(int(x.p), int(x.q)) for x in point)
