"""A body with an outline on a grid of wheels in MuJoCo, a rigid-body physics engine that knows nothing of outlines.

Every wheel of the grid is there: a small sphere fixed in the world, its top at height zero, whose surface runs along
its rim (``surfacevel``).  The body is a plate with a free joint in space, under gravity, a box or a cylinder that may
lie beside its centre of mass; the engine itself finds which spheres touch it.  Contacts are springs and dampers of
equal stiffness, and nobody tells the engine the loads.  Rims point anywhere: after the engine has found the contacts,
the tangents of each contact's frame are turned to the rim and across it, so that its elliptic cone has mu_R and mu_S
there; then its own constraint solver goes on.

What the engine has and the product has not: a contact that slips at a speed s lifts its spring, so that the engine's
loads are those of springs of unequal height (:func:`lifted_loads`).  At wheels of speed u, gravity g and a time
constant T of the contacts that is ``4 u/(g T)`` of the weight; where a motion reacts strongly to loads, poses come out
a tenth of a length apart, and fall together as u does.  The plate sinks into the wheels (about 1e-4 lengths), tilts a
little and creeps while it settles.  So twists are compared at the engine's own pose after settling, and paths start
there.  A wheel beside the plate touches its lower edge up to ``sqrt(2 RADIUS sinking)`` too early (about 1e-3 lengths).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import elastic_loads
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.symbolic.files.scene_document import rectangle
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.contact_set import TipsError, contact_set, standing
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from tests.conftest import Arrays, WheelData

Floats: TypeAlias = NDArray[np.float64]

GRAVITY = 9.81
THICK = 0.02  # half thickness of the plate
RADIUS = 0.01  # of the spheres
INERTIA = 0.5  # of the plate about its vertical axis; half of it about the others
FALLEN = 5e-3  # tilt (radian) of a plate that tips; standing ones are below 1e-3
GRID = 6
SLOW = 1e-6  # speed of wheels for twists: slip moves the loads of the engine by 1e-5 of the weight
SETTLING, FALLING = 0.6, 1.0  # seconds
BRISK = 3e-3  # speed of wheels for paths
TIMESTEP, TIME_CONSTANT = 5e-3, 0.02  # seconds, for paths; a softer plate has truer loads, but sinks deeper
SAMPLE = 2.0  # seconds between two looks at a path


# Of a few vectors each, one a column; by components: np.cross takes longer than all the engine does.


def _inner(first: Floats, second: Floats) -> Floats:
    """Inner products."""
    (a, b, c), (x, y, z) = first, second
    return np.asarray(a * x + b * y + c * z)


def _cross(first: Floats, second: Floats) -> Floats:
    """Vector products."""
    (a, b, c), (x, y, z) = first, second
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


@dataclass
class PlateEngine:
    """A plate of mass 1 on the wheels."""

    model: mujoco.MjModel
    data: mujoco.MjData
    rims: Floats
    friction: Floats
    velocities: Floats

    def step(self, seconds: float) -> None:
        """The engine's own stages, with contact frames turned between two of them."""
        for _ in range(round(seconds / self.model.opt.timestep)):
            self._forward()
            mujoco.mj_Euler(self.model, self.data)

    def _forward(self) -> None:
        model, data = self.model, self.data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        mujoco.mj_collision(model, data)
        self._turn_frames()
        mujoco.mj_makeConstraint(model, data)
        mujoco.mj_projectConstraint(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mujoco.mj_fwdConstraint(model, data)

    def _turn_frames(self) -> None:
        """Tangents along each rim and across it, in the plane of the contact."""
        contacts = self.data.contact
        if not len(contacts):
            return
        wheels, frames = self.touching, contacts.frame
        normals, rims, velocities = frames[:, :3].T, self.rims[wheels].T, self.velocities[wheels].T
        along = rims - _inner(rims, normals) * normals
        along /= np.sqrt(_inner(along, along))
        across = _cross(normals, along)
        frames[:, 3:6], frames[:, 6:9] = along.T, across.T
        contacts.friction[:, :2] = self.friction[wheels]
        surface = contacts.surfacevel  # of the plate, less the wheel's
        surface[:, 0], surface[:, 1] = -_inner(along, velocities), -_inner(across, velocities)

    @property
    def touching(self) -> NDArray[np.int_]:
        """The wheels of the contacts; their geoms come first."""
        first, second = self.data.contact.geom.T
        return np.minimum(first, second)

    @property
    def pose(self) -> Floats:
        """``(x, y, theta)``."""
        place = self.data.qpos
        return np.array([place[0], place[1], 2 * np.arctan2(place[6], place[3])])

    @property
    def twist(self) -> Floats:
        """Spatial twist ``(v, omega)``."""
        (x, y, _), (wx, wy, _), omega = self.pose, self.data.qvel[:3], self.data.qvel[5]
        return np.array([wx + omega * y, wy - omega * x, omega])

    @property
    def has_fallen(self) -> bool:
        """Whether the plate lies aslant."""
        return bool(np.hypot(*self.data.qpos[4:6]) > FALLEN / 2)

    def loads(self) -> Floats:
        """Normal forces of all wheels, as shares of the weight."""
        self._forward()
        loads, force = np.zeros(len(self.rims)), np.zeros(6)
        for k, wheel in enumerate(self.touching):
            mujoco.mj_contactForce(self.model, self.data, k, force)
            loads[wheel] += force[0] / GRAVITY
        return loads


def plate_engine(
    scene: Scene,
    pose: tuple[float, float, float],
    scale: float,
    timestep: float = 1e-3,
    time_constant: float = 0.01,
    lowered: Floats | None = None,
) -> PlateEngine:
    """The body of a scene laid onto all its wheels, which run ``scale`` times as fast; some may be lowered."""
    body = scene.body
    assert body is not None
    wheels = contact_model(replace(scene, body=None))
    (shape, size), (c, s) = _geom(body), (float(entry) for entry in body.heading)
    plate = Plate(shape, size, (float(body.centroid[0]), float(body.centroid[1])), float(np.arctan2(s, c)))
    return laid_plate(replace(wheels, targets=scale * wheels.targets), plate, pose, timestep, time_constant, lowered)


class Plate(NamedTuple):
    """The shape of a plate, and where its middle is from its centre of mass."""

    shape: mujoco.mjtGeom
    size: list[float]
    middle: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0


def laid_plate(
    wheels: ContactModel,
    plate: Plate,
    pose: tuple[float, float, float],
    timestep: float,
    time_constant: float,
    lowered: Floats | None = None,
) -> PlateEngine:
    """A plate laid onto wheels, each a sphere of its own."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = timestep, [0, 0, -GRAVITY]
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 1e9  # the creep of friction is far below 1e-6
    spec.option.iterations, spec.option.tolerance = 200, 1e-14
    x, y, theta = pose
    body = spec.worldbody.add_body(name="plate", pos=[x, y, THICK], quat=[np.cos(theta / 2), 0, 0, np.sin(theta / 2)])
    body.add_freejoint()
    body.explicitinertial, body.mass, body.inertia = True, 1.0, [INERTIA / 2, INERTIA / 2, INERTIA]
    body.ipos, body.iquat = [0, 0, 0], [1, 0, 0, 0]
    body.add_geom(
        name="plate",
        type=plate.shape,
        size=plate.size,
        pos=[*plate.middle, 0],
        quat=[np.cos(plate.turn / 2), 0, 0, np.sin(plate.turn / 2)],
        contype=0,
        conaffinity=0,
    )
    rims = np.column_stack([wheels.rims, np.zeros(wheels.wheels)])
    velocities, friction = wheels.speeds[:, None] * rims, wheels.friction.reshape(-1, 2)
    for k, position in enumerate(wheels.positions):
        depth = 0.0 if lowered is None else float(lowered[k])
        sphere, place = mujoco.mjtGeom.mjGEOM_SPHERE, [*position, -RADIUS - depth]
        spec.worldbody.add_geom(
            name=f"wheel {k}", type=sphere, size=[RADIUS, 0, 0], pos=place, surfacevel=[*velocities[k], 0, 0, 0]
        )
        spec.add_pair(
            geomname1="plate",
            geomname2=f"wheel {k}",
            condim=3,
            friction=[*friction[k], 0, 0, 0],
            solref=[time_constant, 1],
            solimp=[0.5, 0.5, 1, 0.5, 2],
        )
    model = spec.compile()
    return PlateEngine(model, mujoco.MjData(model), rims, friction, velocities)


def _geom(body: Body) -> tuple[mujoco.mjtGeom, list[float]]:
    if isinstance(body.outline, Disc):
        return mujoco.mjtGeom.mjGEOM_CYLINDER, [float(body.outline.radius), THICK, 0]
    assert body.outline.name == "rectangle"
    a, b = body.outline.vertices[2]
    return mujoco.mjtGeom.mjGEOM_BOX, [float(a), float(b), THICK]


# ---- random grids, bodies and poses --------------------------------------------------------------


def random_grid(rng: np.random.Generator) -> Scene:
    """Six times six wheels, pitch one, rims anywhere, speeds 0.3 to 1, one friction for all."""
    side = Fraction(int(rng.integers(2, 11)), 20)
    wheels = []
    for k in range(GRID * GRID):
        at = k % GRID - Fraction(GRID - 1, 2), k // GRID - Fraction(GRID - 1, 2)
        angle = rng.uniform(0, 2 * np.pi)
        way = Fraction(round(100 * np.cos(angle)), 100), Fraction(round(100 * np.sin(angle)), 100)
        wheels.append(WheelData(at, way, Fraction(int(rng.integers(30, 101)), 100)))
    return Arrays().scene(wheels, (1, side))


def inward_grid(side: Fraction) -> Scene:
    """Six times six wheels whose rims point to the middle."""
    return replace(Arrays().grid(GRID, GRID, (1, side)), contact=Contact("ellipse"))


def with_random_body(scene: Scene, rng: np.random.Generator, reach: float) -> Scene:
    """A rectangle or a disc of 4 to 9 wheels at a random pose, its centre of mass a little beside its middle."""
    field = scene.field
    x, y = (field(Fraction(round(1000 * entry), 1000)) for entry in rng.uniform(-reach, reach, 2))
    across, along = (field(Fraction(int(k), 20)) for k in rng.integers(-4, 5, 2))
    c, s = Arrays().circle_point(Fraction(int(rng.integers(-30, 31)), 20))
    centre, heading = (across, along), (field(c), field(s))
    if rng.random() < 0.5:
        body = Body(Disc(field(Fraction(int(rng.integers(120, 171)), 100))), centre, heading)
    else:
        a, b = (field(Fraction(int(k), 100)) for k in rng.integers(100, 161, 2))
        body = Body(rectangle(a, b), centre, heading)
    return replace(scene, body=body, contact=Contact("ellipse"), check=replace(scene.check, equilibrium=(x, y)))


def ellipse() -> SmoothRule:
    """The rule that the engine's cones are."""
    rule = contact_rule("ellipse")
    assert isinstance(rule, SmoothRule)
    return rule


# ---- what the engine says beside what the product says -------------------------------------------


@dataclass(frozen=True)
class Pose:
    """A body at one pose: whether it falls, and how far the twist and the loads are off.

    Attributes:
        tips, fell: in the product, and in the engine.
        margin: distance of the nearest wheel from the edge.
        twist_error: relative to the largest entry of the engine's twist.
        load_error: share of the weight, over all wheels of the grid.
    """

    tips: bool
    fell: bool
    margin: float = 0.0
    twist_error: float = 0.0
    load_error: float = 0.0


def pose_beside_engine(seed: int, reach: float = 1.7) -> Pose:
    """A random body on a random grid, its centre of mass up to ``reach`` from the middle along x and y."""
    rng = np.random.default_rng(seed)
    scene = with_random_body(random_grid(rng), rng, reach)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    plate = plate_engine(scene, (x, y, 0.0), SLOW)
    plate.step(SETTLING)
    try:
        stands = standing(scene)
    except TipsError:
        plate.step(FALLING)
        return Pose(tips=True, fell=plate.has_fallen)
    minima = minima_under(ellipse(), stands, plate.pose[None, :2])
    twist, loads = plate.twist, plate.loads()
    expected = np.zeros(len(loads))
    expected[[wheel.index - 1 for wheel in stands.wheels]] = minima.loads[0]
    error = np.abs(SLOW * minima.twists[0] - twist).max() / np.abs(twist).max()
    margin = contact_set(stands).margin
    assert margin is not None
    return Pose(False, plate.has_fallen, float(margin), float(error), float(np.abs(loads - expected).max()))


def lifted_loads(seed: int, speed: float, time_constant: float) -> tuple[Floats, Floats, Floats]:
    """Loads of the wheels under a random body in the engine, of equal springs, and of springs that slip lifts.

    A lift of the spring of wheel i by the share ``4 u/(g T) |w_i|`` of the weight, w_i its slip weighted by friction,
    at wheels of speed one; balance takes away what a plane through the wheels can follow.
    """
    rng = np.random.default_rng(seed)
    scene = with_random_body(random_grid(rng), rng, 1.2)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    plate = plate_engine(scene, (x, y, 0.0), speed, timestep=time_constant / 4, time_constant=time_constant)
    plate.step(1.0)
    carrying = sorted(under(scene, plate.pose))
    model = contacts_under(ellipse(), replace(scene, wheels=tuple(scene.wheels[k] for k in carrying)))
    springs = elastic_loads(model, plate.pose[None, :2])[0]
    slips = model.friction.reshape(-1, 2) * model.slips(plate.twist / speed)
    planes = np.column_stack([np.ones(len(carrying)), model.positions])
    lifts = 4 * speed / (GRAVITY * time_constant) * np.hypot(*slips.T)
    return plate.loads()[carrying], springs, springs + lifts - planes @ np.linalg.lstsq(planes, lifts, rcond=None)[0]


Change: TypeAlias = tuple[int, bool, float]  # wheel, whether it enters, time (of wheels of speed one)


@dataclass(frozen=True)
class Run:
    """A path beside the engine's.

    Attributes:
        path: of the product, from the engine's pose after it has settled.
        changes: wheels that enter and leave in the engine.
        fell: when the plate lay aslant; None where it never did.
        error: largest difference of poses (lengths, radians).
        last: the engine's last pose.
    """

    path: Trajectory
    changes: list[Change]
    fell: float | None
    error: float
    last: Floats

    @property
    def tips_alike(self) -> bool:
        """Whether the plate falls iff the path says so."""
        return (self.fell is not None) == (self.path.end.reason is EndReason.TIPS)

    def changes_alike(self, late: float) -> bool:
        """Whether the same wheels enter and leave in the same order, each time to within ``late``."""
        expected = [change for change in predicted_changes(self.path) if change[2] < self.path.end.t - late]
        found = [change for change in self.changes if change[2] < self.path.end.t][: len(expected)]
        pairs = list(zip(sorted(expected), sorted(found), strict=False))
        alike = all(a[:2] == b[:2] and abs(a[2] - b[2]) < late for a, b in pairs)
        return alike and len(found) == len(expected)


def predicted_changes(path: Trajectory) -> list[Change]:
    """Wheels that enter and leave, one by one; slides are no changes."""
    changes = []
    for event in path.events:
        if event.kind in (EventKind.ENTER, EventKind.LEAVE):
            names = event.surface.removeprefix("wheel ").split(" under")[0].split(" beside")[0]
            changes += [(int(name) - 1, event.kind is EventKind.ENTER, float(event.t)) for name in names.split(", ")]
    return changes


def run_beside_engine(scene: Scene, until: float) -> Run:
    """The body of a scene from its checked pose, in the engine and in the product."""
    x, y = (float(entry) for entry in scene.check.equilibrium)
    plate = plate_engine(scene, (x, y, 0.0), BRISK, timestep=TIMESTEP, time_constant=TIME_CONSTANT)
    plate.step(1.0)
    path = BodyPath(contacts_under(ellipse(), scene), scene).follow(plate.pose.tolist(), until)
    before, changes, error, fell, time = under(scene, plate.pose), list[Change](), 0.0, None, 0.0
    while time < until and fell is None:
        plate.step(SAMPLE)
        time += SAMPLE * BRISK
        if plate.has_fallen:
            fell = time
            break
        now = under(scene, plate.pose)
        changes += [(wheel, wheel in now, time) for wheel in sorted(now ^ before)]
        before = now
        if time <= path.end.t:
            error = max(error, float(np.abs(plate.pose - path.at(time)).max()))
    return Run(path, changes, fell, error, plate.pose)


def under(scene: Scene, pose: Floats) -> frozenset[int]:
    """The wheels under the body, by complex numbers turned into its own frame."""
    body = scene.body
    assert body is not None
    heading = complex(*map(float, body.heading)) * np.exp(1j * pose[2])
    places = np.array([complex(*map(float, wheel.position)) for wheel in scene.wheels])
    seen = (places - complex(*pose[:2])) / heading - complex(*map(float, body.centre))
    if isinstance(body.outline, Disc):
        inside = np.abs(seen) < float(body.outline.radius)
    else:
        a, b = (float(entry) for entry in body.outline.vertices[2])
        inside = (np.abs(seen.real) < a) & (np.abs(seen.imag) < b)
    return frozenset(int(k) for k in np.flatnonzero(inside))
