"""Linear programs in floats: they propose, and exact arithmetic decides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

METHODS = ("highs", "highs-ipm")  # simplex steps, which may go round in circles where many rows meet; interior points
MOST_STEPS = 10_000  # of each
TOO_MANY = 1  # status


def solve_program(costs: Any, **stated: Any) -> OptimizeResult:
    """The result of :func:`scipy.optimize.linprog`, without a solution where none is found in so many steps.

    Args:
        costs: c of ``min c . x``.
        stated: constraints and bounds, as there.
    """
    from scipy.optimize import linprog

    for method in METHODS:
        found = linprog(costs, method=method, options={"maxiter": MOST_STEPS}, **stated)
        if found.status != TOO_MANY:
            break
    return found
