"""The rules ``box``, ``ellipse`` and ``roller`` at the checked point: exact statements against minimizers."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, proved
from nonsmooth.analysis.minimizers.sampling import (
    SampledLaw,
    relative_rates,
    sample_closed_loop,
    sample_smooth_derivative,
)
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
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.clauses.feedback.twist_candidates import BoxTwist, candidate_twists
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.at_point import decide_translation_at
from nonsmooth.proofs.clauses.translation.on_cells import rest_area
from nonsmooth.proofs.findings import Equilibrium, Feedback, Rotation, Theorem4, Translation
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.theorem4 import CellCheck, SmoothCheck, check_cells, check_smooth, check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from nonsmooth.symbolic.numbers.plane import plus
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.built_in import centred, ruled, whole_check
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.forces_oracle import verifies
from tests.thorough import few

# ---- Rule ``roller`` at the checked point and its feedback: exact statements against the numerical minimizer.

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
    twists = twists_near(scene, directions)
    assert np.abs(twists - predicted).max() < 2e-2 * np.abs(predicted).max()


def test_without_bearing_friction_nothing_bends_and_the_point_is_open() -> None:
    """The rollers never stand, so the Hessian of the standing ones would be wrong: D is ``mu_R |r|``."""
    point = point_of(without_bearing_friction(scene_of("elliptic", Fraction(1, 2))))
    assert (point.situation, point.linearization) == (Situation.OPEN, None)
    assert point.translation is Translation.UNDECIDED
    assert point.equilibrium is Equilibrium.HOLDS


def test_a_spin_with_standing_rollers() -> None:
    """At the rate of least slip rollers stand where their bearings hold."""
    hard = point_of(scene_of("spiral-30", Fraction(19, 20)))
    assert (hard.situation, hard.equilibrium) == (Situation.SMOOTH, Equilibrium.HOLDS)


@few(2)
@pytest.mark.parametrize("ratio", [Fraction(1, 50), Fraction(1, 2)])
@pytest.mark.parametrize("angle", ["pi/4", "pi/3", "5*pi/12"])
@pytest.mark.parametrize("count", [3, 4, 5, 6])
def test_rims_that_do_not_slip_turn_the_body_while_their_rollers_turn(
    count: int, angle: str, ratio: Fraction, tmp_path: Path
) -> None:
    """Of rings with rims away from the centre: everywhere near it D is least for one spin about it.

    The dissipation is that of the definition, the least over the speeds t of the rollers.
    """
    file = tmp_path / "ring.toml"
    file.write_text(
        f'[friction]\nmu_roll = 1\nmu_side = "{ratio}"\n[ring]\ncount = {count}\n'
        f'[field]\nkind = "spiral"\nangle = "{angle}"\n[check]\nradius = "7/20"\n'
    )
    scene = load_scene(file, rule="roller")
    point = point_of(scene)
    assert (point.situation, point.translation) == (Situation.HELD, Translation.STABLE)
    assert point.twist is not None
    spin = float(point.twist.omega)
    for x, y in [(0.0, 0.0), (0.02, -0.01), (-0.005, 0.03)]:
        (twist,) = twists_near(scene, np.array([(x, y)]))
        assert twist == pytest.approx([0, 0, spin], abs=1e-9)
        here = least_dissipation(scene, (x, y), np.array([0, 0, spin]))
        for other in np.random.default_rng(count).normal(size=(20, 3)):
            assert least_dissipation(scene, (x, y), np.array([0, 0, spin]) + 0.01 * other) > here
    radius = decide_translation_at(point, None).region_radius
    assert radius is not None
    angles = np.linspace(0, 2 * np.pi, 60)
    border = 0.999 * float(radius) * np.column_stack([np.cos(angles), np.sin(angles)])
    assert twists_near(scene, border) == pytest.approx(np.tile([0, 0, spin], (60, 1)), abs=1e-9)


def test_a_spin_that_rims_impose_is_told_among_many_roots_too(tmp_path: Path) -> None:
    """Of wheels whose headings and speeds need seven square roots, where quotients are carried out late."""
    wheels = ""
    for k, (x, y) in enumerate([(10, 1), (3, 9), (-7, 7), (-10, -2), (-4, -9), (5, -9), (9, -5)]):
        a, b = -y + x * (k + 2), x + y * (k + 2)
        wheels += (
            f'[[wheel]]\nposition = ["{x}/10", "{y}/10"]\nheading = [{a}, {b}]\n'
            f'speed = "({x * b - y * a})/(10*sqrt({a * a + b * b}))"\n'
        )
    (tmp_path / "many.toml").write_text(f'[friction]\nmu_roll = 1\nmu_side = "1/9"\n[check]\nradius = "1/10"\n{wheels}')
    scene = load_scene(tmp_path / "many.toml", rule="roller")
    point = point_of(scene)
    assert point.situation is Situation.HELD
    radius = decide_translation_at(point, None).region_radius
    assert radius is not None
    border = 0.99 * float(radius) * np.array([(1.0, 0.0), (-0.6, 0.8), (0.0, -1.0)])
    assert twists_near(scene, border) == pytest.approx(np.tile([0, 0, 1], (3, 1)), abs=1e-9)


def least_dissipation(scene: Scene, centre: tuple[float, float], twist: Floats) -> float:
    """``sum_i N_i min_t (mu_R |(r_i, s_i - t)| + mu_S |t|)`` for a twist about the origin, at a centre of mass."""
    region = load_regions(scene, scene.check.equilibrium)[0]
    total, speeds = 0.0, np.linspace(-4, 4, 80_001)
    for wheel, (load, by_x, by_y) in zip(scene.wheels, region.forces, strict=True):
        normal = float(load) + float(by_x) * centre[0] + float(by_y) * centre[1]
        (dx, dy), (px, py) = map(float, wheel.unit_direction), map(float, wheel.position)
        vx, vy = twist[0] - twist[2] * py, twist[1] + twist[2] * px
        along, across = dx * vx + dy * vy - float(wheel.speed), dx * vy - dy * vx
        roll, side = float(wheel.friction.roll), float(wheel.friction.side)
        total += normal * float((roll * np.hypot(along, across - speeds) + side * np.abs(speeds)).min())
    return total


@pytest.mark.parametrize("ratio", [Fraction(1, 20), Fraction(1, 2)])
def test_sticking_wheels_hold_the_body_inside_their_cut_discs(arrays: Arrays, ratio: Fraction) -> None:
    scene = centred(arrays.four_wheel((1, ratio)), "roller")
    zero = scene.field.zero
    wheels = tuple(replace(w, given_speed=zero) if w.index % 2 == 0 else w for w in scene.wheels)
    scene = replace(scene, wheels=wheels)
    point = point_of(scene)
    assert (point.situation, point.translation) == (Situation.STICKING, Translation.STABLE)
    radius = decide_translation_at(point, None).region_radius
    assert radius is not None
    angles = np.linspace(0, 2 * np.pi, 60)
    border = 0.999 * float(radius) * np.column_stack([np.cos(angles), np.sin(angles)])
    assert np.abs(twists_near(scene, border)).max() < 1e-9


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
@pytest.mark.parametrize("name", ["elliptic", "ring-3", "four-wheel", "saddle", "conveyor-3", "off-center"])
def test_speeds_impose_their_twists(name: str, ratio: Fraction) -> None:
    """At the equilibrium by forces, beside it by boxes inside the sets, in each cone of directions."""
    scene = scene_of(name, ratio)
    feedback = decide_driven_feedback(scene)
    assert feedback.verdict is Feedback.STABILIZABLE
    assert evidence_holds(feedback)
    for cone in feedback.cones:
        towards = (0.0, 0.0) if cone.rays is None else tuple(float(x) for x in plus(*cone.rays))
        for imposed in cone.twists:
            twists = twists_near(scene, 1e-2 * np.array([towards]), np.array(rim_speeds(scene, imposed)))
            assert np.abs(twists[0] - [float(x) for x in imposed.twist]).max() < IMPOSED


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
        twists = twists_near(scene, np.zeros((1, 2)), np.array(rim_speeds(scene, one)))
        assert np.abs(twists[0] - [float(x) for x in one.twist]).max() < IMPOSED
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


# ---- Theorem 4 under the rules ``box`` and ``ellipse``: verdicts, evidence and what pruning may leave out.

SLACK = 1e-9  # of D, about the accuracy of CLARABEL; D is of order 0.1
RATE_ERROR = 1e-6  # of V'/V
EVIDENT = ["four-wheel", "rectangle", "ring-5", "grid-4x4", "elliptic", "spiral-30", "conveyor-3", "saddle", "outward"]


def without_feedback(scene: Scene) -> Scene:
    """Side friction first, so that no closed loop is sampled."""
    return replace(
        scene,
        wheels=tuple(replace(w, friction=replace(w.friction, side=w.friction.roll * 2)) for w in scene.wheels),
    )


@cache
def checked(name: str, rule: str) -> CellCheck | SmoothCheck:
    """Once in a process: two tests look at it."""
    return check_theorem4(load_scene(name, rule=rule))


@few(2)
@pytest.mark.parametrize("name", EVIDENT)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_evidence_verifies(name: str, rule: str) -> None:
    result = checked(name, rule)
    assert result.check()
    assert isinstance(result, CellCheck if rule == "box" else SmoothCheck)


def test_four_wheel_under_box_rests_in_a_diamond() -> None:
    result = check_cells(load_scene("four-wheel", rule="box"))
    assert result.verdict is Theorem4.FAILS
    assert result.translation.verdict is Translation.STABLE
    assert result.translation.worst_rate == 0
    assert rest_area(result.partition) == Fraction(1, 2)
    assert result.rotation.verdict is Rotation.NEUTRAL
    assert result.feedback.verdict is Feedback.STABILIZABLE
    assert any("lemma" in s.why for s in result.skipped)


@pytest.mark.parametrize("name", ["four-wheel", "ring-6", "ring-3", "four-wheel-side", "off-center"])
def test_pruning_changes_no_verdict(name: str) -> None:
    scene = without_feedback(load_scene(name, rule="box"))
    pruned, full = check_cells(scene), whole_check(scene)
    for clause in ("equilibrium", "translation", "rotation", "feedback"):
        assert getattr(pruned, clause).verdict is getattr(full, clause).verdict
    assert pruned.verdict is full.verdict
    assert full.partition.complete
    assert full.partition.tiles
    assert full.check()


@few(1)
@pytest.mark.parametrize("friction", [(1, Fraction(1, 5)), (1, Fraction(1, 10))])
def test_the_rotation_bound_of_rule_box_holds_on_every_cell(arrays: Arrays, friction: tuple[int, Fraction]) -> None:
    """V* <= -kappa |c| and |omega| <= bound kappa/2 wherever the body moves."""
    scene = ruled(arrays.four_wheel(friction), "box")
    rotation = check_theorem4(scene, prune=False, beside=False).results["rotation"]
    assert isinstance(rotation, RotationResult)
    bound = rotation.rotation_per_distance
    assert bound is not None
    rng = np.random.default_rng(0)
    for derivative in cell_derivatives(build_box_partition(scene)):
        if any(derivative.twist):
            for _ in range(20):
                x, y = arrays.interior_point(derivative.cell.polygon, rng)
                rate = 2 * float(x * derivative.twist.vx + y * derivative.twist.vy) / np.hypot(float(x), float(y))
                assert 2 * abs(float(derivative.twist.omega)) <= float(bound) * -rate + 1e-12


@pytest.mark.parametrize("ratio", [Fraction(1, 2), Fraction(1, 10), 2])
def test_four_wheel_under_ellipse_is_exponentially_stable(arrays: Arrays, ratio: Fraction) -> None:
    result = check_theorem4(ruled(arrays.four_wheel((1, ratio)), "ellipse"))
    assert isinstance(result, SmoothCheck)
    assert result.translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    linear = result.translation.point.linearization
    assert linear is not None
    assert linear.spectral_abscissa == -result.scene.field.sqrt(2) / (Fraction(ratio) * ratio)
    assert result.rotation.verdict is Rotation.NEUTRAL
    assert result.translation.worst_rate == 0


@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "rectangle", "spiral-30"])
def test_sampled_rates_agree_with_the_verdict(name: str) -> None:
    """Exponentially stable points of these arrays also decrease |c|^2 on the whole square."""
    scene = load_scene(name, rule="ellipse").recentred()
    sampled = sample_smooth_derivative(scene, 400)
    assert (sampled.samples, sampled.not_certified) == (400, "")
    assert sampled.largest is not None
    assert sampled.largest < 1e-9


def test_spinning_and_carried_bodies_are_unstable_in_theta() -> None:
    for name, rate in (("spiral-30", "-4*sqrt(2)/7"), ("conveyor-3", "-1")):
        result = checked(name, "ellipse")
        assert result.equilibrium.verdict is Equilibrium.HOLDS
        assert result.rotation.verdict is Rotation.UNSTABLE
        assert result.rotation.drift is not None
        assert [str(w) for w in result.rotation.drift.interval] == [rate, rate]


@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_a_body_that_would_tip_is_refused(arrays: Arrays, rule: str) -> None:
    with pytest.raises(RefusalError, match=r"check\.radius: .* measured from the checked point, at .* support polygon"):
        check_theorem4(ruled(arrays.four_wheel(radius=2), rule))
    with pytest.raises(RefusalError, match=r"check\.equilibrium: required a point inside the support polygon"):
        check_theorem4(load_scene("four-wheel", rule=rule, at="2,0"))


# ---- feedback: two laws of the field, sampled ----------------------------------------------------


def test_tangential_rims_track_a_wanted_motion(arrays: Arrays) -> None:
    """Full torque authority: twist tracking decreases V at the rate -2k on every sample (all wheels roll)."""
    scene = ruled(arrays.four_wheel(turn=(0, 1)), "ellipse")
    model = contact_model(scene)
    states = np.random.default_rng(0).uniform(-0.3, 0.3, (40, 3))
    rates = relative_rates(model, Functional.ELLIPSE, SampledLaw.TRACKING, states)
    assert rates.max() < 0
    assert check_theorem4(scene).authority.rank == 3


def test_inward_rims_have_no_torque_about_the_equilibrium(arrays: Arrays) -> None:
    """Tracking asks nothing of any wheel at the turned equilibrium; a law that lets wheels slip does."""
    scene = ruled(arrays.four_wheel(), "ellipse")
    result = check_theorem4(scene)
    assert [[str(x) for x in twist] for twist in result.authority.missing] == [["0", "0", "1"]]
    assert result.feedback.verdict is Feedback.STABILIZABLE
    model = contact_model(scene)
    for functional in Functional:
        assert abs(relative_rates(model, functional, SampledLaw.TRACKING, np.array([[0.0, 0.0, 1.0]]))[0]) < 1e-9


@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_samples_are_taken_where_nothing_is_left_out_and_decide_nothing(
    arrays: Arrays, rule: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nonsmooth.proofs.clauses.feedback.by_friction.STATES", dict.fromkeys(("box", "ellipse"), 2))
    scene = ruled(arrays.four_wheel(), rule)
    pruned, full = check_theorem4(scene), check_theorem4(scene, prune=False)
    assert "samples of the closed loop" in [skipped.what for skipped in pruned.skipped]
    assert isinstance(pruned.feedback, DrivenFeedback)
    assert isinstance(full.feedback, DrivenFeedback)
    assert not pruned.feedback.samples
    assert [sample.law for sample in full.feedback.samples]
    assert pruned.feedback == full.feedback


def with_speeds(law: SampledLaw, p: Floats, d: Floats, state: Floats) -> Floats:
    """u_i at gain one: the nearest two wheels drive, or every rim follows the wanted motion ``-(c, theta)``."""
    c, theta = state[:2], state[2]
    if law is SampledLaw.TRACKING:
        return np.array(
            [d_i @ (-c - theta * np.array([c[1] - p_i[1], p_i[0] - c[0]])) for p_i, d_i in zip(p, d, strict=True)]
        )
    i, j = np.argsort(np.hypot(*(p - c).T))[:2]
    arm, speeds = p[j] - p[i], np.zeros(len(p))
    speeds[j] = -np.sign(d[j] @ np.array([-arm[1], arm[0]])) * theta
    speeds[i] = abs(speeds[j]) + np.hypot(*c)
    return speeds


def rates_of_minimizers(functional: Functional, law: SampledLaw, side: float, state: Floats) -> tuple[float, float]:
    """Least and largest V'/V over the twists that minimize D for the four-wheel array, by CVXPY."""
    import cvxpy as cp

    p = np.array(CORNERS, float)
    d = -p / np.sqrt(2)
    n, speeds = np.column_stack([-d[:, 1], d[:, 0]]), with_speeds(law, p, d, state)
    arms, loads = np.column_stack([-p[:, 1], p[:, 0]]), (1 + p @ state[:2]) / 4
    twist, slips, sizes = cp.Variable(3), cp.Variable((4, 2)), cp.Variable((4, 2))
    roll, across = (np.column_stack([axes, (axes * arms).sum(1)]) @ twist for axes in (d, n))
    constraints = [slips[:, 0] == roll - speeds, slips[:, 1] == side * across]
    if functional is Functional.BOX:
        constraints += [slips <= sizes, -slips <= sizes]
    else:
        constraints += [cp.SOC(sizes[:, 0], slips, axis=1), sizes[:, 1] == 0]
    total, rate = loads @ sizes @ np.ones(2), 2 * (state @ twist) / (state @ state)
    least = cp.Problem(cp.Minimize(total), constraints).solve(solver=cp.CLARABEL)
    ends = (cp.Minimize(rate), cp.Maximize(rate))
    low, high = (cp.Problem(end, [*constraints, total <= least + SLACK]).solve(solver=cp.CLARABEL) for end in ends)
    return float(low), float(high)


@pytest.mark.parametrize("functional", list(Functional))
@pytest.mark.parametrize("law", list(SampledLaw))
def test_worst_states_are_as_bad_by_a_convex_program(arrays: Arrays, functional: Functional, law: SampledLaw) -> None:
    """The law, the loads and D are written out here; where D has many minimizers one of them has the rate."""
    sample = sample_closed_loop(contact_model(arrays.four_wheel((1, Fraction(1, 5)))), functional, law, 0.3, 20)
    assert sample.worst_rate is not None
    assert not sample.not_certified
    low, high = rates_of_minimizers(functional, law, 0.2, np.array(sample.worst_state))
    assert low - RATE_ERROR <= sample.worst_rate <= high + RATE_ERROR
    assert sample.fails
    assert sample.worst_rate >= -RATE_ERROR
