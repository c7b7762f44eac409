"""Where inequalities of a claim are least, in floats: what samples propose for levels, rates and gains.

Samples are random points of the cube, or points on rays, where the guards of an inequality hold; the search goes on
closer and closer to the best of them.  Nothing here is proved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.positivity import Inequality
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.symbolic.numbers.polynomial import Exponents, float_values

Floats: TypeAlias = NDArray[np.float64]

RAYS, SHRINKING, DISTANCES = 25, 0.5625, 10  # of points at which ratios are looked at: rays for each orthant
GRID = {1: 3, 2: 13, 3: 5, 4: 3}  # points of a side of the cube that they pass, besides
POINTS, FEWER = 4_000, 500  # of the search for a least value; fewer of one variable
BEST, ROUNDS, SPREAD = 32, 7, 0.35


def kept(inequality: Inequality, points: Floats) -> Floats:
    """The points at which no guard is negative."""
    kept = np.ones(len(points), dtype=bool)
    for guard in inequality.guards.values():
        kept &= float_values(terms_of(guard), points) >= 0
    return points[kept]


@lru_cache
def points_near(count: int) -> Floats:
    """Points of the cube on rays, at distances that fall by a constant factor: terms of low degree decide near it."""
    side = np.linspace(-1, 1, GRID.get(count, 2))
    regular = np.stack(np.meshgrid(*[side] * count), axis=-1).reshape(-1, count)
    rays = np.vstack([np.random.default_rng(0).uniform(-1, 1, (RAYS << count, count)), regular])
    rays = rays[np.any(rays != 0, axis=1)]
    rays /= np.abs(rays).max(axis=1, keepdims=True)
    return np.vstack([rays * SHRINKING**k for k in range(DISTANCES)])


def least(inequality: Inequality) -> tuple[float, tuple[float, ...]]:
    """The least value that is met in a search by samples, and where; infinite where no point is kept."""
    value = inequality.value
    points = np.random.default_rng(0).uniform(-1, 1, (POINTS if value.count > 1 else FEWER, value.count))
    return least_near(inequality, kept(inequality, points), partial(float_values, terms_of(value)))


def least_near(
    inequality: Inequality, points: Floats, values_at: Callable[[Floats], Floats]
) -> tuple[float, tuple[float, ...]]:
    """The same of any values, at some points that are kept and closer and closer to the best of them."""
    source, found = np.random.default_rng(0), (float("inf"), ())
    for k in range(ROUNDS):
        if not len(points):
            break
        values = values_at(points)
        best = points[np.argsort(values)[:BEST]]
        found = float(values.min()), tuple(best[0])
        steps = source.normal(scale=SPREAD ** (k + 1), size=(BEST, *best.shape))
        points = kept(inequality, np.vstack([best, np.clip((best + steps).reshape(-1, best.shape[1]), -1, 1)]))
    return found


def ratios_at(value: Mapping[Exponents, Any], size: Mapping[Exponents, Any], points: Floats) -> Floats:
    """Of two polynomials; infinite where the second one is not positive."""
    sizes = float_values(size, points)
    with np.errstate(all="ignore"):
        ratios = float_values(value, points) / sizes
    return np.where(np.isfinite(ratios) & (sizes > 0), ratios, np.inf)
