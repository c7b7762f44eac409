"""A friction set of another shape needs nothing but itself: superellipses ``x^4 + y^4 <= 1``, and their minimizer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.sum_of_supports import SupportSums, by_multipliers
from nonsmooth.symbolic.friction_set import NearestForce

HALVINGS = 50
NEWTON = 40


class Superellipses:
    """``x^4 + y^4 <= 1`` for every contact."""

    def support(self, r: Floats, s: Floats) -> Floats:
        """The dual norm of the fourth one."""
        return np.asarray((np.abs(r) ** (4 / 3) + np.abs(s) ** (4 / 3)) ** 0.75)

    def excess(self, x: Floats, y: Floats) -> Floats:
        """By the norm itself."""
        return np.asarray((x**4 + y**4) ** 0.25 - 1)

    def nearest(self, x: Floats, y: Floats) -> NearestForce:
        """``(x, y) - force = t grad(x^4 + y^4)``, by halving an interval of t; the derivative by the curvature."""
        given = np.array([x, y])
        outside = self.excess(x, y) > 0
        low, high = np.zeros_like(x), np.abs(given).max(axis=0) + 1
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            beyond = self.excess(*_damped(given, middle)) > 0
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        force = np.where(outside, _damped(given, high), given)
        gradient = 4 * force**3
        normal = np.where(outside, gradient / np.maximum(np.sqrt((gradient**2).sum(axis=0)), 1e-300), 0.0)
        bend = 1 + 12 * high * (force[0] ** 2 * normal[1] ** 2 + force[1] ** 2 * normal[0] ** 2)
        return NearestForce(force, np.where(outside, 1 / bend, 1.0), normal)


def _damped(given: Floats, t: Floats) -> Floats:
    """The roots z of ``z + 4 t z^3 = given``, by Newton's method from beyond."""
    size = np.abs(given)
    z = size.copy()
    for _ in range(NEWTON):
        z = z - (z + 4 * t * z**3 - size) / (1 + 12 * t * z**2)
    return np.asarray(np.sign(given) * z)


def test_the_nearest_point_moves_as_it_says() -> None:
    sets, rng = Superellipses(), np.random.default_rng(0)
    points, change = rng.normal(size=(2, 50)) * 2, rng.normal(size=(2, 50)) * 1e-6
    near, after = sets.nearest(*points), sets.nearest(*(points + change))
    np.testing.assert_allclose(after.force - near.force, near.along(change), atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_multipliers_find_the_least_sum(seed: int) -> None:
    """Against a general minimizer that knows the sum alone; the proof is that of any other set."""
    rng, sets = np.random.default_rng(seed), Superellipses()
    maps, targets, weights = rng.normal(size=(5, 2, 3)), rng.normal(size=(2, 5, 1)), rng.dirichlet(np.ones(5), 2).T
    sums = SupportSums(weights, maps, targets, sets)
    found = by_multipliers(sums, np.zeros((3, 2)), np.zeros((2, 5, 2)), np.full(2, 10.0))
    values, _, lacks, _ = sums.judge(sums.slips(found.y), found.forces)
    assert lacks.max() < 1e-12
    for k in range(2):

        def value(y: Floats, k: int = k) -> float:
            slips = np.einsum("nij,j->in", maps, y) - targets[..., 0]
            return float((weights[:, k] * sets.support(*slips)).sum())

        other = minimize(value, rng.normal(size=3), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-11})
        assert values[k] == pytest.approx(value(found.y[:, k]), abs=1e-14)
        assert values[k] <= other.fun + 1e-12
        assert values[k] >= other.fun - 1e-4
