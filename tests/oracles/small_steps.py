"""Bodies with an outline in small Euler steps: at each, the words of a rule for the wheels under the body just then.

Knows nothing of cells, of faces and of events; loads and outline are written anew.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.outlined import Depths, under


class Contacts(NamedTuple):
    """The wheels of an array in floats."""

    positions: Floats
    rims: Floats
    speeds: Floats
    friction: Floats

    @classmethod
    def of(cls, scene: Scene) -> Contacts:
        positions = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
        rims = np.array([[float(x) for x in wheel.unit_direction] for wheel in scene.wheels])
        speeds = np.array([float(wheel.speed) for wheel in scene.wheels])
        friction = [[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels]
        return cls(positions, rims, speeds, np.array(friction))

    def rows(self, wheels: list[int]) -> tuple[Floats, Floats]:
        """Rows on ``(v, omega)`` along the rim and across it, wheel by wheel, and what they are to be."""
        rows, targets = [], []
        for k in wheels:
            along, (x, y) = self.rims[k], self.positions[k]
            for way, speed in ((along, self.speeds[k]), (np.array([-along[1], along[0]]), 0.0)):
                rows.append([*way, way[1] * x - way[0] * y])
                targets.append(speed)
        return np.array(rows), np.array(targets)

    def nearest(self, wheels: list[int], centre: Floats) -> Floats:
        """Both rows of the nearest wheel, and the row of more friction of the second."""
        order = sorted(wheels, key=lambda k: float(np.hypot(*(self.positions[k] - centre))))
        rows, targets = self.rows(order[:2])
        third = 2 if self.friction[order[1], 0] >= self.friction[order[1], 1] else 3
        chosen = [0, 1, third]
        return np.asarray(np.linalg.solve(rows[chosen], targets[chosen]), float)

    def loads(self, wheels: list[int], centre: Floats) -> dict[int, float]:
        """Springs of equal stiffness; those that pull are taken away one by one."""
        pressed = list(wheels)
        while True:
            moments = np.vstack([np.ones(len(pressed)), self.positions[pressed].T])
            forces, *_ = np.linalg.lstsq(moments, np.array([1.0, *centre]), rcond=None)
            if forces.min() >= 0:
                return dict(zip(pressed, forces.tolist(), strict=True))
            pressed.pop(int(np.argmin(forces)))

    def box(self, wheels: list[int], centre: Floats) -> Floats:
        """The least ``sum N (mu_R |r| + mu_S |s|)``, by a linear program."""
        loads = self.loads(wheels, centre)
        rows, targets = self.rows(list(loads))
        costs = (np.array(list(loads.values()))[:, None] * self.friction[list(loads)]).ravel()
        own = np.eye(len(costs))
        found = linprog(
            np.concatenate([np.zeros(3), costs]),
            A_ub=np.block([[rows, -own], [-rows, -own]]),
            b_ub=np.concatenate([targets, -targets]),
            bounds=[(None, None)] * 3 + [(0, None)] * len(costs),
            method="highs",
        )
        return np.asarray(found.x[:3])


def small_steps(scene: Scene, depths: Depths, start: Floats, until: float, steps: int) -> Floats:
    """The last pose, by Euler steps under the rule of the scene."""
    contacts, pose = Contacts.of(scene), np.array(start, float)
    rule = {"nearest": contacts.nearest, "box": contacts.box}[scene.contact.rule]
    for _ in range(steps):
        v_x, v_y, omega = rule(sorted(under(depths(contacts.positions, pose))), pose[:2])
        pose = pose + until / steps * np.array([v_x - omega * pose[1], v_y + omega * pose[0], omega])
    return pose


def small_steps_of_mass(
    scene: Scene, depths: Depths, start: Floats, until: float, steps: int, masses: tuple[float, float], creep: float
) -> Floats:
    """The last state ``(x, y, theta, w_x, w_y, omega)`` of a body with mass and inertia, from rest, by Euler steps.

    The force of a wheel is its load times the friction ellipse's, rounded below a creep speed; velocities first.
    """
    contacts, pose, velocity = Contacts.of(scene), np.array(start, float), np.zeros(3)
    inverse = 1 / np.array([masses[0], masses[0], masses[1]])
    step = until / steps
    for _ in range(steps):
        wheels = sorted(under(depths(contacts.positions, pose)))
        loads = contacts.loads(wheels, pose[:2])
        carrying = list(loads)
        rows, targets = Contacts(contacts.positions - pose[:2], contacts.rims, contacts.speeds, contacts.friction).rows(
            carrying
        )
        grip = contacts.friction[carrying]
        pull = grip**2 * (rows @ velocity - targets).reshape(-1, 2)
        slips = (rows @ velocity - targets).reshape(-1, 2)
        size = np.sqrt((pull * slips).sum(axis=1) + (grip.max(axis=1) * creep) ** 2)
        forces = -(np.array(list(loads.values())) / size)[:, None] * pull
        velocity = velocity + step * inverse * (rows.T @ forces.ravel())
        pose = pose + step * velocity
    return np.concatenate([pose, velocity])
