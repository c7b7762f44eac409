"""A body with mass and an outline against small Euler steps, whose geometry, loads and forces are written anew."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_path import HELD, MassPath, simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import plate
from nonsmooth.analysis.dynamics.newton_euler import DynamicPath, RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.trajectories.result import EndReason, EventKind
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays, WheelData
from tests.oracles.small_steps import small_steps_of_mass
from tests.outlined import Depths, Pair, on, polygon_depths, polygon_of
from tests.thorough import keep, thorough

CREEP = 1e-3  # of the small steps: explicit steps take no less
OFF = 3e-3  # lengths and radians: what that creep and the steps change
POSE_ERROR = 1e-9


def followed(scene: Scene, body: RigidBody, start: tuple[float, float, float], until: float) -> DynamicPath:
    array = whole(scene)
    return MassPath(contact_model(array), body, array).follow(start, until)


def carton() -> tuple[Scene, Depths]:
    scene = load_scene("carton-on-6x6")
    assert scene.body is not None
    corners = np.array([[float(x) for x in corner] for corner in scene.body.vertices])
    return scene, partial(polygon_depths, corners)


@pytest.mark.parametrize(("until", "steps"), keep(1, [(0.6, 1000), (0.8, 2000)]))
def test_wheels_enter_and_leave_as_in_small_steps(until: float, steps: int) -> None:
    scene, depths = carton()
    start, masses = (1.3, 0.15, 0.0), (0.1, 0.15)
    path = followed(scene, RigidBody(*masses), start, until)
    kinds = [event.kind for event in path.trajectory.events]
    assert kinds == [EventKind.LEAVE, EventKind.LEAVE, EventKind.ENTER, EventKind.ENTER]
    expected = small_steps_of_mass(scene, depths, np.array(start), until, steps, masses, CREEP)
    assert np.abs(path.states[-1][:3] - expected[:3]).max() < OFF
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    for event in path.trajectory.events:
        wheel = int(event.surface.split()[1]) - 1
        assert abs(depths(places[[wheel]], np.array(event.state))[0]) < POSE_ERROR


def pushed_back(arrays: Arrays) -> tuple[Scene, Depths]:
    """Four wheels carry a plate to the right and up, onto a fifth of more grip that runs to the left."""
    ways = [(10, 3), (10, 4), (12, 3), (11, 5)]
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    wheels = [WheelData(at, way, Fraction(1, 2)) for at, way in zip(corners, ways, strict=True)]
    scene = arrays.scene([*wheels, WheelData((2, Fraction(3, 10)), (-10, 1), 2, (8, 4))])
    half, high = Fraction(8, 5), Fraction(9, 5)
    outline: list[Pair] = [(-half, -high), (half, -high), (half, high), (-half, high)]
    return on(scene, polygon_of(scene, outline)), partial(polygon_depths, np.array(outline, float))


@thorough  # the small one: test_wheels_enter_and_leave_as_in_small_steps
def test_a_wheel_that_swings_across_the_edge_is_held_there(arrays: Arrays) -> None:
    scene, depths = pushed_back(arrays)
    start, until, masses = (0.3, -0.2, 0.0), 0.45, (0.01, 0.015)
    path = followed(scene, RigidBody(*masses), start, until)
    *swings, held = path.trajectory.events
    assert {event.kind for event in swings} == {EventKind.ENTER, EventKind.LEAVE}
    assert len(swings) > 20
    assert (held.kind, held.surface) == (EventKind.SLIDE, "wheel 5 under the edge")
    assert f"{HELD:g}" in held.note
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    for time in np.linspace(held.t, until, 5):
        assert abs(depths(places, path.state(time)[:3])[4]) < 3 * HELD
    expected = small_steps_of_mass(scene, depths, np.array(start), until, 4500, masses, CREEP)
    assert np.abs(path.states[-1][:3] - expected[:3]).max() < OFF


def test_a_body_over_all_wheels_moves_as_without_an_outline(arrays: Arrays) -> None:
    scene = arrays.four_wheel(turn=(Fraction(4, 5), Fraction(3, 5)))
    body, start = RigidBody(0.1, 0.05), (0.35, 0.2, 0.4)
    path = followed(on(scene, Disc(scene.field(9))), body, start, 1.0)
    expected = simulate_dynamics(contact_model(scene), body, start, 1.0)
    assert not path.trajectory.events
    assert np.abs(path.states[-1] - expected.states[-1]).max() < 1e-6


def test_a_body_tips_over_the_side_its_centre_crosses(arrays: Arrays) -> None:
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    scene = arrays.scene([WheelData(at, (20, 1), 1) for at in corners])
    path = followed(on(scene, Disc(scene.field(9))), RigidBody(0.1, 0.1), (0.1, 0.05, 0.0), 5.0).trajectory
    assert path.end.reason is EndReason.TIPS
    assert path.end.state[0] == pytest.approx(1, abs=POSE_ERROR)
    assert path.events[-1].surface == "over the line through wheels 4 and 1"


def test_a_start_that_tips_is_refused() -> None:
    scene, _ = carton()
    with pytest.raises(ValueError, match="received one where it tips"):
        followed(scene, RigidBody(0.1, 0.1), (2.9, 2.9, 0.0), 1.0)


def test_inertia_is_that_of_the_plate(arrays: Arrays) -> None:
    """A rectangle a by b has (a^2 + b^2)/12, a disc R^2/2, and a centre of mass beside the centroid adds its square."""
    scene = arrays.four_wheel()
    a, b = Fraction(13, 5), Fraction(8, 5)
    corners: list[Pair] = [(-a / 2, -b / 2), (a / 2, -b / 2), (a / 2, b / 2), (-a / 2, b / 2)]
    rectangle = on(scene, polygon_of(scene, corners)).body
    disc = on(scene, Disc(scene.field(3)), (1, 2)).body
    assert rectangle is not None
    assert disc is not None
    assert plate(rectangle, 0.2).inertia == pytest.approx(0.2 * float(a**2 + b**2) / 12)
    assert plate(disc, 0.2).inertia == pytest.approx(0.2 * (9 / 2 + 5))
