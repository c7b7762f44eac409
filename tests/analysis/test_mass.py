"""Bodies with mass: an outline, friction sets of their own, a high centre of mass, and the limit of no mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from rich.console import Console

import nonsmooth as ns
from nonsmooth.analysis.bodies import mass_path
from nonsmooth.analysis.bodies import mass_study as studies
from nonsmooth.analysis.bodies.gyration import squared_radius_of_plate
from nonsmooth.analysis.bodies.mass_path import HELD, MassPath, simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import (
    MassStudy,
    body_of,
    body_path,
    mass_ladder,
    mass_study,
    path_distance,
    rule_path,
    rules_by_limit,
)
from nonsmooth.analysis.bodies.newton_euler import CREEP, DynamicPath, MovingLoads, NewtonEuler, RigidBody, disc
from nonsmooth.analysis.bodies.path import ellipse_path
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.proofs.answers.inertia import inertia_answer, near_rest
from nonsmooth.reports.simulations.masses import MassResult
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from tests.analysis.test_dynamics import random_model
from tests.conftest import Arrays, WheelData
from tests.oracles.heavy_bodies import HeavyTable, SprungBody
from tests.oracles.small_steps import small_steps_of_mass
from tests.oracles.wheels_in_floats import places_of
from tests.outlined import Pair, carton, on, polygon_of, pushed_back
from tests.thorough import few, keep, thorough

# ---- A body with mass and an outline against small Euler steps, whose geometry, loads and forces are written anew.

STEP_CREEP = 1e-3  # of the small steps: explicit steps take no less
OFF = 3e-3  # lengths and radians: what that creep and the steps change
POSE_ERROR = 1e-9


def followed(scene: Scene, body: RigidBody, start: tuple[float, float, float], until: float) -> DynamicPath:
    array = whole(scene)
    return MassPath(contact_model(array), body, array).follow(start, until)


@pytest.mark.parametrize(("until", "steps"), keep(1, [(0.6, 1000), (0.8, 2000)]))
def test_wheels_enter_and_leave_as_in_small_steps(until: float, steps: int) -> None:
    scene, depths = carton()
    start, masses = (1.3, 0.15, 0.0), (0.1, 0.15)
    path = followed(scene, RigidBody(*masses), start, until)
    kinds = [event.kind for event in path.trajectory.events]
    assert kinds == [EventKind.LEAVE, EventKind.LEAVE, EventKind.ENTER, EventKind.ENTER]
    expected = small_steps_of_mass(scene, depths, np.array(start), until, steps, masses, STEP_CREEP)
    assert np.abs(path.states[-1][:3] - expected[:3]).max() < OFF
    places = places_of(scene)
    for event in path.trajectory.events:
        wheel = int(event.surface.split()[1]) - 1
        assert abs(depths(places[[wheel]], np.array(event.state))[0]) < POSE_ERROR


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
    places = places_of(scene)
    for time in np.linspace(held.t, until, 5):
        assert abs(depths(places, path.state(time)[:3])[4]) < 3 * HELD
    expected = small_steps_of_mass(scene, depths, np.array(start), until, 4500, masses, STEP_CREEP)
    assert np.abs(path.states[-1][:3] - expected[:3]).max() < OFF


def test_a_body_over_all_wheels_moves_as_without_an_outline(arrays: Arrays) -> None:
    scene = arrays.four_wheel(turn=(Fraction(4, 5), Fraction(3, 5)))
    body, start = RigidBody(0.1, 0.05), (0.35, 0.2, 0.4)
    path = followed(on(scene, Disc(scene.field(9))), body, start, 1.0)
    expected = simulate_dynamics(contact_model(scene), body, start, 1.0)
    assert not path.trajectory.events
    assert np.abs(path.states[-1] - expected.states[-1]).max() < 1e-6


def test_a_path_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body at rest goes on resting: for how long is said, not waited for."""
    monkeypatch.setattr(mass_path, "MOST_WORK", 500)
    array = ns.Array.ring(4, radius=0.2, phase="pi/4", mu_roll=1, mu_side="1/2", check_radius=0.1)
    end = array.dynamics((0.05, 0.02, 0.1), until=1e9).trajectory.end
    assert end.reason is EndReason.STEPS
    assert 0 < end.t < 1e3


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
    assert squared_radius_of_plate(rectangle) == (a**2 + b**2) / 12
    assert squared_radius_of_plate(disc) == Fraction(9, 2) + 5


# ---- Bodies with mass and an outline beside the paths of the contact rules, as the mass goes to zero.

STUDIED, SLIDING = 0.2, 0.5  # the plate begins to slide at 0.211
SLOPE = 0.15  # of log distance against log mass, where 1 is expected


def ladder_study(scene: Scene, mass: float, count: int, start: tuple[float, float, float], until: float) -> MassStudy:
    assert scene.body is not None
    return mass_study(scene, mass_ladder(body_of(scene, mass), count), start, until)


@thorough  # the small one: test_masses_are_compared_where_wheels_leave, reports/test_bodies.py
def test_the_distance_from_rule_ellipse_falls_like_the_mass_through_changes_of_the_wheels() -> None:
    scene = whole(load_scene("carton-on-6x6"))
    start = (1.3, 0.15, 0.0)
    study = ladder_study(scene, 1e-3, 2, start, STUDIED)
    assert EventKind.LEAVE in {event.kind for event in rule_path(scene, "ellipse", start, STUDIED).events}
    for heavy, light in pairwise(study.rows):
        fall = heavy.distance("ellipse").position / light.distance("ellipse").position
        assert np.log10(fall) == pytest.approx(1, abs=SLOPE)
    own = study.rows[-1].distance("ellipse").position
    assert study.limits is not None
    assert {limit.rule for limit in study.limits} == {"nearest", "box", "roller"}
    for limit in study.limits:
        assert abs(study.rows[-1].distance(limit.rule).position - limit.position) <= own


@thorough
def test_no_limit_is_stated_where_the_path_slides_along_an_edge(arrays: Arrays) -> None:
    scene, _ = pushed_back(arrays)
    study = ladder_study(whole(scene), 1e-2, 1, (0.3, -0.2, 0.0), SLIDING)
    assert study.limits is None
    assert min(row.distance("ellipse").position for row in study.rows) > 0.05  # and indeed they do not meet
    shown = MassResult(scene, study)
    assert shown.facts()["limits"] is None
    console = Console(width=100, record=True)
    with console.capture() as captured:
        console.print(*shown.views())
    assert "no limit is stated" in captured.get()
    assert "-> 0" not in captured.get()


@pytest.mark.parametrize(("rules", "until"), keep(1, [("ellipse alone", 0.215), ("all", 0.215), ("all", 0.25)]))
def test_a_path_that_slides_along_an_edge_is_no_limit(
    arrays: Arrays, monkeypatch: pytest.MonkeyPatch, rules: str, until: float
) -> None:
    scene, start = whole(pushed_back(arrays)[0]), (0.3, -0.2, 0.0)
    path = rule_path(scene, "ellipse", start, until)
    assert EventKind.SLIDE in {event.kind for event in path.events}
    before = next(event.t for event in path.events if event.kind is EventKind.SLIDE)

    def of_rule(scene: Scene, rule: str, start: Sequence[float], until: float) -> Trajectory:
        if rule != "ellipse" and rules != "all":
            raise ValueError("left out")
        return rule_path(scene, rule, start, until)

    monkeypatch.setattr(studies, "rule_path", of_rule)
    assert mass_study(scene, (), start, until).limits is None
    assert mass_study(scene, (), start, float(before) / 2).limits is not None


# ---- The quasi-static limit: paths of full dynamics tend to that of rule ellipse, and to that of no other rule.

START, UNTIL = (0.2, 0.4, 0.0), 2.0


# The largest mass, how many there are, each a tenth of the one before, where they start and until when they go on; the
# first start is one from which no wheel with rollers is near to sticking, which takes small steps.
STUDIES = {
    "two bodies": (0.001, 2, (0.1, 0.4, 0.0), 0.3),
    "three bodies": (0.01, 3, START, 0.7),
    "three bodies for longer": (0.01, 3, START, 2.0),
}


@pytest.fixture(scope="module", params=keep(1, STUDIES))
def study(request: pytest.FixtureRequest) -> MassStudy:
    mass, count, start, until = STUDIES[request.param]
    scene = load_scene("four-wheel")
    return mass_study(scene, mass_ladder(disc(contact_model(scene), mass), count), start, until)


def test_study_is_a_table_in_a_notebook(study: MassStudy) -> None:
    html = study._repr_html_()
    assert html.startswith("<table>")
    assert html.count("<tr>") == 1 + len(study.rows) * 4 + 3
    assert f"{study.rows[1].distance('ellipse').position:.3g}" in html


def test_ladder_keeps_the_shape_of_the_body() -> None:
    ladder = mass_ladder(RigidBody(0.1, 0.3), 3)
    assert [body.mass for body in ladder] == pytest.approx([0.1, 0.01, 0.001])
    assert [body.inertia / body.mass for body in ladder] == pytest.approx([3.0] * 3)


def test_distance_to_rule_ellipse_falls_like_the_mass(study: MassStudy) -> None:
    for heavy, light in pairwise(study.rows):
        for field in ("position", "rotation"):
            fall = getattr(heavy.distance("ellipse"), field) / getattr(light.distance("ellipse"), field)
            assert np.log10(fall) == pytest.approx(1, abs=SLOPE)
    assert study.rows[-1].distance("ellipse").position < 1e-3


def test_distance_to_the_other_rules_tends_to_theirs_from_ellipse(study: MassStudy) -> None:
    assert study.limits is not None
    limits = {limit.rule: limit for limit in study.limits}
    assert set(limits) == {"nearest", "box", "roller"}
    for row in study.rows:
        own = row.distance("ellipse")
        for rule, limit in limits.items():
            assert abs(row.distance(rule).position - limit.position) <= own.position
            assert abs(row.distance(rule).rotation - limit.rotation) <= own.rotation
    assert min(limit.position for limit in study.limits) > 0.1


@thorough
def test_flat_functional_puts_the_fall_off_until_the_mass_is_tiny() -> None:
    """Three wheels: the field turns around within 1e-4; the fall is that of sqrt(m) first, and that of m in the end."""
    scene = load_scene("ring-3")
    bodies = [disc(contact_model(scene), mass) for mass in (1e-4, 1e-5, 1e-8, 1e-9)]
    first, second, third, last = mass_study(scene, bodies, START, 0.15).rows
    for heavy, light, power in ((first, second, 0.5), (third, last, 1.0)):
        fall = heavy.distance("ellipse").position / light.distance("ellipse").position
        assert np.log10(fall) == pytest.approx(power, abs=SLOPE)


@pytest.mark.parametrize("until", keep(1, [0.005, 0.05, 0.5]))
def test_rules_without_a_path_are_named(until: float) -> None:
    scene = load_scene("conveyor-3")
    study = mass_study(scene, mass_ladder(disc(contact_model(scene), 0.01), 1), START, until)
    assert set(study.skipped) == {"nearest", "box"}
    assert "required a start inside the domain" in study.skipped["box"]
    assert [own.rule for own in study.rows[0].distances] == ["ellipse", "roller"]
    assert study.limits is not None
    assert [limit.rule for limit in study.limits] == ["roller"]


def test_paths_that_break_off_are_compared_while_they_last() -> None:
    scene = load_scene("outward")
    path, other = rule_path(scene, "nearest", START, UNTIL), rule_path(scene, "ellipse", START, UNTIL)
    distance = path_distance("ellipse", path, other, UNTIL)
    assert path.end.reason is EndReason.OUTSIDE
    assert distance.until == pytest.approx(float(path.end.t))
    assert distance.until < float(other.end.t) < UNTIL
    apart = np.array(path.at(distance.until), float) - np.array(other.at(distance.until))
    assert distance.position >= np.hypot(*apart[:2]) * (1 - 1e-12) > 0  # the same place, reached by other sums


def test_distance_is_that_of_known_motions() -> None:
    """Two conveyors side by side in the plane of velocities: one moves along x, one along y at twice the speed."""
    square = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
    along = [ContactModel.build(square, (rim,) * 4, (s,) * 4, (1.0, 1.0)) for rim, s in (((1, 0), 1.0), ((0, 1), 2.0))]
    first, second = (ellipse_path(model, (0.0, 0.0, 0.5), 0.25) for model in along)
    distance = path_distance("ellipse", first, second, 0.25)
    assert distance.position == pytest.approx(0.25 * np.sqrt(5), rel=1e-9)
    assert distance.rotation == pytest.approx(0, abs=1e-9)


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "spiral-30", "off-center"])
def test_settled_twist_is_the_minimizer_at_its_own_pose(name: str) -> None:
    """After a few settling times the velocity differs from the minimizer's by the order of the mass."""
    model = contact_model(load_scene(name))
    errors = []
    for mass in (1e-4, 1e-5):
        x, y, _, wx, wy, omega = simulate_dynamics(model, disc(model, mass), START, 0.1).states[-1]
        twist = np.array([wx + omega * y, wy - omega * x, omega])
        loads = loads_at(model, [[x, y]])
        errors.append(np.abs(twist - EllipseMinimizer().minimize(model, loads).twists[0]).max())
    assert errors[0] < 0.02
    assert errors[1] < errors[0] / 5


def test_ellipse_path_moves_with_the_minimizer_and_exact_kinematics() -> None:
    model = contact_model(load_scene("spiral-30"))
    path, step = ellipse_path(model, START, 1.0), 1e-4
    for t in (0.1, 0.5, 0.9):
        x, y, _ = path.at(t)
        ((vx, vy, omega),) = EllipseMinimizer().minimize(model, loads_at(model, [[x, y]])).twists
        rate = (np.array(path.at(t + step)) - np.array(path.at(t - step))) / (2 * step)
        assert np.allclose(rate, [vx - omega * y, vy + omega * x, omega], atol=1e-5)


def test_start_without_loads_or_time_is_refused() -> None:
    scene = load_scene("four-wheel")
    model = contact_model(scene)
    with pytest.raises(LoadError, match="the body tips there"):
        mass_study(scene, [disc(model, 0.1)], (1.5, 0.0, 0.0), 1.0)
    with pytest.raises(LoadError, match="the body tips there"):
        ellipse_path(model, (1.5, 0.0, 0.0), 1.0)
    with pytest.raises(ValueError, match="positive last time"):
        ellipse_path(model, START, 0.0)


# ---- Bodies with mass under the friction sets of their own wheels: rollers that turn, and rubber beside rollers.
#
# Against Newton's law with fixed steps, written anew (:mod:`tests.oracles.heavy_bodies`), and against the path of the
# rule to which light bodies tend.

BODY = RigidBody(0.1, 0.08)
MIXED_START, MIXED_UNTIL = (0.5, 0.3, 0.3), 0.6
ROUNDED = 0.004  # of the oracle: its forces differ by as much where a wheel nearly sticks
APART = 2e-3  # of poses: the largest seen 9e-4


def four_wheels(*rules: str) -> Scene:
    """Wheels whose bearings pass on a fifth of the friction, or rubber ones that are alike in all directions."""
    scene = load_scene("four-wheel")
    number = scene.field.rational
    wheels = []
    for wheel, rule in zip(scene.wheels, rules, strict=True):
        side = number(Fraction(1, 5)) if rule == "roller" else number(Fraction(1))
        friction = Friction(number(Fraction(1)), side, rule if len(set(rules)) > 1 else "")
        wheels.append(replace(wheel, friction=friction))
    rule = "mixed" if len(set(rules)) > 1 else rules[0]
    return replace(scene, wheels=tuple(wheels), contact=replace(scene.contact, rule=rule))


def table(scene: Scene) -> HeavyTable:
    """The same in the words of the oracle: where bearings hold all the contact does, a disc is not cut."""
    rims = np.array([[float(x) for x in wheel.direction] for wheel in scene.wheels])
    given = [wheel.given_speed for wheel in scene.wheels]
    speeds = [np.hypot(*rim) if own is None else float(own) for rim, own in zip(rims, given, strict=True)]
    friction = np.array([[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels])
    places = places_of(scene)
    headings, ratio = np.arctan2(rims[:, 1], rims[:, 0]), BODY.inertia / BODY.mass
    return HeavyTable(places, headings, np.array(speeds), friction, 1 / BODY.mass, ratio, friction[:, 1], ROUNDED)


@pytest.mark.parametrize(
    "rules",
    [("ellipse", "ellipse", "roller", "roller"), pytest.param(("roller",) * 4, marks=thorough)],
    ids=str,
)
def test_a_body_moves_by_the_forces_of_its_own_wheels(rules: tuple[str, ...]) -> None:
    scene = four_wheels(*rules)
    end = np.array(body_path(scene, BODY, MIXED_START, MIXED_UNTIL).trajectory.end.state)
    _, states = table(scene).follow(np.array([MIXED_START]), MIXED_UNTIL)
    assert np.abs(end - states[-1, 0, :3]).max() < APART
    whole = np.array(body_path(scene.under("ellipse"), BODY, MIXED_START, MIXED_UNTIL).trajectory.end.state)
    assert np.abs(end - whole).max() > 5 * APART  # so plain ellipses would be seen


def test_light_bodies_tend_to_the_path_of_their_own_rule() -> None:
    """Where rollers turn D is linear in pieces, and hardly damps: the distance falls like sqrt(m)."""
    scene = four_wheels(*["roller"] * 4)
    assert rules_by_limit(scene)[0] == "roller"
    study = mass_study(scene, mass_ladder(RigidBody(1e-4, 1e-4), 2), MIXED_START, 0.2)
    heavy, light = (row.distance("roller").position for row in study.rows)
    assert np.log10(heavy / light) == pytest.approx(0.5, abs=0.1)
    limits = {limit.rule: limit.position for limit in study.limits or ()}
    assert set(limits) == {"nearest", "box", "ellipse"}
    assert light < min(limits.values()) / 5


# ---- Where the centre of mass is above the wheels: loads shift while a body accelerates, against springs in space.

TALL_START = (0.1, 0.15, 0.0)
FLAT = RigidBody(0.3, 0.2)
TALL = RigidBody(0.3, 0.2, centre_height=0.4)
BESIDE = 2e-3  # relative distance from the printed limits at which eigenvalues are looked at


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_the_path_is_that_of_a_body_on_stiff_springs(seed: int) -> None:
    model, times = random_model(seed, 4 + seed % 3), np.linspace(0.0, 1.5, 30)
    flat, tall = (simulate_dynamics(model, body, TALL_START, 1.5).trajectory.sample(times) for body in (FLAT, TALL))
    friction = np.column_stack([model.sets.along, model.sets.across])
    sprung = SprungBody(
        model.positions, model.rows[::2, :2], model.speeds, friction, 0.3, 0.2, height=0.4, stiffness=3e4, creep=1e-5
    )
    seen = sprung.follow(np.array(TALL_START[:2]), times)
    assert np.abs(seen - tall).max() < 3e-5
    assert np.abs(flat - tall).max() > 2e-4


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
        simulate_dynamics(model, replace(TALL, centre_height=50.0), TALL_START, 1.0)


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
