"""Limit surfaces fitted to pushes: an ellipsoid and a convex quartic, as level sets of a polynomial H of the wrench.

H is homogeneous of degree d and convex; a body under the wrench w moves along ``grad H(w)``, and the wrench of a motion
V maximizes ``w . V`` where ``H <= 1``.  H is fitted to pairs of motion and wrench by ::

    min  sum_i |(I - t_i t_i^T) grad H(w_i)|^2 + (H(w_i) - 1)^2,    t_i = V_i/|V_i|

over its coefficients: motions are parallel to gradients, wrenches lie on the level set.  Convexity is a linear matrix
inequality: the matrix itself for d = 2, and ``z^T (Hessian of H)(w) z = y^T Q y``, ``y = z (x) w``, Q positive
semidefinite, for d = 4 (sums of squares: sufficient, and in three variables close to necessary).  The form of the
problem is that of Zhou, Paolini, Bagnell and Mason 2016, with weights of one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy
from nonsmooth.symbolic.numbers.plane_arrays import Floats

SHARP = 1e-12  # of the gradient: a Newton iteration that comes closer has found the wrench
MOST_STEPS = 100


@dataclass(frozen=True, eq=False)
class LimitSurface:
    """``H(w) = sum_k a_k w^{e_k}``, homogeneous of degree 2 or 4 and convex; a in the order of :func:`exponents`."""

    degree: int
    coefficients: Floats

    def values(self, wrenches: Floats) -> Floats:
        """``H`` at wrenches (n, 3), shape (n,)."""
        return np.asarray(monomials(self.degree, wrenches) @ self.coefficients)

    def gradients(self, wrenches: Floats) -> Floats:
        """``grad H``, shape (n, 3): the directions of motion."""
        return np.asarray(gradient_monomials(self.degree, wrenches) @ self.coefficients)

    def hessians(self, wrenches: Floats) -> Floats:
        """Second derivatives, shape (n, 3, 3)."""
        derivatives = np.array([[monomials(self.degree, wrenches, i, j) for j in range(3)] for i in range(3)])
        return np.asarray(np.moveaxis(derivatives, 2, 0) @ self.coefficients)

    def wrenches(self, motions: Floats) -> Floats:
        """Wrenches of motions (n, 3), up to their size: where ``H(w) - V . w`` is least, by damped Newton steps."""
        return np.array([self._wrench(motion / np.linalg.norm(motion)) for motion in motions])

    def _wrench(self, motion: Floats) -> Floats:
        w = motion.copy()
        for _ in range(MOST_STEPS):
            slope = self.gradients(w[None])[0] - motion
            if np.abs(slope).max() <= SHARP:
                break
            hessian = self.hessians(w[None])[0]
            step = np.linalg.solve(hessian + SHARP * np.trace(hessian) * np.eye(3), -slope)
            w = w + self._damping(w, step, motion) * step
        return w

    def _damping(self, w: Floats, step: Floats, motion: Floats) -> float:
        """The first power of 1/2 at which the function does not rise."""
        sizes = 0.5 ** np.arange(40)
        trials = w + sizes[:, None] * step
        values = self.values(trials) - trials @ motion
        before = self.values(w[None])[0] - w @ motion
        return float(sizes[int(np.argmax(values <= before))])


def fit_surface(degree: int, motions: Floats, wrenches: Floats) -> LimitSurface:
    """The convex polynomial of degree 2 or 4 that fits pairs (n, 3) best; wrenches are scaled to a mean size of 1.

    Raises:
        RuntimeError: where the solver finds no optimum.
    """
    load_cvxpy()
    import cvxpy as cp

    scaled = wrenches / np.linalg.norm(wrenches, axis=1).mean()
    directions = motions / np.linalg.norm(motions, axis=1, keepdims=True)
    slopes, count = gradient_monomials(degree, scaled), len(exponents(degree))
    aside = slopes - directions[:, :, None] * (directions[:, None, :] @ slopes)
    matrix = np.vstack([aside.reshape(-1, count), monomials(degree, scaled)])
    aims = np.append(np.zeros(3 * len(scaled)), np.ones(len(scaled)))
    left, right, size = _convexity(degree)
    a, gram, misfit = cp.Variable(count), cp.Variable((size, size), PSD=True), cp.Variable()
    constraints = [left @ a == right @ gram.flatten(order="C"), cp.SOC(misfit, matrix @ a - aims)]
    problem = cp.Problem(cp.Minimize(misfit), constraints)
    problem.solve(solver=cp.CLARABEL)
    if a.value is None:
        raise RuntimeError(f"required a fitted limit surface, received {problem.status}")
    return LimitSurface(degree, np.asarray(a.value))


def _convexity(degree: int) -> tuple[Floats, Floats, int]:
    """``z^T (Hessian of H)(w) z = y^T Q y``, coefficient by coefficient: matrices on those of H and of Q, and Q's size.

    A monomial ``z_i z_j w^e`` is the key ``(i, j, *e)`` with ``i <= j``.
    """
    basis = [(z, e) for z in range(3) for e in exponents(degree // 2 - 1)]
    parts = list(_hessian_terms(degree))
    keys = sorted({key for key, _, _ in parts})
    left, right = np.zeros((len(keys), len(exponents(degree)))), np.zeros((len(keys), len(basis) ** 2))
    for key, k, factor in parts:
        left[keys.index(key), k] += factor
    for i, (zi, ei) in enumerate(basis):
        for j, (zj, ej) in enumerate(basis):
            key = (*sorted((zi, zj)), *(p + q for p, q in zip(ei, ej, strict=True)))
            right[keys.index(key), i * len(basis) + j] += 1
    return left, right, len(basis)


def _hessian_terms(degree: int) -> Iterator[tuple[tuple[int, ...], int, float]]:
    """Monomials ``z_i z_j w^e`` of ``z^T Hessian z`` with the coefficient of H and the factor that they have."""
    for k, power in enumerate(exponents(degree)):
        for i in range(3):
            for j in range(3):
                left = list(power)
                factor = left[i]
                left[i] -= 1
                factor *= left[j]
                left[j] -= 1
                if factor:
                    yield (*sorted((i, j)), *left), k, float(factor)


def exponents(degree: int) -> list[tuple[int, int, int]]:
    """Powers of the monomials of a degree in three variables."""
    chosen = combinations_with_replacement(range(3), degree)
    return [(c.count(0), c.count(1), c.count(2)) for c in chosen]


def monomials(degree: int, wrenches: Floats, *variables: int) -> Floats:
    """``w^{e_k}``, or its derivatives by some variables one after the other, shape (n, K)."""
    powers = np.array(exponents(degree))
    factor = np.ones(len(powers))
    for i in variables:
        factor = factor * powers[:, i]
        powers[:, i] = np.maximum(powers[:, i] - 1, 0)
    return np.asarray(factor * np.prod(wrenches[:, None, :] ** powers, axis=2))


def gradient_monomials(degree: int, wrenches: Floats) -> Floats:
    """``d w^{e_k}/d w_i``, shape (n, 3, K)."""
    return np.stack([monomials(degree, wrenches, i) for i in range(3)], axis=1)
