"""A body in space on wheels with springs and dampers under it: nothing is said of how its weight is shared out.

The centre of mass moves in x, y and z, and the body turns about all three axes, little about the level ones.  Each
wheel pushes up as hard as its spring is pressed, and rubs against the point of the body over it, h below the centre of
mass.  Where springs are stiff and damped the body stays level, and what they push tells how the weight is shared out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from tests.oracles.heavy_bodies import Floats


@dataclass(frozen=True)
class SprungBody:
    """A body per unit of weight, on equal springs.

    Attributes:
        places: of the wheels (n, 2).
        rims: unit vectors (n, 2).
        speeds: of the surfaces (n,).
        friction: along and across the rim (n, 2).
        mass: 1/g.
        inertia: about the vertical axis; about the level ones it is the same.
        height: h.
        stiffness: of each spring, as a share of the weight by length.
        creep: slip over which forces are rounded.
    """

    places: Floats
    rims: Floats
    speeds: Floats
    friction: Floats
    mass: float
    inertia: float
    height: float
    stiffness: float
    creep: float

    def rate(self, t: float, state: Floats) -> Floats:
        """Of ``(x, y, z, alpha, beta, theta)`` and their rates, (12,); z from the height h of free springs."""
        place, speed = state[:6], state[6:]
        a = self.places - place[:2]
        up = place[2] + place[3] * a[:, 1] - place[4] * a[:, 0]
        rising = speed[2] + speed[3] * a[:, 1] - speed[4] * a[:, 0]
        damper = 2 * np.sqrt(self.stiffness * self.mass / len(a))
        pushes = np.maximum(-self.stiffness * up - damper * rising, 0.0)
        points = speed[:2] + speed[5] * np.column_stack([-a[:, 1], a[:, 0]])
        points = points + self.height * np.array([-speed[4], speed[3]])  # r = (a, -h)
        sides = np.column_stack([-self.rims[:, 1], self.rims[:, 0]])
        r, s = (points * self.rims).sum(axis=1) - self.speeds, (points * sides).sum(axis=1)
        along, across = self.friction.T
        root = np.sqrt((along * r) ** 2 + (across * s) ** 2 + (self.friction.max(axis=1) * self.creep) ** 2)
        forces = -(pushes / root)[:, None] * ((along**2 * r)[:, None] * self.rims + (across**2 * s)[:, None] * sides)
        tilts = np.array(
            [
                (a[:, 1] * pushes + self.height * forces[:, 1]).sum(),
                (-self.height * forces[:, 0] - a[:, 0] * pushes).sum(),
                (a[:, 0] * forces[:, 1] - a[:, 1] * forces[:, 0]).sum(),
            ]
        )
        lift = (pushes.sum() - 1) / self.mass
        return np.concatenate([speed, forces.sum(axis=0) / self.mass, [lift], tilts / self.inertia])

    def level(self, centre: Floats) -> Floats:
        """The state at rest over a place where all springs are pressed, theta = 0."""
        rows = np.column_stack([np.ones(len(self.places)), self.places - centre])
        lift, by_x, by_y = np.linalg.solve(rows.T @ rows, np.array([-1.0, 0.0, 0.0])) / self.stiffness
        return np.array([*centre, lift, by_y, -by_x, *[0.0] * 7])

    def follow(self, centre: Floats, times: Floats) -> Floats:
        """``(x, y, theta)`` at times (k,), from rest."""
        found = solve_ivp(
            self.rate, (0, times[-1]), self.level(centre), "BDF", times, rtol=1e-7, atol=1e-11, dense_output=False
        )
        return np.asarray(found.y[[0, 1, 5]].T)
