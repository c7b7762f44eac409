"""Clause 2: stability of (x, y) by V = |c|^2 and by c^T P c, rates, regions, witnesses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.filippov import filippov_twists, upper_derivative_at
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation, rotation_bound
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult, decide_translation
from nonsmooth.proofs.clauses.translation.quadratic import QuadraticCertificate, find_quadratic
from nonsmooth.proofs.findings import Rotation, Translation
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import dot
from tests.conftest import Arrays
from tests.four_wheel import CORNERS, ROLL, SIDE
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.nearest_states import nearest_states
from tests.thorough import few, keep, thorough

# ---- Clause 2: stability of (x, y) by V = |c|^2, its rate, its region, its witnesses -------------

RINGS = range(3, 13)
SEEDS = range(30)
# Arrays whose disc of certified decay ends inside the square, each of its own shape.
BOUNDED_SEEDS = [8, 58, 66, 79, 83, 92, 95, 98]

BESIDE = Fraction(1, 10**9)  # shorter than any cell
BESIDE_RAY = 1e-7  # likewise, and the slope changes by less than the tolerance on the way
# Rates are sums of a few products of numbers below 100.
ROUNDING = 1e-9


def decide(scene: Scene) -> TranslationResult:
    return decide_translation(build_nearest_partition(scene.recentred()))


def literal_rate(scene: Scene, point: NDArray[np.float64]) -> float:
    """V* by the rule at one point (both motions where frictions tie), without cells."""
    place = scene.field(Fraction(point[0])), scene.field(Fraction(point[1]))
    velocities = [[float(x) for x in s.twist.velocity] for s in nearest_states(scene, place)]
    return float(max(2 * np.array(velocities) @ point))


def middle_of_ray(polygon: Polygon, along: NDArray[np.float64]) -> float | None:
    """Distance to the middle of what a ray from the origin has in common with a closed polygon."""
    low, high = 0.0, math.inf
    for side in polygon.sides:
        slack = float(side.offset)  # at the origin
        rate = float(side.normal[0]) * along[0] + float(side.normal[1]) * along[1]
        if abs(rate) > ROUNDING:
            low, high = (low, min(high, slack / rate)) if rate > 0 else (max(low, slack / rate), high)
        elif slack < -ROUNDING:
            return None
    return (low + high) / 2 if high > max(low, ROUNDING) else None


def tips(result: TranslationResult) -> bool:
    """Whether the point is not inside the support polygon."""
    return result.support is not None and not result.support.stands


def disc_points(seed: int, inner: float, outer: float, count: int) -> NDArray[np.float64]:
    """Random points of an annulus."""
    rng = np.random.default_rng(seed)
    radii, angles = rng.uniform(inner, outer, count), rng.uniform(0, 2 * math.pi, count)
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


# ---- verdicts and rates with closed forms --------------------------------------------------------


@few(3)
@pytest.mark.parametrize("n", RINGS)
def test_rings_with_roll_rows_attract_in_finite_time(arrays: Arrays, n: int) -> None:
    scene = arrays.ring(n, ROLL)
    result = decide(scene)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.worst_rate == -2
    assert result.decay_rate == 2
    assert result.region_radius == scene.field.cos_pi(Fraction(1, n))  # beyond, the body tips between two wheels
    assert evidence_holds(result)


@few(3)
@pytest.mark.parametrize("n", RINGS)
def test_rings_with_side_rows_have_rays_of_equilibria(arrays: Arrays, n: int) -> None:
    scene = arrays.ring(n, SIDE)
    result = decide(scene)
    assert result.verdict is Translation.STABLE
    assert result.worst_rate == 0
    assert result.decay_rate is None
    assert result.region_radius == scene.field.cos_pi(Fraction(1, n))
    assert result.witness is not None
    assert evidence_holds(result)


def test_the_four_wheel_array_as_in_the_paper(arrays: Arrays) -> None:
    """Eq. (4) is asymptotically stable; eq. (3) is stable, and rests on the axes."""
    roll, side = decide(arrays.four_wheel(ROLL)), decide(arrays.four_wheel(SIDE))
    assert (roll.verdict, side.verdict) == (Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE)
    assert roll.worst_rate == -2
    assert side.worst_rate == 0
    assert side.witness is not None
    x, y = side.witness.point
    assert not x or not y


def test_mixed_hulls_of_equal_frictions_are_only_stable(arrays: Arrays) -> None:
    assert decide(arrays.four_wheel((1, 1))).verdict is Translation.STABLE


@pytest.mark.parametrize("pull_in_y", [False, True], ids=["outward", "saddle"])
def test_pushing_arrays_have_a_witness_that_the_literal_rule_confirms(arrays: Arrays, pull_in_y: bool) -> None:
    scene = arrays.pushed(1, -1 if pull_in_y else 1)
    result = decide(scene)
    assert result.verdict is Translation.UNSTABLE
    assert result.region_radius is None
    assert result.witness is not None
    assert result.witness.value > 0
    assert evidence_holds(result)
    x, y = result.witness.point
    beside = [(x + a, y + b) for a in (-BESIDE, BESIDE) for b in (-BESIDE, BESIDE)]
    rates = [2 * dot((x, y), state.twist.velocity) for p in beside for state in nearest_states(scene, p)]
    assert result.witness.value in rates


# ---- the verdict is about V* near the equilibrium ------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_verdicts_agree_with_the_literal_rule_near_the_equilibrium(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    result = decide(scene)
    rates = np.array([literal_rate(scene, p) / np.hypot(*p) for p in disc_points(seed, 1e-4, 1e-3, 120)])
    if refutes(result):
        assert result.witness is not None
        assert literal_confirms(scene, result.witness)
    elif result.fan is None:
        assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
        assert rates.max() < 0
    else:
        assert rates.max() <= ROUNDING


def refutes(result: TranslationResult) -> bool:
    """Whether V = |c|^2 grows somewhere near the equilibrium, so that the fan decides alone."""
    return result.witness is not None and result.witness.value > 0


def literal_confirms(scene: Scene, witness: Witness) -> bool:
    """Near the witness's ray, close to the equilibrium, some point of the literal rule has V* > 0."""
    ray = np.array([float(x) for x in witness.point]) * 1e-3
    turns = np.linspace(-1e-4, 1e-4, 5)
    return any(literal_rate(scene, ray + t * np.array([-ray[1], ray[0]])) > 0 for t in turns)


@thorough  # about all random cases, which `make bench` runs
def test_all_verdicts_of_this_file_occur(arrays: Arrays) -> None:
    results = [decide(arrays.cocircular(seed)) for seed in SEEDS]
    verdicts = {result.verdict for result in results}
    assert {Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE} <= verdicts
    assert sum(refutes(result) for result in results) == 17  # of 30: the others have a region


@pytest.mark.parametrize("seed", SEEDS)
def test_the_worst_rate_bounds_v_everywhere_and_is_attained(arrays: Arrays, seed: int) -> None:
    """``V* <= worst |c|`` on the square; beside the worst direction the literal rule comes as near as one likes."""
    scene = arrays.cocircular(seed)
    partition = build_nearest_partition(scene)
    result = decide_translation(partition)
    worst = float(result.worst_rate)
    corner = float(scene.check.radius)
    rng = np.random.default_rng(seed)
    for point in rng.uniform(-corner, corner, (100, 2)):
        assert literal_rate(scene, point) <= worst * np.hypot(*point) + ROUNDING
    direction = np.array([float(v) for v in result.worst.direction])
    along = direction / np.hypot(*direction)
    middles = [m * along for cell in partition.cells if (m := middle_of_ray(cell.polygon, along)) is not None]
    around = BESIDE_RAY * np.array([(math.cos(t), math.sin(t)) for t in np.linspace(0.1, 6.3, 24)])
    beside = [m + step for m in (*middles, direction) for step in around]  # it may be a vertex that the ray touches
    beside = [p for p in beside if np.abs(p).max() <= corner]
    assert max(literal_rate(scene, p) / np.hypot(*p) for p in beside) == pytest.approx(worst, abs=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_exact_upper_derivative_agrees_with_the_verdict_in_the_region(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    partition = build_nearest_partition(scene)
    result = decide_translation(partition)
    if refutes(result) or tips(result):
        assert result.region_radius is None
        return
    assert result.region_radius is not None
    squared = result.region_radius * result.region_radius
    points = [v for cell in partition.cells for v in cell.polygon.vertices]
    points += [arrays.interior_point(cell.polygon, np.random.default_rng(seed)) for cell in partition.cells]
    for point in points:
        if any(point) and dot(point, point) < squared:
            rate = upper_derivative_at(partition, point)
            assert rate < 0 if result.verdict is Translation.ASYMPTOTICALLY_STABLE else rate <= 0


# ---- the region ----------------------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("seed", BOUNDED_SEEDS)
@pytest.mark.parametrize("count", keep(1, [100, 300]))
def test_the_region_ends_where_the_literal_rule_first_fails(arrays: Arrays, seed: int, count: int) -> None:
    scene = arrays.cocircular(seed)
    result = decide(scene)
    assert result.region_radius is not None
    assert result.region_radius < scene.check.radius
    radius = float(result.region_radius)
    inside = [literal_rate(scene, p) for p in disc_points(seed, 0, radius, count)]
    outside = [literal_rate(scene, p) for p in disc_points(seed, radius, 1.2 * radius, 5 * count)]
    assert max(inside) <= ROUNDING
    assert max(outside) > (-ROUNDING if result.verdict is Translation.ASYMPTOTICALLY_STABLE else 0)


@pytest.mark.parametrize("seed", BOUNDED_SEEDS)
def test_the_region_is_the_same_in_every_square_that_holds_it(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    radius = decide(scene).region_radius
    assert radius is not None
    grown = replace(scene, check=replace(scene.check, radius=scene.check.radius * 2))
    assert decide(grown).region_radius == radius
    shrunk = replace(scene, check=replace(scene.check, radius=scene.field(Fraction(1, 5))))
    assert decide(shrunk).region_radius == min(radius, scene.field(Fraction(1, 5)))


def test_the_region_ends_where_v_stops_falling(arrays: Arrays) -> None:
    """Inner wheels hold roll rows, outer ones side rows: V* < 0 up to (0, 4), where cells of the outer wheels
    meet on the axis and V* = 0 as in eq. (3).  V* is nowhere positive.
    """
    inner = arrays.inward(CORNERS)
    outer = [w._replace(position=(3 * w.position[0], 3 * w.position[1]), friction=SIDE) for w in inner]
    far = [w._replace(position=(50 * w.position[0], 50 * w.position[1])) for w in inner]  # that the body stands on
    result = decide(arrays.scene([*inner, *outer, *far], ROLL, radius=5))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.worst_rate == 0
    assert result.region_radius == 4
    assert evidence_holds(result)
    assert not evidence_holds(replace(result, region_radius=result.region_radius + 1))


# ---- equilibria beside the equilibrium -----------------------------------------------------------


def holds_rest(partition: Partition, point: Point) -> bool:
    """0 in F at the point under exact kinematics, by the exact linear program."""
    one, zero = partition.scene.field.one, partition.scene.field.zero
    rates = [(*t.pose_rate(point), one) for t in filippov_twists(partition, point)]
    return best_mixture(rates, (zero, zero, one), [zero] * len(rates)) is not None


@pytest.mark.parametrize(("count", "most"), keep(1, [(15, 6), (60, 32)]))
def test_a_ray_of_equilibria_rests_under_exact_kinematics(arrays: Arrays, count: int, most: int) -> None:
    rays = 0
    for seed in range(count):
        partition = build_nearest_partition(arrays.cocircular(seed, SIDE))
        result = decide_translation(partition)
        if result.verdict is Translation.STABLE and result.witness is not None and not refutes(result):
            rays += 1
            x, y = result.witness.point
            for scale in (Fraction(1, 100), Fraction(1, 10**6)):
                assert holds_rest(partition, (x * scale, y * scale)), seed
    assert rays == most


@few(3)
@pytest.mark.parametrize("n", RINGS)
def test_rings_with_roll_rows_rest_nowhere_else(arrays: Arrays, n: int) -> None:
    partition = build_nearest_partition(arrays.ring(n, ROLL))
    for cell in partition.cells:
        for x, y in cell.polygon.vertices:
            if x or y:
                assert not holds_rest(partition, (x * Fraction(1, 10**6), y * Fraction(1, 10**6)))


# ---- evidence ------------------------------------------------------------------------------------


def wrong_versions(result: TranslationResult) -> list[TranslationResult]:
    """Claims beyond the evidence, and evidence that does not belong to the cells."""
    first = result.derivatives[0]
    shifted = replace(first, rates=tuple(rate - 1 for rate in first.rates))
    half = replace(result.worst, velocity=tuple(x / 2 for x in result.worst.velocity))
    wrong = [
        replace(result, derivatives=()),
        replace(result, derivatives=(shifted, *result.derivatives[1:])),
    ]
    if result.worst_rate:
        wrong.append(replace(result, worst=half))
    if result.verdict is not Translation.ASYMPTOTICALLY_STABLE:
        wrong.append(replace(result, verdict=Translation.ASYMPTOTICALLY_STABLE))
    if refutes(result):
        assert result.witness is not None
        others = {Translation.STABLE, Translation.UNSTABLE, Translation.UNDECIDED} - {result.verdict}
        wrong += [replace(result, verdict=other) for other in others]
        wrong.append(replace(result, fan=None))
        wrong.append(replace(result, witness=None))
        wrong.append(replace(result, witness=replace(result.witness, value=result.witness.value + 1)))
        wrong.append(replace(result, witness=replace(result.witness, point=result.witness.point[::-1])))
    elif tips(result):
        assert result.region_radius is None
        wrong.append(replace(result, region_radius=result.derivatives[0].twist.omega.field.one))
    else:
        assert result.region_radius is not None
        wrong.append(replace(result, region_radius=None))
        wrong.append(replace(result, region_radius=-result.region_radius))
    return wrong


@pytest.mark.parametrize("seed", SEEDS)
def test_tampered_results_are_refused(arrays: Arrays, seed: int) -> None:
    result = decide(arrays.cocircular(seed))
    assert evidence_holds(result)
    assert [k for k, wrong in enumerate(wrong_versions(result)) if evidence_holds(wrong)] == []


@pytest.mark.parametrize("seed", BOUNDED_SEEDS)
def test_a_region_that_is_too_large_is_refused_and_a_smaller_one_is_true(arrays: Arrays, seed: int) -> None:
    result = decide(arrays.cocircular(seed))
    assert result.region_radius is not None
    assert not evidence_holds(replace(result, region_radius=result.region_radius * Fraction(1001, 1000)))
    assert evidence_holds(replace(result, region_radius=result.region_radius * Fraction(999, 1000)))


def test_a_ray_that_does_not_rest_is_refused(arrays: Arrays) -> None:
    result = decide(arrays.four_wheel(SIDE))
    assert result.witness is not None
    field = result.worst.velocity[0].field
    diagonal = replace(result.witness, point=(field.one, field.one))
    assert not evidence_holds(replace(result, witness=diagonal))


def test_a_removed_cell_is_noticed_by_the_area(arrays: Arrays) -> None:
    """The clause cannot know that a cell is missing; the partition does."""
    partition = build_nearest_partition(arrays.four_wheel())
    assert not partition.area_error
    assert replace(partition, cells=partition.cells[1:]).area_error == partition.cells[0].polygon.area


def test_the_region_ends_where_the_body_tips(arrays: Arrays) -> None:
    """V* decreases on the whole square, but the centre of mass must stay over the wheels, 1/10 from the point."""
    corners = [(Fraction(x, 5), Fraction(y, 10)) for x in (1, -1) for y in (1, -1)]
    result = decide_translation(build_nearest_partition(arrays.scene(arrays.inward(corners))))
    assert result.worst_rate < 0
    assert result.region_radius == Fraction(1, 10)
    assert evidence_holds(result)
    assert not evidence_holds(replace(result, region_radius=result.region_radius * 2))
    assert "tips" in result.support_note


def test_there_is_no_region_where_the_body_tips_at_the_point(arrays: Arrays) -> None:
    result = decide_translation(build_nearest_partition(arrays.scene(arrays.inward([(1, 0), (-1, 0)]))))
    assert result.region_radius is None
    assert evidence_holds(result)
    assert "tips at c*" in result.support_note


# ---- ``V = c^T P c`` where ``|c|^2`` is no certificate -------------------------------------------

ARRIVED = 1e-9  # a distance; coordinates are of order 1
LOOSE = 9  # the largest bound of the time of arrival against the longest path, over these arrays
QUADRATIC_SEEDS = [3, 4, 13, 16, 26, 50]  # arrays of the builder that attract although |c|^2 grows somewhere


def decided(arrays: Arrays, seed: int) -> tuple[TranslationResult, QuadraticCertificate]:
    result = decide_translation(build_nearest_partition(arrays.cocircular(seed)))
    assert result.quadratic is not None
    return result, result.quadratic


@pytest.mark.parametrize("seed", QUADRATIC_SEEDS)
def test_v_falls_in_its_region_at_the_stated_rate(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.cocircular(seed))
    result, found = decided(arrays, seed)
    assert evidence_holds(result)
    assert evidence_holds(found)
    (a, b), level = (float(x) for x in found.shape), float(found.level)
    p = np.array([[1 + a, b], [b, 1 - a]])
    assert np.linalg.eigvalsh(p).min() > 0
    rng, inside = np.random.default_rng(seed), 0
    for cell in partition.cells:
        for _ in range(60):
            x, y = arrays.interior_point(cell.polygon, rng)
            c = np.array([float(x), float(y)]) * rng.uniform(0, 1) ** 2
            if not cell.polygon.contains((partition.scene.field.zero,) * 2):
                c = np.array([float(x), float(y)])
            if c @ p @ c < level:
                inside += 1
                for twist in cell.twists:
                    turning = float(twist.omega) * np.array([-c[1], c[0]])
                    for velocity in (np.zeros(2), turning):  # leading-order and exact kinematics
                        rate = 2 * c @ p @ (np.array([float(twist.vx), float(twist.vy)]) + velocity)
                        assert rate <= -float(found.decay) * np.hypot(*c) + 1e-12
    assert inside > 20


@pytest.mark.parametrize("seed", QUADRATIC_SEEDS)
def test_forged_certificates_are_refused(arrays: Arrays, seed: int) -> None:
    result, found = decided(arrays, seed)
    assert not evidence_holds(replace(found, decay=found.decay * 64))
    assert not evidence_holds(replace(found, shape=(Fraction(2), Fraction(0))))
    assert not evidence_holds(replace(found, level=found.level * 1000))
    assert not evidence_holds(replace(result, quadratic=replace(found, cones=found.cones[:1])))


def test_no_p_is_found_for_a_fan_that_rests_or_escapes(arrays: Arrays) -> None:
    for scene in (arrays.four_wheel(SIDE), arrays.four_wheel(turn=(-1, 0))):
        partition = build_nearest_partition(scene)
        fan = decide_translation(partition).fan
        assert fan is not None
        assert fan.verdict is not Translation.ASYMPTOTICALLY_STABLE
        assert find_quadratic(build_fan(partition)) is None


def paths_home(
    partition: Partition, found: Any, kinematics: Kinematics, count: int
) -> Iterator[tuple[float, float, Any]]:
    """From all around, at nine tenths of the region's distance: how far, when a path arrives, and its state then."""
    (a, b), level = (float(x) for x in found.shape), float(found.level)
    field = array_field(partition, kinematics)
    for angle in np.linspace(0, 2 * np.pi, count, endpoint=False) + 0.01:
        x, y = np.cos(angle), np.sin(angle)
        distance = 0.9 * np.sqrt(level / ((1 + a) * x * x + 2 * b * x * y + (1 - a) * y * y))
        until = float(found.arrival_per_distance) * distance + 1
        path = simulate(field, (distance * x, distance * y, 0), until)
        ends = [(piece.end, np.array(piece.state(piece.end - piece.start))) for piece in path.pieces]
        moment, state = next((t, state) for t, state in ends if np.hypot(*state[:2]) < ARRIVED)
        assert moment is not None
        yield float(distance), float(moment), state


@pytest.mark.parametrize("count", keep(1, [10, 24]))
@pytest.mark.parametrize("seed", QUADRATIC_SEEDS)
def test_the_time_of_arrival_is_bounded_and_not_by_much_more_than_the_longest_path(
    arrays: Arrays, seed: int, count: int
) -> None:
    """Paths of both kinematics; along leading-order solutions the turn is bounded too: at the point all these drift."""
    partition = build_nearest_partition(arrays.cocircular(seed))
    result, found = decided(arrays, seed)
    assert decide_rotation(partition, result).verdict is Rotation.UNSTABLE
    turning = rotation_bound(partition, result)
    assert turning is not None
    bound, longest = float(found.arrival_per_distance), 0.0
    for kinematics in (Kinematics.LEADING, Kinematics.EXACT):
        for distance, moment, state in paths_home(partition, found, kinematics, count):
            longest = max(longest, moment / distance)
            if kinematics is Kinematics.LEADING:
                assert abs(state[2]) <= float(turning) * distance + ARRIVED
    assert longest <= bound * (1 + ARRIVED)
    assert bound <= LOOSE * longest


@pytest.mark.parametrize("seed", QUADRATIC_SEEDS)
def test_a_forged_time_of_arrival_is_refused(arrays: Arrays, seed: int) -> None:
    _, found = decided(arrays, seed)
    swift = found.swift or found.descent
    assert not evidence_holds(replace(found, swift=replace(swift, decay=swift.decay * 2)))
    assert not evidence_holds(replace(found, swift=replace(swift, shape=(Fraction(1), Fraction(0)))))
