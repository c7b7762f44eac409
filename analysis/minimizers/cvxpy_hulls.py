"""V* over convex hulls by CVXPY: the independent numerical way.

At a point the maximum runs over convex weights of the cells that meet there, on a cell over the polygon's
half-planes.  This is the slow literal definition, with which the tests and the study ``precision`` compare the exact
evaluation; no verdict uses it, and its answers carry the solver's tolerance.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy
from nonsmooth.analysis.minimizers.cvxpy_solvers import ConeSolver, solve_program

TOLERANCE = 1e-8  # Clarabel's own


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
    cell: Cell, solver: ConeSolver = ConeSolver.CLARABEL, tolerance: float = TOLERANCE
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
