"""A friction set that the product does not have, and its rule: superellipses ``x^4 + y^4 <= 1``.

What floats ask of a set is written here once; dissipation, minimizers with their proofs, paths, and bodies with mass
follow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.fields.contact_model import FloatShape
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet, NearestForce
from nonsmooth.symbolic.mechanics.scene import Friction
from nonsmooth.symbolic.numbers.plane_arrays import Floats

STEPS = 8  # of Newton's method, which begins within a factor of three of the root
LEAST = 1e-30  # of t: below it nothing is damped


class Superellipse(FloatShape):
    """Sets with half-axes alpha and beta; nothing is cut."""

    @classmethod
    def searched(cls, cut: Floats) -> Superellipse:
        """For points (2, n, m)."""
        return cls(1.0, 1.0, cut[:, None])

    def support(self, r: Floats, s: Floats) -> Floats:
        """The dual norm of the fourth one."""
        x, y = np.abs(self.along * r), np.abs(self.across * s)
        return np.asarray((x ** (4 / 3) + y ** (4 / 3)) ** 0.75)

    def gauge(self, x: Floats, y: Floats) -> Floats:
        """The norm itself."""
        return np.asarray((x**4 + y**4) ** 0.25)

    def excess(self, x: Floats, y: Floats) -> Floats:
        """By how much it is larger than one."""
        return self.gauge(x, y) - 1

    def nearest(self, x: Floats, y: Floats) -> NearestForce:
        """``(x, y) - force = t grad(x^4 + y^4)``, by Newton's method for t; the derivative by the curvature."""
        given = np.array([x, y])
        outside = self.excess(x, y) > 0
        t = np.maximum(np.abs(given).max(axis=0) - 1, 0) / 4  # no more than the root, where no entry is above one
        for _ in range(STEPS):
            force = _damped(given, t)
            size = self.gauge(*force)
            falls = 4 * (force**6 / (1 + 12 * t * force**2)).sum(axis=0) / np.maximum(size, LEAST) ** 3
            t = np.maximum(t + (size - 1) / np.maximum(falls, LEAST), 0)
        force = np.where(outside, _damped(given, t), given)
        normal = np.where(outside, _normal(*force), 0.0)
        bend = 1 + 12 * t * (force[0] ** 2 * normal[1] ** 2 + force[1] ** 2 * normal[0] ** 2)
        return NearestForce(force, np.where(outside, 1 / bend, 1.0), normal)

    def slip_cone(self, x: Floats, y: Floats, slack: float) -> tuple[Floats, NDArray[np.bool_]]:
        """On the border slips are along its normal, against the force."""
        slips, (p, q) = self.gauge(x, y) >= 1 - slack, _normal(x, y)
        first = np.where(slips, [-p, -q], [np.ones_like(x), np.zeros_like(x)])
        second = np.where(slips, [-q, p], [np.zeros_like(x), np.ones_like(x)])
        equations = np.array([~slips, np.ones_like(slips)])
        return np.moveaxis(np.array([first, second]), (0, 1), (-2, -1)), np.moveaxis(equations, 0, -1)

    def room(self, x: Floats, y: Floats, turning: float) -> Floats:
        """The slack along the normal, and as much or the turning along the border."""
        slack = 1 - np.minimum(self.gauge(x, y), 1.0)[:, None, None]
        normal = _normal(x, y).T
        across = normal[:, :, None] * normal[:, None, :]
        return np.asarray(slack * across + np.maximum(slack, turning) * (np.eye(2) - across))

    def rounded_gradient(self, r: Floats, s: Floats, third: Floats) -> tuple[Floats, Floats]:
        """The force nearest to a multiple of the slip: the gradient of Moreau's envelope."""
        force = self.nearest(self.along * r / third, self.across * s / third).force
        return self.along * force[0], self.across * force[1]

    def rounded_hessian(self, r: Floats, s: Floats, third: Floats) -> tuple[Floats, Floats, Floats]:
        """Its derivatives."""
        xx, yy, xy = self.nearest(self.along * r / third, self.across * s / third).rates / third
        return self.along**2 * xx, self.along * self.across * xy, self.across**2 * yy


def _normal(x: Floats, y: Floats) -> Floats:
    """Unit normals of the border where a force is on it, (2, ...)."""
    gradient = np.array([x**3, y**3])
    return np.asarray(gradient / np.maximum(np.sqrt((gradient**2).sum(axis=0)), 1e-300))


def _damped(given: Floats, t: Floats) -> Floats:
    """The roots z of ``z + 4 t z^3 = given``: of a cubic with one real root, by hyperbolic functions."""
    root = np.sqrt(3 * np.maximum(t, LEAST))
    return np.asarray(np.sinh(np.arcsinh(3 * root * given) / 3) / root)


class SuperellipseRule(SmoothRule):
    """``D = sum_i N_i ((mu_R r)^(4/3) + (mu_S s)^(4/3))^(3/4)``."""

    name = "superellipse"
    summary = "friction losses are least under friction superellipses"

    def friction_set(self, friction: Friction) -> FrictionSet:
        """With half-axes mu_R and mu_S."""
        return Superellipse(friction.roll, friction.side, friction.roll.field.one)
