"""The wheels of an array in floats, twists by the words of the rules, and how twists move a body.

Knows nothing of cells; rows, loads and D are written anew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats, midpoint

Rate: TypeAlias = Callable[[Floats], Floats]

J = np.array([[0.0, -1.0], [1.0, 0.0]])
DEPENDENT = 1e-9  # rows whose least singular value is below this


def places_of(scene: Scene) -> Floats:
    """Positions of the wheels, one to a row."""
    return np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])


def rims_of(scene: Scene) -> Floats:
    """Unit directions of the wheels' rims, one to a row."""
    return np.array([[float(x) for x in wheel.unit_direction] for wheel in scene.wheels])


class Contacts(NamedTuple):
    """The wheels of an array in floats."""

    positions: Floats
    rims: Floats
    speeds: Floats
    friction: Floats

    @classmethod
    def of(cls, scene: Scene) -> Contacts:
        speeds = np.array([float(wheel.speed) for wheel in scene.wheels])
        friction = [[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels]
        return cls(places_of(scene), rims_of(scene), speeds, np.array(friction))

    def model(self, wheels: Sequence[int]) -> ContactModel:
        """What the product's minimizers take, of some of the wheels."""
        chosen = list(wheels)
        return ContactModel.build(self.positions[chosen], self.rims[chosen], self.speeds[chosen], self.friction[chosen])

    def row(self, wheel: int, way: Floats) -> Floats:
        """``way . (v + omega J p)`` as a row on ``(v, omega)``."""
        return np.array([*way, way @ (J @ self.positions[wheel])])

    def rows(self, wheels: list[int]) -> tuple[Floats, Floats]:
        """Rows on ``(v, omega)`` along the rim and across it, wheel by wheel, and what they are to be."""
        rows, targets = [], []
        for k in wheels:
            along = self.rims[k]
            for way, speed in ((along, self.speeds[k]), (J @ along, 0.0)):
                rows.append(self.row(k, way))
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


class TakenRow(NamedTuple):
    """A row that rule ``nearest`` takes: of which wheel, and whether along its rim."""

    wheel: int
    is_roll: bool
    row: Floats


class NearestRows:
    """What rule ``nearest`` takes by its words, kept for each order of distances."""

    def __init__(self, contacts: Contacts) -> None:
        self.contacts = contacts
        self._taken: dict[bytes, list[TakenRow]] = {}

    def at(self, c: Floats) -> list[TakenRow]:
        """Wheels by distance, of each the row of larger friction first, while independent, until three."""
        order = np.argsort(((self.contacts.positions - c) ** 2).sum(axis=1), kind="stable")
        key = order.tobytes()
        if key not in self._taken:
            self._taken[key] = self._greedy(order)
        return self._taken[key]

    def rate(self, c: Floats, rolls: Callable[[TakenRow], float]) -> Floats:
        """``(c', theta')`` where rims have these speeds; across a rim nothing moves."""
        taken = self.at(c)
        right = [rolls(own) if own.is_roll else 0.0 for own in taken]
        return pose_rate(np.linalg.solve(np.array([own.row for own in taken]), right), c)

    def _greedy(self, order: NDArray[np.intp]) -> list[TakenRow]:
        contacts = self.contacts
        taken: list[TakenRow] = []
        for wheel in order:
            roll = TakenRow(int(wheel), True, contacts.row(wheel, contacts.rims[wheel]))
            side = TakenRow(int(wheel), False, contacts.row(wheel, J @ contacts.rims[wheel]))
            roll_is_larger = contacts.friction[wheel, 0] > contacts.friction[wheel, 1]
            for own in (roll, side) if roll_is_larger else (side, roll):
                held = np.array([*(other.row for other in taken), own.row])
                if len(taken) < 3 and np.linalg.svd(held, compute_uv=False)[-1] > DEPENDENT:
                    taken.append(own)
        return taken


def pose_rate(twist: Floats, c: Floats) -> Floats:
    """``(c', theta')`` of a body with its centre of mass at c."""
    return np.array([*(twist[:2] + twist[2] * (J @ c)), twist[2]])


def followed(rate: Rate, pose: Floats, until: float, step: float) -> list[Floats]:
    """Explicit midpoint steps: across rays the path chatters within a step."""
    path = [pose]
    for _ in range(round(until / step)):
        path.append(midpoint(rate, path[-1], step))
    return path
