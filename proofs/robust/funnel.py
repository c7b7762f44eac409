"""The body that starts at the checked point of an array without cells, followed through a funnel until it is far away.

It may leave a disc though other bodies of the disc do not, or though a wheel lifts elsewhere in the disc.

A funnel is a chain of quadrangles about a path, each with a gate in common with the next one; the first begins in the
point.  On both other sides let all velocities lead inward, and in all of a quadrangle through the gate to the next one,
``m . c' > 0`` for its normal m.  Then a body leaves each by that gate, after a time, and does not come back through it.
Floats propose the path.  Forces that balance a pull back (:mod:`nonsmooth.proofs.boxes.balanced_forces`) bound the
velocities: on sides, which are segments, and in quadrangles, which are divided where they are not shown whole.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from nonsmooth.proofs.boxes.balanced_forces import STRENGTHS, BalancedForces
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.robust.ends import field_beside
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats

QUADRANGLES = 16  # on the length of the accuracy
DIVISIONS = 4  # times that quadrangles are divided that are not shown whole
MORE = 2.0**-30  # of a part
FAR = 1.125  # accuracies, as far as a funnel goes
SLOPES = (0.125, 0.5, 0.03)  # of its sides, tried in turn
LONGEST = 8  # accuracies, the longest path of one
DIFFERENCE = 2.0**-16  # of the accuracy, over which the field is differentiated
DOUBLINGS = 40  # of a step in time


def leaves_by_funnel(scene: Scene, accuracy: Fraction) -> bool:
    """Whether the body that starts at the point leaves the disc of that radius, inside a funnel.

    Args:
        scene: centred, without an outline, under a rule without cells, with known loads.
        accuracy: the radius.
    """
    forces = BalancedForces.of(scene)
    path = None if forces is None else _path_outward(forces, float(accuracy))
    if forces is None or path is None:
        return False
    ahead = np.diff(path, axis=0, append=2 * path[-1:] - path[-2:-1])
    normals = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.hypot(*ahead.T)[:, None]
    widths = np.linspace(0.0, FAR * float(accuracy), len(path))[:, None] * normals
    for slope in SLOPES:
        left, right = path + slope * widths, path - slope * widths
        if _is_beyond(path[-1], (left[-1], right[-1]), accuracy) and _is_passed(forces, left, right):
            return True
    return False


def _path_outward(forces: BalancedForces, radius: float) -> Floats | None:
    """Places of a path from the origin to beyond a radius, in floats; None where it stays within.

    By implicit steps in time that are as long as steps of an even length ask for: bodies come fast to a line along
    which they creep.
    """
    length, places = radius / QUADRANGLES, [np.zeros(2)]
    for _ in range(LONGEST * QUADRANGLES):
        here, slope = field_beside(forces.velocities, places[-1], DIFFERENCE * radius)
        speed = float(np.hypot(*here))
        if not 0 < speed < math.inf or not np.isfinite(slope).all():
            return None
        time = length / speed
        move: Any = here
        for _ in range(DOUBLINGS):
            move = np.linalg.solve(np.eye(2) - time * slope, time * here)
            if np.hypot(*move) > length / 2:
                break
            time *= 2
        else:
            return None  # it comes to rest
        places.append(places[-1] + move * min(1.0, length / float(np.hypot(*move))))
        if np.hypot(*places[-1]) > FAR * radius:
            return np.array(places)
    return None


def _is_beyond(towards: Floats, gate: Iterable[Floats], radius: Fraction) -> bool:
    """Whether a gate is farther from the origin than a radius, exactly."""
    a, b = map(Fraction, towards.tolist())
    heights = (a * Fraction(x) + b * Fraction(y) for x, y in map(np.ndarray.tolist, gate))
    return all(height > 0 and height**2 > radius**2 * (a**2 + b**2) for height in heights)


def _is_passed(forces: BalancedForces, left: Floats, right: Floats) -> bool:
    """Whether bodies from the first points of two lines pass all quadrangles between these."""
    to_right, to_left = (np.stack([line[:-1], line[1:], line[1:], line[:-1]], axis=1) for line in (right, left))
    between = np.stack([right[:-1], right[1:], left[1:], left[:-1]], axis=1)
    return (
        _are_convex(between)
        and _lead_left(forces, to_right, right[:-1], right[1:], (2, 1))
        and _lead_left(forces, to_left, left[1:], left[:-1], (2, 1))
        and _lead_left(forces, between, left[1:], right[1:], (2, 2))
    )


def _are_convex(corners: Floats) -> bool:
    """Whether quadrangles, the first of which is a triangle, are convex and counterclockwise, beyond rounding."""
    along = np.roll(corners, -1, axis=1) - corners
    after = np.roll(along, -1, axis=1)
    turns = along[..., 0] * after[..., 1] - along[..., 1] * after[..., 0]
    clear = turns > 2.0**-30 * np.linalg.norm(along, axis=2) * np.linalg.norm(after, axis=2)
    return bool(clear[:, :2].all() and clear[1:].all())


def _lead_left(forces: BalancedForces, corners: Floats, starts: Floats, ends: Floats, parts: tuple[int, int]) -> bool:
    """Whether on each quadrangle all velocities lead to the left of a vector, that from a start to an end.

    Args:
        forces: of the array.
        corners: of the quadrangles (pieces, 4, 2), which may be segments.
        starts: of the vectors (pieces, 2).
        ends: of the vectors (pieces, 2).
        parts: of a quadrangle that is not shown whole, along and across.
    """
    for _ in range(DIVISIONS):
        unit = Intervals.of(1 / np.hypot(*(ends - starts).T)[:, None] * np.ones(4))  # any positive factor does
        along_x, along_y = (unit * (Intervals.of(ends[:, k, None]) - Intervals.of(starts[:, k, None])) for k in (0, 1))
        x, y = (Intervals.of(corners[:, :, k]) for k in (0, 1))
        moment = (-along_x * x - along_y * y) * Intervals.of(np.array(1 / forces.length)).widened
        left = ~(forces.largest_powers(corners, (along_y, -along_x, moment), STRENGTHS) < 0)
        if not left.any():
            return True
        corners = _divided(corners[left], *parts)
        starts, ends = (np.repeat(own[left], parts[0] * parts[1], axis=0) for own in (starts, ends))
    return False


def _divided(corners: Floats, along: int, across: int) -> Floats:
    """Quadrangles that cover others together: parts along, from corner 0 to 1 and from 3 to 2, and across.

    Their corners are rounded: each is a little larger than its part.
    """
    a, b, c, d = (corners[:, k, None] for k in range(4))
    ends = [(np.arange(parts) - MORE, np.arange(1, parts + 1) + MORE) for parts in (along, across)]
    places = []
    for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
        t, s = (grid.reshape(-1, 1) for grid in np.meshgrid(ends[0][i] / along, ends[1][j] / across))
        back, front = a + s * (d - a), b + s * (c - b)
        places.append(back + t * (front - back))
    return np.stack(places, axis=2).reshape(-1, 4, 2)
