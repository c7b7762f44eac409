"""``min_y sum_i |B_i y - b_i|`` with three unknowns y and n vectors in the plane, for many problems at once.

As a second-order cone program: ``min sum t_i`` subject to ``|r_i| <= t_i``, ``r_i = B_i y - b_i``; its dual is
``max sum b_i . z_i`` subject to ``sum B_i^T z_i = 0``, ``|z_i| <= 1`` (z is the friction force in units of its
limit). A primal-dual interior point method with Nesterov-Todd scaling and Mehrotra's corrector finds both, whatever
the weights; norms that vanish at the optimum (wheels that stick) need no special care. As soon as its gap is small,
Newton's method is tried on the norms that it tells apart (:mod:`nonsmooth.analysis.minimizers.newton_polish`): most
problems end there, after three or four steps, solved to rounding; the others go on to a relative gap of 1e-12 in 10
to 20 steps.

All problems of a block advance together: the last axis of every array numbers the m problems. Three things keep
twelve digits where textbook formulas lose half of them:

- the slacks ``t_i - |r_i|`` and ``1 - |z_i|`` are variables of their own, never differences;
- gaps and step lengths are sums of products without cancellation (:mod:`nonsmooth.analysis.minimizers.norm_cones`);
- the three unknowns come from Gram-Schmidt with reorthogonalization, never from normal equations: a sticking wheel
  weighs 1e10 times more than the others.

Both iterates stay feasible, so the gap bounds the error at every step. The method fails only where doubles do: then
the gap stops falling, the best iterate is kept, and the caller sees its gap.

References: Andersen, Roos, Terlaky (2003), Math. Program. 95; Alizadeh, Goldfarb (2003), Math. Program. 95.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.newton_polish import polish
from nonsmooth.analysis.minimizers.norm_cones import Cones
from nonsmooth.analysis.minimizers.norm_scaling import TINY, Iterate, norm, residuals

RELATIVE_GAP = 1e-12  # duality gap over optimal value at which a problem is solved
MAX_STEPS = 60  # random problems need at most 30
STRAY = 100.0  # a gap that rises this far above the best one is rounding: the problem is as solved as doubles can
FIRST_POLISH = 1e-2  # gap over starting value at which Newton's method is tried for the first time
NEXT_POLISH = 1e-2  # share of the present gap at which it is tried again
TO_BOUNDARY = 0.98  # share of the step to the boundary of the cones that is taken
CACHED = 16384  # norms handled together: their arrays fit the processor's cache
SMALLEST_BLOCK = 256  # problems handled together at least: fewer would pay more for Python than for floats
COMPACT = 0.8  # unsolved share of a block at which the solved problems are taken out
DEPENDENT = 1e-14  # relative length at which Gram-Schmidt's remainder is rounding of a dependent column
EPSILON = float(np.finfo(float).eps)


def minimize_norms(weights: Floats, maps: Floats, targets: Floats) -> tuple[Floats, Floats]:
    """Solve ``min_y sum_i w_i |E_i y - e_i|`` for each row of weights.

    Args:
        weights: ``w``, shape (m, n), at least 0.
        maps: ``E_i``, shape (n, 2, 3), columns of comparable size.
        targets: ``e_i`` of order 1, shape (n, 2), or (m, n, 2) where every problem has its own.

    Returns:
        Minimizers y, shape (m, 3), and multipliers z, shape (m, n, 2), with ``|z_i| <= 1`` and
        ``sum_i w_i E_i^T z_i = 0``.
    """
    return solve_blocks(lambda w, e: ProblemBatch(w, maps, e), weights, targets)


def solve_blocks(
    build: Callable[[Floats, Floats], ProblemBatch], weights: Floats, targets: Floats
) -> tuple[Floats, Floats]:
    """Unknowns (m, k) and multipliers (m, n, 2) of all problems, block by block."""
    size = max(SMALLEST_BLOCK, CACHED // weights.shape[1])
    blocks = [slice(first, first + size) for first in range(0, max(len(weights), 1), size)]
    own = targets.ndim == 3
    with np.errstate(all="ignore"):  # a problem at the limit of doubles may divide by 0; that step is not kept
        solved = [build(weights[b], targets[b] if own else targets[None]).solve() for b in blocks]
    return np.concatenate([y.T for y, _ in solved]), np.concatenate([z.transpose(2, 1, 0) for _, z in solved])


class ProblemBatch:
    """Problems that advance together, and the best solution of each so far."""

    def __init__(self, weights: Floats, maps: Floats, targets: Floats) -> None:
        m, n = weights.shape
        self.maps = maps
        self.targets = np.ascontiguousarray(targets.transpose(2, 1, 0))  # (2, n, m), or (2, n, 1) for all
        columns = np.ascontiguousarray(weights.T)
        r = -columns * self.targets
        self.start = norm(r).sum(axis=0)  # values at y = 0
        self.gap, self.polish_below = np.full(m, np.inf), FIRST_POLISH * self.start
        self.y, self.z = np.zeros((3, m)), np.zeros((2, n, m))
        # y = 0 and z = 0 are strictly feasible and not far from central
        slacks = np.stack([np.broadcast_to(self.start / n + TINY, (n, m)), np.ones((n, m))])
        vectors = np.stack([r, np.zeros_like(r)], axis=1)
        self.state = Iterate(np.arange(m), columns, np.zeros((3, m)), vectors, norm(vectors), slacks)

    def solve(self) -> tuple[Floats, Floats]:
        """Unknowns (3, m) and multipliers (2, n, m)."""
        for _ in range(MAX_STEPS):
            cones = Cones(self.state)
            waiting = self._keep(cones.gaps.sum(axis=0))
            unsolved = np.count_nonzero(waiting)
            if not unsolved:
                break
            if unsolved < COMPACT * len(waiting):
                self.state = self.state.take(waiting)
                cones = Cones(self.state)
            self.state = self._step(cones)
        return self.y, self.z

    def _step(self, cones: Cones) -> Iterate:
        """One predictor-corrector step of every problem."""
        fit = self._fit(cones)
        step = cones.corrector(fit.split, cones.predictor(fit.split))
        shares = np.minimum(1.0, TO_BOUNDARY * cones.longest_steps(step))
        y = cones.state.y + shares[0] * fit.solution(step.coefficients)
        return cones.advanced(step, shares, y, self._residuals(cones.state, y))

    def _fit(self, cones: Cones) -> Fit:
        """The least-squares problem of a step."""
        return LeastSquares(cones.scaled_columns(self.maps))

    def _residuals(self, state: Iterate, y: Floats) -> Floats:
        """``w_i (E_i y - e_i)``."""
        return residuals(state.weights, y, self.maps, self._targets_of(state.number))

    def _targets_of(self, index: NDArray[np.int_]) -> Floats:
        return self.targets if self.targets.shape[-1] == 1 else self.targets[..., index]

    def _keep(self, gap: Floats) -> NDArray[np.bool_]:
        """Keep iterates that lower their problem's gap, polish those that are due; which problems go on?"""
        state = self.state
        better = gap < self.gap[state.number]
        index = state.number[better]
        self.gap[index], self.y[:, index], self.z[..., index] = gap[better], state.y[:, better], state.z[..., better]
        rounding = EPSILON * self.start[state.number] + 2 * len(self.maps) * TINY
        waiting = (gap > RELATIVE_GAP * state.sizes[0].sum(axis=0) + rounding) & (gap < STRAY * self.gap[state.number])
        return waiting & ~self._polish(better & ((gap < self.polish_below[state.number]) | ~waiting))

    def _polish(self, due: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Try Newton's method on the problems that are due; which did it solve?"""
        solved = np.zeros_like(due)
        if due.any():
            index = self.state.number[due]
            y, z, accepted = self._finish(self.state.weights[:, due], index)
            solved[due] = accepted
            self.polish_below[index] = NEXT_POLISH * self.gap[index]
            index = index[accepted]
            self.gap[index], self.y[:, index], self.z[..., index] = 0.0, y[:, accepted], z[..., accepted]
        return solved

    def _finish(self, weights: Floats, index: NDArray[np.int_]) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Newton's method on some problems: unknowns, multipliers, and whether they are accepted."""
        return polish(weights, self.maps, self._targets_of(index), self.y[:, index], self.z[..., index])


class Fit(Protocol):
    """A least-squares problem for m steps."""

    def split(self, vector: Floats) -> tuple[Floats, Floats]:
        """Coefficients on the columns, and the remainder orthogonal to them (in place)."""

    def solution(self, coefficients: Floats) -> Floats:
        """The unknowns."""


class LeastSquares:
    """Gram-Schmidt factors of m matrices with three columns, shape (3, k, m), in two passes."""

    def __init__(self, columns: Floats) -> None:
        sizes = np.einsum("jkm,jkm->jm", columns, columns)
        self.columns = columns
        self.scales = [_inverse(sizes[0], sizes[0])]
        self.first = self._remove(0, columns[1:]) + self._remove(0, columns[1:])
        self.scales.append(_inverse(_inner(columns[1], columns[1]), sizes[1]))
        self.second = self._remove(1, columns[2])
        self.first[1] += self._remove(0, columns[2])
        self.second += self._remove(1, columns[2])
        self.scales.append(_inverse(_inner(columns[2], columns[2]), sizes[2]))

    def _remove(self, index: int, vectors: Floats) -> Floats:
        """Subtract from vectors (..., k, m), in place, their projections on a column; returns the coefficients."""
        column = self.columns[index]
        coefficients = _inner(column, vectors) * self.scales[index]
        vectors -= coefficients[..., None, :] * column
        return coefficients

    def split(self, vector: Floats) -> tuple[Floats, Floats]:
        """Coefficients on the orthogonal columns, and the remainder orthogonal to them (in place)."""
        coefficients = [self._remove(index, vector) for index in range(3)]
        return np.array(coefficients), vector

    def solution(self, coefficients: Floats) -> Floats:
        """The unknowns, shape (3, m), by back substitution."""
        x, y, z = coefficients
        y = y - self.second * z
        return np.array([x - self.first[0] * y - self.first[1] * z, y, z])


def _inner(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("km,...km->...m", a, b))


def _inverse(square: Floats, original: Floats) -> Floats:
    """``1/square``, or 0 where only rounding is left of a dependent column."""
    return np.where(square > DEPENDENT**2 * original, 1 / square, 0.0)
