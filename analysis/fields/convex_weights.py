"""Small problems about convex hulls: basic solutions of ``sum l_k w_k = 0`` and the point of least norm.

The hulls mostly have few vertices (cells around a point), so all basic solutions are listed at once; where many
surfaces cross, linear programs find those that matter.  The point of least norm of their hull is a non-negative
least-squares problem (Lawson & Hanson 1974, ch. 23).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product
from math import comb
from typing import Any

import numpy as np

from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, max_norm

# Relative to the largest vector: singular values below belong to directions in which nothing points.
RANK_SLACK = 1e-10
# Weights this much below zero are zero: the systems solved have entries of size one.
WEIGHT_SLACK = 1e-10
MOST_SUBSETS = 5_000  # of vectors whose basic solutions are listed: four surfaces that cross have 4,368
MOST_MIXED = 40  # basic solutions that are sought for one point of least norm


def basic_weights(columns: Floats) -> Floats:
    """All basic solutions of ``l @ vectors = 0, sum l = 1, l >= 0``, one per row.

    Every solution is a convex combination of these; none means that the hull of the vectors does not hold zero.

    Args:
        columns: of these vectors (:func:`columns_of`).
    """
    count, size = columns.shape
    if count < size:
        return np.zeros((0, count))
    subsets, solutions = _basic_solutions(columns, list(combinations(range(count), size)), size)
    weights = np.zeros((len(subsets), count))
    np.put_along_axis(weights, subsets, np.maximum(solutions, 0.0), axis=1)
    return weights / weights.sum(axis=1, keepdims=True)


def central_weights(vectors: Floats) -> Floats | None:
    """A solution of ``l @ vectors = 0, sum l = 1`` whose least entry t is largest; None where there is none.

    t is not negative exactly where the hull of the vectors holds zero, and it changes continuously with them: with the
    mean m of the n vectors, ``-s m`` leaves their hull at ``s = n t/(1 - n t)``.  Written ``l = t + p, p >= 0``, it is
    the best of the basic solutions, which hold t and rank many of the p.
    """
    count = len(vectors)
    columns = columns_of(vectors)
    rank = columns.shape[1] - 1
    if comb(count, rank) > MOST_SUBSETS:
        return _central_by_program(columns)
    chosen = [(*subset, count) for subset in combinations(range(count), rank)]
    subsets, solutions = _basic_solutions(np.vstack([columns, columns.sum(axis=0)]), chosen, rank)
    if not len(subsets):
        return None
    best = np.argmax(solutions[:, -1])
    weights = np.full(count, solutions[best, -1])
    weights[subsets[best, :-1]] += solutions[best, :-1]
    return weights


def _central_by_program(columns: Floats) -> Floats | None:
    """The same by a linear program in t and p, the entries above it."""
    raised = np.vstack([columns, columns.sum(axis=0)])
    prices = np.zeros(len(raised))
    prices[-1] = 1.0
    found = _best_weights(raised, prices, [(0, None)] * len(columns) + [(None, None)])
    return None if found is None else found[:-1] + found[-1]


def shortest_mixture(vectors: Floats, fields: Floats) -> Floats | None:
    """Weights ``l @ vectors = 0, sum l = 1, l >= 0`` for which ``l @ fields`` is shortest; None where there are none.

    Of many vectors basic solutions are sought one by one, each the best along the shortest mixture of those before,
    until none is better (Wolfe 1976, "Finding the nearest point in a polytope").
    """
    columns = columns_of(vectors)
    if _are_listed(columns):
        possible = basic_weights(columns)
        return least_norm_weights(possible @ fields) @ possible if len(possible) else None
    found: list[Floats] = []
    mixed = better = _best_weights(columns, np.zeros(len(vectors)))
    while better is not None and len(found) < MOST_MIXED:
        found.append(better)
        mixed = least_norm_weights(np.array(found) @ fields) @ np.array(found)
        velocity = mixed @ fields
        better = _best_weights(columns, -(fields @ velocity))
        if better is None or velocity @ (velocity - better @ fields) <= WEIGHT_SLACK * max_norm(fields) ** 2:
            break
    return mixed


def extreme_mixtures(vectors: Floats, fields: Floats) -> Floats:
    """Some ``l @ fields`` of such weights, with the least and largest value of each coordinate among all; (m, n)."""
    columns = columns_of(vectors)
    if _are_listed(columns):
        return basic_weights(columns) @ fields
    ends = (_best_weights(columns, side * part) for part, side in product(fields.T, (1, -1)))
    return np.array([weights @ fields for weights in ends if weights is not None]).reshape(-1, fields.shape[1])


def _are_listed(columns: Floats) -> bool:
    return comb(*columns.shape) <= MOST_SUBSETS


def _best_weights(columns: Floats, prices: Floats, bounds: Any = (0, None)) -> Floats | None:
    """The solution of ``l @ columns = (0, ..., 0, 1)`` with the largest ``l . prices``; None where there is none.

    The program is solved to some seven digits; what it says is which weights are zero, and the others follow.
    """
    from scipy.optimize import linprog

    target = np.zeros(columns.shape[1])
    target[-1] = 1.0
    found = linprog(-prices, A_eq=columns.T, b_eq=target, bounds=bounds, method="highs-ds")
    if found.x is None:
        return None
    weights, used = np.zeros(len(columns)), np.flatnonzero(found.x)
    weights[used] = np.linalg.lstsq(columns[used].T, target)[0]
    return weights


def columns_of(vectors: Floats) -> Floats:
    """Coordinates of some vectors in an orthonormal basis of what they span (none if all are zero), and a last one."""
    scale = max_norm(vectors)
    if not scale:
        return np.ones((len(vectors), 1))
    _, values, directions = np.linalg.svd(vectors / scale, full_matrices=False)
    reduced = (vectors / scale) @ directions[values > RANK_SLACK * values[0]].T
    return np.concatenate([reduced, np.ones((len(vectors), 1))], axis=1)


def _basic_solutions(columns: Floats, chosen: Sequence[tuple[int, ...]], bounded: int) -> tuple[Indices, Floats]:
    """The chosen columns that mix into ``(0, ..., 0, 1)``, with their weights, of which the first are not negative."""
    subsets = np.array(chosen)
    systems = columns[subsets].transpose(0, 2, 1)
    regular = np.abs(np.linalg.det(systems)) > RANK_SLACK
    right = np.zeros((int(regular.sum()), columns.shape[1], 1))
    right[:, -1] = 1.0
    solutions = np.linalg.solve(systems[regular], right)[:, :, 0]
    possible = (solutions[:, :bounded] >= -WEIGHT_SLACK).all(axis=1)
    return subsets[regular][possible], solutions[possible]


def least_norm_weights(points: Floats) -> Floats:
    """Convex weights of the point of least norm in the hull of some points."""
    return np.ones(1) if len(points) == 1 else nearest_weights(points, np.zeros(points.shape[1]))


def nearest_weights(points: Floats, target: Floats) -> Floats:
    """Convex weights of the point in the hull of some points (k, d) that is nearest to a target (d,).

    With ``mu >= 0`` minimizing ``|mu @ points - target|^2 + (sum mu - 1)^2``, in units of the largest entry, they are
    ``mu / sum mu``: for the target zero or one inside the hull the first term alone decides once the sum is fixed.
    """
    from scipy.optimize import nnls

    scale = max_norm(points) or 1.0
    weights, _ = nnls(np.vstack([points.T / scale, np.ones(len(points))]), np.append(target / scale, 1.0))
    total = float(weights.sum())
    return (weights / total) if total > 0 else np.full(len(points), 1 / len(points))


def origin_distance(points: Floats) -> float:
    """Distance of the hull of some points from the origin."""
    return float(np.linalg.norm(least_norm_weights(points) @ points))


def least_mix(first: Sequence[Any], second: Sequence[Any]) -> Any:
    """Weight of the first vector in the shortest convex combination of two (one half where they are equal).

    Exact for exact numbers.
    """
    gap = [p - q for p, q in zip(first, second, strict=True)]
    square = sum(g * g for g in gap)
    if not square:
        return (square + 1) / 2
    share = -sum(g * q for g, q in zip(gap, second, strict=True)) / square
    return min(max(share, square * 0), square * 0 + 1)
