"""Minimizers and cells of wheels with friction axes against the definition of D, written here once more from vectors.

The oracle knows no rows: a wheel at p slips by ``q = v + omega J p - u e``, of which friction sees the part along the
axis a and the part along J a.  CVXPY minimizes the sum over the wheels as it stands.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import cvxpy
import numpy as np
import pytest
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.dynamics.newton_euler import EllipseFriction
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.sampling import greedy_twist
from nonsmooth.analysis.motion.frames import wheel_slips
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.thorough import few

Floats: TypeAlias = NDArray[np.float64]

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
        sampled, _ = greedy_twist([scene.wheels[k] for k in order])
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
