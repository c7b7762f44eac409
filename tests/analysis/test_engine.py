"""Paths against MuJoCo, a rigid-body physics engine that knows nothing of contact rules; more in tests/benchmarks."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mujoco
import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.newton_euler import RigidBody
from nonsmooth.analysis.cells.load_sets import load_set
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback, decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.load_model import LoadScatter, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.body_engine import (
    SETTLING,
    SLOW,
    THICK,
    Plate,
    PlateEngine,
    laid_plate,
    lifted_loads,
    plate_engine,
    pose_beside_engine,
    predicted_changes,
    random_grid,
    run_beside_engine,
    with_random_body,
)
from tests.conftest import Arrays
from tests.roller_engine import SPEED, creep_rates, mixed_errors, random_array, relative_errors, settled_twist
from tests.thorough import few, keep, thorough

# ---- Rule ellipse and full dynamics against MuJoCo, a rigid-body physics engine that knows nothing of either.
#
# What is modelled: the four-wheel array turned by 45 degrees, with wheels at distance sqrt(2) on the axes and rims
# inward, under a thin square plate (:mod:`tests.body_engine` says how).  Wheels are slow because the engine's convex
# friction couples slip and normal force by its damping: at 1e-4 lengths per second that changes loads by a few parts in
# ten thousand, at 1e-3 by a per cent.

GRAVITY = 9.81
HALF = 3.0  # half side of the plate: it covers all wheels from everywhere
REST = 0.5  # seconds: fifty time constants of the contacts
TWIST = 2e-3  # relative, of twists; the goal is 0.05, the largest seen 0.0007
SHARE = 1e-3  # of the weight, of loads; 0.0003 was the largest seen
IMPOSED = 2e-4  # relative, of twists that speeds impose; the largest seen 2e-5
LAG = 2e-2  # relative, of the pose: the engine settles and its law acts on samples
PATH = 2e-3  # lengths and radians on a path of length 0.4; 3e-4 was the largest seen

INWARD = -np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])  # rims of the array turned by 45 degrees
FRICTION = {"side 1/2": (1.0, 0.5), "side 1/10": (1.0, 0.1), "roll 1/2": (0.5, 1.0)}  # (mu_R, mu_S)
with_friction = pytest.mark.parametrize("friction", FRICTION.values(), ids=FRICTION)


def array(friction: tuple[float, float], speed: float) -> ContactModel:
    """The four-wheel array turned by 45 degrees."""
    return ContactModel.build(-np.sqrt(2) * INWARD, INWARD, np.full(4, speed), friction)


def engine(wheels: ContactModel, start: tuple[float, float], timestep: float, time_constant: float) -> PlateEngine:
    """A square plate laid onto the wheels, which covers all of them from everywhere."""
    plate = Plate(mujoco.mjtGeom.mjGEOM_BOX, [HALF, HALF, THICK])
    return laid_plate(wheels, plate, (*start, 0.0), timestep, time_constant)


def starts() -> list[tuple[float, float]]:
    """Six positions in the square of half-width 1/2."""
    points = np.random.default_rng(20010).uniform(-0.5, 0.5, size=(6, 2))
    return [(float(x), float(y)) for x, y in points]


def settled(friction: tuple[float, float], start: tuple[float, float]) -> tuple[PlateEngine, ContactModel]:
    wheels = array(friction, speed=1e-4)
    plate = engine(wheels, start, timestep=1e-3, time_constant=0.01)
    plate.step(REST)
    return plate, wheels


def relative_error(twist: Floats, measured: Floats) -> float:
    """Difference of twists over the largest entry of the measured one."""
    return float(np.abs(twist - measured).max() / np.abs(measured).max())


@with_friction
@pytest.mark.parametrize("start", starts())
def test_engines_settled_twist_is_that_of_rule_ellipse(
    friction: tuple[float, float], start: tuple[float, float]
) -> None:
    """With elastic loads, at the engine's own pose; rule box is much farther off, so the test tells them apart."""
    plate, wheels = settled(friction, start)
    before = plate.twist
    plate.step(0.01)
    assert np.abs(plate.twist - before).max() < 1e-3 * np.abs(before).max()
    loads = loads_at(wheels, [plate.pose[:2]])
    expected, other = (method.minimize(wheels, loads).twists[0] for method in (EllipseMinimizer(), BoxHighs()))
    error = relative_error(expected, plate.twist)
    assert error < TWIST
    assert error < relative_error(other, plate.twist) / 10
    assert np.abs(plate.loads() - loads[0]).max() < SHARE


@few(1)
@pytest.mark.parametrize("until", keep(1, [150.0, 400.0]))
@pytest.mark.parametrize("friction", [FRICTION["side 1/2"], FRICTION["side 1/10"]])
def test_engines_path_is_that_of_full_dynamics(friction: tuple[float, float], until: float) -> None:
    """A part of the way to the middle, and most of it, a turn included, at 1e-3 lengths per second."""
    wheels, start = array(friction, speed=1e-3), (0.2, 0.45)
    plate = engine(wheels, start, timestep=5e-3, time_constant=0.02)
    inertia = plate.model.body_inertia[1, 2]
    body = RigidBody(1 / GRAVITY, inertia / GRAVITY)  # the plate weighs one kilogram
    path = simulate_dynamics(wheels, body, (*start, 0.0), until).trajectory
    for quarter in range(1, 5):
        plate.step(until / 4)
        assert np.abs(plate.pose - path.at(quarter * until / 4)).max() < PATH
    travelled = np.abs(plate.pose - (*start, 0.0))
    assert travelled.min() > 10 * PATH


# ---- what the feedback clause says that speeds impose --------------------------------------------


def law_of(arrays: Arrays, side_friction: Fraction) -> tuple[Scene, DrivenFeedback]:
    """The array turned by 45 degrees, of size 3/2, with the law of rule ellipse."""
    far = Fraction(3, 2)
    scene = arrays.scene(arrays.inward([(far, 0), (0, far), (-far, 0), (0, -far)]), (1, side_friction))
    return scene, decide_driven_feedback(replace(scene, contact=replace(scene.contact, rule="ellipse")))


@pytest.mark.parametrize("side_friction", [Fraction(1, 2), Fraction(1, 10)], ids=["side 1/2", "side 1/10"])
def test_the_engine_turns_the_body_as_imposed(arrays: Arrays, side_friction: Fraction) -> None:
    """Inward rims have no torque about the equilibrium; speeds that let wheels slip unequally turn the body."""
    scene, feedback = law_of(arrays, side_friction)
    (cone,) = feedback.cones
    assert any(twist[2] for twist in cone.vectors)
    for imposed in cone.twists:
        speeds = 1e-4 * np.array(rim_speeds(scene, imposed))
        wheels = ContactModel.build(-1.5 * INWARD, INWARD, speeds, (1.0, float(side_friction)))
        plate = engine(wheels, (0.0, 0.0), timestep=1e-3, time_constant=0.01)
        plate.step(REST)
        assert relative_error(1e-4 * np.array([float(x) for x in imposed.twist]), plate.twist) < IMPOSED


@thorough  # the small one: test_the_engine_turns_the_body_as_imposed
def test_the_certified_law_brings_the_body_home_in_the_engine(arrays: Arrays) -> None:
    """Position and heading, with inward rims: twist tracking and the paper's law leave theta where it is."""
    scene, feedback = law_of(arrays, Fraction(1, 2))
    (cone,) = feedback.cones
    assert feedback.kappa is not None
    twists = np.array([[float(x) for x in twist] for twist in cone.vectors])
    speeds = np.array([rim_speeds(scene, imposed) for imposed in cone.twists])
    wheels = ContactModel.build(-1.5 * INWARD, INWARD, np.full(4, 1e-4), (1.0, 0.5))
    plate = engine(wheels, (0.05, 0.02), timestep=2e-3, time_constant=0.01)
    plate.data.qpos[3], plate.data.qpos[6] = np.cos(0.05), np.sin(0.05)  # theta = 0.1
    start, gain, seconds = np.linalg.norm(plate.pose), 0.05, 150.0
    for _ in range(round(seconds / 0.01)):
        products = twists @ plate.pose
        best = int(np.argmax(np.abs(products)))
        plate.velocities[:] = -gain * products[best] * speeds[best][:, None] * plate.rims
        plate.step(0.01)
    bound = np.exp(-gain * float(feedback.kappa) * seconds)  # V' <= -2 k kappa V
    assert bound * start < 0.05  # so long that the certified rate alone halves the heading
    assert np.linalg.norm(plate.pose) <= bound * start * (1 + LAG)
    assert abs(plate.pose[2]) < 0.05


# ---- Rule ``roller`` against MuJoCo with real rollers: three arrays; the benchmarks take a hundred; mixed arrays
# too.

MIXED = 2.5e-3  # relative; the largest of a hundred 2.0e-3, nine of ten below 5.4e-4
CREEP = 2e-2  # relative; the largest seen 2e-3


@pytest.mark.parametrize("seed", [8, 13, 2])
def test_engines_settled_twist_is_that_of_rule_roller(seed: int) -> None:
    roller, ellipse, _ = relative_errors(*random_array(seed))
    assert roller < TWIST
    assert roller < ellipse / 10


@pytest.mark.parametrize("array", keep(2, range(100)))
def test_rubber_beside_rollers_settles_as_the_mixed_rule_says(array: int) -> None:
    """Every other wheel is of rubber.  The engine's own loads, which slip shifts by a thousandth of the weight."""
    mixed, ellipse = mixed_errors(array)
    assert mixed < MIXED
    assert mixed < ellipse


@pytest.mark.parametrize("side", [0.02, 0.5])
def test_rollers_that_stand_creep_home_whatever_their_bearings(side: float) -> None:
    """``c' = -sqrt(2) u c``: under rule box the body rests, under rule ellipse it is ``(mu_R/mu_S)^2`` as fast."""
    assert creep_rates(side) == pytest.approx(np.sqrt(2), rel=CREEP)


# ---- Rule ``roller`` with friction axes against MuJoCo: rollers on real bearings whose axes stand askew to the rims.

MEDIAN = 2e-3  # relative error of a twist, as for rollers across the rims; 3e-5 was seen, and 2e-3 in one of these five
SLOWED = SPEED / 3  # the fastest rim of the scene runs at 3


def test_twists_of_mecanum_wheels_in_the_engine() -> None:
    """Where a twist jumps, the loads of the engine decide: so the median counts.  Without the axis all are far off."""
    errors = np.array([relative_errors(*random_array(seed, askew=True))[0] for seed in range(5)])
    assert np.median(errors) < MEDIAN


def test_the_scene_turns_in_the_engine_as_it_says() -> None:
    model = contact_model(load_scene("mecanum-4"))
    slow = type(model).build(model.positions, model.rims, SLOWED * model.speeds, (1.0, 0.02), axes=list(model.axes))
    twist, _ = settled_twist(slow, np.array([0.1, 0.05]))
    assert twist / SLOWED == pytest.approx([0, 0, 1], abs=5e-3)


# ---- Wheels of unequal height in MuJoCo: their loads lie in the set, and bodies come nearer whatever the loads are.

SLIP_AND_TILT = 2e-3  # of the weight: what slip and tilt change in the engine
DEFLECTION_SHARE = Fraction(1, 5)  # of the mean deflection
MANY = 4.0  # mean deflections: wheels lift off


def plate_on_a_ring(name: str) -> Scene:
    """A disc that covers every wheel."""
    scene = load_scene(name, rule="ellipse")
    zero, one = scene.field.zero, scene.field.one
    return replace(scene, body=Body(Disc(scene.field(2)), (zero, zero), (one, zero)))


def deflection(scene: Scene) -> float:
    """How far the plate sinks in the middle, where all wheels carry alike."""
    plate = plate_engine(scene, (0.0, 0.0, 0.0), SLOW)
    plate.step(SETTLING)
    return float(THICK - plate.data.qpos[2])


def settled_on(scene: Scene, start: Floats, lowered: Floats) -> tuple[Floats, Floats, Floats]:
    """Pose, twist and loads of the engine."""
    plate = plate_engine(scene, (float(start[0]), float(start[1]), 0.0), SLOW, lowered=lowered)
    plate.step(SETTLING)
    return plate.pose, plate.twist, plate.loads()


@few(1)
@pytest.mark.parametrize("name", ["ring-6", "four-wheel", "ring-5"])
def test_loads_of_wheels_of_unequal_height_lie_in_the_set(name: str) -> None:
    scene, rng = plate_on_a_ring(name), np.random.default_rng(4)
    scatter = UnknownLoads(LoadScatter(scene.field(DEFLECTION_SHARE), scene.field.zero))
    unit, spread = deflection(scene), 0.0
    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    worst = np.sign(np.eye(len(moments)) - moments @ np.linalg.pinv(moments))
    for signs in (*worst[:2], *rng.choice([-1.0, 1.0], (4, len(moments)))):
        start, corner = rng.uniform(-0.15, 0.15, 2), signs * float(DEFLECTION_SHARE) * unit
        pose, _, loads = settled_on(scene, start, corner)
        x, y = (scene.field(Fraction(float(entry)).limit_denominator(10**6)) for entry in pose[:2])
        there = replace(scene, contact=Contact("ellipse", scatter)).checked_at((x, y), scene.field(Fraction(1, 100)))
        found = load_set(there.recentred())
        assert not found.remark
        least, largest = (np.array([float(n) for n in end]) for end in (found.bound.least, found.bound.largest))
        assert (loads >= least - SLIP_AND_TILT).all()
        assert (loads <= largest + SLIP_AND_TILT).all()
        elastic = np.array([float(n) for n in found.bound.middle])
        spread = max(spread, np.abs(loads - elastic).max() / (largest - elastic).max())
    assert spread > 0.99  # its ends are reached


@few(1)
@pytest.mark.parametrize("name", ["ring-6", "four-wheel"])
def test_bodies_come_nearer_on_wheels_of_any_height(name: str) -> None:
    """Also where wheels lift off: the verdict for every load says ``c . v < 0``."""
    scene, rng = plate_on_a_ring(name), np.random.default_rng(5)
    unit, lifted = deflection(scene), 0
    for _ in range(8):
        angle = rng.uniform(0, 2 * np.pi)
        start = 0.3 * np.array([np.cos(angle), np.sin(angle)])
        pose, twist, loads = settled_on(scene, start, rng.uniform(-MANY, MANY, len(scene.wheels)) * unit)
        lifted += loads.min() <= 0
        assert pose[:2] @ twist[:2] < 0
    assert lifted > 0


# ---- Bodies with an outline against MuJoCo: a few poses and one path; many of them are in the benchmarks.

TWISTS = 1e-3, 1e-2  # median and largest; over many poses 1e-4 is the median, and one of ten above 6e-4
LOADS = 2e-4  # of the weight
MARGIN = 0.05  # pitches: poses with a wheel nearer to the edge are left out
LATE, FAR = 0.04, 0.03  # of a path of length 0.4 at wheels of speed one; the largest seen 0.014 and 0.012


@thorough  # the small one: test_wheels_enter_and_leave_as_in_the_engine
def test_twists_loads_and_falls_of_random_bodies() -> None:
    poses = [pose_beside_engine(seed) for seed in range(1, 25)]
    assert all(pose.fell == pose.tips for pose in poses)
    assert any(pose.tips for pose in poses)
    inside = [pose for pose in poses if not pose.tips and pose.margin > MARGIN]
    assert len(inside) >= 6
    errors = [pose.twist_error for pose in inside]
    assert np.median(errors) < TWISTS[0]
    assert max(errors) < TWISTS[1]
    assert max(pose.load_error for pose in inside) < LOADS


@pytest.mark.parametrize(("until", "changes"), keep(1, [(0.22, 2), (0.4, 3)]))
def test_wheels_enter_and_leave_as_in_the_engine(until: float, changes: int) -> None:
    rng = np.random.default_rng(1)
    run = run_beside_engine(with_random_body(random_grid(rng), rng, 1.2), until)
    assert run.path.end.reason is EndReason.TIME
    assert len(predicted_changes(run.path)) == changes
    assert run.changes_alike(LATE)
    assert run.tips_alike
    assert run.error < FAR


@pytest.mark.parametrize(("seed", "speed", "time_constant"), [(1, 3e-3, 0.02), (1, 3e-3, 0.04), (3, 3e-3, 0.02)])
def test_slip_lifts_the_springs_of_the_engine(seed: int, speed: float, time_constant: float) -> None:
    """Why poses of engine and product part: by loads, which agree as wheels run more slowly."""
    engine, springs, lifted = lifted_loads(seed, speed, time_constant)
    apart = np.abs(engine - springs).max()
    assert apart > 5e-3
    assert np.abs(engine - lifted).max() < 0.01 * apart
