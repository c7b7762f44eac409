"""Thousands of arrays within tolerances, solved in floats: none breaks what is said, and how sharp it is."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.robust.box import BoxRingProof
from nonsmooth.proofs.robust.nearest import inner_radius
from nonsmooth.proofs.robust.smooth_rules import SmoothDisc
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from tests.benchmarks.conftest import Stopwatch
from tests.proofs.robust.drawn_arrays import drawn_model, small_box
from tests.proofs.robust.test_nearest_bounds import twists
from tests.proofs.robust.test_smooth_discs import box_of

ARRAYS, POINTS = 1_000, 5
SLOPE_ARRAYS = 40
ROUNDING = 1e-7


@pytest.mark.parametrize(("name", "radius"), [("four-wheel", "7/10"), ("ring-5", "9/20"), ("spiral-30", "1/2")])
def test_no_array_breaks_the_disc(name: str, radius: str, stopwatch: Stopwatch) -> None:
    scene = load_scene(name, rule="box", radius=radius).recentred()
    within, rng = small_box(scene), np.random.default_rng(20)
    rule = BoxRingProof(scene)
    found, rests = rule.disc(within, Fraction(radius)), float(rule.rest_radius(within, Fraction(radius)))
    assert found is not None
    slowest, moved = np.inf, 0.0
    for k in range(ARRAYS):
        model = drawn_model(scene, within, rng, corner=k % 2 == 0)
        angles = rng.uniform(0, 2 * np.pi, 2 * POINTS)
        sizes = np.r_[rng.uniform(float(found.radius), float(found.start), POINTS), np.full(POINTS, rests)]
        points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        motions = twists(model, points)
        rates = -(points[:POINTS] * motions[:POINTS, :2]).sum(axis=1) / sizes[:POINTS]
        slowest = min(slowest, float(rates.min()))
        moved = max(moved, float(np.abs(motions[POINTS:]).max())) if rests else moved
    stopwatch.report(
        f"{name}: ends within {float(found.radius):.3g}, rests within {rests:.3g}; {ARRAYS * POINTS} points outside: "
        f"rate at least {slowest:.3g}, certified {float(min(found.rates)):.3g}; fastest at rest {moved:.1e}"
    )
    assert slowest >= float(min(found.rates)) - ROUNDING
    assert moved < ROUNDING


SHARE = Fraction(1, 64)  # of the tolerances: small enough that all grows in proportion to it


def farthest_outward(scene: Scene, box: Tolerance, most: float) -> float:
    """The largest distance at which some array of the box moves its body away from the point, of those tried."""
    rng, angles = np.random.default_rng(30), 2 * np.pi * np.arange(32) / 32
    rays, farthest = np.column_stack([np.cos(angles), np.sin(angles)]), 0.0
    sizes = most * np.linspace(0.02, 1.2, 60)
    points = (sizes[:, None, None] * rays).reshape(-1, 2)
    for _ in range(SLOPE_ARRAYS):
        model = drawn_model(scene, box, rng, corner=True)
        motions = EllipseMinimizer().minimize(model, loads_at(model, points)).twists
        outward = ((points * motions[:, :2]).sum(axis=1) >= 0).reshape(len(sizes), -1).any(axis=1)
        farthest = max(farthest, float(sizes[outward].max(initial=0.0)))
    return farthest


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", ["four-wheel", "ring-6"])
def test_the_radius_per_tolerance_beside_what_arrays_do(name: str, rule: str, stopwatch: Stopwatch) -> None:
    """Toward zero the certified radius is in proportion to the tolerances, and not far above what arrays need."""
    scene = load_scene(name, rule=rule).recentred()
    most, proof = Fraction(str(inner_radius(scene))), SmoothDisc(scene)
    certified = []
    for share in (SHARE, SHARE / 4):
        disc = proof.disc(box_of(scene, share), most)
        assert disc is not None
        certified.append(float(disc.radius / share))
    observed = farthest_outward(scene, box_of(scene, SHARE), certified[0] * float(SHARE)) / float(SHARE)
    stopwatch.report(
        f"{name}, rule {rule}: radius by tolerances {certified[0]:.3g} and {certified[1]:.3g} certified, "
        f"{observed:.3g} observed, {certified[0] / observed:.2g} times"
    )
    assert observed <= certified[0]
    assert max(certified) < 1.5 * min(certified)
