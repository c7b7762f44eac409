"""``V = c^T P c`` where ``|c|^2`` is no certificate."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation, rotation_bound
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult, decide_translation
from nonsmooth.proofs.clauses.translation.quadratic import QuadraticCertificate, find_quadratic
from nonsmooth.proofs.findings.verdicts import Rotation, Translation
from tests.conftest import Arrays
from tests.four_wheel import SIDE
from tests.oracles.clause_evidence import evidence_holds

ARRIVED = 1e-9  # a distance; coordinates are of order 1
LOOSE = 9  # the largest bound of the time of arrival against the longest path, over these arrays
SEEDS = [3, 4, 13, 16, 26, 50]  # arrays of the builder that attract although |c|^2 grows somewhere


def decided(arrays: Arrays, seed: int) -> tuple[TranslationResult, QuadraticCertificate]:
    result = decide_translation(build_nearest_partition(arrays.cocircular(seed)))
    assert result.quadratic is not None
    return result, result.quadratic


@pytest.mark.parametrize("seed", SEEDS)
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


@pytest.mark.parametrize("seed", SEEDS)
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


@pytest.mark.parametrize("seed", SEEDS)
def test_the_time_of_arrival_is_bounded_and_not_by_much_more_than_the_longest_path(arrays: Arrays, seed: int) -> None:
    """Paths of both kinematics from all around, at nine tenths of the region's distance in each direction."""
    partition = build_nearest_partition(arrays.cocircular(seed))
    _, found = decided(arrays, seed)
    (a, b), level = (float(x) for x in found.shape), float(found.level)
    bound, longest = float(found.arrival_per_distance), 0.0
    for kinematics in (Kinematics.LEADING, Kinematics.EXACT):
        field = array_field(partition, kinematics)
        for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False) + 0.01:
            x, y = np.cos(angle), np.sin(angle)
            distance = 0.9 * np.sqrt(level / ((1 + a) * x * x + 2 * b * x * y + (1 - a) * y * y))
            path = simulate(field, (distance * x, distance * y, 0), bound * distance + 1)
            ends = [(piece.end, np.array(piece.state(piece.end - piece.start))) for piece in path.pieces]
            moment = next(t for t, state in ends if np.hypot(*state[:2]) < ARRIVED)
            longest = max(longest, moment / distance)
    assert longest <= bound * (1 + ARRIVED)
    assert bound <= LOOSE * longest


@pytest.mark.parametrize("seed", SEEDS)
def test_a_forged_time_of_arrival_is_refused(arrays: Arrays, seed: int) -> None:
    _, found = decided(arrays, seed)
    swift = found.swift or found.descent
    assert not evidence_holds(replace(found, swift=replace(swift, decay=swift.decay * 2)))
    assert not evidence_holds(replace(found, swift=replace(swift, shape=(Fraction(1), Fraction(0)))))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_decay_bounds_time_and_rotation_until_paths_arrive(arrays: Arrays, seed: int) -> None:
    """From a start in the region, by events along leading-order solutions; at the point itself all these drift."""
    partition = build_nearest_partition(arrays.cocircular(seed))
    result, found = decided(arrays, seed)
    assert decide_rotation(partition, result).verdict is Rotation.UNSTABLE
    turning = rotation_bound(partition, result)
    assert turning is not None
    (a, b), level = (float(x) for x in found.shape), float(found.level)
    field = array_field(partition, Kinematics.LEADING)
    for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False) + 0.01:
        x, y = np.cos(angle), np.sin(angle)
        distance = 0.9 * np.sqrt(level / ((1 + a) * x * x + 2 * b * x * y + (1 - a) * y * y))
        time = float(found.arrival_per_distance) * distance
        path = simulate(field, (distance * x, distance * y, 0), time + 1)
        ends = [(piece.end, np.array(piece.state(piece.end - piece.start))) for piece in path.pieces]
        moment, state = next((t, state) for t, state in ends if np.hypot(*state[:2]) < ARRIVED)
        assert moment <= time + ARRIVED
        assert abs(state[2]) <= float(turning) * distance + ARRIVED
