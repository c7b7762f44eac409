"""Full dynamics: derivatives, closed forms, invariances, energy, another integrator, and the quasi-static limit."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest
from cvxpy.atoms.quad_over_lin import quad_over_lin

from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.newton_euler import (
    EllipseFriction,
    MovingLoads,
    NewtonEuler,
    RigidBody,
    array_size,
    disc,
)
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.thorough import few, keep

PATH = 1e-6  # of paths: the integrator's tolerance and the creep speed, with room for their growth along the path
SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
START = (0.2, 0.4, 0.1)


def random_model(seed: int, wheels: int = 5, *, speeds: float = 1.0) -> ContactModel:
    """Wheels around the origin with random rims, speeds and frictions of their own."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(wheels) + rng.uniform(-0.3, 0.3, wheels)) / wheels
    positions = rng.uniform(0.8, 1.5, wheels)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    rims, friction = rng.normal(size=(wheels, 2)), rng.uniform(0.1, 1.0, size=(wheels, 2))
    return ContactModel.build(positions, rims, speeds * rng.uniform(-1, 1, wheels), friction)


def stopped(friction: tuple[float, float], rims: object = ((1.0, 0.0),) * 4) -> ContactModel:
    """Four wheels that stand still."""
    return ContactModel.build(SQUARE, rims, np.zeros(4), friction)  # type: ignore[arg-type]


# ---- loads and forces ----------------------------------------------------------------------------


def test_moving_loads_are_the_loads_at_every_point() -> None:
    for seed in range(5):
        model = random_model(seed, wheels=4 + seed)
        loads = MovingLoads(model, np.zeros(2))
        points = np.random.default_rng(seed).uniform(-1, 1, size=(300, 2))
        points = points[[loads.margin(point) >= 0 for point in points]]
        assert len(points) > 100
        moving = np.array([loads.at(point)[0] for point in points])
        assert np.abs(moving - loads_at(model, points)).max() < 1e-12


def test_load_table_is_followed_and_its_slope_is_its_own() -> None:
    table = np.array([[0.25, 0.1, 0.0], [0.25, -0.1, 0.1], [0.25, 0.0, -0.1], [0.25, 0.0, 0.0]])
    model = ContactModel.build(SQUARE, np.ones((4, 2)), np.ones(4), (1.0, 0.5), table)
    loads, slope = MovingLoads(model, np.zeros(2)).at(np.array([0.3, -0.2]))
    assert np.allclose(loads, loads_at(model, [[0.3, -0.2]])[0], atol=1e-15)
    assert np.array_equal(slope, table[:, 1:])


@pytest.mark.parametrize("height", [0.0, 0.4])  # of the centre of mass
@pytest.mark.parametrize("number", keep(1, range(4)))
def test_jacobian_is_the_derivative_of_the_rate(number: int, height: float) -> None:
    model, rng, step = random_model(number), np.random.default_rng(number), 1e-6
    body = RigidBody(0.3, 0.2, centre_height=height)
    equations = NewtonEuler(model, body, MovingLoads(model, np.zeros(2)), creep=0.1)
    for _ in range(10):
        state = rng.uniform(-0.2, 0.2, 6)
        columns = [(equations(0, state + step * e) - equations(0, state - step * e)) / (2 * step) for e in np.eye(6)]
        assert np.abs(equations.jacobian(0, state) - np.array(columns).T).max() < 1e-6


def test_forces_are_the_gradient_of_the_dissipation_with_its_sign() -> None:
    """One wheel, the rim along x, the body faster than the rim and drifting to the left: friction brakes both."""
    model = ContactModel.build([[0.0, 0.0]], [[1.0, 0.0]], [0.5], (1.0, 0.25))
    forces = EllipseFriction(model, 1e-9).forces(np.zeros(2), np.array([1.5, 2.0, 0.0]), np.array([2.0]))
    size = np.hypot(1.0 * 1.0, 0.25 * 2.0)
    assert np.allclose(forces[0], [-2.0 * 1.0 / size, -2.0 * 0.0625 * 2.0 / size], rtol=1e-12)


def test_friction_balances_at_the_minimizer_of_the_dissipation() -> None:
    """Where no wheel sticks, so that the creep speed plays no part."""
    compared = 0
    for seed in range(8):
        model = random_model(seed)
        points = np.random.default_rng(seed).uniform(-0.5, 0.5, size=(20, 2))
        loads = loads_at(model, points)
        twists = EllipseMinimizer().minimize(model, loads).twists
        sliding = (np.linalg.norm(model.slips(twists), axis=-1) > 1e-3).all(axis=1)
        friction = EllipseFriction(model, creep=1e-8)
        for point, load, (vx, vy, omega) in zip(points[sliding], loads[sliding], twists[sliding], strict=True):
            velocity = np.array([vx - omega * point[1], vy + omega * point[0], omega])  # of the centre of mass
            forces = friction.forces(point, velocity, load).reshape(-1)
            assert np.abs(friction.rows(point).T @ forces).max() < 1e-6
            compared += 1
    assert compared > 20


# ---- closed forms --------------------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("direction", [0.0, 0.7, np.pi / 2])
def test_isotropic_sliding_brakes_evenly_and_straight(direction: float) -> None:
    """Friction mu against v, whatever the loads: no torque because they balance moments; stops after m v/mu."""
    model, mass, speed, mu = stopped((0.4, 0.4)), 0.1, 1.5, 0.4
    along = np.array([np.cos(direction), np.sin(direction), 0.0])
    path = simulate_dynamics(model, disc(model, mass), START, 1.0, (speed * along).tolist())
    stop = mass * speed / mu
    for t in np.linspace(0, 0.99 * stop, 7):
        covered = speed * t - mu / mass * t**2 / 2
        assert np.allclose(path.trajectory.at(t), START + covered * along, atol=PATH)
    assert np.allclose(path.trajectory.end.state, START + mass * speed**2 / (2 * mu) * along, atol=10 * PATH)


@pytest.mark.parametrize(("axis", "mu"), [(0, 0.8), (1, 0.3)])
def test_parallel_rims_brake_by_their_own_coefficient(axis: int, mu: float) -> None:
    model, mass = stopped((0.8, 0.3)), 0.2
    velocity = np.eye(3)[axis]
    path = simulate_dynamics(model, disc(model, mass), (0.0, 0.0, 0.0), 0.1, velocity.tolist())
    expected = velocity * (0.1 - mu / mass * 0.01 / 2)
    assert np.allclose(path.trajectory.end.state, expected, atol=PATH)


def test_spin_about_the_middle_brakes_by_the_friction_of_all_wheels_across_their_rims() -> None:
    """Inward rims: ``I omega' = -mu_S R`` with R the distance of the wheels."""
    model = stopped((1.0, 0.5), rims=-np.array(SQUARE))
    body = RigidBody(0.1, 0.3)
    path = simulate_dynamics(model, body, (0.0, 0.0, 0.0), 0.3, (0.0, 0.0, 2.0))
    expected = 2.0 * 0.3 - 0.5 * np.sqrt(2) / 0.3 * 0.3**2 / 2
    assert np.allclose(path.trajectory.end.state, (0.0, 0.0, expected), atol=PATH)


def test_body_glides_over_wheels_without_friction() -> None:
    model = stopped((0.0, 0.0))
    path = simulate_dynamics(model, disc(model, 0.1), (0.1, 0.0, 0.0), 0.5, (0.3, -0.2, 1.0))
    assert np.allclose(path.trajectory.end.state, (0.25, -0.1, 0.5), atol=PATH)


def test_unit_of_mass_is_one_over_gravity() -> None:
    """From rest on parallel belts a body gains ``mu g t``, here with g = 1/m, until it has the belts' speed."""
    model = ContactModel.build(SQUARE, ((1.0, 0.0),) * 4, np.ones(4), (0.5, 0.5))
    path = simulate_dynamics(model, disc(model, 0.102), (0.0, 0.0, 0.0), 0.1)
    assert path.states[-1, 3] == pytest.approx(0.5 / 0.102 * 0.1, rel=PATH)


# ---- invariances ---------------------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("factor", [4.0, 1e-3])
def test_faster_wheels_under_a_lighter_body_follow_the_same_path_sooner(factor: float) -> None:
    model = random_model(3)
    fast = ContactModel.build(model.positions, model.rims, factor * model.speeds, model.friction.reshape(-1, 2))
    body = disc(model, 0.2)
    slow_path = simulate_dynamics(model, body, START, 1.0)
    lighter = RigidBody(body.mass / factor**2, body.inertia / factor**2)
    fast_path = simulate_dynamics(fast, lighter, START, 1.0 / factor)
    times = np.linspace(0, 1, 21)
    difference = slow_path.trajectory.sample(times) - fast_path.trajectory.sample(times / factor)
    assert np.abs(difference).max() < PATH


@few(1)
@pytest.mark.parametrize("away", [1.0, 1e5])
def test_turned_and_moved_array_turns_and_moves_the_path(away: float) -> None:
    model, angle, shift = random_model(4), 0.8, away * np.array([3.0, -2.0])
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    friction = model.friction.reshape(-1, 2)
    other = ContactModel.build(model.positions @ turned.T + shift, model.rims @ turned.T, model.speeds, friction)
    path = simulate_dynamics(model, disc(model, 0.1), START, 1.0).trajectory
    start = (*(turned @ START[:2] + shift), START[2])
    moved = simulate_dynamics(other, disc(other, 0.1), start, 1.0).trajectory
    times = np.linspace(0, 1, 21)
    expected = path.sample(times)
    expected[:, :2] = expected[:, :2] @ turned.T + shift
    assert np.abs(moved.sample(times) - expected).max() < PATH


@few(1)
@pytest.mark.parametrize("seed", range(4))
def test_stopped_wheels_only_take_energy(seed: int) -> None:
    model, rng = random_model(seed, speeds=0.0), np.random.default_rng(seed)
    body = disc(model, 0.1)
    path = simulate_dynamics(model, body, START, 1.0, rng.uniform(-1, 1, 3).tolist())
    energy = (np.array([body.mass, body.mass, body.inertia]) * path.states[:, 3:] ** 2).sum(axis=1) / 2
    assert energy[0] > 0.01
    assert (np.diff(energy) <= 1e-12 * energy[0]).all()
    assert energy[-1] < 1e-9 * energy[0]


# ---- another integrator --------------------------------------------------------------------------


def moreau_path(model: ContactModel, body: RigidBody, start: tuple[float, ...], until: float, steps: int) -> Floats:
    """Poses by Moreau's time stepping: set-valued friction, no creep speed, one cone program for each step.

    ``min_z (z - z_k)^T M (z - z_k)/2 + h D(z)`` for the velocity z at the end of a step of length h.
    """
    step, masses = until / steps, np.array([body.mass, body.mass, body.inertia])
    z, old, sizes = cp.Variable(3), cp.Parameter(3), cp.Variable(model.wheels)
    rows = [cp.Parameter((2, 3)) for _ in range(model.wheels)]  # times mu N h
    targets = [cp.Parameter(2) for _ in range(model.wheels)]
    cones = [cp.SOC(sizes[k], rows[k] @ z - targets[k]) for k in range(model.wheels)]
    problem = cp.Problem(cp.Minimize(quad_over_lin(np.diag(np.sqrt(masses / 2)) @ (z - old), 1) + sum(sizes)), cones)
    arms = EllipseFriction(model, 1.0)
    pose, velocity, poses = np.array(start), np.zeros(3), [np.array(start)]
    for _ in range(steps):
        old.value = velocity
        limits = step * model.limits(loads_at(model, pose[None, :2])[0])
        for k, pair in enumerate(arms.rows(pose[:2]).reshape(-1, 2, 3)):
            rows[k].value = limits[k][:, None] * pair
            targets[k].value = limits[k] * model.targets[2 * k : 2 * k + 2]
        problem.solve(solver=cp.CLARABEL)
        velocity = np.asarray(z.value)
        pose = pose + step * velocity
        poses.append(pose)
    return np.array(poses)


def test_path_is_that_of_set_valued_friction() -> None:
    """Time stepping is of first order: two step sizes extrapolate to the path."""
    model = contact_model(load_scene("four-wheel"))
    body, until, steps = disc(model, 0.1), 0.4, 40
    coarse, fine = (moreau_path(model, body, (0.2, 0.4, 0.0), until, n) for n in (steps, 2 * steps))
    path = simulate_dynamics(model, body, (0.2, 0.4, 0.0), until).trajectory.sample(np.linspace(0, until, steps + 1))
    assert np.abs(path - coarse).max() < 0.01
    assert np.abs(path - (2 * fine[::2] - coarse)).max() < 0.001


# ---- where a path ends ---------------------------------------------------------------------------


def test_path_ends_where_the_body_tips() -> None:
    model = contact_model(load_scene("outward"))
    path = simulate_dynamics(model, disc(model, 0.1), (0.2, 0.4, 0.0), 5.0).trajectory
    x, y, _ = path.end.state
    assert path.end.reason is EndReason.TIPS
    assert path.end.t < 5.0
    assert max(abs(x), abs(y)) == pytest.approx(1.0, abs=1e-9)


def test_path_ends_where_a_load_of_the_table_vanishes() -> None:
    table = np.array([[0.25, -1.0, 0.0], [0.25, 1.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    model = ContactModel.build(SQUARE, ((1.0, 0.0),) * 4, np.ones(4), (0.5, 0.5), table)
    path = simulate_dynamics(model, disc(model, 0.01), (0.0, 0.0, 0.0), 5.0).trajectory
    assert path.end.reason is EndReason.LOADS
    assert path.end.state[0] == pytest.approx(0.25, abs=1e-9)


def test_start_without_loads_is_refused() -> None:
    model = contact_model(load_scene("four-wheel"))
    with pytest.raises(LoadError, match="the body tips there"):
        simulate_dynamics(model, disc(model, 0.1), (1.2, 0.0, 0.0), 1.0)


@pytest.mark.parametrize(("mass", "inertia"), [(0.0, 1.0), (1.0, -1.0), (np.inf, 1.0), (1.0, np.nan)])
def test_body_without_positive_mass_is_refused(mass: float, inertia: float) -> None:
    with pytest.raises(ValueError, match="required a positive number"):
        RigidBody(mass, inertia)


def test_disc_is_as_large_as_the_array() -> None:
    model = contact_model(load_scene("four-wheel"))
    assert array_size(model) == pytest.approx(np.sqrt(2))
    assert disc(model, 0.3).inertia == pytest.approx(0.3)
