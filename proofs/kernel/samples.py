"""Claims that floats refute at points of the cube: proposals that cannot be shown are left before they are searched."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality
from nonsmooth.proofs.kernel.search import NotShownError, Search

Floats: TypeAlias = NDArray[np.float64]

POINTS, SHRINK = 600, 4.0  # points of each claim; the exponential scale of their distances
SLACK = 2.0**-30  # of the largest term, below which a value counts as zero
STEPS, TINY = 8, 2.0**-100  # of Newton's method toward a surface; the least square of a slope


class SampledProofs(Search):
    """Accepts every claim that no sample refutes: what it accepts is not shown."""

    def show(self, claim: Claim) -> None:
        """Look at a claim in floats.

        Raises:
            NotShownError: where an inequality is false at a sample.
        """
        points = sample_points(claim.count, bounded=claim.bounded)
        if any(_is_refuted(claim, inequality, points) for inequality in claim.inequalities):
            raise NotShownError(f"a sample refutes {claim.name}")
        self.found[claim.name] = claim, None
        self.used.append(claim.name)


def sample_points(count: int, *, bounded: bool, seed: int = 0) -> Floats:
    """Random points of the cube, as many near the origin as far from it, and points of its diagonals and axes."""
    source = np.random.default_rng((count, seed))
    points = source.uniform(-1, 1, (POINTS, count)) * np.exp(-source.exponential(SHRINK, (POINTS, 1)))
    points[: POINTS // 2] = np.sign(points[: POINTS // 2]) * np.exp(-source.exponential(SHRINK, (POINTS // 2, count)))
    return points


def _is_refuted(claim: Claim, inequality: Inequality, points: Floats) -> bool:
    """Whether an inequality without functions mu is false at a point where all guards are positive."""
    if inequality.pushes or inequality.zeros:
        return False
    guards = list(inequality.guards.values())
    zero = [guard for guard in guards if -guard in guards]
    for _ in range(STEPS if zero else 0):
        points = _nearer(zero[0], points)
    inside = (np.abs(points) <= 1).all(axis=1) if claim.bounded else np.ones(len(points), dtype=bool)
    for guard in guards:
        value, size = values_at(guard, points)
        inside &= (np.abs(value) <= SLACK * size) if guard in zero else (value > SLACK * size)
    value, size = values_at(inequality.value, points[inside])
    return bool((value < -SLACK * size).any()) or (claim.strict and bool(((size > 0) & (value < SLACK * size)).any()))


def _nearer(surface: Polynomial, points: Floats) -> Floats:
    """Points nearer to where a polynomial is zero: one step of Newton's method along its gradient."""
    slopes = np.stack([values_at(surface.derivative(k), points)[0] for k in range(surface.count)], axis=1)
    steps = values_at(surface, points)[0] / np.maximum((slopes**2).sum(axis=1), TINY)
    return np.asarray(points - steps[:, None] * slopes)


def values_at(polynomial: Polynomial, points: Floats) -> tuple[Floats, Floats]:
    """The values at some points, and the sums of the absolute values of the terms there."""
    value, size = np.zeros(len(points)), np.zeros(len(points))
    for exponents, coefficient in polynomial.terms.items():
        term = float(coefficient) * np.prod(points ** np.array(exponents), axis=1)
        value += term
        size += np.abs(term)
    return value, size
