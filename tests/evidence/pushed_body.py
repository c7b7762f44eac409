"""A body that drags point contacts over the ground: the wrench that moves it, and the motion that a push causes.

The ground is at rest and contact i, with load N_i, is dragged over it with ``v(p_i)``: the array of wheels with the
contacts fixed to the body and all speeds zero.  Its dissipation is ``D(xi) = sum_i N_i |M v(p_i)|``, with M the
half-axes of a friction ellipse in the body's frame, the identity where friction is alike in all directions.

- From motion to wrench: minus the friction, ``w = sum_i N_i (M^T M v_i)/|M v_i|`` and its moment: the gradient of D.
- From wrench to motion: the xi of least D among those with ``w . xi = 1``.
- A pusher with a given velocity: a contact that may take any force.  The motion has the least D among those that move
  the pushed point as the pusher does (it sticks), or, where the force would leave the friction cone of the tip, among
  those that take the power 1 from a force along the cone's edge (it slides).  D grows in proportion to the motion, so
  that one is scaled to keep the contact.

Constraints are exact penalties: a contact with more grip than the force it needs does not slip.  So all three are
solved, and proved by their forces, by the minimizers of arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.symbolic.numbers.plane_arrays import Floats, turned

GRIP = 1e3  # of a constraint, in units of the largest wrench that it can need
CLEARANCE = 1e-9  # relative: a tip whose friction exceeds its cone by less sticks


@dataclass(frozen=True, eq=False)
class Contacts:
    """Point contacts of a body: points (n, 2) from its centre of mass, loads (n,) and M (2, 2)."""

    points: Floats
    loads: Floats
    shape: Floats

    @classmethod
    def isotropic(cls, points: Floats, loads: Floats) -> Contacts:
        """With one friction coefficient in all directions, which is the unit of forces."""
        return cls(points, loads, np.eye(2))

    def velocities(self, twists: Floats) -> Floats:
        """``v(p_i)`` for twists (m, 3), shape (m, n, 2)."""
        return np.asarray(twists[:, None, :2] + twists[:, None, 2:] * turned(self.points))

    def wrenches(self, twists: Floats) -> Floats:
        """The wrench ``(f, moment)`` that keeps the body moving, for twists (m, 3); a contact at rest adds nothing."""
        slips = self.velocities(twists) @ self.shape.T
        sizes = np.linalg.norm(slips, axis=2, keepdims=True)
        shares = np.divide(slips, sizes, out=np.zeros_like(slips), where=sizes > 0)
        forces = self.loads[:, None] * (shares @ self.shape)
        moments = (turned(self.points) * forces).sum(axis=(1, 2))
        return np.column_stack([forces.sum(axis=1), moments])

    def dissipation(self, twists: Floats) -> Floats:
        """``D`` for twists (m, 3), shape (m,)."""
        return np.asarray(np.linalg.norm(self.velocities(twists) @ self.shape.T, axis=2) @ self.loads)

    def twist_of(self, wrench: Floats) -> Floats:
        """The motion that a wrench (3,) causes, with ``wrench . xi = 1``."""
        return self.constrained(wrench[None], np.ones(1))[0]

    def constrained(self, normals: Floats, targets: Floats) -> tuple[Floats, Floats]:
        """The twist of least D with ``normals[k] . xi = targets[k]`` for one or two k, and the multiplier of each.

        The multiplier times the normal is the wrench on the body that keeps the constraint.
        """
        sizes = np.hypot(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2] / np.hypot(*self.points.T).max())
        held = np.zeros((2, 3))
        held[: len(normals)] = normals / sizes[:, None]
        aims, grip = np.zeros(2), np.zeros(2)
        aims[: len(normals)], grip[: len(normals)] = targets / sizes, GRIP * np.linalg.norm(self.shape, 2)
        rows, count = self._rows(), 2 * len(self.points)
        model = ContactRows(np.vstack([rows, held]), np.append(np.zeros(count), aims), np.append(np.ones(count), grip))
        found = EllipseMinimizer().minimize(model, np.append(self.loads, 1.0))
        return found.twists[0], found.forces[0, -1, : len(normals)] / sizes

    def _rows(self) -> Floats:
        """``M v(p_i)`` as rows that act on twists, shape (2n, 3)."""
        frames = np.broadcast_to(self.shape, (len(self.points), 2, 2))
        moments = (frames * turned(self.points)[:, None, :]).sum(axis=2, keepdims=True)
        return np.asarray(np.concatenate([frames, moments], axis=2).reshape(-1, 3))


class Tip(StrEnum):
    """What the tip of a pusher does on the body."""

    STICKS = "sticks"
    SLIDES = "slides"
    LEAVES = "leaves"


class Push(NamedTuple):
    """What a pusher does: the twist (3,) of the body, zero where the pusher leaves, and its force (2,) on the body."""

    tip: Tip
    twist: Floats
    force: Floats


def push(contacts: Contacts, point: Floats, normal: Floats, velocity: Floats, friction: float) -> Push:
    """The motion of a body that a pusher's tip moves at one point.

    Args:
        contacts: of the body with the ground.
        point: where the tip touches, from the centre of mass, shape (2,).
        normal: unit vector into the body there, shape (2,).
        velocity: of the tip, shape (2,).
        friction: coefficient of the tip on the body, at least 0.
    """
    approach = float(normal @ velocity)
    if approach <= 0:
        return Push(Tip.LEAVES, np.zeros(3), np.zeros(2))
    tangent, pushed = turned(normal), _row(normal, point)
    rows, speeds = np.stack([pushed, _row(tangent, point)]), np.array([approach, tangent @ velocity])
    twist, (along, across) = contacts.constrained(rows, speeds)
    if abs(across) <= friction * along * (1 + CLEARANCE):
        return Push(Tip.STICKS, twist, along * normal + across * tangent)
    edge = normal + np.sign(across) * friction * tangent
    slid, (size,) = contacts.constrained(_row(edge, point)[None], np.ones(1))
    return Push(Tip.SLIDES, approach / float(pushed @ slid) * slid, size * edge)


def _row(direction: Floats, point: Floats) -> Floats:
    """``(e, e . J p)``: the wrench of a unit force along e at p, and the row of the velocity of p along e."""
    return np.array([*direction, direction @ turned(point)])


# ---- random pushes -------------------------------------------------------------------------------


def random_push(rng: np.random.Generator) -> tuple[Contacts, tuple[Floats, Floats, Floats, float]]:
    """A body on three to five supports, and a tip that comes nearer: the other arguments of :func:`push`."""
    points = rng.normal(size=(int(rng.integers(3, 6)), 2))
    loads = rng.dirichlet(np.ones(len(points)))
    angle = rng.uniform(0, 2 * np.pi)
    aside = angle + rng.uniform(-1.2, 1.2)
    normal, velocity = (np.array([np.cos(a), np.sin(a)]) for a in (angle, aside))
    contacts = Contacts.isotropic(points - loads @ points, loads)
    return contacts, (rng.normal(size=2), normal, velocity, float(rng.uniform(0, 1)))


def masons_vote(point: Floats, normal: Floats, velocity: Floats, friction: float) -> float:
    """The sense of rotation by Mason's voting theorem (1986), which knows nothing of the supports.

    Both edges of the tip's friction cone and the direction of the push vote, each by its moment about the centre of
    mass.
    """
    voters = (normal + friction * turned(normal), normal - friction * turned(normal), velocity)
    return float(np.sign(sum(np.sign(point[0] * voter[1] - point[1] * voter[0]) for voter in voters)))
