"""Translation verdicts against paths that share no theory with them: ties, circles, long trajectories."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.clauses.at_point.cocircular import cocircular_array, failed_hypotheses
from nonsmooth.proofs.clauses.equilibrium.clause import decide_equilibrium
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_fan
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings import Equilibrium, Theorem4, Translation
from nonsmooth.proofs.theorem4 import check_cells, check_theorem4
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from tests.array_certificates import check_certificate, said, subject
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.oracles.box_paths import box_contradiction, contradiction, observe_box
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.nearest_paths import End, Wheel, observe
from tests.oracles.tied_arrays import (
    CENTRE,
    FOUND,
    LEAVES_FROM_1E_9,
    LEAVES_LIKE_A_ROOT,
    found_by_search,
    scene_of,
    tied_array,
    tied_box,
    untied_array,
)
from tests.proofs.forged import with_results
from tests.thorough import thorough

# ---- Translation verdicts of arrays with exact coincidences, against paths that know nothing of the fan of cones.

TIED, UNTIED = 300, 100
BLOCKS, UNTIED_BLOCKS = 30, 10


def compare(arrays: Arrays, wheels: list[Wheel], seed: int) -> Translation:
    result = decide_translation(build_nearest_partition(scene_of(arrays, wheels)))
    assert evidence_holds(result)
    reason = contradiction(result, observe(wheels, seed=seed))
    assert not reason, f"seed {seed}: {reason}; {wheels}"
    return result.verdict


# ---- arrays that were certified asymptotically stable ------------------------------------------


@pytest.mark.parametrize("wheels", [LEAVES_LIKE_A_ROOT, LEAVES_FROM_1E_9])
def test_a_velocity_along_a_ray_that_omega_bends_outward_lets_full_turns_diverge(
    arrays: Arrays, wheels: list[Wheel]
) -> None:
    assert observe(wheels, seed=0) == {End.LEAVES}
    result = check_theorem4(scene_of(arrays, wheels))
    assert result.translation.verdict is Translation.UNSTABLE
    assert result.verdict is Theorem4.FAILS
    assert result.check()


@pytest.mark.parametrize("wheels", [LEAVES_LIKE_A_ROOT, LEAVES_FROM_1E_9])
def test_a_verdict_that_the_own_paths_contradict_is_undecided(arrays: Arrays, wheels: list[Wheel]) -> None:
    result = check_cells(scene_of(arrays, wheels))
    forged = replace(result.translation, verdict=Translation.ASYMPTOTICALLY_STABLE)
    left, answered = reconciled(with_results(result, translation=forged))
    between = {one.between: one.sides for one in left.contradictions}
    said, seen = between["position and a path"]
    assert said.startswith("position comes home")
    assert seen.startswith("the path from")
    assert left.results["translation"].verdict is Translation.UNDECIDED
    assert left.verdict is Theorem4.UNDECIDED
    assert answered.answers[0].verdict is Position.UNDECIDED


def test_half_planes_whose_velocity_lies_along_their_line_have_gain_one(arrays: Arrays) -> None:
    assert observe(CENTRE, seed=0) == {End.CYCLES}
    result = decide_translation(build_nearest_partition(scene_of(arrays, CENTRE)))
    assert result.verdict is Translation.UNDECIDED
    assert result.fan is not None
    assert set(result.fan.gains.values()) == {1}


def test_the_oracle_follows_half_a_turn_about_the_point_itself() -> None:
    """In a half-plane with v = 0 the exit lies half a turn away, where the parameter of the arc is infinite."""
    wheels, _ = tied_array(1_031_836)
    assert observe(wheels, seed=1_031_836, starts=6) == {End.ARRIVES}


@thorough  # the others follow arrays of the file
def test_the_file_lists_the_arrays_that_a_search_finds() -> None:
    assert np.loadtxt(FOUND, dtype=int, delimiter=",").tolist() == found_by_search()


# ---- many --------------------------------------------------------------------------------------


@pytest.mark.parametrize("block", range(BLOCKS))
def test_verdicts_of_tied_arrays_agree_with_paths(arrays: Arrays, block: int) -> None:
    size = TIED // BLOCKS
    for seed in range(size * block, size * (block + 1)):
        wheels, _ = tied_array(seed)
        compare(arrays, wheels, seed)


@pytest.mark.parametrize("block", range(UNTIED_BLOCKS))
def test_verdicts_of_untied_arrays_agree_with_paths_and_are_decided(arrays: Arrays, block: int) -> None:
    size = UNTIED // UNTIED_BLOCKS
    seeds = range(size * block, size * (block + 1))
    verdicts = Counter(compare(arrays, untied_array(seed), seed) for seed in seeds)
    assert verdicts[Translation.UNDECIDED] == 0


# ---- Translation verdicts under rule ``box`` at corners of the cells, against paths that do not use the cells.

TIED_BOXES, BOX_BLOCKS = 50, 25


@pytest.mark.parametrize("block", range(BOX_BLOCKS))
def test_verdicts_at_corners_of_cells_agree_with_paths(arrays: Arrays, block: int) -> None:
    size = TIED_BOXES // BOX_BLOCKS
    for seed in range(size * block, size * (block + 1)):
        wheels, at, partition = tied_box(arrays, seed)
        result = decide_translation(partition)
        assert evidence_holds(result)
        reason = box_contradiction(result, observe_box(wheels, at))
        assert not reason, f"seed {seed}: {reason}; at {at}, {wheels}"


def test_a_stable_corner_lets_the_distance_grow_two_hundredfold(arrays: Arrays) -> None:
    """A velocity that leaves its cell at an angle of 0.0047 rad: paths grow as far as the fan bounds, and rest."""
    wheels, at, partition = tied_box(arrays, 1_000_254)
    result = decide_translation(partition)
    assert result.verdict is Translation.STABLE
    assert result.fan is not None
    assert result.fan.squared_overshoot is not None
    assert 200 < float(result.fan.squared_overshoot) ** 0.5 < 220
    assert observe_box(wheels, at).rested == 24


def inward_array(arrays: Arrays, seed: int) -> Scene:
    """Inward rims at random rational points of one circle, random positive speeds, random mu_S per wheel."""
    rng = np.random.default_rng(seed)
    parameters = {Fraction(int(a), int(b)) for a, b in rng.integers([-9, 1], [10, 6], (int(rng.integers(3, 7)), 2))}
    wheels = []
    for x, y in sorted({arrays.circle_point(t) for t in parameters} | {(Fraction(-1), Fraction(0))}):
        speed = Fraction(int(rng.integers(1, 5)), 2)
        (wheel,) = arrays.inward([(x, y)], speed=speed)
        wheels.append(wheel._replace(friction=(1, Fraction(int(rng.integers(1, 30)), 10))))
    return replace(arrays.scene(wheels, radius=Fraction(1, 16)), contact=Contact("box"))


@pytest.mark.parametrize("seed", range(60))
def test_the_lemma_holds_on_every_cell_of_random_inward_arrays(arrays: Arrays, seed: int) -> None:
    scene = inward_array(arrays, seed)
    try:
        partition = build_box_partition(scene)
    except LoadError:
        return  # the support polygon does not hold the square
    lemma = cocircular_array(scene)
    assert lemma is not None
    assert all(derivative.largest[0].sign() <= 0 for derivative in cell_derivatives(partition))


def test_most_random_arrays_support_the_body(arrays: Arrays) -> None:
    """The test above is no empty promise."""
    supported = 0
    for seed in range(60):
        try:
            build_box_partition(inward_array(arrays, seed))
            supported += 1
        except LoadError:
            pass
    assert supported >= 20


def test_each_hypothesis_is_needed_and_named(arrays: Arrays) -> None:
    scene = replace(arrays.four_wheel(), contact=Contact("box"))
    assert failed_hypotheses(scene) == []
    first, *rest = scene.wheels
    field = scene.field
    cases = {
        "rule nearest": replace(scene, contact=Contact("nearest")),
        "one circle": replace(scene, wheels=(replace(first, position=(field(2), field(2))), *rest)),
        "inward": replace(scene, wheels=(replace(first, direction=(field(1), field(1))), *rest)),
        "speed": replace(scene, wheels=(replace(first, given_speed=field(-1)), *rest)),
        "mu_roll": replace(scene, wheels=(replace(first, friction=replace(first.friction, roll=field(2))), *rest)),
        "moments": replace(scene, contact=Contact("box", LoadTable(((field.one / 4, field.zero, field.zero),) * 4))),
    }
    for word, changed in cases.items():
        (reason,) = failed_hypotheses(changed)
        assert word in reason
        assert cocircular_array(changed) is None


def test_a_table_that_balances_moments_is_accepted(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    quarter = scene.field.one / 4
    rows = tuple((quarter, w.position[0] * quarter, w.position[1] * quarter) for w in scene.wheels)
    assert cocircular_array(replace(scene, contact=Contact("ellipse", LoadTable(rows)))) is not None


# ---- Translation verdicts against long Filippov trajectories with exact kinematics, from starts near the
# equilibrium.

# Distance of the starts: an array can be stable and first move away a hundredfold, so only starts this close stay in
# the cells at the equilibrium, where linear terms no longer count.
CLOSE = 1e-8
LONG = 40.0  # time; speeds are of order one
GROWN = 20.0  # an unstable array takes some start this many times farther away


def random_array(arrays: Arrays, seed: int) -> Scene:
    """3 to 8 wheels at rational points of a circle, radial, elliptic or spiral rims, both friction orders."""
    rng = np.random.default_rng(seed)
    points: dict[tuple[Fraction, Fraction], None] = {}
    while len(points) < rng.integers(3, 9):
        x, y = arrays.circle_point(Fraction(int(rng.integers(-20, 21)), int(rng.integers(1, 13))))
        points[Fraction(x), Fraction(y)] = None
    kind = rng.choice(["radial", "elliptic", "spiral"])
    a, b = (int(v) for v in rng.integers(1, 5, 2))
    turn = arrays.circle_point(Fraction(int(rng.integers(-8, 9)), 16)) if kind == "spiral" else (1, 0)
    wheels = arrays.inward(points, turn)
    if kind == "elliptic":
        wheels = [w._replace(direction=(-a * w.position[0], -b * w.position[1])) for w in wheels]
    friction = ROLL if rng.random() < 0.5 else SIDE
    return arrays.scene(wheels, friction)


def farthest_and_last(scene: Scene, starts: int) -> tuple[list[float], list[float]]:
    """Largest and last distance from the equilibrium, relative to the start's, for every start."""
    field = array_field(build_nearest_partition(scene), Kinematics.EXACT)
    far, last = [], []
    for angle in np.linspace(0.05, math.tau + 0.05, starts, endpoint=False):
        path = simulate(field, (CLOSE * math.cos(angle), CLOSE * math.sin(angle), 0.0), LONG)
        distances = np.hypot(path.array[:, 0], path.array[:, 1]) / CLOSE
        far.append(float(distances.max()))
        last.append(float(distances[-1]))
    return far, last


def is_followed(fan: FanResult) -> bool:
    """Whether instability shows to a trajectory that chooses no repelling slide: an escape or an outward spiral."""
    return any(evidence.move in (Move.ESCAPE, Move.TURN) for evidence in fan.evidence)


def compare_with_trajectories(arrays: Arrays, seed: int, starts: int) -> str:
    """Check one array; what was compared."""
    scene = random_array(arrays, seed)
    partition = build_nearest_partition(scene)
    if decide_equilibrium(partition).verdict is not Equilibrium.HOLDS:
        return "no equilibrium"
    result, fan = decide_translation(partition), decide_fan(partition)
    if result.verdict is Translation.UNDECIDED:
        return "undecided"
    far, last = farthest_and_last(scene, starts)
    if result.verdict is Translation.UNSTABLE:
        assert not is_followed(fan) or max(far) > GROWN
        return "unstable"
    assert fan.squared_overshoot is not None
    assert max(far) <= math.sqrt(float(fan.squared_overshoot)) * 1.01
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        assert max(last) < 1e-3  # arrived, to rounding
    return str(result.verdict)


@pytest.mark.parametrize("block", range(8))
def test_verdicts_agree_with_trajectories(arrays: Arrays, block: int) -> None:
    counts = Counter(compare_with_trajectories(arrays, seed, starts=8) for seed in range(10 * block, 10 * block + 10))
    assert counts["undecided"] == 0


@thorough  # about all random cases, which `make bench` runs
def test_all_verdicts_occur(arrays: Arrays) -> None:
    counts = Counter(compare_with_trajectories(arrays, seed, starts=4) for seed in range(60))
    assert {"stable", "asymptotically stable", "unstable", "no equilibrium"} <= set(counts)


@thorough  # five hundred arrays, 32 starts each
def test_few_verdicts_are_open(arrays: Arrays) -> None:
    counts = Counter(compare_with_trajectories(arrays, seed, starts=32) for seed in range(1000, 1500))
    assert counts["undecided"] <= 0.02 * 500


# ---- What the checker accepts about translation, against paths that share no theory with it ------
#
# The workbench's own decision of an array that is built anew rests on the checker's theorems: an error in these would
# pass. Here the array of each certificate is read back from its own data and followed by the definitions; so are the
# arrays of mutants (tests/proofs/attacks.py).

Record: TypeAlias = dict[str, Any]

CERTIFIED_BLOCKS = 30
FORBIDDEN: dict[str | None, set[End]] = {
    "asymptotically stable": {End.LEAVES, End.RESTS, End.CYCLES},
    "stable": {End.LEAVES},
    None: set(),
}


def wheels_of(certificate: Record) -> list[Wheel]:
    """The wheels as fractions, seen from the checked point."""
    x, y = (Fraction(text) for text in subject(certificate)["at"])
    wheels = []
    for wheel in subject(certificate)["wheels"]:
        (px, py), (dx, dy), (roll, side) = (map(Fraction, wheel[key]) for key in ("position", "direction", "friction"))
        wheels.append(Wheel((px - x, py - y), (dx, dy), Fraction(wheel["speed"]), roll, side))
    return wheels


@lru_cache(maxsize=100)
def paths_end(wheels: tuple[Wheel, ...], seed: int) -> set[End]:
    """Most mutants of a certificate leave its array as it is."""
    return observe(wheels, seed=seed)


def assert_paths_agree(certificate: Record, seed: int) -> None:
    word = said(certificate).get("translation")
    ends = paths_end(tuple(wheels_of(certificate)), seed)
    if word == "unstable":
        assert End.LEAVES in ends
    else:
        assert not ends & FORBIDDEN[word], f"seed {seed}: {word}, but paths end {ends}"


@pytest.mark.parametrize("block", range(CERTIFIED_BLOCKS))
def test_accepted_certificates_of_tied_arrays_agree_with_paths(arrays: Arrays, block: int) -> None:
    wheels, _ = tied_array(block)
    original = build_certificate(check_cells(scene_of(arrays, wheels)))
    assert check_certificate(original) == ""
    assert_paths_agree(original, block)
