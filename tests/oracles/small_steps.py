"""Bodies with an outline in small Euler steps: at each, the words of a rule for the wheels under the body just then.

Knows nothing of cells, of faces and of events.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, pose_rate
from tests.outlined import Depths, under


def small_steps(scene: Scene, depths: Depths, start: Floats, until: float, steps: int) -> Floats:
    """The last pose, by Euler steps under the rule of the scene."""
    contacts, pose = Contacts.of(scene), np.array(start, float)
    rule = {"nearest": contacts.nearest, "box": contacts.box}[scene.contact.rule]
    for _ in range(steps):
        twist = rule(sorted(under(depths(contacts.positions, pose))), pose[:2])
        pose = pose + until / steps * pose_rate(twist, pose[:2])
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
        rows, targets = contacts._replace(positions=contacts.positions - pose[:2]).rows(carrying)
        grip = contacts.friction[carrying]
        pull = grip**2 * (rows @ velocity - targets).reshape(-1, 2)
        slips = (rows @ velocity - targets).reshape(-1, 2)
        size = np.sqrt((pull * slips).sum(axis=1) + (grip.max(axis=1) * creep) ** 2)
        forces = -(np.array(list(loads.values())) / size)[:, None] * pull
        velocity = velocity + step * inverse * (rows.T @ forces.ravel())
        pose = pose + step * velocity
    return np.concatenate([pose, velocity])
