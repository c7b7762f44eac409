"""Translation verdicts against long Filippov trajectories with exact kinematics, from starts near the equilibrium."""

from __future__ import annotations

import math
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.equilibrium.clause import decide_equilibrium
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_fan
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.thorough import thorough

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


def compare(arrays: Arrays, seed: int, starts: int) -> str:
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
    seen = Counter(compare(arrays, seed, starts=8) for seed in range(10 * block, 10 * block + 10))
    assert seen["undecided"] == 0


@thorough  # about all random cases, which `make bench` runs
def test_all_verdicts_occur(arrays: Arrays) -> None:
    seen = Counter(compare(arrays, seed, starts=4) for seed in range(60))
    assert {"stable", "asymptotically stable", "unstable", "no equilibrium"} <= set(seen)
