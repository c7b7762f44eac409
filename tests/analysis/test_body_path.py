"""The path of a body with an outline against references that know nothing of it, geometry written anew.

Event times against DOP853 with event functions of its own; slides against a chattering path of small Euler steps; a
body over all wheels against the array without a body; tipping against the side of the hull that is crossed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.analysis.bodies.path import BodyPath, smooth_path
from nonsmooth.analysis.bodies.set_motion import ContactSets
from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards, first_event
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from tests.body_engine import inward_grid, with_random_body
from tests.conftest import Arrays, WheelData
from tests.outlined import Depths, Floats, Pair, disc_depths, on, polygon_depths, polygon_of, under
from tests.thorough import keep, thorough

TIME_ERROR = 1e-10  # the largest seen 4e-11
POSE_ERROR = 1e-9
CHATTER = 2.0  # distance of a chattering path at the last time, in units of its step
LIKE_NO_BODY = 1e-8  # lengths and radians: the path without a body is right to 1e-9 per step


def ellipse() -> SmoothRule:
    rule = contact_rule("ellipse")
    assert isinstance(rule, SmoothRule)
    return rule


def path_of(scene: Scene, start: tuple[float, float, float], until: float) -> Trajectory:
    return BodyPath(contacts_under(ellipse(), scene), scene).follow(start, until)


# ---- the motion on a set of wheels, with springs of its own ---------------------------------------


class Motion(NamedTuple):
    """The motion on any wheels of an array, from the minimizer that begins anew, kept for each set of wheels."""

    positions: Floats
    rims: Floats
    speeds: Floats
    friction: Floats
    minimizers: dict[frozenset[int], WarmMinimizer]

    @classmethod
    def of(cls, scene: Scene) -> Motion:
        positions = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
        rims = np.array([[float(x) for x in wheel.unit_direction] for wheel in scene.wheels])
        speeds = np.array([float(wheel.speed) for wheel in scene.wheels])
        friction = [[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels]
        return cls(positions, rims, speeds, np.array(friction), {})

    def loads(self, wheels: list[int], centre: Floats) -> Floats:
        """Springs of equal stiffness; those that pull are taken away one by one."""
        pressed = list(wheels)
        while True:
            moments = np.vstack([np.ones(len(pressed)), self.positions[pressed].T])
            forces, *_ = np.linalg.lstsq(moments, np.array([1.0, *centre]), rcond=None)
            if forces.min() >= 0:
                break
            pressed.pop(int(np.argmin(forces)))
        loads = np.zeros(len(self.positions))
        loads[pressed] = forces
        return loads[wheels]

    def rate(self, carrying: frozenset[int], pose: Floats) -> Floats:
        """``(c', theta')``."""
        wheels = sorted(carrying)
        if carrying not in self.minimizers:
            contacts = (self.positions[wheels], self.rims[wheels], self.speeds[wheels], self.friction[wheels])
            self.minimizers[carrying] = WarmMinimizer(ContactModel.build(*contacts))
        twist = self.minimizers[carrying].minimize(self.loads(wheels, pose[:2]))
        assert twist is not None
        v, omega = twist[:2], twist[2]
        return np.array([v[0] - omega * pose[1], v[1] + omega * pose[0], omega])


class Reference(NamedTuple):
    """What the reference path met: times and sets at changes, and its last pose."""

    times: list[float]
    sets: list[frozenset[int]]
    last: Floats


def reference_path(motion: Motion, depths: Depths, start: Floats, until: float) -> Reference:
    """DOP853 from change to change; each change lets one wheel enter or leave."""
    pose, time = start, 0.0
    carrying = under(depths(motion.positions, pose))
    times: list[float] = []
    sets = [carrying]
    while True:
        events = [edge_event(k, k in carrying, motion, depths) for k in range(len(motion.positions))]
        here = carrying

        def rate(t: float, at: Floats, here: frozenset[int] = here) -> Floats:
            return motion.rate(here, at)

        path = solve_ivp(
            rate, (time, until), pose, method="DOP853", rtol=1e-12, atol=1e-13, events=events, max_step=0.2
        )
        if path.status == 0:
            return Reference(times, sets, path.y[:, -1])
        (wheel,) = (k for k, found in enumerate(path.t_events) if len(found))
        time, pose = float(path.t_events[wheel][0]), path.y_events[wheel][0]
        carrying ^= {wheel}
        times.append(time)
        sets.append(carrying)


def edge_event(wheel: int, inside: bool, motion: Motion, depths: Depths) -> Callable[[float, Floats], float]:
    """An event function that ends a stretch where a wheel leaves or enters."""

    def event(t: float, pose: Floats) -> float:
        return float(depths(motion.positions[[wheel]], pose)[0])

    event.terminal = True  # type: ignore[attr-defined]
    event.direction = -1 if inside else 1  # type: ignore[attr-defined]
    return event


# ---- arrays --------------------------------------------------------------------------------------


def conveyor(arrays: Arrays, columns: int = 10) -> Scene:
    """Four rows of wheels that run along x, no two alike, the fastest at the bottom: the body turns on its way."""
    rng = np.random.default_rng(11)
    wheels = []
    for column in range(columns):
        for row in range(4):
            slope, extra = rng.integers(-3, 4), rng.integers(0, 5)
            speed = 1 + Fraction(int(extra), 10) - Fraction(row, 20)
            wheels.append(WheelData((column, row), (10, int(slope)), speed))
    return arrays.scene(wheels)


SHIELD: list[Pair] = [(-2, -1), (1, Fraction(-3, 2)), (2, 0), (Fraction(1, 2), Fraction(3, 2)), (-2, 1)]


def disc_case(scene: Scene) -> tuple[Scene, Depths]:
    radius, centre = Fraction(8, 5), (Fraction(1, 5), Fraction(-1, 10))
    outlined = on(scene, Disc(scene.field(radius)), centre)
    return outlined, partial(disc_depths, float(radius), np.array(centre, float))


def polygon_case(scene: Scene) -> tuple[Scene, Depths]:
    outlined = on(scene, polygon_of(scene, SHIELD))
    return outlined, partial(polygon_depths, np.array(SHIELD, float))


# what lies on the array, the last time, and how many changes come at least
CASES = {"polygon": (polygon_case, 0.9, 5), "longer": (polygon_case, 1.9, 10), "disc": (disc_case, 1.3, 10)}


def sets_of(path: Trajectory) -> list[frozenset[int]]:
    return [frozenset(int(name) - 1 for name in piece.cells) for piece in path.pieces]


@pytest.mark.parametrize(("case", "until", "changes"), keep(1, CASES.values()), ids=list(CASES))
def test_changes_come_when_another_integrator_says(
    case: Callable[[Scene], tuple[Scene, Depths]], until: float, changes: int, arrays: Arrays
) -> None:
    scene, depths = case(conveyor(arrays))
    start = np.array([2.03, 1.52, 0.1])
    path = BodyPath(contacts_under(ellipse(), scene), scene).follow(start.tolist(), until)
    expected = reference_path(Motion.of(scene), depths, start, until)
    assert path.end.reason is EndReason.TIME
    assert len(expected.times) >= changes
    assert {event.kind for event in path.events} == {EventKind.ENTER, EventKind.LEAVE}
    assert sets_of(path) == expected.sets
    found = [event.t for event in path.events]
    assert np.abs(np.array(found) - expected.times).max() < TIME_ERROR
    assert np.abs(np.array(path.end.state) - expected.last).max() < POSE_ERROR


# ---- sliding -------------------------------------------------------------------------------------


def pushed_back(arrays: Arrays) -> tuple[Scene, Depths]:
    """Four wheels carry a plate to the right and up, onto a fifth of more grip that runs to the left."""
    ways = [(10, 3), (10, 4), (12, 3), (11, 5)]
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    wheels = [WheelData(at, way, Fraction(1, 2)) for at, way in zip(corners, ways, strict=True)]
    fifth = WheelData((2, Fraction(3, 10)), (-10, 1), 2, (8, 4))
    half, high = Fraction(8, 5), Fraction(9, 5)
    scene = arrays.scene([*wheels, fifth])
    plate: list[Pair] = [(-half, -high), (half, -high), (half, high), (-half, high)]
    return on(scene, polygon_of(scene, plate)), partial(polygon_depths, np.array(plate, float))


def chatter(motion: Motion, depths: Depths, start: Floats, until: float, steps: int) -> Floats:
    """Euler steps, each on the wheels that are under the body at its beginning."""
    pose = start
    for _ in range(steps):
        pose = pose + until / steps * motion.rate(under(depths(motion.positions, pose)), pose)
    return pose


@thorough  # the small one: that of the same name in test_cell_path.py
def test_a_wheel_that_pushes_the_body_off_stays_under_its_edge(arrays: Arrays) -> None:
    scene, depths = pushed_back(arrays)
    start, until = np.array([0.3, -0.2, 0.0]), 1.0
    motion = Motion.of(scene)
    path = BodyPath(contacts_under(ellipse(), scene), scene).follow(start.tolist(), until)
    assert [event.kind for event in path.events] == [EventKind.SLIDE]
    (slide,) = path.events
    assert slide.surface == "wheel 5 under the edge"
    for time in np.linspace(slide.t, until, 7):
        assert abs(depths(motion.positions, np.array(path.at(time)))[4]) < POSE_ERROR
    assert np.abs(np.subtract(path.at(until), path.at(slide.t))).max() > 0.1
    for steps in (100, 400):
        error = np.abs(chatter(motion, depths, start, until, steps) - path.at(until)).max()
        assert error < CHATTER * until / steps


# ---- all wheels under the body, and none enough --------------------------------------------------


def test_a_body_over_all_wheels_moves_as_without_an_outline(arrays: Arrays) -> None:
    scene = replace(conveyor(arrays, columns=3), contact=Contact("ellipse"))
    start = np.array([0.7, 1.4, 0.3])
    covered = on(scene, Disc(scene.field(20)), (1, 2))
    path, expected = (smooth_path(ellipse(), each, start.tolist(), 0.5) for each in (covered, scene))
    assert not path.events
    for time in np.linspace(0, 0.5, 6):
        assert np.abs(np.subtract(path.at(time), expected.at(time))).max() < LIKE_NO_BODY
    assert np.abs(path.at(0.5) - start).max() > 0.1


def square(arrays: Arrays, way: Pair) -> Scene:
    """Four wheels that all run one way."""
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    return arrays.scene([WheelData(at, way, 1) for at in corners])


WAYS: dict[str, tuple[Pair, int, float]] = {
    "wheels 1 and 2": ((1, 20), 1, 1.0),
    "wheels 2 and 3": ((-20, 1), 0, -1.0),
    "wheels 3 and 4": ((1, -20), 1, -1.0),
    "wheels 4 and 1": ((20, 1), 0, 1.0),
}


@pytest.mark.parametrize("side", WAYS)
def test_a_body_tips_over_the_side_its_centre_crosses(side: str, arrays: Arrays) -> None:
    way, axis, place = WAYS[side]
    scene = square(arrays, way)
    path = path_of(on(scene, Disc(scene.field(9))), (0.1, 0.05, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    assert path.end.state[axis] == pytest.approx(place, abs=POSE_ERROR)
    assert path.events[-1].kind is EventKind.TIPS
    assert path.events[-1].surface == f"over the line through {side}"


def test_a_body_that_leaves_a_wheel_tips_over_the_side_that_is_left(arrays: Arrays) -> None:
    """Wheel 4 carries the lower right of the centre of mass; then the slanted edge leaves it behind."""
    scene = square(arrays, (-20, 19))
    slanted: list[Pair] = [(-3, -3), (Fraction(-3, 2), -3), (3, Fraction(3, 2)), (3, 3), (-3, 3)]
    path = path_of(on(scene, polygon_of(scene, slanted)), (0.6, -0.2, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    x, y, _ = path.end.state
    assert x - y == pytest.approx(0.5, abs=POSE_ERROR)
    assert path.events[-1].surface == "over the line through wheels 3 and 1"


def test_contacts_of_some_wheels_are_those_of_the_array_of_these_wheels() -> None:
    """With friction axes that are not the rims: the model built anew, entry by entry."""
    scene = load_scene("roller-bed", rule="ellipse")
    wheels = [3, 7, 8, 20]
    sets = ContactSets(contacts_under(ellipse(), scene))
    pose = np.array([float(sum(x)) / 4 for x in zip(*(scene.wheels[k].position for k in wheels), strict=True)] + [0.0])
    found = sets.motion(frozenset(wheels), pose).model
    expected = contact_model(replace(scene, wheels=tuple(scene.wheels[k] for k in wheels)))
    for entry in fields(ContactModel):
        assert np.array_equal(getattr(found, entry.name), getattr(expected, entry.name)), entry.name


def test_a_path_passes_a_place_where_the_slip_of_a_wheel_vanishes() -> None:
    """On a line of symmetry that attracts ever faster as the slip goes to zero, up to 4e7 times a second.

    On the line itself the motion is in one coordinate and not stiff: an explicit method follows it.
    """
    scene = with_random_body(inward_grid(Fraction(1, 2)), np.random.default_rng(4), 0.5)
    path = BodyPath(contacts_under(ellipse(), scene), scene).follow([0.443, 0.011, 0.0], 0.3)
    begins, ends = 0.05, 0.3
    x, y, theta = path.at(begins)
    assert abs(y) < 1e-12
    mode = next(piece for piece in path.pieces if piece.end is not None and piece.end >= ends)
    wheels = frozenset(int(name) - 1 for name in mode.cells)
    motion = ContactSets(contacts_under(ellipse(), scene)).motion(wheels, np.array([x, 0.0, theta]))
    line = solve_ivp(
        lambda t, place: [motion.rate(np.array([place[0], 0.0, theta]))[0]],
        (begins, ends),
        [x],
        rtol=1e-11,
        atol=1e-13,
        method="DOP853",
    )
    assert mode.start < begins
    assert abs(path.at(ends)[0] - line.y[0, -1]) < 1e-8
    assert abs(path.at(ends)[1]) < 1e-9
    assert len(mode.times) < 5_000


def test_a_change_that_only_many_states_together_show_is_the_end_of_its_interval() -> None:
    """Products of many states and of one are rounded differently: what is below zero there is above it alone."""

    class Rounded(Guards):
        looks = 8

        def at(self, t: float, x: Floats) -> list[float]:
            return [float(1 - x[0] + 1e-12)]

        def at_all(self, times: Sequence[float], states: Floats) -> list[Sequence[float]]:
            return [[float(1 - x[0] - 1e-12)] for x in states]

    line = DenseStep((0.0, np.zeros(1)), (1.1, np.ones(1)), lambda: lambda t: np.minimum(np.array([8 / 7 * t]), 1.0))
    found = first_event(Rounded(), [1.0], [1e-12], line)
    assert found is not None
    assert found[0] == pytest.approx(1.1 * 7 / 8)
