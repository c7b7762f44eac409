"""Rule ``roller``, and Newton's method on the regimes of its contacts."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import nonsmooth as ns
from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.bodies.set_motion import DraggedMinimizer, SetMotion, with_drag
from nonsmooth.analysis.cells.contact_rule import contact_rule, smooth_rule_of
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, minima_under
from nonsmooth.analysis.minimizers.float_loads import elastic_loads, loads_at
from nonsmooth.analysis.minimizers.many_twists import MovingTwists
from nonsmooth.analysis.minimizers.minimum import Functional, dissipation
from nonsmooth.analysis.minimizers.smooth_newton import CutNewton, SmoothNewton, smallest_forces
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.scene import Friction
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.thorough import few, keep

# ---- Rule ``roller``: D against the rolling that it is made of, its minimizers under symmetries, and its paths.

PAIRS = [(1.0, 0.02), (1.0, 0.3), (0.7, 0.69), (2.0, 0.5)]  # (mu_R, mu_S)


def of_rolling(roll: float, side: float, r: float, s: float) -> float:
    """``min over t of mu_R |(r, s - t)| + mu_S |t|`` by a general-purpose minimizer between the kinks."""

    def lost(t: float) -> float:
        return roll * float(np.hypot(r, s - t)) + side * abs(t)

    span = (min(0.0, s), max(0.0, s))
    found = minimize_scalar(lost, bounds=span, method="bounded", options={"xatol": 1e-13})
    return min(float(found.fun), lost(0.0), lost(s))


def size_of(weighted: Floats, cuts: Floats) -> Floats:
    """The dissipation per unit of load and limit, of slips in units of the half-axes."""
    return np.asarray(CutEllipse.units(cuts).support(*np.moveaxis(weighted, -1, 0)))


@few(2)
@pytest.mark.parametrize("friction", PAIRS)
def test_the_dissipation_is_that_of_contact_and_rolling(friction: tuple[float, float]) -> None:
    roll, side = friction
    slips = np.random.default_rng(1).normal(size=(300, 2))
    found = size_of(roll * slips, np.array(side / roll))
    expected = [of_rolling(roll, side, r, s) for r, s in slips]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    angle = side / np.sqrt(roll**2 - side**2)
    turning = np.abs(slips[:, 1]) > angle * np.abs(slips[:, 0])
    assert 0 < turning.sum() < len(slips)
    np.testing.assert_allclose(found[~turning], roll * np.hypot(*slips[~turning].T), rtol=1e-14)


@pytest.mark.parametrize(
    ("roll", "side", "axes", "cut"),
    [(1, 2, (1, 1), 1), (1, 1, (1, 1), 1), (2, 1, (2, 2), Fraction(1, 2)), (3, 0, (3, 0), 1), (0, 1, (0, 0), 1)],
)
def test_the_friction_set(roll: int, side: int, axes: tuple[int, int], cut: Fraction | int) -> None:
    """The disc cut by the strip; whole where bearings hold more, a segment without bearing friction."""
    field = NumberField()
    found = contact_rule("roller").friction_set(Friction(field(roll), field(side)))  # type: ignore[union-attr]
    assert (found.along, found.across, found.cut) == (*axes, cut)


def random_rollers(seed: int) -> tuple[ContactModel, Floats]:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 8))
    wheels = ContactModel.build(
        rng.normal(size=(count, 2)), rng.normal(size=(count, 2)), rng.normal(size=count), (1.0, 1.0)
    )
    wheels = replace(wheels, cuts=rng.uniform(0.05, 0.9, count))
    return wheels, elastic_loads(wheels, rng.dirichlet(np.ones(count), size=20) @ wheels.positions)


@pytest.mark.parametrize("seed", range(6))
def test_forces_are_the_gradient_where_rims_slip(seed: int) -> None:
    """Minus the gradient of each wheel's term by its slips is its force, by differences."""
    wheels, loads = random_rollers(seed)
    minima = EllipseMinimizer().minimize(wheels, loads)
    slips, step = wheels.slips(minima.twists), 1e-7
    moved = (
        np.stack([slips + step * np.eye(2)[k] for k in range(2)]),
        np.stack([slips - step * np.eye(2)[k] for k in range(2)]),
    )
    sizes = [size_of(part, wheels.cuts) for part in moved]
    slopes = loads[..., None] * np.moveaxis((sizes[0] - sizes[1]) / (2 * step), 0, -1)
    slipping = np.abs(slips[..., 0]) > 1e-4
    assert slipping.any()
    np.testing.assert_allclose(minima.forces[slipping], -slopes[slipping], atol=1e-5)


@pytest.mark.parametrize("seed", range(6))
def test_no_twist_dissipates_less(seed: int) -> None:
    wheels, loads = random_rollers(seed)
    minima = EllipseMinimizer().minimize(wheels, loads)
    assert minima.check(1e-12).all()
    near = minima.twists + 1e-3 * np.random.default_rng(seed).normal(size=(50, 1, 3))
    assert (dissipation(Functional.ELLIPSE, wheels, loads, near) >= minima.values * (1 - 1e-13)).all()


@pytest.mark.parametrize("seed", range(6))
def test_the_twists_of_many_paths_are_minimizers_where_some_wheels_have_no_rollers(seed: int) -> None:
    wheels, loads = random_rollers(seed)
    wheels = replace(wheels, cuts=np.where(np.arange(wheels.wheels) % 2, 1.0, wheels.cuts))
    minima, paths = EllipseMinimizer().minimize(wheels, loads), np.arange(len(loads))
    moving = MovingTwists(wheels, len(loads))
    moving.remember(minima.twists, paths)
    twists, settled = moving.at(loads @ wheels.positions, paths)
    assert settled.any()
    found = dissipation(Functional.ELLIPSE, wheels, loads, twists)
    np.testing.assert_allclose(found[settled], minima.values[settled], rtol=1e-3)


@few(1)
@pytest.mark.parametrize("seed", range(4))
def test_mirrored_turned_and_faster_arrays_move_alike(seed: int) -> None:
    wheels, loads = random_rollers(seed)
    twists = EllipseMinimizer().minimize(wheels, loads).twists
    speeds = wheels.speeds

    def minimizers(positions: Floats, rims: Floats, surface: Floats) -> Floats:
        other = replace(ContactModel.build(positions, rims, surface, (1.0, 1.0)), cuts=wheels.cuts)
        return EllipseMinimizer().minimize(other, loads).twists

    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = minimizers(wheels.positions @ turn.T, wheels.rims @ turn.T, speeds)
    np.testing.assert_allclose(turned[:, :2], twists[:, :2] @ turn.T, atol=1e-9)
    np.testing.assert_allclose(turned[:, 2], twists[:, 2], atol=1e-9)
    flip = np.array([1.0, -1.0])
    mirrored = minimizers(wheels.positions * flip, wheels.rims * flip, speeds)
    np.testing.assert_allclose(mirrored, twists * [1, -1, -1], atol=1e-9)
    np.testing.assert_allclose(minimizers(wheels.positions, -wheels.rims, -speeds), twists, atol=1e-9)
    np.testing.assert_allclose(minimizers(wheels.positions, wheels.rims, 3 * speeds), 3 * twists, atol=1e-8)


def test_bearings_that_hold_make_it_rule_ellipse_with_equal_friction() -> None:
    scene = with_friction_ratio(load_scene("elliptic", rule="roller"), Fraction(2))
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 2))
    equal = with_friction_ratio(load_scene("elliptic", rule="ellipse"), Fraction(1))
    found, expected = (minima_under(smooth_rule_of(one), one, points) for one in (scene, equal))
    np.testing.assert_array_equal(found.twists, expected.twists)
    assert "never turn" in smooth_rule_of(scene).remark(scene)


def test_cuts_are_checked() -> None:
    rows, free = np.zeros((2, 3)), np.zeros(2)
    for cuts in ([0.0], [1.5], [0.5, 0.5], [np.nan]):
        with pytest.raises(ValueError, match="cuts above 0 and at most 1"):
            ContactRows(rows, free, free, cuts=np.array(cuts))


@pytest.mark.parametrize("ratio", keep(1, [Fraction(1, 2), Fraction(1, 50)]))
def test_a_path_slides_home_where_the_twist_jumps(ratio: Fraction) -> None:
    """Easy rollers: box-like jumps far from the point, and the exact linearization close to it."""
    scene = with_friction_ratio(load_scene("four-wheel", rule="roller"), ratio)
    path = smooth_path(smooth_rule_of(scene), scene, (0.2, 0.13, 0.0), 4.0)
    distances = np.hypot(*path.sample(np.linspace(0, 4, 40))[:, :2].T)
    assert (np.diff(distances) < 0).all()
    late = path.sample(np.array([3.0, 4.0]))
    shrunk = np.hypot(*late[1, :2]) / np.hypot(*late[0, :2])
    assert shrunk == pytest.approx(np.exp(-np.sqrt(2)), rel=1e-2)


def test_a_path_has_the_twist_of_the_rule() -> None:
    """The drag changes it by a millionth or so."""
    scene = load_scene("elliptic", rule="roller")
    rule = smooth_rule_of(scene)
    path = smooth_path(rule, scene, (0.2, 0.13, 0.0), 0.2)
    model = contacts_under(rule, scene)
    for t in (0.05, 0.1, 0.15):
        before, here, after = path.sample(np.array([t - 1e-3, t, t + 1e-3]))
        (twist,) = EllipseMinimizer().minimize(model, loads_at(model, here[None, :2])).twists
        rate = twist + twist[2] * np.array([-here[1], here[0], 0.0])
        np.testing.assert_allclose((after - before) / 2e-3, rate, atol=1e-4)


def test_drag_knows_no_origin_and_draws_one_of_several_solutions() -> None:
    """Beside the line of symmetry the twist jumps away from it: on it bodies may turn either way."""
    rims = [[1.0, 3**0.5], [-1.0, 3**0.5], [1.0, 0.0], [-1.0, 0.0]]
    places = np.array([[-75.0, -150.0], [75.0, -150.0], [-75.0, 0.0], [75.0, 0.0]])
    loads = np.array([2.0, 2.0, 5.0, 5.0]) / 14
    for middle in ([0.0, 0.0], [225.0, 150.0]):
        wheels = ContactModel.build(places + middle, rims, np.full(4, 300.0), (1.0, 1.0))
        twist = DraggedMinimizer(replace(wheels, cuts=np.full(4, 0.03))).minimize(loads)
        assert twist is not None
        np.testing.assert_allclose(twist, [0.0, 200 * 3**0.5, 0.0], atol=1e-5)
    scene = load_scene("four-wheel", rule="roller")
    assert smooth_path(smooth_rule_of(scene), scene, (0.2, 0.13, 0.0), 0.01).unique is None


# ---- Newton's method beside contacts that stick, against the method of multipliers; slopes of regimes as
# differences.

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
        between = np.array([with_drag((1 - share) * ends[0] + share * ends[1]) for share in np.linspace(0, 1, 21)])
        for loads, expected in zip(between, EllipseMinimizer().minimize(model, between).twists, strict=True):
            twist = newton.minimize(loads)
            if twist is None:
                newton.start_from(expected)
                continue
            found += 1
            rolls += int((np.abs(model.slips(twist)[:rollers, 0]) < SAME).any())
            assert np.abs(twist - expected).max() < DRAGGED
    assert found > 60
    assert rolls > 20


def test_newtons_method_goes_on_where_multipliers_end_beside_a_kink() -> None:
    """On these wheels a body spins so fast that the slip of one, near zero beside the others, is lost in rounding."""
    places, headings = [(300, 0), (150, 150), (300, 150), (450, 150), (150, 300)], (120, 0, 180, 180, -60)
    wheels = [ns.Wheel(place, heading=f"{turn} deg", speed=300) for place, turn in zip(places, headings, strict=True)]
    scene = ns.Array(wheels, mu_roll="7/10", mu_side="1/50", rule="roller", at=(240, 140), radius=1).scene
    pose = np.array([241.64969563, 136.01943797, -0.5109944])
    motion = SetMotion(contacts_under(smooth_rule_of(scene), scene), pose)
    rate, before = (motion.rate(place) for place in (pose, pose - [1e-3, 0.0, 0.0]))
    assert rate[2] == pytest.approx(-29.85640646, rel=1e-6)
    assert before == pytest.approx(rate, rel=1e-3)


def test_wheels_with_their_rims_on_one_line_hold_together() -> None:
    """Their forces are told by no equation alone."""
    places, rims = [[-1, 0], [1, 0], [0, 1], [0, -1]], [[1, 0], [1, 0], [1, 0], [0, 1]]
    wheels = ContactModel.build(places, rims, np.array([1.0, 1.0, 0.2, 0.5]), (1.0, 1.0))
    model = DraggedMinimizer(replace(wheels, cuts=np.full(4, 0.05))).dragged
    loads = np.array([with_drag(np.array([0.4 - shift, 0.3 + shift, 0.15, 0.15])) for shift in (0.0, 0.01, 0.1)])
    expected, newton = EllipseMinimizer().minimize(model, loads).twists, CutNewton(model)
    newton.start_from(expected[0])
    for own, twist in zip(loads, expected, strict=True):
        found = newton.minimize(own)
        assert found is not None
        assert (newton._sides[:2, 0] == 0).all()
        np.testing.assert_allclose(found, twist, atol=1e-9)


def test_a_slip_on_the_wrong_side_that_a_step_does_not_change_turns_at_once() -> None:
    model = replace(model_of(0, 0), cuts=np.full(7, 0.1))
    newton = CutNewton(model)
    newton.start_from(EllipseMinimizer().minimize(model, np.full((1, 7), 1 / 7)).twists[0])
    slips = -np.where(newton._sides == 0, 1.0, newton._sides)
    assert newton._first_turned(slips, np.zeros(3), np.full(7, True)) == (0.0, 0, 0)


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


def test_a_slip_off_its_side_leaves_it_in_a_step_that_changes_nothing() -> None:
    """Without a division by zero, of which users were warned while bodies crossed the edges of wheels."""
    newton, slips = CutNewton(contact_model(load_scene("four-wheel", rule="roller"))), np.zeros((4, 2))
    newton._sides, slips[2, 1] = np.zeros((4, 2)), 0.5
    newton._sides[2, 1] = -1
    assert newton._first_turned(slips, np.zeros(3), np.ones(4, bool)) == (0.0, 2, 1)
