"""The program's own minimizers against CVXPY, per point, in one run and to at least its accuracy."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minimizer
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.benchmarks.conftest import Stopwatch
from tests.oracles.cvxpy_programs import CvxpyMinimizer

REQUIRED_SPEEDUP = 300  # ellipse, four wheels, over CVXPY as one writes it down
POINTS = 4000  # for the vectorized minimizer
FEW = 40  # for those that go point by point
ROUNDS = 5  # runs alternate, so that a busy moment of the machine meets all


def loads_of(model: ContactModel, count: int) -> Floats:
    """At random centres of mass about the middle of the array."""
    rng = np.random.default_rng(0)
    return loads_at(model, model.positions.mean(axis=0) + rng.uniform(-0.3, 0.3, (count, 2)))


def times_per_point(
    model: ContactModel, entrants: dict[str, tuple[Minimizer, int]], stopwatch: Stopwatch
) -> dict[str, float]:
    best = dict.fromkeys(entrants, float("inf"))
    for _ in range(ROUNDS):
        for name, (minimizer, count) in entrants.items():
            loads = loads_of(model, count)
            seconds = stopwatch.best(lambda m=minimizer, w=loads: m.minimize(model, w), runs=1)  # type: ignore[misc]
            best[name] = min(best[name], seconds / count)
    return best


@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "ring-8", "grid-4x4"])
def test_ellipse(name: str, stopwatch: Stopwatch) -> None:
    model = contact_model(load_scene(name))
    interior = EllipseMinimizer()
    plain, compiled = (CvxpyMinimizer(Functional.ELLIPSE, compiled=c) for c in (False, True))
    minima, reference = (m.minimize(model, loads_of(model, FEW)) for m in (interior, compiled))
    assert minima.check(1e-10).all()
    assert (minima.values <= reference.values * (1 + 1e-9)).all()
    entrants: dict[str, tuple[Minimizer, int]] = {
        "interior": (interior, POINTS),
        "plain": (plain, FEW),
        "compiled": (compiled, FEW),
    }
    seconds = times_per_point(model, entrants, stopwatch)
    ratios = {name: seconds[name] / seconds["interior"] for name in ("plain", "compiled")}
    stopwatch.report(
        f"ellipse, {name}: {1e6 * seconds['interior']:.1f} us per point; CVXPY {1e3 * seconds['plain']:.2f} ms, "
        f"{ratios['plain']:.0f} times as long; stated once with parameters {1e3 * seconds['compiled']:.2f} ms, "
        f"{ratios['compiled']:.0f} times"
    )
    if name == "four-wheel":
        assert ratios["plain"] >= REQUIRED_SPEEDUP


def test_box(stopwatch: Stopwatch) -> None:
    model = contact_model(load_scene("four-wheel"))
    highs, plain, compiled = BoxHighs(), *(CvxpyMinimizer(Functional.BOX, compiled=c) for c in (False, True))
    assert highs.minimize(model, loads_of(model, FEW)).check(1e-10).all()
    entrants: dict[str, tuple[Minimizer, int]] = {
        "HiGHS": (highs, FEW),
        "plain": (plain, FEW),
        "compiled": (compiled, FEW),
    }
    seconds = times_per_point(model, entrants, stopwatch)
    stopwatch.report(
        f"box, four-wheel: HiGHS {1e3 * seconds['HiGHS']:.2f} ms per point; CVXPY {1e3 * seconds['plain']:.2f} ms, "
        f"stated once with parameters {1e3 * seconds['compiled']:.2f} ms"
    )
