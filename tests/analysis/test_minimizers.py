"""What every minimizer of the dissipation must pass, whichever functional it minimizes and however."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxEnumeration, BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import elastic_loads, loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minima, Minimizer, dissipation
from nonsmooth.analysis.minimizers.sum_of_supports import Solutions, SupportSums, by_holding, by_multipliers
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from tests.four_wheel import CORNERS
from tests.oracles.cvxpy_programs import MINIMIZERS, CvxpyMinimizer, minimizers_of
from tests.oracles.floats import Floats
from tests.thorough import few, keep

FOUR = np.array(CORNERS, float)
SAME_VALUE = 1e-9  # relative: what the least exact minimizer reaches
SAME_TWIST = 1e-5  # relative to the speeds: the reference solvers know D to 1e-11, a twist to its square root
ROUNDING = 1e-10  # of twists and forces of order 1 by the exact minimizers
GAPS = {EllipseMinimizer: 1e-10, BoxHighs: 1e-10, BoxEnumeration: 1e-9, CvxpyMinimizer: 1e-7}  # relative


def label(minimizer: Minimizer) -> str:
    return f"{type(minimizer).__name__}-{minimizer.functional}"


EVERY = pytest.mark.parametrize("minimizer", MINIMIZERS, ids=label)
EXACT = pytest.mark.parametrize("minimizer", [m for m in MINIMIZERS if not isinstance(m, CvxpyMinimizer)], ids=label)


def certified(minima: Minima, minimizer: Minimizer) -> bool:
    return bool(minima.check(GAPS[type(minimizer)]).all())


# ---- arrays ------------------------------------------------------------------------------------


class Case(NamedTuple):
    """An array under normal forces (m, n)."""

    model: ContactModel
    loads: Floats


def four_wheels(mu_roll: float = 1, mu_side: float = 0.5) -> ContactModel:
    return ContactModel.build(FOUR, -FOUR, np.ones(4), (mu_roll, mu_side))


def ring(count: int, friction: tuple[float, float] = (1, 0.5), semi_axes: tuple[float, float] = (1, 1)) -> ContactModel:
    """Wheels on the unit circle, rims along the elliptic field ``(-a x, -b y)``."""
    angles = 2 * np.pi * np.arange(count) / count
    positions = np.column_stack([np.cos(angles), np.sin(angles)])
    return ContactModel.build(positions, -positions * semi_axes, np.ones(count), friction)


def grid(rows: int, columns: int, friction: tuple[float, float] = (1, 0.5)) -> ContactModel:
    """Unit pitch about the origin, rims inward; a wheel at the origin points along x."""
    x, y = np.arange(columns) - (columns - 1) / 2, np.arange(rows) - (rows - 1) / 2
    positions = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    rims = np.where(np.any(positions, axis=1, keepdims=True), -positions, [[1.0, 0.0]])
    return ContactModel.build(positions, rims, np.ones(len(positions)), friction)


def random_array(seed: int, friction: tuple[float, float] | None = None) -> ContactModel:
    """Random places, rims and speeds, a third of which are zero; random friction unless given."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 9))
    speeds = rng.normal(size=count) * (rng.random(count) > 1 / 3)
    own = 10.0 ** rng.uniform(-1, 1, (count, 2)) if friction is None else friction
    return ContactModel.build(rng.normal(size=(count, 2)), rng.normal(size=(count, 2)), speeds, own)


def at_random_points(model: ContactModel, count: int, seed: int = 0) -> Case:
    """Elastic loads at random centres of mass inside the support polygon."""
    weights = np.random.default_rng(seed).dirichlet(np.ones(model.wheels), size=count)
    return Case(model, elastic_loads(model, weights @ model.positions))


def two_isotropic_wheels(first: float, second: float) -> Case:
    """Wheels at (0, 0) and (2, 1) with equal friction both ways and two surface velocities each."""
    model = ContactModel.build([(0, 0), (2, 1)], [(1, 0), (1, 0)], [(1, 0.3), (-0.2, 0.5)], (1, 1))
    return Case(model, np.array([[first, second]], float))


def with_rollers(seed: int) -> ContactModel:
    """A random array with friction discs that are cut, one of them not."""
    model = random_array(seed, (1.0, 1.0))
    cuts = np.random.default_rng(seed).uniform(0.02, 1, model.wheels)
    cuts[-1] = 1.0
    return replace(model, cuts=cuts)


CASES: dict[str, Callable[[], Case]] = {
    "four-wheel": lambda: at_random_points(contact_model(load_scene("four-wheel")), 6),
    "ring-5": lambda: at_random_points(contact_model(load_scene("ring-5")), 6),
    "elliptic": lambda: at_random_points(contact_model(load_scene("elliptic")), 6),
    "spiral-30": lambda: at_random_points(contact_model(load_scene("spiral-30")), 6),
    "grid-3x3": lambda: at_random_points(grid(3, 3), 4),
    "side friction larger": lambda: at_random_points(four_wheels(0.5, 1), 4),
    "a wheel lifts off": lambda: Case(four_wheels(), elastic_loads(four_wheels(), [(0.75, 0.75), (0.9, -0.4)])),
    **{f"rollers-{k}": lambda k=k: at_random_points(with_rollers(k), 4) for k in range(4)},  # type: ignore[misc]
    **{f"random-{k}": lambda k=k: at_random_points(random_array(k), 4) for k in range(6)},  # type: ignore[misc]
}
ARRAYS = pytest.mark.parametrize("case", CASES, indirect=True)


@pytest.fixture
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]()


# ---- every minimizer ---------------------------------------------------------------------------


@few(8)
@EVERY
@ARRAYS
def test_results_prove_themselves(minimizer: Minimizer, case: Case) -> None:
    minima = minimizer.minimize(*case)
    assert len(minima) == len(case.loads)
    assert certified(minima, minimizer)


@few(8)
@EVERY
@ARRAYS
def test_values_agree(minimizer: Minimizer, case: Case) -> None:
    reference = minimizers_of(minimizer.functional)[0].minimize(*case)
    np.testing.assert_allclose(minimizer.minimize(*case).values, reference.values, rtol=SAME_VALUE, atol=1e-14)


@few(8)
@EVERY
@ARRAYS
def test_unique_twists_agree(minimizer: Minimizer, case: Case) -> None:
    minima, reference = minimizer.minimize(*case), minimizers_of(minimizer.functional)[0].minimize(*case)
    for one, other in zip(minima, reference, strict=True):
        assert list(one.faces) == list(other.faces)
        if not one.faces:
            np.testing.assert_allclose(one.twists, other.twists, atol=SAME_TWIST)


@few(8)
@EVERY
@ARRAYS
def test_no_other_twist_dissipates_less(minimizer: Minimizer, case: Case) -> None:
    rng = np.random.default_rng(0)
    steps = rng.normal(size=(300, 3)) * 10.0 ** rng.uniform(-6, 0.5, (300, 1))
    for minimum in minimizer.minimize(*case):
        around = dissipation(minimum.functional, minimum.model, minimum.loads, minimum.twists + steps)
        assert around.min() >= minimum.values[0] * (1 - SAME_VALUE)


@few(8)
@EXACT
@ARRAYS
def test_friction_opposes_slip(minimizer: Minimizer, case: Case) -> None:
    """Complementarity: each wheel's friction takes all the power its slip can lose, ``-f . slip = |weighted slip|``."""
    for minimum in minimizer.minimize(*case):
        (slips,) = case.model.slips(minimum.twists)
        lost = -(minimum.forces[0] * slips).sum(axis=1)
        weighted = case.model.limits(minimum.loads[0]) * slips
        box = minimum.functional is Functional.BOX
        most = np.abs(weighted).sum(axis=1) if box else largest_powers(weighted, case.model.cuts)
        np.testing.assert_allclose(lost, most, atol=ROUNDING)


def largest_powers(weighted: Floats, cuts: Floats) -> Floats:
    """``max f . w`` over the unit disc cut by ``|f_2| <= cut``: at the direction of w, or at a corner of the set."""
    sizes, (along, across) = np.hypot(weighted[:, 0], weighted[:, 1]), np.abs(weighted).T
    corner = np.sqrt(np.maximum(1 - cuts**2, 0)) * along + cuts * across
    return np.where(across <= cuts * sizes, sizes, corner)


@few(8)
@EXACT
@ARRAYS
def test_order_of_the_wheels_does_not_matter(minimizer: Minimizer, case: Case) -> None:
    model, order = case.model, np.random.default_rng(0).permutation(case.model.wheels)
    rows = np.column_stack([2 * order, 2 * order + 1]).reshape(-1)
    shuffled = ContactRows(model.rows[rows], model.targets[rows], model.friction[rows], cuts=model.cuts[order])
    minima, other = minimizer.minimize(*case), minimizer.minimize(shuffled, case.loads[:, order])
    np.testing.assert_allclose(other.values, minima.values, rtol=SAME_VALUE, atol=1e-14)
    for one, two in zip(minima, other, strict=True):
        if not one.faces:
            np.testing.assert_allclose(two.twists, one.twists, atol=SAME_TWIST)


@few(6)
@EXACT
@ARRAYS
def test_a_turned_array_moves_in_the_turned_direction(minimizer: Minimizer, case: Case) -> None:
    """Turned about the origin, v turns along and omega stays."""
    c, s = 0.6, 0.8
    turn = np.array([(c, -s), (s, c)])
    model = case.model
    surface, friction = model.targets.reshape(-1, 2), model.friction.reshape(-1, 2)
    turned = ContactModel.build(model.positions @ turn.T, model.rims @ turn.T, surface, friction)
    turned = replace(turned, cuts=model.cuts)
    minima, other = minimizer.minimize(*case), minimizer.minimize(turned, case.loads)
    np.testing.assert_allclose(other.values, minima.values, rtol=SAME_VALUE, atol=1e-14)
    for one, two in zip(minima, other, strict=True):
        if not one.faces:
            (twist,) = one.twists
            np.testing.assert_allclose(two.twists[0], np.r_[turn @ twist[:2], twist[2]], atol=SAME_TWIST)


@EXACT
@pytest.mark.parametrize(("length", "speed", "weight"), [(1e3, 1, 1), (1e-3, 1e6, 1e3), (1, 1e-9, 1e-6)])
def test_units_do_not_matter(minimizer: Minimizer, length: float, speed: float, weight: float) -> None:
    model, loads = at_random_points(random_array(3), 3)
    surface = speed * model.targets.reshape(-1, 2)
    scaled = ContactModel.build(length * model.positions, model.rims, surface, model.friction.reshape(-1, 2))
    minima, other = minimizer.minimize(model, loads), minimizer.minimize(scaled, weight * loads)
    assert certified(other, minimizer)
    np.testing.assert_allclose(other.values, speed * weight * minima.values, rtol=SAME_VALUE)
    np.testing.assert_allclose(other.twists * [1, 1, length] / speed, minima.twists, atol=SAME_TWIST)


# ---- closed forms ------------------------------------------------------------------------------


@EVERY
@pytest.mark.parametrize("heavy", range(4))
def test_a_dominating_wheel_sticks(minimizer: Minimizer, heavy: int) -> None:
    """Its smallest limit, ``mu_S N_i``, exceeds what all others can push together."""
    loads = np.full((1, 4), 0.04)
    loads[0, heavy] = 0.88
    minima = minimizer.minimize(four_wheels(1, 0.5), loads)
    assert certified(minima, minimizer)
    np.testing.assert_allclose(minima.model.slips(minima.twists[0])[heavy], 0, atol=SAME_TWIST)


@pytest.mark.parametrize("minimizer", minimizers_of(Functional.BOX), ids=label)
@pytest.mark.parametrize("ratio", [0.5, 0.2, 0.1])
def test_four_wheels_rest_near_the_origin(minimizer: Minimizer, ratio: float) -> None:
    """Box functional: rest iff ``|x| + |y| <= mu_S/mu_R``."""
    rng, model = np.random.default_rng(0), four_wheels(1, ratio)
    points = rng.uniform(-0.5, 0.5, (20, 2))
    moves = np.abs(minimizer.minimize(model, loads_at(model, points)).twists).max(axis=1) > SAME_TWIST
    np.testing.assert_array_equal(moves, np.abs(points).sum(axis=1) > ratio)


@pytest.mark.parametrize("minimizer", minimizers_of(Functional.ELLIPSE), ids=label)
@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0])
def test_four_wheels_settle_exponentially(minimizer: Minimizer, ratio: float) -> None:
    """Ellipse functional: ``c' = -sqrt(2) (mu_R/mu_S)^2 c`` to first order, with ``c' = v + omega J c``."""
    model, small = four_wheels(1, ratio), 1e-3
    points = small * np.array([(1, 0), (0, -1), (0.6, 0.8)])
    twists = minimizer.minimize(model, elastic_loads(model, points)).twists
    rates = twists[:, :2] + twists[:, 2:] * np.column_stack([-points[:, 1], points[:, 0]])
    np.testing.assert_allclose(rates, -np.sqrt(2) / ratio**2 * points, atol=SAME_TWIST)


@pytest.mark.parametrize("minimizer", minimizers_of(Functional.ELLIPSE), ids=label)
def test_two_isotropic_wheels(minimizer: Minimizer) -> None:
    minima = minimizer.minimize(*two_isotropic_wheels(1, 2))
    assert certified(minima, minimizer)
    assert minima.values[0] == pytest.approx(0.98387, abs=5e-6)
    assert minima.twists[0, 2] == pytest.approx(0.32, abs=SAME_TWIST)
    assert not minima.faces


@pytest.mark.parametrize("minimizer", minimizers_of(Functional.ELLIPSE), ids=label)
def test_equal_isotropic_wheels_leave_a_segment(minimizer: Minimizer) -> None:
    """Slips are parallel and opposite: at either end of the segment one wheel sticks."""
    case = two_isotropic_wheels(1, 1)
    minimum = minimizer.minimize(*case)
    assert certified(minimum, minimizer)
    face = minimum.faces[0]
    assert len(face) == 2
    np.testing.assert_allclose(face[:, 2], 0.32, atol=SAME_TWIST)
    slips = np.hypot(*np.moveaxis(case.model.slips(face), -1, 0))
    np.testing.assert_allclose(np.sort(slips, axis=1)[:, 0], 0, atol=SAME_TWIST)
    assert sorted(slips.argmin(axis=1)) == [0, 1]


@EVERY
def test_weighted_median(minimizer: Minimizer) -> None:
    """One unknown, weights 3, 2, 2 on speeds 0, 1, 1: the minimizer is 1, though 3 is the largest weight."""
    rows = np.tile([(1.0, 0, 0), (0, 1, 0)], (3, 1))
    model = ContactRows(rows, np.array([0.0, 0, 1, 0, 1, 0]), np.tile([1.0, 1.0], 3))
    if isinstance(minimizer, BoxEnumeration):
        with pytest.raises(ValueError, match="three independent"):
            minimizer.minimize(model, [(3, 2, 2)])
        return
    minima = minimizer.minimize(model, [(3, 2, 2)])
    assert certified(minima, minimizer)
    np.testing.assert_allclose(minima.values, 3, rtol=SAME_VALUE)
    np.testing.assert_allclose(minima.twists, [(1, 0, 0)], atol=SAME_TWIST)


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "elliptic"])
def test_box_minimizer_moves_as_the_exact_cells_say(name: str) -> None:
    scene = load_scene(name, rule="box")
    model, rng = contact_model(scene), np.random.default_rng(0)
    for cell in build_box_partition(scene).cells:
        vertices = np.array([[float(x) for x in vertex] for vertex in cell.polygon.vertices])
        points = rng.dirichlet(np.ones(len(vertices)), size=3) @ vertices
        exact = [[float(x) for x in twist] for twist in cell.twists]
        np.testing.assert_allclose(BoxHighs().minimize(model, loads_at(model, points)).twists, exact * 3, atol=ROUNDING)


# ---- Theorem 2: faces --------------------------------------------------------------------------


def square_face() -> Case:
    """Two wheels of equal weight in one place that want (0, 0) and (1, 1), a third holds the rotation."""
    rows = np.array([(1, 0, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1)], float)
    model = ContactRows(rows, np.array([0.0, 0, 1, 1, 0, 0]), np.ones(6))
    return Case(model, np.ones((1, 3)))  # type: ignore[arg-type]


FACES: dict[str, Callable[[], Case]] = {
    "square": square_face,
    "two wheels": lambda: two_isotropic_wheels(1, 1),
    "edge of the rest area": lambda: Case(four_wheels(), elastic_loads(four_wheels(), [(0.25, 0.25), (0.3, -0.2)])),
    "corner of the rest area": lambda: Case(four_wheels(), elastic_loads(four_wheels(), [(0.5, 0)])),
    "one constraint more": lambda: Case(four_wheels(1, 0.2), elastic_loads(four_wheels(), [(0.2, 0), (0.3, 0.3)])),
}


@few(6)
@EVERY
@pytest.mark.parametrize("name", FACES)
def test_all_points_of_a_face_dissipate_the_same(minimizer: Minimizer, name: str) -> None:
    """Theorem 2, with the vertices found by the oracle of the same functional."""
    case, rng = FACES[name](), np.random.default_rng(0)
    minima, reference = minimizer.minimize(*case), minimizers_of(minimizer.functional)[-2].minimize(*case)
    assert certified(minima, minimizer)
    for minimum, other in zip(minima, reference, strict=True):
        assert list(minimum.faces) == list(other.faces)
        for face in minimum.faces.values():
            mixtures = rng.dirichlet(np.ones(len(face)), size=20) @ face
            values = dissipation(minimum.functional, case.model, minimum.loads, mixtures)
            np.testing.assert_allclose(values, minimum.values[0], rtol=SAME_VALUE)
            assert_same_points(face, other.faces[0])


def assert_same_points(first: Floats, second: Floats) -> None:
    assert len(first) == len(second)
    distances = np.abs(first[:, None] - second[None]).max(axis=2)
    assert distances.min(axis=0).max() < SAME_TWIST
    assert distances.min(axis=1).max() < SAME_TWIST


def test_faces_of_the_square_example() -> None:
    """Box: all of [0, 1]^2; ellipse: its diagonal."""
    case = square_face()
    box, ellipse = (minimizers_of(functional)[0].minimize(*case).faces[0] for functional in Functional)
    assert_same_points(box, np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], float))
    assert_same_points(ellipse, np.array([(0, 0, 0), (1, 1, 0)], float))


# ---- degenerate and extreme --------------------------------------------------------------------


@EVERY
def test_wheels_at_rest_hold_the_body(minimizer: Minimizer) -> None:
    model = ContactModel.build(FOUR, -FOUR, np.zeros(4), (1, 0.5))
    minima = minimizer.minimize(model, np.full((2, 4), 0.25))
    assert certified(minima, minimizer)
    np.testing.assert_allclose(minima.twists, 0, atol=SAME_TWIST)
    np.testing.assert_allclose(minima.values, 0, atol=1e-9)


@EVERY
def test_a_rigid_motion_that_all_wheels_want_costs_nothing(minimizer: Minimizer) -> None:
    wanted = np.array([0.3, -0.2, 0.5])
    positions = np.random.default_rng(0).normal(size=(5, 2))
    velocities = wanted[:2] + wanted[2] * np.column_stack([-positions[:, 1], positions[:, 0]])
    model = ContactModel.build(positions, velocities, np.hypot(*velocities.T), (1, 0.5))
    minima = minimizer.minimize(model, np.full((1, 5), 0.2))
    np.testing.assert_allclose(minima.twists, [wanted], atol=SAME_TWIST)
    np.testing.assert_allclose(minima.values, 0, atol=1e-9)


def test_slips_that_are_rounding_prove_that_nothing_slips() -> None:
    """With a gap of that size, beside a sum of that size: further passes would find the same."""
    angles = np.array([0.1, 1.2, 3.5])
    maps = np.array([[(1, 0, -np.sin(angle)), (0, 1, np.cos(angle))] for angle in angles])
    wanted = np.array([0.3, -0.2, -np.sqrt(3) / 2])
    sums = SupportSums(np.ones((3, 1)), maps, (maps @ wanted).T[..., None], UnitDiscs(np.ones(3)))
    for error, proved in ((1e-16, True), (1e-13, False)):
        slips = sums.slips(wanted[:, None] + error)
        assert np.abs(slips).max() > 0
        assert sums.judge(slips, np.zeros((2, 3, 1))).proved == proved


def test_slips_beyond_floats_prove_nothing() -> None:
    """Their squares are infinite, and so is the gap that is allowed beside the sum."""
    maps = np.array([[(1.0, 0, -1), (0, 1, 1)], [(1, 0, 2), (0, 1, 1)]])
    sums = SupportSums(np.ones((2, 1)), maps, np.ones((2, 2, 1)), UnitDiscs(np.ones(2)))
    with np.errstate(all="ignore"):
        assert not sums.judge(sums.slips(np.full((3, 1), 1e200)), np.zeros((2, 2, 1))).proved.any()


@pytest.mark.parametrize("sticking", [0, 1])
def test_holding_finds_a_minimizer_that_is_known_beforehand(sticking: int) -> None:
    """The pull is what forces at chosen slips balance; of a contact that sticks any force in the disc."""
    rng = np.random.default_rng(5 + sticking)
    count, contacts = 200, 5
    maps = rng.normal(size=(contacts, 2, 3))
    wanted, weights = rng.normal(size=(3, count)), rng.uniform(0.2, 1, (contacts, count))
    slips = rng.normal(size=(2, contacts, count))
    forces = slips / np.hypot(*slips)
    slips[:, :sticking] = 0.0
    forces[:, :sticking] *= rng.uniform(0, 0.95, (sticking, count))
    pulls = np.einsum("im,ikj,kim->jm", weights, maps, forces)
    targets = np.moveaxis(maps @ wanted, 0, 1) - slips
    sums = SupportSums(weights, maps, targets, UnitDiscs(np.ones(contacts)), pulls)
    found = Solutions(contacts, count)
    with np.errstate(all="ignore"):
        by_holding(found, np.arange(count), sums, wanted + 0.02 * rng.normal(size=(3, count)))
    assert found.proved.mean() > 0.9  # others are left to the methods that follow
    np.testing.assert_allclose(found.y[:, found.proved], wanted[:, found.proved], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("minimizer", [m for m in MINIMIZERS if not isinstance(m, BoxEnumeration)], ids=label)
def test_one_loaded_wheel(minimizer: Minimizer) -> None:
    """The body may turn about it: no dissipation, and the wheel sticks.

    Of a vanishing D the reference solvers know no relative gap, so only the exact minimizers prove it.
    """
    minima = minimizer.minimize(four_wheels(), [(0, 1, 0, 0)])
    assert isinstance(minimizer, CvxpyMinimizer) or certified(minima, minimizer)
    np.testing.assert_allclose(minima.values, 0, atol=1e-8)
    np.testing.assert_allclose(minima.model.slips(minima.twists[0])[1], 0, atol=SAME_TWIST)


RATIOS = pytest.mark.parametrize("ratio", [1e-3, 1e-2, 0.1, 0.5, 1, 2, 10, 1e2, 1e3])


@few(1)
@pytest.mark.parametrize("points", keep(1, [100, 1000]))
@RATIOS
def test_on_rings_grids_and_random_arrays(ratio: float, points: int) -> None:
    """Gap below 1e-10, and D no more than CVXPY's best plus 1e-9 of it."""
    models = [ring(count, (1, ratio)) for count in range(3, 9)] + [ring(6, (1, ratio), (1, 2))]
    models += [grid(2, 3, (1, ratio)), grid(4, 4, (1, ratio)), grid(6, 6, (1, ratio))]
    models += [random_array(seed, (1, ratio)) for seed in range(4)]
    reference = CvxpyMinimizer(Functional.ELLIPSE)
    for seed, model in enumerate(models):
        _, loads = at_random_points(model, points, seed)
        minima = EllipseMinimizer().minimize(model, loads)
        assert minima.check(1e-10).all()
        best = reference.minimize(model, loads[:2]).values
        assert (minima.values[:2] <= best * (1 + 1e-9)).all()


@few(2)
@pytest.mark.parametrize("exponent", range(-12, 13, 3))
@pytest.mark.parametrize("seed", range(4))
def test_at_extreme_friction(exponent: int, seed: int) -> None:
    model, loads = at_random_points(random_array(seed, (1, 10.0**exponent)), 50, seed)
    assert EllipseMinimizer().minimize(model, loads).check(1e-9).all()


@few(1)
@pytest.mark.parametrize("seed", range(6))
def test_at_extreme_loads_places_and_speeds(seed: int) -> None:
    """Loads over twelve decades, a wheel array far from the origin, thin, or with speeds over many decades."""
    rng, model = np.random.default_rng(seed), random_array(seed)
    surface, friction = model.targets.reshape(-1, 2), model.friction.reshape(-1, 2)

    def moved(positions: Floats) -> ContactModel:
        return ContactModel.build(positions, model.rims, surface, friction)

    wide = 10.0 ** rng.uniform(-12, 0, (30, model.wheels))
    even = rng.dirichlet(np.ones(model.wheels), size=30)
    speeds = 10.0 ** rng.uniform(-9, 9, model.wheels)
    for other, loads in [
        (model, wide),
        (moved(model.positions + 1e4), even),
        (moved(model.positions * [1, 1e-5]), even),
        (ContactModel.build(model.positions, model.rims, speeds, friction), even),
    ]:
        assert EllipseMinimizer().minimize(other, loads).check(1e-9).all()


@few(2)
@pytest.mark.parametrize("seed", range(5))
def test_multipliers_alone_reach_the_same(seed: int) -> None:
    """From nothing, without the smoothing that starts them, and with the same proof."""
    model, loads = at_random_points(random_array(seed), 100, seed)
    minima = EllipseMinimizer().minimize(model, loads)
    speed = np.abs(model.friction * model.targets).max()
    maps = (model.friction[:, None] * model.rows).reshape(-1, 2, 3)
    targets = (model.friction * model.targets / speed).reshape(-1, 2)
    sums = SupportSums(loads.T, maps, targets.T[..., None], UnitDiscs(model.cuts))
    start = np.zeros((3, len(loads))), np.zeros((2, model.wheels, len(loads))), np.full(len(loads), 10.0)
    alone = by_multipliers(sums, *start)
    assert alone.proved.all()
    np.testing.assert_allclose(speed * alone.y.T, minima.twists, atol=1e-7)


# ---- results -----------------------------------------------------------------------------------


@pytest.fixture
def minimum() -> Minima:
    return EllipseMinimizer().minimize(four_wheels(), elastic_loads(four_wheels(), [(0.2, 0.1)]))


@pytest.mark.parametrize(
    "forge",
    [
        lambda m: replace(m, twists=m.twists + np.array([1e-3, 0, 0])),
        lambda m: replace(m, twists=m.twists * np.nan),
        lambda m: replace(m, forces=1.001 * m.forces),
        lambda m: replace(m, forces=0.999 * m.forces),
        lambda m: replace(m, forces=m.forces + 1e-6 * np.eye(4)[:, :2]),
        lambda m: replace(m, forces=np.zeros_like(m.forces)),
        lambda m: replace(m, loads=m.loads * [1, 1, 1, 0.5]),
        lambda m: replace(m, functional=Functional.BOX),
        lambda m: replace(m, faces={0: np.concatenate([m.twists, m.twists + np.array([0, 0, 0.1])])}),
        lambda m: replace(m, faces={0: m.twists}),
    ],
)
def test_forged_results_fail(minimum: Minima, forge: Callable[[Minima], Minima]) -> None:
    assert minimum.check()[0]
    assert not forge(minimum).check()[0]


def test_many_results_are_a_sequence() -> None:
    model, loads = at_random_points(four_wheels(), 5)
    minima = EllipseMinimizer().minimize(model, loads)
    assert len(minima) == len(list(minima)) == 5
    np.testing.assert_array_equal(minima[-1].twists[0], minima.twists[4])
    np.testing.assert_allclose([m.values[0] for m in minima], minima.values, rtol=1e-15)
    np.testing.assert_allclose([m.gaps[0] for m in minima], minima.gaps, atol=1e-15)
    with pytest.raises(IndexError):
        minima[5]


@pytest.mark.parametrize("points", keep(1, [4000, 9000]))
def test_points_do_not_depend_on_their_company(points: int) -> None:
    """Thousands of points go through several blocks; each result is that of the point alone."""
    model, loads = at_random_points(random_array(2), points)
    together = EllipseMinimizer().minimize(model, loads)
    assert together.check(1e-10).all()
    for k in (0, points // 2, points - 1):
        alone = EllipseMinimizer().minimize(model, loads[k])
        np.testing.assert_allclose(together.twists[k], alone.twists[0], atol=ROUNDING)


def test_no_points() -> None:
    minima = EllipseMinimizer().minimize(four_wheels(), np.empty((0, 4)))
    assert len(minima) == 0
    assert minima.check().shape == (0,)


def test_lighter_loads_dissipate_less() -> None:
    """D is linear in the loads."""
    model, loads = at_random_points(random_array(1), 1)
    values = EllipseMinimizer().minimize(model, np.outer([1, 2, 3, 10], loads[0])).values
    assert all(a < b for a, b in pairwise(values))
    np.testing.assert_allclose(values, values[0] * np.array([1, 2, 3, 10]), rtol=1e-12)


@EVERY
@pytest.mark.parametrize(
    ("loads", "expected"),
    [([1, 2, 3], "shape"), ([[1, 1, 1, -1]], ">= 0"), ([[1, 1, 1, np.nan]], "finite"), ([[[1, 1, 1, 1]]], "shape")],
)
def test_loads_are_validated(minimizer: Minimizer, loads: list[float], expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        minimizer.minimize(four_wheels(), loads)


def test_enumeration_refuses_large_arrays() -> None:
    with pytest.raises(ValueError, match="at most 40 wheels"):
        BoxEnumeration().minimize(grid(7, 7), np.ones((1, 49)))


def test_large_forces_that_nearly_cancel_prove_nothing_about_a_small_dissipation() -> None:
    """Wheels that carry the body dissipate nothing; at mu_S/mu_R = 1e12 rest was once certified in its place."""
    scene = with_friction_ratio(load_scene("conveyor-3"), Fraction(10**12))
    model = contact_model(scene)
    found = BoxHighs().minimize(model, loads_at(model, [[0.1, 0.05]]))
    turning = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]  # the rims are tangential
    carried = dissipation(Functional.BOX, model, found.loads[0], turning).min()
    assert carried <= 1e-3
    assert found.values[0] <= 1e-3 or not found.check()[0]
    rest = replace(found, twists=np.zeros((1, 3)))
    assert rest.values[0] == pytest.approx(1)
    assert not rest.check()[0]
