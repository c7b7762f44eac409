"""Thousands of arrays within tolerances under rule ``box``, solved by linear programs: none breaks what is said."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest

from nonsmooth.proofs.robust.box import BoxRule
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.proofs.robust.test_box_bounds import drawn, small_box, twists

if TYPE_CHECKING:
    from tests.benchmarks.conftest import Stopwatch

pytestmark = pytest.mark.benchmark

ARRAYS, POINTS = 1_000, 5
ROUNDING = 1e-7


@pytest.mark.parametrize(("name", "radius"), [("four-wheel", "7/10"), ("ring-5", "9/20"), ("spiral-30", "1/2")])
def test_no_array_breaks_the_disc(name: str, radius: str, stopwatch: Stopwatch) -> None:
    scene = load_scene(name, rule="box", radius=radius).recentred()
    within, rng = small_box(scene), np.random.default_rng(20)
    rule = BoxRule(scene)
    found, rests = rule.disc(within, Fraction(radius)), float(rule.rest_radius(within, Fraction(radius)))
    assert found is not None
    slowest, moved = np.inf, 0.0
    for k in range(ARRAYS):
        model = drawn(scene, within, rng, corner=k % 2 == 0)
        angles = rng.uniform(0, 2 * np.pi, 2 * POINTS)
        sizes = np.r_[rng.uniform(float(found.radius), float(found.start), POINTS), np.full(POINTS, rests)]
        points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        motions = twists(model, points)
        rates = -(points[:POINTS] * motions[:POINTS, :2]).sum(axis=1) / sizes[:POINTS]
        slowest = min(slowest, float(rates.min()))
        moved = max(moved, float(np.abs(motions[POINTS:]).max())) if rests else moved
    stopwatch.report(
        f"{name}: ends within {float(found.radius):.3g}, rests within {rests:.3g}; {ARRAYS * POINTS} points outside: "
        f"rate at least {slowest:.3g}, certified {float(found.kappa):.3g}; fastest at rest {moved:.1e}"
    )
    assert slowest >= float(found.kappa) - ROUNDING
    assert moved < ROUNDING
