"""The closed loop of a law that imposes one of some twists: a switched field whose modes are known.

The law of the rules ``box`` and ``ellipse`` imposes ``-k (g . xi_l) xi_l`` with the ``xi_l`` of the largest
``|g . xi_l|``, where ``g = (c, theta)`` with l for the unit of length.  Its modes switch on planes through the checked
point: ``g . (xi_l - xi_m) = 0`` and ``g . (xi_l + xi_m) = 0``, and where the law has twists of its own for each cone of
directions of c, on the lines between the cones.  D is homogeneous in twist and speeds together: a mode's motion is its
motion at unit gain times ``-k (g . xi_l)``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import Surface, Velocity, affine_surface
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats

STATES = ("x", "y", "theta")
# Entries of unit normals that differ by less are the same plane: far above their rounding, and a plane that is taken
# for another one would have to be this close to it.
SAME_PLANE = 1e-12

Motion: TypeAlias = Callable[[Floats], Floats]  # the twist about c*, at unit gain, by the displacement c of the body


@dataclass(frozen=True, eq=False)
class ImposedMotions:
    """The twists of one cone of directions of c, in floats.

    Attributes:
        rays: first and last direction of the cone, counterclockwise; None all around.
        twists: xi_l, shape (m, 3).
        motions: the motion that the speeds of each impose.
        speeds: the speeds that impose each, wheel by wheel, shape (m, n).
    """

    rays: tuple[Floats, Floats] | None
    twists: Floats
    motions: tuple[Motion, ...]
    speeds: Floats


def driven_field(cones: Sequence[ImposedMotions], centre: Sequence[float], size: float, gain: float) -> SignField:
    """The closed loop under exact kinematics, in lengths l.

    Args:
        cones: the law; they go around.
        centre: the checked point.
        size: of the states, which sets the slack of the surfaces.
        gain: k.
    """
    home = np.array([*centre, 0.0])
    lines = _distinct([np.array([-ray[1], ray[0], 0.0]) for cone in cones for ray in cone.rays or ()])
    planes = _distinct([normal for cone in cones for normal in _ties(cone.twists)])
    normals = [*lines, *planes]

    @cache
    def flow(signs: Signs) -> Velocity:
        cone = _cone(cones, lines, signs)
        chosen = _largest(cone, normals, signs)
        return lambda t, x: _rate(cone, chosen, x - home, gain)

    surfaces = [_surface(normal, home, k, len(lines)) for k, normal in enumerate(normals)]
    return SignField(STATES, tuple(surfaces), flow, size, kinematics="exact")


def _surface(normal: Floats, home: Floats, index: int, lines: int) -> Surface:
    name = f"direction {index + 1}" if index < lines else f"tie {index - lines + 1}"
    return affine_surface(name, normal.tolist(), float(normal @ home))


def _rate(cone: ImposedMotions, chosen: int, g: Floats, gain: float) -> Floats:
    """The pose rate ``(v + omega J c, omega)`` of the imposed motion."""
    vx, vy, omega = -gain * float(g @ cone.twists[chosen]) * cone.motions[chosen](g[:2])
    return np.array([vx - omega * g[1], vy + omega * g[0], omega])


def _ties(twists: Floats) -> list[Floats]:
    """Normals of the planes on which two of the products are equally large."""
    return [a + side * b for a, b in combinations(twists, 2) for side in (-1.0, 1.0)]


def _distinct(normals: Sequence[Floats]) -> list[Floats]:
    """Unit normals of different planes."""
    found: list[Floats] = []
    for normal in normals:
        unit = normal / np.linalg.norm(normal)
        if all(min(np.abs(unit - other).max(), np.abs(unit + other).max()) > SAME_PLANE for other in found):
            found.append(unit)
    return found


def _side(normals: Sequence[Floats], signs: Signs, normal: Floats) -> int:
    """On which side of its plane a pattern of signs lies."""
    products = [float(other @ normal) / float(np.linalg.norm(normal)) for other in normals]
    index = int(np.argmax(np.abs(products)))
    return signs[index] * sign(products[index])


def _cone(cones: Sequence[ImposedMotions], lines: Sequence[Floats], signs: Signs) -> ImposedMotions:
    """The cone of a pattern: left of its first ray and right of its last; the first of all where none is.

    Patterns without points are asked for too, by smoothing.
    """
    for cone in cones:
        if cone.rays is None:
            return cone
        start, end = (np.array([-ray[1], ray[0], 0.0]) for ray in cone.rays)
        if _side(lines, signs, start) > 0 > _side(lines, signs, end):
            return cone
    return cones[0]


def _largest(cone: ImposedMotions, normals: Sequence[Floats], signs: Signs) -> int:
    """The twist with the largest ``|g . xi_l|``: ``|a| > |b|`` where ``(a - b)(a + b) > 0``."""
    wins = [0] * len(cone.twists)
    for first, second in combinations(range(len(cone.twists)), 2):
        a, b = cone.twists[first], cone.twists[second]
        larger = _side(normals, signs, a - b) * _side(normals, signs, a + b) > 0
        wins[first if larger else second] += 1
    return int(np.argmax(wins))
