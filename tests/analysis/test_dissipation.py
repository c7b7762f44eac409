"""The dissipation functional and its least values, against definitions, 100 digits and forces that prove them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import cvxpy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.analysis.bodies.newton_euler import EllipseFriction
from nonsmooth.analysis.bodies.path import ellipse_path
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model
from nonsmooth.analysis.measurements.cases import RATIOS
from nonsmooth.analysis.measurements.studies import ellipse_references
from nonsmooth.analysis.minimizers.agreement import PointLocator, compare_rules
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import (
    GAP,
    Functional,
    Minima,
    Minimizer,
    balance_forces,
    dissipation,
    free_motions,
    imbalance,
    input_power,
    minima_without_proof,
    proved,
    share_of_limit,
    usage,
)
from nonsmooth.analysis.minimizers.sampling import SampledLaw, greedy_twist, sample_smooth_derivative
from nonsmooth.analysis.motion.frames import wheel_slips
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.clauses.feedback.by_friction import with_samples
from nonsmooth.proofs.theorem4 import SmoothCheck, check_smooth, check_theorem4
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import constraint_matrix
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import with_friction_ratio
from tests.conftest import Arrays, Pair, WheelData
from tests.oracles.cvxpy_programs import MINIMIZERS
from tests.oracles.floats import Floats
from tests.oracles.least_dissipation import ReferenceMinimization
from tests.thorough import few, keep

# ---- The dissipation functional: its two readings by hand, their convexity, and the duality bound.

ROUNDING = 1e-13  # relative, of sums of a few dozen terms
BOTH = pytest.mark.parametrize("functional", Functional)

entries = st.floats(-5, 5, allow_subnormal=False)
twists = st.tuples(entries, entries, entries).map(np.array)


@pytest.fixture
def two_wheels() -> ContactModel:
    """Rims along x and along y, frictions 1 and 1/2, speeds 1 and 2."""
    return ContactModel.build([(0, 0), (2, 0)], [(3, 0), (0, 5)], [1, 2], (1, 0.5))


def random_model(seed: int, count: int) -> ContactModel:
    rng = np.random.default_rng(seed)
    friction = rng.uniform(0.1, 2, (count, 2))
    return ContactModel.build(
        rng.normal(size=(count, 2)), rng.normal(size=(count, 2)), rng.normal(size=count), friction
    )


@pytest.mark.parametrize("name", builtin_scenes())
def test_rows_are_the_exact_constraints_rounded_once(name: str) -> None:
    scene = load_scene(name)
    model = contact_model(scene)
    exact = np.array([[float(x) for x in row] for wheel in scene.wheels for row in constraint_matrix(wheel)])
    np.testing.assert_allclose(np.column_stack([model.rows, -model.targets]), exact, rtol=0, atol=1e-15 * len(exact))


def test_geometry_of_the_model(two_wheels: ContactModel) -> None:
    np.testing.assert_array_equal(two_wheels.rims, [(1, 0), (0, 1)])
    np.testing.assert_array_equal(two_wheels.sides, [(0, 1), (-1, 0)])
    np.testing.assert_array_equal(two_wheels.speeds, [1, 2])
    np.testing.assert_array_equal(two_wheels.mu_roll, [1, 1])
    np.testing.assert_array_equal(two_wheels.mu_side, [0.5, 0.5])
    np.testing.assert_array_equal(two_wheels.rows, [(1, 0, 0), (0, 1, 0), (0, 1, 2), (-1, 0, 0)])


def test_slips_of_a_known_twist(two_wheels: ContactModel) -> None:
    """v = (3, 4), omega = 1: p_1 moves with (3, 4), p_2 with (3, 6)."""
    np.testing.assert_array_equal(two_wheels.slips([3, 4, 1]), [(2, 4), (4, -3)])


def test_values_by_hand(two_wheels: ContactModel) -> None:
    """Weighted slips are (2, 2) and (4, -3/2) at unit loads."""
    twist, loads = [3, 4, 1], [2, 1]
    assert dissipation(Functional.BOX, two_wheels, loads, twist) == pytest.approx(2 * 4 + 5.5)
    assert dissipation(Functional.ELLIPSE, two_wheels, loads, twist) == pytest.approx(2 * np.sqrt(8) + np.sqrt(18.25))


@BOTH
def test_points_and_twists_broadcast(functional: Functional, two_wheels: ContactModel) -> None:
    loads, many = np.array([[1.0, 2.0], [3.0, 4.0]]), np.arange(15.0).reshape(5, 3)
    table = dissipation(functional, two_wheels, loads[:, None], many[None])
    assert table.shape == (2, 5)
    assert table[1, 3] == dissipation(functional, two_wheels, loads[1], many[3])


@BOTH
@given(first=twists, second=twists, share=st.floats(0, 1))
def test_convex_in_the_twist(
    functional: Functional, first: NDArray[np.float64], second: NDArray[np.float64], share: float
) -> None:
    model, loads = random_model(1, 4), [0.1, 0.2, 0.3, 0.4]
    between = dissipation(functional, model, loads, share * first + (1 - share) * second)
    ends = dissipation(functional, model, loads, np.stack([first, second]))
    assert between <= share * ends[0] + (1 - share) * ends[1] + ROUNDING * (1 + ends.sum())


@given(twist=twists)
def test_ellipse_lies_between_the_box_and_its_diagonal(twist: NDArray[np.float64]) -> None:
    model, loads = random_model(2, 5), [0.1, 0.1, 0.2, 0.2, 0.4]
    box, ellipse = (float(dissipation(f, model, loads, twist)) for f in Functional)
    assert box / np.sqrt(2) <= ellipse * (1 + ROUNDING)
    assert ellipse <= box * (1 + ROUNDING)


@BOTH
@given(twist=twists, seed=st.integers(0, 100))
def test_power_of_balanced_forces_bounds_every_dissipation(
    functional: Functional, twist: NDArray[np.float64], seed: int
) -> None:
    """Weak duality: ``sum f b <= D(xi)``, for the forces that the repair returns from any inside their limits."""
    model = random_model(3, 4)
    loads = np.array([[0.4, 0.3, 0.2, 0.1]])
    inside = np.random.default_rng(seed).uniform(-0.6, 0.6, (1, 4, 2)) * model.limits(loads)
    forces = balance_forces(functional, model, loads, inside)
    assert imbalance(model, forces)[0] <= ROUNDING
    assert usage(functional, model, loads, forces).max() <= 1 + ROUNDING
    assert input_power(model, forces)[0] <= dissipation(functional, model, loads, twist)[0] + ROUNDING


@BOTH
def test_share_of_a_missing_limit(functional: Functional) -> None:
    """No limit and no force: nothing used. No limit and a force: infinitely much."""
    model = ContactRows(np.eye(3)[[0, 1, 0, 1]], np.zeros(4), np.array([1.0, 0.0, 1.0, 1.0]))
    np.testing.assert_array_equal(share_of_limit(model, [1, 0], [[1, 0], [0, 0]]), [[1, 0], [0, 0]])
    np.testing.assert_array_equal(usage(functional, model, [1, 0], [[0, 1], [0, -1]]), [np.inf, np.inf])


@pytest.mark.parametrize(
    ("rows", "targets", "friction", "expected"),
    [
        (np.ones((3, 3)), np.zeros(3), np.ones(3), "shape"),
        (np.ones((2, 2)), np.zeros(2), np.ones(2), "shape"),
        (np.ones((2, 3)), np.zeros(3), np.ones(2), "2 targets"),
        (np.ones((2, 3)), np.array([0, np.nan]), np.ones(2), "finite"),
        (np.ones((2, 3)), np.zeros(2), np.array([1.0, -1.0]), "friction >= 0"),
    ],
)
def test_rows_are_validated(
    rows: NDArray[np.float64], targets: NDArray[np.float64], friction: NDArray[np.float64], expected: str
) -> None:
    with pytest.raises(ValueError, match=expected):
        ContactRows(rows, targets, friction)


def test_a_rim_without_direction_is_refused() -> None:
    with pytest.raises(ValueError, match="nonzero length"):
        ContactModel.build([(0, 0)], [(0, 0)], [1], (1, 1))


# ---- The least dissipation at 100 digits: a golden value, certified minima, and scales -----------

SOLVERS = 1e-7  # relative gap of the reference solvers
EXACT = 1e-12  # of the others
MOST_RATIO = 1e6  # of frictions: beyond it forces may be so large that their rounding outweighs the gap


def test_two_isotropic_wheels() -> None:
    """D* = 0.98387 for the circle functional: the paper's example of two wheels."""
    model = ContactModel.build([(0, 0), (2, 1)], [(1, 0), (1, 0)], [(1, 0.3), (-0.2, 0.5)], (1, 1))
    least = ReferenceMinimization(Functional.ELLIPSE, model, np.array([1.0, 2.0])).least()
    assert float(least.mid()) == pytest.approx(0.98387, abs=5e-6)


@pytest.mark.parametrize("minimizer", MINIMIZERS, ids=lambda m: f"{type(m).__name__}-{m.functional}")
@pytest.mark.parametrize("seed", range(3))
def test_every_minimizer_reaches_it_and_none_falls_below(minimizer: Minimizer, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = ContactModel.build(
        rng.normal(size=(5, 2)), rng.normal(size=(5, 2)), rng.normal(size=5), rng.uniform(0.1, 2, (5, 2))
    )
    loads = rng.uniform(0.1, 1, 5)
    problem = ReferenceMinimization(minimizer.functional, model, loads)
    least = problem.least()
    excess = float(((problem.at(minimizer.minimize(model, loads[None]).twists[0]) - least) / least).mid())
    assert -1e-24 <= excess <= (SOLVERS if "Cvxpy" in type(minimizer).__name__ else EXACT)


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-5", "off-center"]))
def test_certificates_at_extreme_friction_are_right(name: str) -> None:
    """What the forces certify is the least dissipation, where they outweigh rounding and where they do not."""
    scene = load_scene(name)
    point = [[float(c) + 0.3 * float(scene.check.radius) for c in scene.check.equilibrium]]
    for ratio in RATIOS.values():
        model = contact_model(with_friction_ratio(scene, ratio))
        loads = loads_at(model, point)
        for minimizer in (BoxHighs(), EllipseMinimizer()):
            minima = minimizer.minimize(model, loads)
            problem = ReferenceMinimization(minimizer.functional, model, loads[0])
            error = abs(float(((problem.at(minima.twists[0]) - problem.least()) / problem.at(np.zeros(3))).mid()))
            assert error <= GAP or not minima.check()[0]
            assert minima.check()[0] or max(ratio, 1 / ratio) > MOST_RATIO


@pytest.mark.parametrize("functional", list(Functional))
def test_a_slip_that_vanishes_adds_nothing(functional: Functional) -> None:
    """The body turns about the origin, and the first wheel with it: its slip is a ball about zero."""
    model = ContactModel.build([(0.5, 0), (0.7, 0)], [(0, 1), (0, 1)], (-1.5, 0), (1, 1))
    dissipation = ReferenceMinimization(functional, model, np.ones(2)).at(np.array([0.0, 0.0, -3.0]))
    assert float(dissipation.mid()) == pytest.approx(2.1, abs=1e-14)


# ---- Rule ``ellipse`` without friction across the rims: only what forces prove is shown as a number.
#
# With ``mu_S = 0`` the functional of rule ``ellipse`` is ``sum N_i mu_R |r_i|``, that of rule ``box``: the exact
# cells of that rule say what the motion is.

FREE_ROLLERS: Pair = (1, 0)
FAST = 1e3  # no array here has a speed above 3 at a distance below 1: a rate above that is no motion
TURNED: Pair = (Fraction(3, 5), Fraction(4, 5))


def under_ellipse(scene: Scene) -> Scene:
    return replace(scene, contact=Contact("ellipse"))


def omniwheels(arrays: Arrays) -> Scene:
    """Three tangential rims: the wheels carry the body around without any slip, D = 0."""
    positions: list[Pair] = [(1, 0), (Fraction(-3, 5), Fraction(4, 5)), (Fraction(-3, 5), Fraction(-4, 5))]
    wheels = [WheelData((x, y), (-y, x)) for x, y in positions]
    return under_ellipse(arrays.scene(wheels, FREE_ROLLERS, radius=Fraction(1, 10)))


def turned_rims(arrays: Arrays, count: int = 6) -> Scene:
    """Rims turned by one angle from the centre, on the unit circle."""
    (c, s), wheels = TURNED, []
    for t in (Fraction(0), Fraction(1, 3), Fraction(3, 2), Fraction(-4), Fraction(-2, 3), Fraction(-1, 5))[:count]:
        x, y = arrays.circle_point(t)
        wheels.append(WheelData((x, y), (s * y - c * x, -s * x - c * y)))
    return under_ellipse(arrays.scene(wheels, FREE_ROLLERS, radius=Fraction(1, 10)))


def inward_rims(arrays: Arrays) -> Scene:
    """Nothing resists the rotation about the centre."""
    return under_ellipse(arrays.four_wheel(FREE_ROLLERS))


@pytest.mark.parametrize("build", [omniwheels, turned_rims])
def test_every_minimum_is_proved_and_right(arrays: Arrays, build: object) -> None:
    scene = build(arrays)  # type: ignore[operator]
    model = contact_model(scene)
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (300, 2))
    minima = EllipseMinimizer().minimize(model, loads_at(model, points))
    assert proved(minima).all()
    boxed = replace(scene, contact=Contact("box"))
    exact = PointLocator(build_box_partition(boxed)).twists(points)
    value = dissipation(Functional.BOX, model, minima.loads, exact)
    assert minima.values == pytest.approx(value, abs=1e-9)


@cache
def checked(build: Callable[[Arrays], Scene]) -> SmoothCheck:
    """What several tests look at."""
    result = check_theorem4(build(Arrays()), prune=False)
    assert isinstance(result, SmoothCheck)
    return result


@few(1)
@pytest.mark.parametrize("build", [inward_rims, omniwheels, turned_rims])
def test_no_sampled_rate_is_beyond_what_a_body_can_do(build: Callable[[Arrays], Scene]) -> None:
    result = checked(build)
    assert result.check()
    sampled = result.translation.sampled
    assert sampled is not None
    assert sampled.largest_relative is None or abs(sampled.largest_relative) < FAST
    for sample in result.feedback.samples:
        assert sample.worst_rate is None or abs(sample.worst_rate) < FAST


def test_free_motions_are_named_instead_of_numbers(arrays: Arrays) -> None:
    scene = inward_rims(arrays)
    assert free_motions(scene) == "no row with friction resists the motion xi = (0, 0, 1)"
    sampled = sample_smooth_derivative(scene, 100)
    assert (sampled.samples, sampled.largest, sampled.largest_relative, sampled.at) == (0, None, None, None)
    assert sampled.not_certified == free_motions(scene)
    for sample in with_samples(checked(inward_rims).feedback, scene).samples:
        assert (sample.states, sample.worst_rate, sample.worst_state, sample.fails) == (0, None, None, None)
        assert sample.not_certified == free_motions(scene)


def test_two_free_motions(arrays: Arrays) -> None:
    """Parallel rims on one line: neither the translation across nor the rotation is resisted."""
    scene = arrays.scene([WheelData((x, 0), (1, 0)) for x in (-1, 0, 1)], FREE_ROLLERS)
    assert free_motions(scene) == "no row with friction resists the motions xi = (0, 0, 1), (0, 1, 0)"
    for motion in ((0, 0, 1), (0, 1, 0)):
        assert not any(np.array(motion) @ row for row in contact_model(scene).rows[::2])


def test_minima_without_proof_do_not_count(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every other answer spoiled: half of them are left, and the sentence says so."""
    honest = EllipseMinimizer.minimize

    def spoilt(self: EllipseMinimizer, model: ContactRows, loads: object) -> Minima:
        found = honest(self, model, loads)  # type: ignore[arg-type]
        twists = found.twists.copy()
        twists[::2] *= 1e200
        return replace(found, twists=twists)

    monkeypatch.setattr(EllipseMinimizer, "minimize", spoilt)
    scene = under_ellipse(arrays.four_wheel())
    with np.errstate(over="ignore", invalid="ignore"):
        sampled = sample_smooth_derivative(scene, 100)
        agreement = compare_rules(scene)
    assert sampled.samples == 50
    assert sampled.largest_relative is not None
    assert abs(sampled.largest_relative) < FAST
    assert sampled.not_certified == "50 of 100 minima without proof"
    assert agreement.differences["ellipse", "box"].points == 800
    assert agreement.differences["ellipse", "box"].not_certified == "800 of 1600 minima without proof"
    assert agreement.differences["ellipse", "box"].largest is not None
    assert agreement.differences["ellipse", "box"].largest <= 2


def test_no_sentence_where_nothing_is_missing() -> None:
    assert minima_without_proof(np.array([True, True])) == ""


def test_own_speeds_at_every_point(arrays: Arrays) -> None:
    """Speeds by point: the same minima as one model after the other, and proofs against the point's own speeds."""
    model = contact_model(under_ellipse(arrays.four_wheel()))
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.4, 0.4, (20, 2))
    targets = np.zeros((20, 8))
    targets[:, ::2] = rng.uniform(-1, 1, (20, 4))
    loads = loads_at(model, points)
    together = EllipseMinimizer().minimize(ContactRows(model.rows, targets, model.friction), loads)
    assert proved(together).all()
    for k in range(20):
        alone = EllipseMinimizer().minimize(replace(model, targets=targets[k]), loads[k])
        assert together.twists[k] == pytest.approx(alone.twists[0], abs=1e-12)
        assert together[k].check()
    forged = replace(together, model=ContactRows(model.rows, targets[::-1], model.friction))
    assert not proved(forged).any()


def test_paths_of_unproved_motions_end_in_words(arrays: Arrays) -> None:
    with pytest.raises(TrajectoryError, match=r"a minimum without proof at \(0.02, 0.01\)"):
        ellipse_path(contact_model(inward_rims(arrays)), (0.02, 0.01, 0.0), 0.1)


def test_references_leave_out_kinks(arrays: Arrays) -> None:
    """Without friction across the rims D has no curvature along them: Newton's method has nothing to solve."""
    assert ellipse_references(turned_rims(arrays)) == ()


def test_laws_are_listed_best_first_and_unknown_last(arrays: Arrays) -> None:
    scene = under_ellipse(arrays.four_wheel())
    samples = with_samples(check_smooth(scene).feedback, scene).samples
    assert {sample.law for sample in samples} == set(SampledLaw)
    rates = [sample.worst_rate for sample in samples]
    assert all(rate is not None for rate in rates)
    assert rates == sorted(rates)  # type: ignore[type-var]


# ---- Minimizers and cells of wheels with friction axes against the definition of D, written here once more from
# vectors.
#
# The oracle knows no rows: a wheel at p slips by ``q = v + omega J p - u e``, of which friction sees the part along
# the axis a and the part along J a. CVXPY minimizes the sum over the wheels as it stands.


cp: Any = cvxpy  # without types of its own

SEEDS = range(12)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
CLOSE = 1e-6  # of twists and of D, beside the largest speed: the accuracy of the oracle


def askew(seed: int, rule: str, side: str = "2/5") -> Scene:
    """Five wheels about the checked point with rims and axes in all directions."""
    rng = np.random.default_rng(seed)
    wheels = []
    for k in range(5):
        angle = 2 * np.pi * k / 5 + rng.uniform(-0.4, 0.4)
        place = [str(round(float(v), 2)) for v in (np.cos(angle), np.sin(angle))]
        heading, axis = ([int(v) for v in pair] for pair in rng.integers(1, 6, (2, 2)) * rng.choice([-1, 1], (2, 2)))
        wheels.append(ns.Wheel(place, heading=heading, speed=str(round(rng.uniform(-2, 2), 1)), axis=axis))
    return ns.Array(wheels, mu_roll=1, mu_side=side, rule=rule, radius="1/4").scene


def points(seed: int) -> Floats:
    return np.random.default_rng(seed + 100).uniform(-0.25, 0.25, (3, 2))


def loads_by_springs(places: Floats, point: Floats) -> Floats:
    """Identical springs: ``N_i = alpha + beta . p_i`` with the weight 1 at the centre of mass."""
    ones = np.column_stack([np.ones(len(places)), places])
    return np.asarray(ones @ np.linalg.solve(ones.T @ ones, np.array([1.0, *point])))


def cells_at(partition: Partition, point: Floats) -> list[Cell]:
    def beyond(side: HalfPlane) -> float:
        return float(side.normal[0]) * point[0] + float(side.normal[1]) * point[1] - float(side.offset)

    return [cell for cell in partition.cells if max(map(beyond, cell.polygon.sides)) <= 0]


class Definition:
    """The wheels as vectors."""

    def __init__(self, scene: Scene) -> None:
        def arrays(name: str) -> Floats:
            return np.array([[float(x) for x in getattr(wheel, name)] for wheel in scene.wheels])

        def unit(vectors: Floats) -> Floats:
            return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])

        self.rule = scene.contact.rule
        self.places, self.axes = arrays("position"), unit(arrays("grip"))
        self.surface = unit(arrays("direction")) * np.array([[float(wheel.speed)] for wheel in scene.wheels])
        first = scene.wheels[0].friction
        self.roll, self.side = float(first.roll), float(first.side)

    def cost(self, twist: Any, k: int) -> Any:
        """Friction losses of wheel k for each unit of load."""
        v, omega = twist[:2], twist[2]
        slip = v + omega * (TURN @ self.places[k]) - self.surface[k]
        along, across = self.axes[k] @ slip, (TURN @ self.axes[k]) @ slip
        if self.rule == "box":
            return self.roll * cp.abs(along) + self.side * cp.abs(across)
        if self.rule == "ellipse":
            return cp.norm(cp.hstack([self.roll * along, self.side * across]))
        turning = cp.Variable()  # of the roller
        return self.roll * cp.norm(cp.hstack([along, across - turning])) + self.side * cp.abs(turning)

    def minimum(self, point: Floats) -> tuple[Floats, float]:
        twist = cp.Variable(3)
        loads = loads_by_springs(self.places, point)
        assert loads.min() > 0
        problem = cp.Problem(cp.Minimize(cp.sum([n * self.cost(twist, k) for k, n in enumerate(loads)])))
        problem.solve(solver="CLARABEL", tol_gap_abs=1e-9, tol_gap_rel=1e-9, tol_feas=1e-9)
        return np.asarray(twist.value), float(problem.value)

    def dissipation(self, twist: Floats, point: Floats) -> float:
        loads = loads_by_springs(self.places, point)
        costs = [self.cost(cp.Constant(twist), k) for k in range(len(loads))]
        return float(cp.Problem(cp.Minimize(cp.sum([n * c for n, c in zip(loads, costs, strict=True)]))).solve())


@few(1)
@pytest.mark.parametrize("side", ["2/5", "0"])
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("seed", SEEDS)
def test_minima_without_cells(seed: int, rule: str, side: str) -> None:
    scene = askew(seed, rule, side)
    minima = minima_under(smooth_rule_of(scene), scene, points(seed))
    assert minima.check().all()
    for point, twist in zip(points(seed), minima.twists, strict=True):
        best, least = Definition(scene).minimum(point)
        assert Definition(scene).dissipation(twist, point) == pytest.approx(least, abs=CLOSE)
        if side != "0" and rule == "ellipse":
            assert twist == pytest.approx(best, abs=1e-3)


@few(1)
@pytest.mark.parametrize("side", ["2/5", "0"])
@pytest.mark.parametrize("seed", SEEDS)
def test_cells_and_minima_of_rule_box(seed: int, side: str) -> None:
    """The exact twist of the cell has the least D, and so has that of the linear program."""
    scene = askew(seed, "box", side)
    partition, model = build_partition(scene), contact_model(scene)
    assert partition.tiles
    for point in points(seed):
        _, least = Definition(scene).minimum(point)
        inside = cells_at(partition, point)
        twists = [np.array([float(x) for x in twist]) for cell in inside for twist in cell.twists]
        twists.append(BoxHighs().minimize(model, loads_at(model, point[None])).twists[0])
        assert inside
        for twist in twists:
            assert Definition(scene).dissipation(twist, point) == pytest.approx(least, abs=CLOSE)


@pytest.mark.parametrize("side", ["2/5", "3", "0"])
@pytest.mark.parametrize("seed", SEEDS)
def test_rule_nearest_by_its_words(seed: int, side: str) -> None:
    """Wheels by distance, of each the direction of larger friction first, while independent, until three."""
    scene = askew(seed, "nearest", side)
    partition, oracle = build_partition(scene), Definition(scene)
    for point in points(seed):
        rows: list[Floats] = []
        rhs: list[float] = []
        order = np.argsort(np.linalg.norm(oracle.places - point, axis=1))
        for k in order:
            frames = [(oracle.roll, oracle.axes[k]), (oracle.side, TURN @ oracle.axes[k])]
            for friction, way in sorted(frames, key=lambda entry: -entry[0]):
                row = np.array([*way, way @ TURN @ oracle.places[k]])
                if friction and len(rows) < 3 and np.linalg.matrix_rank(np.array([*rows, row])) > len(rows):
                    rows.append(row)
                    rhs.append(float(way @ oracle.surface[k]))
        expected = np.linalg.solve(np.array(rows), np.array(rhs))
        assert [float(x) for x in cells_at(partition, point)[0].twists[0]] == pytest.approx(
            expected, rel=1e-9, abs=1e-9
        )
        sampled, _ = greedy_twist(contact_model(scene), order)
        assert sampled == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_speeds_and_slips_of_the_model(seed: int) -> None:
    scene = askew(seed, "ellipse")
    model, oracle = contact_model(scene), Definition(scene)
    assert model.speeds == pytest.approx([float(wheel.speed) for wheel in scene.wheels])
    twist = np.random.default_rng(seed).normal(size=3)
    slips = twist[:2] + twist[2] * oracle.places @ TURN.T - oracle.surface
    expected = np.column_stack([(slips * oracle.axes).sum(axis=1), (slips * (oracle.axes @ TURN.T)).sum(axis=1)])
    assert model.slips(twist) == pytest.approx(expected)
    assert wheel_slips(model, twist[None], model.speeds[None])[0] == pytest.approx(expected)


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_of_the_full_dynamics_point_against_weighted_slips(seed: int) -> None:
    """``f = -N (mu_R^2 r a + mu_S^2 s J a)/sqrt(mu_R^2 r^2 + mu_S^2 s^2)``, its moment about the centre of mass."""
    scene = askew(seed, "ellipse")
    oracle, centre = Definition(scene), np.array([0.05, -0.1])
    velocity = 3 + np.random.default_rng(seed).normal(size=3)
    arms = oracle.places - centre
    slips = velocity[:2] + velocity[2] * arms @ TURN.T - oracle.surface
    loads, total = loads_by_springs(oracle.places, centre), np.zeros(3)
    for load, slip, axis, arm in zip(loads, slips, oracle.axes, arms, strict=True):
        r, s = axis @ slip, (TURN @ axis) @ slip
        pull = oracle.roll**2 * r * axis + oracle.side**2 * s * (TURN @ axis)
        force = -load * pull / np.hypot(oracle.roll * r, oracle.side * s)
        total += [*force, arm[0] * force[1] - arm[1] * force[0]]
    found = EllipseFriction(contact_model(scene), 1e-9).total(centre, velocity, loads)
    assert found == pytest.approx(total, rel=1e-6, abs=1e-6)
