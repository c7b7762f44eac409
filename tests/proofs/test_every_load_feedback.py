"""Laws for every load, against minimizers of D under sampled loads that share nothing with the proof."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.proofs.clauses.every_load.point import FloatLoads
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, rim_speeds
from nonsmooth.proofs.clauses.feedback.every_load_law import TwistPyramid, WheelForms
from nonsmooth.proofs.clauses.feedback.loop_bounds import limited_speed, ultimate_bound
from nonsmooth.proofs.findings.verdicts import Certainty, Feedback
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.scene import Contact, LoopErrors, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.mechanics.unknown_loads import LoadScatter, UnknownLoads
from tests.measured_arrays import Kind, measured_array
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few

Floats: TypeAlias = NDArray[np.float64]

LOADS, POSES = 32, 200
NEAR = 1e-5  # distance from the point, in lengths: loads and slips differ by that
SLACK = 1e-3  # of the rate: motions differ from those at the point, and solvers end with a gap
HEIGHT = 0.3

ANY, UNEVEN = "any", "uneven"
SPIRAL = """name = "spiral"
[friction]
mu_roll = 1
mu_side = "1/5"
[ring]
count = 5
[field]
kind = "spiral"
angle = "pi/4"
"""
FRAGILE = measured_array(Kind.COCIRCULAR, 22)


def array(text: str, rule: str, loads: str, folder: Path) -> Scene:
    """A scene from its text, or a built-in one, measured from the point, its loads unknown."""
    file = folder / "array.toml"
    file.write_text(text, encoding="utf-8")
    scene = load_scene(file if "\n" in text else text).recentred()
    zero = scene.field.zero
    unknown = UnknownLoads() if loads == ANY else UnknownLoads(LoadScatter(zero + Fraction(3, 10), zero))
    return replace(scene, contact=Contact(rule, unknown))


def sampled_loads(scene: Scene, c: Floats, rng: np.random.Generator) -> Floats:
    """Springs of random heights with the body on them (m, n), or corners of all admissible loads."""
    from scipy.optimize import linprog

    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    wanted, count = np.array([1.0, *c]), len(moments)
    if scene.contact.loads == UnknownLoads():
        prices = rng.normal(size=(LOADS, count))
        return np.array([linprog(p, A_eq=moments.T, b_eq=wanted, bounds=(0, None)).x for p in prices])
    heights = HEIGHT / count * rng.choice([-1.0, 1.0], (LOADS, count))  # in units of 1/k
    poses = np.linalg.solve(moments.T @ moments, (wanted + heights @ moments).T)
    loads: Floats = (moments @ poses).T - heights
    assert loads.min() > 0  # no wheel lifts
    return loads


@dataclass(frozen=True)
class Loop:
    """A law in floats, with l for the unit of length: its twists (3, 3), and what they become under loads (3, m, 3)."""

    twists: Floats
    motions: Floats

    def rates(self, g: Floats) -> Floats:
        """The velocities of g under all loads at gain one, (m, 3)."""
        products = self.twists @ g
        chosen = int(np.argmax(np.abs(products)))
        velocities: Floats = -products[chosen] * self.motions[chosen]
        return velocities

    def worst(self, rng: np.random.Generator) -> float:
        """The largest ``V'/2 / |g|^2`` at random poses."""
        poses = rng.normal(size=(POSES, 3))
        poses /= np.linalg.norm(poses, axis=1, keepdims=True)
        return max(float((self.rates(g) @ g).max()) for g in poses)


def loop_of(scene: Scene, cone: LawCone) -> Loop:
    """The law of a cone under sampled loads near the point."""
    own, rng = in_own_length(scene), np.random.default_rng(5)
    loads, rule = sampled_loads(own, NEAR * rng.normal(size=2), rng), rule_of(own)
    model = contacts_under(rule, own)
    minimizer = EllipseMinimizer() if isinstance(rule, SmoothRule) else BoxHighs()
    motions = []
    for imposed in cone.twists:
        targets = np.zeros(2 * model.wheels)
        targets[0::2] = rim_speeds(own, imposed)
        motions.append(minimizer.minimize(replace(model, targets=targets), loads).twists)
    return Loop(np.array([[float(x) for x in imposed.twist] for imposed in cone.twists]), np.array(motions))


def certified(scene: Scene) -> DrivenFeedback:
    """The law for every load, with its evidence verified."""
    feedback = decide_driven_feedback(scene)
    assert feedback.verdict is Feedback.STABILIZABLE
    assert evidence_holds(feedback)
    assert feedback.scene is scene
    return feedback


@few(1)
@pytest.mark.parametrize(
    ("text", "rule", "loads"),
    [
        (SPIRAL, "ellipse", ANY),
        (SPIRAL, "roller", ANY),
        (SPIRAL, "box", ANY),
        ("ring-5", "ellipse", UNEVEN),
        ("ring-5", "roller", UNEVEN),
        ("ring-5", "box", UNEVEN),
    ],
)
def test_v_falls_at_the_certified_rate_under_sampled_loads(text: str, rule: str, loads: str, tmp_path: Path) -> None:
    scene = array(text, rule, loads, tmp_path)
    feedback = certified(scene)
    assert feedback.certified_kappa is not None
    seen = loop_of(scene, feedback.cones[0]).worst(np.random.default_rng(1))
    assert seen <= -float(feedback.certified_kappa) * (1 - SLACK)


def test_the_law_of_level_springs_fails_where_the_law_for_every_load_works(tmp_path: Path) -> None:
    """Under some heights V rises with the fastest law on level springs; the law for all of them is another one."""
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    level = decide_driven_feedback(replace(scene, contact=Contact("ellipse")))
    feedback, rng = certified(scene), np.random.default_rng(1)
    assert level.kappa is not None
    assert feedback.kappa is not None
    assert level.kappa > feedback.kappa
    assert loop_of(scene, level.cones[0]).worst(rng) > 0
    assert loop_of(scene, feedback.cones[0]).worst(rng) < 0


def test_a_law_is_no_law_for_other_loads_or_a_better_rate(tmp_path: Path) -> None:
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    feedback = certified(scene)
    law = feedback.every_load
    assert law is not None
    other = replace(scene, contact=Contact("ellipse", UnknownLoads()))
    for slack in (law.slack / 8, Fraction(0), Fraction(1)):
        assert not evidence_holds(replace(feedback, every_load=replace(law, slack=slack)))
    assert not evidence_holds(replace(feedback, every_load=replace(law, scene=in_own_length(other))))


def test_loads_that_balance_in_one_way_only_leave_the_rate(tmp_path: Path) -> None:
    """Three wheels."""
    scene = array("ring-3", "ellipse", ANY, tmp_path)
    level = decide_driven_feedback(replace(scene, contact=Contact("ellipse")))
    feedback = certified(scene)
    assert feedback.kappa == level.kappa
    assert feedback.kept > Fraction(99, 100)


def test_what_no_law_holds_on_level_springs_no_law_holds_for_every_load(tmp_path: Path) -> None:
    feedback = decide_driven_feedback(array("differential-drive", "ellipse", UNEVEN, tmp_path))
    assert feedback.verdict is Feedback.NO_CERTIFICATE
    assert feedback.reason.startswith("on level springs, which are among the loads: ")
    assert evidence_holds(feedback)


def test_late_poses_and_ends_of_speeds_take_the_rest_of_the_rate(tmp_path: Path) -> None:
    """A loop just below the largest delay comes home while a random load acts in every step."""
    scene = array(FRAGILE, "ellipse", UNEVEN, tmp_path)
    feedback = certified(scene)
    zero, rng = scene.field.zero, np.random.default_rng(0)
    bound = ultimate_bound(feedback, LoopErrors(zero, zero, Fraction(0)))
    assert bound.verdict is Certainty.CERTIFIED
    assert bound.largest_delay is not None
    loop, lag = loop_of(scene, feedback.cones[0]), 20
    step = float(bound.largest_delay) * 0.9 / lag
    path = [np.array([0.6, -0.3, 0.7])] * (lag + 1)
    for _ in range(4000):
        rates = loop.rates(path[-1 - lag])
        path.append(path[-1] + step * rates[rng.integers(len(rates))])
    sizes = np.linalg.norm(path, axis=1)
    assert sizes.max() < 1.05
    assert sizes[-1] < 0.9
    with_limits = replace(scene, wheels=tuple(replace(wheel, speed_limit=zero + 1) for wheel in scene.wheels))
    free, level = limited_speed(feedback, with_limits), limited_speed(replace(feedback, every_load=None), with_limits)
    assert free is not None
    assert level is not None
    assert free == level * feedback.kept


def test_a_pyramid_holds_what_it_holds() -> None:
    """Wheels at random: a pyramid that does not hold the motion is refused, one with some room about it is not."""
    rng = np.random.default_rng(2)
    wheels = WheelForms(rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), CutEllipse(*np.ones((3, 6))))
    speeds, loads = rng.normal(size=6), FloatLoads(np.full((1, 6), 1 / 6), np.zeros((0, 6)))
    motion = minimum(wheels, speeds)
    for away, slack, held in ((0.0, Fraction(1, 100), True), (0.3, Fraction(1, 5), False), (0.3, Fraction(3, 5), True)):
        twists = np.eye(3) * np.linalg.norm(motion)
        twists[0] = motion
        twists[0] = motion + away * np.linalg.norm(motion) * np.array([0, 0, 1.0])
        pyramid = TwistPyramid(twists, 0, speeds, slack, max(2 * slack, Fraction(1, 8)))
        assert pyramid.holds_minimizers(wheels, loads) == held


def minimum(wheels: WheelForms, speeds: Floats) -> Floats:
    """The minimizer of D for equal loads, by a general method."""
    from scipy.optimize import minimize

    found = minimize(lambda xi: wheels.dissipation(xi, speeds).sum(), np.zeros(3), method="Nelder-Mead", tol=1e-12)
    point: Floats = found.x
    return point
