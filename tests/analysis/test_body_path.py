"""Paths of bodies with an outline: against references that know nothing of them, and the work that they take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.analysis.bodies import path as body_path
from nonsmooth.analysis.bodies.path import BodyPath, smooth_path
from nonsmooth.analysis.bodies.set_motion import ContactSets, SetMotion, turning
from nonsmooth.analysis.bodies.supports import CarryingWheels
from nonsmooth.analysis.bodies.switching import Switching
from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.cells.loads import at_least_zero
from nonsmooth.analysis.cells.outline import Filtered, Outline, OutlineSide, between, known_sign, meet
from nonsmooth.analysis.cells.polygon import Polygon, square
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model, contacts_under
from nonsmooth.analysis.minimizers import ellipse_minimizer
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.minimizers.minimum import may_jump
from nonsmooth.analysis.minimizers.smooth_newton import CutNewton
from nonsmooth.analysis.minimizers.sum_of_supports import by_smoothing
from nonsmooth.analysis.trajectories.follow import DenseStep, Guards, first_event
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory, TrajectoryError
from nonsmooth.proofs.answers.failures import without
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.numbers.coefficients import whole_multiples
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.body_engine import inward_grid, with_random_body
from tests.conftest import HALF, Arrays, WheelData
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, pose_rate
from tests.outlined import Depths, Pair, disc_depths, on, polygon_depths, polygon_of, pushed_back, under
from tests.thorough import keep, thorough

# ---- The path of a body with an outline against references that know nothing of it, geometry written anew.
#
# Event times against DOP853 with event functions of its own; slides against a chattering path of small Euler steps; a
# body over all wheels against the array without a body; tipping against the side of the hull that is crossed.

TIME_ERROR = 1e-10  # the largest seen 4e-11
POSE_ERROR = 1e-9
CHATTER = 2.0  # distance of a chattering path at the last time, in units of its step
LIKE_NO_BODY = 1e-8  # lengths and radians: the path without a body is right to 1e-9 per step


def smooth(name: str) -> SmoothRule:
    rule = contact_rule(name)
    assert isinstance(rule, SmoothRule)
    return rule


def path_of(scene: Scene, start: tuple[float, float, float], until: float) -> Trajectory:
    return BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow(start, until)


# ---- the motion on a set of wheels, with springs of its own ---------------------------------------


class Motion(NamedTuple):
    """The motion on any wheels of an array, from the minimizer that begins anew, kept for each set of wheels."""

    contacts: Contacts
    minimizers: dict[frozenset[int], WarmMinimizer]

    @classmethod
    def of(cls, scene: Scene) -> Motion:
        return cls(Contacts.of(scene), {})

    @property
    def positions(self) -> Floats:
        return self.contacts.positions

    def rate(self, carrying: frozenset[int], pose: Floats) -> Floats:
        """``(c', theta')``."""
        wheels = sorted(carrying)
        if carrying not in self.minimizers:
            self.minimizers[carrying] = WarmMinimizer(self.contacts.model(wheels))
        loads = self.contacts.loads(wheels, pose[:2])
        twist = self.minimizers[carrying].minimize(np.array([loads.get(wheel, 0.0) for wheel in wheels]))
        assert twist is not None
        return pose_rate(twist, pose[:2])


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
    path = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow(start.tolist(), until)
    expected = reference_path(Motion.of(scene), depths, start, until)
    assert path.end.reason is EndReason.TIME
    assert len(expected.times) >= changes
    assert {event.kind for event in path.events} == {EventKind.ENTER, EventKind.LEAVE}
    assert sets_of(path) == expected.sets
    found = [event.t for event in path.events]
    assert np.abs(np.array(found) - expected.times).max() < TIME_ERROR
    assert np.abs(np.array(path.end.state) - expected.last).max() < POSE_ERROR


# ---- sliding -------------------------------------------------------------------------------------


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
    path = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow(start.tolist(), until)
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
    path, expected = (smooth_path(smooth("ellipse"), each, start.tolist(), 0.5) for each in (covered, scene))
    assert not path.events
    for time in np.linspace(0, 0.5, 6):
        assert np.abs(np.subtract(path.at(time), expected.at(time))).max() < LIKE_NO_BODY
    assert np.abs(path.at(0.5) - start).max() > 0.1


def square_array(arrays: Arrays, way: Pair) -> Scene:
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
    scene = square_array(arrays, way)
    path = path_of(on(scene, Disc(scene.field(9))), (0.1, 0.05, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    assert path.end.state[axis] == pytest.approx(place, abs=POSE_ERROR)
    assert path.events[-1].kind is EventKind.TIPS
    assert path.events[-1].surface == f"over the line through {side}"


def test_a_body_that_leaves_a_wheel_tips_over_the_side_that_is_left(arrays: Arrays) -> None:
    """Wheel 4 carries the lower right of the centre of mass; then the slanted edge leaves it behind."""
    scene = square_array(arrays, (-20, 19))
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
    sets = ContactSets(contacts_under(smooth("ellipse"), scene))
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
    path = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow([0.443, 0.011, 0.0], 0.3)
    begins, ends = 0.05, 0.3
    x, y, theta = path.at(begins)
    assert abs(y) < 1e-12
    mode = next(piece for piece in path.pieces if piece.end is not None and piece.end >= ends)
    wheels = frozenset(int(name) - 1 for name in mode.cells)
    motion = ContactSets(contacts_under(smooth("ellipse"), scene)).motion(wheels, np.array([x, 0.0, theta]))
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


# ---- Paths of bodies with an outline: minimizers from the last one, and an end after so much work.


def test_a_body_that_all_wheels_carry_along_hardly_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """On parallel rollers all contacts stick: multipliers go on from the last minimizer, with the same proof.

    The path is known by the definition: nothing slips.
    """
    asked: list[bool] = []
    begun: list[bool] = []
    warm, cold = WarmMinimizer.minimize, by_smoothing

    def counted_warm(self: WarmMinimizer, loads: Floats) -> Floats | None:
        asked.append(True)
        return warm(self, loads)

    def counted_cold(
        weights: Floats, maps: Floats, targets: Floats, sets: UnitDiscs, passes: int
    ) -> tuple[Floats, Floats]:
        begun.append(True)
        return cold(weights, maps, targets, sets, passes)

    monkeypatch.setattr(CutNewton, "minimize", lambda *_: None)  # which finds these
    monkeypatch.setattr(WarmMinimizer, "minimize", counted_warm)
    monkeypatch.setattr(ellipse_minimizer, "by_smoothing", counted_cold)
    scene = load_scene("roller-bed")
    path = BodyPath(contacts_under(smooth("roller"), scene), scene).follow((0.1, 0.05, 0.2), 0.1)
    assert path.end.state == pytest.approx((0.2, 0.05, 0.2), abs=1e-9)
    assert len(begun) < len(asked) / 4


def test_a_path_of_a_body_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was followed until then is the path."""
    scene = load_scene("carton-on-6x6")
    whole = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    monkeypatch.setattr(body_path, "MOST_RATES", 400)
    part = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    assert part.end.reason is EndReason.STEPS
    assert 0 < part.end.t < whole.end.t
    assert part.end.state == pytest.approx(whole.at(part.end.t), abs=1e-9)


def without_wheel_15() -> BodyPath:
    """A body on a table where two of the three wheels that are left under it are on either side of the rest point."""
    scene = without(load_scene("carton-on-6x6").under("ellipse"), [15])
    return BodyPath(contacts_under(smooth("ellipse"), scene), scene)


def test_a_centre_of_mass_that_comes_ever_nearer_to_the_border_of_its_support_tips() -> None:
    """Without wheel 15 the rest point lies over the line through two wheels, where rounding alone would move a body.

    From afar this path did not end in ten minutes; that it never crosses the line makes no difference to a table.
    """
    path = without_wheel_15().follow((1e-7, 1e-7, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    assert [event.surface for event in path.events] == ["over the line through wheels 21 and 16"]
    x, y, _ = path.end.state
    assert 0 < x + y < 4e-9
    assert x == pytest.approx(y, abs=1e-12)


def test_a_step_that_looks_beyond_a_corner_of_the_support_ends_no_path(arrays: Arrays) -> None:
    """One wheel alone fixes no motion: the step goes on with the last twist that is proved, and the path tips.

    Such paths ended with a minimum without proof.
    """
    corners = [(Fraction(7, 10), -HALF), (Fraction(1, 10), HALF), (Fraction(-4, 5), Fraction(-3, 10))]
    rims = [(-3, -2), (-1, -1), (0, 1)]
    scene = arrays.scene(list(map(WheelData, corners, rims)), friction=(HALF, Fraction(4, 5)))
    inside, beyond = np.array([-0.3, 0.05, 0.0]), np.array([-0.85, -0.33, 0.0])
    motion = SetMotion(contacts_under(smooth("roller"), scene), inside)
    with pytest.raises(TrajectoryError, match="a minimum without proof"):
        motion.rate(beyond)
    twists = [motion.rate(pose) - motion.rate(pose)[2] * turning(pose) for pose in (inside, beyond)]
    assert twists[1] == pytest.approx(twists[0], abs=1e-15)
    assert np.abs(twists[0]).max() > 1e-2


# Rims along x, two at either side of the middle, drive a body toward it at one speed.
OPPOSED = [
    WheelData((x, y), (1 if x < 0 else -1, 0)) for x, y in ((-1, -1), (-1, 1), (1, -1), (1, 1))
]  # fmt: skip


def opposed(arrays: Arrays, *others: WheelData) -> Scene:
    """Such wheels, and others."""
    return arrays.scene([*OPPOSED, *others], friction=(1, Fraction(1, 2))).under("ellipse")


# Without an outline, and sampled: test_sampled_bodies_rest_between_opposed_wheels.
@pytest.mark.parametrize("body", keep(1, [Disc, None]))
def test_a_body_between_opposed_wheels_comes_to_rest_where_they_bear_alike(arrays: Arrays, body: Any) -> None:
    """By hand: the side that bears more sets the speed, and in the middle neither does.

    The twist jumps there though no friction ellipse is cut; such paths took steps of 1e-14 and never ended.
    """
    scene = opposed(arrays)
    if body is not None:
        zero, one = scene.field(0), scene.field(1)
        scene = replace(scene, body=Body(body(scene.field(3)), (zero, zero), (one, zero)))
    start = (0.4, 0.3, 0.2)
    path = smooth_path(smooth("ellipse"), scene, start, 0.5 if body is None else 1.0)
    assert path.end.state == pytest.approx((0.0, 0.3, 0.2), abs=1e-6)
    assert path.sample([0.1, 0.3])[:, 0] == pytest.approx([0.3, 0.1], abs=1e-5)
    assert path.end.reason is (EndReason.TIME if body is None else EndReason.REST)
    assert path.unique is None


def test_only_wheels_that_drive_along_one_motion_jump(arrays: Arrays) -> None:
    """Parallel rims, rims around one point, and free ones; not such that all turn together without slip."""

    def jump(*wheels: WheelData, friction: Pair = (1, HALF)) -> bool:
        return may_jump(contacts_under(smooth("ellipse"), arrays.scene(wheels, friction)))

    around = [replace_rim(wheel, (-wheel.position[1], wheel.position[0])) for wheel in OPPOSED]
    assert jump(*OPPOSED)
    assert jump(*(wheel._replace(speed=speed) for wheel, speed in zip(around, (1, 2, 1, 2), strict=True)))
    assert not jump(*around)  # the body turns with them all
    alike = [replace_rim(wheel, (1, 0)) for wheel in OPPOSED]
    assert not jump(*alike)  # it goes with them
    assert jump(*alike[:3], alike[3]._replace(speed=0))
    assert not jump(*arrays.inward(wheel.position for wheel in OPPOSED))
    assert jump(*arrays.inward(wheel.position for wheel in OPPOSED), friction=(1, 0))


def replace_rim(wheel: WheelData, rim: Pair) -> WheelData:
    return wheel._replace(direction=rim)


ROLLERS = """
contact = { rule = "roller" }
friction = { mu_roll = 0.7, mu_side = 0.02 }
check = { equilibrium = [250, 150], radius = 20 }
wheel = [
    { position = [200, 100], heading = "94 deg" }, { position = [300, 100], heading = "154 deg" },
    { position = [200, 200], heading = "-86 deg" }, { position = [300, 200], heading = "203 deg" },
]
"""


def test_a_minimum_that_only_drag_holds_is_proved_to_rounding(tmp_path: Path) -> None:
    """Between two wheels that roll, steps of Newton's method stay as large as rounding of the forces makes them.

    A path over a conveyor ended here without a proof.
    """
    (tmp_path / "rollers.toml").write_text(ROLLERS, encoding="utf-8")
    pose = np.array([225.228055030587, 142.9326976828335, 0.0])
    motion = SetMotion(contacts_under(smooth("roller"), load_scene(tmp_path / "rollers.toml")), pose)
    found = motion.rate(pose) - motion.rate(pose)[2] * turning(pose)
    slips = motion.model.rows[[0, 2]] @ found - motion.model.targets[[0, 2]]
    assert np.abs(slips).max() <= 1e-9 * 250


def test_a_path_that_cannot_be_followed_any_farther_ends_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """With what was followed until then, and the reason; without a first step it is an error."""
    scene = load_scene("carton-on-6x6").under("ellipse")
    whole_path = smooth_path(smooth("ellipse"), scene, (0.15, 0.1, 0.08), 1.0)
    own = SetMotion.rate

    def rate(motion: SetMotion, pose: Floats) -> Floats:
        if pose[0] < 0.1:
            raise TrajectoryError("no proof")
        return own(motion, pose)

    monkeypatch.setattr(SetMotion, "rate", rate)
    part = smooth_path(smooth("ellipse"), scene, (0.15, 0.1, 0.08), 1.0)
    assert (part.end.reason, part.end.note) == (EndReason.UNPROVED, "no proof")
    assert part.end.why == "what follows is not known: no proof"
    assert part.end.record()["note"] == "no proof"
    assert 0 < part.end.t < whole_path.end.t
    assert part.end.state == pytest.approx(whole_path.at(part.end.t), abs=1e-8)
    assert part.end.state[0] < part.at(0.0)[0]
    with pytest.raises(TrajectoryError, match="no proof"):
        smooth_path(smooth("ellipse"), scene, (0.09, 0.1, 0.08), 1.0)


def test_a_start_over_the_line_through_two_wheels_is_refused() -> None:
    """It ended with a message of NumPy about shapes."""
    with pytest.raises(
        ValueError, match="where the body stands on its wheels, received one where it tips over the line "
    ):
        without_wheel_15().follow((0.0, 0.0, 0.3), 1.0)


def test_a_path_over_all_wheels_ends_after_its_work_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that needs minutes says so in its last line."""
    monkeypatch.setattr(body_path, "MOST_RATES", 30)
    path = BodyPath(contacts_under(smooth("ellipse"), load_scene("four-wheel"))).follow((0.2, 0.4, 0.0), 5.0)
    assert path.end.reason is EndReason.STEPS
    assert 0 < path.end.t < 5


def test_where_one_method_gives_up_the_next_one_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """With tolerances ever wider, and from the last place that was reached."""
    scene = load_scene("carton-on-6x6")
    whole = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 0.5)
    monkeypatch.setattr(body_path, "MANY_STEPS", 3)
    monkeypatch.setattr(body_path, "MANY_STIFF_STEPS", 5)
    rough = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 0.5)
    assert rough.end.state == pytest.approx(whole.end.state, abs=1e-5)


# ---- Lines and points by floats and whole numbers: what they say of a sign is true, and outlines are exact polygons.

Draw: TypeAlias = Callable[[], Number]
FIELDS = {"rational": (1, ()), "one root": (1, (2,)), "two roots": (1, (2, 3)), "of ring-5": (5, ())}


def draws(name: str, rng: np.random.Generator) -> tuple[NumberField, Draw]:
    """A field and short numbers of it at random."""
    order, radicands = FIELDS[name]
    field = NumberField(order)
    units = [field.one, *(field.sqrt(radicand) for radicand in radicands), *([field.two_cos(1)] if order > 1 else [])]
    return field, lambda: sum((unit * int(rng.integers(-4, 5)) for unit in units), field.zero) / int(rng.integers(1, 5))


def product(line: tuple[Number, ...], point: tuple[Number, ...]) -> Number:
    return line[0] * point[0] + line[1] * point[1] + line[2] * point[2]


@pytest.mark.parametrize("name", FIELDS)
def test_known_signs_are_those_of_exact_numbers(name: str) -> None:
    rng = np.random.default_rng(0)
    field, draw = draws(name, rng)
    decided = 0
    for _ in range(150):
        first, second, third = ((draw(), draw(), draw()) for _ in range(3))
        a, b = first, second
        point = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        met = meet(Filtered.of(first), Filtered.of(second))
        for line in (first, third):
            known = known_sign(Filtered.of(line), met)
            assert known is None or known == sign(product(line, point))
            assert name != "rational" or known is not None
            decided += known is not None
        one, x, y, u, v = field.one, *(draw() for _ in range(4))
        middle = between(Filtered.of((one, x, y)), Filtered.of((one, u, v)))
        known = known_sign(Filtered.of(third), middle)
        assert known is None or known == sign(product(third, (one * 2, x + u, y + v)))
    assert decided >= 100


@pytest.mark.parametrize("name", FIELDS)
def test_an_outline_is_the_polygon_that_exact_numbers_cut(name: str) -> None:
    """Lines of few slopes through few places: many pass through corners of others."""
    rng = np.random.default_rng(1)
    field, draw = draws(name, rng)
    cut = 0
    for _ in range(60):
        exact: Polygon | None = square((field.zero, field.zero), field(2))
        outline: Outline | None = Outline.of(exact) if exact else None
        for _ in range(6):
            form = (draw() + Fraction(3, 2), draw(), draw())
            if not any(form[1:]):
                continue
            half_plane = at_least_zero(form, "cut")
            side = OutlineSide(Filtered.of(form), lambda half_plane=half_plane: half_plane)  # type: ignore[misc]
            exact = exact and exact.clipped(half_plane)
            outline = outline and outline.clipped(side)
            assert (outline is None) == (exact is None)
            if outline is not None:
                cut += 1
                assert outline.polygon == exact
    assert cut >= 60


def test_what_floats_do_not_hold_is_not_known() -> None:
    field = NumberField()
    root = field.sqrt(2)
    for size in (Fraction(10) ** 400, Fraction(1, 10**400), Fraction(10) ** 90):
        far = (field(size) * root, field(size), field.one)
        assert known_sign(Filtered.of(far), Filtered.of((field.one, root, root))) is None
    near = (field.one, root - 1 + Fraction(1, 10**30), field.zero)
    assert known_sign(Filtered.of(near), Filtered.of((1 - root, field.one, field.zero))) is None


def test_whole_multiples() -> None:
    field = NumberField()
    root = field.sqrt(2)
    thirds = [(root / 3).terms, (root * 2).terms, field.zero.terms]
    assert whole_multiples(thirds, 10) == [1, 6, 0]
    assert whole_multiples(thirds, 2) is None
    assert whole_multiples([root.terms, field.one.terms], 10) is None
    assert whole_multiples([field.zero.terms] * 2, 10) == [0, 0]
    assert whole_multiples([NumberField(5).two_cos(1).terms], 10) is None


# ---- Where a slide ends: the motion beyond is tangent to the edge, up to rounding ----------------


class DepthRates:
    """Contact sets that carry everywhere, over an outline: rates of the depths of wheels, by the set that carries."""

    is_stiff = False

    def __init__(self, rates: dict[frozenset[int], Sequence[float]]) -> None:
        self._rates = rates

    def carries(self, wheels: frozenset[int], pose: Floats) -> bool:
        return True

    def rate(self, wheels: frozenset[int], pose: Floats) -> Floats:
        return np.array(self._rates[wheels])

    def rates(self, pose: Floats, rate: Floats, wheels: Sequence[int]) -> Floats:
        return rate


NONE, FIRST, SECOND = frozenset[int](), frozenset({0}), frozenset({1})
BEYOND_SLIDES: list[tuple[dict[frozenset[int], Sequence[float]], frozenset[int], tuple[int, ...]]] = [
    ({NONE: [1e-12], FIRST: [-1.0]}, NONE, ()),  # the weight has come to zero
    ({NONE: [-1e-12], FIRST: [-1.0]}, NONE, ()),
    ({NONE: [1.0], FIRST: [-1e-12]}, FIRST, ()),  # to one
    ({NONE: [1e-3], FIRST: [-1.0]}, NONE, (0,)),  # has not
    ({NONE: [1.0, 1e-12], FIRST: [-1.0, 1e-12], SECOND: [1.0, -1.0], FIRST | SECOND: [-1.0, -1.0]}, NONE, (0,)),
    ({NONE: [1.0, 0.1], FIRST: [-1.0, 0.1], SECOND: [1.0, -1.0], FIRST | SECOND: [-1.0, -1.0]}, NONE, (0, 1)),
    ({NONE: [1.0, -0.1], FIRST: [-1.0, -0.1], SECOND: [1.0, -1.0], FIRST | SECOND: [-1.0, -1.0]}, NONE, (0,)),
]


@pytest.mark.parametrize(("rates", "carrying", "sliding"), BEYOND_SLIDES)
def test_a_slide_that_has_ended_is_not_taken_again(
    rates: dict[frozenset[int], Sequence[float]], carrying: frozenset[int], sliding: tuple[int, ...]
) -> None:
    """It was: of a carton on a conveyor, two thousand times without progress."""
    given: Any = DepthRates(rates)
    support = Switching(given, given).next_support(np.zeros(3), NONE, range(len(rates[NONE])))
    assert (support.carrying, support.sliding) == (carrying, sliding)


@pytest.mark.parametrize(("rate", "gone"), [(1.0, True), (-1.0, False)])
def test_a_slide_is_over_where_a_wheel_bears_nothing(rate: float, gone: bool) -> None:
    """Both motions take it the same way: a step that comes so far was refused, and is cut where its weight ends."""
    given: Any = DepthRates({NONE: [rate], FIRST: [rate]})
    support, pose = CarryingWheels(NONE, (0,)), np.zeros(3)
    moves, (weight,) = Switching(given, given).rate(support, pose, np.array([0.5]))
    assert (moves.tolist(), weight > 1, weight < 0) == ([rate], gone, not gone)
