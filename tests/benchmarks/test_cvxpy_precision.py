"""CVXPY's solvers at their tolerances against exact answers, or answers to 60 digits, beside the program's own.

A tolerance bounds the duality gap (Clarabel) or the residuals (SCS, OSQP), never the error of a twist.  The gap grows
linearly with the distance from a minimizer where D has a vertex (box), with its square where D is smooth (ellipse), so
that slope 1/2 is all that a tolerance buys there.  V* over hulls errs by the gap itself.
"""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.measurements.harness import log_slope
from nonsmooth.analysis.measurements.studies import box_references, ellipse_references, largest_derivative
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minimizer
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch
from tests.oracles.cvxpy_programs import ConeSolver, CvxpyMinimizer, hull_upper_derivative_on

TOLERANCES = tuple(10.0**-k for k in (2, 4, 6, 8, 10))
WITHIN = 0.2  # of the predicted slope
MOST_TOLERANCES = 1_000  # the error of a solver in units of its tolerance: the condition of the problem, with room
ROUNDING = 1e-14  # of the program's own minimizers


def twist_error(minimizer: Minimizer, stopwatch: Stopwatch) -> float:
    """The largest error over the reference points of four wheels, with its time on the side."""
    box = minimizer.functional is Functional.BOX
    scene = load_scene("four-wheel", rule="box" if box else "ellipse")
    references = box_references(build_box_partition(scene)) if box else ellipse_references(scene)
    model = contact_model(scene)
    loads = loads_at(model, np.array([reference.point for reference in references]))
    twists = minimizer.minimize(model, loads).twists
    error = max(reference.error(twist) for reference, twist in zip(references, twists, strict=True))
    seconds = stopwatch.best(lambda: minimizer.minimize(model, loads), runs=1)
    stopwatch.report(f"{minimizer.functional}, {minimizer}: error {error:.1e} in {1e3 * seconds:.1f} ms")
    return error


@pytest.mark.parametrize("minimizer", [BoxHighs(), EllipseMinimizer()], ids=lambda m: str(m.functional))
def test_the_programs_own_reach_rounding(minimizer: Minimizer, stopwatch: Stopwatch) -> None:
    assert twist_error(minimizer, stopwatch) < ROUNDING


@pytest.mark.parametrize("solver", list(ConeSolver))
def test_solvers_on_the_box_err_by_their_tolerance(solver: ConeSolver, stopwatch: Stopwatch) -> None:
    entrants = [CvxpyMinimizer(Functional.BOX, solver=solver, tolerance=tolerance) for tolerance in TOLERANCES]
    errors = [twist_error(minimizer, stopwatch) for minimizer in entrants]
    assert all(error < MOST_TOLERANCES * tolerance for tolerance, error in zip(TOLERANCES, errors, strict=True))
    # SCS looks at its residuals every 25 steps and may stop two orders below the tolerance, on each machine elsewhere.
    assert 1 - WITHIN < log_slope(TOLERANCES, errors) < (1.5 if solver is ConeSolver.SCS else 1 + WITHIN)


def test_a_gap_bounds_the_square_of_the_error_where_d_is_smooth(stopwatch: Stopwatch) -> None:
    errors = [twist_error(CvxpyMinimizer(Functional.ELLIPSE, tolerance=t), stopwatch) for t in TOLERANCES]
    assert log_slope(TOLERANCES, errors) == pytest.approx(0.5, abs=WITHIN)


def test_the_upper_derivative_over_hulls_errs_by_the_gap() -> None:
    partition = build_partition(load_scene("four-wheel").recentred())
    exact = float(largest_derivative(partition))
    errors = [
        abs(max(hull_upper_derivative_on(cell, tolerance=t) for cell in partition.cells) - exact) for t in TOLERANCES
    ]
    assert log_slope(TOLERANCES, errors) == pytest.approx(1, abs=WITHIN)


@pytest.mark.parametrize("solver", list(ConeSolver))
def test_solvers_print_nothing(solver: ConeSolver, capfd: pytest.CaptureFixture[str]) -> None:
    """Not even past Python's own streams, where a solver may complain most, and elsewhere."""
    for tolerance in TOLERANCES:
        for cell in build_partition(load_scene("conveyor-3").recentred()).cells:
            hull_upper_derivative_on(cell, solver, tolerance)
    assert capfd.readouterr() == ("", "")
