"""The least dissipation at 100 digits: a golden value, certified minima, and scales."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.measurements.cases import RATIOS
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.choice import Minimizer
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import GAP
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from tests.oracles.cvxpy_programs import MINIMIZERS
from tests.oracles.least_dissipation import ReferenceMinimization
from tests.thorough import keep

SOLVERS = 1e-7  # relative gap of the reference solvers
EXACT = 1e-12  # of the others
MOST_RATIO = 1e6  # of frictions: beyond it forces may be so large that their rounding outweighs the gap


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


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-5", "off-center"]))
def test_certificates_at_extreme_friction_are_right(name: str) -> None:
    """What the forces certify is the least dissipation, where they outweigh rounding and where they do not."""
    scene = load_scene(name)
    point = [[float(c) + 0.3 * float(scene.check.radius) for c in scene.check.equilibrium]]
    for ratio in RATIOS.values():
        model = contact_model(with_friction_ratio(scene, ratio))
        loads = loads_at(model, point)
        for minimizer in (BoxHighs(), EllipseMinimizer()):
            minima = minimizer.minimize(model, loads)
            problem = ReferenceMinimization(minimizer.functional, model, loads[0])
            error = abs(float(((problem.at(minima.twists[0]) - problem.least()) / problem.at(np.zeros(3))).mid()))
            assert error <= GAP or not minima.check()[0]
            assert minima.check()[0] or max(ratio, 1 / ratio) > MOST_RATIO


@pytest.mark.parametrize("functional", list(Functional))
def test_a_slip_that_vanishes_adds_nothing(functional: Functional) -> None:
    """The body turns about the origin, and the first wheel with it: its slip is a ball about zero."""
    model = ContactModel.build([(0.5, 0), (0.7, 0)], [(0, 1), (0, 1)], (-1.5, 0), (1, 1))
    dissipation = ReferenceMinimization(functional, model, np.ones(2)).at(np.array([0.0, 0.0, -3.0]))
    assert float(dissipation.mid()) == pytest.approx(2.1, abs=1e-14)
