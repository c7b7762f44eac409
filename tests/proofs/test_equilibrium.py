"""Clause 1: whether 0 lies in F(c*), with convex weights or a separating direction as evidence."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumResult, decide_equilibrium
from nonsmooth.proofs.findings.verdicts import Equilibrium
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import Vector, dot, separating_direction
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.hulls import hull_holds_zero
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few, thorough

HALF = Fraction(1, 2)


def decide(scene: Scene) -> EquilibriumResult:
    return decide_equilibrium(build_nearest_partition(scene.recentred()))


def holds_by_highs(partition: Partition) -> bool:
    """Feasibility of ``sum w v = 0, sum w = 1, w >= 0`` by SciPy."""
    zero = partition.scene.field.zero
    return hull_holds_zero(t.velocity for t in filippov_twists(partition, (zero, zero)))


@pytest.mark.parametrize("seed", range(30))
def test_verdicts_agree_with_highs_on_random_arrays(arrays: Arrays, seed: int) -> None:
    for scene in (arrays.random(seed, 2 + seed % 5), arrays.cocircular(seed)):
        partition = build_nearest_partition(scene.recentred())
        result = decide_equilibrium(partition)
        assert (result.verdict is Equilibrium.HOLDS) == holds_by_highs(partition)
        assert evidence_holds(result)


@thorough  # about all random cases, which `make bench` runs
def test_both_verdicts_occur_among_the_random_arrays(arrays: Arrays) -> None:
    found = {decide(s).verdict for seed in range(30) for s in (arrays.random(seed, 4), arrays.cocircular(seed))}
    assert found == {Equilibrium.HOLDS, Equilibrium.FAILS}


@few(3)
@pytest.mark.parametrize("n", range(3, 13))
def test_the_centre_of_a_ring_is_an_equilibrium(arrays: Arrays, n: int) -> None:
    for friction in (ROLL, SIDE):
        result = decide(arrays.ring(n, friction))
        assert result.verdict is Equilibrium.HOLDS
        zero = result.twists[0].omega.field.zero
        assert sum(result.weights.values()) == 1
        assert sum((w * result.twists[k].vx for k, w in result.weights.items()), zero) == 0
        assert sum((w * result.twists[k].vy for k, w in result.weights.items()), zero) == 0
        assert min(result.weights.values()) > 0


def test_off_the_centre_one_twist_drives_the_body(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    off = replace(scene, check=replace(scene.check, equilibrium=(scene.field(Fraction(1, 5)), scene.field.zero)))
    result = decide(replace(off, check=replace(off.check, radius=scene.field(Fraction(1, 10)))))
    assert result.verdict is Equilibrium.FAILS
    assert result.separator is not None
    assert all(dot(result.separator, twist.velocity) > 0 for twist in result.twists)
    assert evidence_holds(result)


@pytest.mark.parametrize(
    ("point", "eq_3", "eq_4"),
    [
        ((Fraction(1, 4), 0), Equilibrium.HOLDS, Equilibrium.FAILS),  # on the axes eq. (3) rests
        ((0, Fraction(-1, 3)), Equilibrium.HOLDS, Equilibrium.FAILS),
        ((Fraction(1, 4), Fraction(1, 4)), Equilibrium.FAILS, Equilibrium.FAILS),
        ((Fraction(1, 4), Fraction(1, 8)), Equilibrium.FAILS, Equilibrium.FAILS),
        ((0, 0), Equilibrium.HOLDS, Equilibrium.HOLDS),
    ],
)
def test_equilibria_of_the_four_wheel_array(
    arrays: Arrays, point: tuple[Fraction | int, Fraction | int], eq_3: Equilibrium, eq_4: Equilibrium
) -> None:
    for friction, expected in ((SIDE, eq_3), (ROLL, eq_4)):
        scene = arrays.four_wheel(friction)
        there = (scene.field(point[0]), scene.field(point[1]))
        # leading order at the point: the pose rate there is the velocity in coordinates centred on it
        assert decide(replace(scene, check=replace(scene.check, equilibrium=there))).verdict is expected


@pytest.mark.parametrize("seed", range(10))
def test_moving_array_and_point_together_changes_nothing(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    shift = (scene.field(Fraction(17, 3)), scene.field(Fraction(-22, 7)))
    wheels = tuple(replace(w, position=(w.position[0] + shift[0], w.position[1] + shift[1])) for w in scene.wheels)
    moved = replace(scene, wheels=wheels, check=replace(scene.check, equilibrium=shift))
    assert decide(moved) == decide(scene)


def test_a_near_miss_is_a_miss(arrays: Arrays) -> None:
    """Beside the equilibrium of eq. (4), 10^-30 away, all velocities point back to it."""
    scene = arrays.four_wheel(ROLL)
    zero, tiny = scene.field.zero, scene.field(Fraction(1, 10**30))
    for point, expected in (((zero, zero), Equilibrium.HOLDS), ((tiny, zero), Equilibrium.FAILS)):
        result = decide(replace(scene, check=replace(scene.check, equilibrium=point)))
        assert result.verdict is expected
        assert evidence_holds(result)


# ---- evidence ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_tampered_weights_are_refused(arrays: Arrays, seed: int) -> None:
    result = decide(arrays.cocircular(seed))
    assert result.verdict is Equilibrium.HOLDS
    k = next(iter(result.weights))
    tampered = [
        replace(result, weights={}),
        replace(result, weights={**result.weights, k: result.weights[k] / 2}),
        replace(result, weights={j: -w for j, w in result.weights.items()}),
        replace(result, verdict=Equilibrium.FAILS),
        replace(result, verdict=Equilibrium.FAILS, separator=result.twists[0].velocity),
    ]
    assert not any(evidence_holds(wrong) for wrong in tampered)


@pytest.mark.parametrize(
    ("velocities", "weights"),
    [
        ([(1, 0), (2, 0)], [2, -1]),  # not convex
        ([(0, 1), (0, 3)], [HALF, HALF]),  # rest in x only
        ([(1, 0), (3, 0)], [HALF, HALF]),  # rest in y only
        ([(1, 0), (-1, 0)], [1, 1]),  # more than one in all
    ],
)
def test_weights_must_be_convex_and_rest_in_both_directions(
    velocities: list[tuple[int, int]], weights: list[int | Fraction]
) -> None:
    field = NumberField()
    twists = tuple(Twist(field(x), field(y), field.one) for x, y in velocities)
    mixture = {k: field(w) for k, w in enumerate(weights)}
    assert not evidence_holds(EquilibriumResult(Equilibrium.HOLDS, twists, mixture, None))


def test_a_tampered_separator_is_refused(arrays: Arrays) -> None:
    result = next(r for seed in range(30) if (r := decide(arrays.random(seed, 4))).verdict is Equilibrium.FAILS)
    assert result.separator is not None
    x, y = result.separator
    assert evidence_holds(result)
    assert not evidence_holds(replace(result, separator=(-x, -y)))
    assert not evidence_holds(replace(result, separator=(x * 0, y * 0)))
    assert not evidence_holds(replace(result, separator=None))
    assert not evidence_holds(replace(result, twists=()))
    assert not evidence_holds(replace(result, verdict=Equilibrium.HOLDS))


@pytest.mark.parametrize("seed", range(40))
def test_separating_direction_of_vectors_in_a_half_plane(seed: int) -> None:
    field = NumberField()
    rng = np.random.default_rng(seed)
    a, b = rng.integers(-9, 10, 2).tolist()
    axis = field(a or 1), field(b)
    vectors: list[Vector] = []
    while len(vectors) < 1 + seed % 6:
        x, y = (field(k) for k in rng.integers(-9, 10, 2).tolist())
        if dot(axis, (x, y)) > 0:
            vectors.append((x, y))
    direction = separating_direction(vectors)
    assert direction is not None
    assert all(dot(direction, v) > 0 for v in vectors)


@pytest.mark.parametrize(
    "vectors",
    [[(1, 0), (-1, 0)], [(0, 0)], [(1, 0), (0, 0)], [(1, 0), (-1, 1), (-1, -1)], [(1, 0), (0, 1), (-1, 0)]],
)
def test_no_separating_direction_of_vectors_around_the_origin(vectors: list[tuple[int, int]]) -> None:
    field = NumberField()
    assert separating_direction([(field(x), field(y)) for x, y in vectors]) is None
