"""Where the centre of mass is above the wheels: loads shift while a body accelerates, against springs in space."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import body_of
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.newton_euler import CREEP, MovingLoads, NewtonEuler, RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.proofs.answers.inertia import inertia_answer, near_rest
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.analysis.test_dynamics import random_model
from tests.oracles.tall_bodies import SprungBody

START = (0.1, 0.15, 0.0)
FLAT = RigidBody(0.3, 0.2)
TALL = RigidBody(0.3, 0.2, centre_height=0.4)
BESIDE = 2e-3  # relative distance from the printed limits at which eigenvalues are looked at


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_the_path_is_that_of_a_body_on_stiff_springs(seed: int) -> None:
    model, times = random_model(seed, 4 + seed % 3), np.linspace(0.0, 1.5, 30)
    flat, tall = (simulate_dynamics(model, body, START, 1.5).trajectory.sample(times) for body in (FLAT, TALL))
    friction = np.column_stack([model.sets.along, model.sets.across])
    sprung = SprungBody(
        model.positions, model.rows[::2, :2], model.speeds, friction, 0.3, 0.2, height=0.4, stiffness=3e4, creep=1e-5
    )
    seen = sprung.follow(np.array(START[:2]), times)
    assert np.abs(seen - tall).max() < 3e-5
    assert np.abs(flat - tall).max() > 2e-4


@pytest.mark.parametrize("seed", range(3))
def test_jacobian_is_the_derivative_of_the_rate(seed: int) -> None:
    model, rng, step = random_model(seed), np.random.default_rng(seed), 1e-6
    equations = NewtonEuler(model, TALL, MovingLoads(model, np.zeros(2)), creep=0.1)
    for _ in range(10):
        state = rng.uniform(-0.2, 0.2, 6)
        columns = [(equations(0, state + step * e) - equations(0, state - step * e)) / (2 * step) for e in np.eye(6)]
        assert np.abs(equations.jacobian(0, state) - np.array(columns).T).max() < 1e-6


def test_loads_balance_all_moments() -> None:
    """About the centre of mass: those of the loads, and those of friction h below it."""
    model = random_model(2, 6)
    equations, state = (
        NewtonEuler(model, TALL, MovingLoads(model, np.zeros(2)), CREEP),
        np.array([0.1, -0.1, 0, 0, 0, 0]),
    )
    loads = equations.loads.at(equations.pressed(state)[0])[0]
    force = TALL.mass * equations(0.0, state)[3:5]
    assert loads.sum() == pytest.approx(1.0)
    assert (loads > 0).all()
    assert loads @ (model.positions - state[:2]) == pytest.approx(-TALL.centre_height * force)


def test_a_tower_tips_as_soon_as_wheels_rub() -> None:
    model = random_model(0)
    with pytest.raises(LoadError, match="tip over"):
        simulate_dynamics(model, replace(TALL, centre_height=50.0), START, 1.0)


def ring(height: object, speed: object = 1, friction: object = "1/2") -> ns.Array:
    """Rims that lean, in metres: with mass the body may swing for ever."""
    body = {"mass": 1} if height is None else {"mass": 1, "centre_height": height}
    field = {"kind": "spiral", "angle": "pi/6", "speed": speed}
    return ns.Array.ring(
        4,
        radius="sqrt(2)",
        phase="pi/4",
        mu_roll=1,
        mu_side=friction,
        check_radius="1/2",
        rule="ellipse",
        length=1,
        field=field,
        units={"length": "m"},
        body=body,
    )


def growth(scene: Scene, factor: float, spin: float) -> float:
    """The largest real part of five eigenvalues at the middle, with all speeds this factor times as large."""
    own = scene.recentred()
    model, body = contact_model(own), body_of(own, factor**2 / float(own.inertia.gravity))  # type: ignore[union-attr]
    creep = 1e-3 * CREEP * float(np.abs(model.targets).max())
    equations = NewtonEuler(model, body, MovingLoads(model, np.zeros(2)), creep)
    matrix = equations.jacobian(0.0, np.array([0.0, 0.0, 0.0, 0.0, 0.0, spin]))
    kept = [0, 1, 3, 4, 5]
    return float(np.linalg.eigvals(matrix[np.ix_(kept, kept)]).real.max())


@pytest.mark.parametrize(("height", "friction"), [(None, "1/2"), ("1/10", "1/2"), ("1/4", "1/2"), ("1/5", "3/4")])
def test_speeds_up_to_which_it_is_stable_are_those_of_the_jacobian(height: object, friction: object) -> None:
    scene = ring(height, friction=friction).scene
    near = near_rest(scene)
    assert near.stable_to is not None
    assert near.unstable_at is not None
    assert growth(scene, float(near.stable_to) * (1 - BESIDE), near.spin) < 0
    assert growth(scene, float(near.unstable_at) * (1 + BESIDE), near.spin) > 0


def test_the_answer_says_how_high_the_centre_of_mass_is() -> None:
    low, high = (inertia_answer(ring(height).scene) for height in (None, "1/4"))
    assert low is not None
    assert high is not None
    assert "above the wheels" not in low.sentence
    assert "centre of mass 0.25 m above the wheels" in high.sentence
    assert (low["centre_height"], high["centre_height"]) == (None, Fraction(1, 4))
    assert low["stable_to"] != high["stable_to"]
