"""Products of weights that mix the motions of all subsets of some wheels, as where several lie under the edge."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats

STEPS = 40  # of Newton's method for the weights
WEIGHT_ERROR = 1e-12  # of the rates of the depths, relative to the largest


def subsets_of(wheels: Sequence[int]) -> Iterator[frozenset[int]]:
    """All subsets, in the order in which :func:`mixed_of` weighs them: the last wheel changes first."""
    for bits in product((False, True), repeat=len(wheels)):
        yield frozenset(wheel for wheel, bit in zip(wheels, bits, strict=True) if bit)


def _shares(weights: Floats) -> Floats:
    """``prod_(i in S) w_i prod_(i not in S) (1 - w_i)`` for every subset S."""
    shares = np.ones(1)
    for weight in weights:
        shares = np.outer(shares, [1 - weight, weight]).ravel()
    return shares


def mixed_of(corners: Floats, weights: Floats) -> Floats:
    """The motions (2^k, d) of all subsets of k wheels, mixed."""
    return np.asarray(_shares(weights) @ corners)


def balancing_weights(rates: Floats, count: int, start: Floats) -> Floats | None:
    """Weights with which the rates (2^k, k) of the depths vanish, by Newton's method; None where it does not end."""
    weights = np.clip(start, 0.0, 1.0) if start.shape == (count,) else np.full(count, 0.5)
    scale = np.abs(rates).max() or 1.0
    for _ in range(STEPS):
        here = mixed_of(rates, weights)
        if np.abs(here).max() <= WEIGHT_ERROR * scale:
            return weights
        slopes = np.empty((count, count))
        for k in range(count):  # linear in each weight
            low, high = weights.copy(), weights.copy()
            low[k], high[k] = 0.0, 1.0
            slopes[:, k] = mixed_of(rates, high) - mixed_of(rates, low)
        try:
            weights = weights - np.linalg.solve(slopes, here)
        except np.linalg.LinAlgError:
            return None
    return None
