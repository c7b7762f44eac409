"""Newton's method beside contacts that stick, against the method of multipliers; slopes of regimes as differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.analysis.bodies.set_motion import DraggedMinimizer, with_drag
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.smooth_newton import CutNewton, SmoothNewton, smallest_forces
from tests.thorough import few, keep

SAME = 1e-9  # of twists of order one
DRAGGED = 1e-7  # the same, where drag alone says which of many that are nearly as good: its slopes are a millionth
STEP, SLOPE_ERROR = 1e-5, 1e-6  # of the way from loads to loads; relative


def model_of(seed: int, alike: int) -> ContactModel:
    """Seven wheels; some of them run alike, so that contacts stick, two at once where they lie on a line."""
    rng = np.random.default_rng(seed)
    places, angles, speeds = rng.uniform(-1, 1, (7, 2)), rng.uniform(-1, 1, 7), rng.uniform(0.5, 1, 7)
    places[:alike] = np.linspace(-0.5, 0.5, alike)[:, None] * [1.0, 0.3]
    angles[:alike], speeds[:alike] = 0.1, 0.8
    rims = np.column_stack([np.cos(angles), np.sin(angles)])
    return ContactModel.build(places, rims, speeds, (1.0, 0.5))


@few(1)
@pytest.mark.parametrize("models", keep(1, [2, 8]))
@pytest.mark.parametrize("alike", [2, 0, 1, 3])
def test_twists_are_those_of_the_method_of_multipliers(alike: int, models: int) -> None:
    found = stuck = 0
    for seed in range(models):
        model, rng = model_of(seed, alike), np.random.default_rng(seed + 100)
        ends = rng.dirichlet(np.ones(7), 2)
        newton = SmoothNewton(model)
        newton.start_from(EllipseMinimizer().minimize(model, ends[:1]).twists[0])
        for share in np.linspace(0, 1, 21):
            loads = (1 - share) * ends[0] + share * ends[1]
            (expected,) = EllipseMinimizer().minimize(model, loads[None]).twists
            twist = newton.minimize(loads)
            if twist is None:
                newton.start_from(expected)
                continue
            found += 1
            stuck += int(newton.last is not None and newton.last[0].sticks.any())
            assert np.abs(twist - expected).max() < SAME
    assert found > 15 * models
    assert stuck > 2.5 * models


@pytest.mark.parametrize("rollers", keep(1, [5, 2, 7]))
def test_twists_beside_strips_are_those_of_the_method_of_multipliers(rollers: int) -> None:
    found = rolls = 0
    for seed in range(4):
        rng = np.random.default_rng([seed, rollers])
        plain = model_of(seed, 0)
        friction = np.where(np.arange(7)[:, None] < rollers, [1.0, 1.0], [1.0, 0.5]).ravel()
        cuts = np.where(np.arange(7) < rollers, 0.1, 1.0)
        model = DraggedMinimizer(replace(plain, friction=friction, cuts=cuts)).dragged
        newton, ends = CutNewton(model), rng.dirichlet(np.ones(7), 2)
        newton.start_from(EllipseMinimizer().minimize(model, with_drag(ends[0])[None]).twists[0])
        for share in np.linspace(0, 1, 21):
            loads = with_drag((1 - share) * ends[0] + share * ends[1])
            (expected,) = EllipseMinimizer().minimize(model, loads[None]).twists
            twist = newton.minimize(loads)
            if twist is None:
                newton.start_from(expected)
                continue
            found += 1
            rolls += int((np.abs(model.slips(twist)[:rollers, 0]) < SAME).any())
            assert np.abs(twist - expected).max() < DRAGGED
    assert found > 60
    assert rolls > 20


@pytest.mark.parametrize("alike", [0, 2])
def test_slopes_are_differences(alike: int) -> None:
    compared = 0
    for seed in range(8):
        model, rng = model_of(seed, alike), np.random.default_rng(seed + 200)
        loads, others = rng.dirichlet(np.ones(7), 2)
        newton = SmoothNewton(model)
        newton.start_from(EllipseMinimizer().minimize(model, loads[None]).twists[0])
        if newton.minimize(loads) is None or newton.last is None:
            continue
        regime, unknowns = newton.last
        change = others - loads
        ends = [newton.settled(regime, unknowns, loads + sign * STEP * change) for sign in (1, -1)]
        if ends[0] is None or ends[1] is None:
            continue
        slope = newton.slope(regime, unknowns, loads, change)
        difference = (ends[0] - ends[1])[:3] / (2 * STEP)
        assert np.abs(slope[:3] - difference).max() < SLOPE_ERROR * max(1.0, np.abs(slope[:3]).max())
        compared += 1
    assert compared >= 5


@pytest.mark.parametrize("count", [2, 3, 4])
def test_no_other_forces_have_a_smaller_largest_one(count: int) -> None:
    rng = np.random.default_rng(count)
    for _ in range(10):
        line = np.linspace(0, 1, count)[:, None] * [0.6, 0.8]
        maps = np.array([[[1, 0, -y], [0, 1, x]] for x, y in line])
        forces = rng.normal(size=(count, 2))
        best = smallest_forces(maps, forces)
        assert np.einsum("kij,ki->j", maps, best) == pytest.approx(np.einsum("kij,ki->j", maps, forces), abs=1e-9)
        *_, frame = np.linalg.svd(maps.reshape(-1, 3).T)
        for _ in range(200):
            other = best + (rng.normal(size=len(frame) - 3) * 0.1 @ frame[3:]).reshape(-1, 2)
            assert np.hypot(*other.T).max() > 0.99 * np.hypot(*best.T).max()
