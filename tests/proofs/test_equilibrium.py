"""Clauses 1 and 3: whether 0 lies in F(c*), and the drift of theta there."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumResult, decide_equilibrium
from nonsmooth.proofs.clauses.rotation.clause import RotationResult, decide_rotation, drift_at_rest
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import Vector, dot, separating_direction
from tests.conftest import Arrays, WheelData
from tests.four_wheel import ROLL, SIDE
from tests.hulls import hull_holds_zero
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few, thorough

# ---- Clause 1: whether 0 lies in F(c*), with convex weights or a separating direction as evidence.

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
    verdicts = {decide(s).verdict for seed in range(30) for s in (arrays.random(seed, 4), arrays.cocircular(seed))}
    assert verdicts == {Equilibrium.HOLDS, Equilibrium.FAILS}


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


# ---- Clause 3: the drift of theta at the equilibrium, and the bound on its total rotation where there is none.

# HiGHS solves to 1e-7 feasibility; rotation rates here are below 100.
SOLVER_TOLERANCE = 1e-5


def rotation_of(scene: Scene) -> RotationResult:
    partition = build_nearest_partition(scene.recentred())
    return decide_rotation(partition, decide_translation(partition))


@few(3)
@pytest.mark.parametrize("n", range(3, 13))
def test_drift_of_rings_is_the_closed_form(arrays: Arrays, n: int) -> None:
    """``[-tan(delta/2), tan(delta/2)]`` with roll rows, ``[-cot(delta/2), cot(delta/2)]`` with side rows."""
    for friction in (ROLL, SIDE):
        scene = arrays.ring(n, friction)
        cos, sin = scene.field.cos_pi(Fraction(1, n)), scene.field.sin_pi(Fraction(1, n))
        top = sin / cos if friction == ROLL else cos / sin
        result = rotation_of(scene)
        assert result.verdict is Rotation.UNSTABLE
        assert result.drift is not None
        assert result.drift.interval == (-top, top)
        assert evidence_holds(result)


def test_drift_of_the_four_wheel_array(arrays: Arrays) -> None:
    for friction in (ROLL, SIDE):
        scene = arrays.four_wheel(friction)
        result = rotation_of(scene)
        half_root = scene.field.sqrt(2) / 2
        assert result.drift is not None
        assert result.drift.interval == (-half_root, half_root)


@pytest.mark.parametrize("seed", range(40))
def test_drift_agrees_with_highs(arrays: Arrays, seed: int) -> None:
    partition = build_nearest_partition(arrays.cocircular(seed))
    zero = partition.scene.field.zero
    twists = filippov_twists(partition, (zero, zero))
    drift = drift_at_rest(twists)
    columns = np.array([[float(t.vx), float(t.vy), 1.0] for t in twists]).T
    rates = np.array([float(t.omega) for t in twists])
    ends = [linprog(s * rates, A_eq=columns, b_eq=[0, 0, 1], method="highs") for s in (1, -1)]
    assert drift is not None
    low, high = drift.interval
    assert float(low) == pytest.approx(ends[0].fun, abs=SOLVER_TOLERANCE)
    assert float(high) == pytest.approx(-ends[1].fun, abs=SOLVER_TOLERANCE)


@pytest.mark.parametrize("seed", range(40))
def test_both_ends_are_mixtures_at_rest(arrays: Arrays, seed: int) -> None:
    """The weights are the witness: translation 0, rotation rate the end of the interval."""
    result = rotation_of(arrays.cocircular(seed))
    assert result.drift is not None
    low, high = result.drift.interval
    for mixture, rate in ((result.drift.lowest, low), (result.drift.highest, high)):
        assert sum(mixture.weights.values()) == 1
        assert min(mixture.weights.values()) > 0
        for axis, expected in enumerate((0, 0, rate)):
            terms = [w * result.drift.twists[k][axis] for k, w in mixture.weights.items()]
            assert sum(terms) == expected
    assert (result.verdict is Rotation.UNSTABLE) == bool(low or high)


def test_no_equilibrium_no_statement(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    off = (scene.field(Fraction(1, 5)), scene.field(Fraction(1, 50)))
    result = rotation_of(replace(scene, check=replace(scene.check, equilibrium=off)))
    assert result.verdict is Rotation.UNDECIDED
    assert result.drift is None
    assert evidence_holds(result)


def test_a_body_that_no_cell_turns_keeps_its_heading(arrays: Arrays) -> None:
    """Two wheels that face each other never turn the body, though (0, y) is a line of equilibria."""
    result = rotation_of(arrays.scene(arrays.inward([(1, 0), (-1, 0)])))
    assert result.verdict is Rotation.NEUTRAL
    assert result.rotation_per_distance == 0
    assert evidence_holds(result)
    assert result.drift is not None
    assert not any(result.drift.interval)


# ---- no drift: theta is stable and the total rotation is bounded ---------------------------------

Rates: TypeAlias = dict[tuple[int, int], int]

QUADRANT_RATES: Rates = {(1, 1): 1, (-1, 1): 2, (-1, -1): -1, (1, -1): -2}  # they cancel in opposite quadrants


def quadrant_system(arrays: Arrays, rates: Rates = QUADRANT_RATES) -> Partition:
    """``v = (-sgn x, -sgn y)`` with one rotation rate per quadrant, on the cells of the four-wheel array."""
    partition = build_nearest_partition(arrays.four_wheel())
    field = partition.scene.field

    def rewritten(cell: Cell) -> Cell:
        sx, sy = (x.sign() for x in cell.polygon.centre)
        twist = Twist(field(-sx), field(-sy), field(rates[sx, sy]))
        return replace(cell, states=(ContactState(cell.states[0].rows, twist),))

    return replace(partition, cells=tuple(rewritten(cell) for cell in partition.cells))


def total_rotation(x: Fraction, y: Fraction) -> Fraction:
    """Along the diagonal to an axis, then in the sliding mode along it: half of each neighbouring quadrant."""
    sx, sy = (1 if x > 0 else -1), (1 if y > 0 else -1)
    first = min(abs(x), abs(y))
    other = (-sx, sy) if abs(x) < abs(y) else (sx, -sy)
    sliding = Fraction(QUADRANT_RATES[sx, sy] + QUADRANT_RATES[other], 2)
    return QUADRANT_RATES[sx, sy] * first + sliding * abs(abs(x) - abs(y))


def test_total_rotation_stays_within_the_bound(arrays: Arrays) -> None:
    partition = quadrant_system(arrays)
    translation = decide_translation(partition)
    result = decide_rotation(partition, translation)
    assert translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert translation.decay_rate == 2
    assert result.verdict is Rotation.NEUTRAL
    assert result.drift is not None
    assert not any(result.drift.interval)
    assert result.rotation_per_distance == 2
    assert evidence_holds(result)
    for a in range(-5, 6):
        for b in range(-5, 6):
            if a and b:
                turned = total_rotation(Fraction(a, 20), Fraction(b, 20))
                assert turned**2 <= 4 * Fraction(a * a + b * b, 400)


@pytest.mark.parametrize(("rate", "ends"), [(-1, (-1, 0)), (1, (0, 1))])
def test_a_drift_of_one_sense_is_drift(arrays: Arrays, rate: int, ends: tuple[int, int]) -> None:
    """One pair of opposite quadrants turns the body, the other does not: it may rest, and it may spin."""
    rates: Rates = {(1, 1): 0, (-1, 1): rate, (-1, -1): 0, (1, -1): rate}
    partition = quadrant_system(arrays, rates)
    result = decide_rotation(partition, decide_translation(partition))
    assert result.verdict is Rotation.UNSTABLE
    assert result.drift is not None
    assert [float(w) for w in result.drift.interval] == list(ends)
    assert evidence_holds(result)


# ---- evidence ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_tampered_drifts_are_refused(arrays: Arrays, seed: int) -> None:
    result = rotation_of(arrays.cocircular(seed))
    assert result.drift is not None
    high, low = result.drift.highest, result.drift.lowest
    assert evidence_holds(result)
    wrong = [
        replace(result, drift=replace(result.drift, highest=replace(high, value=high.value + 1))),
        replace(result, drift=replace(result.drift, highest=replace(high, weights={}))),
        replace(result, drift=replace(result.drift, lowest=replace(low, multipliers=(low.value + 1,) * 3))),
        replace(result, verdict=Rotation.NEUTRAL),
    ]
    wrong += [replace(result, drift=None)] * (result.verdict is Rotation.UNSTABLE)
    wrong += [replace(result, verdict=Rotation.UNSTABLE)] * (result.verdict is Rotation.UNDECIDED)
    assert not any(evidence_holds(r) for r in wrong)


def test_a_claim_of_stability_needs_its_bound_and_a_claim_of_spin_its_drift(arrays: Arrays) -> None:
    partition = quadrant_system(arrays)
    result = decide_rotation(partition, decide_translation(partition))
    assert not evidence_holds(replace(result, rotation_per_distance=None))
    assert not evidence_holds(replace(result, verdict=Rotation.UNSTABLE))
    assert not evidence_holds(replace(result, drift=None))


def test_a_body_that_leaves_the_square_may_turn_beyond_it(arrays: Arrays) -> None:
    """Near the point no cell turns the body, but it leaves and meets a wheel that does: theta is not bounded.

    The path is followed by the definition, in small steps: from 1e-4 the body turns by more than one radian.
    """
    wheels = [WheelData((1, 0), (1, 0), 1), WheelData((-1, 0), (-1, 0), 1), WheelData((3, 1), (0, 1), 5)]
    scene = arrays.scene(wheels, radius=Fraction(1, 4))
    assert turned_from(scene, (1e-4, 0.0), until=3.0) > 1.0
    result = rotation_of(scene)
    assert result.verdict is Rotation.UNDECIDED
    assert evidence_holds(result)


def turned_from(scene: Scene, start: tuple[float, float], until: float) -> float:
    """Largest rotation along Euler steps of rule ``nearest``, from the rows of the two nearest wheels."""
    x, y, theta, most, step = *start, 0.0, 0.0, 1e-3
    for _ in range(round(until / step)):
        ordered = sorted(scene.wheels, key=lambda w: (x - float(w.position[0])) ** 2 + (y - float(w.position[1])) ** 2)
        rows, speeds = [], []
        for k, wheel in enumerate(ordered[:2]):
            (px, py), (dx, dy) = (tuple(map(float, v)) for v in (wheel.position, wheel.direction))
            rows.append((dx, dy, dy * px - dx * py))
            speeds.append(float(wheel.speed))
            if k == 0:
                rows.append((-dy, dx, dx * px + dy * py))
                speeds.append(0.0)
        if abs(np.linalg.det(rows)) < 1e-12:  # the roll row of the second wheel is dependent: its side row follows
            (px, py), (dx, dy) = (tuple(map(float, v)) for v in (ordered[1].position, ordered[1].direction))
            rows[2], speeds[2] = (-dy, dx, dx * px + dy * py), 0.0
        vx, vy, omega = np.linalg.solve(rows, speeds)
        x, y, theta = x + step * (vx - omega * y), y + step * (vy + omega * x), theta + step * omega
        most = max(most, abs(theta))
    return most
