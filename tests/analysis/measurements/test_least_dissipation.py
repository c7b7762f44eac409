"""The least dissipation at 100 digits: a golden value, certified minima, and scales."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.measurements.references.least_dissipation import ReferenceMinimization
from nonsmooth.analysis.minimizers.choice import Minimizer
from nonsmooth.analysis.minimizers.dissipation import Functional
from tests.oracles.cvxpy_programs import MINIMIZERS

SOLVERS = 1e-7  # relative gap of the reference solvers
EXACT = 1e-12  # of the others


def test_two_isotropic_wheels() -> None:
    """D* = 0.98387 for the circle functional: the paper's example of two wheels."""
    model = ContactModel.build([(0, 0), (2, 1)], [(1, 0), (1, 0)], [(1, 0.3), (-0.2, 0.5)], (1, 1))
    least = ReferenceMinimization(Functional.ELLIPSE, model, np.array([1.0, 2.0])).least()
    assert float(least.mid()) == pytest.approx(0.98387, abs=5e-6)


@pytest.mark.parametrize("minimizer", MINIMIZERS, ids=lambda m: f"{type(m).__name__}-{m.functional}")
@pytest.mark.parametrize("seed", range(3))
def test_every_minimizer_reaches_it_and_none_falls_below(minimizer: Minimizer, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = ContactModel.build(
        rng.normal(size=(5, 2)), rng.normal(size=(5, 2)), rng.normal(size=5), rng.uniform(0.1, 2, (5, 2))
    )
    loads = rng.uniform(0.1, 1, 5)
    problem = ReferenceMinimization(minimizer.functional, model, loads)
    least = problem.least()
    excess = float(((problem.at(minimizer.minimize(model, loads[None]).twists[0]) - least) / least).mid())
    assert -1e-24 <= excess <= (SOLVERS if "Cvxpy" in type(minimizer).__name__ else EXACT)


@pytest.mark.parametrize("functional", list(Functional))
def test_a_slip_that_vanishes_adds_nothing(functional: Functional) -> None:
    """The body turns about the origin, and the first wheel with it: its slip is a ball about zero."""
    model = ContactModel.build([(0.5, 0), (0.7, 0)], [(0, 1), (0, 1)], (-1.5, 0), (1, 1))
    dissipation = ReferenceMinimization(functional, model, np.ones(2)).at(np.array([0.0, 0.0, -3.0]))
    assert float(dissipation.mid()) == pytest.approx(2.1, abs=1e-14)
