"""Steps of the interior point method inside the cones of a sum of norms.

Notation and scaling are those of :mod:`nonsmooth.analysis.minimizers.norm_scaling`.  In scaled coordinates a step
splits into a primal part in the span of the columns (the map from the three unknowns) and a dual part orthogonal to
them, so that one least-squares problem gives both.  What decides how far a step may go, the determinants ``t^2 -
|r|^2`` and ``1 - |z|^2`` along it, is computed from slacks and from ``t - r_along``, never by subtracting squares:
near the solution they are 1e-12 of the squares.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.norm_scaling import TINY, Iterate, nesterov_todd, norm

NEAREST_TO_BOUNDARY = 1e-6  # a step never divides the determinant of a cone by more, whatever rounding says

Split: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]


class ConeStep(NamedTuple):
    """A step of every cone.

    Attributes:
        coefficients: what the least-squares problem says about the unknowns, shape (3, m).
        primal, dual: scaled steps, shape (2, n, m): entries a and q.
        b: entry b of the scaled primal step.
        steps: of r and z in the frame, shape (2, side, n, m).
        t: step of t.
        slope, curvature: ``det + 2 slope x + curvature x^2`` is the determinant of the cone after a share x of
            the step, ``t^2 - |r|^2`` or ``1 - |z|^2``; shape (side, n, m).
    """

    coefficients: Floats
    primal: Floats
    dual: Floats
    b: Floats
    steps: Floats
    t: Floats
    slope: Floats
    curvature: Floats


class Cones:
    """The cones at an iterate, scaled: determinants, and the common image of (t, r) and (1, z)."""

    def __init__(self, state: Iterate) -> None:
        self.state, self.gaps = state, state.gaps()
        self.det = state.slacks * (2 * state.sizes + state.slacks)
        roots = np.sqrt(self.det)
        self.root = roots[0] * roots[1]
        self.scaling = nesterov_todd(state, roots, self.gaps)
        self.vectors = self.scaling.in_frame(state.vectors)
        along, across = self.vectors[:, 0]
        forward = np.abs(along)
        bend = np.square(across) / (state.sizes[0] + forward + TINY)
        self.above = state.slacks[0] + bend + (forward - along)  # t - along, without cancellation
        self.point = self.vectors[:, 0] / self.scaling.scale  # entries a and q
        self.point_b = (self.above + self.scaling.tilt * along) / self.scaling.lift
        self.dual = self.vectors[:, 1] * self.scaling.scale

    def scaled_columns(self, maps: Floats) -> Floats:
        """Columns of the map from the unknowns to (a, q) of all cones, shape (3, 2n, m)."""
        n, m = self.above.shape
        first, second = maps.transpose(1, 2, 0)[..., None]  # each (3, n, 1)
        a, q = self.state.weights / self.scaling.scale
        cos, sin = self.scaling.cos, self.scaling.sin
        columns = np.empty((3, 2, n, m))
        columns[:, 0] = first * (a * cos) + second * (a * sin)
        columns[:, 1] = second * (q * cos) - first * (q * sin)
        return columns.reshape(3, 2 * n, m)

    def direction(self, split: Split, goal: Floats, goal_b: Floats) -> ConeStep:
        """Step with scaled primal plus scaled dual equal to the goal, keeping the multipliers balanced.

        The primal step lies in the span of the columns, the dual's new value is orthogonal to them: one
        least-squares problem (``split``) gives both.
        """
        coefficients, remainder = split((goal + self.dual).reshape(-1, goal.shape[-1]))
        dual = remainder.reshape(goal.shape) - self.dual
        primal = goal - dual
        steps = np.empty_like(self.vectors)
        np.multiply(primal, self.scaling.scale, out=steps[:, 0])
        np.divide(dual, self.scaling.scale, out=steps[:, 1])
        along = steps[0, 0]
        rise = goal_b * self.scaling.lift - self.scaling.tilt * along
        t = along + rise
        products = self.vectors * steps
        squares = np.square(steps)
        slope, curvature = -products[0] - products[1], -squares[0] - squares[1]
        slope[0] = self.above * t + self.vectors[0, 0] * rise - products[1, 0]
        curvature[0] = rise * (along + t) - squares[1, 0]
        return ConeStep(coefficients, primal, dual, goal_b, steps, t, slope, curvature)

    def predictor(self, split: Split) -> ConeStep:
        """The step that aims at gap 0."""
        return self.direction(split, -self.point, -self.point_b)

    def corrector(self, split: Split, predictor: ConeStep) -> ConeStep:
        """The step with Mehrotra's centring and second-order correction.

        Its goal is ``x - point`` where ``point o x = centre (1, 0, 0) - primal o dual`` (Jordan products) of the
        predictor's scaled steps.
        """
        sh, ch = self.scaling.sh, self.scaling.ch
        (primal_a, primal_q), (dual_a, dual_q), (a, q) = predictor.primal, predictor.dual, self.point
        primal_t, primal_x = sh * primal_a + ch * predictor.b, ch * primal_a - sh * predictor.b
        dual_t, dual_x = sh * dual_a, ch * dual_a
        goal_t = self._centre(predictor) - primal_a * dual_a - primal_q * dual_q
        goal_x = -primal_t * dual_x - primal_x * dual_t
        goal_q = -primal_t * dual_q - primal_q * dual_t
        t, x = sh * a + ch * self.point_b, ch * a - sh * self.point_b
        x_t = (t * goal_t - x * goal_x - q * goal_q) / self.root
        x_x, x_q = (goal_x - x * x_t) / t, (goal_q - q * x_t) / t
        goal = np.array([sh * x_t + ch * x_x, x_q]) - self.point
        return self.direction(split, goal, ch * x_t - sh * x_x - self.point_b)

    def _centre(self, predictor: ConeStep) -> Floats:
        """Mean gap to aim at: the mean gap after the predictor, times its ratio to the mean gap now."""
        primal, dual = np.minimum(1.0, self.longest_steps(predictor))
        products = self.point * predictor.primal
        share = -(products[0] + products[1] + self.point_b * predictor.b).mean(axis=0)  # of the primal in the fall
        before = self.gaps.mean(axis=0)
        after = before - primal * share - dual * (before - share)
        return np.asarray(np.square(np.clip(after, 0.0, before)) / before)

    def longest_steps(self, step: ConeStep) -> Floats:
        """Largest share of the step that stays in all cones of a problem, shape (side, m)."""
        inverse = np.sqrt(np.maximum(np.square(step.slope) - step.curvature * self.det, 0.0)) - step.slope
        return np.asarray(1 / np.maximum((inverse / self.det).max(axis=1), TINY))

    def advanced(self, step: ConeStep, shares: Floats, y: Floats, r: Floats) -> Iterate:
        """The iterate with new y and r after shares (side, m) of the primal and the dual step."""
        along, across = shares[1] * step.steps[:, 1]
        vectors = self.state.vectors.copy()
        vectors[:, 0] = r
        vectors[0, 1] += self.scaling.cos * along - self.scaling.sin * across
        vectors[1, 1] += self.scaling.sin * along + self.scaling.cos * across
        sizes = norm(vectors)
        share = shares[:, None]
        det = self.det + share * (2 * step.slope + share * step.curvature)
        before = self.state.sizes + self.state.slacks
        before[0] += shares[0] * step.t
        slacks = np.maximum(det, NEAREST_TO_BOUNDARY * self.det) / (before + sizes)
        return Iterate(self.state.number, self.state.weights, y, vectors, sizes, slacks)
