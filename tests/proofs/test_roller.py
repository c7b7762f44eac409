"""Rule ``roller`` at the checked point and its feedback: exact statements against the numerical minimizer."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import proved
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation, ellipse_point
from nonsmooth.proofs.clauses.feedback.balanced_twists import (
    HALVES,
    BalancedTwist,
    balance_twist,
    border_enclosure,
    exclude_twist,
    wheel_forces,
)
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.driven_law import between, rim_speeds
from nonsmooth.proofs.clauses.feedback.twist_candidates import BoxTwist, candidate_twists
from nonsmooth.proofs.findings.verdicts import Equilibrium, Feedback, Translation
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.theorem4 import check_smooth
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from tests.conftest import Arrays
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.forces_oracle import verifies
from tests.ruled import centred
from tests.thorough import few

NEAR = 1e-3  # length: where a linearization is compared
IMPOSED = 1e-7
TIPPING = (4, 10, 16, 20, 22, 23)  # random arrays whose centre is outside the support polygon


def scene_of(name: str, ratio: Fraction) -> Scene:
    return with_friction_ratio(load_scene(name, rule="roller"), ratio).recentred()


def without_bearing_friction(scene: Scene) -> Scene:
    zero = scene.field.zero
    return replace(scene, wheels=tuple(replace(w, friction=Friction(w.friction.roll, zero)) for w in scene.wheels))


def point_of(scene: Scene) -> EllipsePoint:
    point = ellipse_point(scene, load_regions(scene, scene.check.equilibrium))
    assert evidence_holds(point)
    assert verifies(point)
    return point


def twists_near(scene: Scene, points: np.ndarray, speeds: np.ndarray | None = None) -> np.ndarray:
    model = contacts_under(smooth_rule_of(scene), scene)
    if speeds is not None:
        targets = np.zeros(2 * len(speeds))
        targets[::2] = speeds
        model = replace(model, targets=targets)
    minima = EllipseMinimizer().minimize(model, loads_at(model, points))
    assert proved(minima).all()
    assert not minima.faces
    return minima.twists


@pytest.mark.parametrize("ratio", [Fraction(1, 50), Fraction(1, 2), Fraction(3)])
def test_near_rest_rollers_stand_and_the_body_creeps_home(ratio: Fraction) -> None:
    """``c' = -sqrt(2) c`` whatever the bearings are."""
    scene = scene_of("four-wheel", ratio)
    point = point_of(scene)
    assert (point.situation, point.translation) == (Situation.SMOOTH, Translation.ASYMPTOTICALLY_STABLE)
    assert point.linearization is not None
    zero, rate = scene.field.zero, -scene.field.sqrt(2)
    assert point.linearization.translation == ((rate, zero), (zero, rate))


@pytest.mark.parametrize("name", ["ring-3", "rectangle", "elliptic", "outward", "grid-4x4"])
def test_the_linearization_against_the_minimizer(name: str) -> None:
    scene = scene_of(name, Fraction(1, 4))
    point = point_of(scene)
    assert point.linearization is not None
    columns = np.array([[float(x) for x in column] for column in point.linearization.columns])
    directions = NEAR * np.array([(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
    predicted = directions @ columns
    found = twists_near(scene, directions)
    assert np.abs(found - predicted).max() < 2e-2 * np.abs(predicted).max()


def test_without_bearing_friction_nothing_bends_and_the_point_is_open() -> None:
    """The rollers never stand, so the Hessian of the standing ones would be wrong: D is ``mu_R |r|``."""
    point = point_of(without_bearing_friction(scene_of("elliptic", Fraction(1, 2))))
    assert (point.situation, point.linearization) == (Situation.OPEN, None)
    assert point.translation is Translation.UNDECIDED
    assert point.equilibrium is Equilibrium.HOLDS


def test_a_spin_with_standing_rollers_and_one_with_turning_ones() -> None:
    """At the rate of least slip rollers stand where their bearings hold; with easy ones rims roll, and it is open."""
    hard = point_of(scene_of("spiral-30", Fraction(19, 20)))
    assert (hard.situation, hard.equilibrium) == (Situation.SMOOTH, Equilibrium.HOLDS)
    easy = point_of(scene_of("spiral-30", Fraction(1, 50)))
    assert (easy.situation, easy.equilibrium) == (Situation.OPEN, Equilibrium.UNDECIDED)
    (spin,) = twists_near(scene_of("spiral-30", Fraction(1, 50)), np.zeros((1, 2)))
    assert np.hypot(spin[0], spin[1]) < 1e-9


@pytest.mark.parametrize("ratio", [Fraction(1, 20), Fraction(1, 2)])
def test_sticking_wheels_hold_the_body_inside_their_cut_discs(arrays: Arrays, ratio: Fraction) -> None:
    scene = centred(arrays.four_wheel((1, ratio)), "roller")
    zero = scene.field.zero
    wheels = tuple(replace(w, given_speed=zero) if w.index % 2 == 0 else w for w in scene.wheels)
    scene = replace(scene, wheels=wheels)
    point = point_of(scene)
    assert (point.situation, point.translation) == (Situation.STICKING, Translation.STABLE)
    assert np.abs(twists_near(scene, np.array([(0.0, 0.0), (1e-3, -2e-3)]))).max() < 1e-9


def test_it_is_driven_away_from_an_off_centre_point() -> None:
    for ratio in (Fraction(1, 10), Fraction(1, 2)):
        scene = scene_of("off-center", ratio)
        point = point_of(scene)
        speed = np.hypot(*twists_near(scene, np.zeros((1, 2)))[0, :2])
        assert (point.equilibrium is Equilibrium.FAILS) == (speed > 1e-6) or point.situation is Situation.OPEN


@pytest.mark.parametrize("seed", [k for k in range(30) if k not in TIPPING])
def test_random_points_are_never_misjudged(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed, (1, Fraction(1 + seed % 5, 6))) if seed % 2 else arrays.random(seed, 5)
    scene = centred(replace(scene, check=replace(scene.check, radius=scene.field(1) / 64)), "roller")
    point = point_of(scene)
    if point.equilibrium is not Equilibrium.UNDECIDED:
        speed = np.hypot(*twists_near(scene, np.zeros((1, 2)))[0, :2])
        assert (speed < 1e-7) == (point.equilibrium is Equilibrium.HOLDS)


@few(1)
@pytest.mark.parametrize("ratio", [Fraction(1, 50), Fraction(1, 4), Fraction(9, 10)])
@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "elliptic", "saddle", "conveyor-3", "off-center"])
def test_speeds_impose_their_twists(name: str, ratio: Fraction) -> None:
    """At the equilibrium by forces, beside it by boxes inside the sets, in each cone of directions."""
    scene = scene_of(name, ratio)
    feedback = decide_driven_feedback(scene)
    assert feedback.verdict is Feedback.STABILIZABLE
    assert evidence_holds(feedback)
    for cone in feedback.cones:
        towards = (0.0, 0.0) if cone.rays is None else tuple(float(x) for x in between(*cone.rays))
        for imposed in cone.twists:
            found = twists_near(scene, 1e-2 * np.array([towards]), np.array(rim_speeds(scene, imposed)))
            assert np.abs(found[0] - [float(x) for x in imposed.twist]).max() < IMPOSED


def test_boxes_inside_the_sets_prove_what_forces_leave_open() -> None:
    feedback = decide_driven_feedback(scene_of("four-wheel", Fraction(1, 50)))
    assert "boxes inside the friction sets" in feedback.reason
    assert all(isinstance(imposed, BoxTwist) for cone in feedback.cones for imposed in cone.twists)
    assert feedback.reach is not None


def test_what_forces_prove_no_separator_excludes(arrays: Arrays) -> None:
    scene = arrays.cocircular(1, (1, Fraction(3, 5)))
    scene = centred(replace(scene, check=replace(scene.check, radius=scene.field(1) / 8)), "roller")
    (region, *_) = load_regions(scene, (scene.field.zero, scene.field.zero))
    balanced = [balance_twist(scene, region, twist) for twist in candidate_twists(scene)]
    unique = [one for one in balanced if one.is_unique]
    for one in unique:
        found = twists_near(scene, np.zeros((1, 2)), np.array(rim_speeds(scene, one)))
        assert np.abs(found[0] - [float(x) for x in one.twist]).max() < IMPOSED
    assert not exclude_twist(unique[0]).is_excluded


@pytest.mark.parametrize("cut", [Fraction(1, 50), Fraction(3, 5), Fraction(99, 100)])
def test_arcs_of_a_cut_border_lie_in_their_enclosures(cut: Fraction) -> None:
    scene = scene_of("ring-3", cut)
    (region, *_) = load_regions(scene, (scene.field.zero, scene.field.zero))
    one = scene.field.one
    wheel = next(w for w in wheel_forces(scene, region, (one / 3, one / 7, one)) if w.side)
    rng = np.random.default_rng(0)
    angles = np.linspace(0, 2 * np.pi, 32)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    arcs = [HALVES, *((Fraction(low, 64), Fraction(low + 1 + k % 9, 64)) for k, low in enumerate(range(-63, 54, 4)))]
    for low, high in arcs:
        corners = np.array([[float(x) for x in corner] for corner in border_enclosure(wheel, (low, high))])
        for t in rng.uniform(float(low), float(high), 20):
            height = min((1 - t * t) / (1 + t * t), float(cut))
            inside = directions @ [2 * t / (1 + t * t), wheel.side * height]
            assert (inside <= (directions @ corners.T).max(axis=1) + 1e-12).all()


def test_a_unicycle_stays_one(arrays: Arrays) -> None:
    scene = centred(arrays.differential_drive(), "roller")
    feedback = decide_driven_feedback(scene)
    assert feedback.verdict is Feedback.NO_CERTIFICATE
    assert evidence_holds(feedback)
    assert all(isinstance(candidate, BalancedTwist) for candidate in feedback.candidates)


def test_there_is_no_certificate_file() -> None:
    with pytest.raises(NoCertificateError, match='"nearest" or "box", received "roller"'):
        build_certificate(check_smooth(load_scene("four-wheel", rule="roller")))
