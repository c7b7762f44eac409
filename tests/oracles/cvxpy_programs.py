"""Both functionals and V* over hulls, stated to CVXPY as they stand: the independent references.

``min sum_i N_i |(mu_R r_i, mu_S s_i)|`` over twists and slips, linked by ``slips = rows . twist - targets``; the
link's multipliers are the friction forces.  The norm is the sum of absolute values (box: a linear program) or the
length (ellipse: a second-order cone program; where ellipses are cut, with the speeds t of rollers,
``|(x, y - t)| + kappa |t|``), solved point by point: hundreds of times slower than the program's own solvers, and less
exact.  V* at a point is a maximum over convex weights of the cells that meet there, on a cell over the polygon's
half-planes.

Every solver names its tolerances differently and means something else by them: Clarabel (interior point) the duality
gap and the residuals, SCS and OSQP (operator splitting) the residuals only.  The tolerance bounds what the solver
measures, never the error of the answer.  On second-order cones solvers often end a digit short and say so; the answer
is kept, and whoever asks for it computes its error.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.box_minimizers import BoxEnumeration, BoxHighs
from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.minimum import Functional, Minima, Minimizer
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    import cvxpy as cp

MOST_STEPS = 200_000  # of a splitting method: some seconds for the small programs here


class ConeSolver(StrEnum):
    """A solver by the name that CVXPY gives it."""

    CLARABEL = "CLARABEL"
    SCS = "SCS"
    OSQP = "OSQP"  # no second-order cones

    @property
    def label(self) -> str:
        """The name as its makers write it."""
        return "Clarabel" if self is ConeSolver.CLARABEL else self.value


def solver_options(solver: ConeSolver, tolerance: float) -> dict[str, Any]:
    """The options that ask a solver for a tolerance."""
    match solver:
        case ConeSolver.CLARABEL:
            return {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}
        case ConeSolver.SCS:
            return {"eps_abs": tolerance, "eps_rel": tolerance, "max_iters": MOST_STEPS}
        case ConeSolver.OSQP:
            # Polishing would print on standard output, past any redirection, and hide what the tolerance does.
            return {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": MOST_STEPS, "polishing": False}


def solve_program(problem: cp.Problem, solver: ConeSolver, tolerance: float) -> float:
    """Solve a program as exactly as asked, or as nearly as the solver gets; the value.

    Raises:
        RuntimeError: where the solver gives up.
    """
    load_cvxpy()
    import cvxpy as cp

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
        try:
            value = problem.solve(solver=str(solver), **solver_options(solver, tolerance))
        except cp.SolverError as error:
            raise RuntimeError(f"{solver} gave up at tolerance {tolerance:g}: {error}") from None
    if problem.status not in cp.settings.SOLUTION_PRESENT:
        raise RuntimeError(f"required a solution, received the status {problem.status!r} from {solver}")
    return float(value)


# ---- minimizers of the dissipation ---------------------------------------------------------------

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
        """See :class:`nonsmooth.analysis.minimizers.minimum.Minimizer`."""
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


MINIMIZERS: tuple[Minimizer, ...] = (
    EllipseMinimizer(),
    BoxHighs(),
    BoxEnumeration(),
    CvxpyMinimizer(Functional.ELLIPSE),
    CvxpyMinimizer(Functional.BOX),
)
"""The program's own, then the references."""


def minimizers_of(functional: Functional) -> tuple[Minimizer, ...]:
    """Those of one functional, the one to use first and the reference last."""
    return tuple(minimizer for minimizer in MINIMIZERS if minimizer.functional is functional)


# ---- the upper derivative over hulls ------------------------------------------------------------

HULL_TOLERANCE = 1e-8  # Clarabel's own


def hull_upper_derivative_at(partition: Partition, point: Point) -> float:
    """``max sum_k lambda_k 2 c . v_k`` over ``lambda >= 0, sum lambda = 1``."""
    load_cvxpy()
    import cvxpy as cp

    c = np.array([float(x) for x in point])
    velocities = np.array([[float(t.vx), float(t.vy)] for t in filippov_twists(partition, point)])
    weights = cp.Variable(len(velocities), nonneg=True)
    total = np.ones(len(velocities)) @ weights
    problem = cp.Problem(cp.Maximize(2 * (velocities @ c) @ weights), [total == 1])
    return float(problem.solve(solver=cp.CLARABEL))


def hull_upper_derivative_on(
    cell: Cell, solver: ConeSolver = ConeSolver.CLARABEL, tolerance: float = HULL_TOLERANCE
) -> float:
    """``max 2 c . v`` over the closed cell, given by its half-planes.

    Raises:
        RuntimeError: where the solver gives up.
    """
    load_cvxpy()
    import cvxpy as cp

    c = cp.Variable(2)
    normals = np.array([[float(x) for x in side.normal] for side in cell.polygon.sides])
    offsets = np.array([float(side.offset) for side in cell.polygon.sides])
    best = -np.inf
    for twist in cell.twists:
        velocity = np.array([float(twist.vx), float(twist.vy)])
        problem = cp.Problem(cp.Maximize(2 * velocity @ c), [offsets - normals @ c >= 0])
        best = max(best, solve_program(problem, solver, tolerance))
    return best
