"""Minimizers of both functionals stated to CVXPY as they stand: the independent references.

``min sum_i N_i |(mu_R r_i, mu_S s_i)|`` over twists and slips, linked by ``slips = rows . twist - targets``; the
link's multipliers are the friction forces.  The norm is the sum of absolute values (box: a linear program) or the
length (ellipse: a second-order cone program; where ellipses are cut, with the speeds t of rollers,
``|(x, y - t)| + kappa |t|``), solved point by point: hundreds of times slower than the program's own
solvers, and less exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats
from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy
from nonsmooth.analysis.minimizers.cvxpy_solvers import ConeSolver, solve_program
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.minimum import Minima

TOLERANCE = 1e-12  # or as near as the solver gets; the gap that counts is computed from twist and forces afterwards


@dataclass(frozen=True)
class CvxpyMinimizer:
    """Either functional by CVXPY.

    Attributes:
        functional: box or ellipse.
        compiled: state the program once, with the loads as parameters; if not, afresh at every point, as in plain
            use of CVXPY.
        solver: the solver behind CVXPY; OSQP for the box only.
        tolerance: what the solver is asked for.
    """

    functional: Functional
    compiled: bool = True
    solver: ConeSolver = ConeSolver.CLARABEL
    tolerance: float = TOLERANCE

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """See :class:`nonsmooth.analysis.minimizers.choice.Minimizer`."""
        normal = model.checked_loads(loads)
        twists, multipliers = np.empty((len(normal), 3)), np.empty((*normal.shape, 2))
        program = _Program(self.functional, model) if self.compiled else None
        for k, load in enumerate(normal):
            stated = program or _Program(self.functional, model)
            twists[k], multipliers[k] = stated.solve(load, self.solver, self.tolerance)
        return Minima.certified(self.functional, model, normal, twists, multipliers)


class _Program:
    """``min N . t`` subject to ``|weighted slips of wheel i| <= t_i``."""

    def __init__(self, functional: Functional, model: ContactRows) -> None:
        load_cvxpy()
        import cvxpy as cp

        self.friction = model.friction.reshape(-1, 2)
        self.twist, self.slips = cp.Variable(3), cp.Variable(self.friction.shape)
        self.loads = cp.Parameter(model.wheels, nonneg=True)
        slips = self.slips.flatten(order="C")
        self.link = slips == model.friction[:, None] * model.rows @ self.twist - model.friction * model.targets
        if functional is Functional.BOX:
            parts = cp.Variable(self.friction.shape)
            sizes, cones = parts @ np.ones(2), [self.slips <= parts, -parts <= self.slips]
        elif (model.cuts == 1).all():
            sizes = cp.Variable(model.wheels)
            cones = [cp.SOC(sizes, self.slips, axis=1)]
        else:
            contact, bearing = cp.Variable(model.wheels), cp.Variable(model.wheels)
            turning = cp.Variable(self.friction.shape)  # of rollers: across the rims only
            cones = [cp.SOC(contact, self.slips - turning, axis=1), turning[:, 0] == 0]
            cones += [turning[:, 1] <= bearing, -turning[:, 1] <= bearing]
            sizes = contact + np.diag(model.cuts) @ bearing
        self.problem = cp.Problem(cp.Minimize(self.loads @ sizes), [self.link, *cones])

    def solve(self, loads: Floats, solver: ConeSolver, tolerance: float) -> tuple[Floats, Floats]:
        """Twist (3,) and friction forces (n, 2)."""
        self.loads.value = loads
        solve_program(self.problem, solver, tolerance)
        return np.asarray(self.twist.value), np.asarray(self.link.dual_value).reshape(-1, 2) * self.friction
