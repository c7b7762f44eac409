"""Minimizers of the box functional ``D = sum_i N_i (mu_R |r_i| + mu_S |s_i|)``: a weighted L1 fit.

Its dual is force balance: the friction forces inside their limits that take the most power from the wheels,
``max sum f_k b_k`` subject to ``sum f_k a_k = 0, |f_k| <= mu N``; the minimizing twist is the multiplier of the
balance.  :class:`BoxHighs` solves that linear program, with three equations however many wheels there are, and
:class:`BoxEnumeration` tries every twist that satisfies three independent rows, of which one is always a
minimizer (Theorem 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.minimum import (
    SAME_VALUE,
    SAME_VERTEX,
    Functional,
    Minima,
    balance_forces,
    dissipation,
    distinct,
    rounding_error,
)
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, max_norm

TOGETHER = 40  # points in one linear program: beyond, the time of the simplex method grows faster than their number
HIGHS_FEASIBILITY = 1e-10  # smallest feasibility tolerance of HiGHS, on rows and limits of order 1
REGULAR = 1e-10  # volume of three unit rows below which they count as dependent
ZERO_SLIP = 1e-9  # relative to the largest speed: a smaller slip is rounding of a satisfied row
MAX_WHEELS = 40  # 82,160 triples: about a second and 20 MB for each


@dataclass(frozen=True)
class BoxHighs:
    """The dual linear program, by HiGHS (dual simplex), some points at a time; exact to rounding.

    Attributes:
        tolerance: feasibility tolerance, on rows and limits of order 1.
    """

    functional: ClassVar = Functional.BOX
    tolerance: float = HIGHS_FEASIBILITY

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.minimum.Minimizer`."""
        normal = model.checked_loads(loads)
        scale, speeds = _column_sizes(model), _speeds(model, len(normal))
        targets, limits = model.targets / speeds, model.limits(normal).reshape(len(normal), -1)
        most = limits.max(axis=1, keepdims=True)
        most[most == 0] = 1.0
        shares, multipliers = _most_power((model.rows / scale).T, targets, limits / most, self.tolerance)
        forces = (most * shares).reshape(*normal.shape, 2)
        return Minima.certified(self.functional, model, normal, speeds * multipliers / scale, forces)


def _most_power(rows: Floats, targets: Floats, limits: Floats, tolerance: float) -> tuple[Floats, Floats]:
    """``max targets . f`` subject to ``rows f = 0, |f| <= limits`` at every point.

    Programs that share nothing are solved as one, whose matrix is block diagonal: that spares the solver's start.

    Args:
        rows: (3, k).
        targets: (m, k).
        limits: (m, k).
        tolerance: feasibility tolerance of primal and dual.

    Returns:
        f (m, k) and the multipliers (m, 3) of the equations.
    """
    blocks = range(0, len(limits), TOGETHER)
    solved = [_most_power_of(rows, targets[k : k + TOGETHER], limits[k : k + TOGETHER], tolerance) for k in blocks]
    forces, multipliers = zip(*solved, strict=True)
    return np.concatenate(forces), np.concatenate(multipliers)


def _most_power_of(rows: Floats, targets: Floats, limits: Floats, tolerance: float) -> tuple[Floats, Floats]:
    from scipy.optimize import linprog
    from scipy.sparse import block_diag

    count, bound = len(limits), limits.ravel()
    balances = block_diag([rows] * count, format="csc") if count > 1 else rows
    options = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance}
    result = linprog(
        -targets.ravel(),
        A_eq=balances,
        b_eq=np.zeros(3 * count),
        bounds=np.column_stack([-bound, bound]),
        method="highs-ds",
        options=options,
    )
    if not result.success:
        raise RuntimeError(f"required an optimal linear program, received: {result.message}")
    return np.asarray(result.x).reshape(limits.shape), -np.asarray(result.eqlin.marginals).reshape(count, 3)


def _column_sizes(model: ContactRows) -> Floats:
    """Column scales of the rows, so that the linear program has entries of order 1."""
    columns = np.abs(model.rows).max(axis=0)
    return np.where(columns > 0, columns, 1.0)


def _speeds(model: ContactRows, count: int) -> Floats:
    """The largest speed of the wheels at every point, 1 where all stand still; shape (m, 1)."""
    largest = np.abs(model.targets).max(axis=-1, keepdims=True)
    return np.broadcast_to(np.where(largest > 0, largest, 1.0), (count, 1))


@dataclass(frozen=True)
class BoxEnumeration:
    """Every twist that satisfies three independent loaded rows, as Theorem 1 reads; the oracle of small arrays."""

    functional: ClassVar = Functional.BOX

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.minimum.Minimizer`.

        Raises:
            ValueError: for more than :data:`MAX_WHEELS` wheels, or fewer than three independent loaded rows.
        """
        normal = model.checked_loads(loads)
        if model.wheels > MAX_WHEELS:
            raise ValueError(f"required at most {MAX_WHEELS} wheels to try all triples, received {model.wheels}")
        scale = _column_sizes(model)
        triples, candidates = regular_triples(model.rows / scale, model.targets)
        candidates = candidates / scale
        twists, forces = np.empty((len(normal), 3)), np.empty((*normal.shape, 2))
        faces = {}
        for k, load in enumerate(normal):
            loaded = (model.limits(load).reshape(-1) > 0)[triples].all(axis=1)
            if not loaded.any():
                raise ValueError(f"required three independent loaded rows, received loads {load}")
            best = _best(model, load, candidates[loaded])
            twists[k], forces[k] = best[0], forces_at(model, load, best.mean(axis=0))
            if len(best) > 1:
                faces[k] = best
        forces = balance_forces(self.functional, model, normal, forces)
        return Minima(self.functional, model, normal, twists, forces, faces)


def regular_triples(rows: Floats, targets: Floats) -> tuple[Indices, Floats]:
    """Triples of independent rows (k, 3), and the twists at which these have their targets (k), shape (t, 3) each."""
    triples = np.array(list(combinations(range(len(rows)), 3)))
    matrices = rows[triples]
    sizes = np.linalg.norm(matrices, axis=2).prod(axis=1)
    regular = np.abs(np.linalg.det(matrices)) > REGULAR * sizes
    twists = np.linalg.solve(matrices[regular], targets[triples[regular]][..., None])[..., 0]
    return triples[regular], twists


def _best(model: ContactRows, loads: Floats, candidates: Floats) -> Floats:
    """The distinct candidates that dissipate the least, shape (k, 3)."""
    values = dissipation(Functional.BOX, model, loads, candidates)
    least = int(values.argmin())
    allowed = SAME_VALUE * values[least] + rounding_error(model, loads, candidates)
    best = candidates[values <= values[least] + allowed]
    slips = model.slips(best).reshape(len(best), -1)
    return best[distinct(slips, SAME_VERTEX * max_norm(slips))]


def forces_at(model: ContactRows, loads: Floats, twist: Floats) -> Floats:
    """Balanced forces at a minimizer: minus the limit times the slip's sign, free where a row does not slip."""
    from scipy.optimize import lsq_linear

    limits, slips = model.limits(loads).reshape(-1), model.slips(twist).reshape(-1)
    free = (np.abs(slips) <= ZERO_SLIP * _speeds(model, 1).item()) & (limits > 0)
    forces = np.where(free, 0.0, -limits * np.sign(slips))
    if free.any():  # without unknowns, SciPy 1.13 raises an error
        rows = model.rows / _column_sizes(model)
        bounds = (-limits[free], limits[free])
        forces[free] = lsq_linear(rows[free].T, -rows.T @ forces, bounds, method="bvls").x
    return forces.reshape(-1, 2)
