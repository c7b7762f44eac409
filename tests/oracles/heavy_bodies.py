"""Bodies with inertia in a few lines: on wheels in the plane, and in space on springs and dampers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.oracles.floats import Floats

# ---- Bodies with inertia by Newton's law in a few lines, with fixed steps: shares nothing with the product.
#
# Loads are those of equal springs that only push: least squares on the wheels that carry, those that would pull left
# out. Forces are on the friction ellipse, against its gradient, rounded where slips are some per cent of the speed of
# the wheels; under rule roller they are cut at the bearings' friction. Many bodies are followed at once, in any
# units.


ROUNDED = 0.03  # slips beside the largest speed of a wheel below which forces are less than they may be
STIFF = 1.0  # of the time in which the fastest slip decays where a turn adds as much again: a step


@dataclass(frozen=True)
class HeavyTable:
    """A table of omniwheels or rubber wheels, and how heavy its body is.

    Attributes:
        places: of the wheels (n, 2).
        headings: of the rims (n,), radian.
        speeds: of the surfaces (n,).
        friction: along and across the rim (n, 2).
        gravity: g.
        squared_radius: I/m.
        bearings: forces across the rim are cut there, as a share of the load (n,); None under rule ellipse.
    """

    places: Floats
    headings: Floats
    speeds: Floats
    friction: Floats
    gravity: float
    squared_radius: float
    bearings: Floats | None = None
    rounded: float = ROUNDED

    def exactly(self) -> HeavyTable:
        """Without rounding: for derivatives where every wheel slips."""
        return replace(self, rounded=0.0)

    @cached_property
    def sides(self) -> tuple[Floats, Floats]:
        """Unit vectors along each rim and across it, (n, 2)."""
        along = np.column_stack([np.cos(self.headings), np.sin(self.headings)])
        return along, np.column_stack([-along[:, 1], along[:, 0]])

    @cached_property
    def moments(self) -> tuple[Floats, float, Floats]:
        """Rows ``(1, x, y)`` of the wheels in a unit of length (n, 3), the unit, and loads of all by (1, x, y).

        The loads are not numbers where all wheels are on one line.
        """
        size = float(np.abs(self.places).max())
        rows = np.column_stack([np.ones(len(self.places)), self.places / size])
        fails = np.abs(np.linalg.det(rows.T @ rows)) < 1e-9
        return rows, size, np.full(rows.shape, np.nan) if fails else np.linalg.pinv(rows.T)

    def loads(self, centres: Floats) -> Floats:
        """Shares of the weight (m, n) at centres of mass (m, 2); nan where fewer than three wheels would carry."""
        rows, size, of_all = self.moments
        goal = np.column_stack([np.ones(len(centres)), centres / size])
        loads = goal @ of_all.T
        if (loads >= 0).all():
            return np.asarray(loads)
        carries = np.ones((len(centres), len(rows)), bool)
        for _ in range(len(rows)):
            normal = np.einsum("mn,ni,nj->mij", carries.astype(float), rows, rows)
            fails = (carries.sum(axis=1) < 3) | (np.abs(np.linalg.det(normal)) < 1e-9)
            normal[fails] = np.eye(3)
            loads = carries * (np.linalg.solve(normal, goal[..., None])[..., 0] @ rows.T)
            loads[fails] = np.nan
            pulls = loads < 0
            if not pulls.any():
                break
            carries &= ~pulls
        return loads

    def rate(self, states: Floats) -> Floats:
        """Time derivatives of states ``(x, y, theta, w_x, w_y, omega)``, (m, 6)."""
        along, across = self.sides
        arms = self.places - states[:, None, :2]
        points = states[:, None, 3:5] + states[:, None, 5:] * np.stack([-arms[..., 1], arms[..., 0]], axis=2)
        r = (points * along).sum(axis=2) - self.speeds
        s = (points * across).sum(axis=2)
        mu, most = self.friction, self.friction.max(axis=1) * self.rounded * np.abs(self.speeds).max()
        if self.bearings is None:
            root = np.sqrt((mu[:, 0] * r) ** 2 + (mu[:, 1] * s) ** 2 + most**2)
            pull, push = -(mu[:, 0] ** 2) * r / root, -(mu[:, 1] ** 2) * s / root
        else:  # the disc of mu_roll, its rollers turn where it would be cut
            root = np.sqrt((mu[:, 0] * r) ** 2 + (mu[:, 0] * s) ** 2 + most**2)
            pull, push = -(mu[:, 0] ** 2) * r / root, -(mu[:, 0] ** 2) * s / root
            turns = np.abs(push) > self.bearings
            rest = np.sqrt(mu[:, 0] ** 2 - self.bearings**2)
            pull = np.where(turns, -rest * r / np.sqrt(r**2 + (most / mu[:, 0]) ** 2), pull)
            push = np.where(turns, np.sign(push) * self.bearings, push)
        loads = self.gravity * self.loads(states[:, :2])
        forces = loads[..., None] * (pull[..., None] * along + push[..., None] * across)
        torque = (arms[..., 0] * forces[..., 1] - arms[..., 1] * forces[..., 0]).sum(axis=1)
        return np.column_stack([states[:, 3:], forces.sum(axis=1), torque / self.squared_radius])

    @property
    def step(self) -> float:
        """Of time: a share of that in which the fastest slip decays."""
        return STIFF * self.rounded * float(np.abs(self.speeds).max()) / (self.gravity * float(self.friction.max()))

    def follow(self, starts: Floats, until: float, looks: int = 2000) -> tuple[Floats, Floats]:
        """Times (k,) and states (k, m, 6) from rest at ``(x, y, theta)`` (m, 3): the classical Runge-Kutta method."""
        states = np.column_stack([starts, np.zeros((len(starts), 3))])
        count = int(np.ceil(until / self.step))
        every, h = max(1, count // looks), until / count
        times, seen = [0.0], [states]
        for k in range(count):
            a = self.rate(states)
            b = self.rate(states + h / 2 * a)
            c = self.rate(states + h / 2 * b)
            d = self.rate(states + h * c)
            states = states + h / 6 * (a + 2 * b + 2 * c + d)
            if (k + 1) % every == 0:
                times.append((k + 1) * h)
                seen.append(states)
        return np.array(times), np.array(seen)


def eigenvalues_by_differences(table: HeavyTable, state: Floats) -> NDArray[np.complex128]:
    """Of the rates by the five entries without theta, by central differences about a state (6,)."""
    size, speed = np.abs(table.places).max(), np.abs(table.speeds).max()
    steps = 1e-5 * np.array([size, size, 1.0, speed, speed, speed / size])
    columns = []
    for k in (0, 1, 3, 4, 5):
        off = np.zeros(6)
        off[k] = steps[k]
        ahead, behind = table.rate(np.array([state + off, state - off]))
        columns.append((ahead - behind)[[0, 1, 3, 4, 5]] / (2 * steps[k]))
    return np.asarray(np.linalg.eigvals(np.column_stack(columns)))


# ---- A body in space on wheels with springs and dampers under it: nothing is said of how its weight is shared out.
#
# The centre of mass moves in x, y and z, and the body turns about all three axes, little about the level ones. Each
# wheel pushes up as hard as its spring is pressed, and rubs against the point of the body over it, h below the centre
# of mass. Where springs are stiff and damped the body stays level, and what they push tells how the weight is shared
# out.


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
