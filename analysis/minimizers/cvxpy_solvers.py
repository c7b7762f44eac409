"""The solvers behind CVXPY, each asked for one tolerance.

Every solver names its tolerances differently and means something else by them: Clarabel (interior point) the duality
gap and the residuals, SCS and OSQP (operator splitting) the residuals only.  The tolerance bounds what the solver
measures, never the error of the answer.  On second-order cones solvers often end a digit short and say so; the answer
is kept, and whoever asks for it computes its error.
"""

from __future__ import annotations

import warnings
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.minimizers.cvxpy_import import load_cvxpy

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


def import_solvers() -> None:
    """Import CVXPY now, so that no measured time includes it."""
    load_cvxpy()


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
