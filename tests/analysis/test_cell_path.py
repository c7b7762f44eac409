"""Bodies with an outline under rules with cells, and sampled ends of many bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.bodies import many_paths
from nonsmooth.analysis.bodies.many_paths import (
    ENDS,
    BodyEnd,
    CellMotions,
    LeastDissipation,
    ManyPaths,
    ManyRates,
    destinations,
)
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.outline_field import CellPath
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, contact_rule, rule_of, smooth_rule_of
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import elastic_loads
from nonsmooth.analysis.minimizers.many_twists import (
    EACH_STEP,
    ManyTwists,
    MovingTwists,
    RowsOfWheels,
    elastic_loads_of,
    widest_gaps,
)
from nonsmooth.analysis.minimizers.many_twists import Contacts as ManyContacts
from nonsmooth.analysis.trajectories import smooth_ends as smooth_ends_module
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.smooth_ends import LEFT, MOVING, smooth_ends
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.conftest import Arrays, WheelData
from tests.oracles.small_steps import small_steps
from tests.oracles.wheels_in_floats import Contacts, places_of, pose_rate
from tests.outlined import Depths, Pair, carton, disc_depths, on, polygon_depths, polygon_of, pushed_back
from tests.thorough import few, keep, thorough

# ---- The path of a body with an outline under rules with cells, against small steps that know nothing of cells.
#
# A body over all wheels against the array without a body, in closed form; tipping against the side that is crossed.

STEPS_OFF = 6.0  # distance of small steps from the path, in units of a step at speed one
POSE_ERROR = 1e-9
RULES = ("nearest", "box")
STEPS = {"nearest": 600, "box": 150}


def followed(scene: Scene, start: tuple[float, float, float], until: float) -> Trajectory:
    rule = contact_rule(scene.contact.rule)
    assert isinstance(rule, CellRule)
    return CellPath(whole(scene), rule).follow(start, until)


def assert_near_small_steps(scene: Scene, depths: Depths, start: tuple[float, float, float], path: Trajectory) -> None:
    until, steps = float(path.end.t), STEPS[scene.contact.rule]
    found = small_steps(scene, depths, np.array(start), until, steps)
    assert np.abs(found - path.end.state).max() < STEPS_OFF * until / steps


def test_sampled_bodies_rest_between_opposed_wheels(arrays: Arrays) -> None:
    """By hand: the side that bears more sets the speed, so all come to the line between, and stay.

    They were still on their way after all steps, as twists under rule ellipse were not thought to jump.
    """
    corners = ((-1, -1), (-1, 1), (1, -1), (1, 1))
    wheels = [WheelData((x, y), (1 if x < 0 else -1, 0)) for x, y in corners]
    scene = arrays.scene(wheels).under("ellipse")
    starts = np.array([(x, y) for x in (-0.3, 0.1, 0.2) for y in (-0.2, 0.0, 0.3)])
    found = smooth_ends(scene, starts)
    assert (found.reached >= 0).all()
    ends = found.places[found.reached]
    assert ends == pytest.approx(starts * [0, 1], abs=0.01)


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_a_disc_over_a_wheel_is_followed_from_there(arrays: Arrays, rule: str) -> None:
    """In the middle of a disc its depth has no slope: such starts had no continuation, for want of a number."""
    wheels = [WheelData((0, 0), (0, -1)), *arrays.inward([(1, 0), (-1, 0), (0, 1), (0, -1)])]
    scene = arrays.scene(wheels).under(rule)
    zero, one = scene.field(0), scene.field(1)
    scene = replace(scene, body=Body(Disc(scene.field(Fraction(6, 5))), (zero, zero), (one, zero)))
    own = contact_rule(rule)
    assert isinstance(own, CellRule)
    path = CellPath(scene, own)
    middle, beside = (path.follow((0.0, y, 0.3), 0.1).end.state for y in (0.0, 1e-7))
    assert middle == pytest.approx(beside, abs=1e-6)


@few(1)
@pytest.mark.parametrize("rule", RULES)
def test_wheels_enter_and_leave_as_in_small_steps(rule: str) -> None:
    (scene, depths), start = carton(rule), (1.436, -0.602, -0.46)
    path = followed(scene, start, 0.9)
    assert path.end.reason is EndReason.TIME
    kinds = [event.kind for event in path.events]
    assert kinds.count(EventKind.ENTER) > 1
    assert kinds.count(EventKind.LEAVE) > 0
    assert_near_small_steps(scene, depths, start, path)
    places = places_of(scene)
    for event in path.events:
        if event.kind in (EventKind.ENTER, EventKind.LEAVE):
            wheel = int(event.surface.split()[1]) - 1
            assert abs(depths(places[[wheel]], np.array(event.state))[0]) < POSE_ERROR
            beside = depths(places[[wheel]], np.array(path.at(event.t + 1e-5)))[0]
            assert (beside > 0) == (event.kind is EventKind.ENTER)


def test_two_wheels_enter_at_once_where_all_is_symmetric() -> None:
    scene, _ = carton()
    path = followed(scene, (1.3, 0.0, 0.0), 0.5)
    assert [event.surface for event in path.events if event.kind is EventKind.LEAVE] == ["wheel 18, 24 beside the body"]
    assert [event.surface for event in path.events if event.kind is EventKind.ENTER] == ["wheel 15, 21 under the body"]
    assert path.end.state[1:] == pytest.approx((0.0, 0.0), abs=POSE_ERROR)


# ---- sliding along the edge over a wheel ---------------------------------------------------------


def pushed_up(arrays: Arrays) -> tuple[Scene, Depths]:
    """Three wheels carry a plate down onto a fourth, which is nearer then than all others and pushes it up."""
    wheels = [
        WheelData((-1, 1), (-1, -4), Fraction(1, 2)),
        WheelData((-1, -1), (1, -5), Fraction(1, 2)),
        WheelData((Fraction(3, 2), Fraction(1, 2)), (1, -3), Fraction(1, 2)),
        WheelData((Fraction(2, 5), Fraction(-4, 5)), (1, 6), 1),
    ]
    corners: list[Pair] = [(-2, Fraction(-3, 2)), (Fraction(-1, 2), Fraction(-3, 2)), (2, 0), (2, 2), (-2, 2)]
    scene = arrays.scene(wheels)
    plate = on(scene, polygon_of(scene, corners), rule="nearest")
    return plate, partial(polygon_depths, np.array(corners, float))


SLIDES: dict[str, tuple[Callable[[Arrays], tuple[Scene, Depths]], tuple[float, float, float], int]] = {
    "nearest": (pushed_up, (0.0, 0.3, 0.0), 4),
    "box": (partial(pushed_back, rule="box"), (0.3, -0.2, 0.0), 5),
}


@few(1)
@pytest.mark.parametrize("rule", RULES)
def test_a_wheel_that_pushes_the_body_off_stays_under_its_edge(rule: str, arrays: Arrays) -> None:
    build, start, wheel = SLIDES[rule]
    scene, depths = build(arrays)
    path = followed(scene, start, 0.8)
    slide = path.events[-1]
    assert (slide.kind, slide.surface) == (EventKind.SLIDE, f"wheel {wheel} under the edge")
    assert sum(weight for _, weight in slide.weights) == pytest.approx(1)
    places = places_of(scene)
    for time in np.linspace(slide.t, 0.8, 5):
        assert abs(depths(places, np.array(path.at(time)))[wheel - 1]) < POSE_ERROR
    assert np.abs(np.subtract(path.at(0.8), path.at(slide.t))).max() > 0.05
    assert_near_small_steps(scene, depths, start, path)


# ---- all wheels under the body, and none enough --------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
def test_a_body_over_all_wheels_moves_as_without_an_outline(rule: str, arrays: Arrays) -> None:
    scene = replace(arrays.four_wheel(turn=(Fraction(4, 5), Fraction(3, 5))), contact=Contact(rule))
    start = (0.35, 0.2, 0.4)
    path = followed(on(scene, Disc(scene.field(9)), rule=rule), start, 1.0)
    expected = simulate(array_field(build_partition(scene), Kinematics.EXACT), start, 1.0)
    assert [event.kind for event in path.events] == [event.kind for event in expected.events]
    for time in np.linspace(0, 1.0, 9):
        assert np.abs(np.subtract(path.at(time), expected.at(time))).max() < POSE_ERROR


@pytest.mark.parametrize("rule", RULES)
def test_a_body_tips_over_the_side_its_centre_crosses(rule: str, arrays: Arrays) -> None:
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    scene = arrays.scene([WheelData(at, (20, 1), 1) for at in corners])
    path = followed(on(scene, Disc(scene.field(9)), rule=rule), (0.1, 0.05, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    assert path.end.state[0] == pytest.approx(1, abs=POSE_ERROR)
    assert (path.events[-1].kind, path.events[-1].surface) == (EventKind.TIPS, "over the line through wheels 4 and 1")


def test_a_body_whose_wheel_leaves_tips_over_what_is_left(arrays: Arrays) -> None:
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    scene = arrays.scene([WheelData(at, (-20, 19), 1) for at in corners])
    slanted: list[Pair] = [(-3, -3), (Fraction(-3, 2), -3), (3, Fraction(3, 2)), (3, 3), (-3, 3)]
    path = followed(on(scene, polygon_of(scene, slanted), rule="box"), (0.6, -0.2, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    x, y, _ = path.end.state
    assert x - y == pytest.approx(0.5, abs=POSE_ERROR)
    assert path.events[-1].surface == "over the line through wheels 3 and 1"


def in_unit(arrays: Arrays, length: Fraction, rule: str) -> Scene:
    """Wheels and a plate, all lengths and speeds times a number, which is also the length l of the scene."""
    wheels = [
        WheelData(
            (length * x + length * (x * y % 3) / 10, length * y),
            ((7 * x + 3 * y) % 5 - 2 or 1, (2 * x + 5 * y) % 7 - 3 or 2),
            length * (1 + (x + y) % 3) / 2,
        )
        for x in range(5)
        for y in range(5)
    ]
    scene = arrays.scene(wheels)
    scene = replace(scene, check=replace(scene.check, length=length))
    a, b = Fraction(7, 5) * length, Fraction(11, 10) * length
    return on(scene, polygon_of(scene, [(-a, -b), (a / 2, -b * 5 / 4), (a, b / 3), (0, b), (-a, b)]), rule=rule)


@pytest.mark.parametrize("length", keep(1, [Fraction(1, 1000), Fraction(1000)]))
def test_a_path_is_the_same_in_every_unit_of_length(arrays: Arrays, length: Fraction) -> None:
    expected = followed(in_unit(arrays, Fraction(1), "nearest"), (1.7, 2.1, 0.4), 1.0)
    assert len(expected.events) > 5
    size = float(length)
    path = followed(in_unit(arrays, length, "nearest"), (1.7 * size, 2.1 * size, 0.4), 1.0)
    assert [event.surface for event in path.events] == [event.surface for event in expected.events]
    x, y, theta = path.end.state
    assert (x / size, y / size, theta) == pytest.approx(expected.end.state, abs=POSE_ERROR)


def test_a_start_that_tips_is_refused_in_one_line() -> None:
    scene, _ = carton()
    with pytest.raises(ValueError, match="stands on its wheels, received one where it tips"):
        followed(scene, (2.9, 2.9, 0.0), 1.0)


def test_a_table_of_loads_is_refused_where_loads_decide(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    quarter, zero = scene.field(Fraction(1, 4)), scene.field.zero
    table = LoadTable(tuple((quarter, zero, zero) for _ in scene.wheels))
    outlined = on(scene, Disc(scene.field(9)), rule="box")
    outlined = replace(outlined, contact=replace(outlined.contact, loads=table))
    with pytest.raises(SceneError, match="elastic loads"):
        followed(outlined, (0.1, 0.1, 0.0), 1.0)


# ---- the derivative of the depths ----------------------------------------------------------------


def test_gradients_of_depths_are_their_differences(arrays: Arrays) -> None:
    scene = arrays.scene([WheelData((x, y), (1, 0)) for x in range(4) for y in range(3)])
    shield: list[Pair] = [(-2, -1), (1, Fraction(-3, 2)), (2, 0), (Fraction(1, 2), Fraction(3, 2)), (-2, 1)]
    polygon = on(scene, polygon_of(scene, shield))
    disc = on(scene, Disc(scene.field(Fraction(8, 5))), (Fraction(1, 5), Fraction(-1, 10)))
    places = places_of(scene)
    pose, step = np.array([0.83, 1.21, 0.7]), 1e-6
    centre = np.array([0.2, -0.1])
    shapes = (
        (polygon, partial(polygon_depths, np.array(shield, float))),
        (disc, partial(disc_depths, 1.6, centre)),
    )
    for outlined, depths in shapes:
        assert outlined.body is not None
        outline = MovingOutline(outlined.body, places)
        for wheel in range(len(places)):
            moves = [
                (depths(places, pose + way)[wheel] - depths(places, pose - way)[wheel]) / (2 * step)
                for way in step * np.eye(3)
            ]
            assert outline.gradient(pose, wheel) == pytest.approx(moves, abs=1e-7)


# ---- Sampled ends of a body with an outline: against paths by events, and against the proved minimizers.

PLACE_ERROR, HEADING_ERROR = 0.01, 0.02  # of the spacing, and radians: Heun's steps of 0.04, chattering at edges
RATE_ERROR = {"ellipse": 1e-4, "roller": 2e-2}  # of the fastest wheel: norms are smoothed


def carton_file(folder: Path, rule: str = "ellipse", side: str = "1") -> Scene:
    """A carton of 3 x 2 on 6 x 6 wheels that point to the middle."""
    file = folder / "carton.toml"
    file.write_text(
        f'[grid]\nrows = 6\ncolumns = 6\n[field]\nkind = "radial"\nspeed = "unit"\n[body]\nshape = "rectangle"\n'
        f'width = 3\nheight = 2\n[friction]\nmu_roll = 1\nmu_side = "{side}"\n[contact]\nrule = "{rule}"\n'
        "[check]\nradius = 2\n"
    )
    return load_scene(file)


def random_poses(count: int, reach: float) -> np.ndarray:
    return np.random.default_rng(7).uniform([-reach, -reach, -3], [reach, reach, 3], (count, 3))


@few(1)
@pytest.mark.parametrize(("rule", "side"), [("ellipse", "1"), ("ellipse", "1/5"), ("roller", "1/10")])
def test_rates_are_those_of_paths_by_events(rule: str, side: str, tmp_path: Path) -> None:
    scene = carton_file(tmp_path, rule, side)
    model = contacts_under(smooth_rule_of(scene), scene)
    assert scene.body is not None
    outline, poses = MovingOutline(scene.body, model.positions), random_poses(40, 1.2)
    found = ManyRates(LeastDissipation(model, outline.size, 40), outline, poses).at(poses, np.arange(40))
    assert found.known.all()
    path = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    agree = 0
    for pose, rate, tips in zip(poses, found.rates, found.tips, strict=True):
        carrying = frozenset(int(k) for k in np.flatnonzero(outline.depths(pose) > 0))
        assert tips == (not path._sets.carries(carrying, pose))
        if not tips:
            agree += np.abs(path._sets.rate(carrying, pose) - rate).max() <= RATE_ERROR[rule]
    standing = int((~found.tips).sum())
    assert standing > 20
    assert agree >= (standing if rule == "ellipse" else standing - 1)


@few(1)
@pytest.mark.parametrize(("rule", "count"), [("nearest", 15), ("box", 6), ("nearest", 60)])
def test_rates_by_cells_are_those_of_the_words_of_the_rule(rule: str, count: int, tmp_path: Path) -> None:
    scene = carton_file(tmp_path, rule, "1/2")
    cells = rule_of(scene)
    assert isinstance(cells, CellRule)
    assert scene.body is not None
    contacts = Contacts.of(scene)
    outline, poses = MovingOutline(scene.body, contacts.positions), random_poses(count, 1.5)
    found = ManyRates(CellMotions(scene, cells), outline, poses).at(poses, np.arange(count))
    words = {"nearest": contacts.nearest, "box": contacts.box}[rule]
    assert (~found.tips).sum() > count / 3
    for pose, rate in zip(poses[~found.tips], found.rates[~found.tips], strict=True):
        twist = words(np.flatnonzero(outline.depths(pose) > 0).tolist(), pose[:2])
        np.testing.assert_allclose(rate, pose_rate(twist, pose[:2]), atol=1e-9)


def test_twists_are_sought_from_the_best_of_several_starts() -> None:
    """A body that goes to and fro has two motions in turn, each near the last but one."""
    chance, bodies, wheels = np.random.default_rng(3), 30, 6
    rows, targets = chance.normal(size=(bodies, wheels, 2, 3)), chance.normal(size=(bodies, wheels, 2))
    contacts = ManyContacts.of(rows, targets, chance.uniform(0, 1, (bodies, wheels)), np.ones((bodies, wheels)))
    afar = chance.normal(scale=3, size=(bodies, 1, 3))

    def found_from(starts: np.ndarray) -> tuple[np.ndarray, int]:
        twists = ManyTwists(float(np.abs(targets).max()), rollers=False)
        found, settled = twists.minimize(contacts, starts)
        assert settled.all()
        return found, twists.work

    least, long = found_from(afar)
    again, short = found_from(np.concatenate([afar, least[:, None]], axis=1))
    assert again == pytest.approx(least, abs=1e-6)
    assert 3 * short < long


def test_a_body_that_drifts_slowly_takes_long_steps(tmp_path: Path) -> None:
    """It turns by a degree in a second until other wheels carry it; the shortest steps would take 200 windows."""
    file = tmp_path / "carton.toml"
    file.write_text(
        '[grid]\nrows = 3\ncolumns = 4\n[field]\nkind = "spiral"\nangle = "pi/200"\nspeed = "unit"\n'
        '[body]\nshape = "rectangle"\nwidth = 3\nheight = "2.2"\n[friction]\nmu_roll = 1\nmu_side = 1\n'
        '[contact]\nrule = "ellipse"\n'
    )
    scene, start, until = load_scene(file), (0.1, 0.05, 0.0), 20.0
    windows: list[str] = []
    paths = ManyPaths(scene, smooth_rule_of(scene))
    found = paths.follow(np.array([start]), until, lambda done, total, up_to: windows.append(up_to))
    assert found.by(BodyEnd.TIME)[0]
    assert len(windows) < 60
    end = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene).follow(start, until).end
    assert found.poses[0] == pytest.approx(end.state, abs=1e-4)


# Of a grid of 3 by 4 in millimetres without one wheel: places, and headings in degrees.
LIFTED = (
    (-150, -100, 37.0),
    (-50, -100, 65.5),
    (150, -100, 142.0),
    (-150, 0, 5.7),
    (-50, 0, 16.1),
    (50, 0, 162.3),
    (150, 0, 174.1),
    (-150, 100, -29.1),
    (-50, 100, -58.2),
    (50, 100, -119.2),
    (150, 100, -150.1),
)


def test_bodies_that_turn_on_at_rest_end_where_their_paths_do(tmp_path: Path) -> None:
    """They turn by a tenth of a degree in a second, and one to where another wheel carries it; its map ended before."""
    wheels = "".join(f"[[wheel]]\nposition = [{x}, {y}]\nheading = {own}\nspeed = 100\n" for x, y, own in LIFTED)
    file = tmp_path / "lifted.toml"
    file.write_text(
        'units = { length = "mm", angle = "deg", speed = "mm/s" }\nfriction = { mu_roll = 1, mu_side = 0.5 }\n'
        'contact = { rule = "ellipse" }\nbody = { shape = "rectangle", width = 216.1, height = 191.8 }\n' + wheels
    )
    scene = load_scene(file)
    starts = np.array([[44.6, 20, -0.93], [-31.4, 29.3, 0.9]])
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(starts)
    assert found.by(BodyEnd.REST).all()
    path = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    for start, pose in zip(starts.tolist(), found.poses, strict=True):
        end = path.follow(start, found.until).end
        assert np.abs(np.subtract(end.state[:2], pose[:2])).max() < 0.1  # mm; 13 where they began to turn
        assert abs(end.state[2] - pose[2]) < 0.005  # 0.04


# Wheels that slip easily across: a body slides along layers of some thousandths of the wheels' spacing.
STIFF = (
    '[grid]\nrows = {rows}\ncolumns = {columns}\n[field]\nkind = "radial"\nspeed = "unit"\n'
    '[body]\nshape = "rectangle"\nwidth = "{width}"\nheight = "{height}"\n'
    '[friction]\nmu_roll = 1\nmu_side = "{side}"\n[contact]\nrule = "ellipse"\n'
)
STIFF_HEADING_ERROR = 0.04  # without shorter steps in layers 0.1 to 1


@few(2)
@pytest.mark.parametrize(
    ("rows", "columns", "width", "height", "side", "start"),
    [
        pytest.param(4, 5, "2.1", "1.9", "1/10", (0.44, 0.0, 0.3), id="the heading stays once the place rests"),
        pytest.param(5, 4, "1.91", "2.5", "1/10", (0.66, -0.66, 0.55), id="it rests, and does not tip"),
        pytest.param(5, 4, "2.13", "2.72", "1/20", (0.66, -0.66, 0.64), id="a layer narrower yet"),
        pytest.param(3, 4, "2.52", "1.77", "1/30", (-0.5, -0.5, 0.65), id="and one of a thousandth"),
    ],
)
def test_bodies_that_slide_along_narrow_layers_end_where_paths_by_events_do(
    rows: int, columns: int, width: str, height: str, side: str, start: tuple[float, float, float], tmp_path: Path
) -> None:
    file = tmp_path / "stiff.toml"
    file.write_text(STIFF.format(rows=rows, columns=columns, width=width, height=height, side=side))
    scene = load_scene(file)
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(np.array([start]))
    end = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene).follow(start, 60.0).end
    assert (end.reason, ENDS[found.reasons[0]]) == (EndReason.REST, BodyEnd.REST)
    assert np.abs(np.subtract(end.state[:2], found.poses[0, :2])).max() < PLACE_ERROR
    assert abs(end.state[2] - found.poses[0, 2]) < STIFF_HEADING_ERROR


def test_paths_are_given_up_after_much_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A last time that is never reached was waited for without end; what ends before is told all the same."""
    monkeypatch.setattr(many_paths, "MORE_WINDOWS", 5)
    monkeypatch.setattr(many_paths, "CROSSINGS", 0.1)
    file = tmp_path / "turns.toml"
    file.write_text(
        '[grid]\nrows = 3\ncolumns = 4\n[field]\nkind = "spiral"\nangle = "pi/3"\nspeed = "unit"\n'
        '[body]\nshape = "rectangle"\nwidth = 3\nheight = "2.2"\n[friction]\nmu_roll = 1\nmu_side = 1\n'
        '[contact]\nrule = "ellipse"\n'
    )
    scene = load_scene(file)
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(np.array([[0.1, 0.05, 0.0], [9.0, 9.0, 0.0]]), 1e12)
    assert [ENDS[reason] for reason in found.reasons] == [BodyEnd.LOST, BodyEnd.LEAVES]
    assert 0 < found.times[0] < 1e3


def test_a_body_that_does_not_move_rests_at_once(tmp_path: Path) -> None:
    scene = carton_file(tmp_path)
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(np.array([[0.0, 0.0, 0.3], [1.0, 0.9, 0.3]]), 0.2)
    assert [ENDS[reason] for reason in found.reasons] == [BodyEnd.REST, BodyEnd.TIME]
    assert found.times[0] == 0
    assert found.turning[0] == pytest.approx(0, abs=1e-4)


@thorough  # the small one: test_ends_agree_with_paths_by_events
def test_bodies_end_by_cells_where_their_paths_by_events_do(tmp_path: Path) -> None:
    scene = carton_file(tmp_path, "nearest", "1/2")
    rule = rule_of(scene)
    assert isinstance(rule, CellRule)
    starts = random_poses(6, 1.0)
    ends = ManyPaths(scene, rule).follow(starts, until=6.0)
    path = CellPath(scene, rule)
    compared = 0
    for k, start in enumerate(starts):
        if not path.stands(start.tolist()):
            assert ends.by(BodyEnd.TIPS)[k]
            continue
        end = path.follow(start.tolist(), 6.0).end
        assert ends.by(BodyEnd.TIPS)[k] == (end.reason is EndReason.TIPS)
        if ends.by(BodyEnd.REST)[k]:
            assert np.abs(np.subtract(end.state[:2], ends.poses[k, :2])).max() < PLACE_ERROR
            compared += 1
    assert compared > 1


def test_loads_are_those_of_one_pose_at_a_time(tmp_path: Path) -> None:
    scene = carton_file(tmp_path)
    model, points = contacts_under(smooth_rule_of(scene), scene), random_poses(30, 2.4)[:, :2]
    levers = model.positions - points[:, None]
    loads, balanced = elastic_loads_of(levers, np.ones(levers.shape[:2], bool))
    assert balanced.all()
    np.testing.assert_allclose(loads, elastic_loads(model, points), atol=1e-10)
    rows, _ = RowsOfWheels(model).at(np.arange(36)[None], levers[:1], 1.0)
    assert rows.shape == (1, 36, 2, 3)


def test_a_body_tips_over_the_line_with_the_widest_gap() -> None:
    corners = np.array([[1.0, 0.2], [-1, 0.2], [-1, 1], [1, 1]])
    levers = np.stack([corners, corners - [0, 0.5]])
    gaps, first, second = widest_gaps(levers, np.ones((2, 4), bool))
    assert (gaps < np.pi).tolist() == [False, True]
    assert (first[0], second[0]) == (1, 0)
    assert np.isinf(widest_gaps(levers, np.zeros((2, 4), bool))[0]).all()


@pytest.mark.parametrize("count", keep(1, [1, 4]))
def test_ends_agree_with_paths_by_events(count: int, tmp_path: Path) -> None:
    scene = carton_file(tmp_path)
    starts = np.column_stack([random_poses(count, 1.6)[:, :2], np.full(count, 0.3)])
    told: list[str] = []
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(starts, report=lambda done, total, up_to: told.append(up_to))
    assert len(set(told)) > 2  # it moves while no path has ended
    assert told[-1] == f"t = {found.until:.3g} of {found.until:.3g}"
    path = BodyPath(contacts_under(smooth_rule_of(scene), scene), scene)
    for k, start in enumerate(starts):
        end = path.follow(tuple(start), 60.0).end
        assert end.reason is EndReason.REST
        assert found.by(BodyEnd.REST)[k]
        away = np.abs(np.array(end.state) - found.poses[k])
        assert away[:2].max() <= PLACE_ERROR
        assert away[2] <= HEADING_ERROR


@pytest.mark.parametrize(("side", "reach"), keep(1, [(2, 1), (3, 2), (5, 2)]))
def test_destinations_share_all_starts(side: int, reach: float, tmp_path: Path) -> None:
    scene = carton_file(tmp_path)
    axis = np.linspace(-reach, reach, side)
    x, y = np.meshgrid(axis, axis)
    paths = ManyPaths(scene, smooth_rule_of(scene))
    found = paths.follow(np.column_stack([x.ravel(), y.ravel(), np.full(side**2, 0.4)]))
    places = destinations(found, 0.02 * paths.spacing)
    assert sum(len(one.starts) for one in places) == side**2
    assert sum(one.share for one in places) == pytest.approx(1)
    resting = [one for one in places if one.reason is BodyEnd.REST]
    assert resting
    assert all(one.headings is not None and one.headings[0] <= one.headings[1] for one in resting)


def test_what_still_moves_is_said_to(tmp_path: Path) -> None:
    scene = carton_file(tmp_path)
    found = ManyPaths(scene, smooth_rule_of(scene)).follow(np.array([[1.0, 0.9, 0.3], [4.0, 4.0, 0.0]]), 0.2)
    assert found.by(BodyEnd.TIME).tolist() == [True, False]
    assert found.times[0] == pytest.approx(0.2)
    assert found.by(BodyEnd.LEAVES).tolist() == [False, True]


# ---- Smoothed twists of many bodies at once against proved minimizers, one by one ----------------

POINTS = 40
ERRORS = {"ellipse": 1e-5, "roller": 2e-3}  # of the fastest wheel's speed: by how much they are smoothed


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", keep(3, ["omni-3", "mecanum-4", "spiral-30", "grid-4x4", "conveyor-3"]))
def test_twists_are_the_minimizers(name: str, rule: str) -> None:
    """From the proved ones of points beside them: all settle, and lie where D is least."""
    scene = load_scene(name, rule=rule).recentred()
    smooth = smooth_rule_of(scene)
    model, radius = contacts_under(smooth, scene), float(scene.check.radius)
    points = np.random.default_rng(3).uniform(-0.9, 0.9, (POINTS, 2)) * radius
    paths = np.arange(POINTS)
    moving = MovingTwists(model, POINTS)
    moving.remember(minima_under(smooth, scene, 0.95 * points).twists, paths)
    found, settled = moving.at(points, paths)
    proved = minima_under(smooth, scene, points).twists
    assert settled.all()
    assert np.abs(found - proved).max() <= ERRORS[rule] * np.abs(model.speeds).max()


def test_paths_keep_their_own_twists() -> None:
    """A few paths of many: the others begin where they were."""
    scene = load_scene("conveyor-3", rule="ellipse").recentred()
    smooth = smooth_rule_of(scene)
    points = np.random.default_rng(4).uniform(-0.4, 0.4, (POINTS, 2)) * float(scene.check.radius)
    moving = MovingTwists(contacts_under(smooth, scene), POINTS)
    proved = minima_under(smooth, scene, points).twists
    moving.remember(proved, np.arange(POINTS))
    odd = np.arange(1, POINTS, 2)
    found, settled = moving.at(points[odd], odd)
    assert settled.all()
    assert np.abs(found - proved[odd]).max() <= ERRORS["ellipse"]


def test_a_step_counts_as_work_however_few_bodies_take_it() -> None:
    """What a call costs is that of its Newton steps: one body alone takes hardly less time than many together."""
    scene = load_scene("mecanum-4", rule="roller").recentred()
    smooth = smooth_rule_of(scene)
    points = np.random.default_rng(5).uniform(-0.4, 0.4, (POINTS, 2)) * float(scene.check.radius)
    spent = []
    for count in (1, POINTS):
        moving = MovingTwists(contacts_under(smooth, scene), count)
        moving.remember(minima_under(smooth, scene, points[:count]).twists, np.arange(count))
        for turn in range(10):
            moving.at(points[:count] * (1 - 0.01 * turn), np.arange(count))
        spent.append(moving.work)
    assert spent[0] >= 10 * EACH_STEP
    assert spent[0] < spent[1] < POINTS * spent[0]


def test_paths_end_when_their_work_is_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same starts with less work: those that still moved are said to, and no other end changes."""
    scene = load_scene("outward", rule="roller").recentred()
    starts = np.random.default_rng(6).uniform(-0.9, 0.9, (5, 2)) * float(scene.check.radius)
    whole = smooth_ends(scene, starts)
    monkeypatch.setattr(smooth_ends_module, "MOST_WORK", 400 * EACH_STEP)
    short = smooth_ends(scene, starts)
    assert (short.reached == MOVING).any()
    ended = short.reached == LEFT
    assert ended.any()
    assert (whole.reached[ended] == LEFT).all()
