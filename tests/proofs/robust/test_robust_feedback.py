"""Feedback of arrays drawn from a box, under the law of the scene: minimizers by a linear program."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import cast

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.robust.feedback import decide_robust_loop
from nonsmooth.proofs.theorem4 import check_smooth
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from tests.built_in import checked
from tests.proofs.robust.test_box_bounds import Floats, small_box
from tests.proofs.robust.test_smooth_discs import box_of
from tests.thorough import few, keep

NAMES = ("ring-5", "spiral-30", "saddle", "conveyor-3")


def case(name: str, factor: Fraction = Fraction(1)) -> tuple[Scene, Tolerance, DrivenFeedback]:
    scene = load_scene(name, rule="box")
    box = small_box(scene, factor)
    return replace(scene, tolerances=box), box, cast("DrivenFeedback", checked(name, "box").results["feedback"])


def commanded(scene: Scene, twist: Floats) -> Floats:
    """The rims' speeds of the scene for a twist, at the places of its wheels."""
    centred = scene.recentred()
    places = np.array([[float(x) for x in wheel.position] for wheel in centred.wheels])
    rims = np.array([[float(x) for x in wheel.unit_direction] for wheel in centred.wheels])
    at = twist[:2] + twist[2] * np.column_stack([-places[:, 1], places[:, 0]])
    return np.asarray((rims * at).sum(axis=1))


def drawn(scene: Scene, box: Tolerance, speeds: Floats, rng: np.random.Generator, *, corner: bool) -> ContactModel:
    def shift(*size: int) -> Floats:
        return rng.choice([-1.0, 1.0], size) if corner else rng.uniform(-1, 1, size)

    wheels = scene.recentred().wheels
    n = len(wheels)
    places = np.array([[float(x) for x in w.position] for w in wheels]) + float(box.position) * shift(n, 2)
    angles = np.array([np.arctan2(float(y), float(x)) for x, y in (w.unit_direction for w in wheels)])
    angles = angles + np.pi * float(box.heading) * shift(n)
    roll = np.array([float(w.friction.roll) for w in wheels]) * (1 + float(box.mu_roll) * shift(n))
    side = np.array([float(w.friction.side) for w in wheels]) * (1 + float(box.mu_side) * shift(n))
    rims = np.column_stack([np.cos(angles), np.sin(angles)])
    true = speeds * (1 + float(box.speed) * shift(n))
    return ContactModel.build(places, rims, true, np.column_stack([roll, side]))


@few(1)
@pytest.mark.parametrize("name", NAMES)
def test_no_array_of_the_box_is_slower(name: str) -> None:
    """``V' <= -2 k kappa V`` at random poses close to the point, for arrays that are corners of the box and others."""
    scene, box, feedback = case(name)
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.kappa is not None
    assert loop.rate < feedback.kappa
    length, rng = float(scene.check.length), np.random.default_rng(7)
    twists = np.array([[float(x) for x in twist] for twist in feedback.cones[0].vectors])
    for k in range(60):
        g = rng.normal(size=3)
        products = twists @ g
        m = int(np.argmax(np.abs(products)))
        command = -products[m] * np.array([*twists[m][:2], twists[m][2] / length])
        model = drawn(scene, box, commanded(scene, command), rng, corner=k % 2 == 0)
        near = 1e-9 * g[None, :2]
        moved = BoxHighs().minimize(model, loads_at(model, near)).twists[0] * np.array([1, 1, length])
        assert g @ moved <= -float(loop.rate) * (g @ g) + 1e-7


def test_without_tolerances_the_rate_is_that_of_the_law() -> None:
    scene, _, feedback = case("saddle", Fraction(0))
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.kappa is not None
    assert float(loop.rate) == pytest.approx(float(feedback.kappa), rel=1e-5)
    assert loop.rate <= feedback.kappa


def test_what_is_not_followed_is_said() -> None:
    for name, rule, said in (
        ("four-wheel", "box", "balance exactly"),
        ("four-wheel", "nearest", "another pair may carry"),
    ):
        scene = load_scene(name, rule=rule)
        feedback = checked(name, rule).results["feedback"]
        loop = decide_robust_loop(replace(scene, tolerances=small_box(scene)), cast("DrivenFeedback", feedback))
        assert loop is not None
        assert loop.rate is None
        assert said in loop.reason
    scene, _, feedback = case("saddle", Fraction(60))
    loop = decide_robust_loop(scene, feedback)
    assert loop is not None
    assert loop.rate is None


# ---- rules with friction sets --------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize(
    ("name", "count"), keep(1, [("four-wheel", 10), ("four-wheel", 40), ("saddle", 40), ("spiral-30", 40)])
)
def test_no_array_of_the_box_is_slower_under_rules_with_friction_sets(name: str, count: int, rule: str) -> None:
    """The speeds are those that the law states; minimizers in floats, for corners of the box and others."""
    scene = load_scene(name, rule=rule)
    feedback = cast("DrivenFeedback", check_smooth(scene).results["feedback"])
    box = box_of(scene, Fraction(1, 100))
    loop = decide_robust_loop(replace(scene, tolerances=box), feedback)
    assert loop is not None
    assert loop.rate is not None
    assert feedback.certified_kappa is not None
    assert 0 < loop.rate < feedback.certified_kappa
    own = in_own_length(replace(scene, tolerances=box).recentred())
    cone, rng = feedback.cones[0], np.random.default_rng(9)
    twists = np.array([[float(x) for x in twist] for twist in cone.vectors])
    speeds = [np.array(rim_speeds(own, imposed)) for imposed in cone.twists]
    assert own.tolerances is not None
    for k in range(count):
        g = rng.normal(size=3)
        products = twists @ g
        m = int(np.argmax(np.abs(products)))
        model = drawn(own, own.tolerances, -products[m] * speeds[m], rng, corner=k % 2 == 0)
        if rule == "roller":
            roll, side = model.friction.reshape(-1, 2).T
            model = replace(model, friction=np.repeat(roll, 2), cuts=np.minimum(side / roll, 1.0))
        moved = EllipseMinimizer().minimize(model, loads_at(model, 1e-9 * g[None, :2])).twists[0]
        assert g @ moved <= -float(loop.rate) * (g @ g) + 1e-6


def test_large_tolerances_leave_the_law_undecided() -> None:
    scene = load_scene("ring-5", rule="ellipse")
    feedback = cast("DrivenFeedback", check_smooth(scene).results["feedback"])
    loop = decide_robust_loop(replace(scene, tolerances=box_of(scene, Fraction(3))), feedback)
    assert loop is not None
    assert loop.rate is None
    assert "slip away" in loop.reason
