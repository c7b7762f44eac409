"""Wheels with real rollers in MuJoCo, a rigid-body physics engine that knows nothing of rule ``roller``.

A wheel is a sphere on a hinge along its rim, as a roller on its bearing: it turns freely across the rim, and its
surface moves along the rim with the speed of the wheel (``surfacevel``, a velocity that contacts see).  The contact
has one friction mu_R in all directions, the bearing a friction torque (``frictionloss``) of ``mu_S N`` times its
radius, with the load N that springs carry.  The body is a thin square plate with a free joint in space, under gravity,
on soft contacts, as in ``test_engine``.  What the engine has and the model has not: inertia of the rollers,
springs that tilt the plate, loads that move with slip, a bearing that creeps (``armature`` and ``solimp`` keep that
below a thousandth of the slips).  Mecanum wheels have the hinge along their friction axis, askew to the rim.  A wheel
with ``mu_S = mu_R`` has no hinge: it is of rubber.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import mujoco
import numpy as np

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.reports.interface.array import Array, Wheel
from nonsmooth.symbolic.numbers.plane_arrays import Floats

GRAVITY = 9.81
HALF, THICK = 3.0, 0.02  # half sides of the plate: it covers all wheels from everywhere
RADIUS = 0.05  # of the rollers
ARMATURE = 1e-2  # inertia of a roller: large, so that its bearing is hard; it plays no part in steady motion
SPEED = 3e-5  # lengths per second: slow, because slip moves the loads of the engine (``test_engine``)
SETTLING = 1.0  # seconds
MIXED_SPEED = 2e-4  # where the engine's own loads are asked for: a faster slip makes the creep of what is held small
BRAKES = 3  # times that bearings are braked by the loads that the engine then has
LEAST_LOAD = 0.05  # share of the weight, of every wheel of a random array


class RollerPlate(NamedTuple):
    """A plate on wheels with rollers."""

    model: mujoco.MjModel
    data: mujoco.MjData

    def step(self, seconds: float) -> None:
        for _ in range(round(seconds / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)

    def brake(self, wheels: ContactModel) -> None:
        """Let bearings resist with mu_S of the loads that the contacts carry, in place of those at rest."""
        for k, load in enumerate(GRAVITY * self.loads):
            if wheels.mu_side[k] < wheels.mu_roll[k]:
                (bearing,) = self.model.body(f"roller {k}").dofadr
                self.model.dof_frictionloss[bearing] = wheels.mu_side[k] * load * RADIUS

    @property
    def centre(self) -> Floats:
        """``(x, y)``; the plate's joint is the last one."""
        return np.array(self.data.qpos[-7:-5])

    @property
    def twist(self) -> Floats:
        """Spatial twist ``(v, omega)``."""
        (x, y), (wx, wy), omega = self.centre, self.data.qvel[-6:-4], self.data.qvel[-1]
        return np.array([wx + omega * y, wy - omega * x, omega])

    @property
    def loads(self) -> Floats:
        """Shares of the weight by wheel, as the contacts carry them."""
        forces = np.zeros(self.model.npair)
        for k in range(self.data.ncon):
            force, wheel = np.zeros(6), self.model.geom(int(min(self.data.contact[k].geom))).name
            mujoco.mj_contactForce(self.model, self.data, k, force)
            forces[int(wheel.removeprefix("wheel "))] = force[0]
        return np.asarray(forces / forces.sum())


def roller_plate(wheels: ContactModel, start: Floats) -> RollerPlate:
    """The plate laid onto the wheels: friction mu_R of the contacts, mu_S of the bearings."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 1e-3, [0, 0, -GRAVITY]
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 1e7
    spec.option.iterations, spec.option.tolerance = 200, 1e-14
    loads = GRAVITY * loads_at(wheels, start[None])[0]
    for k, (position, rim) in enumerate(zip(wheels.positions, wheels.rims, strict=True)):
        roller = spec.worldbody.add_body(name=f"roller {k}", pos=[*position, -RADIUS])
        if wheels.mu_side[k] < wheels.mu_roll[k]:
            roller.add_joint(
                type=mujoco.mjtJoint.mjJNT_HINGE,
                axis=[*wheels.axes[k], 0],
                armature=ARMATURE,
                frictionloss=wheels.mu_side[k] * loads[k] * RADIUS,
                solref_friction=[2e-3, 1],
                solimp_friction=[0.9999, 0.9999, 1, 0.5, 2],
            )
        roller.add_geom(
            name=f"wheel {k}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[RADIUS, 0, 0],
            mass=1e-3,
            contype=0,
            conaffinity=0,
            surfacevel=[*(wheels.speeds[k] * rim), 0, 0, 0, 0],
        )
    plate = spec.worldbody.add_body(name="plate", pos=[*start, THICK])
    plate.add_freejoint()
    box = mujoco.mjtGeom.mjGEOM_BOX
    plate.add_geom(name="plate", type=box, size=[HALF, HALF, THICK], mass=1.0, contype=0, conaffinity=0)
    for k in range(wheels.wheels):
        spec.add_pair(
            geomname1="plate",
            geomname2=f"wheel {k}",
            condim=3,
            friction=[wheels.mu_roll[k], wheels.mu_roll[k], 0, 0, 0],
            solref=[0.01, 1],
            solimp=[0.5, 0.5, 1, 0.5, 2],
        )
    model = spec.compile()
    return RollerPlate(model, mujoco.MjData(model))


def settled_twist(wheels: ContactModel, start: Floats) -> tuple[Floats, Floats]:
    """Twist and centre after the springs have settled."""
    plate = roller_plate(wheels, start)
    plate.step(SETTLING)
    return plate.twist, plate.centre


def random_array(seed: int, *, askew: bool = False, speed: float = SPEED) -> tuple[ContactModel, Floats]:
    """Four to six wheels with rims in all directions, bearing friction of 0.02 to 0.5, and a place for the body.

    With ``askew`` their rollers stand in all directions too.
    """
    rng = np.random.default_rng(seed)
    count, side = int(rng.integers(4, 7)), float(np.exp(rng.uniform(np.log(0.02), np.log(0.5))))
    while True:
        positions, angles = rng.uniform(-1.5, 1.5, (count, 2)), rng.uniform(0, 2 * np.pi, count)
        start = rng.dirichlet(np.full(count, 3.0)) @ positions
        speeds = speed * rng.uniform(0.3, 1.0, count)
        rims = np.column_stack([np.cos(angles), np.sin(angles)])
        turns = rng.uniform(0, np.pi, count) if askew else None
        axes = None if turns is None else list(np.column_stack([np.cos(turns), np.sin(turns)]))
        wheels = ContactModel.build(positions, rims, speeds, (1.0, side), axes=axes)
        if loads_at(wheels, start[None]).min() > LEAST_LOAD:
            return wheels, start


def rubber_beside_rollers(seed: int) -> tuple[ContactModel, Floats]:
    """A random array in which every other wheel is of rubber, that grips alike in all directions."""
    wheels, start = random_array(seed, speed=MIXED_SPEED)
    friction = wheels.friction.reshape(-1, 2).copy()
    friction[::2, 1] = friction[::2, 0]
    return replace(wheels, friction=friction.reshape(-1)), start


def with_rollers(wheels: ContactModel) -> ContactModel:
    """The friction sets of rule ``roller``, for mu_S < mu_R."""
    discs = np.repeat(wheels.mu_roll, 2)
    return replace(wheels, friction=discs, cuts=wheels.mu_side / wheels.mu_roll)


def relative_errors(wheels: ContactModel, start: Floats) -> Floats:
    """Of the twists of the rules ``roller``, ``ellipse`` and ``box``, relative to the engine's largest entry."""
    twist, centre = settled_twist(wheels, start)
    loads = loads_at(wheels, centre[None])
    models = (EllipseMinimizer(), with_rollers(wheels)), (EllipseMinimizer(), wheels), (BoxHighs(), wheels)
    errors = [np.abs(method.minimize(model, loads).twists[0] - twist).max() for method, model in models]
    return np.array(errors) / np.abs(twist).max()


def mixed_errors(seed: int) -> Floats:
    """Of the twists of the rules ``mixed`` and ``ellipse`` where every other wheel is of rubber, by the engine's loads.

    Relative to the engine's largest entry, for scenes that are made as users make them.
    """
    wheels, start = rubber_beside_rollers(seed)
    plate = roller_plate(wheels, start)
    plate.step(SETTLING)
    for _ in range(BRAKES):
        plate.brake(wheels)
        plate.step(SETTLING)
    texts = [list(map(repr, row.tolist())) for row in np.column_stack([wheels.positions, wheels.rims, wheels.speeds])]
    made = Array(
        Wheel((x, y), heading=(a, b), speed=u, mu_roll=1, mu_side=repr(side), contact=("ellipse", "roller")[k % 2])
        for k, ((x, y, a, b, u), side) in enumerate(zip(texts, wheels.mu_side.tolist(), strict=True))
    )
    models = [contacts_under(smooth_rule_of(scene), scene) for scene in (made.scene, made.scene.under("ellipse"))]
    twists = [EllipseMinimizer().minimize(model, plate.loads).twists[0] for model in models]
    return np.array([np.abs(twist - plate.twist).max() for twist in twists]) / np.abs(plate.twist).max()


def creep_rates(side: float) -> Floats:
    """``-v/(u c)`` in the engine near the middle of four wheels at (1, 1) and so on, with inward rims."""
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1.0)])
    wheels = ContactModel.build(corners, -corners, np.full(4, SPEED), (1.0, side))
    twist, centre = settled_twist(wheels, np.array([4e-3, 2e-3]))
    return np.asarray(-twist[:2] / (SPEED * centre))
