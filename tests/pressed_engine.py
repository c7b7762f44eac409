"""A body on a table of driven wheels at any speed in MuJoCo, with wheels that are pressed against it.

Laid onto wheels under gravity (:mod:`tests.body_engine`), a contact that slips lifts its own spring: the engine's loads
are off by ``4 u/(g T)`` of the weight at wheels of speed u and a time constant T of the contacts.  At 250 mm/s that is
more than the weight itself, and no T cures it: springs soft enough sink by a length of the table.  So here every wheel
is a small sphere on a piston that pushes upward with the load of its wheel, those of equal springs that
:meth:`tests.oracles.heavy_bodies.HeavyTable.loads` finds, and the body is a plate that moves in the plane.  However far
slip lifts a contact, the piston follows, and the contact carries what presses it.  The friction cones, which wheels
stick, and Newton's law are the engine's; only the loads are told.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from tests.body_engine import PlateEngine
from tests.oracles.floats import Floats
from tests.oracles.heavy_bodies import HeavyTable

METRE = 1000.0  # of the table's millimetres
HALF, THICK = 3.0, 0.02  # half sides of the plate: it covers all wheels from everywhere
RADIUS = 0.01  # of the spheres
PISTON = 1e-3  # mass of a piston beside that of the body
TIMESTEP = 5e-4
TIME_CONSTANT = 2e-3
EVERY = 4  # steps between two looks; loads are told at every step, for a delay would feed swings


@dataclass
class PressedPlate(PlateEngine):
    """A plate that moves in the plane, with the joints ``x``, ``y`` and ``theta`` last."""

    turned: tuple[Floats, Floats] | None = None  # frames and surface velocities of all contacts: they stay as they are

    def _turn_frames(self) -> None:
        contacts = self.data.contact
        if len(contacts) < len(self.rims):  # a wheel without a load
            super()._turn_frames()
        elif self.turned is None:
            super()._turn_frames()
            self.turned = contacts.frame.copy(), contacts.surfacevel.copy()
        else:
            contacts.frame[:], contacts.surfacevel[:] = self.turned

    @property
    def pose(self) -> Floats:
        return np.asarray(self.data.qpos[-3:], np.float64)

    def press(self, loads: Floats) -> None:
        """Let the pistons push with these forces."""
        self.data.qfrc_applied[: len(loads)] = loads


@dataclass(frozen=True)
class EngineTable:
    """A :class:`HeavyTable` in the engine, followed in the same way.

    Attributes:
        table: in millimetres, rule ellipse.
        mass: of the body (kg).
        timestep: of the engine (s).
    """

    table: HeavyTable
    mass: float = 2.0
    timestep: float = TIMESTEP

    def plate(self, start: Floats) -> PressedPlate:
        """The plate at rest at ``(x, y, theta)``."""
        table = self.table
        rims = np.column_stack([np.cos(table.headings), np.sin(table.headings), np.zeros(len(table.places))])
        spec = mujoco.MjSpec()
        spec.option.timestep, spec.option.gravity = self.timestep, [0, 0, 0]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = 1e5  # no creep of friction
        spec.option.iterations, spec.option.tolerance = 200, 1e-14
        velocities = rims * (table.speeds / METRE)[:, None]
        for k, place in enumerate(table.places / METRE):
            piston = spec.worldbody.add_body(name=f"piston {k}", pos=[*place, -RADIUS])
            piston.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
            piston.add_geom(
                name=f"wheel {k}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[RADIUS, 0, 0],
                mass=PISTON * self.mass,
                surfacevel=[*velocities[k], 0, 0, 0],
            )
        plate = spec.worldbody.add_body(name="plate", pos=[0, 0, THICK])
        for axis in ([1, 0, 0], [0, 1, 0]):
            plate.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        plate.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        inertia = self.mass * table.squared_radius / METRE**2
        plate.explicitinertial, plate.mass, plate.inertia = True, self.mass, [inertia, inertia, inertia]
        plate.ipos, plate.iquat = [0, 0, 0], [1, 0, 0, 0]
        box = mujoco.mjtGeom.mjGEOM_BOX
        plate.add_geom(name="plate", type=box, size=[HALF, HALF, THICK], contype=0, conaffinity=0)
        for k, friction in enumerate(table.friction):
            spec.add_pair(
                geomname1="plate",
                geomname2=f"wheel {k}",
                condim=3,
                friction=[*friction, 0, 0, 0],
                solref=[TIME_CONSTANT, 1],
                solimp=[0.5, 0.5, 1, 0.5, 2],
            )
        model = spec.compile()
        engine = PressedPlate(model, mujoco.MjData(model), rims, table.friction, velocities)
        engine.data.qpos[-3:] = start[0] / METRE, start[1] / METRE, start[2]
        return engine

    def follow(self, starts: Floats, until: float) -> tuple[Floats, Floats]:
        """Times (k,) and poses (k, m, 3) in millimetres from rest at ``(x, y, theta)`` (m, 3); nan once thrown off."""
        count = int(np.ceil(until / (EVERY * self.timestep)))
        times = np.asarray(EVERY * self.timestep * np.arange(count + 1), np.float64)
        return times, np.stack([self._path(start, count) for start in starts], axis=1)

    def _path(self, start: Floats, count: int) -> Floats:
        engine, scale = self.plate(start), self.mass * self.table.gravity / METRE
        poses = np.full((count + 1, 3), np.nan)
        poses[0] = start
        for k in range(count):
            for _ in range(EVERY):
                loads = self._loads(engine.pose[:2] * METRE)
                if np.isnan(loads).any():
                    return poses
                engine.press(scale * loads)
                engine.step(self.timestep)
            poses[k + 1] = engine.pose * (METRE, METRE, 1.0)
        return poses

    @cached_property
    def _planes(self) -> Floats:
        """The matrix (n, 3) that takes ``(1, x, y)`` of the centre of mass to the loads while all wheels carry."""
        rows = np.column_stack([np.ones(len(self.table.places)), self.table.places])
        return np.asarray(np.linalg.solve(rows.T @ rows, rows.T).T)

    def _loads(self, centre: Floats) -> Floats:
        loads: Floats = self._planes @ (1.0, *centre)
        return loads if loads.min() >= 0 else self.table.loads(centre[None])[0]
